//! A run as a function of the coefficients of a random field, as a user would write it: gradient, differences and samples.

use std::collections::BTreeMap;

use perturbation_moments::{Estimate, MonteCarlo};
use smpm::material::{LinearElasticParameters, LinearElasticSolid};
use smpm::uncertainty::{Coefficients, Design, Experiment, Study};
use smpm::{
    Body, BoundaryKind, Config, Error, Fill, Gauge, Number, Place, Plan, Quantity, Simulation,
    Window,
};

use crate::fixtures::{NO_VISCOSITY, wall};

/// A bar that runs into a wall, whose Young's modulus is lognormal: `ln E` has the modes `cos(k pi x/L)/k`.
struct Bar;

impl Experiment<1> for Bar {
    fn simulation<S: Number>(&self, coefficients: &[S]) -> Result<Simulation<S, 1>, Error> {
        let c = S::constant;
        let material = |_: usize, x: &[f64; 1]| {
            let mut exponent = c(0.0);
            for (k, &xi) in (1_i32..).zip(coefficients) {
                let mode = (f64::from(k) * std::f64::consts::PI * x[0] / 4.0).cos() / f64::from(k);
                exponent = exponent + xi * (0.1 * mode);
            }
            let young_modulus = exponent.exp() * 2.0;
            let (density, poisson_ratio) = (c(7.8), c(0.3));
            Ok(LinearElasticSolid::linear_elastic(LinearElasticParameters {
                density,
                young_modulus,
                poisson_ratio,
            })?)
        };
        let fill = Fill::of([0.05], ([0.0], [4.0]), |_| true)?;
        // The bulk viscosity acts in compression alone: a kink that derivatives do not see.
        let config = Config {
            viscosity: NO_VISCOSITY,
            boundaries: vec![wall(BoundaryKind::Symmetry)],
            ..Config::with_cell(0.1)
        };
        Simulation::new(config, vec![Body::varying(material, &fill, [-0.001])?])
    }
}

fn plan() -> Plan<1> {
    let gauge =
        |name: &str, x: f64| Gauge { name: name.to_owned(), body: 0, place: Place::Nearest([x]) };
    Plan {
        gauges: vec![gauge("middle", 2.025), gauge("end", 3.975)],
        quantities: vec![Quantity::Position(0), Quantity::Stress(0, 0)],
        windows: vec![Window::at(6.0)],
    }
}

#[test]
fn the_gradient_by_any_number_of_coefficients_is_that_of_differences() {
    let study = Study::new(&Bar, Coefficients(11), plan()).unwrap();
    let found = study.propagated().unwrap();
    assert_eq!(found.n_runs, 2);
    for response in 0..study.plan().n_responses() {
        let moments = &found.moments[response];
        let (scale, step) = (moments.variance().sqrt(), 1e-3);
        let own = moments.curvature.iter().fold(0.0_f64, |most, h| most.max(h.abs()));
        for k in 0..11 {
            let at = |s: f64| {
                let mut xi = [0.0; 11];
                xi[k] = s;
                study.run(&xi).unwrap()[response]
            };
            let (above, below) = (at(step), at(-step));
            let slope = (above - below) / (2.0 * step);
            // Truncation, step^2 of the third derivative, and roundoff of the place over the step; seen 7e-7.
            let error = (moments.gradient[k] - slope).abs();
            assert!(error < 5e-6 * scale, "{response} {k}: {error:e} of {scale:e}");
            let curvature = (above - 2.0 * moments.value + below) / (step * step);
            // Roundoff of the values over step^2: 4e-16/1e-6 of a place of 4; seen 6e-9.
            let error = (moments.curvature[k] - curvature).abs();
            assert!(error < 1e-3 * own + 2e-8, "{response} {k}: {error:e} of {own:e}");
        }
    }
    assert!(found.switches.iter().all(|switch| switch.so_far.is_infinite()));
    assert!(matches!(study.run(&[0.0; 3]), Err(Error::OtherInputs { value: 3, expected: 11 })));
}

#[test]
fn samples_of_fields_agree_with_the_taylor_series_and_are_controlled_by_it() {
    let study = Study::new(&Bar, Coefficients(5), plan()).unwrap();
    let series = study.propagated().unwrap().moments;
    let judge = MonteCarlo { seed: 3, n_samples: 200 };
    let none = BTreeMap::new();
    let design = Design::Random(judge);
    let sampled =
        study.sampled_from(design, 0..200, &none, 50, |_, _| Ok::<(), Error>(())).unwrap();
    assert_eq!((sampled.n_samples(), sampled.failures.len()), (200, 0));
    // Place of the end: nearly linear in the field.
    let (raw, controlled) = (sampled.raw(2).unwrap(), sampled.controlled(2, &series[2]).unwrap());
    let error = |estimate: &Estimate| estimate.standard_error().unwrap();
    assert!(error(&controlled.variance) < 0.3 * error(&raw.variance));
    assert!((controlled.mean.value - series[2].mean()).abs() < 5.0 * error(&controlled.mean));
    let variance = series[2].surrogate_variance();
    assert!((controlled.variance.value / variance - 1.0).abs() < 0.05);
    // Half of the samples in another run, known to this one: bitwise identical.
    let half = study.sampled_from(design, 100..200, &none, 7, |_, _| Ok::<(), Error>(()));
    let known = half.unwrap().responses();
    let again = study.sampled_from(design, 0..200, &known, 30, |_, _| Ok::<(), Error>(()));
    assert_eq!(again.unwrap(), sampled);
}
