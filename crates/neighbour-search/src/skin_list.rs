//! A list that outlives small movements.

use crate::cell_grid::CellGrid;
use crate::error::Error;
use crate::list::{NeighbourList, Pair};
use crate::radii::{Radii, in_range};
use crate::search::{NeighbourSearch, check, squared_distance};

/// Relative slack on the wide radius: covers the roundings of two distances and two displacements, each below
/// `(D + 2)` units of 1.1e-16.
const SLACK: f64 = 1.0 + 1e-14;

/// What an update did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Update {
    /// Nobody has moved by more than half of the skin since the last build: the list still holds every pair.
    Reused,
    /// The list is new.
    Rebuilt,
}

/// The pairs within a radius, found again only when a point has moved by more than half of a skin.
///
/// It lists the pairs within radius and skin, and hands out those within the radius as the points stand: the same pairs
/// in the same order as a new list. Memory: that of a [`CellGrid`] and a list with radius and skin, and the points at the
/// last build.
///
/// Worth it where the movement of a step is much smaller than the radius: an update without a build is one pass over the
/// points, but every sweep over the pairs passes over `(1 + skin/radius)^D` times as many.
#[derive(Debug, Clone)]
pub struct SkinList<const D: usize> {
    skin: f64,
    radius: f64,
    grid: CellGrid<D>,
    wide: NeighbourList,
    built_at: Vec<[f64; D]>,
}

impl<const D: usize> SkinList<D> {
    /// A list of no points with a skin, unit of length of the points.
    ///
    /// # Errors
    ///
    /// [`Error::Skin`] if it is not between [`MIN_RADIUS`](crate::MIN_RADIUS) and [`MAX_RADIUS`](crate::MAX_RADIUS).
    pub fn new(skin: f64) -> Result<Self, Error> {
        if !in_range(skin) {
            return Err(Error::Skin { value: skin });
        }
        let (grid, wide) = (CellGrid::new(), NeighbourList::new());
        Ok(Self { skin, radius: 0.0, grid, wide, built_at: Vec::new() })
    }

    /// Makes the list hold every pair within `radius` of the points as they stand. Points may be more or fewer than before.
    ///
    /// Without a build it takes one pass over the points; a build of the same size allocates nothing.
    ///
    /// # Errors
    ///
    /// Those of [`full_list`](NeighbourSearch::full_list), the radius being refused with its skin where both together are
    /// too large. The list is then as it was.
    pub fn update(&mut self, points: &[[f64; D]], radius: f64) -> Result<Update, Error> {
        check(points, Radii::Uniform(radius))?;
        let half = 0.5 * self.skin;
        let is_near = |(x, then): (&[f64; D], &[f64; D])| squared_distance(x, then) <= half * half;
        if radius.to_bits() == self.radius.to_bits()
            && points.len() == self.built_at.len()
            && points.iter().zip(&self.built_at).all(is_near)
        {
            return Ok(Update::Reused);
        }
        let wide = Radii::Uniform((radius + self.skin) * SLACK);
        self.grid.full_list(points, wide, &mut self.wide)?;
        self.radius = radius;
        self.built_at.clear();
        self.built_at.extend_from_slice(points);
        Ok(Update::Rebuilt)
    }

    /// The pairs within radius and skin at the last build: no pair within the radius is missing, and there are others.
    #[must_use]
    pub fn candidates(&self) -> &NeighbourList {
        &self.wide
    }

    /// Visits the pairs within the radius, rows in order and neighbours ascending; `points` are those of the last update.
    ///
    /// # Errors
    ///
    /// [`Error::ListLength`] if there are not as many points as at the last update.
    #[inline]
    pub fn for_each_pair(
        &self,
        points: &[[f64; D]],
        mut visit: impl FnMut(Pair<D>),
    ) -> Result<(), Error> {
        let limit = self.radius * self.radius;
        self.wide.for_each_pair(points, |pair| {
            if squared_distance(&pair.x_ij, &[0.0; D]) <= limit {
                visit(pair);
            }
        })
    }
}
