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
