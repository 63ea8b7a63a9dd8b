//! Functions of one normal, with their moments and derivatives.

use sde_integrators::normal_probability;
use serde::Deserialize;

/// A function of a normal; all but the step are one at the origin.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Function {
    /// `exp(a z)`.
    Exponential(f64),
    /// `1 + a z`.
    Linear(f64),
    /// `1 + a z^2`.
    Quadratic(f64),
    /// `exp(-a z^2/2)`.
    Bell(f64),
    /// One above `a`.
    Step(f64),
}

impl Function {
    pub(super) fn at(self, z: f64) -> f64 {
        match self {
            Self::Exponential(a) => (a * z).exp(),
            Self::Linear(a) => 1.0 + a * z,
            Self::Quadratic(a) => 1.0 + a * z * z,
            Self::Bell(a) => (-0.5 * a * z * z).exp(),
            Self::Step(a) => f64::from(u8::from(z > a)),
        }
    }

    /// Means of its first four powers.
    pub(super) fn moments(self) -> [f64; 4] {
        [1.0_f64, 2.0, 3.0, 4.0].map(|k| match self {
            Self::Exponential(a) => (0.5 * k * k * a * a).exp(),
            Self::Linear(a) => {
                1.0 + k * (k - 1.0) / 2.0 * a * a + if k > 3.0 { 3.0 * a.powi(4) } else { 0.0 }
            }
            // Binomial coefficients by the moments 1, 3, 15, 105 of the square of a normal.
            Self::Quadratic(a) => {
                let rising =
                    |n: i32| (0..n).map(|j| (k - f64::from(j)) / f64::from(j + 1)).product();
                let term = |(n, moment): (i32, f64)| -> f64 {
                    let coefficient: f64 = rising(n);
                    coefficient * moment * a.powi(n)
                };
                (0..5).zip([1.0, 1.0, 3.0, 15.0, 105.0]).map(term).sum()
            }
            Self::Bell(a) => (1.0 + k * a).powf(-0.5),
            Self::Step(a) => normal_probability(-a),
        })
    }

    /// Value and three derivatives at the origin.
    pub(super) fn derivatives(self) -> [f64; 4] {
        match self {
            Self::Exponential(a) => [1.0, a, a * a, a * a * a],
            Self::Linear(a) => [1.0, a, 0.0, 0.0],
            Self::Quadratic(a) => [1.0, 0.0, 2.0 * a, 0.0],
            Self::Bell(a) => [1.0, 0.0, -a, 0.0],
            Self::Step(a) => [f64::from(u8::from(a < 0.0)), 0.0, 0.0, 0.0],
        }
    }

    pub(super) fn scaled(self, by: f64) -> Self {
        match self {
            Self::Exponential(a) => Self::Exponential(by * a),
            Self::Linear(a) => Self::Linear(by * a),
            Self::Quadratic(a) => Self::Quadratic(by * a),
            Self::Bell(a) => Self::Bell(by * a),
            Self::Step(a) => Self::Step(a / by),
        }
    }
}
