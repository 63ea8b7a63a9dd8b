//! How far each point sees, and whose sight decides.

use crate::error::Error;

/// Smallest radius accepted, 1e-150 in the unit of the points: below it squares lose digits to underflow.
pub const MIN_RADIUS: f64 = 1e-150;

/// Largest radius accepted, 1e150 in the unit of the points: beyond it squares overflow.
pub const MAX_RADIUS: f64 = 1e150;

/// Which radius decides whether `j` is listed as a neighbour of `i`, at distance `r`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Criterion {
    /// `r <= h_i`: whom `i` sees. Not symmetric.
    Gather,
    /// `r <= h_j`: who sees `i`. Not symmetric; the transpose of [`Gather`](Self::Gather).
    Scatter,
    /// `r <= max(h_i, h_j)`: either sees the other. Symmetric.
    Max,
    /// `r <= (h_i + h_j) / 2`. Symmetric.
    Mean,
}

impl Criterion {
    /// Every criterion, for tests and tables.
    pub const ALL: [Self; 4] = [Self::Gather, Self::Scatter, Self::Max, Self::Mean];

    /// The radius within which a point of radius `h_j` is listed under one of radius `h_i`; grows with both.
    #[inline(always)]
    pub(crate) fn limit(self, h_i: f64, h_j: f64) -> f64 {
        match self {
            Self::Gather => h_i,
            Self::Scatter => h_j,
            Self::Max => h_i.max(h_j),
            Self::Mean => mean(h_i, h_j),
        }
    }

    /// Whether neighbours are mutual.
    #[must_use]
    pub fn is_symmetric(self) -> bool {
        matches!(self, Self::Max | Self::Mean)
    }
}

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
        /// Whose radius decides.
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

    /// Refuses radii of which a pair can be seen from one side alone.
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

/// Mean of two radii; the same bits whichever comes first.
#[inline]
fn mean(a: f64, b: f64) -> f64 {
    0.5 * (a + b)
}

pub(crate) fn in_range(radius: f64) -> bool {
    (MIN_RADIUS..=MAX_RADIUS).contains(&radius)
}
