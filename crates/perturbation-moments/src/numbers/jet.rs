//! Numbers with derivatives along eight directions.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::{Add, Div, Mul, Neg, Sub};

use wide::f64x2;

use crate::numbers::real::Real;
use crate::numbers::scalar::Scalar;
use crate::one_value;

/// Number of directions of a [`Jet`].
pub const LANES: usize = 8;

/// A value with its first and second derivatives along up to eight directions.
///
/// $$ \left( y, \; \frac{d y}{d t_k}, \; \frac{d^2 y}{d t_k^2} \right)_{k = 1..8}, \qquad x(t) = x_0 + \sum_k t_k v_k $$
///
/// Each direction is a separate curve, so mixed derivatives are not carried. They follow from directions that mix
/// inputs: `q(u + v) = q(u) + q(v) + 2 u^T H v`.
///
/// An operation costs one evaluation on the value (`exp`, `ln`, `powf` are evaluated once, not once per lane) and a
/// few lane-wise multiplications. Everything is `#[inline(always)]`: inside the closure of `simd_lanes::dispatch` it is
/// compiled for the widest registers of the machine. No operations are fused, so all machines give bitwise identical
/// results where the functions of the value do.
///
/// Domain: that of the same operation on the value. `powf`, `ln` and `sqrt` of zero have infinite derivatives.
///
/// ```
/// use perturbation_moments::{Jet, Real};
///
/// // y = x1 exp(x2) at (3, 0): dy/dx1 = 1, dy/dx2 = 3, and along (1, 1) the second derivative is 2 + 3.
/// let x1 = Jet::new(3.0, [1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// let x2 = Jet::new(0.0, [0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// let y = x1 * x2.exp();
/// assert_eq!((y.value, y.first[0], y.first[1], y.second[2]), (3.0, 1.0, 3.0, 5.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(16))]
pub struct Jet {
    /// `dy/dt_k`.
    pub first: [f64; LANES],
    /// `d^2y/dt_k^2`.
    pub second: [f64; LANES],
    /// `y`.
    pub value: f64,
}

/// Applies one formula to every lane, two at a time: `formula(k)` computes lanes `2 k` and `2 k + 1`.
///
/// For single numbers the compiler would pack them across jets, with shuffles.
#[inline(always)]
pub(crate) fn lanes(formula: impl Fn(usize) -> f64x2) -> [f64; LANES] {
    let mut out = [0.0; LANES];
    for k in 0..LANES / 2 {
        let [even, odd] = formula(k).to_array();
        (out[2 * k], out[2 * k + 1]) = (even, odd);
    }
    out
}

/// The lanes `2 k` and `2 k + 1`.
#[inline(always)]
pub(crate) fn pair(lanes: &[f64; LANES], k: usize) -> f64x2 {
    f64x2::new([lanes[2 * k], lanes[2 * k + 1]])
}

impl Jet {
    /// A number that moves along straight lines: first derivatives and zero curvature.
    #[must_use]
    #[inline(always)]
    pub const fn new(value: f64, first: [f64; LANES]) -> Self {
        Self { first, second: [0.0; LANES], value }
    }

    /// Input number `lane` of a response.
    ///
    /// For `lane >= 8` the number is a constant.
    #[must_use]
    #[inline(always)]
    pub fn variable(value: f64, lane: usize) -> Self {
        Self::new(value, std::array::from_fn(|k| if k == lane { 1.0 } else { 0.0 }))
    }

    /// A function of this number, from its value `y` and its derivatives `d` and `c` at this value.
    ///
    /// `y' = d x'`, `y'' = d x'' + c x'^2`.
    #[must_use]
    #[inline(always)]
    pub fn compose(self, value: f64, derivative: f64, curvature: f64) -> Self {
        Self {
            value,
            first: lanes(|k| derivative * pair(&self.first, k)),
            second: lanes(|k| {
                derivative * pair(&self.second, k)
                    + curvature * (pair(&self.first, k) * pair(&self.first, k))
            }),
        }
    }
}

impl Real for Jet {
    one_value!(2);

