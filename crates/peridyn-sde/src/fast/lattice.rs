//! Bonds of a lattice: no list, a stencil and a bit for each bond.

use rayon::prelude::*;
use sde_integrators::SimdLevel;

use super::LaneBits;
use super::lattice_rows::{Band, BandWork, Components};
use super::limit::Limit;
use super::stencil::{Sites, Stencil};
use crate::body::{AtStrength, Body};
use crate::bonds::Bonds;
use crate::broken_bond::{BrokenBond, Cause};
use crate::error::{Error, positive, same_length};
use crate::nodes::Nodes;
use crate::real::Real;
use crate::strain::Strain;

/// A body whose nodes are on a lattice and whose bonds are all alike: of one volume, one strength, and one stiffness for each
/// vector between nodes. As [`BondList`](crate::BondList) with one lane, without a list: an evaluation reads one bit of a bond (more
/// for the sites that fill up rows of 16). Besides, [`Bonds`] keeps 20 bytes of a bond that it does not touch.
///
/// Bonds of one vector from neighbouring nodes are computed side by side, each once, in bands of rows in parallel. What a band pulls
/// with at nodes of the next is added to it afterwards. Where bands begin is the body's, so that the bits do not depend on the number
/// of threads.
#[derive(Debug, Clone)]
pub struct LatticeBody<T, const D: usize> {
    pub(super) nodes: Nodes<D>,
    pub(super) bonds: Bonds,
    pub(super) strain: Strain,
    pub(super) strength: f64,
    stencil: Stencil<T, D>,
    sites: Sites<D>,
    /// Displacements by component, over all sites.
    padded: Components<T, D>,
    pub(super) bands: Vec<Band<T, D>>,
    level: SimdLevel,
}

impl<T: Real, const D: usize> LatticeBody<T, D> {
    /// Finds the sites of the nodes and cuts their rows into bands.
    pub(crate) fn undamaged(
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
        let (bands, level) = (bands.collect(), SimdLevel::best());
        let mut body =
            Self { nodes, bonds, strain, strength, stencil, sites, padded, bands, level };
        for bond in 0..body.bonds.len() {
            body.set_intact(bond, 1);
        }
        Ok(body)
    }

    /// With the instructions of a level; the bits are the same with any.
    #[must_use]
    pub fn at_level(self, level: SimdLevel) -> Self {
        Self { level, ..self }
    }

    /// Forces under displacements, with strains measured in one way.
    pub(crate) fn pull(
        &mut self,
        strain: Strain,
        u: &[T],
        forces: &mut [T],
        at: AtStrength<'_>,
    ) -> Result<(), Error> {
        same_length("displacements", u.len(), self.bonds.n_nodes() * D)?;
        same_length("forces", forces.len(), u.len())?;
        let mut none = Vec::new();
        let (limit, reached) = Limit::of(at, &mut none);
        let limit = match limit {
            Limit::Strength => T::of(self.strain.squared_elongation(self.strength)),
            Limit::Unreached => T::LARGEST,
        };
        self.spread(u);
        let (level, stencil, padded, sites) =
            (self.level, &self.stencil, &self.padded, &self.sites);
        // A virtual call for a band of many bonds, so that what distributes bands is compiled once.
        let of_band: &(dyn Fn(&mut Band<T, D>) + Sync) = match strain {
            Strain::Finite => &|band| {
                level.run(BandWork::<T, D, false> { band, sites, stencil, padded, limit });
            },
            Strain::Linear => &|band| {
                level.run(BandWork::<T, D, true> { band, sites, stencil, padded, limit });
            },
        };
        self.bands.par_iter_mut().for_each(of_band);
        for next in 1..self.bands.len() {
            let (before, after) = self.bands.split_at_mut(next);
            after[0].add(&before[next - 1]);
        }
        self.collect(forces);
        self.collect_reached(reached);
        Ok(())
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

    /// Bonds that bands have found at their limit.
    fn collect_reached(&mut self, reached: &mut Vec<BrokenBond>) {
        for band in &mut self.bands {
            for (site, vector) in band.reached.drain(..) {
                let ends = self.sites.nodes(site, self.stencil.vectors[vector].offset);
                // A bond is in the row of one of its nodes.
                let number = |(i, j)| self.bonds.number(i, j).or_else(|| self.bonds.number(j, i));
                if let Some(bond) = ends.and_then(number) {
                    reached.push(BrokenBond { bond, lanes: 1, cause: Cause::Stretch });
                }
            }
        }
    }

    /// Where the bit of a bond is: band, word and bit.
    pub(super) fn bit(&self, pair: (usize, usize)) -> (usize, usize, LaneBits) {
        let ends = self.sites.in_order(pair);
        let vector = self.stencil.vector(&self.sites, ends);
        let (row, word, bit) = self.sites.bit(ends.0, vector, self.stencil.len());
        let band = row / self.sites.rows_of_band();
        let of_row = self.sites.groups() * self.stencil.len();
        (band, (row - self.bands[band].rows.start) * of_row + word, bit)
    }
}
