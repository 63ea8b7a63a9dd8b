//! The sites and bond vectors of a lattice, with the displacements at its sites.

use super::band::{Band, Components};
use super::stencil::{Sites, Stencil};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::{BrokenBond, Cause};
use crate::error::{Error, same_length};
use crate::fast::LaneBits;
use crate::real::Real;

/// What all bodies on a lattice read.
#[derive(Debug, Clone)]
pub(super) struct Grid<T, const D: usize> {
    pub(super) stencil: Stencil<T, D>,
    pub(super) sites: Sites<D>,
    /// Displacements by component, over all sites.
    pub(super) padded: Components<T>,
}

impl<T: Real, const D: usize> Grid<T, D> {
    /// Finds the sites of the nodes, and the vectors of bonds with their stiffness over length.
    pub(super) fn new(
        nodes: &Nodes<D>,
        bonds: &Bonds,
        stiffness: &dyn Fn(usize) -> f64,
    ) -> Result<Self, Error> {
        same_length("nodes", nodes.positions().len(), bonds.n_nodes())?;
        let sites = Sites::new(nodes, bonds)?;
        let stencil = Stencil::new(nodes, bonds, &sites, stiffness)?;
        let padded = Components::new(sites.len(), D);
        Ok(Self { stencil, sites, padded })
    }

    /// The rows in bands.
    pub(super) fn bands(&self, is_solid: bool) -> Vec<Band<T>> {
        let (n_rows, of_band) = (self.sites.rows().len(), self.sites.rows_of_band());
        let band = |start: usize| {
            let rows = start..n_rows.min(start + of_band);
            Band::new(rows, &self.sites, self.stencil.len(), is_solid)
        };
        (0..n_rows).step_by(of_band).map(band).collect()
    }

    /// Displacements of nodes to their sites.
    pub(super) fn spread(&mut self, u: &[T]) {
        let u = u.as_chunks::<D>().0;
        let padded = self.padded.all_mut::<D>();
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

    /// Forces of bands at sites to their nodes.
    pub(super) fn collect(&self, bands: &[Band<T>], forces: &mut [T]) {
        let forces = forces.as_chunks_mut::<D>().0;
        for run in self.sites.runs() {
            let band = &bands[run.row / self.sites.rows_of_band()];
            let (at, forces) =
                (run.site - band.first, &mut forces[run.node..run.node + run.length]);
            for (k, of_band) in band.forces.all::<D>().into_iter().enumerate() {
                for (force, &of_band) in forces.iter_mut().zip(&of_band[at..at + run.length]) {
                    force[k] = of_band;
                }
            }
        }
    }

    /// The bond from a site along a vector, found at its limit.
    pub(super) fn reached(&self, bonds: &Bonds, site: usize, vector: usize) -> Option<BrokenBond> {
        let ends = self.sites.nodes(site, self.stencil.vectors[vector].offset);
        // A bond is in the row of one of its nodes.
        let number = |(i, j)| bonds.number(i, j).or_else(|| bonds.number(j, i));
        let bond = ends.and_then(number)?;
        Some(BrokenBond { bond, lanes: 1, cause: Cause::Stretch })
    }

    /// Where the bit of a bond is: band, word and bit.
    pub(super) fn bit(&self, pair: (usize, usize)) -> (usize, usize, LaneBits) {
        let ends = self.sites.in_order(pair);
        let vector = self.stencil.vector(&self.sites, ends);
        let (row, word, bit) = self.sites.bit(ends.0, vector, self.stencil.len());
        let (band, row) = (row / self.sites.rows_of_band(), row % self.sites.rows_of_band());
        (band, row * self.sites.groups() * self.stencil.len() + word, bit)
    }
}
