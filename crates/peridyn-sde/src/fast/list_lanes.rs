//! Forces of a list of bonds, a realisation in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use pulp::{Simd, WithSimd};

use super::bond_force::Separation;
use super::limit::Limit;
use super::list_columns::Columns;
use super::vectors::Mask;
use crate::bonds::Bonds;
use crate::broken_bond::{BrokenBond, Cause};
use crate::nodes::Nodes;
use crate::real::Real;

/// Forces under `u`, as many realisations at a time as a register holds.
pub(super) struct InLanes<
    'a,
    T,
    const D: usize,
    const L: usize,
    const LINEAR: bool,
    const OWN: bool,
> {
    pub(super) graph: (&'a Nodes<D>, &'a Bonds),
    pub(super) columns: &'a Columns<T>,
    pub(super) intact: &'a [Mask],
    pub(super) u: &'a [T],
    pub(super) forces: &'a mut [T],
    pub(super) limit: Limit,
    /// Bonds found at their limit.
    pub(super) reached: &'a mut Vec<BrokenBond>,
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool, const OWN: bool> WithSimd
    for InLanes<'_, T, D, L, LINEAR, OWN>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.forces.fill(T::ZERO);
        for first in (0..L).step_by(T::lanes::<S>()) {
            for node in 0..self.graph.1.n_nodes() {
                self.row(simd, node, first);
            }
        }
    }
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool, const OWN: bool>
    InLanes<'_, T, D, L, LINEAR, OWN>
{
    /// Bonds in the row of a node, in the lanes from `first` on.
    #[inline(always)]
    fn row<S: Simd>(&mut self, simd: S, i: usize, first: usize) {
        let (nodes, bonds) = self.graph;
        let (x, zero) = (nodes.positions(), T::splat(simd, T::ZERO));
        let at = |node: usize, k: usize| (node * D + k) * L + first;
        let (mut u_i, mut total) = ([zero; D], [zero; D]);
        for k in 0..D {
            u_i[k] = T::load::<S>(self.u, at(i, k));
            total[k] = T::load::<S>(self.forces, at(i, k));
        }
        for bond in bonds.row(i) {
            let j = bonds.partner(bond);
            let (mut xi, mut eta) = ([zero; D], [zero; D]);
            for k in 0..D {
                xi[k] = T::splat(simd, T::of(x[j][k] - x[i][k]));
                eta[k] = T::minus(simd, T::load::<S>(self.u, at(j, k)), u_i[k]);
            }
            let inverse_square = T::splat(simd, self.columns.inverse_squares[bond]);
            let intact = self.intact[bond] >> first;
            let mut separation =
                Separation::<T, S, D>::new::<LINEAR>(simd, (&xi, inverse_square), &eta, intact);
            let limit = self.limit(simd, bond, first);
            let pull = separation.elongation.pull::<LINEAR>(simd, limit, |reached| {
                let lanes = reached << first;
                self.reached.push(BrokenBond { bond, lanes, cause: Cause::Stretch });
            });
            let tension =
                T::times(simd, Self::of(simd, &self.columns.stiffness, bond, first), pull);
            for k in 0..D {
                let force = T::times(simd, tension, separation.direction[k]);
                total[k] = T::plus(simd, total[k], force);
                let other = T::load::<S>(self.forces, at(j, k));
                T::store::<S>(T::minus(simd, other, force), self.forces, at(j, k));
            }
        }
        for k in 0..D {
            T::store::<S>(total[k], self.forces, at(i, k));
        }
    }

    #[inline(always)]
    fn limit<S: Simd>(&self, simd: S, bond: usize, first: usize) -> T::V<S> {
        match self.limit {
            Limit::Strength => Self::of(simd, &self.columns.limits, bond, first),
            Limit::Unreached => T::splat(simd, T::LARGEST),
        }
    }

    #[inline(always)]
    fn of<S: Simd>(simd: S, column: &[T], bond: usize, first: usize) -> T::V<S> {
        if OWN { T::load::<S>(column, bond * L + first) } else { T::splat(simd, column[bond]) }
    }
}
