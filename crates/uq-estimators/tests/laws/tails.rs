//! Rare events of many standard normals.

use sde_integrators::normal_probability;
use uq_estimators::{Error, Failure, ModelRuns, NormalModel, SubsetConfig, TailSampling};

/// A closure of normals, with a gradient or without.
struct Model<F, G> {
    n: usize,
    value: F,
    gradient: Option<G>,
}

impl<F, G> NormalModel for Model<F, G>
where
    F: Fn(&[f64]) -> f64 + Sync,
    G: Fn(&[f64], &mut [f64]) + Sync,
{
    fn n_normals(&self) -> usize {
        self.n
    }

    fn value(&self, z: &[f64]) -> Result<f64, Failure> {
        Ok((self.value)(z))
    }

    fn value_and_gradient(&self, z: &[f64], slopes: &mut [f64]) -> Result<Option<f64>, Failure> {
        Ok(self.gradient.as_ref().map(|gradient| {
            gradient(z, slopes);
            (self.value)(z)
        }))
    }
}

type NoGradient = fn(&[f64], &mut [f64]);

fn plain<F: Fn(&[f64]) -> f64 + Sync>(n: usize, value: F) -> Model<F, NoGradient> {
    Model { n, value, gradient: None }
}

fn weight(k: usize) -> f64 {
    1.0 / (1 + k) as f64
}

#[test]
fn a_linear_response_is_exact_at_once() {
    let value = |z: &[f64]| 2.0 + z.iter().enumerate().map(|(k, z)| weight(k) * z).sum::<f64>();
    let gradient = |_: &[f64], slopes: &mut [f64]| {
        slopes.iter_mut().enumerate().for_each(|(k, slope)| *slope = weight(k));
    };
    let model = Model { n: 300, value, gradient: Some(gradient) };
    let deviation = (0..300).map(|k| weight(k).powi(2)).sum::<f64>().sqrt();
    let tail = TailSampling { model: &model, level: 2.0 + 4.5 * deviation, seed: 1 };
    let point = tail.design_point().unwrap();
    assert!((point.reliability_index - 4.5).abs() < 1e-12 && point.steps == 1, "{point:?}");
    assert_eq!(point.runs, ModelRuns { values: 2, gradients: 2 });
    let found = tail.line_sampling(&point, 64).unwrap();
    let exact = normal_probability(-4.5);
    assert!((point.first_order_probability() / exact - 1.0).abs() < 1e-11);
    assert!((found.probability.value / exact - 1.0).abs() < 1e-11, "{found:?}");
    // One value a line, and 25 places from -12.5 to 12.5 on each of the eight that are checked.
    assert_eq!((found.runs.values, found.n_several), (64 + 8 * 25, 0));
    assert!((found.effective_lines - 64.0).abs() < 1e-6);
    // Differences find the same point.
    let without = TailSampling { model: &plain(300, value), ..tail };
    let point = without.design_point().unwrap();
    assert!((point.reliability_index - 4.5).abs() < 1e-6);
    assert_eq!(point.runs, ModelRuns { values: 2 * 301 + 2, gradients: 0 });
}

