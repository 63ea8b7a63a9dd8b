//! Neighbours from a grid of cells.

use crate::cells::Cells;
use crate::compiled::searches;
use crate::domain::Domain;
use crate::error::Error;
use crate::radii::Radii;
use crate::rows::{Rows, lists_rows};

/// Points in the cells of a regular grid: the search for one radius.
///
/// Points are sorted into cells by counting, first axis fastest, so that a row of cells is one stretch of memory. Cells
/// are as wide as the radius, the median radius where each point has its own. There are never more than a few cells per
/// point, whatever the cloud: outliers go to the outermost cells, and a cloud too thin for its radius gets wider ones.
/// The candidates of a cell are gathered once for all of its points.
///
/// Radii of one point may differ from another's: `Gather` scans as far as the points of a cell see, the other criteria as
/// far as anybody sees. Where radii differ by more than about 2 to 1, [`LeafTree`](crate::LeafTree) is faster.
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
    /// A grid in a space without end that has seen no points; its first build allocates.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A grid in a space that may be periodic.
    #[must_use]
    pub fn in_domain(domain: Domain<D>) -> Self {
        Self { cells: Cells::new(domain), rows: Rows::default() }
    }
}

lists_rows!(CellGrid, cells, "cells");
