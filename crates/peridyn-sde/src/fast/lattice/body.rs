//! A body on a lattice.

use std::marker::PhantomData;

use rayon::prelude::*;
use sde_integrators::SimdLevel;

use super::band::{Band, Components};
use super::grid::Grid;
use super::rows::{BandWork, SolidSites};
use super::stencil::GROUP;
use crate::bodies::body::{AtStrength, Body, elastic_energy};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::error::{Error, positive, same_length};
use crate::fast::bond_force::{Dilatation, PairForce, Pass, SolidForce};
use crate::fast::list_of;
use crate::fast::potential::Potential;
use crate::material::strain::Strain;
use crate::real::Real;
use crate::solid::SolidBonds;

/// A body whose nodes are on a lattice and whose bonds are all alike: of one volume, and one stiffness for each vector between
/// nodes. Their strengths may differ. It has the forces of [`BondList`](crate::BondList) with one lane, without a list: an
/// evaluation reads one bit of a bond (more for the sites that fill up rows of 16). Besides, [`Bonds`] keeps 20 bytes of a bond that
/// it does not touch.
///
/// Bonds of one vector from neighbouring nodes are computed side by side, each once, in bands of rows in parallel. The sums of a band
/// at nodes of the next are added to it afterwards. The body decides where bands begin, so that the bits do not depend on the number
/// of threads; nor do they depend on the level.
///
/// A linear peridynamic solid ([`LatticeBody::of_solid`]) takes two visits of all bonds: for the dilatation of nodes, then for the
/// forces. Neither takes a root or divides where `|w| < 0.02` (in `f32` 0.03): with the pull `p = 1 - (1 + w)^(-1/2)` the stretch is
/// `w - p - w p`, and with `phi = omega beta V^2` and `tau = D A theta/m`
///
/// $$ F_i = \sum_j \phi \left( \left( \frac{B}{m_i} - \tau_i + \frac{B}{m_j} - \tau_j \right) p + \tau_i + \tau_j \right) (\xi + \eta) . $$
///
/// In a step in which bonds break, the first visit is made twice. Forces are within 1e-11 of the largest of those of the list, in
/// `f32` within 5e-6.
#[derive(Debug, Clone)]
pub struct LatticeBody<T, const D: usize> {
    nodes: Nodes<D>,
    potential: Potential,
    strain: Strain,
    /// The least of all bonds.
    strength: f64,
    /// The strength of each bond, where they differ.
    strengths: Vec<f64>,
    grid: Grid<T, D>,
    solid: SolidSites<T>,
    bands: Vec<Band<T>>,
    level: SimdLevel,
}

impl<T: Real, const D: usize> LatticeBody<T, D> {
    /// An undamaged body of a pair potential whose bonds break at one strength (a stretch).
    ///
    /// # Errors
    /// [`Error::Length`] where nodes and bonds are not of one body; [`Error::Parameter`] for the strength;
    /// [`Error::NotLattice`] for a node off the lattice, or bonds of one vector and different stiffness.
    pub fn new(
        nodes: Nodes<D>,
        bonds: Bonds,
        strain: Strain,
        strength: f64,
    ) -> Result<Self, Error> {
        let stiffness = |bond: usize| {
            let of = bonds.all()[bond];
            of.stiffness / of.length
        };
        let grid = Grid::new(&nodes, &bonds, &stiffness)?;
        let none = Components::new(0, 2);
        let solid = SolidSites { moments: Vec::new(), constants: none.clone(), nodal: none };
        Self::undamaged(nodes, Potential::Pair(bonds), (strain, strength), grid, solid)
    }

    /// An undamaged linear peridynamic solid whose bonds break at one strength (a stretch).
    ///
    /// # Errors
    /// As [`LatticeBody::new`]; [`Error::NotLattice`] for bonds of one vector and different stiffness, as by unequal volumes or a
    /// surface correction.
    pub fn of_solid(
        nodes: Nodes<D>,
        solid: SolidBonds,
        strain: Strain,
        strength: f64,
    ) -> Result<Self, Error> {
        let weights = solid.weights();
        let grid: Grid<T, D> = Grid::new(&nodes, solid.bonds(), &|bond| weights[bond])?;
        let unit = solid.moment_unit();
        let moments = grid
            .stencil
            .vectors
            .iter()
            .map(|of| T::of(of.stiffness.to_f64() / of.inverse_square.to_f64() / unit));
        let moments = moments.collect();
        let mut constants = Components::new(grid.sites.len(), 2);
        let [own, of_sum] = constants.all_mut();
        for node in 0..nodes.positions().len() {
            let site = grid.sites.of(node);
            own[site] = T::of(solid.distortion(node));
            of_sum[site] = T::of(solid.nodal()[node] * unit);
        }
        let sites = SolidSites { moments, constants, nodal: Components::new(grid.sites.len(), 2) };
        Self::undamaged(nodes, Potential::Solid(solid), (strain, strength), grid, sites)
    }

    fn undamaged(
        nodes: Nodes<D>,
        potential: Potential,
        (strain, strength): (Strain, f64),
        grid: Grid<T, D>,
        solid: SolidSites<T>,
    ) -> Result<Self, Error> {
        positive("strength of a bond", strength)?;
        let bands = grid.bands(potential.solid().is_some());
        let (strengths, level) = (Vec::new(), SimdLevel::best());
        let mut body =
            Self { nodes, potential, strain, strength, strengths, grid, solid, bands, level };
        for bond in 0..body.bonds().len() {
            body.set_intact(bond, 1);
        }
        Ok(body)
    }

