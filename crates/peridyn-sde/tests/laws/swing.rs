//! Steps that are stable at rest and too long for a body that is stretched.

use peridyn_sde::{
    BondList, Bonds, Dynamics, Error, Loading, Nodes, Program, Real, Scheme, Simulation, Strain,
};

use crate::fixtures::{PLATE, bonded, in_time, overdamped};

const SIDE: usize = 9;
const STRENGTH: f64 = 1e6;

fn plate() -> (Nodes<2>, Bonds, Vec<bool>) {
    let (nodes, bonds) = bonded(SIDE as f64, PLATE, 2);
    let inside = |x: &[f64; 2]| x.iter().all(|&c| c > 2.0 && c < SIDE as f64 - 2.0);
    let free = nodes.positions().iter().map(inside).collect();
    (nodes, bonds, free)
}

fn dynamics(free: &[bool], scheme: Option<Scheme>) -> Dynamics {
    match scheme {
        Some(scheme) => overdamped(free, scheme, 1e-16),
        None => Dynamics::Inertial { density: 1.0, friction: 0.1, temperature: 1e-16 },
    }
}

/// Follows a plate that is stretched in 200 steps and then held; the step is `share` of the largest that is stable at rest.
fn follow<T: Real, const L: usize>(
    scheme: Option<Scheme>,
    (stretch, share): (f64, f64),
    n_steps: u64,
) -> Result<f64, Error> {
    let (nodes, bonds, free) = plate();
    let held: Vec<usize> = (0..free.len()).filter(|&node| !free[node]).collect();
    let strengths = vec![STRENGTH; bonds.len()];
    let make = |dt: f64| {
        let until = 200.0 * dt;
        let ramp = Program::Ramp { rate: stretch / until, until };
        let one = [[1.0, 0.0], [0.0, 1.0]];
        let loading = Loading::new(free.len()).stretch(&nodes, &held, [true; 2], one, ramp)?;
        let body =
            BondList::<T, 2, L>::new(nodes.clone(), bonds.clone(), Strain::Finite, &strengths)?;
        let config = in_time(dynamics(&free, scheme), dt, 1);
        Simulation::new(body, loading, config, std::array::from_fn(|lane| lane as u64))
    };
    let small = make(1e-6)?.relative_step();
    let dt = match scheme {
        Some(scheme) => 1e-6 * share * scheme.stability_limit() / small,
        None => 1e-6 * share * 2.0 / small.sqrt(),
    };
    let mut run = make(dt)?;
    for _ in 0..n_steps {
        let _ = run.step()?;
    }
    let off = run.displacements(0).into_iter().zip(nodes.positions());
    Ok(off.flat_map(|(u, x)| [0, 1].map(|k| (u[k] - stretch * x[k]).abs())).fold(0.0, f64::max))
}

#[test]
fn step_that_a_stretched_body_makes_too_long_is_reported() {
    let schemes =
        [Some(Scheme::EulerMaruyama), Some(Scheme::LeimkuhlerMatthews), Some(Scheme::Heun), None];
    for scheme in schemes {
        // At a stretch of one, bonds are half as stiff across as along: the stiffest mode grows to 1.3 times.
        let quiet = follow::<f64, 1>(scheme, (1.0, 0.7), 3000).unwrap();
        assert!(quiet < 1e-3, "{scheme:?}: {quiet}");
        for share in [0.9, 0.99] {
            let error = follow::<f64, 1>(scheme, (1.0, share), 8000).unwrap_err();
            let Error::Swings { step, node, value, limit, .. } = error else {
                panic!("{scheme:?}: {error}")
            };
            assert!(step > 40 && value > 0.999 * limit, "{scheme:?}: {error}");
            let (x, y) = (node % SIDE, node / SIDE);
            assert!((2..7).contains(&x) && (2..7).contains(&y), "{scheme:?}: {error}");
        }
        let rest = follow::<f64, 1>(scheme, (0.0, 0.99), 2000).unwrap();
        assert!(rest < 1e-3, "{scheme:?}: {rest}");
    }
    let error = follow::<f32, 16>(None, (1.0, 0.95), 8000).unwrap_err();
    assert!(matches!(error, Error::Swings { .. }), "{error}");
}

/// Plates stretched up to three times their length, at steps up to the limit of a body at rest: none swings without an error.
#[test]
fn no_stretched_body_swings_in_silence() {
    let scheme = Some(Scheme::EulerMaruyama);
    let mut counts = [0; 2];
    for stretch in [0.0, 1.0, 2.0, 3.0] {
        for share in [0.5, 0.6, 0.7, 0.8, 0.9, 0.99] {
            match follow::<f64, 1>(scheme, (stretch, share), 8200) {
                Ok(off) => {
                    assert!(off < 0.01, "stretch {stretch}, share {share}: off by {off} spacings");
                    counts[0] += 1;
                }
                Err(Error::Swings { .. }) => counts[1] += 1,
                Err(error) => panic!("stretch {stretch}, share {share}: {error}"),
            }
        }
    }
    assert!(counts[0] > 8 && counts[1] > 4, "{counts:?}");
}
