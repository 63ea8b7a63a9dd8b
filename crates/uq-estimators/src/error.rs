//! Errors, with the value and its limit.

/// Error of an estimator.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A quantity is not finite.
    #[error("{quantity} {index} is {value}, must be finite")]
    NotFinite {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A quantity is not finite or not positive.
    #[error("{quantity} {index} is {value}, must be finite and positive")]
    NotPositive {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A probability is not between zero and one.
    #[error("{quantity} is {value}, must be above 0 and below 1")]
    OutsideOpenInterval {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A range whose ends are not in order.
    #[error("the range is from {low} to {high}; its start must be below its end")]
    EmptyRange {
        /// Its start.
        low: f64,
        /// Its end.
        high: f64,
    },
    /// A number of items is below its minimum.
    #[error("{value} {quantity}, at least {limit} needed")]
    TooFew {
        /// Kind of items.
        quantity: &'static str,
        /// Number given.
        value: u64,
        /// Minimum.
        limit: u64,
    },
    /// A number of items exceeds its maximum.
    #[error("{value} {quantity}, at most {limit} possible")]
    TooMany {
        /// Kind of items.
        quantity: &'static str,
        /// Number required.
        value: f64,
        /// Maximum.
        limit: f64,
    },
    /// The length of a slice does not match that of another.
    #[error("{value} {quantity}, {expected} expected")]
    Length {
        /// Kind of entries.
        quantity: &'static str,
        /// Number given.
        value: usize,
        /// Number required.
        expected: usize,
    },
    /// A number of items is not a power of two.
    #[error("{value} {quantity}, must be a power of two")]
    NotPowerOfTwo {
        /// Kind of items.
        quantity: &'static str,
        /// Number given.
        value: u64,
    },
    /// A target names a response that the model does not have.
    #[error("target {target} is of response {response}, must be below {limit}")]
    NoSuchResponse {
        /// Index of the target.
        target: usize,
        /// Its response.
        response: usize,
        /// Number of responses.
        limit: usize,
    },
    /// A level of a ladder does not cost more than the one below it.
    #[error(
        "a run of level {level} costs {value}, must exceed {limit}, the cost of the level below"
    )]
    CostNotIncreasing {
        /// The level.
        level: usize,
        /// Its cost.
        value: f64,
        /// Cost of the level below.
        limit: f64,
    },
    /// A model could not be run.
    #[error("sample {realisation} of {model} failed: {message}")]
    SampleFailed {
        /// The models that were run.
        model: String,
        /// Lowest sample that failed.
        realisation: u64,
        /// Text of its error.
        message: String,
    },
    /// A response of a sample is not finite.
    #[error("response {response} of sample {realisation} of {model} is {value}, must be finite")]
    NonFiniteSample {
        /// The models that were run.
        model: String,
        /// Lowest sample that failed.
        realisation: u64,
        /// The response.
        response: usize,
        /// Its value.
        value: f64,
    },
    /// A level has another mean as the finer one than as the coarser one of a pair: the sum over the levels is wrong.
    #[error(
        "levels do not nest: target {target} of level {level} differs by {difference:e} between its roles as finer and coarser level, the limit is {limit:e}"
    )]
    NotNested {
        /// Index of the target.
        target: usize,
        /// The level.
        level: usize,
        /// Difference of the means.
        difference: f64,
        /// Three times the sum of their standard errors.
        limit: f64,
    },
    /// The samples that a tolerance needs cost more than the budget.
    #[error("the tolerances need runs of cost {value:e}, the budget is {limit:e}")]
    OverBudget {
        /// Cost of all samples, those already taken included.
        value: f64,
        /// The budget.
        limit: f64,
    },
    /// A block was given that the plan does not ask for.
    #[error("block {block} of {pair} is not wanted: it is unknown or was given before")]
    UnwantedBlock {
        /// The models of the block.
        pair: String,
        /// Its number.
        block: u64,
    },
    /// A block is of another study.
    #[error("a block is of another study: its {field} is {value}, that of the study is {expected}")]
    ForeignBlock {
        /// The first field that differs.
        field: &'static str,
        /// Value in the block.
        value: String,
        /// Value in the study.
        expected: String,
    },
    /// Blocks of the plan are missing.
    #[error("{missing} blocks of the plan are missing, the first is block {block} of {pair}")]
    MissingBlocks {
        /// Number of missing blocks.
        missing: usize,
        /// Models of the first.
        pair: String,
        /// Its number.
        block: u64,
    },
    /// A response does not vary, so its sensitivities are undefined.
    #[error(
        "response {response} has a variance of {value:e}, must exceed {limit:e}: it does not vary"
    )]
    NoVariance {
        /// Index of the response.
        response: usize,
        /// Its variance.
        value: f64,
        /// Roundoff level.
        limit: f64,
    },
    /// The level of a rare event is below the response at the origin.
    #[error(
        "the response at the origin is {value}, above the level {level}: the event is not rare, so count it in plain samples"
    )]
    NotRare {
        /// The response.
        value: f64,
        /// The level.
        level: f64,
    },
    /// The search for a design point ended elsewhere.
    #[error(
        "no design point after {steps} steps: reached index {reliability_index}, {distance:e} deviations from the linearised \
         surface, {misalignment:e} of the point across the gradient; start elsewhere, or use subset simulation"
    )]
    NoDesignPoint {
        /// Number of steps.
        steps: usize,
        /// Length of the last point.
        reliability_index: f64,
        /// Its distance to the linearised surface; infinite or NaN where the gradient vanishes.
        distance: f64,
        /// Part of it across the gradient.
        misalignment: f64,
    },
    /// The lines of a rare event have too uneven probabilities for a standard error.
    #[error(
        "{n_lines} lines have an effective number of {effective:.3} (at least {fewest}) and a largest share of {share:.3} in \
         the sum (at most {most}): take more lines, another design point, or subset simulation"
    )]
    UnevenWeights {
        /// Number of lines.
        n_lines: u64,
        /// Effective number.
        effective: f64,
        /// Its minimum.
        fewest: f64,
        /// Share of the largest probability in the sum.
        share: f64,
        /// Its maximum.
        most: f64,
    },
    /// Subset simulation failed.
    #[error(transparent)]
    Subset(sde_integrators::Error),
}

pub(crate) fn require_positive(
    quantity: &'static str,
    index: usize,
    value: f64,
) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::NotPositive { quantity, index, value })
    }
}

pub(crate) fn require_finite(
    quantity: &'static str,
    index: usize,
    value: f64,
) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { quantity, index, value }) }
}

pub(crate) fn require_at_least(
    quantity: &'static str,
    value: u64,
    limit: u64,
) -> Result<(), Error> {
    if value >= limit { Ok(()) } else { Err(Error::TooFew { quantity, value, limit }) }
}

/// The first response of a sample that is not finite.
pub(crate) fn require_finite_responses(
    model: &dyn std::fmt::Display,
    realisation: u64,
    responses: &[f64],
) -> Result<(), Error> {
    match responses.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(response) => {
            let (model, value) = (model.to_string(), responses[response]);
            Err(Error::NonFiniteSample { model, realisation, response, value })
        }
    }
}
