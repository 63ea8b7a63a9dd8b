//! Bonds of a lattice: no list, a stencil and a bit for each bond.

use rayon::prelude::*;
use sde_integrators::SimdLevel;

use super::lattice_rows::{RowState, RowWork};
use super::list::growth;
use super::stencil::{Sites, Stencil};
use super::strain::Strain;
use super::vectors::dispatch;
use crate::body::{AtStrength, Body, BrokenBond, Cause};
use crate::bonds::{Bonds, cut_numbers};
use crate::crossing::{Crossing, Standing};
use crate::error::{Error, positive, same_length};
use crate::nodes::Nodes;
use crate::real::Real;

/// A body whose nodes stand on a lattice and whose bonds are all alike: of one volume, one strength, and one stiffness for each
/// vector between nodes. As [`BondList`](crate::BondList) with one lane, without a list: an evaluation reads two bits of a bond, one at
/// each end (more for the sites that fill up rows of 16). Besides, [`Bonds`] keeps 20 bytes of a bond that it does not touch.
///
/// Every node sums over all its bonds, so that each is computed from both ends. Both see it at its strength at the same
/// displacements, to the last bit, since `w` does not change when a bond is turned round. Rows of nodes are computed in parallel;
/// the bits do not depend on the number of threads.
#[derive(Debug, Clone)]
pub struct LatticeBody<T, const D: usize> {
    nodes: Nodes<D>,
    bonds: Bonds,
    strain: Strain,
    strength: f64,
    stencil: Stencil<T, D>,
    sites: Sites<D>,
    /// Displacements by component, over all sites.
    padded: [Vec<T>; D],
    rows: Vec<RowState<T, D>>,
    broken: Vec<BrokenBond>,
    level: SimdLevel,
}

impl<T: Real, const D: usize> LatticeBody<T, D> {
    /// A body as yet untouched, whose bonds break at one strength (a stretch).
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
        same_length("nodes", nodes.positions().len(), bonds.n_nodes())?;
        positive("strength of a bond", strength)?;
        let sites = Sites::new(&nodes, &bonds)?;
        let stencil = Stencil::new(&nodes, &bonds, &sites)?;
        let padded = std::array::from_fn(|_| vec![T::ZERO; sites.len()]);
        let mut rows = vec![RowState::new(sites.groups(), stencil.len()); sites.rows().len()];
        for (i, j) in bonds.pairs() {
            for (from, to) in [(i, j), (j, i)] {
                let (row, word, bit) =
                    sites.bit(from, stencil.vector(&sites, (from, to)), stencil.len());
                rows[row].whole[word] |= bit;
            }
        }
        let (broken, level) = (Vec::new(), SimdLevel::best());
        Ok(Self { nodes, bonds, strain, strength, stencil, sites, padded, rows, broken, level })
    }

    /// With the instructions of a level; the bits are the same with any.
    #[must_use]
    pub fn at_level(self, level: SimdLevel) -> Self {
        Self { level, ..self }
    }

    fn evaluate<const LINEAR: bool>(&mut self, u: &[T], forces: &mut [T], at: AtStrength) {
        for (node, u) in u.as_chunks::<D>().0.iter().enumerate() {
            let site = self.sites.of(node);
            for k in 0..D {
                self.padded[k][site] = u[k];
            }
        }
        let limit = match at {
            AtStrength::Break => T::of(self.strain.growth(self.strength)),
            AtStrength::Hold => T::LARGEST,
        };
        let (level, stencil, padded) = (self.level, &self.stencil, &self.padded);
        let starts = self.sites.rows();
        self.rows.par_iter_mut().zip(starts).with_min_len(8).for_each(|(row, &start)| {
            dispatch(level, RowWork::<T, D, LINEAR> { row, start, stencil, padded, limit });
        });
        for (node, force) in forces.as_chunks_mut::<D>().0.iter_mut().enumerate() {
            let (row, at) = self.sites.place(node);
            for k in 0..D {
                force[k] = self.rows[row].forces[k][at];
            }
        }
        self.collect_broken();
    }

    /// Bonds that rows have broken, each from one of its ends.
    fn collect_broken(&mut self) {
        for (row, state) in self.rows.iter_mut().enumerate() {
            for (at, vector) in state.broken.drain(..) {
                let site = self.sites.rows()[row] + at;
                let ends = self.sites.nodes(site, self.stencil.offset(vector));
                // A bond is in the row of one of its nodes, and told of from there.
                if let Some((i, j)) = ends
                    && let Some(bond) = self.bonds.number(i, j)
                {
                    self.broken.push(BrokenBond { bond, lanes: 1, cause: Cause::Stretch });
                }
            }
        }
    }

    /// Takes a bond out.
    fn cut_one(&mut self, bond: usize, cause: Cause) {
        self.set_one(bond, false);
        self.broken.push(BrokenBond { bond, lanes: 1, cause });
    }

    /// Takes a bond out or puts it in, at both its ends.
    fn set_one(&mut self, bond: usize, whole: bool) {
        let (i, j) = self.bonds.ends(bond);
        for (from, to) in [(i, j), (j, i)] {
            let vector = self.stencil.vector(&self.sites, (from, to));
            let (row, word, bit) = self.sites.bit(from, vector, self.stencil.len());
            let word = &mut self.rows[row].whole[word];
            *word = if whole { *word | bit } else { *word & !bit };
        }
    }

    fn is_whole(&self, (i, j): (usize, usize)) -> bool {
        let vector = self.stencil.vector(&self.sites, (i, j));
        let (row, word, bit) = self.sites.bit(i, vector, self.stencil.len());
        self.rows[row].whole[word] & bit != 0
    }
}

