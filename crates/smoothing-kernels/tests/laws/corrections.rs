//! Corrections reproduce constants and slopes within roundoff, for every kernel, at a corner of a disordered cloud.

use proptest::prelude::*;
use smoothing_kernels::{
    Error, Kernel, SMALLEST_RECIPROCAL_CONDITION, SMALLEST_SHEPARD_SUM, all, corrected_gradient,
    renormalisation_matrix, shepard_factor,
};

/// A lattice of unit spacing over one orthant, shaken by up to a fifth: the first point is its corner.
fn corner<const D: usize>(per_axis: usize) -> Vec<[f64; D]> {
    let n = (0..D).fold(1, |n, _| n * per_axis);
    (0..n)
        .map(|index| {
            let mut rest = index;
            std::array::from_fn(|axis| {
                let cell = (rest % per_axis) as f64;
                rest /= per_axis;
                // Multiples of an irrational number, modulo one: disorder without a generator.
                let shake = ((index * D + axis) as f64 * 0.618_033_988_749_895).fract() - 0.5;
                cell + 0.4 * shake
            })
        })
        .collect()
}

fn corrections_are_exact_at_a_corner<const D: usize>() -> Result<(), Error> {
    let points = corner::<D>(4);
    let volume = 0.8;
    let slope: [f64; D] = std::array::from_fn(|axis| 1.0 - 0.7 * axis as f64);
    let linear = |x: &[f64; D]| 5.0 + x.iter().zip(&slope).map(|(x, slope)| x * slope).sum::<f64>();
    let here = points[0];
    for (name, kernel) in all::<D>() {
        let h = 2.6 / kernel.support();
        let (mut sum, mut sum_of_three) = (0.0, 0.0);
        let mut moment = [[0.0; D]; D];
        let mut plain = [0.0; D];
        for point in &points {
            let x_ij: [f64; D] = std::array::from_fn(|axis| here[axis] - point[axis]);
            let r = x_ij.iter().map(|x| x * x).sum::<f64>().sqrt();
            let (value, gradient) = (kernel.value(r, h), kernel.gradient(&x_ij, r, h));
            sum += volume * value;
            sum_of_three += volume * 3.0 * value;
            for a in 0..D {
                plain[a] += volume * (linear(point) - linear(&here)) * gradient[a];
                for b in 0..D {
                    moment[a][b] -= volume * x_ij[a] * gradient[b];
                }
            }
        }
        let constant = shepard_factor(sum)? * sum_of_three;
        assert!((constant - 3.0).abs() < 1e-14, "{name} in {D} dimensions: {constant}");
        // The correction has something to correct: at a corner the plain sums are far off.
        assert!((sum - 1.0).abs() > 0.01, "{name} in {D} dimensions: {sum}");
        assert!((plain[0] - slope[0]).abs() > 0.01, "{name} in {D} dimensions: {plain:?}");
        let gradient = corrected_gradient(&renormalisation_matrix(&moment)?, &plain);
        for (ours, slope) in gradient.iter().zip(&slope) {
            // Roundoff of the sums, times the condition of the moment, below 1e3.
            assert!((ours - slope).abs() < 1e-12, "{name} in {D} dimensions: {ours} {slope}");
        }
    }
    Ok(())
}

#[test]
fn corrections_make_constants_and_slopes_exact_at_a_corner() -> Result<(), Error> {
    corrections_are_exact_at_a_corner::<1>()?;
    corrections_are_exact_at_a_corner::<2>()?;
    corrections_are_exact_at_a_corner::<3>()?;
    corrections_are_exact_at_a_corner::<4>()?;
    corrections_are_exact_at_a_corner::<5>()?;
    corrections_are_exact_at_a_corner::<6>()
}

#[test]
fn mixed_gradients_need_the_transposition() -> Result<(), Error> {
    // For gradients g_j = A e_j of a lattice's axes the moment is A^T in this order of indices, and B A must be one.
    let mixed = [[1.0, 0.3], [0.0, 0.8]];
    let moment = [[mixed[0][0], mixed[1][0]], [mixed[0][1], mixed[1][1]]];
    let matrix = renormalisation_matrix(&moment)?;
    for axis in 0..2 {
        let gradient = corrected_gradient(&matrix, &[mixed[0][axis], mixed[1][axis]]);
        for (component, value) in gradient.iter().enumerate() {
            let expected = if component == axis { 1.0 } else { 0.0 };
            assert!((value - expected).abs() < 1e-15, "{gradient:?}");
        }
    }
    Ok(())
}

