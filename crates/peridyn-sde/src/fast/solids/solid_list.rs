//! A linear peridynamic solid in a list of bonds, one realisation or several side by side.

use simd_lanes::{MOST_LANES, SimdLevel};

use super::solid_lanes::{ForceLanes, SolidColumns, SumLanes};
use super::solid_list_rows::{ForceRows, OneRealisation, SumRows};
use crate::bodies::body::AtStrength;
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::breaking::failure::all_lanes;
use crate::error::{Error, same_length};
use crate::fast::LaneBits;
use crate::fast::limit::Limit;
use crate::fast::lists::list_columns::{inverse_square, limits};
use crate::fast::realisations::Realisations;
use crate::material::strain::Strain;
use crate::real::Real;
use crate::solid::SolidBonds;

/// A linear peridynamic solid whose bonds break at a critical stretch, `L` realisations side by side in the lanes of wide registers:
/// the law of [`SolidBonds`], in the two passes of [`SolidLattice`](crate::SolidLattice).
///
/// With one lane, the bonds of a node are gathered into registers; with more, every lane is a realisation. `L` is 1, or a multiple
/// of 8 in `f64` and of 16 in `f32`, up to 16. Each realisation may have strengths of its own. The bits are the same at any level.
#[derive(Debug, Clone)]
pub struct SolidList<T, const D: usize, const L: usize> {
    pub(in crate::fast) nodes: Nodes<D>,
    pub(in crate::fast) solid: SolidBonds,
    pub(in crate::fast) strain: Strain,
    pub(in crate::fast) columns: SolidColumns<T>,
    /// `D^2 A/(m^2 V)` of each node, in the inverse of the unit of moments.
    nodal: Vec<T>,
    /// In which lanes a bond is intact.
    pub(in crate::fast) intact: Vec<LaneBits>,
    /// Of each node and lane: sums of dilatations, then `tau`.
    tau: Vec<T>,
    /// With one lane.
    one: Option<OneRealisation<T>>,
    level: SimdLevel,
}

impl<T: Real, const D: usize, const L: usize> SolidList<T, D, L> {
    /// An undamaged body with strengths (stretch) for each lane and bond, in the order of [`Bonds::all`].
    ///
    /// # Errors
    /// [`Error::Length`] where nodes, bonds and strengths are not of one body, or strengths not as many as lanes;
    /// [`Error::NotPositive`] for a strength.
    pub fn new(
        nodes: Nodes<D>,
        solid: SolidBonds,
        strain: Strain,
        strengths: &[Vec<f64>],
    ) -> Result<Self, Error> {
        const {
            assert!(L == 1 || L.is_multiple_of(8) && L <= MOST_LANES, "1, 8 or 16 lanes");
        }
        let bonds = solid.bonds();
        same_length("nodes", nodes.positions().len(), bonds.n_nodes())?;
        same_length("lanes of strengths", strengths.len(), L)?;
        let mut of_lanes = vec![T::ZERO; bonds.len() * L];
        for (lane, strengths) in strengths.iter().enumerate() {
            let of_lane = limits::<T>(strain, strengths, bonds.len())?;
            for (bond, limit) in of_lane.into_iter().enumerate() {
                of_lanes[bond * L + lane] = limit;
            }
        }
        let weights = bonds.all().iter().zip(solid.weights());
        let unit = solid.moment_unit();
        let mut columns = SolidColumns {
            inverse_squares: bonds.all().iter().map(inverse_square).collect(),
            weights: solid.weights().iter().map(|&weight| T::of(weight)).collect(),
            moments: weights.map(|(of, w)| T::of(w * of.length * of.length / unit)).collect(),
            stiffness: bonds.all().iter().map(|of| T::of(of.stiffness / of.length)).collect(),
            limits: of_lanes,
        };
        if L == 1 {
            columns.fill_registers();
        }
        Ok(Self {
            one: (L == 1).then(|| OneRealisation::new(&nodes, bonds)),
            columns,
            nodal: solid.nodal().iter().map(|&n| T::of(n * unit)).collect(),
            intact: vec![all_lanes::<L>(); bonds.len()],
            tau: vec![T::ZERO; bonds.n_nodes() * L],
            nodes,
            solid,
            strain,
            level: SimdLevel::best(),
        })
    }

