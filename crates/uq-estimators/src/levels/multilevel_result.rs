//! Results of a multilevel estimate.

use sde_integrators::Estimate;

use crate::ladder::Pair;

/// Result of a multilevel estimate.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct MultilevelResult {
    /// A result for each target.
    pub targets: Vec<TargetResult>,
    /// The levels, from 0 to the finest one used.
    pub levels: Vec<LevelReport>,
    /// The coarsest level used; those below it do not pay. The finest one where multilevel does not pay at all.
    pub coarsest: usize,
    /// Cost of all samples, the pilot on dropped levels included.
    pub cost: f64,
    /// Cost of plain Monte Carlo on the finest level with the same tolerances, from the measured variance.
    pub single_level_cost: f64,
}

impl MultilevelResult {
    /// Whether more than one level pays.
    #[must_use]
    pub const fn pays(&self) -> bool {
        self.coarsest + 1 < self.levels.len()
    }
}

/// Result for one target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetResult {
    /// The statistic of the finest level, with its standard error; unknown where all samples are equal.
    pub estimate: Estimate,
    /// Bias of the finest level by extrapolation, true value less that of the level, with its standard error; zero by
    /// [`Bias::FinestIsExact`](crate::Bias::FinestIsExact).
    pub bias: Estimate,
    /// The magnitude of the bias, as the largest that the three finest differences predict.
    pub bias_bound: f64,
    /// Error of smoothing the indicator; zero without smoothing.
    pub smoothing: f64,
    /// The weak order that was used, with its standard error if it was fitted; none by [`Bias::FinestIsExact`](crate::Bias::FinestIsExact).
    pub order: Option<Estimate>,
    /// Whether variance and bias each take at most half of the squared tolerance. It fails where the ladder ends.
    pub is_reached: bool,
}

impl TargetResult {
    /// Root of the sum of the squares of standard error, bias bound and error of smoothing; NaN where the first is unknown.
    ///
    /// An interval of 1.96 of it to either side holds the true value in 95 to 97 % of repetitions, as long as the bias is at
    /// most the standard error.
    #[must_use]
    pub fn root_mean_square_error(&self) -> f64 {
        let standard_error = self.estimate.standard_error().unwrap_or(f64::NAN);
        (standard_error.powi(2) + self.bias_bound.powi(2) + self.smoothing.powi(2)).sqrt()
    }
}

/// A level and its difference to the one below.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelReport {
    /// The levels that a sample runs.
    pub pair: Pair,
    /// Number of samples of this pair; of the level alone for the coarsest used.
    pub n_samples: u64,
    /// Cost of a sample.
    pub cost: f64,
    /// Whether the estimate uses the level.
    pub is_used: bool,
    /// Mean of the difference, for each target.
    pub differences: Vec<Estimate>,
    /// Variance of the difference, for each target.
    pub difference_variances: Vec<f64>,
    /// Variance of the level, for each target.
    pub variances: Vec<f64>,
}
