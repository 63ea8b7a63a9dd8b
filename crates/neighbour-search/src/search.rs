//! The neighbour search trait, and the distance test common to every search.

use core::fmt::Debug;

use crate::domain::Domain;
use crate::error::Error;
use crate::list::{MAX_DIMENSION, NeighbourList};
use crate::radii::Radii;
use crate::row::{Row, visit_list};

/// Finds all pairs of points within a radius.
///
/// `j` is a neighbour of `i` when
///
/// ```text
/// sum over axes of (x_i - x_j)^2  <=  limit(i, j)^2          in f64, axes summed in order from 0
/// ```
///
/// with the limit of [`Radii`] and `x_i - x_j` of the nearest images ([`Domain::difference`]). The limit is inclusive,
/// the point itself is excluded, and coincident points are neighbours. The rounding of that formula decides about a
/// point exactly at the radius. Every implementation finds the same pairs. The order of a row is specific to the
/// search and independent of the number of threads.
pub trait NeighbourSearch<const D: usize>: Debug {
    /// Fills `list` with the neighbours of every point.
    ///
    /// `points` and `radii` are in the same unit of length. Buffers, here and in `list`, are kept: a second build of
    /// the same size allocates nothing. A cloud of no or one point gives an empty list.
    ///
    /// # Errors
    ///
    /// [`Error::TooManyPoints`], [`Error::CoordinateNotFinite`], [`Error::UniformRadius`], [`Error::Radius`],
    /// [`Error::RadiiLength`] and [`Error::PeriodTooShort`], for the first invalid point. The list is then unchanged.
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error>;

    /// Fills `list` with each pair once, listed under one of its points.
    ///
    /// The default keeps the later half of [`full_list`](Self::full_list), under the smaller index.
    ///
    /// # Errors
    ///
    /// [`Error::NotSymmetric`] for `Gather` and `Scatter`, and those of [`full_list`](Self::full_list).
    fn half_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        radii.check_symmetric()?;
        self.full_list(points, radii, list)?;
        list.keep_later();
        Ok(())
    }

    /// Calls `visit` with every point and all of its neighbours.
    ///
    /// This is the fast way to traverse pairs, and builds no list where the search needs none. The search determines
    /// the order of the points; each is visited once.
    ///
    /// The default builds a list.
    ///
    /// # Errors
    ///
    /// Those of [`full_list`](Self::full_list); `visit` has then not been called, except for
    /// [`TooManyNeighbours`](Error::TooManyNeighbours), which may occur after other rows.
    fn for_each_row(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        visit: &mut dyn FnMut(Row<'_, D>),
    ) -> Result<(), Error> {
        let mut list = NeighbourList::new();
        self.full_list(points, radii, &mut list)?;
        visit_list(&list, points, visit)
    }
}

/// Input checks common to every search.
pub(crate) fn check<const D: usize>(
    points: &[[f64; D]],
    radii: Radii<'_>,
    domain: &Domain<D>,
) -> Result<(), Error> {
    const { assert!(D >= 1 && D <= MAX_DIMENSION, "points have one to six coordinates") };
    if u32::try_from(points.len()).is_err() {
        return Err(Error::TooManyPoints { points: points.len() });
    }
    radii.check(points.len())?;
    domain.check(radii.largest())?;
    let is_finite = |x: &[f64; D]| x.iter().fold(true, |all, value| all & value.is_finite());
    if let Some(particle) = points.iter().position(|x| !is_finite(x)) {
        for (axis, &value) in points[particle].iter().enumerate() {
            if !value.is_finite() {
                return Err(Error::CoordinateNotFinite { particle, axis, value });
            }
        }
    }
    Ok(())
}
