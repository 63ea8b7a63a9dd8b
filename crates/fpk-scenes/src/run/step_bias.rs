//! The bias that the steps of paths leave in moments and probabilities, measured on pairs of paths: one place for all methods that
//! sample.

use scene_runs::answers::Unknown;
use scene_runs::causes::with_causes;
use sde_integrators::{EnsembleConfig, GaussianMixture, Observable, StepDifference};

use super::observed::{Observed, by_scale};
use crate::density::{Requested, monomial};
use crate::monte_carlo::Sampling;
use crate::paths::{PathEnsemble, Paths};

/// Pairs of paths: a part of the paths, between these numbers.
const PART: u64 = 20;
const FEWEST: u64 = 100;
const MOST: u64 = 4_000;
/// Pairs with amplified noise, and the largest amplitude.
const AMPLIFIED: u64 = 2_000;
const MOST_AMPLITUDE: f64 = 64.0;

/// The bias of the steps of paths at each time of observation.
#[derive(Debug)]
pub(super) struct StepBias {
    /// Empty where a pair failed. The last difference is that of the square of the demand.
    rows: Vec<Vec<StepDifference>>,
    /// Why, if one did.
    failed: Option<String>,
    /// The square of the demand at each time, with noise of twice the amplitude, four times and so on until it reaches the
    /// highest threshold; none of a linear system, whose bias is the same for all.
    amplified: Vec<Vec<StepDifference>>,
    is_linear: bool,
    times: Vec<f64>,
    bias_over_difference: f64,
}

/// What half the step changes of the scale of a demand: relative bias, and the power of the amplitude with which the scale grows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OfScale {
    relative: f64,
    power: f64,
}

impl StepBias {
    /// Measures the bias of a sampling. Where a pair of paths fails the bias is unknown, and no estimate is lost for it.
    pub(super) fn measured<S: Paths<D, M>, const D: usize, const M: usize>(
        (system, is_linear): (&S, bool),
        law: &GaussianMixture<D>,
        sampling: &Sampling,
        asked: &Requested<D>,
    ) -> Self {
        let Requested { times, powers, demand, thresholds, .. } = asked;
        let monomials: Vec<_> =
            powers.iter().map(|&powers| move |_: f64, x: &[f64; D]| monomial(powers, x)).collect();
        let square = |_: f64, x: &[f64; D]| demand.magnitude(x).powi(2);
        let mut observables: Vec<Observable<'_, D>> =
            monomials.iter().map(|f| Observable::Mean(f)).collect();
        observables.push(Observable::Mean(&square));
        let &Sampling { paths, step, seed } = sampling;
        let config = EnsembleConfig { seed, n_paths: paths, dt: step, times: times.clone() };
        let pairs = |observables: &[Observable<'_, D>], n: u64, amplitude: f64| {
            let ensemble = PathEnsemble { law, config: &config, observables };
            system.step_differences(&ensemble, n, amplitude)
        };
        let found = pairs(&observables, (paths / PART).clamp(FEWEST, MOST), 1.0);
        let failed = found.as_ref().err().map(|error| with_causes(error));
        let rows = found.unwrap_or_default();
        let highest = thresholds.iter().copied().fold(0.0, f64::max);
        let is_below = |rows: &[StepDifference]| rows.iter().any(|row| rms(row) < highest);
        let (mut amplified, mut amplitude) = (Vec::new(), 2.0);
        let mut goes_on = !is_linear && failed.is_none() && highest > 0.0;
        while goes_on && amplitude <= MOST_AMPLITUDE {
            let found = pairs(&[Observable::Mean(&square)], AMPLIFIED, amplitude);
            let Ok(found) = found else { break };
            let at_times: Vec<StepDifference> = found.into_iter().flatten().collect();
            goes_on = is_below(&at_times);
            amplified.push(at_times);
            amplitude *= 2.0;
        }
        let bias_over_difference = S::INTEGRATOR.bias_over_difference();
        Self { rows, failed, amplified, is_linear, times: times.clone(), bias_over_difference }
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

    /// Adds the bias to the error of a probability `P = 2 Phi(-z)` that the demand is above a threshold: that of the scale of the
    /// demand where it is as large as the threshold, by `dP / d ln(scale) = 2 z phi(z) / a`. With noise amplified by `s` the scale
    /// grows as `s^a`: `a` is 1 for a linear system, whose probabilities are normal, and 1/2 where a cubic force prevails.
    pub(super) fn add_to_probability(&self, threshold: f64, observed: &mut Observed) {
        if observed.error.is_none() {
            return;
        }
        let slope = by_scale(observed.value);
        let bias = self.of_scale(observed.t, threshold);
        observed.add_error(bias.map(|OfScale { relative, power }| slope * relative / power));
        if bias.is_none() && self.failed.is_none() {
            let note = "no path with half the step came so far: the bias of the steps is unknown; take shorter ones";
            observed.note.get_or_insert_with(|| note.to_owned());
        }
    }

    /// The bias of the scale of the demand where it is as large as a threshold: the larger one of the amplitudes around it.
    fn of_scale(&self, t: f64, threshold: f64) -> Option<OfScale> {
        let k = self.index(t)?;
        let relative =
            |square: &StepDifference| Some(0.5 * self.bias(square)? / square.value.value);
        let first = self.rows.get(k)?.last()?;
        let mut below = (rms(first), relative(first)?);
        if self.is_linear || threshold <= below.0 {
            return Some(OfScale { relative: below.1, power: 1.0 });
        }
        for rows in &self.amplified {
            let square = rows.get(k)?;
            let above = (rms(square), relative(square)?);
            if threshold <= above.0 {
                let power = (above.0 / below.0).log2().clamp(LEAST_POWER, 1.0);
                return Some(OfScale { relative: above.1.max(below.1), power });
            }
            below = above;
        }
        None
    }

    fn index(&self, t: f64) -> Option<usize> {
        self.times.iter().position(|time| time.to_bits() == t.to_bits())
    }

    fn row(&self, t: f64) -> Option<&[StepDifference]> {
        self.rows.get(self.index(t)?).map(Vec::as_slice)
    }

    /// The bias of a mean, with the standard error of what it is measured by.
    fn bias(&self, found: &StepDifference) -> Option<f64> {
        let StepDifference { difference, .. } = found;
        let bias = self.bias_over_difference * difference.value.hypot(difference.standard_error()?);
        bias.is_finite().then_some(bias)
    }
}

/// Least power of the amplitude with which a scale grows: that of a force of the ninth power.
const LEAST_POWER: f64 = 0.2;

/// Root of a mean square.
fn rms(square: &StepDifference) -> f64 {
    square.value.value.sqrt()
}
