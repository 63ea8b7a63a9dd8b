//! Arbitrary numbers for the tests of this crate and, by `#[path]`, for the `any_input` targets of dependent crates.

use std::ops::Range;

use proptest::prelude::*;

/// Any double: an ordinary number with the given weight against 4, else another kind.
///
/// The other kinds are numbers up to 10, numbers of any bits, and the ends of the range, infinities and NaN.
pub(crate) fn number(ordinary: Range<f64>, weight: u32) -> impl Strategy<Value = f64> {
    prop_oneof![
        weight => ordinary,
        2 => -10.0..10.0,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![
            0.0, -0.0, 1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE,
            5e-324, 1e-300, 1e300, -1e300,
        ]),
    ]
}
