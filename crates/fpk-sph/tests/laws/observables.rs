//! Sums over the particles of a Gaussian, whose values are known.

use std::f64::consts::{E, PI};

use fpk_sph::{Error, InitialLattice, Simulation};
use sde_integrators::GaussianMixture;
use vibrating_systems::LinearOscillator;

use crate::fixtures::{config, oscillator};

const DEVIATIONS: [f64; 2] = [0.15, 0.10];
/// Standard deviations between particles, of which there are 41 along each axis.
const SPACING: f64 = 0.3;

fn at_start() -> (Simulation<LinearOscillator, 2, 1>, GaussianMixture<2>) {
    let law = GaussianMixture::independent([0.0, 0.0], DEVIATIONS).unwrap();
    let lattice = InitialLattice::Box { count: [41, 41], reach: 6.0 };
    let system = oscillator(PI, 0.01, 0.2);
    (Simulation::new(system, &law, &config(lattice, 2.0)).unwrap(), law)
}

#[test]
fn mass_moments_density_and_entropy_of_a_gaussian_are_its_own() {
    let (simulation, law) = at_start();
    // Sums over a lattice of a smooth density are right to exp(-2 (pi/0.3)^2), and at 6 deviations 2e-9 is left out; a fourth
    // moment loses 1e-6 of itself there.
    assert!((simulation.total_mass() - 1.0).abs() < 1e-8, "{}", simulation.total_mass());
    let fourth = 3.0 * DEVIATIONS[0].powi(4);
    assert!((simulation.raw_moment([4, 0]) / fourth - 1.0).abs() < 2e-6);
    let mixed = DEVIATIONS[0].powi(2) * DEVIATIONS[1].powi(2);
    assert!((simulation.raw_moment([2, 2]) / mixed - 1.0).abs() < 2e-6);
    let (cosine, exact) =
        (simulation.expectation(|x| x[0].cos()), (-0.5 * DEVIATIONS[0].powi(2)).exp());
    assert!((cosine / exact - 1.0).abs() < 1e-8);
    // The logarithm is a quadratic, which the fit holds exactly.
    let error = simulation.density_error(|x| law.density(x)).unwrap();
    let entropy = (2.0 * PI * E * DEVIATIONS[0] * DEVIATIONS[1]).ln();
    assert!(error < 1e-12, "{error:e}");
    // What is left out, 4e-9, would have added 18 nats of itself.
    assert!((simulation.entropy().unwrap() - entropy).abs() < 1e-7);
    let other = GaussianMixture::independent([0.0, 0.0], [0.15, 0.11]).unwrap();
    assert!(simulation.density_error(|x| other.density(x)).unwrap() > 0.05);
}

#[test]
fn exceedance_by_counted_masses_is_within_a_column_and_interpolated_within_its_square() {
    let (simulation, _) = at_start();
    let demand = |x: &[f64; 2]| x[0].abs();
    // Of 2 (1 - Phi(t)), t in standard deviations.
    for (t, exact) in [(1.0, 0.317_310_507_863), (2.0, 0.045_500_263_896), (3.0, 0.002_699_796_063)]
    {
        let threshold = t * DEVIATIONS[0];
        let counted = simulation.exceedance_indicator(demand, threshold).unwrap();
        let between = simulation.exceedance_log_interpolated(demand, threshold).unwrap();
        let column = 2.0 * SPACING * (-0.5 * t * t).exp() / (2.0 * PI).sqrt();
        assert!((counted - exact).abs() <= column, "{t}: {counted}");
        // The trapezoidal rule adds t h^2/12 of the density at t, which is at most t + 1/t of the tail; between particles the
        // logarithm of the tail bends by less than h^2/8.
        let bound = SPACING * SPACING * (t * t + 1.0) / 12.0;
        assert!((between / exact - 1.0).abs() < bound, "{t}: {between}");
    }
    // No particle is beyond six deviations, and all are beyond zero.
    for estimate in [
        simulation.exceedance_indicator(demand, 1.0),
        simulation.exceedance_log_interpolated(demand, 1.0),
    ] {
        assert!(estimate.unwrap().abs() < f64::MIN_POSITIVE);
    }
    let all = simulation.exceedance_log_interpolated(demand, -1.0).unwrap();
    assert!((all - simulation.total_mass()).abs() < 1e-12);
    let refused = simulation.exceedance_indicator(demand, f64::NAN).unwrap_err();
    assert!(matches!(refused, Error::NotFinite { name: "threshold", .. }), "{refused}");
    let refused = simulation.exceedance_log_interpolated(|_| f64::NAN, 0.1).unwrap_err();
    assert!(matches!(refused, Error::NotFinite { name: "demand", .. }), "{refused}");
}
