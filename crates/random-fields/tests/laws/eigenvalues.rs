//! Eigenvalues against printed equations and dense matrices, kriging against the dense formula.

use nalgebra::{DMatrix, DVector};
use random_fields::{
    ConditionedField, Correlation, CorrelationFunction, Measurement, RandomField,
    SpatialCorrelation, Truncation,
};
use sde_integrators::Noise;

/// A box of three by two lengths of its correlation.
pub(super) const CORNERS: [[f64; 2]; 2] = [[0.0, 0.0], [3.0, 4.0]];

fn exponential(length: f64) -> Correlation {
    Correlation { function: CorrelationFunction::Exponential, length }
}

/// `exp(-|dx| - |dy|/2)`.
pub(super) fn soil() -> SpatialCorrelation<2> {
    SpatialCorrelation::separable([exponential(1.0), exponential(2.0)])
}

/// Points of a lattice from a corner on.
pub(super) fn lattice(corner: f64, counts: [usize; 2], spacing: f64) -> Vec<[f64; 2]> {
    let place = |k: usize| [k % counts[0], k / counts[0]].map(|at| corner + at as f64 * spacing);
    (0..counts[0] * counts[1]).map(place).collect()
}

/// The root between two values of opposite sign, by bisection.
fn bisection(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let is_positive = f(low) > 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == is_positive { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// `b - w tan w = 0` and `w + b tan w = 0` (Ghanem and Spanos 1991, section 2.3.3), multiplied by the cosine. Roundoff of a root
/// beside a multiple of pi/2, squared.
#[test]
fn eigenvalues_of_an_interval_solve_the_printed_equations() {
    use std::f64::consts::FRAC_PI_2;
    for b in [0.02_f64, 0.5, 3.0, 40.0] {
        let ends = [[0.0], [2.0 * b]];
        let field = RandomField::on_box(ends, exponential(1.0), Truncation::Terms(100)).unwrap();
        for (m, share) in field.shares().iter().enumerate() {
            let (low, high) = (m as f64 * FRAC_PI_2, (m + 1) as f64 * FRAC_PI_2);
            let root = if m % 2 == 0 {
                bisection(low, high, |w| b * w.cos() - w * w.sin())
            } else {
                bisection(low, high, |w| w * w.cos() + b * w.sin())
            };
            // lambda/(2 a) with a = b l.
            let error = share * b * (1.0 + (root / b).powi(2)) - 1.0;
            assert!(error.abs() < 2e-13, "b = {b}, term {m}: {error:e}");
        }
    }
}

/// The roots are m pi/2 + 2 b/(m pi): the shares beyond n sum to 4 b/(pi^2 (n - 1/2)), with an error of order 1/n^2.
#[test]
fn shares_sum_to_one() {
    let (b, n) = (1.5, 2000);
    let ends = [[0.0], [2.0 * b]];
    let field = RandomField::on_box(ends, exponential(1.0), Truncation::Terms(n)).unwrap();
    let tail = 4.0 * b / (std::f64::consts::PI.powi(2) * (n as f64 - 0.5));
    assert!((field.mean_left_out_variance() / tail - 1.0).abs() < 1e-6);
}

/// Within roundoff with all points as pivots; 20 terms by four pivots each leave out at most 6 % more than the least.
#[test]
fn shares_by_points_are_eigenvalues_of_their_covariance() {
    let points = lattice(0.0, [16, 21], 0.2);
    let n = points.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| soil().between(&points[i], &points[j]) / n as f64);
    let mut exact: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
    exact.sort_by(|a, b| b.total_cmp(a));
    let by = |terms| RandomField::on_points(&points, soil(), Truncation::Terms(terms)).unwrap();
    for (found, exact) in by(n.div_ceil(4)).shares().iter().zip(&exact) {
        assert!((found / exact - 1.0).abs() < 2e-13, "{found} {exact}");
    }
    let least = 1.0 - exact[..20].iter().sum::<f64>();
    let ratio = by(20).mean_left_out_variance() / least;
    assert!((1.0..1.06).contains(&ratio), "{ratio}");
}

fn measurements(standard_deviation: f64) -> Vec<Measurement<2>> {
    let at =
        |x: f64, y: f64, value: f64| Measurement { position: [x, y], value, standard_deviation };
    vec![
        at(0.3, 0.4, 1.5),
        at(1.1, 2.7, -0.5),
        at(2.6, 0.9, 0.3),
        at(2.2, 3.6, -2.0),
        at(0.7, 3.2, 1.0),
        at(1.6, 1.5, 0.0),
    ]
}

/// Mean and variance at points by a covariance of two points (Rasmussen and Williams 2006, eq 2.23 and 2.24).
fn kriging(
    points: &[[f64; 2]],
    data: &[Measurement<2>],
    covariance: impl Fn(&[f64; 2], &[f64; 2]) -> f64,
) -> Vec<[f64; 2]> {
    let m = data.len();
    let matrix = DMatrix::from_fn(m, m, |i, j| {
        let noise = if i == j { data[i].standard_deviation.powi(2) } else { 0.0 };
        covariance(&data[i].position, &data[j].position) + noise
    });
    let factor = matrix.lu();
    let values = DVector::from_iterator(m, data.iter().map(|one| one.value));
    let at = |x: &[f64; 2]| {
        let row = DVector::from_iterator(m, data.iter().map(|one| covariance(x, &one.position)));
        let weights = factor.solve(&row).unwrap();
        [weights.dot(&values), covariance(x, x) - weights.dot(&row)]
    };
    points.iter().map(at).collect()
}

/// Six measurements, exact and uncertain, by a box of 200 terms and by points of 100: the dense formula with the covariance of
/// the terms within roundoff, that of the whole correlation within what the terms leave out, and realisations that have the
/// measured values.
#[test]
fn conditioned_fields_are_kriging() {
    let points = lattice(0.1, [8, 10], 0.4);
    let cover = lattice(0.0, [31, 41], 0.1);
    for deviation in [0.0, 0.4] {
        let data = measurements(deviation);
        for field in [
            RandomField::on_box(CORNERS, soil(), Truncation::Terms(200)).unwrap(),
            RandomField::on_points(&cover, soil(), Truncation::Terms(100)).unwrap(),
        ] {
            let given = ConditionedField::new(field, &data).unwrap();
            let mut means = vec![0.0; points.len()];
            given.mean(&points, &mut means).unwrap();
            let found: Vec<[f64; 2]> = points
                .iter()
                .zip(means)
                .map(|(x, mean)| [mean, given.variance(x).unwrap()])
                .collect();
            let far = |expected: &[[f64; 2]]| {
                let both = found.as_flattened().iter().zip(expected.as_flattened());
                both.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
            };
            let terms = kriging(&points, &data, |a, b| given.field().covariance(a, b).unwrap());
            assert!(far(&terms) < 1e-13, "{:e}", far(&terms));
            let whole = far(&kriging(&points, &data, |a, b| soil().between(a, b)));
            assert!(whole < 0.2, "{whole}");

            let positions: Vec<[f64; 2]> = data.iter().map(|one| one.position).collect();
            let (mut xi, mut values) = (vec![0.0; given.n_terms()], vec![0.0; data.len()]);
            for realisation in 0..if deviation > 0.0 { 0 } else { 100 } {
                given.coefficients(&Noise::new(61), realisation, 0, &mut xi).unwrap();
                given.field().values(&xi, &positions, &mut values).unwrap();
                for (value, one) in values.iter().zip(&data) {
                    assert!((value - one.value).abs() < 1e-13, "{value} {}", one.value);
                }
            }
        }
    }
}
