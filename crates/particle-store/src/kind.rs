//! The kinds of columns.

/// Kind of a column, with one value for each particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// `f64`
    Scalar,
    /// `[f64; D]`
    Point,
    /// `i64`
    Integer,
    /// `[i32; D]`
    Index,
    /// [`SymmetricTensor`](crate::SymmetricTensor)
    Tensor,
    /// `u8`
    Flag,
    /// `u32`
    Label,
}
