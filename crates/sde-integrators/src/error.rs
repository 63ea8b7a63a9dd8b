//! What can go wrong, with the value and its limit.

/// Why a step could not be taken. Explicit methods never fail; what they return is checked by the caller.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// An implicit equation was not solved.
    #[error("residual {residual:e} after {iterations} iterations, the limit is {limit:e}")]
    NotConverged {
        /// How many iterations were made.
        iterations: usize,
        /// What was left: the last correction of the state.
        residual: f64,
        /// What would have been accepted.
        limit: f64,
    },
    /// The method cannot take a step of this length.
    #[error("step length {dt} exceeds its limit {limit}")]
    StepTooLong {
        /// The step length asked for.
        dt: f64,
        /// The largest one.
        limit: f64,
    },
    /// A linear system within an implicit step has no unique solution.
    #[error("pivot {pivot:e} in row {row}, must exceed {limit:e}")]
    Singular {
        /// The row where the elimination failed.
        row: usize,
        /// The pivot found there.
        pivot: f64,
        /// What its size must exceed: roundoff.
        limit: f64,
    },
    /// The operator of an implicit step does not fit the field.
    #[error("the operator has {value} unknowns, the field {expected}")]
    OperatorLength {
        /// Those of the operator.
        value: usize,
        /// Those of the field.
        expected: usize,
    },
    /// The operator of an implicit step is not symmetric negative semidefinite.
    #[error(
        "1 - theta h A has a curvature of {curvature:e} in a direction of length 1, must be positive"
    )]
    OperatorIndefinite {
        /// The curvature found.
        curvature: f64,
    },
}