    /// With the instructions of a level; the bits are the same with any.
    #[must_use]
    pub fn at_level(self, level: SimdLevel) -> Self {
        Self { level, ..self }
    }

    pub(in crate::fast) fn all_bonds(&self) -> &Bonds {
        self.solid.bonds()
    }

    /// Forces under displacements, with strains measured in one way.
    pub(crate) fn pull(
        &mut self,
        strain: Strain,
        u: &[T],
        forces: &mut [T],
        at: AtStrength<'_>,
    ) -> Result<(), Error> {
        same_length("displacements", u.len(), self.all_bonds().n_nodes() * D * L)?;
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
        let first = reached.len();
        self.sum::<LINEAR>(u, limit, reached);
        let reached = &reached[first..];
        if !reached.is_empty() {
            // Both ends lose them from their dilatation: once more, without them.
            for found in reached {
                self.set(found.bond, self.intact[found.bond] & !found.lanes);
            }
            self.sum::<LINEAR>(u, Limit::Unreached, &mut Vec::new());
        }
        for (tau, &n) in self.tau.as_chunks_mut::<L>().0.iter_mut().zip(&self.nodal) {
            *tau = tau.map(|sum| n * sum);
        }
        let Self { nodes, solid, columns, intact, tau, one, level, .. } = self;
        // By a constant, so that lanes of one realisation are not compiled.
        if L == 1 {
            let (bonds, Some(one)) = (solid.bonds(), one) else { return };
            level.run_narrow(ForceRows::<T, D, LINEAR> { bonds, columns, one, u, tau, forces });
        } else {
            let realisations = realisations(nodes, solid, columns, intact);
            level.run(ForceLanes::<T, D, L, LINEAR> { realisations, columns, u, tau, forces });
        }
        for found in reached {
            self.set(found.bond, self.intact[found.bond] | found.lanes);
        }
    }

    /// Sets in which lanes a bond is intact.
    pub(in crate::fast) fn set(&mut self, bond: usize, lanes: LaneBits) {
        self.intact[bond] = lanes;
        if L == 1 {
            let is_intact = lanes & 1 != 0;
            let value = |of: T| if is_intact { of } else { T::ZERO };
            self.columns.inverse_squares[bond] =
                value(inverse_square(&self.solid.bonds().all()[bond]));
            self.columns.weights[bond] = value(T::of(self.solid.weights()[bond]));
        }
    }

    fn sum<const LINEAR: bool>(&mut self, u: &[T], limit: Limit, reached: &mut Vec<BrokenBond>) {
        let Self { nodes, solid, columns, intact, tau, one, level, .. } = self;
        let sums = &mut tau[..];
        if L == 1 {
            let (bonds, Some(one)) = (solid.bonds(), one) else { return };
            let rows = SumRows::<T, D, LINEAR> { bonds, columns, one, u, sums, limit, reached };
            level.run_narrow(rows);
        } else {
            let realisations = realisations(nodes, solid, columns, intact);
            level.run(SumLanes::<T, D, L, LINEAR> {
                realisations,
                columns,
                u,
                sums,
                limit,
                reached,
            });
        }
    }
}

fn realisations<'a, T: Real, const D: usize, const L: usize>(
    nodes: &'a Nodes<D>,
    solid: &'a SolidBonds,
    columns: &'a SolidColumns<T>,
    intact: &'a [LaneBits],
) -> Realisations<'a, T, D, L> {
    let (bonds, inverse_squares) = (solid.bonds(), &columns.inverse_squares[..]);
    Realisations { nodes, bonds, inverse_squares, intact }
}
