//! Regular initial lattices.

use std::collections::HashMap;

use crate::error::Error;

/// Relative tolerance at the surface of a ball: points within it belong to the ball despite rounding.
const ON_THE_SURFACE: f64 = 1e-12;

/// Points of a rectangular lattice centred on 0, the first axis fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice<const D: usize> {
    /// The points, in the unit of length of the construction.
    pub points: Vec<[f64; D]>,
    /// Integer coordinates of each point: from the lower corner of a box lattice, from the centre of a ball lattice.
    pub indices: Vec<[i32; D]>,
    /// Distance of neighbouring points along each axis.
    pub spacing: [f64; D],
}

impl<const D: usize> Lattice<D> {
    /// The box `[-half_width, half_width]` with `count` points along each axis, end points included.
    ///
    /// Point `k` along an axis of `n` points is at `half_width (2k - n + 1) / (n - 1)`, exactly antisymmetric; the spacing is
    /// `2 half_width / (n - 1)`. A single point is at the centre, and its spacing is the whole width.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidLength`] unless every half width is positive and finite, [`Error::ZeroCount`],
    /// [`Error::TooManyPoints`].
    pub fn box_lattice(half_width: [f64; D], count: [usize; D]) -> Result<Self, Error> {
        let mut counts = [0_i32; D];
        let mut total: usize = 1;
        for axis in 0..D {
            check_length("half width", axis, half_width[axis])?;
            if count[axis] == 0 {
                return Err(Error::ZeroCount { axis });
            }
            counts[axis] = i32::try_from(count[axis]).map_err(|_| Error::TooManyPoints)?;
            total = total.checked_mul(count[axis]).ok_or(Error::TooManyPoints)?;
        }
        check_total(total)?;
        let along = |axis: usize, index: i32| {
            let steps = f64::from(counts[axis]) - 1.0;
            if steps > 0.0 {
                half_width[axis] * ((2.0 * f64::from(index) - steps) / steps)
            } else {
                0.0
            }
        };
        let (mut points, mut indices) = (Vec::with_capacity(total), Vec::with_capacity(total));
        let mut index = [0; D];
        for _ in 0..total {
            points.push(core::array::from_fn(|axis| along(axis, index[axis])));
            indices.push(index);
            for axis in 0..D {
                index[axis] += 1;
                if index[axis] < counts[axis] {
                    break;
                }
                index[axis] = 0;
            }
        }
        let spacing = core::array::from_fn(|axis| {
            2.0 * half_width[axis] / (f64::from(counts[axis]) - 1.0).max(1.0)
        });
        Ok(Self { points, indices, spacing })
    }

    /// The points `k spacing` with integer `k` at a distance of at most `radius` from the centre.
    ///
    /// Points within a relative 1e-12 of the surface are included, so that rounding of `radius / spacing` loses none.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidLength`] unless radius and spacing are positive and finite, [`Error::TooManyPoints`].
    pub fn ball_lattice(radius: f64, spacing: f64) -> Result<Self, Error> {
        check_length("radius", 0, radius)?;
        check_length("spacing", 0, spacing)?;
        let in_spacings = radius / spacing * (1.0 + ON_THE_SURFACE);
        // Beyond this one axis alone has too many points.
        if in_spacings >= f64::from(i32::MAX) {
            return Err(Error::TooManyPoints);
        }
        let squared = in_spacings * in_spacings;
        check_total(count_ball::<D>(D - 1, squared, 0))?;
        let mut indices = Vec::new();
        push_ball(D - 1, squared, &mut [0; D], &mut indices);
        let points =
            indices.iter().map(|index: &[i32; D]| index.map(|k| f64::from(k) * spacing)).collect();
        Ok(Self { points, indices, spacing: [spacing; D] })
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Volume of a point: the product of the spacings.
    #[must_use]
    pub fn cell_volume(&self) -> f64 {
        self.spacing.iter().product()
    }

    /// For each point and axis the points one step below and one step above, if they exist.
    ///
    /// They are found by integer coordinates, so a lattice with removed or moved points keeps its neighbours.
    #[must_use]
    pub fn axis_neighbours(&self) -> Vec<[[Option<u32>; 2]; D]> {
        let ids: HashMap<[i32; D], u32> = self.indices.iter().copied().zip(0_u32..).collect();
        let beside = |index: &[i32; D], axis: usize, step: i32| {
            let mut beside = *index;
            beside[axis] = beside[axis].checked_add(step)?;
            ids.get(&beside).copied()
        };
        self.indices
            .iter()
            .map(|index| core::array::from_fn(|axis| [-1, 1].map(|step| beside(index, axis, step))))
            .collect()
    }
}

fn check_length(what: &'static str, axis: usize, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::InvalidLength { what, axis, value })
    }
}

fn check_total(total: usize) -> Result<(), Error> {
    if u32::try_from(total).is_ok() { Ok(()) } else { Err(Error::TooManyPoints) }
}

/// Largest `k >= 0` with `k^2 <= squared`; the caller ensures the range.
#[expect(clippy::cast_possible_truncation, reason = "below i32::MAX by the check on the radius")]
fn whole_steps(squared: f64) -> i32 {
    // Rounding may make the remainder for the inner axes slightly negative.
    squared.max(0.0).sqrt() as i32
}

/// `counted` plus the points of the ball over axes 0 to `axis`; stops once they are too many.
fn count_ball<const D: usize>(axis: usize, squared: f64, counted: usize) -> usize {
    let steps = whole_steps(squared);
    if axis == 0 {
        return counted + 2 * steps.unsigned_abs() as usize + 1;
    }
    let mut counted = counted;
    for k in -steps..=steps {
        counted = count_ball::<D>(axis - 1, squared - f64::from(k).powi(2), counted);
        if counted > u32::MAX as usize {
            break;
        }
    }
    counted
}

/// Appends the points of the ball over axes 0 to `axis`; the other coordinates are those in `index`.
fn push_ball<const D: usize>(
    axis: usize,
    squared: f64,
    index: &mut [i32; D],
    indices: &mut Vec<[i32; D]>,
) {
    let steps = whole_steps(squared);
    for k in -steps..=steps {
        index[axis] = k;
        if axis == 0 {
            indices.push(*index);
        } else {
            push_ball(axis - 1, squared - f64::from(k).powi(2), index, indices);
        }
    }
}