/// `B M^T = 1`, or an error that says how near to singular the moment is.
fn matrix_is_the_inverse<const D: usize>(entries: &[f64]) {
    let moment: [[f64; D]; D] =
        std::array::from_fn(|row| std::array::from_fn(|column| entries[row * D + column]));
    match renormalisation_matrix(&moment) {
        Ok(matrix) => {
            for row in 0..D {
                let unit = corrected_gradient(&matrix, &moment[row]);
                for (column, value) in unit.iter().enumerate() {
                    let expected = if row == column { 1.0 } else { 0.0 };
                    // Roundoff times the condition, 1e8 at most, and the growth of pivots.
                    assert!((value - expected).abs() < 1e-5, "{moment:?}: {matrix:?}");
                }
            }
        }
        Err(Error::SingularMoment { value, limit }) => assert!(value < limit, "{moment:?}"),
        Err(other) => assert_eq!(other.to_string(), "", "no other error is promised"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100_000))]

    #[test]
    fn renormalisation_inverts_or_says_why_not(
        entries in prop::array::uniform32(-1.0..1.0_f64), more in prop::array::uniform4(-1.0..1.0_f64),
        round in any::<bool>(),
    ) {
        // Rounded to -1, 0 and 1 many of the small ones are singular.
        let value = |entry: &f64| if round { entry.round() } else { *entry };
        let entries: Vec<f64> = entries.iter().chain(&more).map(value).collect();
        matrix_is_the_inverse::<1>(&entries);
        matrix_is_the_inverse::<2>(&entries);
        matrix_is_the_inverse::<3>(&entries);
        matrix_is_the_inverse::<4>(&entries);
        matrix_is_the_inverse::<5>(&entries);
        matrix_is_the_inverse::<6>(&entries);
    }

    #[test]
    fn shepard_divides_or_says_why_not(mantissa in -2.0..2.0_f64, exponent in -20..300_i32) {
        let sum = mantissa * 10.0_f64.powi(exponent);
        match shepard_factor(sum) {
            Ok(factor) => prop_assert!((factor * sum - 1.0).abs() < 2.0 * f64::EPSILON),
            Err(error) => prop_assert!(sum < 1e-10, "{error}"),
        }
    }
}

#[test]
fn matrix_needs_its_pivots() {
    // A permutation has zeros on the diagonal; its inverse is its transpose.
    let cycle = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    assert_eq!(renormalisation_matrix(&cycle), Ok(cycle));
}

#[test]
fn singular_moments_are_refused_with_value_and_limit() {
    let limit = SMALLEST_RECIPROCAL_CONDITION;
    // Neighbours on a line, none at all, one that is not a number, and two directions a hair apart.
    for moment in [
        [[1.0, 1.0], [1.0, 1.0]],
        [[0.0, 0.0], [0.0, 0.0]],
        [[f64::NAN, 0.0], [0.0, 1.0]],
        [[1.0, 0.0], [0.0, 0.99e-8]],
    ] {
        match renormalisation_matrix(&moment) {
            Err(Error::SingularMoment { value, limit: stated }) => {
                assert!(value.is_nan() || value < limit, "{value}");
                assert!((stated - limit).abs() < f64::EPSILON);
            }
            other => assert!(other.is_err(), "{moment:?} was taken: {other:?}"),
        }
    }
    assert!(renormalisation_matrix(&[[1.0, 0.0], [0.0, 1.01e-8]]).is_ok());
    assert_eq!(
        renormalisation_matrix(&[[1.0, 0.0], [0.0, 0.0]]),
        Err(Error::SingularMoment { value: 0.0, limit })
    );
}

#[test]
fn empty_neighbourhoods_have_no_shepard_factor() {
    for value in [0.0, -1.0, 0.9e-10, f64::INFINITY] {
        let refused = Err(Error::ShepardSum { value, limit: SMALLEST_SHEPARD_SUM });
        assert_eq!(shepard_factor(value), refused);
    }
    assert!(shepard_factor(f64::NAN).is_err());
    assert_eq!(shepard_factor(0.25), Ok(4.0));
}