    #[inline(always)]
    fn squared(self) -> Self {
        let twice = self.value + self.value;
        Self {
            value: self.value * self.value,
            first: lanes(|k| twice * pair(&self.first, k)),
            second: lanes(|k| {
                let square = pair(&self.first, k) * pair(&self.first, k);
                twice * pair(&self.second, k) + (square + square)
            }),
        }
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let y = 1.0 / self.value;
        let square = y * y;
        self.compose(y, -square, 2.0 * square * y)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let y = self.value.sqrt();
        let derivative = 0.5 / y;
        self.compose(y, derivative, -0.5 * derivative / self.value)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        let y = simd_lanes::exp(self.value);
        self.compose(y, y, y)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        let inverse = 1.0 / self.value;
        self.compose(simd_lanes::ln(self.value), inverse, -(inverse * inverse))
    }
}

impl Scalar for Jet {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::new(value, [0.0; LANES])
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn exp_scaled(self, factor: f64) -> Self {
        let y = simd_lanes::exp(self.value * factor);
        let derivative = factor * y;
        self.compose(y, derivative, factor * derivative)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.compose(sin, cos, -sin)
    }

    #[inline(always)]
    fn cos(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.compose(cos, -sin, -cos)
    }

    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        let p = f64::from(exponent);
        if exponent < 0 {
            let (y, inverse) = (self.value.powi(exponent), 1.0 / self.value);
            let derivative = p * y * inverse;
            return self.compose(y, derivative, (p - 1.0) * derivative * inverse);
        }
        // No negative power: at x = 0 it would be infinity times zero.
        let power = |below: i32, factor: f64| {
            if exponent < below { 0.0 } else { factor * self.value.powi(exponent - below) }
        };
        self.compose(self.value.powi(exponent), power(1, p), power(2, p * (p - 1.0)))
    }

    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        let y = self.value.powf(exponent);
        let inverse = 1.0 / self.value;
        let derivative = exponent * y * inverse;
        self.compose(y, derivative, (exponent - 1.0) * derivative * inverse)
    }
}

impl Neg for Jet {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            first: lanes(|k| -pair(&self.first, k)),
            second: lanes(|k| -pair(&self.second, k)),
        }
    }
}

impl Add for Jet {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: lanes(|k| pair(&self.first, k) + pair(&other.first, k)),
            second: lanes(|k| pair(&self.second, k) + pair(&other.second, k)),
        }
    }
}

impl Sub for Jet {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            first: lanes(|k| pair(&self.first, k) - pair(&other.first, k)),
            second: lanes(|k| pair(&self.second, k) - pair(&other.second, k)),
        }
    }
}

#[allow(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
impl Mul for Jet {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        Self {
            value: a * b,
            first: lanes(|k| a * pair(&other.first, k) + pair(&self.first, k) * b),
            second: lanes(|k| {
                let cross = pair(&self.first, k) * pair(&other.first, k);
                (a * pair(&other.second, k) + pair(&self.second, k) * b) + (cross + cross)
            }),
        }
    }
}

impl Div for Jet {
    type Output = Self;
    /// `q = a/b`: `q' = (a' - q b')/b`, `q'' = (a'' - q b'' - 2 q' b')/b`.
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // The value by its own division: bitwise identical to the same formula over `f64`.
        let (value, inverse) = (self.value / other.value, 1.0 / other.value);
        let first = lanes(|k| (pair(&self.first, k) - value * pair(&other.first, k)) * inverse);
        let second = lanes(|k| {
            let cross = pair(&first, k) * pair(&other.first, k);
            ((pair(&self.second, k) - value * pair(&other.second, k)) - (cross + cross)) * inverse
        });
        Self { first, second, value }
    }
}

impl Add<f64> for Jet {
    type Output = Self;
    #[inline(always)]
    fn add(self, constant: f64) -> Self {
        Self { value: self.value + constant, ..self }
    }
}

impl Sub<f64> for Jet {
    type Output = Self;
    #[inline(always)]
    fn sub(self, constant: f64) -> Self {
        Self { value: self.value - constant, ..self }
    }
}

impl Mul<f64> for Jet {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            first: lanes(|k| pair(&self.first, k) * factor),
            second: lanes(|k| pair(&self.second, k) * factor),
        }
    }
}

impl Div<f64> for Jet {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        let inverse = 1.0 / divisor;
        Self {
            value: self.value / divisor,
            first: lanes(|k| pair(&self.first, k) * inverse),
            second: lanes(|k| pair(&self.second, k) * inverse),
        }
    }
}
