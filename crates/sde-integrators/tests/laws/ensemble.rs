//! Ensembles: bitwise identical results for any number of threads, estimates that agree with the truth, refusals.

use sde_integrators::{
    Additive, Ensemble, EnsembleConfig, Error, EulerMaruyama, GaussianMixture, Noise, Observable,
    Sde, SemiImplicitEuler, StrangOscillator, Uncertainty, simulate,
};

use crate::methods::OSCILLATOR;

fn law() -> GaussianMixture<2> {
    GaussianMixture::independent([0.5, 0.0], [0.2, 0.3]).expect("a law")
}

fn config(n_paths: u64, dt: f64, times: &[f64]) -> EnsembleConfig {
    EnsembleConfig { seed: 42, n_paths, dt, times: times.to_vec() }
}

const OBSERVABLES: [Observable<'_, 2>; 3] = [
    Observable::Mean(&|_, x| x[0]),
    Observable::Mean(&|_, x| x[0] * x[0]),
    Observable::Probability(&|_, x| x[0].abs() > 0.8),
];

fn run(config: &EnsembleConfig) -> Result<Ensemble, Error> {
    simulate(&OSCILLATOR, &SemiImplicitEuler, &law(), config, &OBSERVABLES)
}

fn bits(ensemble: &Ensemble) -> Vec<u64> {
    let error = |uncertainty| match uncertainty {
        Uncertainty::StandardError(value) | Uncertainty::Bound(value) => value,
        Uncertainty::Unknown => 0.0,
    };
    let estimates = ensemble.estimates.iter().flatten();
    estimates.flat_map(|e| [e.value.to_bits(), error(e.uncertainty).to_bits()]).collect()
}

/// Recorded once, and the same with and without the feature `rayon`.
#[test]
fn an_ensemble_keeps_its_bits() {
    let ensemble = run(&config(10_000, 0.1, &[0.5, 1.0])).unwrap();
    let seen = [bits(&ensemble)[2], bits(&ensemble)[3], bits(&ensemble)[10]];
    assert_eq!(seen, GOLDEN, "{seen:#x?}");
}

const GOLDEN: [u64; 3] = [0x3fbc_c2a8_e1ff_bb53, 0x3f56_3277_ee2d_9d5a, 0x3fa8_9374_bc6a_7efa];

#[cfg(feature = "rayon")]
#[test]
fn an_ensemble_has_the_same_bits_for_any_number_of_threads() {
    let config = config(3 * 4096 + 5, 0.1, &[0.0, 0.5, 1.7]);
    let on = |n_threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        bits(&pool.install(|| run(&config)).unwrap())
    };
    let alone = on(1);
    assert_eq!(alone.len(), 18);
    assert_eq!(alone, on(2));
    assert_eq!(alone, on(8));
}

/// A block is no more than its paths: an ensemble by hand, path after path.
#[test]
fn an_ensemble_is_its_paths() {
    use sde_integrators::{Accumulator, Integrator};
    let config = config(100, 0.25, &[1.0]);
    let ensemble = run(&config).unwrap();
    let mut by_hand = Accumulator::default();
    for realisation in 0..100 {
        let noise = Noise::new(42);
        let mut x = law().sample(&noise, realisation);
        let mut path = noise.path::<1>(realisation);
        for step in 0..4 {
            let dw = path.next_increment(0.25);
            SemiImplicitEuler
                .step(&OSCILLATOR, 0.25 * f64::from(step), 0.25, &dw, &mut x, &mut ())
                .unwrap();
        }
        by_hand.push(x[0]);
    }
    assert_eq!(ensemble.estimates[0][0], by_hand.cautious_estimate().unwrap());
    assert_eq!((ensemble.path_steps, ensemble.n_paths), (400, 100));
}

/// Strang from the stationary law stays in it: |z| < 4 for E q, E q^2 and P(|q| > 0.8), at each time.
#[test]
fn estimates_lie_within_their_standard_errors() {
    let v_squared: f64 = 0.81 / 0.6;
    let q_squared = v_squared / 4.0;
    let law =
        GaussianMixture::independent([0.0, 0.0], [q_squared.sqrt(), v_squared.sqrt()]).unwrap();
    // erfc(0.8/sqrt(2 0.3375)) = 0.168493
    let exact = [0.0, q_squared, 0.168_493_467_8];
    let config = config(50_000, 0.7, &[0.0, 1.0, 10.0]);
    let ensemble = simulate(&OSCILLATOR, &StrangOscillator, &law, &config, &OBSERVABLES).unwrap();
    for (t, estimates) in ensemble.times.iter().zip(&ensemble.estimates) {
        for (estimate, exact) in estimates.iter().zip(exact) {
            let z = (estimate.value - exact) / estimate.standard_error().unwrap();
            assert!(z.abs() < 4.0, "t = {t}: {estimate}, exact {exact}");
        }
    }
}

/// A clock: `dx = 1 dt`.
struct Clock;

impl Sde<1, 1> for Clock {
    type Noise = Additive;

    fn drift(&self, _t: f64, _x: &[f64; 1]) -> [f64; 1] {
        [1.0]
    }

    fn noise(&self, _t: f64, _x: &[f64; 1]) -> [[f64; 1]; 1] {
        [[0.0]]
    }
}