impl<T: Real, const D: usize> Body<T, D, 1> for LatticeBody<T, D> {
    fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        &self.bonds
    }

    fn forces(&mut self, u: &[T], forces: &mut [T], at: AtStrength) -> Result<(), Error> {
        same_length("displacements", u.len(), self.bonds.n_nodes() * D)?;
        same_length("forces", forces.len(), u.len())?;
        match self.strain {
            Strain::Finite => self.evaluate::<false>(u, forces, at),
            Strain::Linear => self.evaluate::<true>(u, forces, at),
        }
        Ok(())
    }

    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        same_length("displacements", v.len(), self.bonds.n_nodes() * D)?;
        same_length("forces", forces.len(), v.len())?;
        self.evaluate::<true>(v, forces, AtStrength::Hold);
        Ok(())
    }

    fn advance(
        &mut self,
        from: &[T],
        to: &[T],
        _dt: f64,
        crossing: Option<&mut Crossing<1>>,
    ) -> Result<(), Error> {
        let Some(crossing) = crossing else { return Ok(()) };
        for bond in 0..self.bonds.len() {
            let pair = self.bonds.ends(bond);
            if !self.is_whole(pair) {
                continue;
            }
            let of = &self.bonds.all()[bond];
            let stretch = [from, to].map(|u| {
                let w = growth::<T, D, 1>(&self.nodes, pair, (self.strain, of.length), u, 0);
                self.strain.stretch(w)
            });
            if let Some(cause) =
                crossing.test(bond, 0, Standing { stretch, strength: self.strength })
            {
                self.cut_one(bond, cause);
            }
        }
        Ok(())
    }

    fn cut(&mut self, bonds: &[usize]) -> Result<(), Error> {
        cut_numbers(bonds, self.bonds.len())?;
        for &bond in bonds {
            self.cut_one(bond, Cause::Cut);
        }
        Ok(())
    }

    fn lost(&self, bond: usize, _lane: usize) -> f64 {
        f64::from(!self.is_whole(self.bonds.ends(bond)))
    }

    fn strength(&self, _bond: usize, _lane: usize) -> f64 {
        self.strength
    }

    fn energy(&self, u: &[T], lane: usize) -> f64 {
        let mut energy = 0.0;
        for (pair, of) in self.bonds.pairs().zip(self.bonds.all()) {
            if self.is_whole(pair) {
                let w = growth::<T, D, 1>(&self.nodes, pair, (self.strain, of.length), u, lane);
                energy += 0.5 * of.stiffness * of.length * self.strain.stretch(w).powi(2);
            }
        }
        energy
    }

    fn whole(&self) -> Option<Vec<u16>> {
        Some(self.bonds.pairs().map(|pair| u16::from(self.is_whole(pair))).collect())
    }

    fn set_whole(&mut self, whole: &[u16]) -> Result<(), Error> {
        same_length("saved bonds", whole.len(), self.bonds.len())?;
        for (bond, &whole) in whole.iter().enumerate() {
            self.set_one(bond, whole != 0);
        }
        Ok(())
    }

    fn take_broken(&mut self) -> Vec<BrokenBond> {
        std::mem::take(&mut self.broken)
    }
}
