//! The same bits at every level, for ordinary numbers and for those at the ends of the range.

#[path = "shared/number.rs"]
mod any_number;

use lanes::{SimdLevel, dispatch, dispatch_narrow, exp, ln, minus_twice_ln, power, sin_cos};
use proptest::prelude::*;

/// Results of every function for each number, one after the other.
#[allow(clippy::inline_always, reason = "compiled for the registers of a level")]
#[inline(always)]
fn evaluate(numbers: &[f64], results: &mut [[f64; 6]]) {
    for (&x, result) in numbers.iter().zip(results) {
        let ([sin], [cos]) = sin_cos([x]);
        let [twice] = minus_twice_ln([x]);
        *result = [exp(x), ln(x), power(x, 0.35), sin, cos, twice];
    }
}

/// NaN has many bits, which IEEE 754 leaves open.
fn bits(results: &[[f64; 6]]) -> Vec<[u64; 6]> {
    let bits = |x: f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
    results.iter().map(|result| result.map(bits)).collect()
}

/// Results in a loop of its own for each number, which no register is wide enough for.
fn alone(numbers: &[f64]) -> Vec<[u64; 6]> {
    let mut results = vec![[0.0; 6]; numbers.len()];
    for (x, result) in numbers.chunks(1).zip(results.chunks_mut(1)) {
        evaluate(std::hint::black_box(x), result);
    }
    bits(&results)
}

proptest! {
    #[test]
    fn every_level_gives_the_bits_of_one_number_alone(
        numbers in prop::collection::vec(any_number::number(-700.0..700.0, 4), 0..70)
    ) {
        let expected = alone(&numbers);
        let mut results = vec![[0.0; 6]; numbers.len()];
        for level in SimdLevel::available() {
            level.call(
                #[inline(always)]
                || evaluate(&numbers, &mut results),
            );
            prop_assert_eq!(&bits(&results), &expected, "{}", level);
        }
        dispatch(
            #[inline(always)]
            || evaluate(&numbers, &mut results),
        );
        prop_assert_eq!(&bits(&results), &expected);
        dispatch_narrow(
            #[inline(always)]
            || evaluate(&numbers, &mut results),
        );
        prop_assert_eq!(&bits(&results), &expected);
    }
}

#[test]
fn levels_are_told_apart_by_their_names() {
    let names: Vec<_> = SimdLevel::available().map(SimdLevel::name).collect();
    let known = ["portable", "avx2", "avx512"];
    assert!(names.iter().all(|name| known.contains(name)) && names[0] == "portable");
    assert!(names.is_sorted_by_key(|name| known.iter().position(|k| k == name)));
    assert_eq!(SimdLevel::best().to_string(), *names.last().expect("a level"));
}
