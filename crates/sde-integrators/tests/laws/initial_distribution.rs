//! Initial distributions: density, moments, samples, refusals.

use sde_integrators::{
    Error, GaussianComponent, GaussianMixture, InitialDistribution, Noise, Purpose,
};

fn two_humps() -> GaussianMixture<2> {
    GaussianMixture::mixture(&[
        GaussianComponent { weight: 0.3, mean: [-1.0, 0.5], covariance: [[0.4, 0.1], [0.1, 0.2]] },
        GaussianComponent {
            weight: 0.7,
            mean: [1.5, -0.5],
            covariance: [[0.3, -0.2], [-0.2, 0.5]],
        },
    ])
    .expect("a law")
}

/// The trapezoidal rule on a Gaussian over +-8 deviations errs below 1e-12 at this spacing.
#[test]
fn the_density_integrates_to_one_and_has_the_stated_moments() {
    let law = two_humps();
    let spacing = 0.1;
    let (mut mass, mut first, mut second) = (0.0, [0.0; 2], [[0.0; 2]; 2]);
    for i in -70..=70 {
        for j in -70..=70 {
            let x = [spacing * f64::from(i), spacing * f64::from(j)];
            let share = law.density(&x) * spacing * spacing;
            mass += share;
            for a in 0..2 {
                first[a] += share * x[a];
                for b in 0..2 {
                    second[a][b] += share * x[a] * x[b];
                }
            }
        }
    }
    assert!((mass - 1.0).abs() < 1e-11, "{mass}");
    for a in 0..2 {
        assert!((first[a] - law.mean()[a]).abs() < 1e-11);
        for b in 0..2 {
            let covariance = second[a][b] - first[a] * first[b];
            assert!((covariance - law.covariance()[a][b]).abs() < 1e-10);
        }
    }
}

#[test]
fn the_density_of_correlated_normals_is_the_closed_form() {
    let (s_1, s_2, rho) = (0.7_f64, 1.3_f64, -0.6_f64);
    let cross = rho * s_1 * s_2;
    let law =
        GaussianMixture::gaussian([0.2, -0.1], [[s_1 * s_1, cross], [cross, s_2 * s_2]]).unwrap();
    for x in [[0.2, -0.1], [1.0, 0.4], [-2.0, 3.0]] {
        let (u, v) = ((x[0] - 0.2) / s_1, (x[1] + 0.1) / s_2);
        let exponent = (u * u - 2.0 * rho * u * v + v * v) / (2.0 * (1.0 - rho * rho));
        let scale = std::f64::consts::TAU * s_1 * s_2 * (1.0 - rho * rho).sqrt();
        assert!((law.log_density(&x) - (-exponent - scale.ln())).abs() < 1e-13);
        assert!((law.density(&x) * scale * exponent.exp() - 1.0).abs() < 1e-13);
    }
}

#[test]
fn the_logarithm_of_the_density_survives_where_the_density_does_not() {
    let law = two_humps();
    let far = law.log_density(&[100.0, 0.0]);
    assert!(law.density(&[100.0, 0.0]) <= 0.0 && far.is_finite() && far < -1e4);
    assert!(law.density(&[f64::NAN, 0.0]).is_nan());
}

/// |z| < 4, with the variances estimated from the fourth moments of the sample.
#[test]
fn samples_have_the_moments_of_their_law() {
    let (law, noise, n) = (two_humps(), Noise::new(17), 100_000);
    let (mean, covariance) = (law.mean(), law.covariance());
    for (a, b) in [(0, 0), (0, 1), (1, 1)] {
        let mut products = sde_integrators::Accumulator::default();
        let mut values = sde_integrators::Accumulator::default();
        for realisation in 0..n {
            let x = law.sample(&noise, realisation);
            values.push(x[a]);
            products.push((x[a] - mean[a]) * (x[b] - mean[b]));
        }
        for (estimate, expected) in [
            (values.estimate().unwrap(), mean[a]),
            (products.estimate().unwrap(), covariance[a][b]),
        ] {
            let z = (estimate.value - expected) / estimate.standard_error().unwrap();
            assert!(z.abs() < 4.0, "({a}, {b}): z = {z}");
        }
    }
}

/// Whichever component is chosen, the normals come from the same words.
#[test]
fn a_sample_takes_its_words_from_the_stream_of_the_initial_law() {
    let noise = Noise::new(4);
    let law = GaussianMixture::independent([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]).unwrap();
    let x = law.sample(&noise, 8);
    let mut stream = noise.stream(Purpose::InitialDistribution, 8);
    stream.seek(2);
    let mut z = [0.0; 3];
    stream.fill_normal(&mut z);
    for i in 0..3 {
        let unit = 0.1 * (i as f64 + 1.0);
        assert!((x[i] - (i as f64 + 1.0) - unit * z[i]).abs() < 1e-15);
    }
    let point = InitialDistribution::sample(&[7.0, 8.0], &noise, 3);
    assert_eq!(point.map(f64::to_bits), [7.0_f64, 8.0].map(f64::to_bits));
}

#[test]
fn a_law_that_is_none_is_refused_with_the_value_and_its_limit() {
    let component = |weight, variance| GaussianComponent {
        weight,
        mean: [0.0, 0.0],
        covariance: [[1.0, 0.0], [0.0, variance]],
    };
    let message = |components: &[GaussianComponent<2>]| {
        GaussianMixture::mixture(components).unwrap_err().to_string()
    };
    assert_eq!(message(&[]), "0 components of a mixture, at least 1 needed");
    assert_eq!(
        message(&[component(0.5, 1.0), component(0.4, 1.0)]),
        "weights of the components sum to 0.9, must be 1 within 1e-12"
    );
    assert_eq!(
        message(&[component(-0.5, 1.0)]),
        "weight of a component is -0.5, must be finite and positive"
    );
    assert_eq!(
        message(&[component(0.5, 1.0), component(0.5, f64::INFINITY)]),
        "covariance of component 1 is inf, must be finite"
    );
    assert_eq!(
        message(&[component(0.5, 1.0), component(0.5, -2.0)]),
        "covariance of component 1 is not positive definite: pivot -2e0 in row 1, must exceed 8.881784197001252e-16"
    );
    let skew = GaussianMixture::gaussian([0.0, 0.0], [[1.0, 0.1], [0.2, 1.0]]).unwrap_err();
    assert!(matches!(skew, Error::NotSymmetric { component: 0, row: 1, column: 0, .. }), "{skew}");
    let singular = GaussianMixture::gaussian([0.0, 0.0], [[1.0, 1.0], [1.0, 1.0]]).unwrap_err();
    assert!(matches!(singular, Error::NotPositiveDefinite { row: 1, .. }), "{singular}");
    let nan = GaussianMixture::gaussian([0.0, f64::NAN], [[1.0, 0.0], [0.0, 1.0]]).unwrap_err();
    assert!(
        matches!(nan, Error::NotFinite { quantity: "mean of component", index: 0, .. }),
        "{nan}"
    );
    let flat = GaussianMixture::independent([0.0], [0.0]).unwrap_err();
    assert_eq!(flat.to_string(), "standard deviation is 0, must be finite and positive");
}
