//! The numbers of bonds that a force evaluation reads.

use simd_lanes::MOST_LANES;

use crate::bodies::bonds::Bond;
use crate::error::{Error, positive, same_length};
use crate::fast::potential::Potential;
use crate::material::strain::Strain;
use crate::real::Real;

/// Constants of bonds, shared by all lanes or one for each.
#[derive(Debug, Clone)]
pub(super) struct Columns<T> {
    /// `1/|xi|^2`; with one lane zero where the bond is broken, so that its elongation is zero.
    pub(super) inverse_squares: Vec<T>,
    /// Stiffness over length; one for each bond, or for each bond and lane.
    pub(super) stiffness: Vec<T>,
    /// The relative squared elongation at which a bond breaks, one for each bond, or for each bond and lane.
    pub(super) limits: Vec<T>,
    /// `omega beta V_i V_j` of a linear peridynamic solid; with one lane zero where the bond is broken.
    pub(super) weights: Vec<T>,
    /// The same times `|xi|^2`, in the unit of [`SolidBonds::moment_unit`](crate::SolidBonds).
    pub(super) moments: Vec<T>,
    /// Whether limits, and the stiffness of a pair potential, are one for each lane. Those of a linear peridynamic solid always are.
    pub(super) own: bool,
}

impl<T: Real> Columns<T> {
    /// The same constants in all `L` lanes.
    pub(super) fn new<const L: usize>(
        potential: &Potential,
        strain: Strain,
        strengths: &[f64],
    ) -> Result<Self, Error> {
        let bonds = potential.bonds();
        let mut columns = Self {
            inverse_squares: bonds.all().iter().map(inverse_square).collect(),
            stiffness: bonds.all().iter().map(|b| T::of(b.stiffness / b.length)).collect(),
            limits: limits(strain, strengths, bonds.len())?,
            weights: Vec::new(),
            moments: Vec::new(),
            own: false,
        };
        if let Potential::Solid(solid) = potential {
            let (unit, weights) = (solid.moment_unit(), solid.weights());
            let moment = |(of, w): (&Bond, &f64)| T::of(w * of.length * of.length / unit);
            columns.weights = weights.iter().map(|&weight| T::of(weight)).collect();
            columns.moments = bonds.all().iter().zip(weights).map(moment).collect();
            separate::<T, L>(&mut columns.limits);
            columns.own = true;
        }
        if L == 1 {
            // Registers that begin at the last bonds end within the columns.
            let Self { inverse_squares, stiffness, limits, weights, moments, .. } = &mut columns;
            for column in [inverse_squares, stiffness, weights, moments] {
                column.extend([T::ZERO; MOST_LANES]);
            }
            limits.extend([T::LARGEST; MOST_LANES]);
        }
        Ok(columns)
    }

    /// Gives each lane its own stiffness and limits.
    pub(super) fn separate_lanes<const L: usize>(&mut self) {
        if !self.own {
            self.own = true;
            separate::<T, L>(&mut self.stiffness);
            separate::<T, L>(&mut self.limits);
        }
    }

    /// Sets the limits of a lane.
    pub(super) fn set_limits<const L: usize>(
        &mut self,
        strain: Strain,
        (lane, strengths): (usize, &[f64]),
        n_bonds: usize,
    ) -> Result<(), Error> {
        for (bond, limit) in limits(strain, strengths, n_bonds)?.into_iter().enumerate() {
            self.limits[bond * L + lane] = limit;
        }
        Ok(())
    }

    /// Where limit, and stiffness of a pair potential, of a bond in a lane are.
    pub(super) fn at<const L: usize>(&self, bond: usize, lane: usize) -> usize {
        if self.own { bond * L + lane } else { bond }
    }
}

fn separate<T: Real, const L: usize>(column: &mut Vec<T>) {
    *column = column.iter().flat_map(|&value| [value; L]).collect();
}

pub(super) fn inverse_square<T: Real>(bond: &Bond) -> T {
    T::of(1.0 / (bond.length * bond.length))
}

/// The relative squared elongations at which bonds of these strengths break.
fn limits<T: Real>(strain: Strain, strengths: &[f64], n_bonds: usize) -> Result<Vec<T>, Error> {
    same_length("strengths", strengths.len(), n_bonds)?;
    let limit = |&strength: &f64| {
        positive("strength of a bond", strength)?;
        Ok(T::of(strain.squared_elongation(strength)))
    };
    strengths.iter().map(limit).collect()
}
