//! Forces of a list of bonds, a realisation in every lane.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Registers, Work};

use super::list_columns::Columns;
use crate::breaking::broken_bond::{BrokenBond, Cause};
use crate::fast::limit::Limit;
use crate::fast::realisations::Realisations;
use crate::real::Real;

/// Forces under `u`, as many realisations at a time as a register holds.
pub(in crate::fast) struct InLanes<
    'a,
    T,
    const D: usize,
    const L: usize,
    const LINEAR: bool,
    const OWN: bool,
> {
    pub(in crate::fast) realisations: Realisations<'a, T, D, L>,
    pub(in crate::fast) columns: &'a Columns<T>,
    pub(in crate::fast) u: &'a [T],
    pub(in crate::fast) forces: &'a mut [T],
    pub(in crate::fast) limit: Limit,
    /// Bonds found at their limit.
    pub(in crate::fast) reached: &'a mut Vec<BrokenBond>,
}

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool, const OWN: bool> Work<T>
    for InLanes<'_, T, D, L, LINEAR, OWN>
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

impl<T: Real, const D: usize, const L: usize, const LINEAR: bool, const OWN: bool>
    InLanes<'_, T, D, L, LINEAR, OWN>
{
    /// Bonds in the row of a node, in the lanes from `first` on.
    #[inline(always)]
    fn row<R: Registers<T>>(&mut self, registers: R, i: usize, first: usize) {
        let all = self.realisations;
        let at = |node: usize, k: usize| Realisations::<T, D, L>::at(node, k, first);
        let u_i = Realisations::<T, D, L>::of_node(registers, self.u, i, first);
        let mut total = Realisations::<T, D, L>::of_node(registers, self.forces, i, first);
        for bond in all.bonds.row(i) {
            let j = all.bonds.partner(bond);
            let moved = (self.u, &u_i);
            let separation = all.separation::<R, LINEAR>(registers, (bond, [i, j]), moved, first);
            let limit = self.limit(registers, bond, first);
            let pull = separation.elongation.pull::<R, LINEAR>(
                registers,
                limit,
                || limit,
                |reached| {
                    let lanes = reached << first;
                    self.reached.push(BrokenBond { bond, lanes, cause: Cause::Stretch });
                },
            );
            let tension = Self::of(registers, &self.columns.stiffness, bond, first) * pull;
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

    #[inline(always)]
    fn limit<R: Registers<T>>(&self, registers: R, bond: usize, first: usize) -> R::Vector {
        match self.limit {
            Limit::Strength => Self::of(registers, &self.columns.limits, bond, first),
            Limit::Unreached => registers.splat(T::LARGEST),
        }
    }

    #[inline(always)]
    fn of<R: Registers<T>>(registers: R, column: &[T], bond: usize, first: usize) -> R::Vector {
        if OWN {
            registers.load_at(column, bond * L + first)
        } else {
            registers.splat(column[bond])
        }
    }
}
