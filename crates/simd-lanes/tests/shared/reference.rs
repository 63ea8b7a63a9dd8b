//! Elementary functions to about 100 bits, in double-double arithmetic.

use std::f64::consts::LN_2;

/// A number as an unevaluated sum of two.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Double(pub(crate) f64, pub(crate) f64);

impl Double {
    pub(crate) fn plus(self, other: Self) -> Self {
        let sum = self.0 + other.0;
        let part = sum - self.0;
        let error = (self.0 - (sum - part)) + (other.0 - part) + self.1 + other.1;
        Self(sum + error, error - ((sum + error) - sum))
    }

    pub(crate) fn times(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let error = self.0.mul_add(other.0, -product) + self.0 * other.1 + self.1 * other.0;
        Self(product + error, error - ((product + error) - product))
    }

    pub(crate) fn over(self, divisor: f64) -> Self {
        let quotient = self.0 / divisor;
        let rest = (-quotient).mul_add(divisor, self.0) + self.1;
        Self(quotient, rest / divisor)
    }

    /// Error of a result in units of its last place.
    pub(crate) fn ulps(self, result: f64) -> f64 {
        let magnitude = self.0.abs();
        ((result - self.0) - self.1).abs() / (magnitude.next_up() - magnitude)
    }
}

/// `-ln 2` (DLMF 4.2.14 and A002162).
const MINUS_LN_2: Double = Double(-LN_2, -2.319_046_813_846_299_6e-17);

/// `e^x = 2^k e^r`: Taylor's series of `e^(r/1024) - 1`, then ten times `m -> 2 m + m^2`.
pub(crate) fn reference_exp(x: Double) -> Double {
    let k = (x.0 / LN_2).round();
    let r = x.plus(MINUS_LN_2.times(Double(k, 0.0)));
    let small = Double(r.0 / 1024.0, r.1 / 1024.0);
    let (mut term, mut sum) = (small, small);
    for n in 2..12_u32 {
        term = term.times(small).over(f64::from(n));
        sum = sum.plus(term);
    }
    for _ in 0..10 {
        sum = sum.plus(sum).plus(sum.times(sum));
    }
    sum = sum.plus(Double(1.0, 0.0));
    let scale = k.exp2();
    Double(sum.0 * scale, sum.1 * scale)
}

/// `ln x = y + ln(x e^-y)` from the platform's `y`; two terms of the series suffice for the remainder.
pub(crate) fn reference_ln(x: f64) -> Double {
    let y = Double(x.ln(), 0.0);
    let rest = reference_exp(Double(-y.0, 0.0)).times(Double(x, 0.0)).plus(Double(-1.0, 0.0));
    y.plus(rest).plus(Double(-0.5 * rest.0 * rest.0, 0.0))
}

/// `(sin x, cos x)` by Taylor's series.
pub(crate) fn reference_sin_cos(x: f64) -> (Double, Double) {
    let mut term = Double(1.0, 0.0);
    let mut sums = [Double(0.0, 0.0), term];
    for n in 1..28_u32 {
        term = term.times(Double(x, 0.0)).over(f64::from(n));
        let sign = if n % 4 < 2 { 1.0 } else { -1.0 };
        let sum = &mut sums[usize::from(n % 2 == 0)];
        *sum = sum.plus(Double(sign * term.0, sign * term.1));
    }
    (sums[0], sums[1])
}
