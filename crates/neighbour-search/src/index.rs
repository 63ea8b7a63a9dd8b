//! Index type of lists.

/// An index as it is stored.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "no more than u32::MAX points pass the check")]
pub(crate) fn stored(index: usize) -> u32 {
    index as u32
}
