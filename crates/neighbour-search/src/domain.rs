//! The space of the points: unbounded, or periodic along some axes.

use crate::error::Error;
use crate::radii::in_range;

/// A space of `D` axes, each unbounded or periodic.
///
/// Along an axis of period `L` a point at `x` has images at `x + k L` for every integer `k`. The difference
/// `x_i - x_j` is that of the nearest images, between `-L/2` and `L/2`. Points need not lie in one period. Two points
/// are neighbours through at most one image, so no period may be shorter than two radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Domain<const D: usize> {
    periods: [Option<f64>; D],
}

impl<const D: usize> Default for Domain<D> {
    fn default() -> Self {
        Self::unbounded()
    }
}

impl<const D: usize> Domain<D> {
    /// A space unbounded along every axis.
    #[must_use]
    pub const fn unbounded() -> Self {
        Self { periods: [None; D] }
    }

    /// A space with the given periods, unit of length of the points; `None` for an unbounded axis.
    ///
    /// # Errors
    ///
    /// [`Error::Period`] if one is not between [`MIN_RADIUS`](crate::MIN_RADIUS) and [`MAX_RADIUS`](crate::MAX_RADIUS).
    pub fn periodic(periods: [Option<f64>; D]) -> Result<Self, Error> {
        for (axis, period) in periods.iter().enumerate() {
            if let &Some(value) = period
                && !in_range(value)
            {
                return Err(Error::Period { axis, value });
            }
        }
        Ok(Self { periods })
    }

    /// A space with periods already validated.
    pub(crate) const fn of(periods: [Option<f64>; D]) -> Self {
        Self { periods }
    }

    /// The period along each axis.
    #[must_use]
    pub fn periods(&self) -> [Option<f64>; D] {
        self.periods
    }

    /// Whether any axis has a period.
    #[must_use]
    pub fn is_periodic(&self) -> bool {
        self.periods.iter().any(Option::is_some)
    }

    /// `x_i - x_j` of the nearest images.
    #[inline]
    #[must_use]
    pub fn difference(&self, x_i: &[f64; D], x_j: &[f64; D]) -> [f64; D] {
        core::array::from_fn(|axis| match self.periods[axis] {
            None => x_i[axis] - x_j[axis],
            Some(period) => nearest_image(x_i[axis], x_j[axis], period),
        })
    }

    /// `|x_i - x_j|^2` of the nearest images, summed from axis 0; bitwise symmetric in the points.
    #[inline]
    #[must_use]
    pub fn squared_distance(&self, x_i: &[f64; D], x_j: &[f64; D]) -> f64 {
        square(&self.difference(x_i, x_j))
    }

    /// Image of a coordinate in `[0, L]`, up to one rounding; on an unbounded axis the coordinate itself.
    #[inline]
    pub(crate) fn wrap(&self, x: f64, axis: usize) -> f64 {
        match self.periods[axis] {
            None => x,
            Some(period) => x.rem_euclid(period),
        }
    }

    /// Images of all coordinates, as [`wrap`](Self::wrap) computes them.
    #[inline]
    pub(crate) fn wrap_all(&self, x: &[f64; D]) -> [f64; D] {
        core::array::from_fn(|axis| self.wrap(x[axis], axis))
    }

    /// Search distance along each axis that covers a radius with all roundings.
    ///
    /// It covers the roundings of the squared distance and its sum, below `(D + 2)` units of 1.1e-16 each, and those
    /// of images, below 4 units of a period.
    #[inline]
    pub(crate) fn reach(&self, radius: f64) -> [f64; D] {
        core::array::from_fn(|axis| {
            radius * (1.0 + 1e-14) + 1e-14 * self.periods[axis].unwrap_or(0.0)
        })
    }

    /// Whether `x_i - (x_j + shift)`, up to rounding, is the difference `x_ij` of the nearest images.
    #[inline]
    pub(crate) fn is_image(
        &self,
        x_i: &[f64; D],
        x_j: &[f64; D],
        shift: &[f64; D],
        x_ij: &[f64; D],
    ) -> bool {
        (0..D).all(|axis| match self.periods[axis] {
            None => true,
            Some(period) => {
                let along = x_i[axis] - (x_j[axis] + shift[axis]);
                (along - x_ij[axis]).abs() < 0.5 * period
            }
        })
    }

    /// Rejects periods shorter than twice the largest radius.
    pub(crate) fn check(&self, largest: f64) -> Result<(), Error> {
        for (axis, period) in self.periods.iter().enumerate() {
            if let &Some(period) = period
                && period < 2.0 * largest
            {
                return Err(Error::PeriodTooShort { axis, period, least: 2.0 * largest });
            }
        }
        Ok(())
    }
}

/// `|x|^2`, summed from axis 0.
#[inline]
pub(crate) fn square<const D: usize>(x: &[f64; D]) -> f64 {
    x.iter().fold(0.0, |sum, along| sum + along * along)
}

/// `a - b - k period` for the integer `k` that brings it closest to zero.
///
/// In a tie either value may result, with the opposite sign if `a` and `b` are exchanged. It is rounded once, in the
/// difference of the remainders, which cannot overflow.
#[inline]
fn nearest_image(a: f64, b: f64, period: f64) -> f64 {
    let along = rest(a, period) - rest(b, period);
    let (half, along) = (0.5 * period, rest(along, period));
    if along.abs() <= half { along } else { along - period.copysign(along) }
}

/// The remainder with the sign of `x`, which is exact.
#[inline]
fn rest(x: f64, period: f64) -> f64 {
    // The remainder is a slow loop, and most points lie within a period.
    if x.abs() < period { x } else { x % period }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_image_is_exact_odd_and_within_half_a_period() {
        for (along, expected) in
            [(0.25, 0.25), (0.5, 0.5), (0.75, -0.25), (1.0, 0.0), (7.25, 0.25), (1.5, 0.5)]
        {
            for (a, b) in [(along, 0.0), (along + 3.0, 3.0), (along - 0.125, -0.125)] {
                assert!((nearest_image(a, b, 1.0) - expected).abs() == 0.0, "{a} - {b}");
                assert!((nearest_image(b, a, 1.0) + expected).abs() == 0.0, "{b} - {a}");
            }
        }
        // The largest number is even, and 3 divides no power of two: its remainder is 1 or 2.
        assert!((nearest_image(f64::MAX, -f64::MAX, 3.0).abs() - 1.0).abs() == 0.0);
    }

    #[test]
    fn difference_takes_the_nearest_image_along_periodic_axes_only() {
        let domain = Domain::periodic([Some(1.0), None]).unwrap();
        let found = domain.difference(&[0.9375, 0.9375], &[0.0625, 0.0625]);
        assert_eq!(found.map(f64::to_bits), [-0.125_f64, 0.875].map(f64::to_bits));
        let squared = domain.squared_distance(&[0.9375, 0.9375], &[0.0625, 0.0625]);
        assert!((squared - (0.015625 + 0.765625)).abs() == 0.0);
    }

    #[test]
    fn period_that_is_no_length_is_refused_with_its_axis() {
        for value in [0.0, -1.0, f64::INFINITY, 1e200] {
            let refused = Domain::periodic([None, Some(value)]);
            assert_eq!(refused, Err(Error::Period { axis: 1, value }));
        }
        let domain = Domain::periodic([Some(1.0), Some(3.0)]).unwrap();
        assert_eq!(domain.check(0.5), Ok(()));
        let too_short = Error::PeriodTooShort { axis: 0, period: 1.0, least: 1.5 };
        assert_eq!(domain.check(0.75), Err(too_short));
    }
}
