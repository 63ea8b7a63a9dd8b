//! Bonds of a list that may have crossed their strength in a step, a realisation in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use pulp::{Simd, WithSimd};

use super::bond_force::Separation;
use super::vectors::Mask;
use crate::bonds::Bonds;
use crate::crossing::Crossing;
use crate::nodes::Nodes;
use crate::real::Real;
use crate::strain::Strain;

/// For each bond and lane: which bonds may have crossed their strength over a step.
#[derive(Debug, Clone)]
pub(super) struct CrossingLimits<T> {
    /// `w_0`, the relative squared elongation at the strength.
    pub(super) strength: Vec<T>,
    /// Below it the product `(w_0 - w)(w_0 - w')` needs a test.
    pub(super) product: Vec<T>,
}

impl<T: Real> CrossingLimits<T> {
    /// Of so many bonds and lanes with these strengths.
    pub(super) fn new<const L: usize>(
        strain: Strain,
        (n_bonds, n_lanes): (usize, usize),
        crossing: &Crossing<L>,
        strength: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let mut limits = Self { strength: Vec::new(), product: Vec::new() };
        for at in 0..n_bonds * n_lanes {
            let strength = strength(at / n_lanes, at % n_lanes);
            // A gap in stretch is at least that in elongation over the largest slope below the strength.
            let slope = strain.slope(strength);
            let product = slope * slope * crossing.least_product(at / n_lanes);
            limits.product.push(T::of(product));
            limits.strength.push(T::of(strain.squared_elongation(strength)));
        }
        limits
    }
}

/// Finds the bonds for which `(w_0 - w)(w_0 - w')`, with the relative squared elongations `w` before and `w'` after the step, is
/// below its limit in any lane.
pub(super) struct MayCross<'a, T, const D: usize, const L: usize, const LINEAR: bool> {
    pub(super) graph: (&'a Nodes<D>, &'a Bonds),
    pub(super) inverse_squares: &'a [T],
    pub(super) limits: &'a CrossingLimits<T>,
    pub(super) intact: &'a [Mask],
    pub(super) from: &'a [T],
    pub(super) to: &'a [T],
    /// Bonds with their ends.
    pub(super) found: &'a mut Vec<(usize, [usize; 2])>,
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> WithSimd
    for MayCross<'_, T, D, L, LINEAR>
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

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> MayCross<'_, T, D, L, LINEAR> {
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
        let intact = self.intact[bond] >> first;
        let at = bond * L + first;
        let limit = T::load::<S>(&self.limits.strength, at);
        let near = T::load::<S>(&self.limits.product, at);
        let mut product = T::splat(simd, T::of(1.0));
        for u in [self.from, self.to] {
            let (mut xi, mut eta) = ([zero; D], [zero; D]);
            for k in 0..D {
                xi[k] = T::splat(simd, T::of(x[j][k] - x[i][k]));
                let at = |node: usize| (node * D + k) * L + first;
                eta[k] = T::minus(simd, T::load::<S>(u, at(j)), T::load::<S>(u, at(i)));
            }
            let shape = (&xi, T::splat(simd, self.inverse_squares[bond]));
            let w = Separation::<T, S, D>::new::<LINEAR>(simd, shape, &eta, intact).elongation.0;
            product = T::times(simd, product, T::minus(simd, limit, w));
        }
        let below = T::greater(simd, T::minus(simd, near, product), zero);
        T::any_beyond(simd, below, T::splat(simd, T::SMALLEST))
    }
}
