//! Responses of a plan with their moments.

use perturbation_moments::{Estimate, Uncertainty};
use result_figures::number::{percent, short};
use scene_runs::answers::{ErrorOrigin, Number};
use serde::Serialize;
use smpm::uncertainty::{MOST_FAILED, Series, Switch, exceedance_of_normal};
use smpm::{Error, Plan, Window};

use crate::scene::{RandomScene, SmpmScene};

/// What none of `n` samples has met has a probability below three in `n`, in 95 of 100 cases.
const RULE_OF_THREE: f64 = 3.0;

/// A response with its moments.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Response {
    /// Start and end of the window; equal for an instant.
    pub(super) window: [f64; 2],
    /// Value at the centre of the parameters.
    pub(super) centre: f64,
    pub(super) mean: f64,
    /// Standard error of the mean, if sampled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mean_standard_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) variance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) variance_standard_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) standard_deviation: Option<f64>,
    /// Error of the mean of a Taylor series: twice the root mean square of what it leaves of whole runs that it has not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mean_error: Option<f64>,
    /// Likewise of its standard deviation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) standard_deviation_error: Option<f64>,
    /// Share of the samples that ended in errors and did not count, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) failed_share: Option<f64>,
    /// Number of samples that correct a surrogate, if they do.
    #[serde(skip)]
    pub(super) n_followed: Option<u64>,
    /// Trust in a Taylor series.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) trust: Option<Indicators>,
    /// Parts of the variance, if they were asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) sobol_indices: Vec<Shares>,
    /// What the next coarser grid changes, if a multilevel estimate used it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) change_from_coarser_grid: Option<GridChange>,
    /// Levels and their exceedance probabilities.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) exceedance: Vec<Chance>,
}

impl Response {
    /// The end of its window.
    pub(super) const fn time(&self) -> f64 {
        self.window[1]
    }

    /// Whether it is of one time and not of a window.
    pub(super) const fn is_instant(&self) -> bool {
        self.window[0] >= self.window[1]
    }

    /// The mean with its error.
    pub(super) fn mean(&self) -> Number {
        self.number(self.mean, self.mean_standard_error.or(self.mean_error))
    }

    /// The standard deviation with its error: from check runs, or from that of the variance to first order.
    pub(super) fn deviation(&self) -> Option<Number> {
        let deviation = self.standard_deviation?;
        let first_order = || self.variance_standard_error.filter(|_| deviation > 0.0);
        let sampled = || Some(first_order()? / (2.0 * deviation));
        Some(self.number(deviation, self.standard_deviation_error.or_else(sampled)))
    }

    fn number(&self, value: f64, error: Option<f64>) -> Number {
        let number = Number::sampled(value, error);
        if self.mean_error.is_none() {
            return number;
        }
        Number { error_kind: ErrorOrigin::CheckRuns, ..number }
    }

    /// Whether its series leaves more than half of the deviation of check runs.
    pub(super) fn is_missed(&self) -> bool {
        let [deviation, error] =
            [self.standard_deviation, self.standard_deviation_error].map(|it| it.unwrap_or(0.0));
        error > 0.5 * deviation
    }

    /// How the errors of its moments are known, in words.
    pub(super) fn how(&self) -> String {
        if let Some(share) = self.failed_share {
            let share = format!("{} of the samples ended in errors", percent(share));
            return match self.mean_standard_error {
                Some(_) => format!(
                    "standard error of the samples; {share} and are taken within three deviations"
                ),
                None => format!(
                    "error unknown: {share} and did not count, at most {} may",
                    percent(MOST_FAILED)
                ),
            };
        }
        if self.mean_error.is_some() {
            return ErrorOrigin::CheckRuns.words().to_owned();
        }
        if let (Some(n), Some(_)) = (self.n_followed, self.mean_standard_error) {
            let most = short(Some(RULE_OF_THREE / n as f64));
            return format!(
                "standard error of the samples about a surrogate; what none of {n} runs met, such as a later yielding, may change it by {most} deviations"
            );
        }
        match (&self.trust, self.mean_standard_error, self.standard_deviation) {
            (_, Some(_), _) => "standard error of the samples".to_owned(),
            (Some(Indicators { curvature_ratio: Some(ratio), .. }), ..) => {
                format!("Taylor series, no error estimate; curvature ratio {}", short(Some(*ratio)))
            }
            (Some(_), ..) => "Taylor series, no error estimate".to_owned(),
            (None, None, Some(deviation)) if deviation <= 0.0 => {
                "error unknown: all runs answer the same".to_owned()
            }
            (None, None, Some(_)) => "no error estimate".to_owned(),
            (None, None, None) => "one run, no error estimate".to_owned(),
        }
    }
}

/// Difference of a mean between the grid of the scene and the next coarser one.
#[derive(Debug, Clone, Serialize)]
pub(super) struct GridChange {
    coarser_cell: f64,
    mean: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    mean_standard_error: Option<f64>,
}

impl GridChange {
    pub(super) fn new(coarser_cell: f64, mean: &Estimate) -> Self {
        Self { coarser_cell, mean: mean.value, mean_standard_error: error_of(mean) }
    }
}

/// Trust indicators of a Taylor series.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Indicators {
    /// Square root of the variance by curvature over that by slope.
    ///
    /// Below 0.03 the variance is mostly accurate within one per cent.
    ///
    /// Unknown without mixed derivatives or where nothing varies.
    pub(super) curvature_ratio: Option<f64>,
    /// Distance to an elastic-plastic switch at the end of the window, in standard deviations.
    ///
    /// None without yielding at the gauge.
    pub(super) switch_distance: Option<f64>,
    /// The distance is below two.
    pub(super) switch_within_two_deviations: bool,
}

