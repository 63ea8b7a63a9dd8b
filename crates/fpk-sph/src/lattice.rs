//! The lattice on which the particles were laid, and who stands near whom on it.

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};
use particle_store::Lattice;

use crate::cloud::AxisNeighbours;
use crate::error::Error;

/// Places of the particles on a lattice, in spacings. It changes when a fresh lattice is laid, and never else.
#[derive(Debug, Clone, Default)]
pub(crate) struct ParticleLattice<const D: usize> {
    /// Whole numbers; one place per particle.
    pub(crate) places: Vec<[f64; D]>,
    pub(crate) axis_neighbours: Vec<AxisNeighbours<D>>,
    /// Who stands within the method's reach of whom, rows ascending, for estimators that work there; else empty.
    pub(crate) neighbours: NeighbourList,
    /// The spacing in the coordinates of the metric when it was laid: the D-th root of a cell's volume.
    pub(crate) spacing: f64,
}

impl<const D: usize> ParticleLattice<D> {
    /// The lattice of the given places.
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

    /// Finds who stands within `reach` spacings of whom.
    pub(crate) fn find_neighbours(&mut self, reach: f64) -> Result<(), Error> {
        self.neighbours = neighbours_on_lattice(&self.places, reach)?;
        Ok(())
    }
}

/// Who stands within `reach` spacings of whom, rows ascending.
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
