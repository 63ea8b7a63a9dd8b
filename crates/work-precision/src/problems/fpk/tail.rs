//! The rivals for one probability: importance sampling at a design point, and subset simulation.

use sde_integrators::{
    DrivenPath, Error, Estimate, GaussianMixture, Integrator, Noise, SubsetConfig, Uncertainty,
    design_point, importance_sampling, subset_simulation,
};

use super::cholesky::cholesky;

/// `P(|q(t)| > T)` of the first state, from paths as functions of independent standard normals: first those of the
/// initial law, then those of the steps.
#[derive(Debug)]
pub struct TailPaths<'a, S, I, const D: usize> {
    system: &'a S,
    integrator: &'a I,
    mean: [f64; D],
    factor: [[f64; D]; D],
    time: f64,
    n_steps: usize,
}

/// Why there is no probability.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TailError {
    /// A mixture is no function of as many normals as there are states.
    #[error("the initial law has {value} components; it must be one normal law")]
    Mixture {
        /// How many.
        value: usize,
    },
    /// The covariance of the initial law has no factor.
    #[error("the pivot of the initial covariance at state {state} is {value}; it must be positive")]
    NotACovariance {
        /// At which state.
        state: usize,
        /// The pivot.
        value: f64,
    },
    /// A path or a method failed.
    #[error(transparent)]
    Sampling(#[from] Error),
}

impl<'a, S: Sync, I, const D: usize> TailPaths<'a, S, I, D> {
    /// Paths from a normal law to a time.
    ///
    /// # Errors
    /// [`TailError::Mixture`], [`TailError::NotACovariance`].
    pub fn new(
        system: &'a S,
        integrator: &'a I,
        law: &GaussianMixture<D>,
        (time, n_steps): (f64, usize),
    ) -> Result<Self, TailError> {
        let value = law.components().len();
        if value != 1 {
            return Err(TailError::Mixture { value });
        }
        let factor = cholesky(&law.covariance())
            .map_err(|(state, value)| TailError::NotACovariance { state, value })?;
        Ok(Self { system, integrator, mean: law.mean(), factor, time, n_steps })
    }

    fn path(&self, start: [f64; D]) -> DrivenPath<'a, S, I, D> {
        let Self { system, integrator, time, n_steps, .. } = *self;
        DrivenPath { system, integrator, start, dt: time / n_steps as f64, n_steps }
    }

    /// How many normals make a path.
    fn n_normals<const M: usize>(&self) -> usize
    where
        I: Integrator<S, D, M>,
    {
        D + self.path(self.mean).n_normals::<M>()
    }

    /// `q` at the end of the path that the normals make.
    fn displacement<const M: usize>(&self, normals: &[f64]) -> Result<f64, Error>
    where
        I: Integrator<S, D, M>,
    {
        let (first, rest) = normals.split_at(D);
        let start = std::array::from_fn(|i| {
            self.mean[i] + (0..=i).map(|k| self.factor[i][k] * first[k]).sum::<f64>()
        });
        Ok(self.path(start).run::<M>(rest, |_, _, _| ())?[0])
    }

    /// Importance sampling at the design point of `q > T`, doubled: for laws that are symmetric about zero.
    ///
    /// # Errors
    /// [`TailError::Sampling`], where there is no design point as well.
    pub fn importance<const M: usize>(
        &self,
        threshold: f64,
        n_samples: u64,
        seed: u64,
    ) -> Result<Estimate, TailError>
    where
        I: Integrator<S, D, M>,
    {
        let response = |normals: &[f64]| self.displacement::<M>(normals);
        let point = design_point(&response, self.n_normals::<M>(), threshold)?;
        let one = importance_sampling(&response, threshold, &point, &Noise::new(seed), n_samples)?;
        let uncertainty = match one.uncertainty {
            Uncertainty::StandardError(error) => Uncertainty::StandardError(2.0 * error),
            Uncertainty::Bound(bound) => Uncertainty::Bound(2.0 * bound),
            Uncertainty::Unknown => Uncertainty::Unknown,
        };
        Ok(Estimate { value: 2.0 * one.value, uncertainty })
    }

    /// Subset simulation of `|q| > T`.
    ///
    /// # Errors
    /// [`TailError::Sampling`].
    pub fn subset<const M: usize>(
        &self,
        threshold: f64,
        config: &SubsetConfig,
        seed: u64,
    ) -> Result<Estimate, TailError>
    where
        I: Integrator<S, D, M>,
    {
        let response = |normals: &[f64]| Ok(self.displacement::<M>(normals)?.abs());
        let n_normals = self.n_normals::<M>();
        Ok(subset_simulation(&response, n_normals, threshold, &Noise::new(seed), config)?)
    }
}

#[cfg(test)]
mod tests {
    use fpk_sph::systems::{LinearOscillator, LinearOscillatorParameters, Window};
    use sde_integrators::{GaussianComponent, StrangOscillator};

    use super::*;
    use crate::problems::fpk::linear_moments::linear_moments;

    #[test]
    fn a_correlated_start_and_the_noise_both_reach_the_tail_and_a_mixture_is_refused() {
        let system = LinearOscillator::new(LinearOscillatorParameters {
            natural_frequency: 2.0,
            damping_ratio: 0.05,
            noise_intensity: 0.1,
            window: Window::Stationary,
        })
        .unwrap();
        let covariance = [[0.04, 0.03], [0.03, 0.09]];
        let law = GaussianMixture::gaussian([0.0; 2], covariance).unwrap();
        let exact = linear_moments(&system, &law, &[2.0], 1e-2).unwrap()[0];
        let threshold = 4.0 * exact.covariance[0][0].sqrt();
        let expected = exact.exceedance(&[1.0, 0.0], threshold).value;
        let paths = TailPaths::new(&system, &StrangOscillator, &law, (2.0, 50)).unwrap();
        let config = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs: 8 };
        for (name, estimate) in [
            ("importance", paths.importance::<1>(threshold, 4_000, 1).unwrap()),
            ("subset", paths.subset::<1>(threshold, &config, 1).unwrap()),
        ] {
            let error = estimate.standard_error().unwrap();
            assert!(error < 0.2 * expected, "{name}: {error:e} of {expected:e}");
            // Strang with 50 steps: the variance errs by (omega dt)^2, 4e-4 here, times 16/2 in the tail.
            let off = (estimate.value - expected).abs();
            assert!(off < 4.0 * error + 4e-3 * expected, "{name}: {off:e}, s.e. {error:e}");
        }
        let half = GaussianComponent { weight: 0.5, mean: [0.0; 2], covariance };
        let mixture = GaussianMixture::mixture(&[half; 2]).unwrap();
        let refused = TailPaths::new(&system, &StrangOscillator, &mixture, (2.0, 50)).unwrap_err();
        assert!(matches!(refused, TailError::Mixture { value: 2 }));
    }
}
