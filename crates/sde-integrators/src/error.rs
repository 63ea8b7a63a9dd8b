//! Errors, with the value and its limit.

/// Error of a step. Explicit methods never fail; the caller checks their results.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The solver of an implicit equation did not converge.
    #[error("residual {residual:e} after {iterations} iterations, the limit is {limit:e}")]
    NotConverged {
        /// Number of iterations.
        iterations: usize,
        /// The last correction of the state.
        residual: f64,
        /// Largest accepted correction.
        limit: f64,
    },
    /// The step length exceeds the limit of the method.
    #[error("step length {dt} exceeds its limit {limit}")]
    StepTooLong {
        /// Requested step length.
        dt: f64,
        /// Largest step length.
        limit: f64,
    },
    /// A linear system within an implicit step is singular.
    #[error("pivot {pivot:e} in row {row}, must exceed {limit:e}")]
    Singular {
        /// Row where the elimination failed.
        row: usize,
        /// Pivot in that row.
        pivot: f64,
        /// Roundoff level that its magnitude must exceed.
        limit: f64,
    },
}

/// Error of a distribution, an estimate or an ensemble.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
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
    /// A quantity is not finite or not positive.
    #[error("{quantity} is {value}, must be finite and positive")]
    NotPositive {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A quantity is NaN.
    #[error("the {quantity} is NaN, must be a number")]
    NotANumber {
        /// Name of the quantity.
        quantity: &'static str,
    },
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
    /// A quantity is out of range.
    #[error("{quantity} is {value}, must lie in {from}..={to}")]
    OutOfRange {
        /// Name of the quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// Lower limit.
        from: f64,
        /// Upper limit.
        to: f64,
    },
    /// The covariance of a field's noise is not symmetric.
    #[error(
        "covariance of the noise differs by {difference:e} between ({row}, {column}) and ({column}, {row}), the limit is {limit:e}"
    )]
    CovarianceNotSymmetric {
        /// The row of the entry.
        row: usize,
        /// The column of the entry.
        column: usize,
        /// Difference between the two entries.
        difference: f64,
        /// Largest admissible difference.
        limit: f64,
    },
    /// The covariance of a field's noise is not positive definite.
    #[error(
        "covariance of the noise is not positive definite: the pivot of row {row} is not positive"
    )]
    CovarianceNotPositiveDefinite {
        /// Row where the factorisation failed.
        row: usize,
    },
    /// The starts of compressed rows are not in order.
    #[error(
        "compressed row {row} starts at entry {start}, must lie in {from}..={to} and the last at the end"
    )]
    SparseRow {
        /// The row.
        row: usize,
        /// Its start.
        start: usize,
        /// Start of the previous row.
        from: usize,
        /// Largest possible start.
        to: usize,
    },
    /// A compressed row has an entry in a nonexistent column.
    #[error("entry {entry} lies in column {column}, of {n_motions}")]
    SparseColumn {
        /// The entry.
        entry: usize,
        /// Its column.
        column: usize,
        /// Number of columns.
        n_motions: usize,
    },
    /// The weights of a mixture do not sum to one.
    #[error("weights of the components sum to {sum}, must be 1 within {tolerance:e}")]
    WeightSum {
        /// Their sum.
        sum: f64,
        /// Largest admissible deviation from 1.
        tolerance: f64,
    },
    /// A covariance is not symmetric.
    #[error(
        "covariance of component {component} differs by {difference:e} between ({row}, {column}) and ({column}, {row}), the limit is {limit:e}"
    )]
    NotSymmetric {
        /// Component of the mixture.
        component: usize,
        /// The row of the entry.
        row: usize,
        /// The column of the entry.
        column: usize,
        /// Difference between the two entries.
        difference: f64,
        /// Largest admissible difference.
        limit: f64,
    },
    /// A covariance is not positive definite.
    #[error(
        "covariance of component {component} is not positive definite: pivot {pivot:e} in row {row}, must exceed {limit:e}"
    )]
    NotPositiveDefinite {
        /// Component of the mixture.
        component: usize,
        /// Row where the factorisation failed.
        row: usize,
        /// Pivot in that row: the variance of this state given those before it.
        pivot: f64,
        /// Roundoff level that it must exceed.
        limit: f64,
    },
    /// An output time is negative, not increasing, or not finite.
    #[error("output time {index} is {value}, must be finite and {relation} {limit}")]
    OutputTime {
        /// Index of the output time.
        index: usize,
        /// Its value.
        value: f64,
        /// Required relation: "at least" or "above".
        relation: &'static str,
        /// Limit of the relation.
        limit: f64,
    },
    /// A method failed in a step.
    #[error("path {realisation}, step {step}, time {t}: no step was possible")]
    Step {
        /// Lowest realisation that failed.
        realisation: u64,
        /// The step, counted from 0.
        step: u64,
        /// The time at its start.
        t: f64,
        /// Cause.
        source: StepError,
    },
    /// The state of a path is not finite.
    #[error(
        "path {realisation} is non-finite after {steps} steps, at time {t}: state {component} is {value}"
    )]
    NonFiniteState {
        /// Lowest realisation that failed.
        realisation: u64,
        /// Number of steps before the failure; 0 if the initial distribution caused it.
        steps: u64,
        /// The time after them.
        t: f64,
        /// Index of the component.
        component: usize,
        /// Its value.
        value: f64,
    },
    /// An observable of a finite state is not finite.
    #[error("observable {observable} of path {realisation} at time {t} is {value}, must be finite")]
    NonFiniteObservable {
        /// Index of the observable.
        observable: usize,
        /// Lowest realisation that failed.
        realisation: u64,
        /// The output time.
        t: f64,
        /// Its value.
        value: f64,
    },
    /// Some paths of a study failed, so the remaining ones are no sample of the distribution.
    #[error("{n_failed} of {n_paths} paths failed, the first of them {realisation}: {message}")]
    PathsFailed {
        /// Number of failed paths.
        n_failed: u64,
        /// Number of paths.
        n_paths: u64,
        /// Lowest realisation that failed.
        realisation: u64,
        /// Error text.
        message: String,
    },
    /// The shard number is out of range.
    #[error("shard {shard} of {n_shards}: they are counted from 0")]
    NoSuchShard {
        /// Requested number.
        shard: u64,
        /// Number of shards.
        n_shards: u64,
    },
    /// A shard is missing.
    #[error("shard {shard} of {n_shards} is missing")]
    MissingShard {
        /// Lowest missing shard.
        shard: u64,
        /// Number of shards.
        n_shards: u64,
    },
    /// A shard was given twice.
    #[error("shard {shard} was given twice")]
    DoubledShard {
        /// Number of the shard.
        shard: u64,
    },
    /// A shard belongs to another study than the first shard.
    #[error(
        "shard {shard} is of another study: its {field} is {value}, that of the first is {expected}"
    )]
    ForeignShard {
        /// Number of the shard.
        shard: u64,
        /// The first field that differs.
        field: &'static str,
        /// Value in the shard.
        value: String,
        /// Value in the first shard.
        expected: String,
    },
    /// A record has the wrong number of blocks for its shard.
    #[error(
        "shard {shard} holds {n_blocks} blocks, must hold {expected}, each with all its results"
    )]
    BrokenShard {
        /// Number of the shard.
        shard: u64,
        /// Number of blocks in the record.
        n_blocks: u64,
        /// Required number.
        expected: u64,
    },
    /// A block of a record has impossible contents.
    #[error(
        "shard {shard}: block {block} of it holds more paths than a block has, or other results"
    )]
    BrokenBlock {
        /// Number of the shard.
        shard: u64,
        /// Index of the block.
        block: usize,
    },
    /// Mean or variance of a sample exceeds the range of a double.
    #[error("a sample of mean {mean} and variance {variance}, both must be finite")]
    NonFiniteSample {
        /// The mean.
        mean: f64,
        /// The variance.
        variance: f64,
    },
    /// The state has no such component.
    #[error("component {component} of the state, must be below {limit}")]
    NoSuchComponent {
        /// Requested component.
        component: usize,
        /// Number of components.
        limit: usize,
    },
    /// The rotation of an oscillator in a step is too large to determine the arc between its ends.
    #[error("a step turns the oscillator by {angle} rad, must be below {limit}")]
    ArcTooLong {
        /// Rotation angle.
        angle: f64,
        /// Half a turn.
        limit: f64,
    },
    /// A slice has the wrong length.
    #[error("{value} {quantity}, must be {expected}")]
    WrongLength {
        /// Kind of entries.
        quantity: &'static str,
        /// Number given.
        value: usize,
        /// Number required.
        expected: usize,
    },
    /// Subset simulation did not reach its threshold.
    #[error("threshold {threshold} not reached after {limit} levels")]
    TooManyLevels {
        /// Number of levels.
        limit: u32,
        /// The threshold.
        threshold: f64,
    },
}
