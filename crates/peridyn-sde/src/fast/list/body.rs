//! A body with a list of bonds, realisations side by side.

use std::marker::PhantomData;

use simd_lanes::{MOST_LANES, SimdLevel};

use super::columns::{Columns, inverse_square};
use super::crossing::{CrossingLimits, MayCross};
use super::lanes::{LaneWork, Realisations};
use super::rows::{OneRealisation, RowWork};
use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::breaking::crossing::{BondOverStep, Crossing};
use crate::breaking::failure::all_lanes;
use crate::error::{Error, positive, same_length};
use crate::fast::bond_force::{Dilatation, Kind, PairForce, Pass, SolidForce};
use crate::fast::potential::Potential;
use crate::fast::{LaneBits, list_of};
use crate::material::strain::Strain;
use crate::real::Real;
use crate::solid::SolidBonds;

/// A body whose bonds break at a critical stretch, `L` realisations side by side in the lanes of wide registers.
///
/// The law is that of [`CriticalStretch`](crate::law::CriticalStretch), written without a root or a division: with the relative
/// squared elongation `w = eta (2 xi + eta)/|xi|^2` a bond pulls by `kappa/r (1 - (1 + w)^(-1/2))` along `xi + eta`, the
/// bracket by a polynomial below `|w| = 0.02` (in `f32` 0.03) and in closed form beyond, and breaks at `w >= (1 + s_0)^2 - 1`.
/// Against the sum in `f64` without a polynomial forces are within 1e-11, in `f32` within 5e-6 of the largest.
///
/// With one lane, the bonds of a node are gathered into registers; with more, every lane is a realisation. `L` is 1, or a multiple
/// of 8 in `f64` and of 16 in `f32`, up to 16. Each realisation may have strengths and stiffnesses of its own. The bits are the same
/// at any level.
///
/// An evaluation reads 30 bytes of a bond in `f64`, 18 in `f32`: the other node (4), three numbers (24 or 12), in which lanes it is
/// intact (2, with one lane not read), shared by all lanes; `16 L` or `8 L` in place of two of the numbers where realisations have
/// their own. Besides, [`Bonds`] keeps 16 bytes of a bond that an evaluation does not touch.
///
/// A linear peridynamic solid ([`BondList::of_solid`]) takes the two visits of all bonds of [`LatticeBody`](crate::LatticeBody). Its
/// realisations may have strengths of their own.
#[derive(Debug, Clone)]
pub struct BondList<T, const D: usize, const L: usize> {
    nodes: Nodes<D>,
    potential: Potential,
    strain: Strain,
    columns: Columns<T>,
    /// In which lanes a bond is intact.
    intact: Vec<LaneBits>,
    /// For each node of a linear peridynamic solid `D^2 A/(m^2 V)`, in the inverse of the unit of moments.
    nodal: Vec<T>,
    /// For each node and lane of a linear peridynamic solid the sum over its bonds, then `tau`.
    tau: Vec<T>,
    /// Computed when first needed.
    crossing_limits: Option<CrossingLimits<T>>,
    /// Bonds that may have crossed their strength, with their ends.
    candidates: Vec<(usize, [usize; 2])>,
    /// Present with one lane.
    one: Option<OneRealisation<T>>,
    level: SimdLevel,
}

impl<T: Real, const D: usize, const L: usize> BondList<T, D, L> {
    /// All lanes alike: an undamaged body with a strength (stretch) for each bond, in the order of [`Bonds::all`].
    ///
    /// # Errors
    /// [`Error::Length`] where nodes, bonds and strengths are not of one body; [`Error::Parameter`] for a strength.
    pub fn new(
        nodes: Nodes<D>,
        bonds: Bonds,
        strain: Strain,
        strengths: &[f64],
    ) -> Result<Self, Error> {
        Self::undamaged(nodes, Potential::Pair(bonds), strain, strengths)
    }

    /// As [`BondList::new`], a linear peridynamic solid.
    ///
    /// # Errors
    /// As [`BondList::new`].
    pub fn of_solid(
        nodes: Nodes<D>,
        solid: SolidBonds,
        strain: Strain,
        strengths: &[f64],
    ) -> Result<Self, Error> {
        Self::undamaged(nodes, Potential::Solid(solid), strain, strengths)
    }

