//! Posteriors of the parameters in a result file: errors, marginal distributions, correlations.

use crack_inference::{
    Emulator, Observations, POSTERIOR_QUANTILES, Parameter, ParameterPosterior, ParameterSpace,
    Posterior, Prior, Scale, Verdict,
};
use scene_runs::answers::Number;
use scene_runs::kind::RunError;
use sde_integrators::{Estimate, Uncertainty, normal_probability};
use serde::Serialize;

use crate::run::Quantile;

/// Verdicts on a parameter whose data the model predicts.
const IDENTIFIED: &str = "identified";
pub(super) const AT_BOUND: &str = "at the bound of the prior";
pub(super) const NOT_IDENTIFIED: &str = "not identified";

/// Bins of a marginal distribution, of equal width on the scale of the parameter.
const BINS: usize = 24;

/// Draws for the error that finite ensembles leave in posterior means.
const DRAWS: usize = 400;

/// Posterior of a parameter.
#[derive(Debug, Serialize)]
pub(super) struct ParameterRecord {
    pub(super) key: String,
    pub(super) mean: Number,
    pub(super) standard_deviation: Number,
    pub(super) quantiles: Vec<Quantile>,
    /// One less the variance of the posterior over that of the prior, on the scale.
    pub(super) contraction: Number,
    /// Whether the data determine it: they contract its prior, no bound cuts its posterior, and the model predicts them.
    pub(super) is_identified: bool,
    pub(super) verdict: &'static str,
    pub(super) r_hat: f64,
    pub(super) effective_sample_size: f64,
    /// Standard error of the mean on the scale of the parameter that the finite ensembles of the design leave; the average over
    /// emulators has it in the width of the posterior.
    pub(super) error_of_ensembles: f64,
    pub(super) marginal: Vec<Bin>,
}

/// Densities in an interval of a parameter.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Bin {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Density of the posterior, per unit of the key.
    pub(super) posterior: Number,
    /// Density of the prior, per unit of the key.
    pub(super) prior: f64,
}

/// A correlation of two parameters.
#[derive(Debug, Serialize)]
pub(super) struct Correlation {
    pub(super) of: String,
    pub(super) with: String,
    #[serde(flatten)]
    pub(super) number: Number,
}

/// Posteriors of all parameters.
pub(super) fn parameters(
    space: &ParameterSpace,
    posterior: &Posterior,
    emulator: &Emulator,
    data: &Observations,
    is_predicted: bool,
) -> Result<Vec<ParameterRecord>, RunError> {
    let verdict = |of: &ParameterPosterior| match of.verdict {
        _ if !is_predicted => "data outside the predictions",
        Verdict::Identified => IDENTIFIED,
        Verdict::AtBound => AT_BOUND,
        Verdict::NotIdentified => NOT_IDENTIFIED,
    };
    let errors = emulator
        .error_of_means(&posterior.thinned(DRAWS).map_err(RunError::solver)?, data)
        .map_err(RunError::solver)?;
    let of = |(i, of): (usize, &ParameterPosterior)| ParameterRecord {
        key: of.name.clone(),
        mean: of.mean.into(),
        standard_deviation: of.standard_deviation.into(),
        quantiles: Quantile::all(&POSTERIOR_QUANTILES, &of.quantiles),
        contraction: of.contraction.into(),
        is_identified: is_predicted && of.verdict == Verdict::Identified,
        verdict: verdict(of),
        r_hat: of.r_hat,
        effective_sample_size: of.effective_sample_size,
        error_of_ensembles: errors[i],
        marginal: marginal(&space.parameters()[i], posterior, i),
    };
    Ok(posterior.parameters().iter().enumerate().map(of).collect())
}

fn on_scale(parameter: &Parameter, value: f64) -> f64 {
    match parameter.scale {
        Scale::Linear => value,
        Scale::Logarithmic => value.ln(),
    }
}

/// Shares of the draws, and of the prior, in bins from bound to bound, over the widths of the bins.
fn marginal(parameter: &Parameter, posterior: &Posterior, i: usize) -> Vec<Bin> {
    let (low, high) = (on_scale(parameter, parameter.low), on_scale(parameter, parameter.high));
    let edge = |k: usize| low + (high - low) * k as f64 / BINS as f64;
    let value = |on_scale: f64| match parameter.scale {
        Scale::Linear => on_scale,
        Scale::Logarithmic => on_scale.exp(),
    };
    let draws = posterior.chains().iter().flatten().map(|draw| on_scale(parameter, draw[i]));
    let (mut counts, mut n) = (vec![0_u64; BINS], 0_u64);
    for draw in draws {
        let place = (draw - low) / (high - low) * BINS as f64;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a bin")]
        let bin = (place.max(0.0) as usize).min(BINS - 1);
        counts[bin] += 1;
        n += 1;
    }
    let effective = posterior.parameters()[i].effective_sample_size;
    let below = |on_scale: f64| match parameter.prior {
        Prior::Uniform => (on_scale - low) / (high - low),
        Prior::Normal { mean, standard_deviation } => {
            let of = |at: f64| normal_probability((at - mean) / standard_deviation);
            (of(on_scale) - of(low)) / (of(high) - of(low))
        }
    };
    let bin = |(k, &count): (usize, &u64)| {
        let (from, to) = (value(edge(k)), value(edge(k + 1)));
        let share = count as f64 / n as f64;
        let width = to - from;
        let uncertainty = if count == 0 {
            // No draw: three over the number of independent ones.
            Uncertainty::Bound(3.0 / effective / width)
        } else {
            Uncertainty::StandardError((share * (1.0 - share) / effective).sqrt() / width)
        };
        let posterior = Estimate { value: share / width, uncertainty }.into();
        Bin { low: from, high: to, posterior, prior: (below(edge(k + 1)) - below(edge(k))) / width }
    };
    counts.iter().enumerate().map(bin).collect()
}

/// Correlations of all pairs, with the standard error `(1 - r^2)/sqrt(n)` for the smaller effective number of draws.
pub(super) fn correlations(space: &ParameterSpace, posterior: &Posterior) -> Vec<Correlation> {
    let parameters = space.parameters();
    let draws = || posterior.chains().iter().flatten();
    let n = draws().count() as f64;
    let at = |draw: &[f64], i: usize| on_scale(&parameters[i], draw[i]);
    let mean: Vec<f64> =
        (0..parameters.len()).map(|i| draws().map(|draw| at(draw, i)).sum::<f64>() / n).collect();
    let covariance = |i: usize, j: usize| {
        draws().map(|draw| (at(draw, i) - mean[i]) * (at(draw, j) - mean[j])).sum::<f64>() / n
    };
    let pairs = (0..parameters.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
    let of = |(i, j): (usize, usize)| {
        let value = covariance(i, j) / (covariance(i, i) * covariance(j, j)).sqrt();
        let effective = |i: usize| posterior.parameters()[i].effective_sample_size;
        let error = (1.0 - value * value) / effective(i).min(effective(j)).sqrt();
        let uncertainty = Uncertainty::StandardError(error);
        Correlation {
            of: parameters[i].name.clone(),
            with: parameters[j].name.clone(),
            number: Estimate { value, uncertainty }.into(),
        }
    };
    pairs.map(of).collect()
}
