//! Rules of columns for splitting and merging.

/// Rule of a column when particles are split and merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rule {
    /// Split in proportion to mass, summed when merged: volume, momentum, energy. It is for real numbers only.
    Sum,
    /// Copied to the children, averaged with masses as weights when merged: velocity, density. It is for real numbers only.
    Mean,
    /// Copied to the children, taken from the first when merged: phase, body, smoothing length.
    First,
}