    /// With a strength (a stretch) for each bond, in the order of [`Bonds::all`]. An evaluation reads them where an elongation is at
    /// the least of them.
    ///
    /// # Errors
    /// [`Error::Length`] where there are not as many as bonds; [`Error::Parameter`] for a strength.
    pub fn with_strengths(mut self, strengths: &[f64]) -> Result<Self, Error> {
        let bonds = self.potential.bonds();
        same_length("strengths", strengths.len(), bonds.len())?;
        for band in &mut self.bands {
            band.limits = vec![T::LARGEST; band.intact.len() * GROUP];
        }
        self.strength = f64::INFINITY;
        for (bond, &strength) in strengths.iter().enumerate() {
            positive("strength of a bond", strength)?;
            self.strength = self.strength.min(strength);
            let (band, word, bit) = self.grid.bit(bonds.ends(bond));
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
    fn pull(
        &mut self,
        strain: Strain,
        u: &[T],
        forces: &mut [T],
        at: AtStrength<'_>,
    ) -> Result<(), Error> {
        same_length("displacements", u.len(), self.bonds().n_nodes() * D)?;
        same_length("forces", forces.len(), u.len())?;
        match strain {
            Strain::Finite => self.evaluate::<false>(u, forces, at),
            Strain::Linear => self.evaluate::<true>(u, forces, at),
        }
        Ok(())
    }

    fn evaluate<const LINEAR: bool>(&mut self, u: &[T], forces: &mut [T], at: AtStrength<'_>) {
        let mut none = Vec::new();
        let (breaks, reached) = list_of(at, &mut none);
        self.grid.spread(u);
        if let Potential::Pair(_) = self.potential {
            self.visit::<PairForce, D, LINEAR>(breaks, reached);
        } else {
            let first = reached.len();
            self.visit::<Dilatation, 1, LINEAR>(breaks, reached);
            let reached = &reached[first..];
            if !reached.is_empty() {
                // Both ends lose them from their dilatation: once more, without them.
                self.set_all(reached, 0);
                self.visit::<Dilatation, 1, LINEAR>(false, &mut Vec::new());
            }
            self.find_dilatations();
            // Bonds at their strength were found in the first visit, and are broken in this one.
            self.visit::<SolidForce, D, LINEAR>(false, &mut Vec::new());
            self.set_all(reached, 1);
        }
        self.grid.collect(&self.bands, forces);
    }

    fn set_all(&mut self, bonds: &[BrokenBond], lanes: u16) {
        for found in bonds {
            self.set_intact(found.bond, lanes);
        }
    }

    /// Visits all bonds; those at their strength are added to a list if the visit `breaks` bonds.
    fn visit<P: Pass, const M: usize, const LINEAR: bool>(
        &mut self,
        breaks: bool,
        reached: &mut Vec<BrokenBond>,
    ) {
        let limit = self.strain.squared_elongation(self.strength);
        let limit = if breaks { T::of(limit) } else { T::LARGEST };
        let (level, grid, solid) = (self.level, &self.grid, &self.solid);
        // A virtual call for a band of many bonds, so that what distributes bands is compiled once.
        let of_band: &(dyn Fn(&mut Band<T>) + Sync) = &|band| {
            let (own, pass) = (breaks, PhantomData::<P>);
            level.run(BandWork::<T, P, D, M, LINEAR> { grid, solid, band, limit, own, pass });
        };
        self.bands.par_iter_mut().for_each(of_band);
        for next in 1..self.bands.len() {
            let (before, after) = self.bands.split_at_mut(next);
            after[0].add::<P, M>(&mut before[next - 1]);
        }
        let bonds = self.potential.bonds();
        for band in &mut self.bands {
            let found = band.reached.drain(..);
            reached.extend(found.filter_map(|(at, v)| self.grid.reached(bonds, at, v)));
        }
    }

    /// From sums to `B/m - tau` and `tau`.
    fn find_dilatations(&mut self) {
        let SolidSites { constants, nodal, .. } = &mut self.solid;
        let ([own, of_sum], [sigma, tau]) = (constants.all(), nodal.all_mut());
        for run in self.grid.sites.runs() {
            let band = &self.bands[run.row / self.grid.sites.rows_of_band()];
            let [sums] = band.dilatations.all();
            for site in run.site..run.site + run.length {
                tau[site] = of_sum[site] * sums[site - band.first];
                sigma[site] = own[site] - tau[site];
            }
        }
    }
}

impl<T: Real, const D: usize> Body<T, D, 1> for LatticeBody<T, D> {
    fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        self.potential.bonds()
    }

    fn forces(&mut self, u: &[T], forces: &mut [T], at: AtStrength<'_>) -> Result<(), Error> {
        self.pull(self.strain, u, forces, at)
    }

    fn intact(&self, bond: usize) -> u16 {
        let (band, word, bit) = self.grid.bit(self.bonds().ends(bond));
        u16::from(self.bands[band].intact[word] & bit != 0)
    }

    fn set_intact(&mut self, bond: usize, lanes: u16) {
        let (band, word, bit) = self.grid.bit(self.bonds().ends(bond));
        let word = &mut self.bands[band].intact[word];
        *word = if lanes & 1 != 0 { *word | bit } else { *word & !bit };
    }

    fn strain(&self) -> Strain {
        self.strain
    }

    fn strength(&self, bond: usize, _lane: usize) -> f64 {
        self.strengths.get(bond).copied().unwrap_or(self.strength)
    }

    fn energy(&self, u: &[T], lane: usize) -> f64 {
        match self.potential.solid() {
            None => elastic_energy(self, u, lane),
            Some(solid) => solid.energies(self, u, lane).iter().sum(),
        }
    }

    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        self.pull(Strain::Linear, v, forces, AtStrength::Hold)
    }
}
