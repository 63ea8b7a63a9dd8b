//! Evaluation over slices against the scalar calls, bit for bit.

use proptest::prelude::*;
use smoothing_kernels::{Error, Kernel, all};

/// Equal bits, or both not a number: the sign of a NaN is not specified.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

fn slices_have_the_bits_of_the_scalars<const D: usize>(r_squared: &[f64], h: f64) {
    let (mut values, mut factors) =
        (vec![f64::NAN; r_squared.len()], vec![f64::NAN; r_squared.len()]);
    for (name, kernel) in all::<D>() {
        assert_eq!(kernel.values(r_squared, h, &mut values), Ok(()));
        assert_eq!(kernel.gradient_factors(r_squared, h, &mut factors), Ok(()));
        for ((r_squared, value), factor) in r_squared.iter().zip(&values).zip(&factors) {
            let r = r_squared.sqrt();
            assert!(same(*value, kernel.value(r, h)), "{name} in {D} dimensions at r = {r}");
            assert!(
                same(*factor, kernel.gradient_factor(r, h)),
                "gradient factor of {name} in {D} dimensions at r = {r}"
            );
        }
    }
}

fn in_every_dimension(r_squared: &[f64], h: f64) {
    slices_have_the_bits_of_the_scalars::<1>(r_squared, h);
    slices_have_the_bits_of_the_scalars::<2>(r_squared, h);
    slices_have_the_bits_of_the_scalars::<3>(r_squared, h);
    slices_have_the_bits_of_the_scalars::<4>(r_squared, h);
    slices_have_the_bits_of_the_scalars::<5>(r_squared, h);
    slices_have_the_bits_of_the_scalars::<6>(r_squared, h);
}

#[test]
fn slices_have_the_bits_of_the_scalars_at_knots_edges_and_beyond_sense() {
    let q = [0.0, 1e-300, 1e-9, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.1, 1e200, f64::INFINITY, f64::NAN];
    let mut r_squared: Vec<f64> = q.iter().map(|q| q * q).collect();
    r_squared.extend([-1.0, -0.0, 1.0 - f64::EPSILON, 4.0 + 4.0 * f64::EPSILON]);
    in_every_dimension(&r_squared, 1.0);
    in_every_dimension(&[], 1.0);
}

#[test]
fn slices_of_unequal_length_are_refused_and_left_alone() {
    for (_, kernel) in all::<2>() {
        let mut out = [7.0; 2];
        let refused = Err(Error::LengthMismatch { given: 2, expected: 3 });
        assert_eq!(kernel.values(&[0.0; 3], 1.0, &mut out), refused);
        assert_eq!(kernel.gradient_factors(&[0.0; 3], 1.0, &mut out), refused);
        assert_eq!(out.map(f64::to_bits), [7.0_f64.to_bits(); 2]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100_000))]

    #[test]
    fn slices_of_any_length_have_the_bits_of_the_scalars(
        r_squared in prop::collection::vec(0.0..12.0_f64, 0..20),
        h in 0.1..3.0_f64,
    ) {
        in_every_dimension(&r_squared, h);
    }
}
