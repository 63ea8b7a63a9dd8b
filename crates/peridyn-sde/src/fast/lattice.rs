//! Bonds of a lattice: no list, a stencil and a bit for each bond.

use rayon::prelude::*;
use sde_integrators::SimdLevel;

use super::lattice_rows::{Band, BandWork, Components};
use super::list::growth;
use super::stencil::{Sites, Stencil};
use super::strain::Strain;
use super::vectors::{Mask, dispatch};
use crate::body::{AtStrength, Body, BrokenBond, Cause};
use crate::bonds::{Bonds, cut_numbers};
use crate::crossing::{Crossing, Standing};
use crate::error::{Error, positive, same_length};
use crate::nodes::Nodes;
use crate::real::Real;

/// A body whose nodes stand on a lattice and whose bonds are all alike: of one volume, one strength, and one stiffness for each
/// vector between nodes. As [`BondList`](crate::BondList) with one lane, without a list: an evaluation reads one bit of a bond (more
/// for the sites that fill up rows of 16). Besides, [`Bonds`] keeps 20 bytes of a bond that it does not touch.
///
/// Bonds of one vector from neighbouring nodes are computed side by side, each once, in bands of rows in parallel. What a band pulls
/// with at nodes of the next is added to it afterwards. Where bands begin is the body's, so that the bits do not depend on the number
/// of threads.
#[derive(Debug, Clone)]
pub struct LatticeBody<T, const D: usize> {
    nodes: Nodes<D>,
    bonds: Bonds,
    strain: Strain,
    strength: f64,
    stencil: Stencil<T, D>,
    sites: Sites<D>,
    /// Displacements by component, over all sites.
    padded: Components<T, D>,
    bands: Vec<Band<T, D>>,
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
        let padded = Components::new(sites.len());
        let (n_rows, of_band) = (sites.rows().len(), sites.rows_of_band());
        let bands = (0..n_rows)
            .step_by(of_band)
            .map(|start| Band::new(start..n_rows.min(start + of_band), &sites, stencil.len()));
        let (bands, broken, level) = (bands.collect(), Vec::new(), SimdLevel::best());
        let mut body =
            Self { nodes, bonds, strain, strength, stencil, sites, padded, bands, broken, level };
        for bond in 0..body.bonds.len() {
            body.set_one(bond, true);
        }
        Ok(body)
    }

    /// With the instructions of a level; the bits are the same with any.
    #[must_use]
    pub fn at_level(self, level: SimdLevel) -> Self {
        Self { level, ..self }
    }

    fn evaluate<const LINEAR: bool>(&mut self, u: &[T], forces: &mut [T], at: AtStrength) {
        let limit = match at {
            AtStrength::Break => T::of(self.strain.growth(self.strength)),
            AtStrength::Hold => T::LARGEST,
        };
        self.spread(u);
        let (level, stencil, padded, sites) =
            (self.level, &self.stencil, &self.padded, &self.sites);
        self.bands.par_iter_mut().for_each(|band| {
            dispatch(level, BandWork::<T, D, LINEAR> { band, sites, stencil, padded, limit });
        });
        for next in 1..self.bands.len() {
            let (before, after) = self.bands.split_at_mut(next);
            after[0].add(&before[next - 1]);
        }
        self.collect(forces);
        self.collect_broken();
    }

    /// Displacements of nodes to their sites.
    fn spread(&mut self, u: &[T]) {
        let u = u.as_chunks::<D>().0;
        let padded = self.padded.all_mut();
        for run in self.sites.runs() {
            let u = &u[run.node..run.node + run.length];
            for k in 0..D {
                let padded = &mut padded[k][run.site..run.site + run.length];
                for (padded, u) in padded.iter_mut().zip(u) {
                    *padded = u[k];
                }
            }
        }
    }

    /// Forces at sites to their nodes.
    fn collect(&self, forces: &mut [T]) {
        let forces = forces.as_chunks_mut::<D>().0;
        for run in self.sites.runs() {
            let band = &self.bands[run.row / self.sites.rows_of_band()];
            let (at, forces) =
                (run.site - band.first, &mut forces[run.node..run.node + run.length]);
            for k in 0..D {
                let of_band = &band.forces.all()[k][at..at + run.length];
                for (force, &of_band) in forces.iter_mut().zip(of_band) {
                    force[k] = of_band;
                }
            }
        }
    }

    /// Bonds that bands have broken.
    fn collect_broken(&mut self) {
        for band in &mut self.bands {
            for (site, vector) in band.broken.drain(..) {
                let ends = self.sites.nodes(site, self.stencil.vectors[vector].offset);
                // A bond is in the row of one of its nodes.
                let number = |(i, j)| self.bonds.number(i, j).or_else(|| self.bonds.number(j, i));
                if let Some(bond) = ends.and_then(number) {
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

    /// Takes a bond out or puts it in.
    fn set_one(&mut self, bond: usize, whole: bool) {
        let (band, word, bit) = self.bit(self.bonds.ends(bond));
        let word = &mut self.bands[band].whole[word];
        *word = if whole { *word | bit } else { *word & !bit };
    }

    fn is_whole(&self, pair: (usize, usize)) -> bool {
        let (band, word, bit) = self.bit(pair);
        self.bands[band].whole[word] & bit != 0
    }

    /// Where the bit of a bond is: band, word and bit.
    fn bit(&self, pair: (usize, usize)) -> (usize, usize, Mask) {
        let ends = self.sites.in_order(pair);
        let vector = self.stencil.vector(&self.sites, ends);
        let (row, word, bit) = self.sites.bit(ends.0, vector, self.stencil.len());
        let band = row / self.sites.rows_of_band();
        let of_row = self.sites.groups() * self.stencil.len();
        (band, (row - self.bands[band].rows.start) * of_row + word, bit)
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
