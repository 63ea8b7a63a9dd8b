//! Disorder fields: what was asked for is what is drawn.

use peridyn_sde::DisorderField;
use random_fields::{Correlation, CorrelationFunction, GaussianField, Marginal};
use sde_integrators::{Accumulator, Noise, Samples};

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

const LAWS: [Marginal; 3] = [
    Marginal::Lognormal { mean: 2e-3, coefficient_of_variation: 0.4 },
    Marginal::Weibull { mean: 2e-3, shape: 3.0 },
    Marginal::Normal { mean: 2e-3, standard_deviation: 2e-4 },
];

#[test]
fn values_have_the_mean_deviation_and_quantiles_of_their_law() {
    let positions = lattice([3, 2], 1.0);
    let correlation = Correlation { function: CorrelationFunction::Gaussian, length: 1.0 };
    for law in LAWS {
        for gaussian in both(&positions, 1.0, correlation) {
            let field = DisorderField::new(gaussian, law, 0).unwrap();
            let (mut mean, mut square, mut values) =
                (Accumulator::default(), Accumulator::default(), vec![]);
            let mut out = [0.0; 6];
            for realisation in 0..10_000 {
                field.sample(&Noise::new(31), realisation, &mut out).unwrap();
                mean.push(out[4]);
                square.push((out[4] - law.mean()).powi(2));
                values.push(out[4]);
            }
            let within = |estimate: sde_integrators::Estimate, expected: f64, what: &str| {
                let error = estimate.standard_error().unwrap();
                let distance = (estimate.value - expected).abs();
                assert!(error < 0.1 * expected, "{law:?}, {what}: {error:e} says nothing");
                assert!(distance < 4.0 * error, "{law:?}, {what}: {estimate:?}, not {expected}");
            };
            within(mean.estimate().unwrap(), law.mean(), "mean");
            within(square.estimate().unwrap(), law.standard_deviation().powi(2), "variance");
            let samples = Samples::new(values).unwrap();
            // The deciles lie at -1.2815515655 and 1.2815515655 (Abramowitz and Stegun, table 26.5).
            for (z, p) in [(-1.2815515655, 0.1), (0.0, 0.5), (1.2815515655, 0.9)] {
                within(samples.quantile(p).unwrap(), law.at(z), "quantile");
            }
        }
    }
}

#[test]
fn values_at_two_nodes_have_the_distorted_correlation() {
    let positions = lattice([3, 2], 1.0);
    let correlation = Correlation { function: CorrelationFunction::Exponential, length: 2.0 };
    let laws = [
        Marginal::Lognormal { mean: 1.0, coefficient_of_variation: 1.0 },
        Marginal::Weibull { mean: 1.0, shape: 1.0 },
    ];
    for law in laws {
        for gaussian in both(&positions, 1.0, correlation) {
            let field = DisorderField::new(gaussian, law, 5).unwrap();
            let mut product = Accumulator::default();
            let mut out = [0.0; 6];
            for realisation in 0..10_000 {
                field.sample(&Noise::new(37), realisation, &mut out).unwrap();
                product.push((out[0] - 1.0) * (out[2] - 1.0));
            }
            let found = product.estimate().unwrap();
            let expected = law.translated_correlation(f64::exp(-1.0)).unwrap();
            let error = found.standard_error().unwrap();
            assert!((found.value - expected).abs() < 4.0 * error, "{law:?}: {found:?} {expected}");
        }
    }
}