    fn undamaged(
        nodes: Nodes<D>,
        potential: Potential,
        strain: Strain,
        strengths: &[f64],
    ) -> Result<Self, Error> {
        const {
            assert!(L == 1 || L.is_multiple_of(8) && L <= MOST_LANES, "1, 8 or 16 lanes");
        }
        let bonds = potential.bonds();
        same_length("nodes", nodes.positions().len(), bonds.n_nodes())?;
        let (mut nodal, mut tau, mut n_pulls) = (Vec::new(), Vec::new(), 0);
        if let Some(solid) = potential.solid() {
            let unit = solid.moment_unit();
            nodal = solid.nodal().iter().map(|&n| T::of(n * unit)).collect();
            tau = vec![T::ZERO; bonds.n_nodes() * L];
            n_pulls = bonds.len();
        }
        Ok(Self {
            columns: Columns::new::<L>(&potential, strain, strengths)?,
            intact: vec![all_lanes::<L>(); bonds.len()],
            nodal,
            tau,
            one: (L == 1).then(|| OneRealisation::new(&nodes, n_pulls)),
            nodes,
            potential,
            strain,
            crossing_limits: None,
            candidates: Vec::new(),
            level: SimdLevel::best(),
        })
    }

    /// With strengths for each lane.
    ///
    /// # Errors
    /// As [`BondList::new`]; [`Error::Length`] where there are not as many as lanes.
    pub fn with_strengths(mut self, strengths: &[Vec<f64>]) -> Result<Self, Error> {
        same_length("lanes of strengths", strengths.len(), L)?;
        self.columns.separate_lanes::<L>();
        let n_bonds = self.potential.bonds().len();
        for (lane, strengths) in strengths.iter().enumerate() {
            self.columns.set_limits::<L>(self.strain, (lane, strengths), n_bonds)?;
        }
        self.crossing_limits = None;
        Ok(self)
    }

    /// With stiffnesses times a factor for each bond and lane.
    ///
    /// # Errors
    /// [`Error::Length`] where there are not as many as lanes and bonds; [`Error::Parameter`] for a factor;
    /// [`Error::UniformStiffness`] for a linear peridynamic solid.
    pub fn with_stiffness_factors(mut self, factors: &[Vec<f64>]) -> Result<Self, Error> {
        if self.potential.solid().is_some() {
            return Err(Error::UniformStiffness { law: "a linear peridynamic solid" });
        }
        same_length("lanes of stiffness factors", factors.len(), L)?;
        self.columns.separate_lanes::<L>();
        for (lane, factors) in factors.iter().enumerate() {
            same_length("stiffness factors", factors.len(), self.potential.bonds().len())?;
            for (bond, &factor) in factors.iter().enumerate() {
                positive("stiffness factor of a bond", factor)?;
                let stiffness = &mut self.columns.stiffness[bond * L + lane];
                *stiffness = T::of(stiffness.to_f64() * factor);
            }
        }
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
        self.check(u)?;
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
        if let Potential::Pair(_) = self.potential {
            self.visit::<PairForce, D, LINEAR>((u, &[]), forces, breaks, reached);
            return;
        }
        let first = reached.len();
        let mut tau = std::mem::take(&mut self.tau);
        self.visit::<Dilatation, 1, LINEAR>((u, &[]), &mut tau, breaks, reached);
        let reached = &reached[first..];
        if !reached.is_empty() {
            // Both ends lose them from their dilatation: once more, without them.
            for found in reached {
                self.set_intact(found.bond, self.intact[found.bond] & !found.lanes);
            }
            self.visit::<Dilatation, 1, LINEAR>((u, &[]), &mut tau, false, &mut Vec::new());
        }
        for (tau, &n) in tau.as_chunks_mut::<L>().0.iter_mut().zip(&self.nodal) {
            *tau = tau.map(|sum| n * sum);
        }
        self.visit::<SolidForce, D, LINEAR>((u, &tau), forces, false, &mut Vec::new());
        self.tau = tau;
        for found in reached {
            self.set_intact(found.bond, self.intact[found.bond] | found.lanes);
        }
    }

    /// Visits all bonds under displacements; those at their strength are added to a list if the visit `breaks` bonds.
    fn visit<P: Pass, const M: usize, const LINEAR: bool>(
        &mut self,
        (u, tau): (&[T], &[T]),
        sums: &mut [T],
        breaks: bool,
        reached: &mut Vec<BrokenBond>,
    ) {
        let (level, columns, pass) = (self.level, &self.columns, PhantomData::<P>);
        // By a constant, so that lanes of one realisation are not compiled.
        if L == 1 {
            let (bonds, Some(one)) = (self.potential.bonds(), &mut self.one) else { return };
            level.run_narrow(RowWork::<T, P, D, LINEAR> {
                bonds,
                columns,
                one,
                u,
                tau,
                sums,
                breaks,
                reached,
                pass,
            });
            return;
        }
        let realisations = self.realisations();
        // A linear peridynamic solid has limits of its own in each lane.
        if !matches!(P::KIND, Kind::PairForce) || columns.own {
            level.run(LaneWork::<T, P, D, M, L, LINEAR, true> {
                realisations,
                columns,
                u,
                tau,
                sums,
                breaks,
                reached,
                pass,
            });
        } else {
            level.run(LaneWork::<T, P, D, M, L, LINEAR, false> {
                realisations,
                columns,
                u,
                tau,
                sums,
                breaks,
                reached,
                pass,
            });
        }
    }

