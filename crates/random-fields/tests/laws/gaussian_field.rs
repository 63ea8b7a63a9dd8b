//! Fields at given points: what was asked for is what is drawn.

use random_fields::{Correlation, CorrelationFunction, Enough, GaussianField, pivoted_cholesky};
use sde_integrators::Noise;

fn lattice(counts: [usize; 2], spacing: f64) -> Vec<[f64; 2]> {
    let place = |k: usize| [(k % counts[0]) as f64 * spacing, (k / counts[0]) as f64 * spacing];
    (0..counts[0] * counts[1]).map(place).collect()
}

/// The field by each way to draw it; the tolerance of the factor is far below the sampling error.
fn both(positions: &[[f64; 2]], spacing: f64, correlation: Correlation) -> [GaussianField; 2] {
    [
        GaussianField::by_pivoted_cholesky(positions, correlation, 1e-8).unwrap(),
        GaussianField::by_circulant_embedding(positions, spacing, correlation).unwrap(),
    ]
}

/// Realisations of a field, each a row.
fn realisations(field: &GaussianField, seed: u64, number: u32, n: u64) -> Vec<Vec<f64>> {
    let draw = |realisation| {
        let mut out = vec![0.0; field.n_nodes()];
        field.sample(&Noise::new(seed), realisation, number, &mut out).unwrap();
        out
    };
    (0..n).map(draw).collect()
}

/// `L^-1 z` of a factor with all columns: its rows in the order of the pivots are a triangle.
fn whitened((columns, pivots): (&[f64], &[usize]), z: &[f64]) -> Vec<f64> {
    let n = z.len();
    let mut y = vec![0.0; n];
    for i in 0..n {
        let known: f64 = (0..i).map(|j| columns[j * n + pivots[i]] * y[j]).sum();
        y[i] = (z[pivots[i]] - known) / columns[i * n + pivots[i]];
    }
    y
}

#[test]
fn all_entries_of_the_covariance_of_a_small_lattice_pass_one_chi_square_test() {
    let positions = lattice([4, 3], 0.5);
    let n = positions.len();
    for function in CorrelationFunction::ALL {
        let correlation = Correlation { function, length: 0.8 };
        let entry = |i: usize, j: usize| correlation.between(&positions[i], &positions[j]);
        let factor = pivoted_cholesky(n, entry, Enough::Trace(0.0)).unwrap();
        for (field, way) in both(&positions, 0.5, correlation).iter().zip(["factor", "lattice"]) {
            let n_draws = 3000;
            let mut sums = vec![0.0; n * n];
            for z in realisations(field, 17, 0, n_draws) {
                let y = whitened((&factor.columns, &factor.pivots), &z);
                for i in 0..n {
                    for j in 0..=i {
                        sums[i * n + j] += y[i] * y[j];
                    }
                }
            }
            // Of independent normals y, a mean of y_i y_j has the variance 1/N, one of y_i^2 - 1 the variance 2/N.
            let draws = n_draws as f64;
            let mut statistic = 0.0;
            for i in 0..n {
                for j in 0..i {
                    statistic += sums[i * n + j].powi(2) / draws;
                }
                statistic += (sums[i * n + i] - draws).powi(2) / (2.0 * draws);
            }
            let entries = (n * (n + 1) / 2) as f64;
            let deviations = (statistic - entries) / (2.0 * entries).sqrt();
            assert!(deviations.abs() < 4.0, "{function:?} by {way}: {deviations}");
        }
    }
}

#[test]
fn covariance_is_right_at_every_lag_and_does_not_go_round_the_border() {
    let (n, length) = (16, 4.0);
    let positions = lattice([n, 3], 1.0);
    let correlation = Correlation { function: CorrelationFunction::Matern32, length };
    for (field, way) in both(&positions, 1.0, correlation).iter().zip(["factor", "lattice"]) {
        let draws = realisations(field, 23, 0, 4000);
        // The last is at the other border: periodic in 16 it would be next to the first.
        for other in [0, 1, 3, 8, n - 1, n, 3 * n - 1] {
            let expected = correlation.between(&positions[0], &positions[other]);
            let mean = draws.iter().map(|z| z[0] * z[other]).sum::<f64>() / 4000.0;
            let error = ((1.0 + expected * expected) / 4000.0).sqrt();
            assert!((mean - expected).abs() < 4.0 * error, "{way}, {other}: {mean} {expected}");
        }
    }
    assert!(correlation.at(15.0) < 0.01 && correlation.at(1.0) > 0.9);
}

#[test]
fn other_realisations_numbers_and_seeds_are_independent_fields() {
    let positions = lattice([2, 2], 1.0);
    let correlation = Correlation { function: CorrelationFunction::Exponential, length: 1.0 };
    for field in &both(&positions, 1.0, correlation) {
        let n = 4000;
        let draws = realisations(field, 29, 0, n + 1);
        let next = &draws[1..];
        let (number, seed) = (realisations(field, 29, 1, n), realisations(field, 30, 0, n));
        for (others, what) in [(next, "realisation"), (&number, "number"), (&seed, "seed")] {
            for node in 0..4 {
                let products = draws.iter().zip(others).map(|(a, b)| a[node] * b[node]);
                let mean = products.sum::<f64>() / n as f64;
                assert!(mean.abs() < 4.0 / (n as f64).sqrt(), "{what}, node {node}: {mean}");
            }
        }
    }
}

/// The mean square of a field over a whole lattice has the variance `2/n^2` times the sum of the squares of all correlations.
fn mean_square_is_one<const D: usize>(per_axis: usize, correlation: Correlation) {
    let n = per_axis.pow(u32::try_from(D).unwrap());
    let place = |point: usize| -> [f64; D] {
        let mut rest = point;
        std::array::from_fn(|_| {
            let along = rest % per_axis;
            rest /= per_axis;
            along as f64
        })
    };
    let positions: Vec<[f64; D]> = (0..n).map(place).collect();
    let field = GaussianField::by_circulant_embedding(&positions, 1.0, correlation).unwrap();
    let mut z = vec![0.0; n];
    field.sample(&Noise::new(41), 0, 0, &mut z).unwrap();
    // Around a node in the middle, which has more neighbours than any other.
    let middle = [(per_axis / 2) as f64; D];
    let squares: f64 = positions.iter().map(|x| correlation.between(x, &middle).powi(2)).sum();
    let error = (2.0 * squares / n as f64).sqrt();
    let found = z.iter().map(|z| z * z).sum::<f64>() / n as f64;
    assert!(error < 0.1 && (found - 1.0).abs() < 4.0 * error, "{D}-D: {found} within {error}");
}

#[test]
fn large_lattices_in_one_to_three_dimensions_have_unit_variance() {
    let wendland = Correlation { function: CorrelationFunction::WendlandC2, length: 4.0 };
    mean_square_is_one::<1>(4096, wendland);
    mean_square_is_one::<2>(256, wendland);
    mean_square_is_one::<3>(64, wendland);
}
