//! The number type of a response: values, jets or dual numbers.

#![allow(clippy::inline_always, reason = "part of formulas inside a dispatched closure")]

use num_dual::{Dual2_64, DualNum, HyperDual64, HyperHyperDual64};

use crate::numbers::real::Real;

/// A real number, possibly with derivatives: a [`Real`] that is one value.
///
/// A [`Response`](crate::Response) is written once for this trait. With [`f64`] it computes a value, with
/// [`Jet`](crate::Jet) a value with derivatives along eight directions. With the dual numbers of num-dual, used inside
/// [`ForwardDifferentiation`](crate::ForwardDifferentiation), it computes mixed second and third derivatives.
///
/// Outside the domain of a function the value is NaN or infinite, as for [`f64`]; the caller returns an error.
pub trait Scalar: Real<Mask = bool, Primal = f64> {
    /// A constant.
    fn constant(value: f64) -> Self;
    /// The number without its derivatives, for branches.
    fn value(self) -> f64;
    /// The sine of an angle in radians.
    fn sin(self) -> Self;
    /// The cosine of an angle in radians.
    fn cos(self) -> Self;
    /// An integer power.
    fn powi(self, exponent: i32) -> Self;
    /// A constant real power, for `x > 0`.
    fn powf(self, exponent: f64) -> Self;

    /// `exp(factor x)`; with `factor = ln b` the power `b^x` of a certain base.
    #[must_use]
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "part of formulas inside a dispatched closure")]
    fn exp_scaled(self, factor: f64) -> Self {
        (self * factor).exp()
    }
}

/// `one_value!(n)` in an `impl Real` is the part that follows from [`Scalar`] where a number is one value and carries derivatives up to
/// the order `n`: comparisons have one truth, which chooses.
#[macro_export]
macro_rules! one_value {
    ($order:expr) => {
        type Mask = bool;
        type Primal = f64;
        const DERIVATIVES: usize = $order;

        #[inline(always)]
        fn splat(self, value: f64) -> Self {
            $crate::Scalar::constant(value)
        }
        #[inline(always)]
        fn from_primal(value: f64) -> Self {
            $crate::Scalar::constant(value)
        }
        #[inline(always)]
        fn primal(self) -> f64 {
            $crate::Scalar::value(self)
        }
        #[inline(always)]
        fn less(self, other: Self) -> bool {
            $crate::Scalar::value(self) < $crate::Scalar::value(other)
        }
        #[inline(always)]
        fn at_least(self, other: Self) -> bool {
            $crate::Scalar::value(self) >= $crate::Scalar::value(other)
        }
        #[inline(always)]
        fn select(mask: bool, inside: Self, outside: Self) -> Self {
            if mask { inside } else { outside }
        }
        #[inline(always)]
        fn first_outside(self, mask: bool) -> Option<f64> {
            if mask { None } else { Some($crate::Scalar::value(self)) }
        }
    };
}

impl Real for f64 {
    one_value!(0);

    #[inline(always)]
    fn recip(self) -> Self {
        1.0 / self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn exp(self) -> Self {
        simd_lanes::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        simd_lanes::ln(self)
    }
}

/// Uses the functions of the type itself: those of num-dual stay an independent reference.
macro_rules! of_num_dual {
    ($type:ty, $order:expr) => {
        impl Real for $type {
            one_value!($order);

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
        }
    };
}
of_num_dual!(Dual2_64, 2);
of_num_dual!(HyperDual64, 2);
of_num_dual!(HyperHyperDual64, 3);

/// Uses the functions of the type itself: those of num-dual stay an independent reference.
macro_rules! scalar {
    ($type:ty, $constant:expr, $value:expr) => {
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
