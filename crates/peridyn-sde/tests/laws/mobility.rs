//! The mobility: its factor, its free nodes, and its distance from the exact matrix.

use peridyn_sde::{CorrelatedMobility, Error, Mobility};
use random_fields::{Correlation, CorrelationFunction};
use sde_integrators::{Noise, Purpose};

const M: f64 = 0.7;
const NUGGET: f64 = 0.1;

fn plate(n: usize) -> Vec<[f64; 2]> {
    (0..n * n).map(|k| [(k % n) as f64, (k / n) as f64]).collect()
}

/// All but the bottom row, as with a prescribed edge.
fn gripped(n: usize) -> Vec<bool> {
    (0..n * n).map(|k| k >= n).collect()
}

fn smooth(length: f64) -> CorrelatedMobility {
    let correlation = Correlation { function: CorrelationFunction::Gaussian, length };
    CorrelatedMobility { mobility: M, correlation, nugget: NUGGET }
}

/// Every way to make one, on a plate of 8 by 8 nodes.
fn each(free: &[bool]) -> Vec<(&'static str, Mobility)> {
    let places = plate(8);
    let matrix: Vec<f64> = (0..64 * 64_usize)
        .map(|k| if k / 64 == k % 64 { 2.0 } else { 1.0 / (1 + (k / 64).abs_diff(k % 64)) as f64 })
        .collect();
    vec![
        ("identity", Mobility::identity(free, M).unwrap()),
        ("matrix", Mobility::from_matrix(free, &matrix).unwrap()),
        ("dense", Mobility::dense(&places, free, &smooth(2.0)).unwrap()),
        ("low rank", Mobility::low_rank(&places, free, &smooth(4.0), 1e-3).unwrap()),
    ]
}

fn normals(n: usize) -> Vec<f64> {
    let mut normals = vec![0.0; n];
    Noise::new(3).stream(Purpose::Field, 0).fill_normal(&mut normals);
    normals
}

fn drift(mobility: &Mobility, components: usize, f: &[f64]) -> Vec<f64> {
    let mut motions = vec![f64::NAN; components * mobility.n_motions()];
    let mut out = vec![f64::NAN; f.len()];
    mobility.apply_factor_transposed(components, f, &mut motions).unwrap();
    mobility.apply_factor(components, &motions, &mut out).unwrap();
    out
}

/// Column `j` of the matrix, by the drift of a unit force.
fn column(mobility: &Mobility, j: usize) -> Vec<f64> {
    let mut unit = vec![0.0; mobility.n_nodes()];
    unit[j] = 1.0;
    drift(mobility, 1, &unit)
}

#[test]
fn dense_factor_makes_the_covariance_it_was_given() {
    let (places, free, config) = (plate(8), gripped(8), smooth(2.0));
    let mobility = Mobility::dense(&places, &free, &config).unwrap();
    for j in 0..64 {
        for (i, found) in column(&mobility, j).into_iter().enumerate() {
            let own = if i == j { NUGGET } else { 0.0 };
            let shared = config.correlation.between(&places[i], &places[j]) + own;
            let expected = if free[i] && free[j] { M * shared } else { 0.0 };
            assert!((found - expected).abs() < 1e-12, "({i}, {j}): {found} {expected}");
        }
    }
}

#[test]
fn low_rank_factor_misses_no_entry_by_more_than_the_tolerance_of_the_trace() {
    let (places, free, config) = (plate(10), vec![true; 100], smooth(4.0));
    for tolerance in [1e-1, 1e-3, 1e-6] {
        let mobility = Mobility::low_rank(&places, &free, &config, tolerance).unwrap();
        let mut trace = 0.0;
        for j in 0..100 {
            for (i, found) in column(&mobility, j).into_iter().enumerate() {
                let own = if i == j { NUGGET } else { 0.0 };
                let expected = M * (config.correlation.between(&places[i], &places[j]) + own);
                // An entry of a positive semidefinite remainder is at most its trace.
                let error = (found - expected).abs();
                assert!(error <= tolerance * 100.0 * M + 1e-13, "{tolerance} ({i}, {j}): {error}");
                trace += if i == j { expected - found } else { 0.0 };
            }
        }
        assert!(trace <= tolerance * 100.0 * M && trace > 0.0, "{tolerance}: {trace}");
        let rank = mobility.n_motions() - 100;
        assert!(rank > 2 && rank < 60, "{tolerance}: {rank}");
    }
}

#[test]
fn every_mobility_is_symmetric_and_positive_definite_on_free_nodes() {
    let free = gripped(8);
    for (name, mobility) in each(&free) {
        let mut x = normals(64);
        (0..8).for_each(|fixed| x[fixed] = 0.0);
        let product: f64 = drift(&mobility, 1, &x).iter().zip(&x).map(|(a, b)| a * b).sum();
        let square: f64 = x.iter().map(|x| x * x).sum();
        assert!(product >= M * NUGGET * square, "{name}: {product} {square}");
        for (i, j) in [(9, 9), (9, 10), (20, 61)] {
            let (forth, back) = (column(&mobility, j)[i], column(&mobility, i)[j]);
            assert!((forth - back).abs() < 1e-14, "{name} ({i}, {j})");
        }
    }
}

