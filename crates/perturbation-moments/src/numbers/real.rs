//! The arithmetic of formulas: one number, possibly with derivatives, or a number in each lane of a register.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use simd_lanes::{Lanes, Mask};
/// A real number of a formula: a value, possibly with derivatives, or a value in each lane of a register.
///
/// A formula over `Real` serves `f64`, [`Jet`](crate::Jet) and [`Gradient`](crate::Gradient), and several `f64` at once in the lanes
/// of a register, [`InLanes`]. Lanes differ in their values, so a branch becomes a choice by a [mask](Self::Mask):
/// [`select`](Self::select), or [`when!`](crate::when) where one side is expensive. For a single value the mask is a `bool`,
/// and `when!` is a branch.
///
/// A constant needs to know the registers, so it is made from a number at hand: [`splat`](Self::splat).
///
/// ```
/// use perturbation_moments::{Jet, Real, when};
///
/// /// `sqrt x`, or zero below zero.
/// fn root<S: Real>(x: S) -> S {
///     let zero = x.splat(0.0);
///     when!(zero.less(x), x.sqrt(), zero)
/// }
///
/// assert_eq!([root(4.0), root(-4.0)], [2.0, 0.0]);
/// assert_eq!(root(Jet::variable(4.0, 0)).first[0], 0.25);
/// ```
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + 'static
{
    /// The truth of a comparison, in each lane.
    type Mask: Mask;
    /// The number without its derivatives, for iterations: `f64`, or one in each lane.
    type Primal: Real<Mask = Self::Mask, Primal = Self::Primal>;
    /// Up to which order it carries derivatives.
    const DERIVATIVES: usize;

    /// A constant, in as many lanes as `self` has.
    #[must_use]
    fn splat(self, value: f64) -> Self;
    /// A constant by its value in each lane.
    fn from_primal(value: Self::Primal) -> Self;
    /// The number without its derivatives.
    fn primal(self) -> Self::Primal;
    /// Where the value is below the other; false for NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// Where the value is the other or above; false for NaN.
    fn at_least(self, other: Self) -> Self::Mask;
    /// `inside` in the lanes where the mask is true, `outside` in the others.
    #[must_use]
    fn select(mask: Self::Mask, inside: Self, outside: Self) -> Self;
    /// The value in the first lane where the mask is false, for a message; `None` where it is true in every lane.
    fn first_outside(self, mask: Self::Mask) -> Option<f64>;
    /// `1/x`.
    #[must_use]
    fn recip(self) -> Self;
    /// The square root, for `x > 0`; not differentiable at zero.
    #[must_use]
    fn sqrt(self) -> Self;
    /// The exponential.
    #[must_use]
    fn exp(self) -> Self;
    /// The natural logarithm, for `x > 0`.
    #[must_use]
    fn ln(self) -> Self;

    /// The square.
    #[must_use]
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }

    /// Where the value is finite.
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        let infinity = self.splat(f64::INFINITY);
        self.less(infinity).and((-infinity).less(self))
    }
}

/// `when!(mask, inside, outside)`: `inside` in the lanes of a [`Real`] where the mask is true, which is computed only if there is any;
/// `outside` in the others. Of one value it is a branch.
///
/// It is no function of closures: these are not always inlined, and then not compiled for the widest registers.
#[macro_export]
macro_rules! when {
    ($mask:expr, $inside:expr, $outside:expr $(,)?) => {{
        let (mask, outside) = ($mask, $outside);
        if $crate::Mask::any(mask) { $crate::Real::select(mask, $inside, outside) } else { outside }
    }};
}

/// A number in each lane of a register, without derivatives.
///
/// Each lane has the bits that the same formula over `f64` has, whatever the register.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct InLanes<V>(pub V);

/// Operators of a register as those of the number in its lanes.
macro_rules! operator {
    ($trait:ident, $function:ident, $operator:tt) => {
        impl<V: Lanes<Number = f64>> $trait for InLanes<V> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0 $operator other.0)
            }
        }

        impl<V: Lanes<Number = f64>> $trait<f64> for InLanes<V> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                Self(self.0 $operator self.0.splat(other))
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<V: Lanes<Number = f64>> Neg for InLanes<V> {
    type Output = Self;
    /// As a product: the sign of a zero changes too.
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0 * self.0.splat(-1.0))
    }
}

impl<V: Lanes<Number = f64>> Real for InLanes<V> {
    type Mask = V::Mask;
    type Primal = Self;
    const DERIVATIVES: usize = 0;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self(self.0.splat(value))
    }
    #[inline(always)]
    fn from_primal(value: Self) -> Self {
        value
    }
    #[inline(always)]
    fn primal(self) -> Self {
        self
    }
    #[inline(always)]
    fn less(self, other: Self) -> V::Mask {
        self.0.less(other.0)
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> V::Mask {
        self.0.at_least(other.0)
    }
    #[inline(always)]
    fn select(mask: V::Mask, inside: Self, outside: Self) -> Self {
        Self(V::select(mask, inside.0, outside.0))
    }
    #[inline(always)]
    fn first_outside(self, mask: V::Mask) -> Option<f64> {
        if mask.all() { None } else { Some(self.0.lane(mask.not().bits().trailing_zeros())) }
    }
    #[inline(always)]
    fn recip(self) -> Self {
        Self(self.0.splat(1.0) / self.0)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[inline(always)]
    fn exp(self) -> Self {
        Self(self.0.exp())
    }
    #[inline(always)]
    fn ln(self) -> Self {
        Self(self.0.ln())
    }
}