/// Parts of the variance of a response that a parameter causes.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Shares {
    pub(super) parameter: String,
    /// First-order index: what it causes alone.
    pub(super) first: f64,
    pub(super) first_standard_error: Option<f64>,
    /// Total index: what would remain if all others were fixed.
    pub(super) total: f64,
    pub(super) total_standard_error: Option<f64>,
    /// Part of the variance that a fitted polynomial leaves: an index may be off by it, besides its standard error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) unexplained: Option<f64>,
}

/// A level and its exceedance probability.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Chance {
    pub(super) level: f64,
    pub(super) probability: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) standard_error: Option<f64>,
    /// `normal_law` from the moments, `count` of samples, or `differences` of counts over grids, which may lie outside of 0 to 1 by
    /// their standard error.
    pub(super) by: &'static str,
}

fn error_of(estimate: &Estimate) -> Option<f64> {
    match estimate.uncertainty {
        Uncertainty::StandardError(error) | Uncertainty::Bound(error) => {
            Some(error).filter(|error| error.is_finite())
        }
        Uncertainty::Unknown => None,
    }
}

/// Responses of a plan at the centre.
pub(super) struct Table<'a, const D: usize> {
    pub(super) scene: &'a SmpmScene,
    pub(super) plan: &'a Plan<D>,
    pub(super) centre: &'a [f64],
}

impl<const D: usize> Table<'_, D> {
    pub(super) fn each(
        &self,
        mut fill: impl FnMut(usize, Response) -> Result<Response, Error>,
    ) -> Result<Vec<Response>, Error> {
        let start = |(i, &centre): (usize, &f64)| {
            let Window { from, to } = self.plan.windows[self.plan.parts(i).2];
            let response = Response {
                window: [from, to],
                centre,
                mean: centre,
                mean_standard_error: None,
                variance: None,
                variance_standard_error: None,
                standard_deviation: None,
                mean_error: None,
                standard_deviation_error: None,
                failed_share: None,
                n_followed: None,
                trust: None,
                sobol_indices: Vec::new(),
                change_from_coarser_grid: None,
                exceedance: Vec::new(),
            };
            fill(i, response)
        };
        self.centre.iter().enumerate().map(start).collect()
    }

    /// The levels of the quantity of a response.
    pub(super) fn levels(&self, response: usize) -> &[f64] {
        let (_, quantity, _) = self.plan.parts(response);
        let name = self.plan.quantities[quantity].to_string();
        self.scene.levels.get(&name).map_or(&[], Vec::as_slice)
    }

    /// With estimates of moments, and of the probabilities of its levels with how they are known.
    pub(super) fn estimated(
        &self,
        i: usize,
        response: Response,
        (mean, variance): (&Estimate, &Estimate),
        (by, chances): (&'static str, impl Iterator<Item = Result<Estimate, Error>>),
    ) -> Result<Response, Error> {
        let mut response = response.with_moments(mean.value, variance.value);
        response.mean_standard_error = error_of(mean);
        response.variance_standard_error = error_of(variance);
        for (&level, chance) in self.levels(i).iter().zip(chances) {
            let chance = chance?;
            let (probability, standard_error) = (chance.value, error_of(&chance));
            response.exceedance.push(Chance { level, probability, standard_error, by });
        }
        Ok(response)
    }

    /// Sobol' indices by parameter; those of a polynomial leave a part of the variance unexplained.
    pub(super) fn shares(
        &self,
        first: &[Estimate],
        total: &[Estimate],
        unexplained: Option<f64>,
    ) -> Vec<Shares> {
        let of = |(random, (first, total)): (&RandomScene, (&Estimate, &Estimate))| Shares {
            parameter: random.parameter.clone(),
            first: first.value,
            first_standard_error: error_of(first),
            total: total.value,
            total_standard_error: error_of(total),
            unexplained,
        };
        self.scene.random.iter().zip(first.iter().zip(total)).map(of).collect()
    }

    /// With the moments of a Taylor series. Its variance by curvature over that by slope is known with the distance to a switch:
    /// where jets were carried through runs.
    pub(super) fn taylor(
        &self,
        i: usize,
        response: Response,
        series: &Series,
        switch: Option<&Switch>,
    ) -> Result<Response, Error> {
        let (mean, variance) = (series.mean(), series.variance());
        let curvature = switch.and_then(|_| series.curvature_ratio());
        let mut response = response.with_moments(mean, variance);
        response.trust = Some(Indicators {
            curvature_ratio: curvature.map(f64::sqrt),
            switch_distance: switch.map(|s| s.at_end).filter(|distance| distance.is_finite()),
            switch_within_two_deviations: switch.is_some_and(|s| s.at_end <= Switch::LIMIT),
        });
        for &level in self.levels(i) {
            let probability = exceedance_of_normal(mean, variance, level)?;
            let (standard_error, by) = (None, "normal_law");
            response.exceedance.push(Chance { level, probability, standard_error, by });
        }
        Ok(response)
    }
}

impl Response {
    pub(super) fn with_moments(self, mean: f64, variance: f64) -> Self {
        let standard_deviation = Some(variance.max(0.0).sqrt());
        Self { mean, variance: Some(variance), standard_deviation, ..self }
    }
}
