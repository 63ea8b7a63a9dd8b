//! Numbers with first derivatives along eight directions.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::numbers::jet::{LANES, lanes, pair};
use crate::numbers::real::Real;
use crate::numbers::scalar::Scalar;
use crate::one_value;

/// A value with first derivatives along up to eight directions: a [`Jet`](crate::Jet) without second derivatives.
///
/// $$ \left( y, \; \frac{d y}{d t_k} \right)_{k = 1..8} $$
///
/// It suffices for a first-order variance, at a fraction of the cost. The mean then lacks its second-order term, and
/// the Taylor series has no trust indicators. Value and derivatives are bitwise identical to those of the jet.
///
/// ```
/// use perturbation_moments::{Gradient, Scalar};
///
/// let (x, y) = (Gradient::variable(3.0, 0), Gradient::variable(2.0, 1));
/// let z = x * y.powi(2);
/// assert_eq!((z.value, z.first[0], z.first[1]), (12.0, 4.0, 12.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(16))]
pub struct Gradient {
    /// `dy/dt_k`.
    pub first: [f64; LANES],
    /// `y`.
    pub value: f64,
}

impl Gradient {
    /// Input number `lane` of a response; for `lane >= 8` the number is a constant.
    #[must_use]
    #[inline(always)]
    pub fn variable(value: f64, lane: usize) -> Self {
        Self { first: std::array::from_fn(|k| if k == lane { 1.0 } else { 0.0 }), value }
    }

    /// A function of this number, from its value and its derivative.
    #[inline(always)]
    fn compose(self, value: f64, derivative: f64) -> Self {
        Self { first: lanes(|k| derivative * pair(&self.first, k)), value }
    }
}

impl Real for Gradient {
    one_value!(1);

    #[inline(always)]
    fn squared(self) -> Self {
        self.compose(self.value * self.value, self.value + self.value)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let y = 1.0 / self.value;
        self.compose(y, -(y * y))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let y = self.value.sqrt();
        self.compose(y, 0.5 / y)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        let y = simd_lanes::exp(self.value);
        self.compose(y, y)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.compose(simd_lanes::ln(self.value), 1.0 / self.value)
    }
}

impl Scalar for Gradient {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self { first: [0.0; LANES], value }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn exp_scaled(self, factor: f64) -> Self {
        let y = simd_lanes::exp(self.value * factor);
        self.compose(y, factor * y)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.compose(sin, cos)
    }

    #[inline(always)]
    fn cos(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.compose(cos, -sin)
    }

    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        let p = f64::from(exponent);
        let y = self.value.powi(exponent);
        let derivative = match exponent {
            0 => 0.0,
            ..0 => p * y * (1.0 / self.value),
            _ => p * self.value.powi(exponent - 1),
        };
        self.compose(y, derivative)
    }

    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        let y = self.value.powf(exponent);
        self.compose(y, exponent * y * (1.0 / self.value))
    }
}

impl Neg for Gradient {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { first: lanes(|k| -pair(&self.first, k)), value: -self.value }
    }
}

impl Add for Gradient {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let first = lanes(|k| pair(&self.first, k) + pair(&other.first, k));
        Self { first, value: self.value + other.value }
    }
}

impl Sub for Gradient {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let first = lanes(|k| pair(&self.first, k) - pair(&other.first, k));
        Self { first, value: self.value - other.value }
    }
}

#[allow(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
impl Mul for Gradient {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        let first = lanes(|k| a * pair(&other.first, k) + pair(&self.first, k) * b);
        Self { first, value: a * b }
    }
}

impl Div for Gradient {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let (value, inverse) = (self.value / other.value, 1.0 / other.value);
        let first = lanes(|k| (pair(&self.first, k) - value * pair(&other.first, k)) * inverse);
        Self { first, value }
    }
}

impl Add<f64> for Gradient {
    type Output = Self;
    #[inline(always)]
    fn add(self, constant: f64) -> Self {
        Self { value: self.value + constant, ..self }
    }
}

impl Sub<f64> for Gradient {
    type Output = Self;
    #[inline(always)]
    fn sub(self, constant: f64) -> Self {
        Self { value: self.value - constant, ..self }
    }
}

impl Mul<f64> for Gradient {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.compose(self.value * factor, factor)
    }
}

impl Div<f64> for Gradient {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        self.compose(self.value / divisor, 1.0 / divisor)
    }
}
