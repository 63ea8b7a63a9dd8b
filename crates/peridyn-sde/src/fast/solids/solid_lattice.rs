//! A linear peridynamic solid on a lattice: no list, a stencil and a bit for each bond.

use rayon::prelude::*;
use sde_integrators::SimdLevel;

use super::solid_rows::{ForceWork, Shared, SolidBand, SumWork};
use crate::bodies::body::{AtStrength, Body};
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::error::{Error, positive, same_length};
use crate::fast::LaneBits;
use crate::fast::lattice_grid::Grid;
use crate::fast::lattice_rows::Components;
use crate::fast::limit::Limit;
use crate::material::strain::Strain;
use crate::real::Real;
use crate::solid::SolidBonds;

/// A linear peridynamic solid whose nodes are on a lattice, of one volume and one critical stretch: the law of
/// [`SolidBonds`], as [`SolidList`](crate::SolidList) computes it, without a list.
///
/// An evaluation goes twice through all bonds: for the dilatation of nodes, then for the forces. Neither takes a root or divides
/// where `|w| < 0.02` (in `f32` 0.03): with the pull `p = 1 - (1 + w)^(-1/2)` of [`BondList`](crate::BondList) the stretch is
/// `w - p - w p`, and with `phi = omega beta V^2` and `tau = D A theta/m`
///
/// $$ F_i = \sum_j \phi \left( \left( \frac{B}{m_i} - \tau_i + \frac{B}{m_j} - \tau_j \right) p + \tau_i + \tau_j \right) (\xi + \eta) . $$
///
/// Bands of rows are as in [`LatticeBody`](crate::LatticeBody), and so are the bits: the same with any number of threads and at any
/// level. In a step in which bonds break, the first pass is made twice. Forces are within 1e-11 of the largest of those of the
/// list, in `f32` within 5e-6.
#[derive(Debug, Clone)]
pub struct SolidLattice<T, const D: usize> {
    pub(in crate::fast) nodes: Nodes<D>,
    pub(in crate::fast) solid: SolidBonds,
    pub(in crate::fast) strain: Strain,
    pub(in crate::fast) strength: f64,
    grid: Grid<T, D>,
    /// `phi |xi|^2` of each vector, in the unit of [`SolidBonds::moment_unit`](crate::SolidBonds).
    moments: Vec<T>,
    /// Of each site `B/m`, and `tau` over the sum of its bonds; zero without a node.
    constants: Components<T, 2>,
    /// Of each site `B/m - tau` and `tau` of the last evaluation.
    nodal: Components<T, 2>,
    pub(in crate::fast) bands: Vec<SolidBand<T, D>>,
    level: SimdLevel,
}

