//! A measured value with its standard error, and a reference value with its own.

/// A value computed by a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The value.
    pub value: f64,
    /// Its standard error, if it has one.
    pub standard_error: Option<f64>,
}

impl Measured {
    /// A value of a deterministic run.
    #[must_use]
    pub const fn exact(value: f64) -> Self {
        Self { value, standard_error: None }
    }

    /// A value with its standard error.
    #[must_use]
    pub const fn sampled(value: f64, standard_error: f64) -> Self {
        Self { value, standard_error: Some(standard_error) }
    }
}

impl From<f64> for Measured {
    fn from(value: f64) -> Self {
        Self::exact(value)
    }
}

/// A reference value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// The value.
    pub value: f64,
    /// Its error (one sigma, or a bound), if it has one.
    pub error: Option<f64>,
}

impl Reference {
    /// A closed form.
    #[must_use]
    pub const fn exact(value: f64) -> Self {
        Self { value, error: None }
    }

    /// A reference known up to an error.
    #[must_use]
    pub const fn uncertain(value: f64, error: f64) -> Self {
        Self { value, error: Some(error) }
    }
}

impl From<f64> for Reference {
    fn from(value: f64) -> Self {
        Self::exact(value)
    }
}
