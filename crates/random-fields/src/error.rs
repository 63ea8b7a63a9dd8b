//! Errors, with the value and its limit.

/// Error of a random field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is NaN or infinite.
    #[error("{name} is {value}; it must be finite")]
    NotFinite {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A parameter is not positive.
    #[error("{name} is {value}; it must be greater than 0 and finite")]
    NotPositive {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A parameter lies outside its interval.
    #[error("{name} is {value}; it must lie between {from} and {to}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Lower limit.
        from: f64,
        /// Upper limit.
        to: f64,
    },
    /// A correlation length beyond the size of the body by so much that the field is one number.
    #[error(
        "the correlation length {length} is more than {limit}, 1000 times the size of the body: the field would be one \
         random variable; use one, or give the length in the units of the positions"
    )]
    LengthBeyondBody {
        /// The correlation length.
        length: f64,
        /// Its limit.
        limit: f64,
    },
    /// Axes of a correlation that are not orthonormal.
    #[error(
        "the axes {first} and {second} of the correlation have the inner product {value}; it must be {expected} within \
         {limit:e}: give unit vectors at right angles"
    )]
    NotOrthonormal {
        /// One axis.
        first: usize,
        /// The other, or the same.
        second: usize,
        /// Their inner product.
        value: f64,
        /// What it must be.
        expected: f64,
        /// By how much it may deviate.
        limit: f64,
    },
    /// A coordinate of a point that cannot be used.
    #[error("{name} of point {point} is {value}; it must be {must}")]
    Point {
        /// The number.
        name: &'static str,
        /// Index of the point.
        point: usize,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A point outside the box on which eigenfunctions are known.
    #[error(
        "point {point} has the coordinate {value} along axis {axis}; the expansion holds from {from} to {to}: make the \
         box of the field larger, or cover the body with points"
    )]
    OutsideBox {
        /// Index of the point.
        point: usize,
        /// The axis of the correlation.
        axis: usize,
        /// The coordinate along it.
        value: f64,
        /// Lower end of the box.
        from: f64,
        /// Upper end of the box.
        to: f64,
    },
    /// A field without points.
    #[error("a random field needs at least one point")]
    NoPoints,
    /// A slice of a wrong length.
    #[error("{name} has {value} entries; there must be {expected}")]
    Length {
        /// The slice.
        name: &'static str,
        /// Its length.
        value: usize,
        /// The length that it must have.
        expected: usize,
    },
    /// A correlation whose eigenfunctions on a box are not known.
    #[error(
        "the eigenfunctions of {correlation} on a box are not known in closed form: take the exponential function in one \
         dimension or a product of exponentials, or cover the body with points"
    )]
    NoEigenfunctions {
        /// The correlation.
        correlation: String,
    },
    /// An expansion that would need more terms than are possible.
    #[error(
        "{n_terms} terms hold {reached} of the variance, {asked} is asked: take a longer correlation length or a smaller \
         share, or draw the field on a lattice by circulant embedding"
    )]
    TooManyTerms {
        /// Most terms that are possible.
        n_terms: usize,
        /// Share of the variance that they hold.
        reached: f64,
        /// Share that was asked for.
        asked: f64,
    },
    /// More terms than the covariance of the points has.
    #[error(
        "{asked} terms are asked; the covariance of {n_points} points has {available} above roundoff"
    )]
    TooFewPoints {
        /// Terms asked for.
        asked: usize,
        /// Terms that there are.
        available: usize,
        /// Number of points.
        n_points: usize,
    },
    /// More points than a lattice may have.
    #[error("{value} points; at most {limit} are possible")]
    TooManyPoints {
        /// Number of points.
        value: usize,
        /// Its limit.
        limit: usize,
    },
    /// A low-rank factor that would not fit into memory.
    #[error(
        "{n_columns} columns of {n_nodes} nodes do not reach the tolerance, and more than {limit} numbers are not kept: \
         take a longer correlation length, a larger tolerance or a lattice"
    )]
    TooManyColumns {
        /// Columns so far.
        n_columns: usize,
        /// Nodes.
        n_nodes: usize,
        /// Most numbers that are kept.
        limit: usize,
    },
    /// A matrix that is not a covariance.
    #[error("the matrix is not positive definite: the pivot of row {row} is not above {limit:e}")]
    NotPositiveDefinite {
        /// The row.
        row: usize,
        /// What the pivot must exceed: roundoff.
        limit: f64,
    },
    /// The eigenvalue iteration did not converge.
    #[error("eigenvalue {index} was not found in {limit} iterations")]
    NoConvergence {
        /// Index of the eigenvalue.
        index: usize,
        /// Most iterations.
        limit: usize,
    },
    /// A correlation without a circulant embedding on a lattice of a reasonable size.
    #[error(
        "the correlation of length {length} has no circulant embedding on up to {points} points: its most negative \
         eigenvalue is {eigenvalue:e} and all of them together would change the covariance by {change:e}, more than \
         {limit:e}; take Wendland's function, a pivoted factor or a shorter length"
    )]
    NoEmbedding {
        /// The correlation length.
        length: f64,
        /// Number of points of the largest embedding that was tried.
        points: usize,
        /// The most negative eigenvalue; that of white noise is 1.
        eigenvalue: f64,
        /// Change of the covariance without the negative eigenvalues.
        change: f64,
        /// Largest change allowed.
        limit: f64,
    },
    /// A normal distribution of a positive quantity that reaches below zero.
    #[error(
        "a normal field of mean {mean} and standard deviation {standard_deviation} lies below 0 with the probability \
         {probability:e}, more than {limit:e}: take a lognormal or a Weibull field"
    )]
    NegativeField {
        /// The mean.
        mean: f64,
        /// The standard deviation.
        standard_deviation: f64,
        /// Probability of a negative value.
        probability: f64,
        /// Its limit.
        limit: f64,
    },
    /// A uniform distribution that reaches zero or below, of a positive quantity.
    #[error("a uniform field of a positive quantity begins at {low}; it must begin above 0")]
    UniformBelowZero {
        /// Lower end.
        low: f64,
    },
    /// Ends of an interval in the wrong order.
    #[error("{name} ends at {high}, not above its begin {low}")]
    EmptyInterval {
        /// The interval.
        name: &'static str,
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
    },
    /// A correlation below the least that a translation can have.
    #[error(
        "a correlation of {value} of the values is asked; this distribution can have {limit} at the least, for normals \
         of correlation -1"
    )]
    CorrelationBelowLeast {
        /// Correlation asked for.
        value: f64,
        /// The least that is possible.
        limit: f64,
    },
    /// Two exact measurements at one place.
    #[error(
        "measurements {first} and {second} are at one place with the values {first_value} and {second_value}, both without \
         an error: remove one of them or give their standard deviation"
    )]
    CoincidentMeasurements {
        /// Index of one.
        first: usize,
        /// Index of the other.
        second: usize,
        /// Value of one.
        first_value: f64,
        /// Value of the other.
        second_value: f64,
    },
    /// Measurements that the terms of the field cannot meet.
    #[error(
        "measurement {measurement} follows from those before it within roundoff: of its variance {value:e} is left, {limit:e} is \
         needed. {n_terms} terms are kept: keep more, give the measurements a standard deviation, or remove it"
    )]
    DependentMeasurement {
        /// Index of the measurement.
        measurement: usize,
        /// Variance left after conditioning on those before it.
        value: f64,
        /// Its limit.
        limit: f64,
        /// Number of terms of the field.
        n_terms: usize,
    },
    /// An error of the noise.
    #[error(transparent)]
    Noise(#[from] sde_integrators::Error),
}

pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() { Ok(()) } else { Err(Error::NotFinite { name, value }) }
}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(Error::NotPositive { name, value }) }
}

pub(crate) fn between(name: &'static str, value: f64, from: f64, to: f64) -> Result<(), Error> {
    if value > from && value < to {
        Ok(())
    } else {
        Err(Error::OutOfRange { name, value, from, to })
    }
}

pub(crate) fn same_length(name: &'static str, value: usize, expected: usize) -> Result<(), Error> {
    if value == expected { Ok(()) } else { Err(Error::Length { name, value, expected }) }
}
