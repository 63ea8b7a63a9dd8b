//! Bonds in a list, realisations side by side.

use sde_integrators::SimdLevel;

use super::list_lanes::InLanes;
use super::list_near::Near;
use super::list_rows::{InRows, Padded};
use super::strain::Strain;
use super::vectors::{MOST_LANES, Mask, dispatch, dispatch_narrow};
use crate::body::{AtStrength, Body, BrokenBond, Cause};
use crate::bonds::{Bond, Bonds, cut_numbers};
use crate::crossing::{Crossing, Standing};
use crate::error::{Error, positive, same_length};
use crate::nodes::Nodes;
use crate::real::Real;

/// A body whose bonds break at a critical stretch, `L` realisations side by side in the lanes of wide registers.
///
/// The law is that of [`CriticalStretch`](crate::law::CriticalStretch), written without a root or a division: with
/// `w = eta (2 xi + eta)/|xi|^2` a bond pulls by `kappa/r (1 - (1 + w)^(-1/2))` along `xi + eta`, the bracket by a polynomial
/// below `|w| = 0.02` (in `f32` 0.03) and in closed form beyond, and breaks at `w >= (1 + s_0)^2 - 1`. Against the sum in `f64`
/// without a polynomial forces are within 1e-11, in `f32` within 5e-6 of the largest.
///
/// With one lane, the bonds of a node are gathered into registers; with more, every lane is a realisation. `L` is 1, or a multiple
/// of 8 in `f64` and of 16 in `f32`, up to 16. Each realisation may have strengths and stiffnesses of its own.
///
/// An evaluation reads 30 bytes of a bond in `f64`, 18 in `f32`: the other node (4), three numbers (24 or 12), in which lanes it is
/// whole (2, with one lane not read), shared by all lanes; `16 L` or `8 L` in place of two of the numbers where realisations have
/// their own. Besides, [`Bonds`] keeps 16 bytes of a bond that an evaluation does not touch.
#[derive(Debug, Clone)]
pub struct BondList<T, const D: usize, const L: usize> {
    nodes: Nodes<D>,
    bonds: Bonds,
    pub(super) strain: Strain,
    pub(super) columns: Columns<T>,
    /// In which lanes a bond is whole.
    pub(super) whole: Vec<Mask>,
    pub(super) broken: Vec<BrokenBond>,
    /// For each bond and lane the growth at which it breaks, and what the product of its distances from that must be below for it
    /// to be looked at; empty until asked for.
    growths: Vec<T>,
    near: Vec<T>,
    /// Bonds to be looked at, with their ends.
    candidates: Vec<(usize, [usize; 2])>,
    /// With one lane.
    padded: Option<Padded<T>>,
    level: SimdLevel,
}

/// What does not change of bonds.
#[derive(Debug, Clone)]
pub(super) struct Columns<T> {
    /// `1/|xi|^2`; with one lane zero where the bond is broken, so that it has not grown.
    pub(super) inverse_squares: Vec<T>,
    /// Stiffness over length; one for each bond, or for each bond and lane.
    pub(super) stiffness: Vec<T>,
    /// The growth `w` at which a bond breaks; as many.
    pub(super) limits: Vec<T>,
    /// Whether there is one for each lane.
    pub(super) own: bool,
}

impl<T: Real> Columns<T> {
    /// Registers that begin at the last bonds end within the columns.
    fn fill_up(&mut self) {
        self.inverse_squares.extend([T::ZERO; MOST_LANES]);
        self.stiffness.extend([T::ZERO; MOST_LANES]);
        self.limits.extend([T::LARGEST; MOST_LANES]);
    }
}