/// `z_1^2 + 0.1 z_2^2 > 16`: the event is on both sides of each line.
#[test]
fn both_sides_of_an_ellipse_count() {
    let gradient = |z: &[f64], slopes: &mut [f64]| {
        slopes.copy_from_slice(&[2.0 * z[0], 0.2 * z[1]]);
    };
    let value = |z: &[f64]| z[0] * z[0] + 0.1 * z[1] * z[1];
    let model = Model { n: 2, value, gradient: Some(gradient) };
    let tail = TailSampling { model: &model, level: 16.0, seed: 2 };
    // The gradient vanishes at the origin.
    let flat = tail.design_point();
    assert!(matches!(flat, Err(Error::NoDesignPoint { steps: 0, .. })), "{flat:?}");
    let point = tail.design_point_from(&[0.5, 0.3]).unwrap();
    assert!((point.reliability_index - 4.0).abs() < 1e-3, "{point:?}");
    // The trapezoidal rule over z_2.
    let on_line = |y: f64| {
        let beyond = 2.0 * normal_probability(-(16.0 - 0.1 * y * y).max(0.0).sqrt());
        beyond * (-0.5 * y * y).exp() / std::f64::consts::TAU.sqrt()
    };
    let exact = (-1200..=1200).map(|k| 0.01 * on_line(0.01 * f64::from(k))).sum::<f64>();
    let found = tail.line_sampling(&point, 4_000).unwrap();
    let error = found.probability.standard_error().unwrap();
    assert!((found.probability.value - exact).abs() < 4.0 * error, "{found:?} {exact}");
    assert!(error < 0.02 * exact && found.n_several > 480, "{found:?}");
}

/// Events nearer to the origin than the opposite of the crossing, farther, and behind a crossing on the same side.
#[test]
fn all_crossings_of_a_line_count() {
    let beyond = |s: f64| normal_probability(-s);
    let cases: [(&(dyn Fn(f64) -> f64 + Sync), f64); 4] = [
        (&|x| (x - 3.1).max(-x - 2.7), beyond(3.1) + beyond(2.7)),
        (&|x| (x - 3.1).max(-x - 3.6), beyond(3.1) + beyond(3.6)),
        // A band.
        (&|x| 0.4 * (x - 2.9) * (3.6 - x), beyond(2.9) - beyond(3.6)),
        // A band, and everything from farther out on.
        (&|x| (x - 2.8) * (x - 3.3) * (x - 3.9), beyond(2.8) - beyond(3.3) + beyond(3.9)),
    ];
    for (k, (of_line, exact)) in cases.into_iter().enumerate() {
        let model = plain(6, |z: &[f64]| of_line(z.iter().sum::<f64>() / 6_f64.sqrt()));
        let tail = TailSampling { model: &model, level: 0.0, seed: 7 };
        let point = tail.design_point_from(&[2.8 / 6_f64.sqrt(); 6]).unwrap();
        let found = tail.line_sampling(&point, 80).unwrap();
        let ratio = found.probability.value / exact;
        // The roots.
        assert!((ratio - 1.0).abs() < 4e-4, "{k}: {found:?} {exact}");
        assert_eq!(found.n_several, 80);
    }
    // The other side is tilted.
    let model = plain(3, |z: &[f64]| (z[0] - 2.2).max(-z[0] - 2.0 - 0.3 * z[1]));
    let tail = TailSampling { model: &model, level: 0.0, seed: 8 };
    let point = tail.design_point_from(&[2.0, 0.0, 0.0]).unwrap();
    let exact = beyond(2.2) + beyond(2.0 / 1.09_f64.sqrt());
    let found = tail.line_sampling(&point, 2000).unwrap().probability;
    let error = found.standard_error().unwrap();
    assert!((found.value - exact).abs() < 4.0 * error && error < 0.02 * exact, "{found:?}");
}

/// In 200 dimensions no direction of a sphere is important: refused, and subset simulation serves.
#[test]
fn a_sphere_in_many_dimensions_is_refused_and_subset_simulation_holds() {
    let model = plain(200, |z: &[f64]| z.iter().map(|z| z * z).sum::<f64>());
    let level = 281.0;
    // Chi-square with 200 degrees of freedom: a Poisson sum.
    let term = |before: f64, j: u32| before * 0.5 * level / f64::from(j);
    let terms = (1..100).scan(1.0, |t, j| {
        *t = term(*t, j);
        Some(*t)
    });
    let exact = (-0.5 * level).exp() * (1.0 + terms.sum::<f64>());
    let tail = TailSampling { model: &model, level, seed: 3 };
    let point = tail.design_point_from(&[0.1; 200]).unwrap();
    let found = tail.line_sampling(&point, 500);
    assert!(matches!(found, Err(Error::UnevenWeights { .. })), "{found:?}");
    let config = SubsetConfig { n_samples: 500, correlation: 0.8, n_runs: 20 };
    let found = tail.subset(&config).unwrap();
    let error = found.probability.standard_error().unwrap();
    assert!((found.probability.value - exact).abs() < 4.0 * error, "{found:?} {exact}");
    assert!(error < 0.2 * exact && found.runs.values > 30_000, "{found:?}");
}

