//! Errors of a search, a list or a query.

use crate::criterion::{Criterion, MAX_RADIUS, MIN_RADIUS};

/// Why a neighbour list could not be built or read.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A coordinate is NaN or infinite.
    #[error("point {particle} has coordinate {value} along axis {axis}, which is not finite")]
    CoordinateNotFinite {
        /// Index of the point.
        particle: usize,
        /// Axis of the coordinate, from 0.
        axis: usize,
        /// The coordinate.
        value: f64,
    },
    /// The common radius is NaN, infinite, not positive, or has no square in double precision.
    #[error("radius {value} is not between {MIN_RADIUS:e} and {MAX_RADIUS:e}")]
    UniformRadius {
        /// The radius.
        value: f64,
    },
    /// A point's radius is NaN, infinite, not positive, or has no square in double precision.
    #[error("radius {value} of point {particle} is not between {MIN_RADIUS:e} and {MAX_RADIUS:e}")]
    Radius {
        /// Index of the point.
        particle: usize,
        /// Its radius.
        value: f64,
    },
    /// The number of radii differs from the number of points.
    #[error("{radii} radii for {points} points: give one for each point")]
    RadiiLength {
        /// Number of points.
        points: usize,
        /// Number of radii.
        radii: usize,
    },
    /// A half list requires a symmetric criterion.
    #[error(
        "a half list requires a symmetric criterion; {criterion:?} is not symmetric: use Max or Mean, or a full list"
    )]
    NotSymmetric {
        /// The criterion.
        criterion: Criterion,
    },
    /// The period of an axis is NaN, infinite, not positive, or has no square in double precision.
    #[error("period {value} of axis {axis} is not between {MIN_RADIUS:e} and {MAX_RADIUS:e}")]
    Period {
        /// Axis, from 0.
        axis: usize,
        /// Its period.
        value: f64,
    },
    /// A period is so short that a point would have neighbours through two images of the same point.
    #[error("period {period} of axis {axis} is shorter than {least}, twice the largest radius")]
    PeriodTooShort {
        /// Axis, from 0.
        axis: usize,
        /// Its period.
        period: f64,
        /// Twice the largest radius.
        least: f64,
    },
    /// A skin is NaN, infinite, not positive, or has no square in double precision.
    #[error("skin {value} is not between {MIN_RADIUS:e} and {MAX_RADIUS:e}")]
    Skin {
        /// The skin.
        value: f64,
    },
    /// The position of a query is NaN or infinite.
    #[error("the position has coordinate {value} along axis {axis}, which is not finite")]
    PlaceNotFinite {
        /// Axis of the coordinate.
        axis: usize,
        /// Its value.
        value: f64,
    },
    /// A list is read with a different number of points than it was built from.
    #[error("a list of {listed} points is read with {points} points: rebuild it")]
    ListLength {
        /// Number of points that the list was built from.
        listed: usize,
        /// Number of points it is read with.
        points: usize,
    },
    /// A row of a list contains an index that is no point.
    #[error("row {i} contains the index {j}; there are {points} points")]
    NotAPoint {
        /// The row.
        i: usize,
        /// Its entry.
        j: u32,
        /// Number of points.
        points: usize,
    },
    /// The number of points exceeds a 32-bit index.
    #[error("{points} points; a list can index at most {}", u32::MAX)]
    TooManyPoints {
        /// Number of points.
        points: usize,
    },
    /// A list above 512 MiB has more than 4,096 neighbours for each of a thousand points.
    #[error(
        "the list of {points} points exceeds {entries} entries, with over {neighbours} neighbours for each of a thousand points: \
         take a smaller radius; points that coincide are all neighbours"
    )]
    TooManyNeighbours {
        /// Number of points.
        points: usize,
        /// Entries that any list may have.
        entries: usize,
        /// Neighbours of a point, on average over a thousand, that a larger list may have.
        neighbours: usize,
    },
}
