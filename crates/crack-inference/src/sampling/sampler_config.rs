//! How the posterior is sampled.

use sde_integrators::Noise;

use crate::error::{Error, at_least};

/// How the posterior is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SamplerConfig {
    /// Points of the cloud that goes from prior to posterior, at least 100.
    pub n_particles: usize,
    /// Steps of each point at each power of the likelihood, at least 1.
    pub n_moves: usize,
    /// Chains from points of that cloud, at least 4.
    pub n_chains: usize,
    /// Steps of each chain before its draws.
    pub n_warm_up: usize,
    /// Draws of each chain, at least 100.
    pub n_draws: usize,
    /// Noise of all draws, under the purposes `InitialDistribution`, `MarkovChain` and `Bootstrap` of [`Purpose`](sde_integrators::Purpose).
    pub noise: Noise,
}

impl SamplerConfig {
    /// 500 points with 10 steps, 4 chains of 5,000 draws after 500 steps: some 100,000 likelihoods.
    #[must_use]
    pub fn new(noise: Noise) -> Self {
        Self { n_particles: 500, n_moves: 10, n_chains: 4, n_warm_up: 500, n_draws: 5000, noise }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        at_least("points of a cloud", self.n_particles, 100)?;
        at_least("steps of a point", self.n_moves, 1)?;
        at_least("chains", self.n_chains, 4)?;
        at_least("draws of a chain", self.n_draws, 100)
    }
}
