//! The bias that the steps of paths leave in moments and probabilities, measured on pairs of paths: one place for all methods that
//! sample.

use scene_runs::answers::Unknown;
use scene_runs::causes::with_causes;
use sde_integrators::{
    EnsembleConfig, GaussianMixture, Observable, StepDifference, normal_probability,
    normal_quantile,
};

use super::observed::Observed;
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
pub(crate) struct StepBias {
    /// Empty where a pair failed. The last difference is that of the square of the demand.
    rows: Vec<Vec<StepDifference>>,
    /// Why, if one did.
    failed: Option<String>,
    /// The square of the demand at each time, with noise of twice the amplitude, four times and so on until it reaches the
    /// highest threshold; none of a linear system, whose bias is the same for all.
    amplified: Vec<Vec<StepDifference>>,
    measured_as: MeasuredAs,
    times: Vec<f64>,
}

/// How the bias of a sampling follows from pairs of paths, and what it changes of a probability.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeasuredAs {
    /// Whether the bias of a scale is the same for all thresholds.
    pub(crate) is_linear: bool,
    pub(crate) highest_threshold: f64,
    pub(crate) bias_over_difference: f64,
    pub(crate) law: Law,
}

/// How a probability depends on the scale of its demand.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Law {
    /// `P = 2 Phi(-z)`.
    Normal,
    /// Passages by independent crossings, as many as half periods up to then: `P = 1 - exp(-n exp(-z^2/2))`.
    Crossings { half_period: f64 },
}

impl Law {
    /// What a probability becomes where the noise is larger by a factor: `2 Phi(-z/f)`, or `1 - exp(-L f')` with `L = -ln(1 - P)` and
    /// `ln f' = (1 - 1/f^2) z^2/2`, `z^2 = 2 ln(n/L)`.
    fn with_noise(self, t: f64, probability: f64, factor: f64) -> f64 {
        match self {
            Self::Normal => 2.0 * normal_probability(normal_quantile(0.5 * probability) / factor),
            Self::Crossings { half_period } => {
                let expected = -(-probability).ln_1p();
                let square = 2.0 * (t / half_period).max(1.0).ln() - 2.0 * expected.ln();
                let more = 0.5 * square.max(1.0) * (1.0 - factor.powi(-2));
                -(-expected * more.exp()).exp_m1()
            }
        }
    }

    /// The larger change of a probability where the noise is larger, or smaller, by a factor.
    fn change(self, t: f64, probability: f64, factor: f64) -> f64 {
        if probability <= 0.0 || probability >= 1.0 {
            return 0.0;
        }
        let more = self.with_noise(t, probability, factor) - probability;
        more.max(probability - self.with_noise(t, probability, 1.0 / factor))
    }
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
        let pairs = |amplitude: f64| {
            let (observables, n) = if amplitude > 1.0 {
                (&[Observable::Mean(&square)][..], AMPLIFIED)
            } else {
                (&observables[..], (paths / PART).clamp(FEWEST, MOST))
            };
            let ensemble = PathEnsemble { law, config: &config, observables };
            system.step_differences(&ensemble, n, amplitude)
        };
        let measured_as = MeasuredAs {
            is_linear,
            highest_threshold: thresholds.iter().copied().fold(0.0, f64::max),
            bias_over_difference: S::INTEGRATOR.bias_over_difference(),
            law: Law::Normal,
        };
        Self::of_pairs(times, measured_as, pairs)
    }

    /// Measures the bias by pairs of paths under noise of an amplitude: per time the differences of the observables, the last of them
    /// the square of the demand.
    pub(crate) fn of_pairs<E: std::error::Error + 'static>(
        times: &[f64],
        measured_as: MeasuredAs,
        pairs: impl Fn(f64) -> Result<Vec<Vec<StepDifference>>, E>,
    ) -> Self {
        let found = pairs(1.0);
        let failed = found.as_ref().err().map(|error| with_causes(error));
        let rows = found.unwrap_or_default();
        let MeasuredAs { is_linear, highest_threshold, .. } = measured_as;
        let is_below = |row: &StepDifference| rms(row) < highest_threshold;
        let (mut amplified, mut amplitude) = (Vec::new(), 2.0);
        let mut goes_on = !is_linear && failed.is_none() && highest_threshold > 0.0;
        while goes_on && amplitude <= MOST_AMPLITUDE {
            let Ok(found) = pairs(amplitude) else { break };
            let at_times: Vec<StepDifference> = found.into_iter().flatten().collect();
            goes_on = at_times.iter().any(is_below);
            amplified.push(at_times);
            amplitude *= 2.0;
        }
        Self { rows, failed, amplified, measured_as, times: times.to_vec() }
    }

    /// The errors that are unknown without the bias.
    pub(crate) fn unknown(&self) -> Option<Unknown> {
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

    /// Adds the bias to the error of a probability that the demand is above a threshold: the change of the probability under more noise,
    /// by which the scale of the demand grows as much as it is biased. The bias is that of a demand as large as the threshold. With noise
    /// amplified by `s` the scale grows as `s^a`: `a` is 1 for a linear system, whose probabilities are normal, and 1/2 where a cubic
    /// force prevails.
    pub(crate) fn add_to_probability(&self, threshold: f64, observed: &mut Observed) {
        let Some(error) = observed.error else { return };
        // Where no path is above the threshold, its bound has the bias.
        let probability = if observed.value > 0.0 { observed.value } else { error };
        let of_scale = self.of_scale(observed.t, threshold);
        let resolved = of_scale.filter(|of_scale| of_scale.relative <= MOST_BIAS);
        observed.add_error(resolved.map(|OfScale { relative, power }| {
            let factor = (1.0 + relative).powf(1.0 / power);
            self.measured_as.law.change(observed.t, probability, factor)
        }));
        if resolved.is_none() && self.failed.is_none() {
            let note = match of_scale {
                Some(_) => {
                    "the steps change the demand by over a quarter: their bias is unknown; take shorter ones"
                }
                None => {
                    "no path with half the step came so far: the bias of the steps is unknown; take shorter ones"
                }
            };
            observed.note.get_or_insert_with(|| note.to_owned());
        }
    }

    /// The bias of the scale of the demand where it is as large as a threshold: the larger one of the amplitudes around it.
    fn of_scale(&self, t: f64, threshold: f64) -> Option<OfScale> {
        let k = self.index(t)?;
        // Over what the steps of the run give, from the difference of the squares.
        let relative = |square: &StepDifference| {
            let whole = square.value.value - square.difference.value;
            Some((1.0 + self.bias(square)? / whole).sqrt() - 1.0).filter(|it| *it >= 0.0)
        };
        let first = self.rows.get(k)?.last()?;
        let mut below = (rms(first), relative(first)?);
        if self.measured_as.is_linear || threshold <= below.0 {
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
        let bias = self.measured_as.bias_over_difference
            * difference.value.hypot(difference.standard_error()?);
        bias.is_finite().then_some(bias)
    }
}

/// Relative bias of a scale above which half the step does not show it.
const MOST_BIAS: f64 = 0.25;

/// Least power of the amplitude with which a scale grows: that of a force of the ninth power.
const LEAST_POWER: f64 = 0.2;

/// Root of a mean square.
fn rms(square: &StepDifference) -> f64 {
    square.value.value.sqrt()
}
