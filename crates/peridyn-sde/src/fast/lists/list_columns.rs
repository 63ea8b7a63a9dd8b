//! The numbers of bonds that a force evaluation reads.

use simd_lanes::MOST_LANES;

use crate::bodies::bonds::{Bond, Bonds};
use crate::error::{Error, positive, same_length};
use crate::material::strain::Strain;
use crate::real::Real;

/// Constants of bonds, shared by all lanes or one for each.
#[derive(Debug, Clone)]
pub(in crate::fast) struct Columns<T> {
    /// `1/|xi|^2`; with one lane zero where the bond is broken, so that its elongation is zero.
    pub(in crate::fast) inverse_squares: Vec<T>,
    /// Stiffness over length; one for each bond, or for each bond and lane.
    pub(in crate::fast) stiffness: Vec<T>,
    /// The relative squared elongation at which a bond breaks; as many.
    pub(in crate::fast) limits: Vec<T>,
    /// Whether there is one for each lane.
    pub(in crate::fast) own: bool,
}

impl<T: Real> Columns<T> {
    /// The same constants in all `L` lanes.
    pub(in crate::fast) fn new<const L: usize>(
        bonds: &Bonds,
        strain: Strain,
        strengths: &[f64],
    ) -> Result<Self, Error> {
        let mut columns = Self {
            inverse_squares: bonds.all().iter().map(inverse_square).collect(),
            stiffness: bonds.all().iter().map(|b| T::of(b.stiffness / b.length)).collect(),
            limits: limits(strain, strengths, bonds.len())?,
            own: false,
        };
        if L == 1 {
            // Registers that begin at the last bonds end within the columns.
            columns.inverse_squares.extend([T::ZERO; MOST_LANES]);
            columns.stiffness.extend([T::ZERO; MOST_LANES]);
            columns.limits.extend([T::LARGEST; MOST_LANES]);
        }
        Ok(columns)
    }

    /// Gives each lane its own stiffness and limits.
    pub(in crate::fast) fn separate_lanes<const L: usize>(&mut self) {
        if !self.own {
            self.own = true;
            for column in [&mut self.stiffness, &mut self.limits] {
                *column = column.iter().flat_map(|&value| [value; L]).collect();
            }
        }
    }

    /// Where stiffness and limit of a bond in a lane are.
    pub(in crate::fast) fn at<const L: usize>(&self, bond: usize, lane: usize) -> usize {
        if self.own { bond * L + lane } else { bond }
    }
}

pub(in crate::fast) fn inverse_square<T: Real>(bond: &Bond) -> T {
    T::of(1.0 / (bond.length * bond.length))
}

/// The relative squared elongations at which bonds of these strengths break.
pub(in crate::fast) fn limits<T: Real>(
    strain: Strain,
    strengths: &[f64],
    n_bonds: usize,
) -> Result<Vec<T>, Error> {
    same_length("strengths", strengths.len(), n_bonds)?;
    strengths
        .iter()
        .map(|&strength| {
            positive("strength of a bond", strength)?;
            Ok(T::of(strain.squared_elongation(strength)))
        })
        .collect()
}
