//! A run to a tolerance: the error that it states against the error that it makes.

use fpk_sph::{Config, InitialLattice, Refinement, RefinementEnd, Simulation, refine};
use sde_integrators::GaussianMixture;

use crate::fixtures::{CubicSpring, behind_soil, config, damper, law};

#[test]
fn the_damper_to_a_tolerance_has_the_error_that_it_states() {
    let refinement = Refinement { tolerance: 2e-3, order: 2.0, most_particles: 20_000 };
    let refined = refine(InitialLattice::box_of(15), &refinement, |lattice| {
        let config = config(*lattice, damper().period());
        let mut simulation = Simulation::new(damper(), &law(), &config)?;
        simulation.advance_to(3.0)?;
        let values = vec![simulation.raw_moment([2, 0]), simulation.raw_moment([0, 2])];
        Ok((simulation.n_particles(), values))
    })
    .unwrap();
    assert!(matches!(refined.end, RefinementEnd::Met), "{refined:?}");
    assert!(refined.runs.len() >= 3, "the first runs are not within the tolerance: {refined:?}");
    // The reference of the density grid, 1e-4 and 3e-4 relative (tests/reference of the project).
    for (found, exact) in refined.values.iter().zip([0.0296960, 0.237442]) {
        let (error, stated) = ((found.value / exact - 1.0).abs(), found.error / exact);
        assert!(
            error < 2e-3 && error < 2.0 * stated + 3e-4,
            "{error:e} where {stated:e} is stated"
        );
    }
}

#[test]
fn slower_settling_shows_the_error_that_lattices_of_four_states_share() {
    let shaken = behind_soil(CubicSpring);
    let law: GaussianMixture<4> = shaken.initial_distribution(&[0.0; 2], &[0.05, 0.15]).unwrap();
    let lattice = InitialLattice::Ball { reach: 5.0, spacing: std::f64::consts::SQRT_2 };
    let config = config(lattice, shaken.filter().period());
    let moments = |config: &Config<4>| {
        let mut simulation = Simulation::new(shaken.clone(), &law, config).unwrap();
        [2.0, 3.0].map(|t| {
            simulation.advance_to(t).unwrap();
            simulation.raw_moment([2, 0, 0, 0])
        })
    };
    let (found, slower) = (moments(&config), moments(&config.with_slower_settling().unwrap()));
    // Paths, 0.1 % (tests/reference of the project). The lattice finer by the root of two has 0.012009 and 0.02215: it
    // agrees within 0.6 %, where both are 1.4 to 5.3 % off.
    for ((found, slower), exact) in found.into_iter().zip(slower).zip([0.0118246, 0.0210296]) {
        let (error, stated) = (found / exact - 1.0, 2.0 * (found - slower).abs() / exact);
        assert!((0.01..0.06).contains(&error), "{error}");
        // Seen: 2.3 and 1.8 times the error.
        assert!((1.0..3.0).contains(&(stated / error)), "{stated} where {error} is made");
    }
}
