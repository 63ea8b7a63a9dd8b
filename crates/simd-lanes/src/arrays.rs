//! Arrays of lanes in a loop that is always inlined.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

/// `[f(0), f(1), ..., f(N - 1)]`, as [`std::array::from_fn`], but always inlined.
///
/// The one of the standard library becomes a function of its own where several callers share it, and is then compiled
/// for the narrowest registers, silently.
///
/// ```
/// assert_eq!(simd_lanes::from_fn::<_, 4>(|lane| 0.5 * lane as f64), [0.0, 0.5, 1.0, 1.5]);
/// ```
#[inline(always)]
#[must_use]
pub fn from_fn<T: Copy + Default, const N: usize>(mut f: impl FnMut(usize) -> T) -> [T; N] {
    let mut lanes = [T::default(); N];
    for (lane, value) in lanes.iter_mut().enumerate() {
        *value = f(lane);
    }
    lanes
}

/// `f` of each element, as the method `map` of arrays, but always inlined; see [`from_fn`].
///
/// ```
/// assert_eq!(simd_lanes::map([1.0, 4.0], f64::sqrt), [1.0, 2.0]);
/// ```
#[inline(always)]
#[must_use]
pub fn map<T: Copy, U: Copy + Default, const N: usize>(
    values: [T; N],
    mut f: impl FnMut(T) -> U,
) -> [U; N] {
    from_fn(|lane| f(values[lane]))
}
