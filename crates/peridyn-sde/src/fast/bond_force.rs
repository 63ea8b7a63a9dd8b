//! The force of bonds: the one text from which the paths over lattices, lists and lanes are made.
//!
//! A path reads `xi` and `eta` of a bond, has the direction and the relative squared elongation from [`component`], the pull from
//! [`SquaredElongation`], and adds `stiffness/length pull direction` to one end and its opposite to the other. Only reading and
//! adding are written three times: neighbouring bonds are at consecutive places of a lattice, at scattered nodes of a list, and at
//! the same nodes of all lanes. A common function for that would have to take the places as an argument, and a register
//! that is filled from places known only at run time costs more than the force itself.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::{Add, Mul};

use pulp::Simd;

use super::vectors::{MOST_LANES, Mask};
use crate::real::Real;

/// One component of a bond: `xi + eta` (`xi` where strains are linear), and its part of the growth of the squared length,
/// `eta (2 xi + eta)` or `2 eta xi`. Of single numbers or of registers. With both arguments negated, the second is bitwise the
/// same.
#[inline(always)]
pub(super) fn component<N: Copy + Add<Output = N> + Mul<Output = N>, const LINEAR: bool>(
    xi: N,
    eta: N,
) -> (N, N) {
    let direction = if LINEAR { xi } else { xi + eta };
    (direction, eta * (xi + direction))
}

/// A register as a number.
#[derive(Clone, Copy)]
struct Register<T: Real, S: Simd>(S, T::V<S>);

impl<T: Real, S: Simd> Add for Register<T, S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0, T::plus(self.0, self.1, other.1))
    }
}

impl<T: Real, S: Simd> Mul for Register<T, S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0, T::times(self.0, self.1, other.1))
    }
}

/// Direction and elongation of bonds, a bond in each lane.
pub(super) struct Separation<T: Real, S: Simd, const D: usize> {
    /// `xi + eta`, or `xi` where strains are linear.
    pub(super) direction: [T::V<S>; D],
    pub(super) elongation: SquaredElongation<T, S>,
}

impl<T: Real, S: Simd, const D: usize> Separation<T, S, D> {
    /// Of bonds `xi` whose ends moved apart by `eta`.
    #[inline(always)]
    pub(super) fn new<const LINEAR: bool>(
        simd: S,
        (xi, inverse_square): (&[T::V<S>; D], T::V<S>),
        eta: &[T::V<S>; D],
        intact: Mask,
    ) -> Self {
        let (mut square, mut direction) = (T::splat(simd, T::ZERO), *xi);
        for k in 0..D {
            let (xi, eta) = (Register::<T, S>(simd, xi[k]), Register(simd, eta[k]));
            let (along, part) = component::<_, LINEAR>(xi, eta);
            direction[k] = along.1;
            square = if k == 0 { part.1 } else { T::plus(simd, square, part.1) };
        }
        let elongation = SquaredElongation::new(simd, (square, inverse_square), intact);
        Self { direction, elongation }
    }
}

/// The relative squared elongation `w = |xi + eta|^2/|xi|^2 - 1`, or `2 xi eta/|xi|^2`; zero where the bond is broken.
pub(super) struct SquaredElongation<T: Real, S: Simd>(pub(super) T::V<S>);

impl<T: Real, S: Simd> SquaredElongation<T, S> {
    /// From the growth of squared lengths.
    #[inline(always)]
    pub(super) fn new(simd: S, (square, inverse_square): (T::V<S>, T::V<S>), intact: Mask) -> Self {
        let elongation = T::times(simd, square, inverse_square);
        let all = Mask::MAX >> (MOST_LANES - T::lanes::<S>());
        if T::has_masks::<S>() || intact & all != all {
            return Self(T::keep(simd, intact, elongation));
        }
        Self(elongation)
    }

    /// The force over stiffness over length along `direction`: `1 - 1/sqrt(1 + w)`, the stretch over the stretched length;
    /// with linear strains `w/2`. Bonds at their limit carry none, and `found` gets their lanes.
    ///
    /// The pull of a bond depends on no other lane, so that the bits do not depend on how many there are.
    #[inline(always)]
    pub(super) fn pull<const LINEAR: bool>(
        &mut self,
        simd: S,
        limit: T::V<S>,
        found: impl FnOnce(Mask),
    ) -> T::V<S> {
        if T::any_beyond(simd, self.0, Self::near::<LINEAR>(simd, limit)) {
            return self.far_pull::<LINEAR>(simd, limit, found);
        }
        self.near_pull::<LINEAR>(simd)
    }

    /// Below which `|w|` no bond is at its limit and [`near_pull`](Self::near_pull) is its pull.
    #[inline(always)]
    pub(super) fn near<const LINEAR: bool>(simd: S, limit: T::V<S>) -> T::V<S> {
        if LINEAR { limit } else { T::lesser(simd, limit, T::splat(simd, T::SERIES_RANGE)) }
    }

    /// [`pull`](Self::pull) of any bonds.
    #[inline(always)]
    fn far_pull<const LINEAR: bool>(
        &mut self,
        simd: S,
        limit: T::V<S>,
        found: impl FnOnce(Mask),
    ) -> T::V<S> {
        let reached = self.at_limit(limit);
        if reached != 0 {
            found(reached);
            self.0 = T::keep(simd, !reached, self.0);
        }
        if LINEAR {
            return self.near_pull::<true>(simd);
        }
        let range = T::splat(simd, T::SERIES_RANGE);
        let closed = T::closed_pull(simd, self.0);
        let near = self.near_pull::<false>(simd);
        T::beyond_or(simd, (self.0, range), closed, near)
    }

    /// [`pull`](Self::pull) of bonds in the range of the series, below their limit.
    #[inline(always)]
    pub(super) fn near_pull<const LINEAR: bool>(&self, simd: S) -> T::V<S> {
        if LINEAR {
            return T::times(simd, self.0, T::splat(simd, T::of(0.5)));
        }
        // In pairs, with powers of w^2: half as many operations wait for each other as one by one.
        let w = self.0;
        let (pairs, square) = (T::SERIES.as_chunks::<2>().0, T::times(simd, w, w));
        let pair = |&[even, odd]: &[T; 2]| {
            T::plus(simd, T::splat(simd, even), T::times(simd, w, T::splat(simd, odd)))
        };
        let mut sum = pair(&pairs[pairs.len() - 1]);
        for of in pairs[..pairs.len() - 1].iter().rev() {
            sum = T::plus(simd, pair(of), T::times(simd, sum, square));
        }
        T::times(simd, sum, w)
    }

    /// The rule of bond failure in a force evaluation: the lanes whose elongation is at its limit.
    #[inline(never)]
    fn at_limit(&self, limit: T::V<S>) -> Mask {
        let (mut elongation, mut limits) = ([T::ZERO; MOST_LANES], [T::ZERO; MOST_LANES]);
        T::store::<S>(self.0, &mut elongation, 0);
        T::store::<S>(limit, &mut limits, 0);
        let mut reached = 0;
        for lane in 0..T::lanes::<S>() {
            reached |= Mask::from(elongation[lane] >= limits[lane]) << lane;
        }
        reached
    }
}
