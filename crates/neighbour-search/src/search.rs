//! The seam: what a neighbour search does, and the one test that every search decides by.

use core::fmt::Debug;

use crate::error::Error;
use crate::list::NeighbourList;
use crate::radii::Radii;

/// Finds which points lie within a radius of which.
///
/// Every implementation gives the same list, bit for bit: `j` is a neighbour of `i` when
///
/// ```text
/// sum over axes of (x_i - x_j)^2  <=  limit(i, j)^2          in f64, axes summed in order from 0
/// ```
///
/// with the limit of [`Radii`]: inclusive, the point itself left out, coincident points neighbours of each other.
/// Whether a point at the very radius is inside is therefore decided by the rounding of that formula.
pub trait NeighbourSearch<const D: usize>: Debug {
    /// Fills `list` with the neighbours of every point, in rows sorted by index.
    ///
    /// `points` in any unit of length, `radii` in the same. Buffers, here and in `list`, are kept: a second build of the
    /// same size allocates nothing. No points, or one, give an empty list.
    ///
    /// # Errors
    ///
    /// [`Error::TooManyPoints`], [`Error::CoordinateNotFinite`], [`Error::UniformRadius`], [`Error::Radius`] and
    /// [`Error::RadiiLength`], for the first point that is at fault. The list is then as it was.
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error>;

    /// Fills `list` with each pair once: `j` is listed under `i` where they are neighbours and `i < j`, rows sorted.
    ///
    /// Provided as the later half of [`full_list`](Self::full_list), with the same buffers.
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
}

/// What every search asks of its input.
pub(crate) fn check<const D: usize>(points: &[[f64; D]], radii: Radii<'_>) -> Result<(), Error> {
    const { assert!(D >= 1, "points need at least one coordinate") };
    if u32::try_from(points.len()).is_err() {
        return Err(Error::TooManyPoints { points: points.len() });
    }
    radii.check(points.len())?;
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

/// `x_i - x_j`.
#[inline]
pub(crate) fn difference<const D: usize>(x_i: &[f64; D], x_j: &[f64; D]) -> [f64; D] {
    core::array::from_fn(|axis| x_i[axis] - x_j[axis])
}

/// `|x_i - x_j|^2`, summed from axis 0: the same bits whichever point comes first.
#[inline]
pub(crate) fn squared_distance<const D: usize>(x_i: &[f64; D], x_j: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for axis in 0..D {
        let along = x_i[axis] - x_j[axis];
        sum += along * along;
    }
    sum
}

/// An index as it is stored.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "no more than u32::MAX points pass the check")]
pub(crate) fn stored(index: usize) -> u32 {
    index as u32
}
