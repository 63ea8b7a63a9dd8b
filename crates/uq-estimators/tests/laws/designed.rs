//! Runs of a design by number.

use uq_estimators::{Error, Failure, Sampling, Surrogate, UnitCube};

const CUBE: UnitCube = UnitCube {
    dimension: 3,
    sampling: Sampling::ScrambledSobol,
    seed: 5,
    n_points: 64,
    n_replicas: 16,
};

/// Nearly quadratic in three inputs.
fn response(x: &[f64], y: &mut [f64]) -> Result<(), Failure> {
    y[0] = surrogate(x) + 0.05 * (x[0] * x[1] * x[2]).exp();
    Ok(())
}

fn surrogate(x: &[f64]) -> f64 {
    2.0 * x[0] + x[1] - 0.5 * x[2]
}

/// Exact moments of the surrogate.
const LINEAR: Surrogate = Surrogate { mean: 1.25, variance: Some((4.0 + 1.0 + 0.25) / 12.0) };

fn values(runs: &uq_estimators::DesignedRuns) -> Vec<f64> {
    let (mut x, mut y) = ([0.0; 3], [0.0]);
    let of_run = |run| {
        runs.input(run, &mut x);
        response(&x, &mut y).map(|()| y[0])
    };
    (0..runs.n_runs()).map(of_run).collect::<Result<_, _>>().unwrap()
}

#[test]
fn a_design_of_twice_the_points_begins_with_all_runs_of_the_smaller() {
    let double = UnitCube { n_points: 128, ..CUBE };
    for (small, large) in [
        (CUBE.runs().unwrap(), double.runs().unwrap()),
        (CUBE.index_runs().unwrap(), double.index_runs().unwrap()),
    ] {
        assert_eq!(2 * small.n_runs(), large.n_runs());
        let (mut a, mut b) = ([0.0; 3], [0.0; 3]);
        for run in [0, 17, small.n_runs() - 1] {
            small.input(run, &mut a);
            large.input(run, &mut b);
            assert_eq!(a, b);
        }
    }
}

/// Eight points a replica with the surrogate, over 200 seeds: unbiased, sharper, and with errors that hold.
#[test]
fn a_surrogate_sharpens_replicas_and_their_errors_hold() {
    let small = UnitCube { n_points: 8, ..CUBE };
    let exact = UnitCube { n_points: 1 << 14, ..CUBE };
    let exact = exact.moments(1, response).unwrap()[0];
    let mut inside = [0; 2];
    let mut ratios = [0.0; 2];
    for seed in 0..200 {
        let cube = UnitCube { seed, ..small };
        let values = values(&cube.runs().unwrap());
        let (mut x, runs) = ([0.0; 3], cube.runs().unwrap());
        let rows: Vec<f64> = (0..)
            .zip(&values)
            .flat_map(|(run, y)| {
                runs.input(run, &mut x);
                [*y, surrogate(&x)]
            })
            .collect();
        let raw = cube.moments_of_runs(&values, &[]).unwrap();
        let found = cube.moments_of_runs(&rows, &[LINEAR]).unwrap();
        let pairs =
            [(found.mean, raw.mean, exact.mean), (found.variance, raw.variance, exact.variance)];
        for (k, (found, raw, exact)) in pairs.into_iter().enumerate() {
            let error = found.standard_error().unwrap();
            // 2.13 standard errors from 16 replicas are 95 %.
            inside[k] += u32::from((found.value - exact.value).abs() < 2.13 * error);
            ratios[k] += raw.standard_error().unwrap() / error / 200.0;
        }
    }
    assert!(inside.iter().all(|n| (180..=198).contains(n)), "{inside:?}");
    assert!(ratios[0] > 10.0 && ratios[1] > 10.0, "{ratios:?}");
}

#[test]
fn rows_that_are_not_those_of_all_runs_are_refused() {
    let short = CUBE.moments_of_runs(&[1.0; 100], &[]);
    assert_eq!(
        short,
        Err(Error::Length { quantity: "numbers of all runs", value: 100, expected: 1024 })
    );
    let mut rows = vec![1.0; 1024];
    rows[7] = f64::NAN;
    assert!(matches!(
        CUBE.mean_of_runs(&rows),
        Err(Error::NonFiniteSample { realisation: 7, response: 0, .. })
    ));
    let unknown = Surrogate { mean: f64::NAN, variance: None };
    assert!(matches!(CUBE.moments_of_runs(&rows, &[unknown]), Err(Error::NotFinite { .. })));
    let constant = CUBE.sobol_indices_of_runs(&vec![1.0; 5 * 1024]);
    assert!(matches!(constant, Err(Error::NoVariance { response: 0, .. })), "{constant:?}");
}
