//! Forces on one row of a lattice, neighbouring nodes in the lanes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use pulp::{Simd, WithSimd};

use super::pull::Separation;
use super::stencil::{GROUP, Stencil};
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
            self.register(simd, at);
        }
    }
}

impl<T: Real, const D: usize, const LINEAR: bool> RowWork<'_, T, D, LINEAR> {
    /// The nodes from a place in the row on.
    #[inline(always)]
    fn register<S: Simd>(&mut self, simd: S, at: usize) {
        let vectors = &self.stencil.vectors;
        let (zero, limit) = (T::splat(simd, T::ZERO), T::splat(simd, self.limit));
        let (group, within) = (at / GROUP, at % GROUP);
        let site = self.start + at;
        let (mut u, mut total) = ([zero; D], [zero; D]);
        for k in 0..D {
            u[k] = T::load::<S>(&self.padded[k], site);
        }
        let words = &mut self.row.whole[group * vectors.len()..][..vectors.len()];
        for (number, (vector, word)) in vectors.iter().zip(words).enumerate() {
            let whole = *word >> within;
            let other = site.wrapping_add_signed(vector.offset);
            let (mut xi, mut eta) = ([zero; D], [zero; D]);
            for k in 0..D {
                xi[k] = T::splat(simd, vector.xi[k]);
                // Beyond the ends of all sites there is no bond: what is read instead does not count.
                eta[k] = T::minus(simd, T::load::<S>(&self.padded[k], other), u[k]);
            }
            let inverse_square = T::splat(simd, vector.inverse_square);
            let mut separation =
                Separation::<T, S, D>::new::<LINEAR>(simd, (&xi, inverse_square), &eta, whole);
            let pull = separation.pull::<LINEAR>(simd, limit, |reached| {
                *word &= !(reached << within);
                for lane in (0..T::lanes::<S>()).filter(|lane| reached & 1 << lane != 0) {
                    self.row.broken.push((at + lane, number));
                }
            });
            let tension = T::times(simd, T::splat(simd, vector.stiffness), pull);
            for k in 0..D {
                total[k] =
                    T::plus(simd, total[k], T::times(simd, tension, separation.direction[k]));
            }
        }
        for k in 0..D {
            T::store::<S>(total[k], &mut self.row.forces[k], at);
        }
    }
}
