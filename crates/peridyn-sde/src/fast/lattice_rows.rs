//! Forces on one row of a lattice, neighbouring nodes in the lanes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::pull::{Growth, Separation};
use super::stencil::{GROUP, Stencil, Vector};
use super::vectors::Mask;
use crate::real::Real;

/// What a row of sites has of its own.
#[derive(Debug, Clone)]
pub(super) struct RowState<T, const D: usize> {
    /// By component.
    pub(super) forces: [Vec<T>; D],
    /// Bits of whole bonds, by group of sites and vector.
    pub(super) whole: Vec<Mask>,
    /// Place in the row, and vector, of bonds that broke.
    pub(super) broken: Vec<(usize, usize)>,
}

impl<T: Real, const D: usize> RowState<T, D> {
    pub(super) fn new(groups: usize, n_vectors: usize) -> Self {
        let forces = std::array::from_fn(|_| vec![T::ZERO; groups * GROUP]);
        Self { forces, whole: vec![0; groups * n_vectors], broken: Vec::new() }
    }
}

/// The forces on a row that begins at a site.
pub(super) struct RowWork<'a, T, const D: usize, const LINEAR: bool> {
    pub(super) row: &'a mut RowState<T, D>,
    pub(super) start: usize,
    pub(super) stencil: &'a Stencil<T, D>,
    pub(super) padded: &'a [Vec<T>; D],
    pub(super) limit: T,
}

impl<T: Real, const D: usize, const LINEAR: bool> WithSimd for RowWork<'_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for at in (0..self.row.forces[0].len()).step_by(T::lanes::<S>()) {
            if !self.is_near(simd, at) {
                simd.vectorize(Far { row: &mut self, at });
            }
        }
    }
}

/// A register whose bonds are not all near, as a function of its own: the rest does not share its registers with it.
struct Far<'a, 'b, T, const D: usize, const LINEAR: bool> {
    row: &'a mut RowWork<'b, T, D, LINEAR>,
    at: usize,
}

impl<T: Real, const D: usize, const LINEAR: bool> WithSimd for Far<'_, '_, T, D, LINEAR> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.row.far(simd, self.at);
    }
}

impl<T: Real, const D: usize, const LINEAR: bool> RowWork<'_, T, D, LINEAR> {
    /// The nodes from a place in the row on, if no bond of theirs is at its limit or out of the series' range.
    #[inline(always)]
    fn is_near<S: Simd>(&mut self, simd: S, at: usize) -> bool {
        let (zero, limit) = (T::splat(simd, T::ZERO), T::splat(simd, self.limit));
        let near = Growth::<T, S>::near::<LINEAR>(simd, limit);
        let (words, site) = (self.words(at), self.start + at);
        let u = components(self.padded);
        let u_i = u.map(|u| T::load::<S>(u, site));
        let (mut farthest, mut total) = (zero, [zero; D]);
        for (vector, &word) in self.stencil.vectors.iter().zip(&self.row.whole[words]) {
            let separation =
                bond::<T, S, D, LINEAR>(simd, (vector, site), (&u, &u_i), word >> (at % GROUP));
            // Squares are asked for in any case, and rise with |w|, rounded or not.
            farthest = T::greater(simd, separation.growth.square(simd), farthest);
            let pull = separation.growth.near_pull::<LINEAR>(simd);
            add(simd, &mut total, (vector, pull), &separation);
        }
        if T::any_beyond(simd, farthest, T::times(simd, near, near)) {
            return false;
        }
        self.store::<S>(&total, at);
        true
    }

    /// The same wherever their bonds are; those at their limit break.
    #[inline(always)]
    fn far<S: Simd>(&mut self, simd: S, at: usize) {
        let (zero, limit) = (T::splat(simd, T::ZERO), T::splat(simd, self.limit));
        let (words, site) = (self.words(at), self.start + at);
        let u = components(self.padded);
        let u_i = u.map(|u| T::load::<S>(u, site));
        let mut total = [zero; D];
        let words = self.row.whole[words].iter_mut();
        for (number, (vector, word)) in self.stencil.vectors.iter().zip(words).enumerate() {
            let within = at % GROUP;
            let mut separation =
                bond::<T, S, D, LINEAR>(simd, (vector, site), (&u, &u_i), *word >> within);
            let pull = separation.growth.pull::<LINEAR>(simd, limit, |reached| {
                *word &= !(reached << within);
                for lane in (0..T::lanes::<S>()).filter(|lane| reached & 1 << lane != 0) {
                    self.row.broken.push((at + lane, number));
                }
            });
            add(simd, &mut total, (vector, pull), &separation);
        }
        self.store::<S>(&total, at);
    }

    /// Where the words of the group of a place in the row are.
    #[inline(always)]
    fn words(&self, at: usize) -> Range<usize> {
        let n = self.stencil.vectors.len();
        at / GROUP * n..(at / GROUP + 1) * n
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, total: &[T::V<S>; D], at: usize) {
        for k in 0..D {
            T::store::<S>(total[k], &mut self.row.forces[k], at);
        }
    }
}

/// The components of displacements, of one length, so that one check serves all.
#[inline(always)]
fn components<T, const D: usize>(padded: &[Vec<T>; D]) -> [&[T]; D] {
    let n_sites = padded[0].len();
    std::array::from_fn(|k| &padded[k][..n_sites])
}

/// The bonds of one vector from a register of sites.
#[inline(always)]
fn bond<T: Real, S: Simd, const D: usize, const LINEAR: bool>(
    simd: S,
    (vector, site): (&Vector<T, D>, usize),
    (u, u_i): (&[&[T]; D], &[T::V<S>; D]),
    whole: Mask,
) -> Separation<T, S, D> {
    // Beyond the ends of all sites there is no bond: what is read instead does not count.
    let other = site.wrapping_add_signed(vector.offset);
    let xi = vector.xi.map(|xi| T::splat(simd, xi));
    let eta = std::array::from_fn(|k| T::minus(simd, T::load::<S>(u[k], other), u_i[k]));
    let inverse_square = T::splat(simd, vector.inverse_square);
    Separation::new::<LINEAR>(simd, (&xi, inverse_square), &eta, whole)
}

/// Adds their forces.
#[inline(always)]
fn add<T: Real, S: Simd, const D: usize>(
    simd: S,
    total: &mut [T::V<S>; D],
    (vector, pull): (&Vector<T, D>, T::V<S>),
    separation: &Separation<T, S, D>,
) {
    let tension = T::times(simd, T::splat(simd, vector.stiffness), pull);
    for k in 0..D {
        total[k] = T::plus(simd, total[k], T::times(simd, tension, separation.direction[k]));
    }
}