/// 0.3/0.1 is just below 3 and (0.9 - 0.3)/0.1 just above 6 in binary; 0.25/0.1 asks for three. Roundoff of the clock: 1e4
/// sums near 1e3, 6e-10.
#[test]
fn steps_are_equal_and_end_on_the_output_times() {
    let times = [0.0, 0.3, 0.9, 1.15, 1e3];
    let config = config(2, 0.1, &times);
    let late = |t: f64, x: &[f64; 1]| (x[0] - t).abs() > 1e-9;
    let observables = [Observable::Mean(&|t, _x| t), Observable::Probability(&late)];
    let ensemble = simulate(&Clock, &EulerMaruyama, &[0.0], &config, &observables).unwrap();
    for (t, estimates) in times.iter().zip(&ensemble.estimates) {
        assert_eq!(estimates[0].value.to_bits(), t.to_bits());
        assert_eq!(estimates[1].value.to_bits(), 0.0_f64.to_bits());
    }
    // 998.85/0.1 = 9988.5
    assert_eq!(ensemble.path_steps, 2 * (3 + 6 + 3 + 9989));
}

#[test]
fn an_event_that_never_happens_has_a_bound_and_no_standard_error() {
    let never = |_t: f64, x: &[f64; 2]| x[0] > 1e6;
    let observables = [Observable::Probability(&never)];
    let ensemble =
        simulate(&OSCILLATOR, &StrangOscillator, &law(), &config(600, 0.1, &[1.0]), &observables)
            .unwrap();
    assert_eq!(ensemble.estimates[0][0].uncertainty, Uncertainty::Bound(3.0 / 600.0));
}

/// `dX = -X^3 dt + s dB`, of which Euler's method with `h = 0.1` loses within 20 units of time some paths at `s = 4` and every one
/// at `s = 8`.
pub(crate) struct Cubic {
    pub(crate) intensity: f64,
}

impl Sde<1, 1> for Cubic {
    type Noise = Additive;

    fn drift(&self, _: f64, &[x]: &[f64; 1]) -> [f64; 1] {
        [-x * x * x]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.intensity]]
    }
}

#[test]
fn a_path_that_explodes_is_an_error_that_names_the_lowest_one() {
    let config = config(50_000, 0.1, &[20.0]);
    let observe = || {
        let observables = [Observable::Mean(&|_t, x: &[f64; 1]| x[0])];
        simulate(&Cubic { intensity: 8.0 }, &EulerMaruyama, &[0.0], &config, &observables)
            .unwrap_err()
    };
    let error = observe();
    let Error::NonFiniteState { realisation: 0, steps, t, component: 0, value } = error else {
        panic!("{error}");
    };
    assert!(steps > 1 && !value.is_finite() && (t - 0.1 * steps as f64).abs() < 1e-9);
    for _ in 0..10 {
        // As text, because the value may be NaN.
        assert_eq!(observe().to_string(), error.to_string());
    }
}

#[test]
fn a_bad_observable_is_an_error_that_names_it() {
    let observables = [Observable::Mean(&|_t, x| x[0]), Observable::Mean(&|t, _x| 1.0 / (t - 1.0))];
    let error = simulate(
        &OSCILLATOR,
        &StrangOscillator,
        &law(),
        &config(10, 0.1, &[0.5, 1.0]),
        &observables,
    )
    .unwrap_err();
    assert_eq!(error.to_string(), "observable 1 of path 0 at time 1 is inf, must be finite");
}

#[test]
fn a_bad_configuration_is_refused_with_the_value_and_its_limit() {
    let message =
        |n_paths, dt, times: &[f64]| run(&config(n_paths, dt, times)).unwrap_err().to_string();
    assert_eq!(message(1, 0.1, &[1.0]), "1 paths, at least 2 needed");
    assert_eq!(message(0, 0.1, &[1.0]), "0 paths, at least 2 needed");
    assert_eq!(message(10, 0.0, &[1.0]), "dt is 0, must be finite and positive");
    assert_eq!(message(10, -0.1, &[1.0]), "dt is -0.1, must be finite and positive");
    assert_eq!(message(10, f64::NAN, &[1.0]), "dt is NaN, must be finite and positive");
    assert_eq!(message(10, 0.1, &[]), "0 output times, at least 1 needed");
    assert_eq!(message(10, 0.1, &[-1.0]), "output time 0 is -1, must be finite and at least 0");
    assert_eq!(message(10, 0.1, &[1.0, 1.0]), "output time 1 is 1, must be finite and above 1");
    assert_eq!(message(10, 0.1, &[2.0, 1.0]), "output time 1 is 1, must be finite and above 2");
    assert_eq!(
        message(10, 0.1, &[0.0, f64::NAN]),
        "output time 1 is NaN, must be finite and above 0"
    );
    assert_eq!(
        message(10, 1e-17, &[1.0]),
        "99999999900000000 steps per path, at most 9007199254740992 possible"
    );
    let nothing = simulate(&OSCILLATOR, &StrangOscillator, &law(), &config(10, 0.1, &[1.0]), &[]);
    assert_eq!(nothing.unwrap_err().to_string(), "0 observables, at least 1 needed");
}