impl<T: Real, const D: usize> SolidLattice<T, D> {
    pub(crate) fn undamaged(
        nodes: Nodes<D>,
        solid: SolidBonds,
        strain: Strain,
        strength: f64,
    ) -> Result<Self, Error> {
        let weights = solid.weights();
        let grid: Grid<T, D> = Grid::new(&nodes, solid.bonds(), &|bond| weights[bond])?;
        positive("strength of a bond", strength)?;
        let (unit, vectors) = (solid.moment_unit(), grid.stencil.vectors.iter());
        let moment = |stiffness: f64, inverse_square: f64| stiffness / inverse_square / unit;
        let moments =
            vectors.map(|of| T::of(moment(of.stiffness.to_f64(), of.inverse_square.to_f64())));
        let moments = moments.collect();
        let mut constants = Components::new(grid.sites.len());
        let [own, of_sum] = constants.all_mut();
        for node in 0..nodes.positions().len() {
            let site = grid.sites.of(node);
            own[site] = T::of(solid.distortion(node));
            of_sum[site] = T::of(solid.nodal()[node] * unit);
        }
        let nodal = Components::new(grid.sites.len());
        let bands = grid.bands().into_iter().map(SolidBand::new).collect();
        let level = SimdLevel::best();
        let mut body =
            Self { nodes, solid, strain, strength, grid, moments, constants, nodal, bands, level };
        for bond in 0..body.solid.bonds().len() {
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
        same_length("displacements", u.len(), self.solid.bonds().n_nodes() * D)?;
        same_length("forces", forces.len(), u.len())?;
        match strain {
            Strain::Finite => self.evaluate::<false>(u, forces, at),
            Strain::Linear => self.evaluate::<true>(u, forces, at),
        }
        Ok(())
    }

    fn evaluate<const LINEAR: bool>(&mut self, u: &[T], forces: &mut [T], at: AtStrength<'_>) {
        let mut none = Vec::new();
        let (limit, reached) = Limit::of(at, &mut none);
        self.grid.spread(u);
        let first = reached.len();
        if let Limit::Strength = limit {
            let limit = T::of(self.strain.squared_elongation(self.strength));
            self.sum::<LINEAR>(limit, reached);
        } else {
            self.sum::<LINEAR>(T::LARGEST, reached);
        }
        let reached = &reached[first..];
        if !reached.is_empty() {
            // Both ends lose them from their dilatation: once more, without them.
            self.set_all(reached, 0);
            self.sum::<LINEAR>(T::LARGEST, &mut Vec::new());
        }
        self.find_dilatations();
        self.add_forces::<LINEAR>(forces);
        self.set_all(reached, 1);
    }

    fn set_all(&mut self, bonds: &[BrokenBond], lanes: u16) {
        for found in bonds {
            self.set_intact(found.bond, lanes);
        }
    }

    /// What both passes read, and the bands that they write.
    fn parts(&mut self) -> (SimdLevel, Shared<'_, T, D>, &mut [SolidBand<T, D>]) {
        let Grid { stencil, sites, padded } = &self.grid;
        let (moments, nodal) = (&self.moments[..], &self.nodal);
        (self.level, Shared { sites, stencil, moments, padded, nodal }, &mut self.bands)
    }

    /// The first pass; bonds at their limit are added to a list.
    fn sum<const LINEAR: bool>(&mut self, limit: T, reached: &mut Vec<BrokenBond>) {
        let (level, shared, bands) = self.parts();
        // A virtual call for a band of many bonds, so that what distributes bands is compiled once.
        let of_band: &(dyn Fn(&mut SolidBand<T, D>) + Sync) =
            &|band| level.run(SumWork::<T, D, LINEAR> { shared, band, limit });
        bands.par_iter_mut().for_each(of_band);
        for next in 1..bands.len() {
            let (before, after) = bands.split_at_mut(next);
            after[0].add_sums(&before[next - 1]);
        }
        for band in &mut self.bands {
            let (grid, bonds) = (&self.grid, self.solid.bonds());
            let found = band.band.reached.drain(..);
            reached.extend(found.filter_map(|(at, v)| grid.reached(bonds, at, v)));
        }
    }

    /// From sums to `B/m - tau` and `tau`.
    fn find_dilatations(&mut self) {
        let ([own, of_sum], [sigma, tau]) = (self.constants.all(), self.nodal.all_mut());
        for run in self.grid.sites.runs() {
            let of = &self.bands[run.row / self.grid.sites.rows_of_band()];
            let [sums] = of.sums.all();
            for site in run.site..run.site + run.length {
                tau[site] = of_sum[site] * sums[site - of.band.first];
                sigma[site] = own[site] - tau[site];
            }
        }
    }

    /// The second pass.
    fn add_forces<const LINEAR: bool>(&mut self, forces: &mut [T]) {
        let (level, shared, bands) = self.parts();
        let of_band: &(dyn Fn(&mut SolidBand<T, D>) + Sync) =
            &|band| level.run(ForceWork::<T, D, LINEAR> { shared, band });
        bands.par_iter_mut().for_each(of_band);
        for next in 1..bands.len() {
            let (before, after) = bands.split_at_mut(next);
            after[0].band.add(&before[next - 1].band);
        }
        self.grid.collect(|band| &self.bands[band].band, forces);
    }

    /// Where the bit of a bond is: band, word and bit.
    pub(in crate::fast) fn bit(&self, pair: (usize, usize)) -> (usize, usize, LaneBits) {
        self.grid.bit(pair)
    }
}
