//! Numbers as registers of one lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use crate::elementary::{exp, exp_rounded, ln, ln_rounded};
use crate::numbers::Lanes;
use crate::sealed::Sealed;

macro_rules! one_lane {
    ($real:ty, $exp:expr, $ln:expr) => {
        impl Sealed for $real {}

        impl Lanes for $real {
            type Number = Self;
            type Mask = bool;

            #[inline(always)]
            fn splat(self, value: Self) -> Self {
                value
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                $ln(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn at_least(self, other: Self) -> bool {
                self >= other
            }
            #[inline(always)]
            fn select(mask: bool, inside: Self, outside: Self) -> Self {
                if mask { inside } else { outside }
            }
            #[inline(always)]
            fn lane(self, _lane: u32) -> Self {
                self
            }
        }
    };
}
one_lane!(f64, exp, ln);
one_lane!(f32, exp_rounded, ln_rounded);
