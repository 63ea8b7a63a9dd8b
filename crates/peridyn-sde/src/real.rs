//! The numbers that fast paths compute with.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::ops::{AddAssign, Neg, SubAssign};

use simd_lanes::Float;

/// `f64` or `f32`.
pub trait Real: Float + Neg<Output = Self> + AddAssign + SubAssign {
    /// Its name, for tables.
    const NAME: &'static str;

    /// Up to which `|w|` [`SERIES`](Self::SERIES) is accurate.
    const SERIES_RANGE: Self;

    /// Zero.
    const ZERO: Self;

    /// The largest number.
    const LARGEST: Self;

    /// The smallest positive number that is not subnormal.
    const SMALLEST: Self;

    /// To which residual a linear system is solved in these numbers.
    const SOLVED: f64;

    /// The nearest to a number.
    fn of(value: f64) -> Self;

    /// The same number as a double.
    fn to_f64(self) -> f64;

    /// Whether it is a number.
    fn is_finite(self) -> bool;

    /// Coefficients of a polynomial for `1 - 1/sqrt(1 + w)` by powers of `w`, from the first on: of all with as many terms that
    /// with the least relative error in the range (Remez), an even number. The first terms of the series are `1/2, -3/8, 5/16, -35/128`.
    const SERIES: &'static [Self];
}

impl Real for f64 {
    const NAME: &'static str = "f64";
    // The relative error is 8.4e-13, at both ends and five times in between.
    const SERIES_RANGE: Self = 0.02;
    const ZERO: Self = 0.0;
    const LARGEST: Self = Self::MAX;
    const SMALLEST: Self = Self::MIN_POSITIVE;
    const SOLVED: f64 = 1e-11;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        self.is_finite()
    }

    const SERIES: &'static [Self] = &[
        0.5000000000004192,
        -0.375000000000786,
        0.31249998113741057,
        -0.2734374783861742,
        0.24621948469705485,
        -0.2257116744881817,
    ];
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "rounding to single precision is what is asked for"
)]
const fn single(value: f64) -> f32 {
    value as f32
}

impl Real for f32 {
    const NAME: &'static str = "f32";
    // The relative error is 5.0e-8, less than a digit of single precision.
    const SERIES_RANGE: Self = 0.03;
    const ZERO: Self = 0.0;
    const LARGEST: Self = Self::MAX;
    const SMALLEST: Self = Self::MIN_POSITIVE;
    const SOLVED: f64 = 1e-6;

    #[inline(always)]
    fn of(value: f64) -> Self {
        single(value)
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        self.is_finite()
    }

    const SERIES: &'static [Self] = &[
        single(0.49999997506151894),
        single(-0.37499996466756447),
        single(0.31272163825270166),
        single(-0.27365914883668885),
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed form is taken as `w/(sqrt(1 + w) (1 + sqrt(1 + w)))`, which loses no digits.
    fn is_accurate<T: Real>(tolerance: f64) {
        for step in -100..=100_i32 {
            let w = T::of(f64::from(step) / 100.0 * T::SERIES_RANGE.to_f64());
            let root = (1.0 + w.to_f64()).sqrt();
            let exact = w.to_f64() / (root * (1.0 + root));
            let series = T::SERIES.iter().rev().fold(T::ZERO, |sum, &term| (sum + term) * w);
            let error = (series.to_f64() - exact).abs();
            assert!(error <= tolerance * exact.abs(), "{} {w:?}: {error}", T::NAME);
        }
    }

    #[test]
    fn the_series_is_accurate_to_the_edge_of_its_range() {
        is_accurate::<f64>(8.5e-13);
        is_accurate::<f32>(3e-7);
    }
}