impl<T: Real, const D: usize, const L: usize> BondList<T, D, L> {
    /// All lanes as one: a body as yet untouched, with a strength (stretch) for each bond, in the order of [`Bonds::all`].
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
        let mut columns = Columns {
            inverse_squares: bonds.all().iter().map(inverse_square).collect(),
            stiffness: bonds.all().iter().map(|b| T::of(b.stiffness / b.length)).collect(),
            limits: limits(strain, strengths, bonds.len())?,
            own: false,
        };
        if L == 1 {
            columns.fill_up();
        }
        let whole = vec![all_lanes::<L>(); bonds.len()];
        let level = SimdLevel::best();
        Ok(Self {
            padded: (L == 1).then(|| Padded::new(&nodes)),
            nodes,
            bonds,
            strain,
            columns,
            whole,
            broken: Vec::new(),
            growths: Vec::new(),
            near: Vec::new(),
            candidates: Vec::new(),
            level,
        })
    }

    /// With strengths for each lane.
    ///
    /// # Errors
    /// As [`BondList::new`]; [`Error::Length`] where there are not as many as lanes.
    pub fn with_strengths(mut self, strengths: &[Vec<f64>]) -> Result<Self, Error> {
        same_length("lanes of strengths", strengths.len(), L)?;
        self.own_columns();
        for (lane, strengths) in strengths.iter().enumerate() {
            let limits = limits::<T>(self.strain, strengths, self.bonds.len())?;
            for (bond, limit) in limits.into_iter().enumerate() {
                self.columns.limits[bond * L + lane] = limit;
            }
        }
        self.near.clear();
        self.growths.clear();
        Ok(self)
    }

    /// With stiffnesses times a factor for each bond and lane.
    ///
    /// # Errors
    /// [`Error::Length`] where there are not as many as lanes and bonds; [`Error::NotPositive`] for a factor.
    pub fn with_stiffness_factors(mut self, factors: &[Vec<f64>]) -> Result<Self, Error> {
        same_length("lanes of stiffness factors", factors.len(), L)?;
        self.own_columns();
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

    /// Leaves a lane out: all its bonds are as broken.
    pub(crate) fn leave_out(&mut self, lane: usize) {
        for bond in 0..self.bonds.len() {
            self.set(bond, self.whole[bond] & !(1 << lane));
        }
    }

    /// Says in which lanes a bond is whole.
    fn set(&mut self, bond: usize, whole: Mask) {
        self.whole[bond] = whole;
        if L == 1 {
            let whole = whole & 1 != 0;
            self.columns.inverse_squares[bond] =
                if whole { inverse_square(&self.bonds.all()[bond]) } else { T::ZERO };
        }
    }

    /// With the instructions of a level; the bits are the same with any.
    #[must_use]
    pub fn at_level(self, level: SimdLevel) -> Self {
        Self { level, ..self }
    }

    fn own_columns(&mut self) {
        let columns = &mut self.columns;
        if !columns.own {
            columns.own = true;
            for column in [&mut columns.stiffness, &mut columns.limits] {
                *column = column.iter().flat_map(|&value| [value; L]).collect();
            }
        }
    }

    fn evaluate<const LINEAR: bool>(&mut self, u: &[T], forces: &mut [T], at: AtStrength) {
        let level = self.level;
        let graph = (&self.nodes, &self.bonds);
        let (whole, broken) = (&mut self.whole[..], &mut self.broken);
        let columns = &mut self.columns;
        if let Some(padded) = &mut self.padded {
            let bonds = &self.bonds;
            let work =
                InRows::<T, D, LINEAR> { bonds, columns, padded, whole, broken, u, forces, at };
            dispatch_narrow(level, work);
        } else if columns.own {
            let work =
                InLanes::<T, D, L, LINEAR, true> { graph, columns, whole, broken, u, forces, at };
            dispatch(level, work);
        } else {
            let work =
                InLanes::<T, D, L, LINEAR, false> { graph, columns, whole, broken, u, forces, at };
            dispatch(level, work);
        }
    }

    /// Bonds that may have crossed their strength over a step.
    fn find_near(
        &mut self,
        crossing: &Crossing<L>,
        from: &[T],
        to: &[T],
        found: &mut Vec<(usize, [usize; 2])>,
    ) {
        if self.near.is_empty() {
            for at in 0..self.bonds.len() * L {
                let strength = self.strength(at / L, at % L);
                // A gap in stretch is at least that in growth over the largest slope below the strength.
                let slope = self.strain.slope(strength);
                self.near.push(T::of(slope * slope * crossing.least_product(at / L)));
                self.growths.push(T::of(self.strain.growth(strength)));
            }
        }
        let (graph, whole) = ((&self.nodes, &self.bonds), &self.whole);
        let limits = (&self.growths[..], &self.near[..]);
        let inverse_squares = &self.columns.inverse_squares;
        if L == 1 {
            for (bond, (i, j)) in self.bonds.pairs().enumerate() {
                let shape = (self.strain, self.bonds.all()[bond].length);
                let gap = |u: &[T]| {
                    let w = growth::<T, D, L>(&self.nodes, (i, j), shape, u, 0);
                    self.growths[bond].to_f64() - w
                };
                if whole[bond] != 0 && gap(from) * gap(to) <= self.near[bond].to_f64() {
                    found.push((bond, [i, j]));
                }
            }
            return;
        }
        match self.strain {
            Strain::Finite => dispatch(
                self.level,
                Near::<T, D, L, false> { graph, inverse_squares, limits, whole, from, to, found },
            ),
            Strain::Linear => dispatch(
                self.level,
                Near::<T, D, L, true> { graph, inverse_squares, limits, whole, from, to, found },
            ),
        }
    }

    fn of_lane(&self, bond: usize, lane: usize) -> usize {
        if self.columns.own { bond * L + lane } else { bond }
    }

    /// The stretch of a bond in a lane.
    fn stretch(&self, bond: usize, pair: (usize, usize), u: &[T], lane: usize) -> f64 {
        let shape = (self.strain, self.bonds.all()[bond].length);
        self.strain.stretch(growth::<T, D, L>(&self.nodes, pair, shape, u, lane))
    }

    fn check(&self, u: &[T]) -> Result<(), Error> {
        same_length("displacements", u.len(), self.bonds.n_nodes() * D * L)
    }
}

