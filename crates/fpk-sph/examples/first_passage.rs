//! First passage of general limit states from one deterministic run: drift, ductility and the hysteretic force of a
//! building that yields in an earthquake.
//!
//! The building is that of Bouc and Wen, `x = (q, q', z)`. A limit state `g(x) > 0` is a demand with thresholds:
//!
//! | limit state | demand | thresholds |
//! |---|---|---|
//! | drift | `abs q` | displacements |
//! | ductility | `abs q / q_y`, with `q_y = z_limit / A` the displacement at which the loop is level | multiples |
//! | hysteretic force | `abs z / z_limit` | parts of the limit |
//!
//! Each error is the difference to a run with wider spacing: an estimate, no bound.

use fpk_sph::observables::FirstPassage;
use fpk_sph::{Config, DEFAULT_MOST_STEPS, Error, InitialLattice, Method, Simulation};
use sde_integrators::GaussianMixture;
use vibrating_systems::{BoucWen, BoucWenParameters};

/// `P` that each of the three demands passes its thresholds within 3 s.
fn passages(spacing: f64) -> Result<[Vec<f64>; 3], Error> {
    let building = BoucWen::new(BoucWenParameters::CANOR_DENOEL_2013)?;
    let z_limit = building.z_limit();
    let yielding = z_limit / building.parameters().initial_slope;
    let at_rest = GaussianMixture::independent([0.0; 3], [0.05; 3])?;
    let config = Config {
        method: Method::FlowMapFit,
        lattice: InitialLattice::Ball { reach: 4.5, spacing },
        reference_period: building.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(building, &at_rest, &config)?;

    // Any number of watches over one run.
    let mut drift = FirstPassage::new(&simulation, |x| x[0].abs(), &[0.5, 1.0])?;
    let mut ductility = FirstPassage::new(&simulation, |x| x[0].abs() / yielding, &[0.75])?;
    let mut force = FirstPassage::new(&simulation, |x| x[2].abs() / z_limit, &[0.6])?;
    while simulation.time() < 3.0 {
        let _report = simulation.step()?;
        drift.record(&simulation)?;
        ductility.record(&simulation)?;
        force.record(&simulation)?;
    }
    Ok([drift.probabilities(), ductility.probabilities(), force.probabilities()]
        .map(<[f64]>::to_vec))
}

#[allow(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Error> {
    let (fine, coarse) = (passages(0.7)?, passages(0.9)?);
    for ((name, fine), coarse) in
        ["drift > 0.5, 1", "ductility > 0.75", "force > 0.6"].iter().zip(&fine).zip(&coarse)
    {
        for (p, rough) in fine.iter().zip(coarse) {
            println!("{name}: P = {p:.4} +- {:.4}", (p - rough).abs());
        }
    }
    // Monte Carlo with 6e7 paths by t = 3: 0.029431 for the drift of 1. The error stated covers it.
    let (p, rough) = (fine[0][1], coarse[0][1]);
    assert!((p - 0.029431).abs() < (p - rough).abs(), "drift: {p} after {rough}");
    // The ductility is the drift in units of the yielding displacement, which is 1 here.
    assert!(fine[0][1] < fine[1][0] && fine[1][0] < fine[0][0]);
    assert!(fine[2][0] > 0.0 && fine[2][0] < 1.0);
    Ok(())
}

#[test]
fn the_example_runs() {
    main().unwrap();
}
