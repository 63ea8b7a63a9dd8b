//! The seam: what a neighbour search does, and the one test that every search decides by.

use core::fmt::Debug;

use crate::domain::Domain;
use crate::error::Error;
use crate::list::{MAX_DIMENSION, NeighbourList};
use crate::radii::Radii;
use crate::row::{Row, visit_list};

/// Finds which points lie within a radius of which.
///
/// `j` is a neighbour of `i` when
///
/// ```text
/// sum over axes of (x_i - x_j)^2  <=  limit(i, j)^2          in f64, axes summed in order from 0
/// ```
///
/// with the limit of [`Radii`] and `x_i - x_j` of the nearest images ([`Domain::difference`]): inclusive, the point itself
/// left out, coincident points neighbours of each other. Whether a point at the very radius is inside is therefore decided
/// by the rounding of that formula. Every implementation finds the same pairs; in which order they stand in a row is its
/// own, and the same for any number of threads.
pub trait NeighbourSearch<const D: usize>: Debug {
    /// Fills `list` with the neighbours of every point.
    ///
    /// `points` in any unit of length, `radii` in the same. Buffers, here and in `list`, are kept: a second build of the
    /// same size allocates nothing. No points, or one, give an empty list.
    ///
    /// # Errors
    ///
    /// [`Error::TooManyPoints`], [`Error::CoordinateNotFinite`], [`Error::UniformRadius`], [`Error::Radius`],
    /// [`Error::RadiiLength`] and [`Error::PeriodTooShort`], for the first point that is at fault. The list is then as it
    /// was.
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error>;

    /// Fills `list` with each pair once, listed under one of its points.
    ///
    /// Provided as the later half of [`full_list`](Self::full_list), under the smaller index.
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

    /// Hands every point to `visit` with all of its neighbours at once: what makes a sweep over pairs fast, without a list
    /// where the search needs none. Points come in an order of the search's own, each once.
    ///
    /// Provided through a list.
    ///
    /// # Errors
    ///
    /// Those of [`full_list`](Self::full_list); nobody has been visited then.
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

/// What every search asks of its input.
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
