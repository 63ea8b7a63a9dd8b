//! A Verlet list: a list with a skin, reused over small movements.

use crate::cell_grid::CellGrid;
use crate::criterion::Criterion;
use crate::domain::{Domain, square};
use crate::error::Error;
use crate::leaf_tree::LeafTree;
use crate::list::{NeighbourList, Pair};
use crate::radii::{Radii, in_range};
use crate::search::{NeighbourSearch, check};

/// Relative tolerance of the enlarged radius.
///
/// It covers the roundings of two distances and two displacements, each below `(D + 2)` units of 1.1e-16.
const SLACK: f64 = 1.0 + 1e-14;

/// Result of an update.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Update {
    /// The list was kept and still holds every pair.
    ///
    /// Points moved and radii grew by less than the skin since the last build.
    Reused,
    /// The list was rebuilt.
    Rebuilt,
}

/// The pairs within a radius, searched again only when points have moved further than a skin allows.
///
/// It lists the pairs within radius plus skin, and visits those within the current radius at the current positions:
/// the pairs of a new list. With `d` the largest displacement since the last build and `g` the largest growth of a
/// radius, no pair is missing while `2 d + g <= skin`. Memory: that of a search and a list for radius plus skin, and
/// of points and radii at the last build. It searches with a [`CellGrid`], or with a [`LeafTree`] where points have
/// individual radii.
///
/// It pays off where the movement in a step is much smaller than the radius. An update without a build is one pass
/// over the points, but every loop over the pairs tests `(1 + skin/radius)^D` times as many.
#[derive(Debug, Clone)]
pub struct SkinList<const D: usize> {
    skin: f64,
    domain: Domain<D>,
    grid: CellGrid<D>,
    tree: LeafTree<D>,
    wide: NeighbourList,
    built_at: Vec<[f64; D]>,
    built_with: Held,
    now: Held,
    wide_radii: Vec<f64>,
}

/// Radii of the last build.
#[derive(Debug, Clone, Default)]
struct Held {
    /// Radius of every point, or one common radius without a criterion.
    radii: Vec<f64>,
    criterion: Option<Criterion>,
}

impl Held {
    fn keep(&mut self, radii: Radii<'_>) {
        self.radii.clear();
        match radii {
            Radii::Uniform(radius) => {
                self.criterion = None;
                self.radii.push(radius);
            }
            Radii::PerPoint { radii, criterion } => {
                self.criterion = Some(criterion);
                self.radii.extend_from_slice(radii);
            }
        }
    }

    fn radii(&self) -> Radii<'_> {
        match self.criterion {
            Some(criterion) => Radii::PerPoint { radii: &self.radii, criterion },
            None => Radii::Uniform(self.radii.first().copied().unwrap_or(0.0)),
        }
    }

    /// Largest growth of a radius, at least 0; infinite if the kinds of radii differ.
    fn growth(&self, radii: Radii<'_>) -> f64 {
        let (criterion, now) = match &radii {
            Radii::Uniform(radius) => (None, core::slice::from_ref(radius)),
            Radii::PerPoint { radii, criterion } => (Some(*criterion), *radii),
        };
        if criterion != self.criterion || now.len() != self.radii.len() {
            return f64::INFINITY;
        }
        now.iter().zip(&self.radii).map(|(now, then)| now - then).fold(0.0, f64::max)
    }
}

impl<const D: usize> SkinList<D> {
    /// A list without points with a skin, unit of length of the points, in an unbounded space.
    ///
    /// # Errors
    ///
    /// [`Error::Skin`] if it is not between [`MIN_RADIUS`](crate::MIN_RADIUS) and [`MAX_RADIUS`](crate::MAX_RADIUS).
    pub fn new(skin: f64) -> Result<Self, Error> {
        Self::in_domain(Domain::unbounded(), skin)
    }

    /// A list without points with a skin, in a space that may be periodic.
    ///
    /// # Errors
    ///
    /// [`Error::Skin`] if it is not between [`MIN_RADIUS`](crate::MIN_RADIUS) and [`MAX_RADIUS`](crate::MAX_RADIUS).
    pub fn in_domain(domain: Domain<D>, skin: f64) -> Result<Self, Error> {
        if !in_range(skin) {
            return Err(Error::Skin { value: skin });
        }
        Ok(Self {
            skin,
            domain,
            grid: CellGrid::in_domain(domain),
            tree: LeafTree::in_domain(domain),
            wide: NeighbourList::new(),
            built_at: Vec::new(),
            built_with: Held::default(),
            now: Held::default(),
            wide_radii: Vec::new(),
        })
    }

    /// Updates the list so that it holds every pair within the current radii. The number of points may change.
    ///
    /// Without a build it takes one pass over the points; a build of the same size allocates nothing.
    ///
    /// # Errors
    ///
    /// Those of [`full_list`](NeighbourSearch::full_list); a radius is also rejected if it is too large together with
    /// the skin. The list is then unchanged.
    pub fn update(&mut self, points: &[[f64; D]], radii: Radii<'_>) -> Result<Update, Error> {
        check(points, radii, &self.domain)?;
        let reserve = 0.5 * (self.skin - self.built_with.growth(radii));
        let is_near = |(x, then): (&[f64; D], &[f64; D])| {
            self.domain.squared_distance(x, then) <= reserve * reserve
        };
        if reserve >= 0.0
            && points.len() == self.built_at.len()
            && points.iter().zip(&self.built_at).all(is_near)
        {
            self.now.keep(radii);
            return Ok(Update::Reused);
        }
        let widened = |radius: f64| (radius + self.skin) * SLACK;
        match radii {
            Radii::Uniform(radius) => {
                self.grid.full_list(points, Radii::Uniform(widened(radius)), &mut self.wide)?;
            }
            Radii::PerPoint { radii, criterion } => {
                self.wide_radii.clear();
                self.wide_radii.extend(radii.iter().map(|&radius| widened(radius)));
                let radii = Radii::PerPoint { radii: &self.wide_radii, criterion };
                self.tree.full_list(points, radii, &mut self.wide)?;
            }
        }
        self.now.keep(radii);
        self.built_with.keep(radii);
        self.built_at.clear();
        self.built_at.extend_from_slice(points);
        Ok(Update::Rebuilt)
    }

    /// The pairs within radius plus skin at the last build: a superset of the pairs within the radius.
    #[must_use]
    pub fn candidates(&self) -> &NeighbourList {
        &self.wide
    }

    /// Visits the pairs within the radius, rows in order; `points` are those of the last update.
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
        let radii = self.now.radii();
        self.wide.for_each_pair(points, |pair| {
            let limit = radii.limit(pair.i, pair.j);
            if square(&pair.x_ij) <= limit * limit {
                visit(pair);
            }
        })
    }
}
