//! Fields given measurements.

use random_fields::{
    ConditionedField, Correlation, CorrelationFunction, Measurement, RandomField, Truncation,
};
use sde_integrators::Noise;

fn field(function: CorrelationFunction) -> RandomField<2> {
    let points: Vec<[f64; 2]> =
        (0..231).map(|k| [f64::from(k % 21) * 0.1, f64::from(k / 21) * 0.1]).collect();
    let correlation = Correlation { function, length: 0.6 };
    RandomField::on_points(&points, correlation, Truncation::Terms(50)).unwrap()
}

fn measurements(standard_deviation: f64) -> Vec<Measurement<2>> {
    let at =
        |x: f64, y: f64, value: f64| Measurement { position: [x, y], value, standard_deviation };
    vec![at(0.2, 0.3, 1.2), at(1.0, 0.5, -0.4), at(1.7, 0.9, 2.0), at(0.6, 0.1, 0.1)]
}

/// Solves `A x = b` by Gaussian elimination with row exchanges.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for i in 0..n {
        let best = (i..n).max_by(|&j, &k| a[j][i].abs().total_cmp(&a[k][i].abs())).unwrap();
        a.swap(i, best);
        b.swap(i, best);
        for j in i + 1..n {
            let factor = a[j][i] / a[i][i];
            for k in i..n {
                a[j][k] -= factor * a[i][k];
            }
            b[j] -= factor * b[i];
        }
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}

#[test]
fn mean_and_variance_are_those_of_the_dense_formula() {
    for deviation in [0.0, 0.3] {
        let field = field(CorrelationFunction::Matern32);
        let data = measurements(deviation);
        let given = ConditionedField::new(field.clone(), &data).unwrap();
        let covariance = |a: &[f64; 2], b: &[f64; 2]| field.covariance(a, b).unwrap();
        let matrix: Vec<Vec<f64>> = (0..4)
            .map(|i| {
                let noise = |j| if i == j { deviation * deviation } else { 0.0 };
                let entry = |j: usize| covariance(&data[i].position, &data[j].position) + noise(j);
                (0..4).map(entry).collect()
            })
            .collect();
        for x in [[0.2, 0.3], [0.8, 0.8], [1.95, 0.05]] {
            let k: Vec<f64> = data.iter().map(|one| covariance(&x, &one.position)).collect();
            let weights = solve(matrix.clone(), k.clone());
            let mean: f64 = weights.iter().zip(&data).map(|(w, one)| w * one.value).sum();
            let known: f64 = weights.iter().zip(&k).map(|(w, k)| w * k).sum();
            let mut found = [0.0];
            given.mean(&[x], &mut found).unwrap();
            assert!((found[0] - mean).abs() < 1e-12, "{x:?}: {found:?} {mean}");
            let variance = given.variance(&x).unwrap();
            let expected = covariance(&x, &x) - known;
            assert!((variance - expected).abs() < 1e-12, "{x:?}: {variance} {expected}");
        }
    }
}

#[test]
fn every_realisation_meets_exact_measurements() {
    for function in CorrelationFunction::ALL {
        let data = measurements(0.0);
        let given = ConditionedField::new(field(function), &data).unwrap();
        let positions: Vec<[f64; 2]> = data.iter().map(|one| one.position).collect();
        for realisation in 0..5 {
            let mut coefficients = vec![0.0; given.n_terms()];
            given.coefficients(&Noise::new(9), realisation, 0, &mut coefficients).unwrap();
            let mut values = [0.0; 4];
            given.field().values(&coefficients, &positions, &mut values).unwrap();
            for (value, one) in values.iter().zip(&data) {
                // Roundoff times the condition of a few correlated measurements.
                assert!((value - one.value).abs() < 1e-11, "{function:?}: {value} {}", one.value);
            }
        }
    }
}

#[test]
fn conditioned_modes_are_what_the_coefficients_become() {
    let data = measurements(0.2);
    let given = ConditionedField::new(field(CorrelationFunction::Exponential), &data).unwrap();
    let (n, x) = (given.n_terms(), [[0.4, 0.4]]);
    let (mut modes, mut mean) = (vec![0.0; n], [0.0]);
    given.modes(&x, &mut modes).unwrap();
    given.mean(&x, &mut mean).unwrap();
    let mut normals = vec![0.0; n];
    given.field().coefficients(&Noise::new(1), 0, 0, &mut normals).unwrap();
    let expected: f64 = mean[0] + modes.iter().zip(&normals).map(|(a, b)| a * b).sum::<f64>();
    given.condition(&mut normals).unwrap();
    let mut value = [0.0];
    given.field().values(&normals, &x, &mut value).unwrap();
    assert!((value[0] - expected).abs() < 1e-13, "{value:?} {expected}");
}

#[test]
fn uncertain_and_exact_measurements_go_together() {
    let mut data = measurements(0.0);
    data[1].standard_deviation = 0.5;
    // A second, exact one at the place of the uncertain one overrules it.
    data.push(Measurement { value: 0.7, standard_deviation: 0.0, ..data[1] });
    let given = ConditionedField::new(field(CorrelationFunction::Exponential), &data).unwrap();
    let mut mean = [0.0];
    given.mean(&[data[1].position], &mut mean).unwrap();
    assert!((mean[0] - 0.7).abs() < 1e-12, "{mean:?}");
    assert!(given.variance(&data[4].position).unwrap().abs() < 1e-12);
}

#[test]
fn without_measurements_the_field_is_as_before() {
    let plain = field(CorrelationFunction::Exponential);
    let given = ConditionedField::new(plain.clone(), &[]).unwrap();
    let mut coefficients = vec![0.0; plain.n_terms()];
    plain.coefficients(&Noise::new(2), 0, 0, &mut coefficients).unwrap();
    let before = coefficients.clone();
    given.condition(&mut coefficients).unwrap();
    assert_eq!(before, coefficients);
}
