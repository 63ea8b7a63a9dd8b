//! Rules of columns for splitting and merging.

/// What a column does when particles are split and merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rule {
    /// Split in proportion to mass, added up when merged: volume, momentum, energy. Real numbers only.
    Sum,
    /// Copied to the children, averaged with masses as weights when merged: velocity, density. Real numbers only.
    Mean,
    /// Copied to the children, taken from the first when merged: phase, body, smoothing length.
    First,
}
