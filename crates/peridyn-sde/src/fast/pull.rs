//! One bond in the lanes of a register: what all fast paths compute.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use pulp::Simd;

use super::vectors::{MOST_LANES, Mask};
use crate::real::Real;

/// How far the ends of bonds have moved apart, a bond in each lane.
pub(crate) struct Separation<T: Real, S: Simd, const D: usize> {
    /// `xi + eta`, or `xi` where strains are linear.
    pub(crate) direction: [T::V<S>; D],
    /// `w = |xi + eta|^2/|xi|^2 - 1`, or `2 xi eta/|xi|^2`; zero where the bond is broken.
    pub(crate) growth: T::V<S>,
}

impl<T: Real, S: Simd, const D: usize> Separation<T, S, D> {
    /// Of bonds `xi` whose ends moved apart by `eta`. Both turned round, it is the same to the last bit.
    #[inline(always)]
    pub(crate) fn new<const LINEAR: bool>(
        simd: S,
        (xi, inverse_square): (&[T::V<S>; D], T::V<S>),
        eta: &[T::V<S>; D],
        whole: Mask,
    ) -> Self {
        let zero = T::splat(simd, T::ZERO);
        let (mut square, mut direction) = (zero, [zero; D]);
        for k in 0..D {
            direction[k] = if LINEAR { xi[k] } else { T::plus(simd, xi[k], eta[k]) };
            let twice = T::plus(simd, xi[k], direction[k]);
            square = T::plus(simd, square, T::times(simd, eta[k], twice));
        }
        let mut growth = T::times(simd, square, inverse_square);
        let all = Mask::MAX >> (MOST_LANES - T::lanes::<S>());
        if whole & all != all {
            growth = T::keep(simd, whole, growth);
        }
        Self { direction, growth }
    }

    /// The part of its stiffness over length that a bond pulls with along `direction`: `1 - 1/sqrt(1 + w)`, the stretch over
    /// the stretched length; with linear strains `w/2`. Bonds that have reached their limit pull no more; `broken` is told of
    /// their lanes.
    #[inline(always)]
    pub(crate) fn pull<const LINEAR: bool>(
        &mut self,
        simd: S,
        limit: T::V<S>,
        broken: impl FnOnce(Mask),
    ) -> T::V<S> {
        let range = if LINEAR { T::LARGEST } else { T::NEAR };
        let safe = T::lesser(simd, limit, T::splat(simd, range));
        if !T::any_beyond(simd, self.growth, safe) {
            return if LINEAR { self.linear(simd) } else { self.series(simd, T::NEAR_TERMS) };
        }
        let reached = self.at_limit(limit);
        if reached != 0 {
            broken(reached);
            self.growth = T::keep(simd, !reached, self.growth);
        }
        if LINEAR {
            self.linear(simd)
        } else if T::any_beyond(simd, self.growth, T::splat(simd, T::SERIES_RANGE)) {
            self.far()
        } else {
            self.series(simd, T::SERIES.len())
        }
    }

    #[inline(always)]
    fn linear(&self, simd: S) -> T::V<S> {
        T::times(simd, self.growth, T::splat(simd, T::of(0.5)))
    }

    #[inline(always)]
    fn series(&self, simd: S, terms: usize) -> T::V<S> {
        let mut sum = T::splat(simd, T::SERIES[terms - 1]);
        for term in (0..terms - 1).rev() {
            sum = T::times(simd, sum, self.growth);
            sum = T::plus(simd, sum, T::splat(simd, T::SERIES[term]));
        }
        T::times(simd, sum, self.growth)
    }

    /// Beyond the range of the series, `w/(sqrt(1 + w) (1 + sqrt(1 + w)))`.
    #[inline(never)]
    fn far(&self) -> T::V<S> {
        let mut growth = [T::ZERO; MOST_LANES];
        T::store::<S>(self.growth, &mut growth, 0);
        for w in &mut growth[..T::lanes::<S>()] {
            let root = (T::of(1.0) + *w).sqrt();
            *w = *w / (root * (T::of(1.0) + root));
        }
        T::load::<S>(&growth, 0)
    }

    /// The lanes whose growth is at its limit.
    #[inline(never)]
    fn at_limit(&self, limit: T::V<S>) -> Mask {
        let (mut growth, mut limits) = ([T::ZERO; MOST_LANES], [T::ZERO; MOST_LANES]);
        T::store::<S>(self.growth, &mut growth, 0);
        T::store::<S>(limit, &mut limits, 0);
        let mut reached = 0;
        for lane in 0..T::lanes::<S>() {
            reached |= Mask::from(growth[lane] >= limits[lane]) << lane;
        }
        reached
    }
}
