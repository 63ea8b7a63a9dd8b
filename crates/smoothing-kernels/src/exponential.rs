//! The exponential of a number that is not positive, without a branch, so that a loop over it vectorises.

use core::f64::consts::LOG2_E;

/// `ln 2` to 32 leading bits: times a whole number below 2^20 it is exact.
const LN_2_HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);

/// `ln 2` less its 32 leading bits.
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// Added to a number of magnitude below 2^51 it rounds it to a whole one, whose bits are then the lowest of the sum.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// `1/2!, 1/4!, .. 1/12!`
const EVEN: [f64; 6] =
    [1.0 / 2.0, 1.0 / 24.0, 1.0 / 720.0, 1.0 / 40_320.0, 1.0 / 3_628_800.0, 1.0 / 479_001_600.0];

/// `1/3!, 1/5!, .. 1/13!`
const ODD: [f64; 6] = [
    1.0 / 6.0,
    1.0 / 120.0,
    1.0 / 5040.0,
    1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
];

/// `e^x` for `-9 <= x <= 0`, which is all that the Gaussian on three smoothing lengths asks; NaN for NaN.
///
/// $$ e^x = 2^k e^r, \quad k = \lfloor x / \ln 2 \rceil, \quad r = x - k \ln 2, \qquad
///    e^r = 1 + \Bigl( r + r^2 \sum_{n=2}^{13} \frac{r^{n-2}}{n!} \Bigr) $$
///
/// `|r|` is at most `ln 2 / 2`, where the first term left out is 5e-18 of the sum. Error: below one unit in the last
/// place; 0.87 is the most met at 400,002 points of the range. Additions, products and shifts only, none fused, so that every register
/// width gives the same bits.
#[inline]
pub(crate) fn exponential(x: f64) -> f64 {
    let shifted = x * LOG2_E + ROUNDING;
    let k = shifted - ROUNDING;
    let (high, low) = (x - k * LN_2_HIGH, k * LN_2_LOW);
    let r = high - low;
    // What the difference has lost.
    let lost = (high - r) - low;
    let s = r * r;
    let tail = polynomial(&EVEN, s) + r * polynomial(&ODD, s);
    // The lowest 11 bits of the sum hold k; with the bias of the exponent they are that of 2^k.
    let two_to_k = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    two_to_k * (1.0 + (r + (s * tail + lost)))
}

/// `c_0 + c_1 s + .. + c_5 s^5` by pairs, which wait for one another less than by Horner's rule.
#[inline]
fn polynomial(c: &[f64; 6], s: f64) -> f64 {
    let square = s * s;
    (c[0] + c[1] * s) + square * ((c[2] + c[3] * s) + square * (c[4] + c[5] * s))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number as an unevaluated sum of two: some 106 bits.
    #[derive(Clone, Copy)]
    struct Double(f64, f64);

    impl Double {
        fn plus(self, other: Self) -> Self {
            let sum = self.0 + other.0;
            let part = sum - self.0;
            let error = (self.0 - (sum - part)) + (other.0 - part) + self.1 + other.1;
            Self(sum + error, error - ((sum + error) - sum))
        }

        fn times(self, other: Self) -> Self {
            let product = self.0 * other.0;
            let error = self.0.mul_add(other.0, -product) + self.0 * other.1 + self.1 * other.0;
            Self(product + error, error - ((product + error) - product))
        }

        fn over(self, divisor: f64) -> Self {
            let quotient = self.0 / divisor;
            let rest = (-quotient).mul_add(divisor, self.0) + self.1;
            Self(quotient, rest / divisor)
        }
    }

    /// `e^x` to some 90 bits: Taylor's series of `e^(x/1024) - 1`, then ten times `m -> 2 m + m^2`.
    fn reference(x: f64) -> Double {
        let small = Double(x / 1024.0, 0.0);
        let (mut term, mut sum) = (small, small);
        for n in 2..14_u32 {
            term = term.times(small).over(f64::from(n));
            sum = sum.plus(term);
        }
        for _ in 0..10 {
            sum = sum.plus(sum).plus(sum.times(sum));
        }
        sum.plus(Double(1.0, 0.0))
    }

    /// Error in units of the last place of the result.
    fn ulps(x: f64) -> f64 {
        let (ours, exact) = (exponential(x), reference(x));
        let spacing = exact.0 - exact.0.next_down();
        ((ours - exact.0) - exact.1).abs() / spacing
    }

    #[test]
    fn reference_is_right_to_more_than_the_last_place() {
        // e^-1 = 0.36787944117144232159552377016146 (DLMF 4.2.11), e^-9 = 1.2340980408667954949763669073003e-4.
        let (one, nine) = (reference(-1.0), reference(-9.0));
        let rest = |value: Double, high: f64, low: f64| ((value.0 - high) + (value.1 - low)).abs();
        assert!(rest(one, 0.367_879_441_171_442_33, -1.242_875_367_278_836_3e-17) < 1e-28);
        assert!(rest(nine, 1.234_098_040_866_795_6e-4, -1.171_665_918_417_464_4e-20) < 1e-31);
    }

    #[test]
    fn error_is_below_one_unit_in_the_last_place() {
        // The kernel's whole range, 200,001 points; an odd step in bits, so that every pattern of the low ones occurs.
        let n = 200_000_u32;
        let worst = (0..=n)
            .map(|k| {
                let x = -9.0 * f64::from(k) / f64::from(n);
                ulps(x).max(ulps((x * 0.999_999_3).max(-9.0)))
            })
            .fold(0.0, f64::max);
        assert!((0.5..0.9).contains(&worst), "{worst}");
    }

    #[test]
    fn constants_are_the_parts_of_the_logarithm_of_two() {
        // ln 2 = 0.693147180559945309417232121458176568 (DLMF 4.2.14 and A002162).
        assert_eq!((LN_2_HIGH + LN_2_LOW).to_bits(), core::f64::consts::LN_2.to_bits());
        assert_eq!(LN_2_HIGH.to_bits() & 0x1f_ffff, 0);
        let low = (core::f64::consts::LN_2 - LN_2_HIGH) + 2.319_046_813_846_299_6e-17;
        assert_eq!(LN_2_LOW.to_bits(), low.to_bits());
    }

    #[test]
    fn zero_gives_one_and_nan_stays() {
        assert_eq!(exponential(0.0).to_bits(), 1.0_f64.to_bits());
        assert_eq!(exponential(-0.0).to_bits(), 1.0_f64.to_bits());
        assert!(exponential(f64::NAN).is_nan());
    }
}
