//! The radius criterion of a pair, and the range of valid radii.

/// Smallest radius accepted, 1e-150 in the unit of the points: below it squares lose digits to underflow.
pub const MIN_RADIUS: f64 = 1e-150;

/// Largest radius accepted, 1e150 in the unit of the points: beyond it squares overflow.
pub const MAX_RADIUS: f64 = 1e150;

/// Which radius decides whether `j` is listed as a neighbour of `i`, at distance `r`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Criterion {
    /// `r <= h_i`: the radius of `i` decides. It is not symmetric.
    Gather,
    /// `r <= h_j`: the radius of `j` decides. It is not symmetric; it is the transpose of [`Gather`](Self::Gather).
    Scatter,
    /// `r <= max(h_i, h_j)`: the larger radius decides. It is symmetric.
    Max,
    /// `r <= (h_i + h_j) / 2`. It is symmetric.
    Mean,
}

impl Criterion {
    /// Every criterion, for tests and tables.
    pub const ALL: [Self; 4] = [Self::Gather, Self::Scatter, Self::Max, Self::Mean];

    /// Search radius between a point of radius `h_i` and a point of radius `h_j`; increases with both.
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

/// Mean of two radii; bitwise symmetric in its arguments.
#[inline]
fn mean(a: f64, b: f64) -> f64 {
    0.5 * (a + b)
}
