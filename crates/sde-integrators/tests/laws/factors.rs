//! Factors of covariances: the transposed factor, and several fields side by side.

#![allow(clippy::unwrap_used, reason = "a test ends by it")]

use sde_integrators::{
    DenseFactor, DiagonalFactor, LowRankFactor, Noise, NoiseFactor, Purpose, SparseFactor,
};

const N: usize = 5;

/// `1 / (1 + |i - j|)`: convex and falling, so positive definite (Polya).
fn dense() -> DenseFactor {
    let covariance: Vec<f64> =
        (0..N * N).map(|k| 1.0 / (1.0 + (k / N).abs_diff(k % N) as f64)).collect();
    DenseFactor::new(N, &covariance).unwrap()
}

fn low_rank() -> LowRankFactor {
    LowRankFactor::new(N, normals(2 * N, 1)).unwrap()
}

/// Five rows and seven columns; one row is empty and one has a column twice.
fn sparse() -> SparseFactor {
    let columns = vec![6, 0, 3, 3, 1, 2, 4, 5];
    SparseFactor::new(7, vec![0, 2, 2, 4, 5, 8], columns, normals(8, 2)).unwrap()
}

fn diagonal() -> DiagonalFactor {
    DiagonalFactor::new(normals(N, 3)).unwrap()
}

fn normals(n: usize, stream: u64) -> Vec<f64> {
    let mut normals = vec![0.0; n];
    Noise::new(11).stream(Purpose::Field, stream).fill_normal(&mut normals);
    normals
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn is_the_transpose(factor: &impl NoiseFactor, name: &str) {
    let (x, z) = (normals(factor.n_unknowns(), 4), normals(factor.n_motions(), 5));
    let (mut l_z, mut lt_x) = (vec![f64::NAN; x.len()], vec![f64::NAN; z.len()]);
    factor.apply(&z, &mut l_z);
    factor.apply_transposed(&x, &mut lt_x);
    // Sums of at most 25 products of numbers below about 3.
    let difference = (dot(&z, &lt_x) - dot(&l_z, &x)).abs();
    assert!(difference < 1e-13, "{name}: {difference:e}");
    assert!(dot(&l_z, &x).abs() > 1e-3, "{name} is not seen");
}

#[test]
fn every_factor_and_its_transpose_agree_on_products() {
    is_the_transpose(&diagonal(), "diagonal");
    is_the_transpose(&dense(), "dense");
    is_the_transpose(&low_rank(), "low rank");
    is_the_transpose(&sparse(), "sparse");
}

/// One component of many.
fn component(values: &[f64], k: usize, components: usize) -> Vec<f64> {
    values.iter().skip(k).step_by(components).copied().collect()
}

macro_rules! components_are_those_alone {
    ($factor:expr, $components:expr) => {{
        let (factor, c) = ($factor, $components);
        let (x, z) = (normals(factor.n_unknowns() * c, 6), normals(factor.n_motions() * c, 7));
        let (mut l_z, mut lt_x) = (vec![f64::NAN; x.len()], vec![f64::NAN; z.len()]);
        factor.apply_to_components(c, &z, &mut l_z);
        factor.apply_transposed_to_components(c, &x, &mut lt_x);
        for k in 0..c {
            let (mut forth, mut back) =
                (vec![0.0; factor.n_unknowns()], vec![0.0; factor.n_motions()]);
            factor.apply(&component(&z, k, c), &mut forth);
            factor.apply_transposed(&component(&x, k, c), &mut back);
            assert_eq!(component(&l_z, k, c), forth, "component {k} of {c}");
            assert_eq!(component(&lt_x, k, c), back, "component {k} of {c}, transposed");
        }
    }};
}

#[test]
fn fields_side_by_side_get_what_each_gets_alone() {
    // Every width of a block, and blocks after one another.
    for c in [1, 2, 3, 4, 5, 8, 14] {
        components_are_those_alone!(diagonal(), c);
        components_are_those_alone!(dense(), c);
        components_are_those_alone!(low_rank(), c);
        components_are_those_alone!(sparse(), c);
    }
}

#[test]
fn rows_and_columns_are_those_of_the_factor() {
    let mut unit = [0.0; N];
    unit[2] = 1.0;
    let mut row = [0.0; N];
    dense().apply_transposed(&unit, &mut row);
    assert_eq!(dense().row(2), &row[..3]);
    let mut row = [0.0; 2];
    low_rank().apply_transposed(&unit, &mut row);
    assert_eq!(low_rank().columns().map(|column| column[2]).collect::<Vec<_>>(), row);
    assert_eq!(sparse().row(2).0, [3, 3]);
    assert_eq!(diagonal().deviations(), normals(N, 3));
}

#[cfg(feature = "faer")]
#[test]
fn the_factor_by_faer_is_the_same_within_roundoff() {
    let n = 70;
    let covariance: Vec<f64> =
        (0..n * n).map(|k| 1.0 / (1.0 + (k / n).abs_diff(k % n) as f64)).collect();
    let (own, other) =
        (DenseFactor::new(n, &covariance).unwrap(), DenseFactor::by_faer(n, &covariance).unwrap());
    for i in 0..n {
        for (a, b) in own.row(i).iter().zip(other.row(i)) {
            // Sums of 70 products below one, over pivots above 0.6.
            assert!((a - b).abs() < 1e-13, "{a} {b}");
        }
    }
    let indefinite = [1.0, 2.0, 2.0, 1.0];
    let error = DenseFactor::by_faer(2, &indefinite).unwrap_err();
    assert_eq!(error, DenseFactor::new(2, &indefinite).unwrap_err());
}
