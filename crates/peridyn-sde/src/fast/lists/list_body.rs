//! A list of bonds as a body: its passes over all bonds are those that are compiled with this crate.

use super::list::BondList;
use super::list_columns::inverse_square;
use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::breaking::crossing::Crossing;
use crate::compiled::lists;
use crate::error::Error;
use crate::material::strain::Strain;
use crate::real::Real;

impl<T: Real, const D: usize, const L: usize> Body<T, D, L> for BondList<T, D, L> {
    fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        &self.bonds
    }

    fn forces(&mut self, u: &[T], forces: &mut [T], at: AtStrength<'_>) -> Result<(), Error> {
        (lists().pull)(self, self.strain, u, forces, at)
    }

    fn intact(&self, bond: usize) -> u16 {
        self.intact[bond]
    }

    fn set_intact(&mut self, bond: usize, lanes: u16) {
        self.intact[bond] = lanes;
        if L == 1 {
            self.columns.inverse_squares[bond] =
                if lanes & 1 != 0 { inverse_square(&self.bonds.all()[bond]) } else { T::ZERO };
        }
    }

    fn strain(&self) -> Strain {
        self.strain
    }

    fn strength(&self, bond: usize, lane: usize) -> f64 {
        self.strain.stretch(self.columns.limits[self.columns.at::<L>(bond, lane)].to_f64())
    }

    fn energy(&self, u: &[T], lane: usize) -> f64 {
        let mut energy = 0.0;
        for (bond, ends) in self.bonds.pairs().enumerate() {
            if self.intact[bond] & 1 << lane != 0 {
                let stretch = self.stretch(bond, ends, u, lane);
                let stiffness = self.columns.stiffness[self.columns.at::<L>(bond, lane)].to_f64();
                let length = self.bonds.all()[bond].length;
                energy += 0.5 * stiffness * length * length * stretch * stretch;
            }
        }
        energy
    }

    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        (lists().pull)(self, Strain::Linear, v, forces, AtStrength::Hold)
    }

    fn advance(
        &mut self,
        from: &[T],
        to: &[T],
        _dt: f64,
        crossing: Option<&mut Crossing<L>>,
        broken: &mut Vec<BrokenBond>,
    ) -> Result<(), Error> {
        (lists().cross)(self, from, to, crossing, broken)
    }
}
