//! Neighbour search on a grid of cells.

use crate::cells::Cells;
use crate::compiled::searches;
use crate::domain::Domain;
use crate::error::Error;
use crate::radii::Radii;
use crate::rows::{Rows, lists_rows};

/// Search on a regular cell grid, for one common radius.
///
/// A counting sort places the points in cells, first axis fastest, so a row of cells is contiguous in memory. Cells
/// are as wide as the radius, or as the median radius where each point has its own. The number of cells per point is
/// bounded for every cloud: outliers go to the outermost cells, and a cloud too sparse for its radius gets wider
/// cells. The candidates of a cell are gathered once for all of its points.
///
/// Radii may differ between points: `Gather` scans as far as the radii of the points of a cell, the other criteria as
/// far as the largest radius. Where radii differ by more than about 2 to 1, [`LeafTree`](crate::LeafTree) is faster.
///
/// Time: O(n + candidates), where the candidates are the points in the cells touched, about 9/π (2-D) and 6.4 (3-D)
/// times the neighbours in a uniform cloud. Memory beside the list: about `8 D + 20` bytes per point. In five and six
/// dimensions, and where a few cells hold most points, it tends towards brute force.
#[derive(Debug, Clone, Default)]
pub struct CellGrid<const D: usize> {
    pub(crate) cells: Cells<D>,
    rows: Rows<D>,
}

impl<const D: usize> CellGrid<D> {
    /// A grid without points in an unbounded space; its first build allocates.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A grid without points in a space that may be periodic.
    #[must_use]
    pub fn in_domain(domain: Domain<D>) -> Self {
        Self { cells: Cells::new(domain), rows: Rows::default() }
    }
}

lists_rows!(CellGrid, cells, "cells");
