//! The number type of a response: one text for values, jets and dual numbers.

use std::ops::{Add, Div, Mul, Neg, Sub};

use num_dual::{Dual2_64, DualNum, HyperDual64, HyperHyperDual64};

/// A real number, or one that carries derivatives with it.
///
/// A [`Response`](crate::Response) is written once over this trait. With [`f64`] it gives a value, with
/// [`Jet`](crate::Jet) a value with derivatives along eight directions, with the dual numbers of num-dual, which
/// [`ForwardDifferentiation`](crate::ForwardDifferentiation) uses inside, mixed second and third derivatives.
///
/// Outside the domain of a function the value is NaN or infinite, as for [`f64`]; who asked for it returns an error.
pub trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// A number that depends on nothing.
    fn constant(value: f64) -> Self;
    /// The number without its derivatives: what a branch looks at.
    fn value(self) -> f64;
    /// `1/x`.
    fn recip(self) -> Self;
    /// The square root, for `x > 0`; at zero it has no derivative.
    fn sqrt(self) -> Self;
    /// The exponential.
    fn exp(self) -> Self;
    /// The natural logarithm, for `x > 0`.
    fn ln(self) -> Self;
    /// The sine of an angle in radians.
    fn sin(self) -> Self;
    /// The cosine of an angle in radians.
    fn cos(self) -> Self;
    /// A whole power.
    fn powi(self, exponent: i32) -> Self;
    /// A constant real power, for `x > 0`.
    fn powf(self, exponent: f64) -> Self;

    /// `exp(factor x)`; with `factor = ln b` the power `b^x` of a base that is certain.
    #[must_use]
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "part of formulas inside a dispatched closure")]
    fn exp_scaled(self, factor: f64) -> Self {
        (self * factor).exp()
    }

    /// The square.
    #[must_use]
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "part of formulas inside a dispatched closure")]
    fn squared(self) -> Self {
        self * self
    }
}

/// Each by the functions that the type brings: those of num-dual stay a judge that shares nothing with ours.
macro_rules! scalar {
    ($type:ty, $constant:expr, $value:expr) => {
        #[allow(clippy::inline_always, reason = "part of formulas inside a dispatched closure")]
        impl Scalar for $type {
            #[inline(always)]
            fn constant(value: f64) -> Self {
                $constant(value)
            }
            #[inline(always)]
            fn value(self) -> f64 {
                $value(self)
            }
            #[inline(always)]
            fn recip(self) -> Self {
                DualNum::recip(&self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                DualNum::sqrt(&self)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                DualNum::exp(&self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                DualNum::ln(&self)
            }
            #[inline(always)]
            fn sin(self) -> Self {
                DualNum::sin(&self)
            }
            #[inline(always)]
            fn cos(self) -> Self {
                DualNum::cos(&self)
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                DualNum::powi(&self, exponent)
            }
            #[inline(always)]
            fn powf(self, exponent: f64) -> Self {
                DualNum::powf(&self, exponent)
            }
        }
    };
}

scalar!(f64, |value| value, |x| x);
scalar!(Dual2_64, Dual2_64::from_re, |x: Dual2_64| x.re);
scalar!(HyperDual64, HyperDual64::from_re, |x: HyperDual64| x.re);
scalar!(HyperHyperDual64, HyperHyperDual64::from_re, |x: HyperHyperDual64| x.re);
