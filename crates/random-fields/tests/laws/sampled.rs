//! Realisations of every kind of field against its covariance.

use random_fields::{
    ConditionedField, Correlation, CorrelationFunction, GaussianField, Measurement, RandomField,
    SpatialCorrelation, Truncation,
};
use sde_integrators::Noise;

use super::eigenvalues::{CORNERS, lattice, soil};

const DRAWS: u32 = 20_000;

/// Standard errors between a mean of products of two values and their covariance, the largest of all pairs; `(1 + rho^2)/N` is
/// the variance of such a mean. The largest of 210 normals is above 4.2 with a probability of 0.6 %.
fn has_its_covariance(
    name: &str,
    points: &[[f64; 2]],
    mut draw: impl FnMut(u64, &mut [f64]),
    covariance: impl Fn(&[f64; 2], &[f64; 2]) -> f64,
) {
    let n = points.len();
    let (mut sums, mut z) = (vec![0.0; n * n], vec![0.0; n]);
    for realisation in 0..DRAWS {
        draw(u64::from(realisation), &mut z);
        for i in 0..n {
            for j in 0..=i {
                sums[i * n + j] += z[i] * z[j];
            }
        }
    }
    for i in 0..n {
        for j in 0..=i {
            let expected = covariance(&points[i], &points[j]);
            let own = covariance(&points[i], &points[i]) * covariance(&points[j], &points[j]);
            let error = ((own + expected * expected) / f64::from(DRAWS)).sqrt();
            let z = (sums[i * n + j] / f64::from(DRAWS) - expected) / error;
            assert!(z.abs() < 4.2, "{name}: points {i} and {j}: {z}");
        }
    }
}

/// By terms of a box and of points, along inclined axes, given measurements, and by circulant embedding.
#[test]
fn realisations_have_the_covariance_of_their_field() {
    let points = lattice(0.0, [4, 5], 0.5);
    let cover = lattice(0.0, [16, 21], 0.2);
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    let function = CorrelationFunction::Matern52;
    let inclined = SpatialCorrelation::elliptic(function, [2.0, 0.4])
        .with_axes([[cosine, sine], [-sine, cosine]]);
    let on_points = |correlation, share| {
        RandomField::on_points(&cover, correlation, Truncation::Share(share)).unwrap()
    };
    for (name, field) in [
        ("box", RandomField::on_box(CORNERS, soil(), Truncation::Share(0.9)).unwrap()),
        ("points", on_points(soil(), 0.9)),
        ("inclined", on_points(inclined, 0.99)),
    ] {
        let n_terms = field.n_terms();
        let (mut modes, mut xi) = (vec![0.0; points.len() * n_terms], vec![0.0; n_terms]);
        field.modes(&points, &mut modes).unwrap();
        let draw = |realisation, z: &mut [f64]| {
            field.coefficients(&Noise::new(41), realisation, 0, &mut xi).unwrap();
            for (z, row) in z.iter_mut().zip(modes.chunks_exact(n_terms)) {
                *z = row.iter().zip(&xi).map(|(mode, xi)| mode * xi).sum();
            }
        };
        has_its_covariance(name, &points, draw, |a, b| field.covariance(a, b).unwrap());
    }
    let wendland = Correlation { function: CorrelationFunction::WendlandC2, length: 0.7 };
    for (name, correlation) in
        [("lattice", soil()), ("lattice, inclined", inclined), ("Wendland", wendland.into())]
    {
        let field = GaussianField::by_circulant_embedding(&points, 0.5, correlation).unwrap();
        let draw = |realisation, z: &mut [f64]| {
            field.sample(&Noise::new(42), realisation, 0, z).unwrap();
        };
        has_its_covariance(name, &points, draw, |a, b| correlation.between(a, b));
    }
}

/// Mean and variance of 5,000 realisations; the largest of 40 normals is above 4 with a probability of 0.3 %.
#[test]
fn realisations_given_measurements_have_the_mean_and_variance_of_kriging() {
    let at = |x: f64, y: f64, value: f64, standard_deviation: f64| Measurement {
        position: [x, y],
        value,
        standard_deviation,
    };
    let data = [at(0.3, 0.4, 1.5, 0.4), at(1.1, 2.7, -0.5, 0.4), at(2.2, 3.6, -2.0, 0.0)];
    let field = RandomField::on_box(CORNERS, soil(), Truncation::Terms(200)).unwrap();
    let given = ConditionedField::new(field, &data).unwrap();
    let (points, n_terms) = (lattice(0.1, [4, 5], 0.7), given.n_terms());
    let (mut modes, mut means) = (vec![0.0; points.len() * n_terms], vec![0.0; points.len()]);
    given.field().modes(&points, &mut modes).unwrap();
    given.mean(&points, &mut means).unwrap();
    let (mut xi, mut sums, n) = (vec![0.0; n_terms], vec![[0.0; 2]; points.len()], 5000);
    for realisation in 0..n {
        given.coefficients(&Noise::new(62), realisation, 0, &mut xi).unwrap();
        for ((row, sums), mean) in modes.chunks_exact(n_terms).zip(&mut sums).zip(&means) {
            let from_mean = row.iter().zip(&xi).map(|(mode, xi)| mode * xi).sum::<f64>() - mean;
            sums[0] += from_mean;
            sums[1] += from_mean * from_mean;
        }
    }
    for (sums, x) in sums.iter().zip(&points) {
        let (n, variance) = (n as f64, given.variance(x).unwrap());
        let of_mean = sums[0] / n / (variance / n).sqrt();
        let of_variance = (sums[1] / n - variance) / (variance * (2.0 / n).sqrt());
        assert!(of_mean.abs() < 4.0 && of_variance.abs() < 4.0, "{x:?}: {of_mean} {of_variance}");
    }
}

/// Vanmarcke 1983, section 5.1: the variance of the mean of an exponential field over an interval of `q` lengths. What the other
/// terms have of the mean, and the spacing of the points, are below 1e-3.
#[test]
fn the_mean_over_a_box_has_the_variance_of_its_closed_form() {
    let of_interval = |q: f64| 2.0 / (q * q) * (q - 1.0 + (-q).exp());
    let exact = of_interval(3.0) * of_interval(2.0);
    let points = lattice(0.025, [60, 80], 0.05);
    let n = points.len() as f64;
    let field = RandomField::on_box(CORNERS, soil(), Truncation::Share(0.97)).unwrap();
    let mut row = vec![0.0; field.n_terms()];
    let mut means = vec![0.0; field.n_terms()];
    for x in &points {
        field.modes(std::slice::from_ref(x), &mut row).unwrap();
        means.iter_mut().zip(&row).for_each(|(mean, mode)| *mean += mode / n);
    }
    let variance: f64 = means.iter().map(|mean| mean * mean).sum();
    assert!((variance / exact - 1.0).abs() < 1e-3, "{variance} {exact}");

    let field = GaussianField::by_circulant_embedding(&points, 0.05, soil()).unwrap();
    let (mut z, mut sums, draws) = (vec![0.0; points.len()], [0.0; 2], 2000);
    for realisation in 0..draws {
        field.sample(&Noise::new(43), realisation, 0, &mut z).unwrap();
        let square = (z.iter().sum::<f64>() / n).powi(2);
        sums[0] += square;
        sums[1] += square * square;
    }
    let draws = draws as f64;
    let value = sums[0] / draws;
    let error = ((sums[1] / draws - value * value) / draws).sqrt();
    assert!((value - exact).abs() < 1e-3 * exact + 4.0 * error, "{value} {exact} {error}");
}
