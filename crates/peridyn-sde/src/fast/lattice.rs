//! Bonds of a lattice: no list, a stencil and a bit for each bond.

use rayon::prelude::*;
use sde_integrators::SimdLevel;

use super::LaneBits;
use super::lattice_grid::Grid;
use super::lattice_rows::{Band, BandWork};
use super::limit::Limit;
use super::stencil::GROUP;
use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::error::{Error, positive, same_length};
use crate::material::strain::Strain;
use crate::real::Real;

/// A body whose nodes are on a lattice and whose bonds are all alike: of one volume, and one stiffness for each vector between
/// nodes. Their strengths may differ. As [`BondList`](crate::BondList) with one lane, without a list: an evaluation reads one bit of a bond (more
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
    /// The least of all bonds.
    pub(super) strength: f64,
    /// Of each bond, where they differ.
    pub(super) strengths: Vec<f64>,
    grid: Grid<T, D>,
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
        let grid = Grid::new(&nodes, &bonds, &|bond| {
            let of = bonds.all()[bond];
            of.stiffness / of.length
        })?;
        positive("strength of a bond", strength)?;
        let (bands, level) = (grid.bands(), SimdLevel::best());
        let strengths = Vec::new();
        let mut body = Self { nodes, bonds, strain, strength, strengths, grid, bands, level };
        for bond in 0..body.bonds.len() {
            body.set_intact(bond, 1);
        }
        Ok(body)
    }

    /// With a strength (a stretch) for each bond, in the order of [`Bonds::all`]. An evaluation reads them where an elongation is at
    /// the least of them.
    ///
    /// # Errors
    /// [`Error::Length`] where there are not as many as bonds; [`Error::NotPositive`] for a strength.
    pub fn with_strengths(mut self, strengths: &[f64]) -> Result<Self, Error> {
        same_length("strengths", strengths.len(), self.bonds.len())?;
        for band in &mut self.bands {
            band.limits = vec![T::LARGEST; band.intact.len() * GROUP];
        }
        self.strength = f64::INFINITY;
        for (bond, &strength) in strengths.iter().enumerate() {
            positive("strength of a bond", strength)?;
            self.strength = self.strength.min(strength);
            let (band, word, bit) = self.bit(self.bonds.ends(bond));
            let limit = T::of(self.strain.squared_elongation(strength));
            self.bands[band].limits[word * GROUP + bit.trailing_zeros() as usize] = limit;
        }
        self.strengths = strengths.to_vec();
        Ok(self)
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
        let (limit, own) = match limit {
            Limit::Strength => (T::of(self.strain.squared_elongation(self.strength)), true),
            Limit::Unreached => (T::LARGEST, false),
        };
        self.grid.spread(u);
        let (level, Grid { stencil, sites, padded }) = (self.level, &self.grid);
        // A virtual call for a band of many bonds, so that what distributes bands is compiled once.
        let of_band: &(dyn Fn(&mut Band<T, D>) + Sync) = match strain {
            Strain::Finite => &|band| {
                level.run(BandWork::<T, D, false> { band, sites, stencil, padded, limit, own });
            },
            Strain::Linear => &|band| {
                level.run(BandWork::<T, D, true> { band, sites, stencil, padded, limit, own });
            },
        };
        self.bands.par_iter_mut().for_each(of_band);
        for next in 1..self.bands.len() {
            let (before, after) = self.bands.split_at_mut(next);
            after[0].add(&before[next - 1]);
        }
        self.grid.collect(|band| &self.bands[band], forces);
        for band in &mut self.bands {
            let found = band.reached.drain(..);
            let grid = &self.grid;
            reached.extend(found.filter_map(|(at, v)| grid.reached(&self.bonds, at, v)));
        }
        Ok(())
    }

    /// Where the bit of a bond is: band, word and bit.
    pub(super) fn bit(&self, pair: (usize, usize)) -> (usize, usize, LaneBits) {
        self.grid.bit(pair)
    }
}