/// Why a law, an estimate or an ensemble could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There are fewer of something than its least number.
    #[error("{value} {quantity}, at least {limit} needed")]
    TooFew {
        /// Of what.
        quantity: &'static str,
        /// How many there are.
        value: u64,
        /// How many there must be.
        limit: u64,
    },
    /// There are more of something than can be.
    #[error("{value} {quantity}, at most {limit} possible")]
    TooMany {
        /// Of what.
        quantity: &'static str,
        /// How many there would be.
        value: f64,
        /// How many there may be.
        limit: f64,
    },
    /// A quantity is infinite, not a number, or not above zero.
    #[error("{quantity} is {value}, must be finite and positive")]
    NotPositive {
        /// Which one.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A quantity is not a number.
    #[error("the {quantity} is NaN, must be a number")]
    NotANumber {
        /// Which one.
        quantity: &'static str,
    },
    /// A quantity is infinite or not a number.
    #[error("{quantity} {index} is {value}, must be finite")]
    NotFinite {
        /// Which one.
        quantity: &'static str,
        /// Its place among its like.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A quantity lies outside its range.
    #[error("{quantity} is {value}, must lie in {from}..={to}")]
    OutOfRange {
        /// Which one.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// The least value.
        from: f64,
        /// The largest value.
        to: f64,
    },
    /// A slice has not the length that belongs to another.
    #[error("{value} {quantity}, {expected} expected")]
    Length {
        /// Of what.
        quantity: &'static str,
        /// How many there are.
        value: usize,
        /// How many there must be.
        expected: usize,
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
        /// By how much the two entries differ.
        difference: f64,
        /// By how much they may differ.
        limit: f64,
    },
    /// The covariance of a field's noise is not positive definite.
    #[error(
        "covariance of the noise is not positive definite: the pivot of row {row} is not positive"
    )]
    CovarianceNotPositiveDefinite {
        /// The row where the factorisation failed.
        row: usize,
    },
    /// The start of a compressed row is out of order.
    #[error(
        "compressed row {row} starts at entry {start}, must lie in {from}..={to} and the last at the end"
    )]
    SparseRow {
        /// Which row.
        row: usize,
        /// Where it starts.
        start: usize,
        /// The start of the row before it.
        from: usize,
        /// The largest start.
        to: usize,
    },
    /// A compressed row has an entry in a column that does not exist.
    #[error("entry {entry} lies in column {column}, of {n_motions}")]
    SparseColumn {
        /// Which entry.
        entry: usize,
        /// Its column.
        column: usize,
        /// How many columns there are.
        n_motions: usize,
    },
    /// The weights of a mixture do not add up to one.
    #[error("weights of the components sum to {sum}, must be 1 within {tolerance:e}")]
    WeightSum {
        /// Their sum.
        sum: f64,
        /// How far it may be from 1.
        tolerance: f64,
    },
    /// A covariance is not symmetric.
    #[error(
        "covariance of component {component} differs by {difference:e} between ({row}, {column}) and ({column}, {row}), the limit is {limit:e}"
    )]
    NotSymmetric {
        /// Which component of the mixture.
        component: usize,
        /// The row of the entry.
        row: usize,
        /// The column of the entry.
        column: usize,
        /// By how much the two entries differ.
        difference: f64,
        /// By how much they may differ.
        limit: f64,
    },
    /// A covariance is not positive definite.
    #[error(
        "covariance of component {component} is not positive definite: pivot {pivot:e} in row {row}, must exceed {limit:e}"
    )]
    NotPositiveDefinite {
        /// Which component of the mixture.
        component: usize,
        /// The row where the factorisation failed.
        row: usize,
        /// The pivot found there: the variance of this state given those before it.
        pivot: f64,
        /// What it must exceed: roundoff.
        limit: f64,
    },
    /// An output time is before the start, not after the one before it, or not a number.
    #[error("output time {index} is {value}, must be finite and {relation} {limit}")]
    OutputTime {
        /// Which one.
        index: usize,
        /// Its value.
        value: f64,
        /// How it must compare: "at least" or "above".
        relation: &'static str,
        /// With what.
        limit: f64,
    },
    /// A method could not take a step.
    #[error("path {realisation}, step {step}, time {t}: no step was possible")]
    Step {
        /// The realisation with the lowest number that failed.
        realisation: u64,
        /// The step, counted from 0.
        step: u64,
        /// The time at its start.
        t: f64,
        /// Why.
        source: StepError,
    },
    /// The shortest step of an adaptive path is too long for its tolerances.
    #[error(
        "path {realisation}, time {t}: the shortest step {dt:e} has {error:e} times the error let pass"
    )]
    StepUnderflow {
        /// The realisation.
        realisation: u64,
        /// The time at the start of the step.
        t: f64,
        /// Its length.
        dt: f64,
        /// The estimate of its error, over what is let pass.
        error: f64,
    },
    /// A path left the numbers.
    #[error(
        "path {realisation} is non-finite after {steps} steps, at time {t}: state {component} is {value}"
    )]
    NonFiniteState {
        /// The realisation with the lowest number that failed.
        realisation: u64,
        /// How many steps it had taken; none where the initial law is to blame.
        steps: u64,
        /// The time after them.
        t: f64,
        /// Which component of the state.
        component: usize,
        /// Its value.
        value: f64,
    },
    /// An observable of a finite state is not finite.
    #[error("observable {observable} of path {realisation} at time {t} is {value}, must be finite")]
    NonFiniteObservable {
        /// Which observable.
        observable: usize,
        /// The realisation with the lowest number that failed.
        realisation: u64,
        /// The output time.
        t: f64,
        /// Its value.
        value: f64,
    },
    /// A number must be even.
    #[error("{value} {quantity}, must be even")]
    NotEven {
        /// Of what.
        quantity: &'static str,
        /// How many there are.
        value: u64,
    },
    /// Some paths of a study failed: those that are left are not a sample of the law.
    #[error("{n_failed} of {n_paths} paths failed, the first of them {realisation}: {message}")]
    PathsFailed {
        /// How many failed.
        n_failed: u64,
        /// Of how many.
        n_paths: u64,
        /// The lowest realisation that failed.
        realisation: u64,
        /// Why it failed.
        message: String,
    },
    /// There is no shard of this number.
    #[error("shard {shard} of {n_shards}: they are counted from 0")]
    NoSuchShard {
        /// The number asked for.
        shard: u64,
        /// How many shards there are.
        n_shards: u64,
    },
    /// A shard was not given.
    #[error("shard {shard} of {n_shards} is missing")]
    MissingShard {
        /// Which one: the lowest that is missing.
        shard: u64,
        /// How many there must be.
        n_shards: u64,
    },
    /// A shard was given twice.
    #[error("shard {shard} was given twice")]
    DoubledShard {
        /// Which one.
        shard: u64,
    },
    /// A shard belongs to another study than the first one given.
    #[error(
        "shard {shard} is of another study: its {field} is {value}, that of the first is {expected}"
    )]
    ForeignShard {
        /// Which one.
        shard: u64,
        /// What differs first.
        field: &'static str,
        /// What the shard has.
        value: String,
        /// What the first has.
        expected: String,
    },
    /// A record does not hold the blocks of its shard.
    #[error(
        "shard {shard} holds {n_blocks} blocks, must hold {expected}, each with all its results"
    )]
    BrokenShard {
        /// Which one.
        shard: u64,
        /// How many blocks it holds.
        n_blocks: u64,
        /// How many it must hold.
        expected: u64,
    },
    /// A block of a record holds what no block of its study can.
    #[error(
        "shard {shard}: block {block} of it holds more paths than a block has, or other results"
    )]
    BrokenBlock {
        /// Which shard.
        shard: u64,
        /// Which block of it, from 0.
        block: usize,
    },
    /// A sample whose mean or variance is beyond the range of a double.
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
        /// The one asked for.
        component: usize,
        /// How many there are.
        limit: usize,
    },
    /// A step turns an oscillator too far for the arc between its ends to be known.
    #[error("a step turns the oscillator by {angle} rad, must be below {limit}")]
    ArcTooLong {
        /// By how much.
        angle: f64,
        /// Half a turn.
        limit: f64,
    },
    /// A slice has another length than it must have.
    #[error("{value} {quantity}, must be {expected}")]
    WrongLength {
        /// Of what.
        quantity: &'static str,
        /// How many there are.
        value: usize,
        /// How many there must be.
        expected: usize,
    },
    /// The iteration found no design point.
    #[error(
        "no design point after {iterations} iterations; square of the gradient: {gradient_square:e}"
    )]
    NoDesignPoint {
        /// How many iterations were made.
        iterations: usize,
        /// Zero where the response does not depend on the noise, not a number where the iterations ran out.
        gradient_square: f64,
    },
    /// Subset simulation did not reach its threshold.
    #[error("threshold {threshold} not reached after {limit} levels")]
    TooManyLevels {
        /// How many levels were tried.
        limit: u32,
        /// The threshold.
        threshold: f64,
    },
}
