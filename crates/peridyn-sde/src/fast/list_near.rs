//! Bonds of a list that may have crossed their strength in a step, a realisation in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use pulp::{Simd, WithSimd};

use super::pull::Separation;
use super::vectors::Mask;
use crate::bonds::Bonds;
use crate::nodes::Nodes;
use crate::real::Real;

/// Finds the bonds for which `(w_0 - w)(w_0 - w')`, with the growths `w` before and `w'` after and `w_0` at the strength, is below
/// `near` in any lane.
pub(super) struct Near<'a, T, const D: usize, const L: usize, const LINEAR: bool> {
    pub(super) graph: (&'a Nodes<D>, &'a Bonds),
    pub(super) inverse_squares: &'a [T],
    /// `w_0` and `near`, for each bond and lane.
    pub(super) limits: (&'a [T], &'a [T]),
    pub(super) whole: &'a [Mask],
    pub(super) from: &'a [T],
    pub(super) to: &'a [T],
    /// Bonds with their ends.
    pub(super) found: &'a mut Vec<(usize, [usize; 2])>,
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> WithSimd
    for Near<'_, T, D, L, LINEAR>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let bonds = self.graph.1;
        for i in 0..bonds.n_nodes() {
            for bond in bonds.row(i) {
                let ends = (i, bonds.partner(bond));
                let (mut first, mut near) = (0, false);
                while first < L {
                    near |= self.is_near(simd, bond, ends, first);
                    first += T::lanes::<S>();
                }
                if near {
                    self.found.push((bond, ends.into()));
                }
            }
        }
    }
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> Near<'_, T, D, L, LINEAR> {
    #[inline(always)]
    fn is_near<S: Simd>(
        &mut self,
        simd: S,
        bond: usize,
        (i, j): (usize, usize),
        first: usize,
    ) -> bool {
        let x = self.graph.0.positions();
        let zero = T::splat(simd, T::ZERO);
        let whole = self.whole[bond] >> first;
        let at = bond * L + first;
        let (limit, near) = (T::load::<S>(self.limits.0, at), T::load::<S>(self.limits.1, at));
        let mut product = T::splat(simd, T::of(1.0));
        for u in [self.from, self.to] {
            let (mut xi, mut eta) = ([zero; D], [zero; D]);
            for k in 0..D {
                xi[k] = T::splat(simd, T::of(x[j][k] - x[i][k]));
                let at = |node: usize| (node * D + k) * L + first;
                eta[k] = T::minus(simd, T::load::<S>(u, at(j)), T::load::<S>(u, at(i)));
            }
            let shape = (&xi, T::splat(simd, self.inverse_squares[bond]));
            let growth = Separation::<T, S, D>::new::<LINEAR>(simd, shape, &eta, whole).growth.0;
            product = T::times(simd, product, T::minus(simd, limit, growth));
        }
        let below = T::greater(simd, T::minus(simd, near, product), zero);
        T::any_beyond(simd, below, T::splat(simd, T::SMALLEST))
    }
}
