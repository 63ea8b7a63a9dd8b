//! The lattice of the particles, and neighbour lists on it.

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};
use particle_store::Lattice;

use crate::cloud::AxisNeighbours;
use crate::error::Error;

/// Positions of the particles on a lattice, in spacings. Only remeshing changes them.
#[derive(Debug, Clone, Default)]
pub(crate) struct ParticleLattice<const D: usize> {
    /// Integers; one position per particle.
    pub(crate) places: Vec<[f64; D]>,
    pub(crate) axis_neighbours: Vec<AxisNeighbours<D>>,
    /// Neighbours within the method's reach, rows ascending, for estimators on the lattice; otherwise empty.
    pub(crate) neighbours: NeighbourList,
    /// The spacing in the coordinates of the metric when it was laid: the D-th root of a cell's volume.
    pub(crate) spacing: f64,
}

impl<const D: usize> ParticleLattice<D> {
    /// The lattice of the given positions.
    pub(crate) fn new(indices: Vec<[i32; D]>, spacing: f64) -> Self {
        let places: Vec<[f64; D]> = indices.iter().map(|index| index.map(f64::from)).collect();
        let lattice = Lattice { points: places.clone(), indices, spacing: [1.0; D] };
        Self {
            places,
            axis_neighbours: lattice.axis_neighbours(),
            neighbours: NeighbourList::new(),
            spacing,
        }
    }

    /// Finds the neighbours within `reach` spacings.
    pub(crate) fn find_neighbours(&mut self, reach: f64) -> Result<(), Error> {
        self.neighbours = neighbours_on_lattice(&self.places, reach)?;
        Ok(())
    }
}

/// Neighbours within `reach` spacings, rows ascending.
pub(crate) fn neighbours_on_lattice<const D: usize>(
    places: &[[f64; D]],
    reach: f64,
) -> Result<NeighbourList, Error> {
    let mut neighbours = NeighbourList::new();
    CellGrid::new().full_list(places, Radii::Uniform(reach), &mut neighbours)?;
    neighbours.sort_rows();
    Ok(neighbours)
}

/// A place as whole numbers.
#[allow(clippy::cast_possible_truncation, reason = "whole numbers well within the range")]
pub(crate) fn index_of_place<const D: usize>(place: &[f64; D]) -> [i32; D] {
    place.map(|value| value.round() as i32)
}