    fn realisations(&self) -> Realisations<'_, T, D, L> {
        let Self { nodes, potential, columns, intact, .. } = self;
        let bonds = potential.bonds();
        Realisations { nodes, bonds, inverse_squares: &columns.inverse_squares, intact }
    }

    /// Bonds that may have crossed their strength over a step.
    fn find_candidates(
        &self,
        limits: &CrossingLimits<T>,
        (from, to): (&[T], &[T]),
        found: &mut Vec<(usize, [usize; 2])>,
    ) {
        let bonds = self.potential.bonds();
        if L == 1 {
            for (bond, ends) in bonds.pairs().enumerate() {
                let shape = (ends, bonds.all()[bond].length);
                let gap = |u: &[T]| {
                    let w = self.strain.squared_elongation_of::<T, D, L>(&self.nodes, shape, u, 0);
                    limits.strength[bond].to_f64() - w
                };
                let is_near = || gap(from) * gap(to) <= limits.product[bond].to_f64();
                if self.intact[bond] != 0 && is_near() {
                    found.push((bond, ends.into()));
                }
            }
            return;
        }
        let (level, realisations) = (self.level, self.realisations());
        match self.strain {
            Strain::Finite => {
                level.run(MayCross::<T, D, L, false> { realisations, limits, from, to, found });
            }
            Strain::Linear => {
                level.run(MayCross::<T, D, L, true> { realisations, limits, from, to, found });
            }
        }
    }

    fn check(&self, u: &[T]) -> Result<(), Error> {
        same_length("displacements", u.len(), self.potential.bonds().n_nodes() * D * L)
    }
}

impl<T: Real, const D: usize, const L: usize> Body<T, D, L> for BondList<T, D, L> {
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
        self.intact[bond]
    }

    fn set_intact(&mut self, bond: usize, lanes: u16) {
        self.intact[bond] = lanes;
        if L == 1 {
            let value = |of: T| if lanes & 1 != 0 { of } else { T::ZERO };
            self.columns.inverse_squares[bond] = value(inverse_square(&self.bonds().all()[bond]));
            if let Some(solid) = self.potential.solid() {
                self.columns.weights[bond] = value(T::of(solid.weights()[bond]));
            }
        }
    }

    fn strain(&self) -> Strain {
        self.strain
    }

    fn strength(&self, bond: usize, lane: usize) -> f64 {
        self.strain.stretch(self.columns.limits[self.columns.at::<L>(bond, lane)].to_f64())
    }

    fn energy(&self, u: &[T], lane: usize) -> f64 {
        if let Some(solid) = self.potential.solid() {
            return solid.energies(self, u, lane).iter().sum();
        }
        let mut energy = 0.0;
        for (bond, ends) in self.bonds().pairs().enumerate() {
            if self.intact[bond] & 1 << lane != 0 {
                let stretch = self.stretch(bond, ends, u, lane);
                let stiffness = self.columns.stiffness[self.columns.at::<L>(bond, lane)].to_f64();
                let length = self.bonds().all()[bond].length;
                energy += 0.5 * stiffness * length * length * stretch * stretch;
            }
        }
        energy
    }

    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        self.pull(Strain::Linear, v, forces, AtStrength::Hold)
    }

    fn advance(
        &mut self,
        from: &[T],
        to: &[T],
        _dt: f64,
        crossing: Option<&mut Crossing<L>>,
        broken: &mut Vec<BrokenBond>,
    ) -> Result<(), Error> {
        self.check(from)?;
        self.check(to)?;
        let Some(crossing) = crossing else { return Ok(()) };
        let limits = self.crossing_limits.take().unwrap_or_else(|| {
            CrossingLimits::new(self.strain, self.bonds().len(), crossing, |bond, lane| {
                self.strength(bond, lane)
            })
        });
        let mut candidates = std::mem::take(&mut self.candidates);
        self.find_candidates(&limits, (from, to), &mut candidates);
        for (bond, ends) in candidates.drain(..) {
            for lane in (0..L).filter(|lane| self.intact[bond] & 1 << lane != 0) {
                let stretch = [from, to].map(|u| self.stretch(bond, ends.into(), u, lane));
                let over = BondOverStep { stretch, strength: self.strength(bond, lane) };
                let cause = crossing.test(bond, lane, over);
                broken.extend(cause.map(|cause| BrokenBond { bond, lanes: 1 << lane, cause }));
            }
        }
        (self.candidates, self.crossing_limits) = (candidates, Some(limits));
        Ok(())
    }
}
