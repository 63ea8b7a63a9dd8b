//! Bonds in a list, realisations side by side.

use simd_lanes::{MOST_LANES, SimdLevel};

use super::list_columns::{Columns, limits};
use super::list_crossing::{CrossingLimits, MayCross};
use super::list_lanes::InLanes;
use super::list_rows::{InRows, Padded};
use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::breaking::crossing::{BondOverStep, Crossing};
use crate::breaking::failure::all_lanes;
use crate::error::{Error, positive, same_length};
use crate::fast::LaneBits;
use crate::fast::limit::Limit;
use crate::fast::realisations::Realisations;
use crate::material::strain::Strain;
use crate::real::Real;

/// A body whose bonds break at a critical stretch, `L` realisations side by side in the lanes of wide registers.
///
/// The law is that of [`CriticalStretch`](crate::law::CriticalStretch), written without a root or a division: with the relative
/// squared elongation `w = eta (2 xi + eta)/|xi|^2` a bond pulls by `kappa/r (1 - (1 + w)^(-1/2))` along `xi + eta`, the
/// bracket by a polynomial below `|w| = 0.02` (in `f32` 0.03) and in closed form beyond, and breaks at `w >= (1 + s_0)^2 - 1`.
/// Against the sum in `f64` without a polynomial forces are within 1e-11, in `f32` within 5e-6 of the largest.
///
/// With one lane, the bonds of a node are gathered into registers; with more, every lane is a realisation. `L` is 1, or a multiple
/// of 8 in `f64` and of 16 in `f32`, up to 16. Each realisation may have strengths and stiffnesses of its own.
///
/// An evaluation reads 30 bytes of a bond in `f64`, 18 in `f32`: the other node (4), three numbers (24 or 12), in which lanes it is
/// intact (2, with one lane not read), shared by all lanes; `16 L` or `8 L` in place of two of the numbers where realisations have
/// their own. Besides, [`Bonds`] keeps 16 bytes of a bond that an evaluation does not touch.
#[derive(Debug, Clone)]
pub struct BondList<T, const D: usize, const L: usize> {
    pub(in crate::fast) nodes: Nodes<D>,
    pub(in crate::fast) bonds: Bonds,
    pub(in crate::fast) strain: Strain,
    pub(in crate::fast) columns: Columns<T>,
    /// In which lanes a bond is intact.
    pub(in crate::fast) intact: Vec<LaneBits>,
    /// Computed when first needed.
    crossing_limits: Option<CrossingLimits<T>>,
    /// Bonds that may have crossed their strength, with their ends.
    candidates: Vec<(usize, [usize; 2])>,
    /// With one lane.
    padded: Option<Padded<T>>,
    level: SimdLevel,
}

impl<T: Real, const D: usize, const L: usize> BondList<T, D, L> {
    /// All lanes alike: an undamaged body with a strength (stretch) for each bond, in the order of [`Bonds::all`].
    ///
    /// # Errors
    /// [`Error::Length`] where nodes, bonds and strengths are not of one body; [`Error::NotPositive`] for a strength.
    pub fn new(
        nodes: Nodes<D>,
        bonds: Bonds,
        strain: Strain,
        strengths: &[f64],
    ) -> Result<Self, Error> {
        const {
            assert!(L == 1 || L.is_multiple_of(8) && L <= MOST_LANES, "1, 8 or 16 lanes");
        }
        same_length("nodes", nodes.positions().len(), bonds.n_nodes())?;
        Ok(Self {
            columns: Columns::new::<L>(&bonds, strain, strengths)?,
            intact: vec![all_lanes::<L>(); bonds.len()],
            padded: (L == 1).then(|| Padded::new(&nodes)),
            nodes,
            bonds,
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
        for (lane, strengths) in strengths.iter().enumerate() {
            let limits = limits::<T>(self.strain, strengths, self.bonds.len())?;
            for (bond, limit) in limits.into_iter().enumerate() {
                self.columns.limits[bond * L + lane] = limit;
            }
        }
        self.crossing_limits = None;
        Ok(self)
    }

    /// With stiffnesses times a factor for each bond and lane.
    ///
    /// # Errors
    /// [`Error::Length`] where there are not as many as lanes and bonds; [`Error::NotPositive`] for a factor.
    pub fn with_stiffness_factors(mut self, factors: &[Vec<f64>]) -> Result<Self, Error> {
        same_length("lanes of stiffness factors", factors.len(), L)?;
        self.columns.separate_lanes::<L>();
        for (lane, factors) in factors.iter().enumerate() {
            same_length("stiffness factors", factors.len(), self.bonds.len())?;
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
    pub(crate) fn pull(
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
        let (limit, reached) = Limit::of(at, &mut none);
        let (level, columns) = (self.level, &self.columns);
        // By a constant, so that lanes of one realisation are not compiled.
        if L == 1 {
            let (bonds, Some(padded)) = (&self.bonds, &mut self.padded) else { return };
            level.run_narrow(InRows::<T, D, LINEAR> {
                bonds,
                columns,
                padded,
                u,
                forces,
                limit,
                reached,
            });
            return;
        }
        let realisations = self.realisations();
        if columns.own {
            level.run(InLanes::<T, D, L, LINEAR, true> {
                realisations,
                columns,
                u,
                forces,
                limit,
                reached,
            });
        } else {
            level.run(InLanes::<T, D, L, LINEAR, false> {
                realisations,
                columns,
                u,
                forces,
                limit,
                reached,
            });
        }
    }

    fn realisations(&self) -> Realisations<'_, T, D, L> {
        let Self { nodes, bonds, columns, intact, .. } = self;
        Realisations { nodes, bonds, inverse_squares: &columns.inverse_squares, intact }
    }

    /// Bonds that may have crossed their strength over a step.
    fn find_candidates(
        &self,
        limits: &CrossingLimits<T>,
        (from, to): (&[T], &[T]),
        found: &mut Vec<(usize, [usize; 2])>,
    ) {
        if L == 1 {
            for (bond, ends) in self.bonds.pairs().enumerate() {
                let shape = (ends, self.bonds.all()[bond].length);
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
        same_length("displacements", u.len(), self.bonds.n_nodes() * D * L)
    }

    /// Finds bonds that crossed their strength over a step.
    pub(crate) fn cross(
        &mut self,
        from: &[T],
        to: &[T],
        crossing: Option<&mut Crossing<L>>,
        broken: &mut Vec<BrokenBond>,
    ) -> Result<(), Error> {
        self.check(from)?;
        self.check(to)?;
        let Some(crossing) = crossing else { return Ok(()) };
        let limits = self.crossing_limits.take().unwrap_or_else(|| {
            CrossingLimits::new(self.strain, (self.bonds.len(), L), crossing, |bond, lane| {
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
