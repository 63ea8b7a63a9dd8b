//! The smallest and the greatest of a value over all particles, with their places.

/// Values that are computed at a time, so that a loop over them is compiled for registers.
const BLOCK: usize = 128;

/// Integers in the order of [`f64::total_cmp`]: registers compare them without a branch.
#[allow(clippy::inline_always, reason = "what is not inlined is not compiled for registers")]
#[inline(always)]
fn in_order(value: f64) -> i64 {
    let bits = value.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
}

/// The greatest of `n` values in the order of [`f64::total_cmp`], and the last place where it is; minus infinity at 0 of
/// none. `compute(first, values)` writes the values from a place on; it is compiled for registers where it is inlined.
pub(crate) fn last_greatest(n: usize, compute: impl Fn(usize, &mut [f64])) -> (usize, f64) {
    let (mut place, mut greatest, mut values) = (0, f64::NEG_INFINITY, [0.0; BLOCK]);
    for first in (0..n).step_by(BLOCK) {
        let values = &mut values[..BLOCK.min(n - first)];
        let here = simd_lanes::dispatch(
            #[inline(always)]
            || {
                compute(first, values);
                values.iter().fold(i64::MIN, |most, value| most.max(in_order(*value)))
            },
        );
        if first == 0 || here >= in_order(greatest) {
            let is_here = |value: &f64| in_order(*value) == here;
            place = first + values.iter().rposition(is_here).unwrap_or(0);
            greatest = values[place - first];
        }
    }
    (place, greatest)
}

/// Bins of a histogram: an eighth of an octave each, from the greatest value down; the last holds all below.
const BINS: usize = 512;

/// The bin of a value that is not negative, below the greatest.
#[allow(clippy::inline_always, reason = "what is not inlined is not compiled for registers")]
#[inline(always)]
fn bin(value: f64, greatest: f64) -> u64 {
    // The exponent and the three leading bits of the mantissa.
    let octaves = |value: f64| value.to_bits() >> 49;
    octaves(greatest).saturating_sub(octaves(value)).min(BINS as u64 - 1)
}

/// As [`last_greatest`], without the greatest values whose `weights` together are at most `neglected`. Values are not negative;
/// those within an eighth of an octave are left out together or not at all.
pub(crate) fn last_greatest_but(
    weights: &[f64],
    neglected: f64,
    compute: impl Fn(usize, &mut [f64]),
) -> (usize, f64) {
    let n = weights.len();
    let (place, greatest) = last_greatest(n, &compute);
    let (mut histogram, mut values) = ([0.0; BINS], [0.0; BLOCK]);
    for first in (0..n).step_by(BLOCK) {
        let values = &mut values[..BLOCK.min(n - first)];
        simd_lanes::dispatch(
            #[inline(always)]
            || compute(first, values),
        );
        for (value, weight) in values.iter().zip(&weights[first..]) {
            #[allow(clippy::cast_possible_truncation, reason = "one of few bins")]
            let bin = bin(*value, greatest) as usize;
            histogram[bin] += weight;
        }
    }
    let mut weight = 0.0;
    let kept = histogram.iter().position(|more| {
        weight += more;
        weight > neglected
    });
    // All are negligible, or none is.
    let Some(kept) = kept.filter(|kept| *kept > 0) else { return (place, greatest) };
    let kept = kept as u64;
    last_greatest(
        n,
        #[inline(always)]
        |first, values| {
            compute(first, values);
            for value in values {
                let is_kept = bin(*value, greatest) >= kept;
                *value = if is_kept { *value } else { 0.0 };
            }
        },
    )
}

/// The smallest of `n` values in the order of [`f64::total_cmp`], and the first place where it is; infinity at 0 of none.
/// `compute` as for [`last_greatest`].
pub(crate) fn first_smallest(n: usize, compute: impl Fn(usize, &mut [f64])) -> (usize, f64) {
    let (mut place, mut smallest, mut values) = (0, f64::INFINITY, [0.0; BLOCK]);
    for first in (0..n).step_by(BLOCK) {
        let values = &mut values[..BLOCK.min(n - first)];
        let here = simd_lanes::dispatch(
            #[inline(always)]
            || {
                compute(first, values);
                values.iter().fold(i64::MAX, |least, value| least.min(in_order(*value)))
            },
        );
        if first == 0 || here < in_order(smallest) {
            let is_here = |value: &f64| in_order(*value) == here;
            place = first + values.iter().position(is_here).unwrap_or(0);
            smallest = values[place - first];
        }
    }
    (place, smallest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both extremes of some values.
    fn extremes(all: &[f64]) -> [(usize, f64); 2] {
        let compute = |first: usize, values: &mut [f64]| {
            values.copy_from_slice(&all[first..first + values.len()]);
        };
        [first_smallest(all.len(), compute), last_greatest(all.len(), compute)]
    }

    #[test]
    fn the_greatest_values_of_little_weight_are_left_out() {
        // Octaves from 2^0 up; weights fall by ten with each.
        let n = 2 * BLOCK + 7;
        let value = |i: usize| 2.0_f64.powi(i32::try_from(i % 9).unwrap());
        let weights: Vec<f64> = (0..n).map(|i| 0.1 / value(i).powi(4)).collect();
        let compute = |first: usize, values: &mut [f64]| {
            for (i, out) in (first..).zip(values) {
                *out = value(i);
            }
        };
        for neglected in [0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.1] {
            // Brute force: whole octaves from the greatest down while their weight is negligible.
            let mut kept = 8;
            let mass = |least: usize| -> f64 {
                (0..n).filter(|i| i % 9 >= least).map(|i| weights[i]).sum()
            };
            while kept > 0 && mass(kept) <= neglected {
                kept -= 1;
            }
            let last = (0..n).rfind(|i| i % 9 == kept).unwrap();
            assert_eq!(last_greatest_but(&weights, neglected, compute), (last, value(kept)));
        }
        // Where all are negligible none is left out.
        assert_eq!(last_greatest_but(&weights, 1e3, compute), last_greatest(n, compute));
        let compute = |_: usize, values: &mut [f64]| values.fill(3.0);
        assert_eq!(last_greatest_but(&[0.5, 0.5], 0.6, compute), (1, 3.0));
        assert_eq!(last_greatest_but(&[], 0.6, compute), (0, f64::NEG_INFINITY));
    }

    #[test]
    fn the_order_is_that_of_total_cmp_and_ties_go_to_the_stated_end() {
        // Ties within a block and between blocks.
        let mut values = vec![0.0; 3 * BLOCK];
        for place in [5, BLOCK + 9, BLOCK + 10] {
            (values[place], values[place + 70]) = (-2.0, 3.0);
        }
        assert_eq!(extremes(&values), [(5, -2.0), (BLOCK + 80, 3.0)]);
        let mut sorted = [f64::NAN, 1.0, -0.0, f64::INFINITY, 0.0, -f64::NAN, -1.0, 5e-324];
        sorted.sort_by_key(|value| in_order(*value));
        assert!(sorted.is_sorted_by(|a, b| a.total_cmp(b).is_le()), "{sorted:?}");
        assert!(extremes(&[1.0, f64::NAN, 2.0])[1].1.is_nan());
        assert!(extremes(&[f64::NAN, f64::NAN])[0].1.is_nan());
        assert_eq!(extremes(&[]), [(0, f64::INFINITY), (0, f64::NEG_INFINITY)]);
    }
}
