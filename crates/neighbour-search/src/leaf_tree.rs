//! Neighbours from a tree of leaves.

use crate::domain::Domain;
use crate::error::Error;
use crate::leaves::Leaves;
use crate::list::NeighbourList;
use crate::radii::Radii;
use crate::rows::{Row, Rows};
use crate::search::{NeighbourSearch, check};
use crate::simd::Level;
use crate::sorted::Listed;

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

    /// The same search with only those instructions that every machine has. The lists are the same; it is for comparison.
    #[must_use]
    pub fn with_portable_instructions(self) -> Self {
        Self { rows: Rows::at(Level::Portable), ..self }
    }

    /// The order of the leaves: `order()[slot]` is the point in that slot at the last build. Data in this order lie in
    /// memory as the points lie in space, which makes loops over pairs several times faster.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        self.leaves.ids()
    }

    fn sort(&mut self, points: &[[f64; D]], radii: Radii<'_>) -> Result<(), Error> {
        check(points, radii, self.leaves.domain())?;
        self.leaves.build(points, radii);
        Ok(())
    }
}

impl<const D: usize> NeighbourSearch<D> for LeafTree<D> {
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        self.sort(points, radii)?;
        self.rows.list(&self.leaves, points, radii, Listed::Full, list);
        Ok(())
    }

    /// Written directly: half of the full list's memory and candidates.
    fn half_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        radii.check_symmetric()?;
        self.sort(points, radii)?;
        self.rows.list(&self.leaves, points, radii, Listed::Half, list);
        Ok(())
    }

    /// Without a list, in the order of the leaves.
    fn for_each_row(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        visit: &mut dyn FnMut(Row<'_, D>),
    ) -> Result<(), Error> {
        self.sort(points, radii)?;
        self.rows.visit(&self.leaves, points, radii, visit);
        Ok(())
    }
}
