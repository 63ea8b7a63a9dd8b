//! A list of a linear peridynamic solid as a body: its passes over all bonds are those that are compiled with this crate.

use super::solid_list::SolidList;
use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::compiled::solid_lists;
use crate::error::Error;
use crate::material::strain::Strain;
use crate::real::Real;

impl<T: Real, const D: usize, const L: usize> Body<T, D, L> for SolidList<T, D, L> {
    fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        self.all_bonds()
    }

    fn forces(&mut self, u: &[T], forces: &mut [T], at: AtStrength<'_>) -> Result<(), Error> {
        (solid_lists().pull)(self, self.strain, u, forces, at)
    }

    fn intact(&self, bond: usize) -> u16 {
        self.intact[bond]
    }

    fn set_intact(&mut self, bond: usize, lanes: u16) {
        self.set(bond, lanes);
    }

    fn strain(&self) -> Strain {
        self.strain
    }

    fn strength(&self, bond: usize, lane: usize) -> f64 {
        self.strain.stretch(self.columns.limits[bond * L + lane].to_f64())
    }

    fn energy(&self, u: &[T], lane: usize) -> f64 {
        self.solid.energies(self, u, lane).iter().sum()
    }

    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        (solid_lists().pull)(self, Strain::Linear, v, forces, AtStrength::Hold)
    }
}
