//! Derivatives of eight responses by one number.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::LANES;

/// Derivatives of eight responses by one number.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Eight(pub(super) [f64; LANES]);

impl Eight {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    /// Adds a multiple of another.
    #[inline(always)]
    pub(super) fn add(&mut self, factor: f64, other: &Self) {
        for lane in 0..LANES {
            self.0[lane] += factor * other.0[lane];
        }
    }

    #[inline(always)]
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let mut product = *self;
        for lane in 0..LANES {
            product.0[lane] *= factor;
        }
        product
    }

    /// Itself; zero is left.
    #[inline(always)]
    pub(super) fn take(&mut self) -> Self {
        std::mem::replace(self, Self::ZERO)
    }
}
