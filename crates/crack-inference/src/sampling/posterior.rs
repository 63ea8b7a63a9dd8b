//! The posterior: chains of draws and what they say of each parameter.

use rayon::prelude::*;
use sde_integrators::{Estimate, Purpose, Uncertainty};

use crate::error::{Error, at_least};
use crate::parameter_space::ParameterSpace;
use crate::sampling::diagnostics::{bulk_effective_sample_size, effective_sample_size, r_hat};
use crate::sampling::sampler_config::SamplerConfig;
use crate::sampling::target::{LogLikelihood, Proposal, Target};
use crate::sampling::tempered::{covariance, tempered};

/// The contraction above which data say more of a parameter than the prior did. For a normal prior and likelihood precisions add,
/// and the contraction is the share of the data in their sum: at one half both weigh the same.
pub const LEAST_CONTRACTION: f64 = 0.5;

/// Distance of the mean of a posterior to a bound of its prior, in standard deviations on the scale of the parameter, at which the bound
/// does not cut it. That of an exponential distribution, as against a bound far from the data, is one, of half a normal 1.3; of a normal
/// one, 5 % lie beyond 1.6 and 2.3 % beyond two.
pub const FROM_BOUND: f64 = 2.0;

/// Probabilities of the reported quantiles.
pub const POSTERIOR_QUANTILES: [f64; 3] = [0.05, 0.5, 0.95];

/// Whether the data identify a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// More than the prior did: the contraction is above [`LEAST_CONTRACTION`].
    Identified,
    /// More, but a bound of the prior cuts the posterior: it lies within [`FROM_BOUND`] standard deviations of the mean. Where the
    /// posterior would lie is unknown, and how wide it would be.
    AtBound,
    /// Less: the result is more the prior than the data.
    NotIdentified,
}

/// Posterior of a parameter. Errors are those of the chains; that of the ensembles behind the likelihood is
/// [`Emulator::error_of_means`](crate::Emulator::error_of_means).
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterPosterior {
    /// Its name.
    pub name: String,
    /// The mean of its value.
    pub mean: Estimate,
    /// The standard deviation of its value.
    pub standard_deviation: Estimate,
    /// The quantiles of [`POSTERIOR_QUANTILES`] of its value. The error of one is half the distance of those one standard error of
    /// their probability above and below (Vehtari et al. 2021, section 4.4).
    pub quantiles: [Estimate; 3],
    /// The larger of both `R`-hats, of [`r_hat`].
    pub r_hat: f64,
    /// [`bulk_effective_sample_size`].
    pub effective_sample_size: f64,
    /// One less the variance of the posterior over that of the prior, on the scale of the parameter.
    pub contraction: Estimate,
    /// Whether that is enough.
    pub verdict: Verdict,
}

impl ParameterPosterior {
    /// From the quantile of 5 % to that of 95 %.
    #[must_use]
    pub fn interval_90(&self) -> (f64, f64) {
        (self.quantiles[0].value, self.quantiles[2].value)
    }
}

/// Draws from the posterior, and what they say.
///
/// A cloud of points goes from the prior to the posterior by powers of the likelihood. From points of it, chains of random-walk
/// Metropolis start, whose proposals have the covariance of the cloud and do not change. The result is bitwise identical on
/// any number of threads.
///
/// Sources: Del Moral, Doucet and Jasra 2006, Sequential Monte Carlo samplers; Metropolis et al. 1953; Vehtari et al. 2021,
/// Rank-normalization, folding, and localization.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    parameters: Vec<ParameterPosterior>,
    acceptance: f64,
    temperatures: Vec<f64>,
    /// By chain and draw.
    chains: Vec<Vec<Vec<f64>>>,
}

impl Posterior {
    /// Samples prior times likelihood. The log-likelihood is asked for at points between the bounds of the parameters; minus
    /// infinity says that the data cannot be.
    ///
    /// # Errors
    /// [`Error::TooFew`] for a configuration, or a prior at hardly any point of which data are possible; those of the likelihood;
    /// [`Error::NotFinite`] for one that is no number; [`Error::NotPositiveDefinite`] where the cloud falls onto a point,
    /// [`Error::NotPositive`] where a chain does not move, or no power of a likelihood that falls too fast can be found.
    pub fn sample(
        space: &ParameterSpace,
        log_likelihood: LogLikelihood<'_>,
        config: &SamplerConfig,
    ) -> Result<Self, Error> {
        config.check()?;
        let target = Target { space, log_likelihood };
        let cloud = tempered(&target, config)?;
        let dimension = space.parameters().len();
        let proposal = Proposal::new(dimension, &covariance(&cloud.walkers))?;
        let chain = |chain: usize| {
            let mut stream = config.noise.stream(Purpose::MarkovChain, chain as u64);
            // Evenly over the cloud, which has no order.
            let mut walker = cloud.walkers[chain * config.n_particles / config.n_chains].clone();
            for _ in 0..config.n_warm_up {
                walker.step(&target, 1.0, &proposal, &mut stream)?;
            }
            let (mut draws, mut accepted) = (Vec::with_capacity(config.n_draws), 0_u64);
            for _ in 0..config.n_draws {
                accepted += u64::from(walker.step(&target, 1.0, &proposal, &mut stream)?);
                draws.push(space.values(&walker.units));
            }
            Ok((draws, accepted))
        };
        let chains: Result<Vec<_>, Error> =
            (0..config.n_chains).into_par_iter().map(chain).collect();
        let (chains, accepted): (Vec<_>, Vec<_>) = chains?.into_iter().unzip();
        let n_steps = (config.n_chains * config.n_draws) as f64;
        let acceptance = accepted.iter().sum::<u64>() as f64 / n_steps;
        let parameters = (0..dimension).map(|i| summary(space, &chains, i));
        let parameters = parameters.collect::<Result<Vec<_>, _>>()?;
        Ok(Self { parameters, acceptance, temperatures: cloud.temperatures, chains })
    }

