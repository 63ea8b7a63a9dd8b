//! A value of a run with its error.

use random_vibration::GuidedEstimate;
use scene_runs::answers::{ErrorOrigin, Number};
use sde_integrators::{Estimate, normal_quantile};
use serde::Serialize;

use super::super::resolution_error::{Coarser, Orders, error_of_finest};

/// A quantity at a time, with its error.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Observed {
    pub(crate) t: f64,
    pub(crate) value: f64,
    pub(crate) error: Option<f64>,
    pub(crate) error_kind: ErrorOrigin,
    /// A note on an unreliable value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) note: Option<String>,
    /// How far the standard error of a weighted estimate can be trusted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) weights: Option<WeightsRecord>,
}

/// Weights of the paths that reached an event.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct WeightsRecord {
    paths: u64,
    hits: u64,
    pub(crate) effective_sample_size: f64,
    pub(crate) largest_share: f64,
    strength: f64,
}

impl WeightsRecord {
    /// The weights of guided paths.
    pub(crate) const fn of(found: &GuidedEstimate) -> Self {
        Self {
            paths: found.n_paths,
            hits: found.n_hits,
            effective_sample_size: found.effective_sample_size,
            largest_share: found.largest_share,
            strength: found.strength,
        }
    }
}

/// Runs that are coarser in one respect, with the ratios of their resolutions.
pub(crate) struct Refinement<R> {
    pub(crate) coarse: (Vec<R>, f64),
    pub(crate) coarsest: Option<(Vec<R>, f64)>,
    pub(crate) orders: Orders,
}

impl Observed {
    /// A value with its error from a coarser run, if there was one.
    pub(crate) fn by_two(t: f64, value: f64, error: Option<f64>) -> Self {
        let error = error.filter(|error| error.is_finite());
        let error_kind =
            if error.is_some() { ErrorOrigin::TwoResolutions } else { ErrorOrigin::Unknown };
        Self { t, value, error, error_kind, note: None, weights: None }
    }

    /// Results of a fine run with errors from the coarser runs: the sum over the refinements, where all of them reached the time.
    /// `pick` selects time and value.
    pub(crate) fn of_runs<R>(
        fine: &[R],
        refinements: &[Refinement<R>],
        pick: &dyn Fn(&R) -> (f64, f64),
    ) -> Vec<Self> {
        let observed = |(k, row)| {
            let (t, value) = pick(row);
            let at =
                |run: &(Vec<R>, f64)| Some(Coarser { value: pick(run.0.get(k)?).1, ratio: run.1 });
            let off = |refinement: &Refinement<R>| {
                let coarsest = refinement.coarsest.as_ref().and_then(at);
                let coarse = at(&refinement.coarse)?;
                Some(error_of_finest(value, coarse, coarsest, refinement.orders))
            };
            let error = refinements.iter().map(off).sum();
            Self::by_two(t, value, if refinements.is_empty() { None } else { error })
        };
        Self::without_sign_changes(fine.iter().enumerate().map(observed).collect())
    }

    /// Raises an error that is far smaller than those before and after it: a difference of runs that changes its sign in between. It
    /// becomes half of their geometric mean.
    pub(crate) fn without_sign_changes(mut all: Vec<Self>) -> Vec<Self> {
        let errors: Vec<Option<f64>> = all.iter().map(|observed| observed.error).collect();
        for (observed, around) in all.iter_mut().skip(1).zip(errors.windows(3)) {
            if let (Some(error), [Some(before), _, Some(after)]) = (&mut observed.error, around) {
                *error = error.max(0.5 * (before * after).sqrt());
            }
        }
        all
    }

    /// Raises a known error to another one.
    pub(crate) fn raise_error(&mut self, least: f64) {
        self.error = self.error.map(|error| error.max(least));
    }

    /// Adds an error that is independent of the known one, or `None` if it is unknown.
    pub(crate) fn add_error(&mut self, error: Option<f64>) {
        let both = self.error.zip(error).map(|(known, error)| known.hypot(error));
        self.error = both.filter(|error| error.is_finite());
        if self.error.is_none() {
            self.error_kind = ErrorOrigin::Unknown;
        }
    }