#[test]
fn the_merit_function_tames_a_surface_on_which_plain_steps_cycle() {
    // Rackwitz-Fiessler steps without halving alternate on a strongly curved surface.
    let model = plain(2, |z: &[f64]| z[0] + 1.5 * (z[1] - 0.3).powi(2) - 0.4 * z[0] * z[1]);
    let tail = TailSampling { model: &model, level: 3.0, seed: 4 };
    let point = tail.design_point().unwrap();
    // The nearest point on a fine walk over the surface.
    let nearest = (-40_000..40_000).map(|k| f64::from(k) * 1e-4).map(|y| {
        let x = (3.0 - 1.5 * (y - 0.3).powi(2)) / (1.0 - 0.4 * y);
        x.hypot(y)
    });
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    assert!((point.reliability_index - nearest).abs() < 1e-3, "{point:?} {nearest}");
}

#[test]
fn threads_change_no_bit() {
    let model = plain(40, |z: &[f64]| z.iter().map(|z| (0.2 * z).exp()).sum::<f64>());
    let tail = TailSampling { model: &model, level: 46.0, seed: 5 };
    let run = || {
        let point = tail.design_point().unwrap();
        (tail.line_sampling(&point, 200).unwrap(), point)
    };
    let all: Vec<_> = [1, 2, 5]
        .map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(run))
        .into();
    assert!(all[0] == all[1] && all[1] == all[2], "{all:?}");
}

#[test]
fn bad_input_is_refused() {
    let linear = plain(2, |z: &[f64]| z[0]);
    let tail = TailSampling { model: &linear, level: 3.0, seed: 0 };
    let point = tail.design_point().unwrap();
    let likely = TailSampling { level: -1.0, ..tail }.design_point();
    assert!(matches!(likely, Err(Error::NotRare { level: -1.0, .. })), "{likely:?}");
    let nan = TailSampling { level: f64::NAN, ..tail };
    assert!(matches!(nan.design_point(), Err(Error::NotFinite { .. })));
    assert!(matches!(nan.line_sampling(&point, 64), Err(Error::NotFinite { .. })));
    assert!(matches!(tail.line_sampling(&point, 63), Err(Error::TooFew { limit: 64, .. })));
    assert!(matches!(tail.design_point_from(&[0.0]), Err(Error::Length { expected: 2, .. })));
    let none = plain(0, |_: &[f64]| 0.0);
    let none = TailSampling { model: &none, ..tail };
    assert!(matches!(none.design_point(), Err(Error::TooFew { .. })));
    // A level that a bounded response never reaches.
    let bounded = plain(1, |z: &[f64]| z[0].tanh());
    let bounded = TailSampling { model: &bounded, level: 2.0, seed: 0 }.design_point();
    assert!(matches!(bounded, Err(Error::NoDesignPoint { .. })), "{bounded:?}");
    let broken = plain(1, |z: &[f64]| if z[0] > 1.0 { f64::NAN } else { z[0] });
    let broken = TailSampling { model: &broken, level: 2.0, seed: 0 }.design_point();
    assert!(matches!(broken, Err(Error::NonFiniteSample { .. })), "{broken:?}");
    let few = SubsetConfig { n_samples: 10, correlation: 0.8, n_runs: 2 };
    assert!(matches!(tail.subset(&few), Err(Error::Subset(_))));
}
