//! Dilatation and forces of a list of bonds of a linear peridynamic solid, a realisation in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{MOST_LANES, Registers, Work};

use super::solid_rows::intact;
use crate::breaking::broken_bond::{BrokenBond, Cause};
use crate::fast::limit::Limit;
use crate::fast::realisations::Realisations;
use crate::real::Real;

/// Constants of bonds.
#[derive(Debug, Clone)]
pub(in crate::fast) struct SolidColumns<T> {
    /// `1/|xi|^2`; with one lane zero where the bond is broken, so that its elongation is zero.
    pub(in crate::fast) inverse_squares: Vec<T>,
    /// `omega beta V_i V_j`; with one lane zero where the bond is broken.
    pub(in crate::fast) weights: Vec<T>,
    /// The same times `|xi|^2`, in the unit of [`SolidBonds::moment_unit`](crate::SolidBonds).
    pub(in crate::fast) moments: Vec<T>,
    /// Stiffness over length.
    pub(in crate::fast) stiffness: Vec<T>,
    /// The relative squared elongation at which a bond breaks, for each bond and lane.
    pub(in crate::fast) limits: Vec<T>,
}

impl<T: Real> SolidColumns<T> {
    /// Registers that begin at the last bonds end within the columns.
    pub(in crate::fast) fn fill_registers(&mut self) {
        let Self { inverse_squares, weights, moments, stiffness, limits } = self;
        for column in [inverse_squares, weights, moments, stiffness] {
            column.extend([T::ZERO; MOST_LANES]);
        }
        limits.extend([T::LARGEST; MOST_LANES]);
    }
}

/// The first pass: `sum omega beta V_i V_j |xi|^2 s` of each node and lane.
pub(in crate::fast) struct SumLanes<'a, T, const D: usize, const L: usize, const LINEAR: bool> {
    pub(in crate::fast) realisations: Realisations<'a, T, D, L>,
    pub(in crate::fast) columns: &'a SolidColumns<T>,
    pub(in crate::fast) u: &'a [T],
    pub(in crate::fast) sums: &'a mut [T],
    pub(in crate::fast) limit: Limit,
    /// Bonds found at their limit, which are to be left out in another pass.
    pub(in crate::fast) reached: &'a mut Vec<BrokenBond>,
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> Work<T>
    for SumLanes<'_, T, D, L, LINEAR>
{
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(mut self, registers: R) {
        self.sums.fill(T::ZERO);
        for first in (0..L).step_by(R::N) {
            for node in 0..self.realisations.bonds.n_nodes() {
                self.row(registers, node, first);
            }
        }
    }
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> SumLanes<'_, T, D, L, LINEAR> {
    #[inline(always)]
    fn row<R: Registers<T>>(&mut self, registers: R, i: usize, first: usize) {
        let all = self.realisations;
        let u_i = Realisations::<T, D, L>::of_node(registers, self.u, i, first);
        let mut total = registers.load_at(self.sums, i * L + first);
        for bond in all.bonds.row(i) {
            let j = all.bonds.partner(bond);
            let moved = (self.u, &u_i);
            let elongation =
                all.separation::<R, LINEAR>(registers, (bond, [i, j]), moved, first).elongation;
            let limit = match self.limit {
                Limit::Strength => registers.load_at(&self.columns.limits, bond * L + first),
                Limit::Unreached => registers.splat(T::LARGEST),
            };
            let w = elongation.0;
            let pull = elongation.pull::<R, LINEAR>(
                registers,
                limit,
                || limit,
                |reached| {
                    let lanes = reached << first;
                    self.reached.push(BrokenBond { bond, lanes, cause: Cause::Stretch });
                },
            );
            // sqrt(1 + w) - 1 = (1 + w) (1 - p) - 1.
            let stretch = if LINEAR { pull } else { w - (pull + w * pull) };
            let part = registers.splat(self.columns.moments[bond]) * stretch;
            total = total + part;
            let other = registers.load_at(self.sums, j * L + first);
            registers.store_at(other + part, self.sums, j * L + first);
        }
        registers.store_at(total, self.sums, i * L + first);
    }
}

/// The second: forces under `u`.
pub(in crate::fast) struct ForceLanes<'a, T, const D: usize, const L: usize, const LINEAR: bool> {
    pub(in crate::fast) realisations: Realisations<'a, T, D, L>,
    pub(in crate::fast) columns: &'a SolidColumns<T>,
    pub(in crate::fast) u: &'a [T],
    /// `tau = D A theta/m` of each node and lane.
    pub(in crate::fast) tau: &'a [T],
    pub(in crate::fast) forces: &'a mut [T],
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> Work<T>
    for ForceLanes<'_, T, D, L, LINEAR>
{
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<T>>(mut self, registers: R) {
        self.forces.fill(T::ZERO);
        for first in (0..L).step_by(R::N) {
            for node in 0..self.realisations.bonds.n_nodes() {
                self.row(registers, node, first);
            }
        }
    }
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool> ForceLanes<'_, T, D, L, LINEAR> {
    #[inline(always)]
    fn row<R: Registers<T>>(&mut self, registers: R, i: usize, first: usize) {
        let (all, columns) = (self.realisations, self.columns);
        let at = |node: usize, k: usize| Realisations::<T, D, L>::at(node, k, first);
        let u_i = Realisations::<T, D, L>::of_node(registers, self.u, i, first);
        let tau_i = registers.load_at(self.tau, i * L + first);
        let mut total = Realisations::<T, D, L>::of_node(registers, self.forces, i, first);
        let unreached = registers.splat(T::LARGEST);
        for bond in all.bonds.row(i) {
            let j = all.bonds.partner(bond);
            let moved = (self.u, &u_i);
            let separation = all.separation::<R, LINEAR>(registers, (bond, [i, j]), moved, first);
            let pull =
                separation.elongation.pull::<R, LINEAR>(registers, unreached, || unreached, |_| ());
            let tau = tau_i + registers.load_at(self.tau, j * L + first);
            let of_dilatation = registers.splat(columns.weights[bond]) * tau;
            let stiffness = registers.splat(columns.stiffness[bond]);
            // With linear strains the tension of the dilatation acts along xi at rest.
            let own = if LINEAR { stiffness } else { stiffness - of_dilatation };
            let tension = own * pull + of_dilatation;
            let tension = intact(registers, tension, all.intact[bond] >> first);
            for k in 0..D {
                let force = tension * separation.direction[k];
                total[k] = total[k] + force;
                let other = registers.load_at(self.forces, at(j, k));
                registers.store_at(other - force, self.forces, at(j, k));
            }
        }
        for k in 0..D {
            registers.store_at(total[k], self.forces, at(i, k));
        }
    }
}