#[test]
fn fixed_nodes_neither_move_nor_move_others() {
    for (name, mobility) in each(&gripped(8)) {
        for fixed in 0..8 {
            assert_eq!(column(&mobility, fixed), [0.0; 64], "{name}");
        }
        let mut out = vec![f64::NAN; 128];
        mobility.apply_factor(2, &normals(2 * mobility.n_motions()), &mut out).unwrap();
        assert_eq!(&out[..16], [0.0; 16], "{name}");
        assert!(out[16..].iter().all(|u| u.abs() > 0.0), "{name}");
    }
}

#[test]
fn components_do_not_see_each_other() {
    for (name, mobility) in each(&gripped(8)) {
        let f = normals(64 * 3);
        let together = drift(&mobility, 3, &f);
        for k in 0..3 {
            let one = |values: &[f64]| -> Vec<f64> {
                values.iter().skip(k).step_by(3).copied().collect()
            };
            assert_eq!(one(&together), drift(&mobility, 1, &one(&f)), "{name}, component {k}");
        }
    }
}

#[test]
fn matrix_that_is_not_positive_definite_is_refused_with_its_row() {
    let refused = |free: &[bool], matrix: &[f64]| match Mobility::from_matrix(free, matrix) {
        Err(Error::NotPositiveDefinite { row, .. }) => Some(row),
        _ => None,
    };
    assert_eq!(refused(&[true; 2], &[1.0, 2.0, 2.0, 1.0]), Some(1));
    assert_eq!(refused(&[true; 2], &[-1.0, 0.0, 0.0, 1.0]), Some(0));
    // The row of a fixed node does not matter.
    assert_eq!(refused(&[true, false], &[1.0, 2.0, 2.0, 1.0]), None);
    assert!(Mobility::from_matrix(&[true, false], &[1.0, 2.0, 2.0, 1.0]).is_ok());
    // Of rank one to all digits but the last: the pivot is roundoff.
    assert_eq!(refused(&[true; 2], &[1.0, 1.0, 1.0, 1.0 + 1e-16]), Some(1));
    let skew = Mobility::from_matrix(&[true; 2], &[1.0, 0.1, 0.2, 1.0]);
    assert!(matches!(skew, Err(Error::Factor(_))), "{skew:?}");
}

#[test]
fn smooth_correlation_without_a_nugget_is_refused() {
    let (places, config) = (plate(8), CorrelatedMobility { nugget: 0.0, ..smooth(8.0) });
    let refused = Mobility::dense(&places, &[true; 64], &config);
    assert!(matches!(refused, Err(Error::NotPositiveDefinite { .. })), "{refused:?}");
    let refused = Mobility::low_rank(&places, &[true; 64], &config, 1e-3);
    assert!(matches!(refused, Err(Error::Parameter { name: "nugget", .. })), "{refused:?}");
}

#[test]
fn input_that_cannot_be_is_refused() {
    let (places, free) = (plate(3), [true; 9]);
    let dense = |config| Mobility::dense(&places, &free, &config);
    let negative = dense(CorrelatedMobility { nugget: -0.1, ..smooth(1.0) });
    assert!(matches!(negative, Err(Error::Parameter { name: "nugget", .. })));
    let still = dense(CorrelatedMobility { mobility: 0.0, ..smooth(1.0) });
    assert!(matches!(still, Err(Error::Parameter { name: "mobility", .. })));
    let nan = dense(smooth(f64::NAN));
    assert!(matches!(nan, Err(Error::Field(random_fields::Error::NotPositive { .. }))));
    let short = Mobility::dense(&places, &free[..8], &smooth(1.0));
    assert!(matches!(short, Err(Error::Length { value: 8, expected: 9, .. })));
    let fixed = Mobility::identity(&[false; 3], 1.0);
    assert!(matches!(fixed, Err(Error::NoFreeNode { n_nodes: 3 })));
    let nowhere = Mobility::low_rank(&[[f64::NAN]], &[true], &smooth(1.0), 0.1);
    assert!(matches!(nowhere, Err(Error::Node { node: 0, .. })));
    let all = Mobility::low_rank(&places, &free, &smooth(1.0), 0.0);
    assert!(matches!(all, Err(Error::Parameter { .. })));
    let mobility = dense(smooth(1.0)).unwrap();
    let wrong = mobility.apply_factor(2, &[0.0; 18], &mut [0.0; 17]);
    assert!(matches!(wrong, Err(Error::Length { value: 17, expected: 18, .. })));
}
