//! What half the step changes.

use sde_integrators::{
    Additive, EnsembleConfig, EulerMaruyama, Observable, Sde, SimdLevel, StepDifference, Study,
};

/// `dX = -X dt + dB` by forward Euler: the mean square of the steps of length `h` from 0 has the closed form `h sum (1 - h)^(2k)`.
#[test]
fn pairs_of_paths_measure_the_bias_of_the_steps() {
    struct Decay;
    impl Sde<1, 1> for Decay {
        type Noise = Additive;
        fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
            [-x[0]]
        }
        fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
            [[1.0]]
        }
    }
    let square = |_: f64, x: &[f64; 1]| x[0] * x[0];
    let config = EnsembleConfig { seed: 3, n_paths: 100, dt: 0.25, times: vec![1.0, 2.0] };
    let study = Study {
        name: "",
        system: &Decay,
        integrator: &EulerMaruyama,
        law: &[0.0],
        config: &config,
        observables: &[Observable::Mean(&square)],
        level: SimdLevel::best(),
    };
    let found = study.step_differences::<1>(20_000, 1.0).unwrap();
    let of = |h: f64, t: f64| {
        let q = (1.0 - h).powi(2);
        h * (1.0 - q.powf(t / h)) / (1.0 - q)
    };
    // The noise as a factor, of a linear system.
    let amplified = study.step_differences::<1>(20_000, 3.0).unwrap()[0][0].difference.value;
    assert!((amplified / found[0][0].difference.value - 9.0).abs() < 1e-9, "{amplified}");
    for (row, t) in found.iter().zip([1.0, 2.0]) {
        let StepDifference { difference, value } = row[0];
        let error = difference.standard_error().unwrap();
        let exact = of(0.125, t) - of(0.25, t);
        assert!((difference.value - exact).abs() < 4.0 * error, "{difference:?}, {exact}");
        assert!(error < 0.1 * exact.abs());
        let error = value.standard_error().unwrap();
        assert!((value.value - of(0.125, t)).abs() < 4.0 * error);
    }
}