impl<T: Real, const D: usize, const L: usize> Body<T, D, L> for BondList<T, D, L> {
    fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        &self.bonds
    }

    fn forces(&mut self, u: &[T], forces: &mut [T], at: AtStrength) -> Result<(), Error> {
        self.check(u)?;
        same_length("forces", forces.len(), u.len())?;
        match self.strain {
            Strain::Finite => self.evaluate::<false>(u, forces, at),
            Strain::Linear => self.evaluate::<true>(u, forces, at),
        }
        Ok(())
    }

    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        self.check(v)?;
        same_length("forces", forces.len(), v.len())?;
        self.evaluate::<true>(v, forces, AtStrength::Hold);
        Ok(())
    }

    fn advance(
        &mut self,
        from: &[T],
        to: &[T],
        _dt: f64,
        crossing: Option<&mut Crossing<L>>,
    ) -> Result<(), Error> {
        self.check(from)?;
        self.check(to)?;
        let Some(crossing) = crossing else { return Ok(()) };
        let mut found = std::mem::take(&mut self.candidates);
        self.find_near(crossing, from, to, &mut found);
        for (bond, pair) in found.drain(..) {
            let pair = pair.into();
            for lane in 0..L {
                if self.whole[bond] & 1 << lane == 0 {
                    continue;
                }
                let stretch = [from, to].map(|u| self.stretch(bond, pair, u, lane));
                let strength = self.strength(bond, lane);
                if let Some(cause) = crossing.test(bond, lane, Standing { stretch, strength }) {
                    self.set(bond, self.whole[bond] & !(1 << lane));
                    self.broken.push(BrokenBond { bond, lanes: 1 << lane, cause });
                }
            }
        }
        self.candidates = found;
        Ok(())
    }

    fn cut(&mut self, bonds: &[usize]) -> Result<(), Error> {
        cut_numbers(bonds, self.bonds.len())?;
        for &bond in bonds {
            self.set(bond, 0);
            self.broken.push(BrokenBond { bond, lanes: all_lanes::<L>(), cause: Cause::Cut });
        }
        Ok(())
    }

    fn lost(&self, bond: usize, lane: usize) -> f64 {
        f64::from(self.whole[bond] & 1 << lane == 0)
    }

    fn strength(&self, bond: usize, lane: usize) -> f64 {
        self.strain.stretch(self.columns.limits[self.of_lane(bond, lane)].to_f64())
    }

    fn energy(&self, u: &[T], lane: usize) -> f64 {
        let mut energy = 0.0;
        for (bond, pair) in self.bonds.pairs().enumerate() {
            if self.whole[bond] & 1 << lane != 0 {
                let stretch = self.stretch(bond, pair, u, lane);
                let stiffness = self.columns.stiffness[self.of_lane(bond, lane)].to_f64();
                let length = self.bonds.all()[bond].length;
                energy += 0.5 * stiffness * length * length * stretch * stretch;
            }
        }
        energy
    }

    fn whole(&self) -> Option<Vec<u16>> {
        Some(self.whole.clone())
    }

    fn set_whole(&mut self, whole: &[u16]) -> Result<(), Error> {
        same_length("saved bonds", whole.len(), self.whole.len())?;
        for (bond, &whole) in whole.iter().enumerate() {
            self.set(bond, whole);
        }
        Ok(())
    }

    fn take_broken(&mut self) -> Vec<BrokenBond> {
        std::mem::take(&mut self.broken)
    }
}

/// The growth `w` of a bond in a lane, from the displacements of its ends.
pub(super) fn growth<T: Real, const D: usize, const L: usize>(
    nodes: &Nodes<D>,
    (i, j): (usize, usize),
    (strain, length): (Strain, f64),
    u: &[T],
    lane: usize,
) -> f64 {
    let x = nodes.positions();
    let mut square = 0.0;
    for k in 0..D {
        let xi = x[j][k] - x[i][k];
        let eta = (u[(j * D + k) * L + lane] - u[(i * D + k) * L + lane]).to_f64();
        square += match strain {
            Strain::Finite => eta * (2.0 * xi + eta),
            Strain::Linear => 2.0 * eta * xi,
        };
    }
    square / (length * length)
}

fn inverse_square<T: Real>(bond: &Bond) -> T {
    T::of(1.0 / (bond.length * bond.length))
}

pub(super) fn all_lanes<const L: usize>() -> Mask {
    Mask::MAX >> (MOST_LANES - L)
}

fn limits<T: Real>(strain: Strain, strengths: &[f64], n_bonds: usize) -> Result<Vec<T>, Error> {
    same_length("strengths", strengths.len(), n_bonds)?;
    strengths
        .iter()
        .map(|&strength| {
            positive("strength of a bond", strength)?;
            Ok(T::of(strain.growth(strength)))
        })
        .collect()
}
