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
    pub(crate) growth: Growth<T, S>,
}

/// `w = |xi + eta|^2/|xi|^2 - 1`, or `2 xi eta/|xi|^2`; zero where the bond is broken.
pub(crate) struct Growth<T: Real, S: Simd>(pub(crate) T::V<S>);

impl<T: Real, S: Simd, const D: usize> Separation<T, S, D> {
    /// Of bonds `xi` whose ends moved apart by `eta`. Both turned round, it is the same to the last bit.
    #[inline(always)]
    pub(crate) fn new<const LINEAR: bool>(
        simd: S,
        (xi, inverse_square): (&[T::V<S>; D], T::V<S>),
        eta: &[T::V<S>; D],
        whole: Mask,
    ) -> Self {
        let (mut square, mut direction) = (T::splat(simd, T::ZERO), *xi);
        for k in 0..D {
            if !LINEAR {
                direction[k] = T::plus(simd, xi[k], eta[k]);
            }
            let part = T::times(simd, eta[k], T::plus(simd, xi[k], direction[k]));
            square = if k == 0 { part } else { T::plus(simd, square, part) };
        }
        Self { direction, growth: Growth::new(simd, (square, inverse_square), whole) }
    }
}

impl<T: Real, S: Simd> Growth<T, S> {
    /// Of bonds whose squares grew by so much.
    #[inline(always)]
    pub(crate) fn new(simd: S, (square, inverse_square): (T::V<S>, T::V<S>), whole: Mask) -> Self {
        let growth = T::times(simd, square, inverse_square);
        let all = Mask::MAX >> (MOST_LANES - T::lanes::<S>());
        if T::has_masks::<S>() || whole & all != all {
            return Self(T::keep(simd, whole, growth));
        }
        Self(growth)
    }

    /// The part of its stiffness over length that a bond pulls with along `direction`: `1 - 1/sqrt(1 + w)`, the stretch over
    /// the stretched length; with linear strains `w/2`. Bonds that have reached their limit pull no more; `broken` is told of
    /// their lanes.
    ///
    /// What a bond pulls with depends on no other lane, so that the bits do not depend on how many there are.
    #[inline(always)]
    pub(crate) fn pull<const LINEAR: bool>(
        &mut self,
        simd: S,
        limit: T::V<S>,
        broken: impl FnOnce(Mask),
    ) -> T::V<S> {
        if T::any_beyond(simd, self.0, Self::near::<LINEAR>(simd, limit)) {
            let reached = self.at_limit(limit);
            if reached != 0 {
                broken(reached);
                self.0 = T::keep(simd, !reached, self.0);
            }
            if !LINEAR {
                let range = T::splat(simd, T::SERIES_RANGE);
                let closed = T::closed_pull(simd, self.0);
                let near = self.near_pull::<false>(simd);
                return T::beyond_or(simd, (self.0, range), closed, near);
            }
        }
        self.near_pull::<LINEAR>(simd)
    }

    /// Below which `|w|` no bond is at its limit and [`near_pull`](Self::near_pull) is what it pulls with.
    #[inline(always)]
    pub(crate) fn near<const LINEAR: bool>(simd: S, limit: T::V<S>) -> T::V<S> {
        if LINEAR { limit } else { T::lesser(simd, limit, T::splat(simd, T::SERIES_RANGE)) }
    }

    /// The same for bonds in the range of the series, far from their limit.
    #[inline(always)]
    pub(crate) fn near_pull<const LINEAR: bool>(&self, simd: S) -> T::V<S> {
        if LINEAR {
            return T::times(simd, self.0, T::splat(simd, T::of(0.5)));
        }
        // In pairs, with powers of w^2: half as many operations wait for each other as one by one.
        let w = self.0;
        let (pairs, square) = (T::SERIES.as_chunks::<2>().0, self.square(simd));
        let pair = |&[even, odd]: &[T; 2]| {
            T::plus(simd, T::splat(simd, even), T::times(simd, w, T::splat(simd, odd)))
        };
        let mut sum = pair(&pairs[pairs.len() - 1]);
        for of in pairs[..pairs.len() - 1].iter().rev() {
            sum = T::plus(simd, pair(of), T::times(simd, sum, square));
        }
        T::times(simd, sum, w)
    }

    /// `w^2`.
    #[inline(always)]
    pub(crate) fn square(&self, simd: S) -> T::V<S> {
        T::times(simd, self.0, self.0)
    }

    /// The lanes whose growth is at its limit.
    #[inline(never)]
    fn at_limit(&self, limit: T::V<S>) -> Mask {
        let (mut growth, mut limits) = ([T::ZERO; MOST_LANES], [T::ZERO; MOST_LANES]);
        T::store::<S>(self.0, &mut growth, 0);
        T::store::<S>(limit, &mut limits, 0);
        let mut reached = 0;
        for lane in 0..T::lanes::<S>() {
            reached |= Mask::from(growth[lane] >= limits[lane]) << lane;
        }
        reached
    }
}
