//! A score estimator as a user would write it: the score of the Gaussian with the cloud's own moments.

use fpk_sph::score::Estimates;
use fpk_sph::{Cloud, Error, InitialLattice, ScoreEstimator, Simulation};
use neighbour_search::Criterion;
use sde_integrators::GaussianMixture;

use crate::fixtures::{config, oscillator};

/// In whitened coordinates the Gaussian closure is `grad log psi = -y`.
#[derive(Debug)]
struct GaussianClosure;

impl<const D: usize> ScoreEstimator<D> for GaussianClosure {
    fn support(&self) -> f64 {
        1.0
    }

    fn criterion(&self) -> Option<Criterion> {
        Some(Criterion::Gather)
    }

    fn estimate(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) -> Result<(), Error> {
        for (i, y) in cloud.positions.iter().enumerate() {
            out.score[i] = y.map(|component| -component);
            out.density[i] = (-0.5 * y.iter().map(|c| c * c).sum::<f64>()).exp();
            out.volume[i] = cloud.masses[i] / out.density[i];
        }
        Ok(())
    }
}

#[test]
fn statistical_linearisation_as_an_estimator_is_exact_for_the_linear_oscillator() {
    let law = GaussianMixture::independent([0.0, 0.0], [0.2, 0.3]).unwrap();
    let config = config(InitialLattice::box_of(15), std::f64::consts::TAU);
    let system = oscillator(1.0, 0.1, 0.1);
    let mut simulation =
        Simulation::with_estimator(system, &law, &config, Box::new(GaussianClosure)).unwrap();
    simulation.advance_to(60.0).unwrap();
    // Stationary: E[v^2] = S_0 / (2 xi w_0) = 0.5. The transient has decayed by exp(-2 xi w t) = 6e-6.
    // Runge-Kutta 4 at 40 steps a period damps by (w dt)^6 / 72 a step, 1.3e-4 over the memory 1 / (2 xi w).
    let second_moment = simulation.raw_moment([0, 2]) / simulation.total_mass();
    assert!((second_moment / 0.5 - 1.0).abs() < 2e-4, "{second_moment}");
}