    /// What it says of each parameter, in their order.
    #[must_use]
    pub fn parameters(&self) -> &[ParameterPosterior] {
        &self.parameters
    }

    /// The share of the proposals that were accepted.
    #[must_use]
    pub fn acceptance(&self) -> f64 {
        self.acceptance
    }

    /// The powers of the likelihood by which the cloud came to the posterior, up to 1.
    #[must_use]
    pub fn temperatures(&self) -> &[f64] {
        &self.temperatures
    }

    /// The draws, by chain and number: points of the parameters.
    #[must_use]
    pub fn chains(&self) -> &[Vec<Vec<f64>>] {
        &self.chains
    }

    /// At most so many draws, evenly spaced over all chains.
    ///
    /// # Errors
    /// [`Error::TooFew`] for none.
    pub fn thinned(&self, n_draws: usize) -> Result<Vec<Vec<f64>>, Error> {
        at_least("draws", n_draws, 1)?;
        let all: Vec<&Vec<f64>> = self.chains.iter().flatten().collect();
        let stride = all.len().div_ceil(n_draws);
        Ok(all.into_iter().step_by(stride).cloned().collect())
    }

    /// Whether every parameter has an `R`-hat of at most 1.01 and an effective sample size of at least 400 (Vehtari et al. 2021,
    /// section 4).
    #[must_use]
    pub fn has_converged(&self) -> bool {
        self.parameters.iter().all(|p| p.r_hat <= 1.01 && p.effective_sample_size >= 400.0)
    }
}

fn summary(
    space: &ParameterSpace,
    chains: &[Vec<Vec<f64>>],
    parameter: usize,
) -> Result<ParameterPosterior, Error> {
    let of = &space.parameters()[parameter];
    let take = |chain: &Vec<Vec<f64>>| chain.iter().map(|draw| draw[parameter]).collect();
    let values: Vec<Vec<f64>> = chains.iter().map(take).collect();
    let on_scale = mapped(&values, |x| of.on_scale(x));
    let prior_variance = space.prior_variance(parameter);
    let mean = mean(&values)?;
    let spread = variance(&values)?;
    let standard_deviation = spread.value.sqrt();
    let deviation_error = error(&spread) / (2.0 * standard_deviation);
    let spread = variance(&on_scale)?;
    let contraction = 1.0 - spread.value / prior_variance;
    let middle = self::mean(&on_scale)?.value;
    let to_bound = (middle - of.on_scale(of.low)).min(of.on_scale(of.high) - middle);
    let verdict = if contraction <= LEAST_CONTRACTION {
        Verdict::NotIdentified
    } else if to_bound < FROM_BOUND * spread.value.sqrt() {
        Verdict::AtBound
    } else {
        Verdict::Identified
    };
    let mut quantiles = [mean; 3];
    for (quantile, p) in quantiles.iter_mut().zip(POSTERIOR_QUANTILES) {
        *quantile = self::quantile(&values, p)?;
    }
    Ok(ParameterPosterior {
        name: of.name.clone(),
        mean,
        standard_deviation: estimate(standard_deviation, deviation_error),
        quantiles,
        r_hat: r_hat(&values)?,
        effective_sample_size: bulk_effective_sample_size(&values)?,
        contraction: estimate(contraction, error(&spread) / prior_variance),
        verdict,
    })
}

fn estimate(value: f64, standard_error: f64) -> Estimate {
    Estimate { value, uncertainty: Uncertainty::StandardError(standard_error) }
}

fn error(of: &Estimate) -> f64 {
    of.standard_error().unwrap_or(f64::INFINITY)
}

fn mapped(chains: &[Vec<f64>], map: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
    chains.iter().map(|chain| chain.iter().map(|&x| map(x)).collect()).collect()
}

/// Mean of all draws, with the error that their effective number leaves.
fn mean(chains: &[Vec<f64>]) -> Result<Estimate, Error> {
    let mut all = sde_integrators::Accumulator::default();
    chains.iter().flatten().for_each(|&x| all.push(x));
    let effective = effective_sample_size(chains)?;
    Ok(estimate(all.mean(), (all.variance()? / effective).sqrt()))
}

/// Variance of all draws: the mean of their squared distances to the mean.
fn variance(chains: &[Vec<f64>]) -> Result<Estimate, Error> {
    let middle = mean(chains)?.value;
    mean(&mapped(chains, |x| (x - middle) * (x - middle)))
}

/// The value of rank `ceil(S p)`; its error by the effective number of draws that lie below it or not.
fn quantile(chains: &[Vec<f64>], p: f64) -> Result<Estimate, Error> {
    let mut all = chains.concat();
    all.sort_unstable_by(f64::total_cmp);
    let n = all.len();
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a rank, from 1 to the number of draws"
    )]
    let at = |p: f64| all[((n as f64 * p).ceil().max(1.0) as usize).min(n) - 1];
    let value = at(p);
    let below = mapped(chains, |x| if x <= value { 1.0 } else { 0.0 });
    let effective = effective_sample_size(&below)?;
    let deviation = (p * (1.0 - p) / effective).sqrt();
    Ok(estimate(value, 0.5 * (at(p + deviation) - at(p - deviation))))
}
