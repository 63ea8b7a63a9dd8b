//! Neighbours from a tree of leaves.

use crate::compiled::searches;
use crate::domain::Domain;
use crate::error::Error;
use crate::leaves::Leaves;
use crate::radii::Radii;
use crate::rows::{Rows, lists_rows};

/// Points in the leaves of a balanced tree: the search for a radius per point.
///
/// The points are halved along the widest axis of their box until sixteen are left; the tree is walked once for each leaf,
/// whose candidates are gathered for all of its points. Every node knows the largest radius in it, so that a few points
/// that see far cost the others nothing.
///
/// Time: O(n log n + candidates). Memory beside the list: about `24 D + 30` bytes per point. With one radius for all
/// [`CellGrid`](crate::CellGrid) is two to four times faster.
#[derive(Debug, Clone, Default)]
pub struct LeafTree<const D: usize> {
    pub(crate) leaves: Leaves<D>,
    rows: Rows<D>,
}

impl<const D: usize> LeafTree<D> {
    /// A tree in a space without end that has seen no points; its first build allocates.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A tree in a space that may be periodic.
    #[must_use]
    pub fn in_domain(domain: Domain<D>) -> Self {
        Self { leaves: Leaves::new(domain), rows: Rows::default() }
    }
}

lists_rows!(LeafTree, leaves, "leaves");
