//! A fragility curve: the probability that a building with a viscous damper passes a drift in an earthquake, over the
//! intensity of the earthquake.
//!
//! Each intensity is one deterministic run, which serves all drifts. The curve is smooth, with no scatter from one
//! intensity to the next. Each error is the difference to a run with half the particles: an estimate, no bound.

use fpk_sph::observables::FirstPassage;
use fpk_sph::{Config, DEFAULT_MOST_STEPS, Error, InitialLattice, Method, Simulation};
use sde_integrators::GaussianMixture;
use vibrating_systems::{
    LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters, Window,
};

/// Drifts.
const DRIFTS: [f64; 3] = [0.4, 0.6, 0.8];

/// `P(max |q| > d)` for the intensity `S_0` of the noise, with `count` particles along each axis.
fn passage(intensity: f64, count: usize) -> Result<Vec<f64>, Error> {
    let structure = LinearOscillatorParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.01,
        noise_intensity: intensity,
        window: Window::CANOR_DENOEL_2013,
    };
    let building = ViscousDamper::new(ViscousDamperParameters {
        structure,
        damper_coefficient: 0.25,
        damper_exponent: 0.35,
    })?;
    // Nearly at rest; how nearly does not matter once the ground moves.
    let at_rest = GaussianMixture::independent([0.0, 0.0], [0.05, 0.05])?;
    let config = Config {
        method: Method::FlowMapFit,
        lattice: InitialLattice::box_of(count),
        reference_period: building.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(building, &at_rest, &config)?;
    let mut passage = FirstPassage::new(&simulation, |x| x[0].abs(), &DRIFTS)?;
    passage.advance_to(&mut simulation, 7.0)?;
    Ok(passage.probabilities().to_vec())
}

#[allow(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Error> {
    println!("S_0     {}", DRIFTS.map(|drift| format!("P(max |q| > {drift})")).join("      "));
    let mut last = vec![0.0; DRIFTS.len()];
    for intensity in [0.05, 0.1, 0.2, 0.3, 0.4] {
        let (fine, coarse) = (passage(intensity, 31)?, passage(intensity, 22)?);
        let row: Vec<String> = fine
            .iter()
            .zip(&coarse)
            .map(|(p, rough)| format!("{p:.3e} +- {:.0e}", (p - rough).abs()))
            .collect();
        println!("{intensity:<7} {}", row.join("   "));
        assert!(fine.iter().zip(&last).all(|(p, before)| p > before), "fragility rises");
        assert!(fine.windows(2).all(|pair| pair[1] < pair[0]), "and falls with the drift");
        last = fine;
    }
    Ok(())
}

#[test]
fn the_example_runs() {
    main().unwrap();
}