    /// Adds a probability that no particle carries to a known error.
    pub(crate) fn may_lack(&mut self, outside: f64) {
        let Some(error) = &mut self.error else { return };
        if outside > *error {
            self.error_kind = ErrorOrigin::Bound;
        }
        *error += outside;
    }

    /// A probability that is no larger than what the lattice left outside: their sum is a bound, and no more is known.
    pub(crate) fn bounded_by(&mut self, outside: f64) {
        (self.error, self.error_kind) = (Some(outside), ErrorOrigin::Bound);
    }

    /// A probability without an error where the estimate is zero; an error of zero would imply an exact value.
    pub(crate) fn without_zero_error(mut self, note: &str) -> Self {
        if self.value == 0.0 {
            self.lose_error(note);
        }
        self
    }

    /// Takes the error away, with the reason.
    pub(crate) fn lose_error(&mut self, note: &str) {
        (self.error, self.error_kind) = (None, ErrorOrigin::Unknown);
        self.note = Some(note.to_owned());
    }

    /// Takes away an error that is that of the lattice alone, and notes it; what is unknown for another reason keeps that.
    pub(crate) fn of_one_covariance(&mut self) {
        if let Some(error) = self.error {
            self.lose_error(&format!(
                "no lattice shows the error of one covariance of the filter for all states; that of the lattice is {error:.1e}"
            ));
        }
    }

    /// An estimate with its uncertainty.
    pub(crate) fn of_estimate(t: f64, estimate: &Estimate) -> Self {
        let Number { value, error, error_kind } = Number::from(*estimate);
        Self { t, value, error, error_kind, note: None, weights: None }
    }

    /// Says why the error is unknown, where it is.
    pub(crate) fn unknown_for(self, reason: &str) -> Self {
        let note = self.error.is_none().then(|| reason.to_owned());
        Self { note: self.note.or(note), ..self }
    }

    /// An estimate of guided paths.
    pub(crate) fn of_guided(t: f64, found: &GuidedEstimate) -> Self {
        Self { weights: Some(WeightsRecord::of(found)), ..Self::of_estimate(t, &found.estimate) }
    }

    /// The value with its error.
    pub(crate) const fn number(&self) -> Number {
        Number { value: self.value, error: self.error, error_kind: self.error_kind }
    }

    /// The value, unless its error is as large.
    pub(crate) fn known(&self) -> Option<f64> {
        self.error.is_none_or(|error| error < self.value.abs()).then_some(self.value)
    }
}

/// `dP / d ln(scale) = 2 z phi(z)` of a probability `P = 2 Phi(-z)` that a normal demand is above a threshold.
pub(crate) fn by_scale(probability: f64) -> f64 {
    if probability > 0.0 && probability < 1.0 {
        let z = -normal_quantile(0.5 * probability);
        2.0 * z * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_vanishes_between_two_times_is_a_change_of_sign() {
        let errors = [0.4, 0.0, 0.1, 1e-9, 0.0];
        let all = errors.map(|error| Observed::by_two(0.0, 1.0, Some(error))).to_vec();
        let raised: Vec<f64> =
            Observed::without_sign_changes(all).iter().filter_map(|it| it.error).collect();
        assert_eq!(raised, [0.4, 0.1, 0.1, 1e-9, 0.0]);
    }

    #[test]
    fn a_count_of_nothing_is_known_to_what_the_lattice_left_outside() {
        let mut zero = Observed::by_two(1.0, 0.0, Some(0.0));
        zero.may_lack(1e-7);
        assert_eq!((zero.error, zero.error_kind), (Some(1e-7), ErrorOrigin::Bound));
        let mut large = Observed::by_two(1.0, 0.5, Some(0.01));
        large.may_lack(1e-7);
        assert_eq!((large.error, large.error_kind), (Some(0.0100001), ErrorOrigin::TwoResolutions));
        let mut small = Observed::by_two(1.0, 1.7e-7, Some(1e-9));
        small.bounded_by(2.5e-7);
        assert_eq!((small.error, small.error_kind), (Some(2.5e-7), ErrorOrigin::Bound));
        let mut unknown = Observed::by_two(1.0, 0.5, None);
        unknown.may_lack(1e-7);
        assert_eq!(unknown.error, None);
    }
}
