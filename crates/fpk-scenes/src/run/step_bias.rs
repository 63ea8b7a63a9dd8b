//! The bias that the steps of paths leave in moments and probabilities, measured on pairs of paths: one place for all methods that
//! sample.

use scene_runs::answers::Unknown;
use scene_runs::causes::with_causes;
use sde_integrators::{
    EnsembleConfig, GaussianMixture, Observable, StepDifference, normal_quantile,
};

use super::observed::Observed;
use crate::density::{Requested, monomial};
use crate::monte_carlo::Sampling;
use crate::paths::{PathEnsemble, Paths};

/// Pairs of paths: a part of the paths, between these numbers.
const PART: u64 = 20;
const FEWEST: u64 = 100;
const MOST: u64 = 4_000;

/// The bias of the steps of paths at each time of observation.
#[derive(Debug)]
pub(super) struct StepBias {
    /// Empty where a pair failed.
    rows: Vec<Vec<StepDifference>>,
    /// Why, if one did.
    failed: Option<String>,
    times: Vec<f64>,
    bias_over_difference: f64,
}

impl StepBias {
    /// Measures the bias of a sampling. Where a pair of paths fails the bias is unknown, and no estimate is lost for it.
    pub(super) fn measured<S: Paths<D, M>, const D: usize, const M: usize>(
        system: &S,
        law: &GaussianMixture<D>,
        sampling: &Sampling,
        asked: &Requested<D>,
    ) -> Self {
        let Requested { times, powers, demand, .. } = asked;
        let monomials: Vec<_> =
            powers.iter().map(|&powers| move |_: f64, x: &[f64; D]| monomial(powers, x)).collect();
        let square = |_: f64, x: &[f64; D]| demand.magnitude(x).powi(2);
        let mut observables: Vec<Observable<'_, D>> =
            monomials.iter().map(|f| Observable::Mean(f)).collect();
        observables.push(Observable::Mean(&square));
        let &Sampling { paths, step, seed } = sampling;
        let config = EnsembleConfig { seed, n_paths: paths, dt: step, times: times.clone() };
        let ensemble = PathEnsemble { law, config: &config, observables: &observables };
        let found = system.step_differences(&ensemble, (paths / PART).clamp(FEWEST, MOST));
        let failed = found.as_ref().err().map(|error| with_causes(error));
        let bias_over_difference = S::INTEGRATOR.bias_over_difference();
        let rows = found.unwrap_or_default();
        Self { rows, failed, times: times.clone(), bias_over_difference }
    }

    /// The errors that are unknown without the bias.
    pub(super) fn unknown(&self) -> Option<Unknown> {
        let failed = self.failed.as_ref()?;
        Some(Unknown {
            what: "errors of all quantities".to_owned(),
            reason: format!(
                "the bias of the steps is measured on pairs of paths, and one failed: {failed}"
            ),
        })
    }

    /// Adds the bias to the error of moment `k`.
    pub(super) fn add_to_moment(&self, k: usize, observed: &mut Observed) {
        let bias = self.row(observed.t).and_then(|row| self.bias(row.get(k)?));
        observed.add_error(bias);
    }

    /// Adds the bias to the error of a probability `P = 2 Phi(-z)`: that of the scale of the demand, by `dP / d ln(scale) = 2 z phi(z)`
    /// of a normal distribution.
    pub(super) fn add_to_probability(&self, observed: &mut Observed) {
        let relative = self.row(observed.t).and_then(|row| {
            let square = row.last()?;
            Some(0.5 * self.bias(square)? / square.value.value)
        });
        let value = observed.value;
        let slope = if value > 0.0 && value < 1.0 {
            let z = -normal_quantile(0.5 * value);
            2.0 * z * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
        } else {
            0.0
        };
        observed.add_error(relative.map(|relative| slope * relative));
    }

    fn row(&self, t: f64) -> Option<&[StepDifference]> {
        let k = self.times.iter().position(|time| time.to_bits() == t.to_bits())?;
        self.rows.get(k).map(Vec::as_slice)
    }

    /// The bias of a mean, with the standard error of what it is measured by.
    fn bias(&self, found: &StepDifference) -> Option<f64> {
        let StepDifference { difference, .. } = found;
        let bias = self.bias_over_difference * difference.value.hypot(difference.standard_error()?);
        bias.is_finite().then_some(bias)
    }
}
