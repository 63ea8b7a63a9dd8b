//! Search radii of the points, and the criterion of a pair.

use crate::criterion::{Criterion, MAX_RADIUS, MIN_RADIUS};
use crate::error::Error;

/// The search radius: one for all points, or one for each.
///
/// Radii are in the unit of length of the points, within [`MIN_RADIUS`] and [`MAX_RADIUS`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Radii<'a> {
    /// Points at `r <= radius` are neighbours.
    Uniform(f64),
    /// Points have radii of their own.
    PerPoint {
        /// `h_i`, one for each point.
        radii: &'a [f64],
        /// Criterion of a pair.
        criterion: Criterion,
    },
}

impl Radii<'_> {
    /// The radius within which `j` is listed as a neighbour of `i`.
    #[inline]
    pub(crate) fn limit(&self, i: usize, j: usize) -> f64 {
        match *self {
            Radii::Uniform(radius) => radius,
            Radii::PerPoint { radii, criterion } => criterion.limit(radii[i], radii[j]),
        }
    }

    /// The largest radius, 0 if there is none.
    pub(crate) fn largest(&self) -> f64 {
        match *self {
            Radii::Uniform(radius) => radius,
            Radii::PerPoint { radii, .. } => radii.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Rejects radii whose criterion is not symmetric.
    pub(crate) fn check_symmetric(&self) -> Result<(), Error> {
        match *self {
            Radii::PerPoint { criterion, .. } if !criterion.is_symmetric() => {
                Err(Error::NotSymmetric { criterion })
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn check(&self, n_points: usize) -> Result<(), Error> {
        match *self {
            Radii::Uniform(value) if !in_range(value) => Err(Error::UniformRadius { value }),
            Radii::Uniform(_) => Ok(()),
            Radii::PerPoint { radii, .. } => {
                if radii.len() != n_points {
                    return Err(Error::RadiiLength { points: n_points, radii: radii.len() });
                }
                match radii.iter().position(|&radius| !in_range(radius)) {
                    Some(particle) => Err(Error::Radius { particle, value: radii[particle] }),
                    None => Ok(()),
                }
            }
        }
    }
}

pub(crate) fn in_range(radius: f64) -> bool {
    (MIN_RADIUS..=MAX_RADIUS).contains(&radius)
}
