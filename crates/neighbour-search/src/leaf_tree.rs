//! Neighbour search on a balanced tree.

use crate::compiled::searches;
use crate::domain::Domain;
use crate::error::Error;
use crate::leaves::Leaves;
use crate::radii::Radii;
use crate::rows::{Rows, lists_rows};

/// Search on a balanced tree, for a radius per point.
///
/// Points are halved along the widest axis of their box down to leaves of sixteen. The tree is traversed once for each
/// leaf, whose candidates are gathered for all of its points. Every node stores the largest radius in it, so a few
/// points with large radii add no cost for the others.
///
/// Time: O(n log n + candidates). Memory beside the list: about `24 D + 30` bytes per point. With one radius for all
/// [`CellGrid`](crate::CellGrid) is two to four times faster.
#[derive(Debug, Clone, Default)]
pub struct LeafTree<const D: usize> {
    pub(crate) leaves: Leaves<D>,
    rows: Rows<D>,
}

impl<const D: usize> LeafTree<D> {
    /// A tree without points in an unbounded space; its first build allocates.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A tree without points in a space that may be periodic.
    #[must_use]
    pub fn in_domain(domain: Domain<D>) -> Self {
        Self { leaves: Leaves::new(domain), rows: Rows::default() }
    }
}

lists_rows!(LeafTree, leaves, "leaves");
