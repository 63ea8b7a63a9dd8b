//! Bitwise identical results at every level, for ordinary numbers and at the ends of the range.

use proptest::prelude::*;
use simd_lanes::{
    Float, Lanes, MOST_LANES, Mask, Registers, SimdLevel, Work, dispatch, dispatch_narrow, exp, ln,
    minus_twice_ln, power, sin_cos,
};

/// Results of every function for each number, in sequence.
#[allow(clippy::inline_always, reason = "compiled for the registers of a level")]
#[inline(always)]
fn evaluate(numbers: &[f64], results: &mut [[f64; 6]]) {
    for (&x, result) in numbers.iter().zip(results) {
        let ([sin], [cos]) = sin_cos([x]);
        let [twice] = minus_twice_ln([x]);
        *result = [exp(x), ln(x), power(x, 0.35), sin, cos, twice];
    }
}

/// Bit patterns of the results; NaN has many, which IEEE 754 leaves open.
fn bits(results: &[[f64; 6]]) -> Vec<[u64; 6]> {
    let bits = |x: f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
    results.iter().map(|result| result.map(bits)).collect()
}

/// Results from a separate loop for each number, too short for any register.
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
        numbers in prop::collection::vec(crate::any_number::number(-700.0..700.0, 4), 0..70)
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

/// A formula with every operation, over numbers or registers, and the mask by which it selects.
#[allow(clippy::inline_always, reason = "compiled for the registers of a level")]
#[inline(always)]
fn formula<N: Lanes>(a: N, b: N) -> (N, u32) {
    let root = (a.abs() + b * b).sqrt();
    let (low, high) = (a.min(b), a.max(b));
    let is_less = low.less(root);
    let chosen = N::select(is_less, root / high, root - low);
    (N::select(chosen.at_least(a), chosen, a * b), is_less.bits())
}

/// Evaluates the formula of each number and its successor in registers; returns the masks in sequence.
struct InRegisters<'a, T> {
    numbers: &'a [T],
    results: &'a mut [T],
    masks: &'a mut Vec<bool>,
}

impl<T: Float> Work<T> for InRegisters<'_, T> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "compiled for the registers of a level")]
    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        for at in (0..self.results.len()).step_by(R::N) {
            let (a, b) =
                (registers.load_at(self.numbers, at), registers.load_at(self.numbers, at + 1));
            let (result, mask) = formula(a, b);
            registers.store_at(result, self.results, at);
            self.masks.extend((0..R::N).map(|lane| mask >> lane & 1 == 1));
            // Round trip: selecting by the bits of a mask equals selecting by the mask.
            let by_bits = R::Vector::select(registers.mask(mask), a, b);
            assert_eq!(by_bits.less(a).bits() & mask, 0);
            assert_eq!(registers.mask(!mask).any(), mask.count_ones() as usize != R::N);
        }
    }
}

/// Whether every level is bitwise identical to the scalar results.
fn agrees<T: Float>(numbers: &[T], bits: impl Fn(T) -> u64) {
    let count = (numbers.len() - 1) / MOST_LANES * MOST_LANES;
    let single = (0..count).map(|k| formula(numbers[k], numbers[k + 1]));
    let (expected, masks): (Vec<_>, Vec<_>) = single.map(|(x, mask)| (bits(x), mask == 1)).unzip();
    let levels = SimdLevel::available().flat_map(|level| [(level, false), (level, true)]);
    for (level, is_narrow) in levels {
        let (mut results, mut found) = (vec![T::default(); count], Vec::new());
        let work = InRegisters { numbers, results: &mut results, masks: &mut found };
        if is_narrow {
            level.run_narrow(work);
        } else {
            level.run(work);
        }
        assert_eq!(found, masks, "{level}");
        let results: Vec<_> = results.into_iter().map(&bits).collect();
        assert_eq!(results, expected, "{level}");
    }
}

proptest! {
    #[test]
    fn registers_of_every_level_have_the_bits_of_single_numbers(
        numbers in prop::collection::vec(crate::any_number::number(-700.0..700.0, 4), 17..70)
    ) {
        agrees(&numbers, |x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() });
        #[expect(clippy::cast_possible_truncation, reason = "the nearest number, or infinite")]
        let single: Vec<f32> = numbers.iter().map(|&x| x as f32).collect();
        agrees(&single, |x| (if x.is_nan() { f32::NAN } else { x }).to_bits().into());
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
