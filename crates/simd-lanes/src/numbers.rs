//! One trait for scalars and SIMD registers.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Sub};

use crate::sealed::Sealed;

/// A scalar or a register of scalars: a formula written over `Lanes` works for both.
///
/// `f64` and `f32` implement it as one lane; so do the registers of every level. All operations are those of IEEE 754,
/// rounded once, and no product is fused with a sum: each lane is bitwise identical to the scalar result.
///
/// ```
/// use simd_lanes::{Lanes, Mask, Registers, SimdLevel, Work};
///
/// /// `sqrt x`, or zero below zero.
/// #[inline(always)]
/// fn root<N: Lanes<Number = f64>>(x: N) -> N {
///     let zero = x.splat(0.0);
///     let negative = x.less(zero);
///     if negative.any() { N::select(negative, zero, x).sqrt() } else { x.sqrt() }
/// }
///
/// struct Roots<'a>(&'a mut [f64]);
///
/// impl Work<f64> for Roots<'_> {
///     type Output = ();
///
///     #[inline(always)]
///     fn run<R: Registers<f64>>(self, registers: R) {
///         for at in (0..self.0.len()).step_by(R::N) {
///             let x = registers.load_at(self.0, at);
///             registers.store_at(root(x), self.0, at);
///         }
///     }
/// }
///
/// assert_eq!([root(4.0), root(-4.0)], [2.0, 0.0]);
/// let mut x = [4.0, -1.0, 9.0, 0.25, 1.0, -0.5, 0.0, 16.0];
/// SimdLevel::best().run(Roots(&mut x));
/// assert_eq!(x, [2.0, 0.0, 3.0, 0.5, 1.0, 0.0, 0.0, 4.0]);
/// ```
pub trait Lanes:
    Copy
    + Debug
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Sealed
    + 'static
{
    /// Number type of a lane.
    type Number: Copy;
    /// Result of a comparison in each lane.
    type Mask: Mask;
    /// Fills every lane with the same number, in as many lanes as `self` has.
    fn splat(self, value: Self::Number) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The value without its sign bit; NaN stays NaN.
    fn abs(self) -> Self;
    /// The exponential, as [`exp`](crate::exp) of each lane; of `f32` that of `f64`, rounded.
    fn exp(self) -> Self;
    /// The natural logarithm, as [`ln`](crate::ln) of each lane; of `f32` that of `f64`, rounded.
    fn ln(self) -> Self;
    /// `self` where `self < other`, else `other`; `other` also where either is NaN or both are zero.
    fn min(self, other: Self) -> Self;
    /// `self` where `self > other`, else `other`; `other` also where either is NaN or both are zero.
    fn max(self, other: Self) -> Self;
    /// Mask of `self < other`; false in lanes with NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// Mask of `self >= other`; false in lanes with NaN.
    fn at_least(self, other: Self) -> Self::Mask;
    /// `inside` in the lanes where the mask is true, `outside` in the others.
    fn select(mask: Self::Mask, inside: Self, outside: Self) -> Self;
    /// The number in a lane; of lanes beyond the last, that in the last.
    fn lane(self, lane: u32) -> Self::Number;
}

/// A Boolean value for each lane.
pub trait Mask: Copy + Debug + Send + Sync + Sealed + 'static {
    /// Whether it is true in any lane.
    fn any(self) -> bool;
    /// Whether it is true in every lane.
    #[inline(always)]
    fn all(self) -> bool {
        !self.not().any()
    }
    /// Bit mask: bit `k` is lane `k`; bits beyond the lanes are zero.
    fn bits(self) -> u32;
    /// True where both are.
    #[must_use]
    fn and(self, other: Self) -> Self;
    /// True where either is.
    #[must_use]
    fn or(self, other: Self) -> Self;
    /// True where it is false.
    #[must_use]
    fn not(self) -> Self;
}

impl Sealed for bool {}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.into()
    }
    #[inline(always)]
    fn and(self, other: bool) -> bool {
        self & other
    }
    #[inline(always)]
    fn or(self, other: bool) -> bool {
        self | other
    }
    #[inline(always)]
    fn not(self) -> bool {
        !self
    }
}
