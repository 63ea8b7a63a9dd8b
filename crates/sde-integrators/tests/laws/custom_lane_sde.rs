//! Systems of any number of states: a path alone is that in lanes, and its variance is the exact one less its known bias.

use sde_integrators::{
    Accumulator, DrivenLanes, Error, GuidedEnsemble, GuidedPath, LaneSde, Noise, Purpose, WongZakai,
};

/// `n` oscillators `q'' + 2 xi w q' + w^2 q = s W` under the same noise: states `(q_1, v_1, q_2, ..)`.
struct Oscillators {
    n: usize,
}

const OMEGA: f64 = 2.0;
const XI: f64 = 0.1;
const INTENSITY: f64 = 0.5;

impl LaneSde for Oscillators {
    fn n_states(&self) -> usize {
        2 * self.n
    }

    #[inline]
    fn drift<const L: usize>(&self, _: f64, x: &[[f64; L]], drift: &mut [[f64; L]]) {
        for (x, drift) in x.chunks_exact(2).zip(drift.chunks_exact_mut(2)) {
            for lane in 0..L {
                drift[0][lane] = x[1][lane];
                drift[1][lane] = -2.0 * XI * OMEGA * x[1][lane] - OMEGA * OMEGA * x[0][lane];
            }
        }
    }

    fn noise(&self, _: f64, g: &mut [f64]) {
        for g in g.chunks_exact_mut(2) {
            g.copy_from_slice(&[0.0, INTENSITY]);
        }
    }
}

fn ends(
    system: &Oscillators,
    (dt, n_steps): (f64, usize),
    n_paths: u64,
) -> Result<Vec<Vec<f64>>, Error> {
    let n = system.n_states();
    let (paths, mean, factor) = (&WongZakai(system), &vec![0.0; n][..], &vec![0.0; n * n][..]);
    let (guides, passages, seed) = (&[][..], None, 3);
    let ensemble = GuidedEnsemble { paths, mean, factor, dt, n_steps, guides, passages, seed };
    let push = |all: &mut Vec<Vec<f64>>, path: &GuidedPath<'_>| all.push(path.end.to_vec());
    let join = |mut earlier: Vec<_>, later: Vec<_>| {
        earlier.extend(later);
        earlier
    };
    ensemble.run(0..n_paths, Vec::new, push, join)
}

#[test]
fn a_path_alone_is_bitwise_that_in_lanes() {
    let (system, dt, n_steps) = (Oscillators { n: 3 }, 0.1, 37);
    for (realisation, end) in ends(&system, (dt, n_steps), 40).unwrap().into_iter().enumerate() {
        let mut normals = vec![0.0; n_steps];
        Noise::new(3).stream(Purpose::Path, realisation as u64).fill_normal(&mut normals);
        let mut alone = Vec::new();
        let look = |_: &[[f64; 1]], x: &[[f64; 1]]| alone = x.to_vec();
        DrivenLanes { system: &system, dt }.run(&[0.0; 6], &normals, look).unwrap();
        for (a, [b]) in end.iter().zip(alone) {
            assert_eq!(a.to_bits(), b.to_bits());
        }
    }
}

#[test]
fn the_variance_is_exact_less_the_bias_of_a_noise_constant_over_a_step() {
    // Stationary at 2 xi omega t = 12: s^2/(4 xi omega^3), less (omega h)^2/12 of it.
    let (h, n_steps) = (0.25, 120);
    let mut square = Accumulator::default();
    for end in ends(&Oscillators { n: 1 }, (h, n_steps), 40_000).unwrap() {
        square.push(end[0] * end[0]);
    }
    let estimate = square.estimate().unwrap();
    let exact = INTENSITY * INTENSITY / (4.0 * XI * OMEGA.powi(3));
    let error = estimate.standard_error().unwrap() / exact;
    assert!(error < 0.008, "{estimate}");
    // The filter sinc^2(omega h/2) at resonance; damping of Runge-Kutta 4, (omega h)^5/144 over xi, adds 1.5e-3.
    let off = estimate.value / exact - 1.0 + (OMEGA * h).powi(2) / 12.0;
    assert!(off.abs() < 4.0 * error + 3e-3, "{off} {error}");
}

#[test]
fn invalid_starts_and_steps_are_refused() {
    let system = Oscillators { n: 2 };
    let refused = |dt, start: &[f64], normals: &[f64]| {
        DrivenLanes { system: &system, dt }.run(start, normals, |_, _| ()).unwrap_err().to_string()
    };
    assert_eq!(refused(0.1, &[0.0; 3], &[0.0]), "3 states of the start, must be 4");
    assert!(refused(0.0, &[0.0; 4], &[0.0]).contains("dt"));
    assert!(refused(0.1, &[0.0; 4], &[1.0, f64::INFINITY]).contains("step"));
}
