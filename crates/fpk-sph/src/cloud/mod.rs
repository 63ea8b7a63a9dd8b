//! The cloud of particles: where its particles start, their lattice, the metric that gives them coordinates, and how far
//! the lattice must reach.
//!
//! [`Cloud`] is what an estimator sees: particles in the coordinates of the metric, their masses, reach and neighbours.
//! This folder knows positions and masses alone: no estimator, no system and no time step.

pub(crate) mod lattice;
pub(crate) mod metric;
pub(crate) mod reach;
pub(crate) mod start;

use neighbour_search::NeighbourList;

/// Ids of the lattice points one step below and one above along each axis, where there are such.
pub type AxisNeighbours<const D: usize> = [[Option<u32>; 2]; D];

/// A cloud of particles at one stage of one step, in the coordinates of the metric. Borrowed; `n` particles.
#[derive(Debug, Clone, Copy)]
pub struct Cloud<'a, const D: usize> {
    /// Positions `y_i`, `n` points.
    pub positions: &'a [[f64; D]],
    /// Masses `mu_i` (probability), `n` values.
    pub masses: &'a [f64],
    /// Smoothing lengths `h_i`, `n` values.
    pub smoothing_lengths: &'a [f64],
    /// Neighbours of each particle, itself excluded, by the criterion that the estimator asked for.
    pub neighbours: &'a NeighbourList,
    /// The lattice that the particles started from; `n` entries, or none where there is no lattice.
    pub lattice: &'a [AxisNeighbours<D>],
    /// Whether the coordinates are those in which the cloud has the unit covariance.
    pub whitened: bool,
    /// Steps taken and time, for errors.
    pub step: u64,
    /// Time, for errors.
    pub time: f64,
}

impl<const D: usize> Cloud<'_, D> {
    /// Number of particles.
    pub fn n_particles(&self) -> usize {
        self.positions.len()
    }

    /// `x_j - x_i` and the square of its length.
    pub(crate) fn offset(&self, i: usize, j: usize) -> ([f64; D], f64) {
        let (from, to) = (&self.positions[i], &self.positions[j]);
        let mut offset = [0.0; D];
        let mut square = 0.0;
        for k in 0..D {
            offset[k] = to[k] - from[k];
            square += offset[k] * offset[k];
        }
        (offset, square)
    }
}
