//! Sensitivity of a probability to a parameter, by differences of a deterministic run.
//!
//! Two runs at parameters a little apart are the same particles, moved a little: their difference has no sampling noise,
//! and a central difference over 5 % gives the derivative. Monte Carlo would need common random numbers, and still sees
//! only the few paths that change sides. Each error is the difference to runs with half the particles: an estimate.

use fpk_sph::observables::FirstPassage;
use fpk_sph::{Config, DEFAULT_MOST_STEPS, Error, InitialLattice, Method, Simulation};
use sde_integrators::GaussianMixture;
use vibrating_systems::{LinearOscillator, LinearOscillatorParameters, Window};

/// `E[q^2]` and `P(|q| > 0.9)` at `t = 6`, and `P(max |q| > 0.9)` up to there.
fn answers(damping_ratio: f64, count: usize) -> Result<[f64; 3], Error> {
    let building = LinearOscillator::new(LinearOscillatorParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio,
        noise_intensity: 0.2,
        window: Window::CANOR_DENOEL_2013,
    })?;
    let at_rest = GaussianMixture::independent([0.0, 0.0], [0.05, 0.05])?;
    let config = Config {
        method: Method::FlowMapFit,
        lattice: InitialLattice::box_of(count),
        reference_period: building.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let demand = |x: &[f64; 2]| x[0].abs();
    let mut simulation = Simulation::new(building, &at_rest, &config)?;
    let mut passage = FirstPassage::new(&simulation, demand, &[0.9])?;
    passage.advance_to(&mut simulation, 6.0)?;
    let exceeded = simulation.cell_integral()?.exceedance(demand, 0.9)?.probability();
    // A derivative of what no particle carries means nothing: then it is no number.
    let exceeded = exceeded.resolved().unwrap_or(f64::NAN);
    Ok([simulation.raw_moment([2, 0]), exceeded, passage.probabilities()[0]])
}

/// Derivatives by the damping ratio, each over its value.
fn sensitivities(damping_ratio: f64, count: usize) -> Result<[f64; 3], Error> {
    let step = 0.05 * damping_ratio;
    let (above, below) =
        (answers(damping_ratio + step, count)?, answers(damping_ratio - step, count)?);
    Ok(std::array::from_fn(|k| (above[k] / below[k]).ln() / (2.0 * step)))
}

#[allow(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Error> {
    let damping_ratio = 0.05;
    let (fine, coarse) = (sensitivities(damping_ratio, 41)?, sensitivities(damping_ratio, 29)?);
    for ((name, value), rough) in
        ["E[q^2]", "P(|q| > 0.9)", "P(max |q| > 0.9)"].iter().zip(&fine).zip(&coarse)
    {
        println!("d ln {name} / d xi = {value:.3} +- {:.3}", (value - rough).abs());
    }
    // P(|q| > T) = erfc(T / sqrt(2 s)) with s = E[q^2]: the derivative of its logarithm by ln s is z phi(z) / P, with
    // z = T / sqrt(s).
    let [variance, exceeded, _] = answers(damping_ratio, 41)?;
    let z = 0.9 / variance.sqrt();
    let density = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    let expected = fine[0] * z * density / exceeded;
    assert!((fine[1] / expected - 1.0).abs() < 0.02, "{} against {expected}", fine[1]);
    assert!(fine.iter().all(|&value| value < 0.0), "damping helps");
    Ok(())
}

#[test]
fn the_example_runs() {
    main().unwrap();
}
