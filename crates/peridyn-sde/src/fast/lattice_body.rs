//! Bonds of a lattice as a body: its passes over all bonds are those that are compiled with this crate.

use super::lattice::LatticeBody;
use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::compiled::lattices;
use crate::error::Error;
use crate::material::strain::Strain;
use crate::real::Real;

impl<T: Real, const D: usize> LatticeBody<T, D> {
    /// An undamaged body whose bonds break at one strength (a stretch).
    ///
    /// # Errors
    /// [`Error::Length`] where nodes and bonds are not of one body; [`Error::NotPositive`] for the strength;
    /// [`Error::NotLattice`] for a node off the lattice, or bonds of one vector and different stiffness.
    pub fn new(
        nodes: Nodes<D>,
        bonds: Bonds,
        strain: Strain,
        strength: f64,
    ) -> Result<Self, Error> {
        (lattices().new)(nodes, bonds, strain, strength)
    }
}

impl<T: Real, const D: usize> Body<T, D, 1> for LatticeBody<T, D> {
    fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        &self.bonds
    }

    fn forces(&mut self, u: &[T], forces: &mut [T], at: AtStrength<'_>) -> Result<(), Error> {
        (lattices().pull)(self, self.strain, u, forces, at)
    }

    fn intact(&self, bond: usize) -> u16 {
        let (band, word, bit) = self.bit(self.bonds.ends(bond));
        u16::from(self.bands[band].intact[word] & bit != 0)
    }

    fn set_intact(&mut self, bond: usize, lanes: u16) {
        let (band, word, bit) = self.bit(self.bonds.ends(bond));
        let word = &mut self.bands[band].intact[word];
        *word = if lanes & 1 != 0 { *word | bit } else { *word & !bit };
    }

    fn strain(&self) -> Strain {
        self.strain
    }

    fn strength(&self, bond: usize, _lane: usize) -> f64 {
        self.strengths.get(bond).copied().unwrap_or(self.strength)
    }

    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        (lattices().pull)(self, Strain::Linear, v, forces, AtStrength::Hold)
    }
}
