//! Result file of an inference: schema `crack-inference/1`.

use crack_inference::{Component, ComponentFit, Emulator, Observations, Posterior, Summaries};
use scene_runs::answers::Number;
use scene_runs::kind::RunError;
use scene_runs::scene::NamedFile;
use serde::Serialize;

use super::ensembles::Ended;
use super::posterior_record::{Correlation, ParameterRecord};
use super::predictive::{Compared, PathBand};
use crate::crack_inference::measured::MeasuredPlate;

/// Keys that this kind adds to every result.
#[derive(Debug, Serialize)]
pub(super) struct Content {
    /// The plate, the files that it names, and those of the measured plates.
    pub(super) files: Vec<NamedFile>,
    pub(super) seed: u64,
    pub(super) work: WorkRecord,
    pub(super) parameters: Vec<ParameterRecord>,
    /// Correlations of the parameters under the posterior, on their scales.
    pub(super) correlations: Vec<Correlation>,
    pub(super) sampler: SamplerRecord,
    pub(super) emulator: EmulatorRecord,
    pub(super) measured: MeasuredRecord,
    pub(super) predictive: PredictiveRecord,
}

/// Work counters.
#[derive(Debug, Default, Serialize)]
pub(super) struct WorkRecord {
    /// Ensembles of the design and of the prediction.
    pub(super) ensembles: usize,
    /// Their realisations.
    pub(super) realisations: usize,
    /// CPU time of ensembles and posterior on all threads.
    pub(super) cpu_seconds: f64,
}

/// What the sampler reports.
#[derive(Debug, Serialize)]
pub(super) struct SamplerRecord {
    /// Share of accepted proposals of the chains.
    pub(super) acceptance: f64,
    /// Powers of the likelihood from the prior to the posterior.
    pub(super) temperatures: Vec<f64>,
    pub(super) has_converged: bool,
}

/// The fitted likelihood.
#[derive(Debug, Serialize)]
pub(super) struct EmulatorRecord {
    /// Log-likelihood at the posterior medians, with the standard error that finite ensembles leave in one fit.
    pub(super) log_likelihood: Number,
    /// Least share of the realisations of an ensemble that have all summaries.
    pub(super) least_share: f64,
    pub(super) fit: Vec<Fit>,
    pub(super) points: Vec<PointRecord>,
}

/// Lack of fit of one number of the distribution of the summaries.
#[derive(Debug, Serialize)]
pub(super) struct Fit {
    /// The component in words.
    pub(super) component: String,
    /// Squared residuals over the variances of finite ensembles; none where an ensemble has the variance zero.
    pub(super) chi_square: Option<f64>,
    pub(super) degrees_of_freedom: usize,
    /// Root mean square of the residuals beyond these variances, in standard deviations of the summary; of a variance, of its
    /// logarithm.
    pub(super) misfit: f64,
    /// The misfit over the standard error with which the measured plates determine the same number.
    pub(super) over_error_of_plates: f64,
}

/// An ensemble of the design.
#[derive(Debug, Serialize)]
pub(super) struct PointRecord {
    point: Vec<f64>,
    with_summaries: usize,
    without_summaries: usize,
}

/// The measured plates.
#[derive(Debug, Serialize)]
pub(super) struct MeasuredRecord {
    pub(super) plates: usize,
    /// Plates without a crack at all abscissae, which do not count.
    pub(super) without_summaries: usize,
    pub(super) paths: Vec<MeasuredPlate>,
}

/// Posterior prediction.
#[derive(Debug, Serialize)]
pub(super) struct PredictiveRecord {
    /// Points of the parameters.
    pub(super) draws: Vec<Vec<f64>>,
    /// Share of the measured values inside their band of 90 %.
    pub(super) share_inside: Option<Number>,
    pub(super) summaries: Vec<Compared>,
    /// Predicted heights of the crack.
    pub(super) path: Vec<PathBand>,
}

impl EmulatorRecord {
    pub(super) fn new(
        emulator: &Emulator,
        posterior: &Posterior,
        data: &Observations,
        (names, ensembles, summaries): (&[String], &[Ended], &[Summaries]),
    ) -> Result<Self, RunError> {
        let medians: Vec<f64> =
            posterior.parameters().iter().map(|it| it.quantiles[1].value).collect();
        let fit = |fit: &ComponentFit| Fit {
            component: component(names, fit.component),
            chi_square: Some(fit.chi_square).filter(|value| value.is_finite()),
            degrees_of_freedom: fit.degrees_of_freedom,
            misfit: fit.misfit,
            over_error_of_plates: fit.misfit * over_error(fit.component, data.n_plates()),
        };
        let point = |(ended, summaries): (&Ended, &Summaries)| PointRecord {
            point: ended.point.clone(),
            with_summaries: summaries.n_realisations(),
            without_summaries: summaries.absent().total(),
        };
        Ok(Self {
            log_likelihood: emulator
                .log_likelihood(&medians, data)
                .map_err(RunError::solver)?
                .into(),
            least_share: emulator.least_share(),
            fit: emulator.fit().iter().map(fit).collect(),
            points: ensembles.iter().zip(summaries).map(point).collect(),
        })
    }
}

/// One over the standard error, in the unit of a misfit, with which `P` plates determine a component: `1/sqrt(P)` for means and slopes,
/// `sqrt(2/P)` for the logarithm of a variance.
fn over_error(component: Component, plates: usize) -> f64 {
    let plates = plates as f64;
    match component {
        Component::Mean(_) | Component::Slope(..) => plates.sqrt(),
        Component::LogVariance(_) => (0.5 * plates).sqrt(),
    }
}

fn component(names: &[String], component: Component) -> String {
    match component {
        Component::Mean(i) => format!("mean of the {}", names[i]),
        Component::Slope(i, j) => format!("slope of the {} on the {}", names[i], names[j]),
        Component::LogVariance(i) => format!("logarithm of the variance of the {}", names[i]),
    }
}
