//! A system with diagonal noise as a user writes it, and a method for it.

use sde_integrators::{
    DiagonalNoise, DiagonalSde, EnsembleConfig, EulerMaruyama, Heun, Increment, Integrator,
    Milstein, Observable, Sriw1, StepError, StratonovichForm, check_diagonal_noise,
    check_diffusion_divergence, simulate,
};

/// `dX = -X dt + sqrt(1 + X^2) dB`, per state.
struct Spread;

impl DiagonalSde<2> for Spread {
    fn drift(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        [-x[0], -2.0 * x[1]]
    }

    fn intensity(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        x.map(|x| x.hypot(1.0))
    }

    fn intensity_derivative(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        x.map(|x| x / x.hypot(1.0))
    }
}

/// The derivative is forgotten in the second state.
struct Wrong;

impl DiagonalSde<2> for Wrong {
    fn drift(&self, t: f64, x: &[f64; 2]) -> [f64; 2] {
        Spread.drift(t, x)
    }

    fn intensity(&self, t: f64, x: &[f64; 2]) -> [f64; 2] {
        Spread.intensity(t, x)
    }

    fn intensity_derivative(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        [x[0] / x[0].hypot(1.0), 0.0]
    }
}

/// Milstein's method without its derivative: `b'` by a difference along the noise (Kloeden and Platen 1992, eq 11.1.3).
struct DerivativeFree;

impl<S: DiagonalSde<2>> Integrator<S, 2, 2> for DerivativeFree {
    type Memory = ();

    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<2>,
        x: &mut [f64; 2],
        (): &mut (),
    ) -> Result<(), StepError> {
        let (f, b) = (system.drift(t, x), system.intensity(t, x));
        let support = std::array::from_fn(|i| x[i] + b[i] * dt.sqrt());
        let ahead = system.intensity(t, &support);
        for i in 0..2 {
            let w = dw.brownian[i];
            x[i] += dt * f[i] + b[i] * w + 0.5 * (ahead[i] - b[i]) * (w * w - dt) / dt.sqrt();
        }
        Ok(())
    }
}

/// Central differences: roundoff eps^(2/3), times the slope.
#[test]
fn a_wrong_derivative_is_found() {
    let states = [[0.3, -1.2], [2.0, 0.7]];
    assert!(check_diagonal_noise(&Spread, 0.0, &states) < 1e-9);
    assert!(check_diagonal_noise(&Wrong, 0.0, &states) > 0.5);
    assert!(check_diffusion_divergence(&DiagonalNoise(Spread), 0.0, &states) < 1e-9);
}

/// For this `b`, `b'` by a difference errs by `O(sqrt(h))`: one step of the two methods differs by `O(h^1.5)`.
#[test]
fn a_method_of_ones_own_stands_beside_milstein() {
    let difference = |dt: f64| {
        let dw =
            Increment { brownian: [0.7 * dt.sqrt(), -0.4 * dt.sqrt()], space_time_area: [0.0; 2] };
        let (mut a, mut b) = ([0.3, -1.2], [0.3, -1.2]);
        Milstein.step(&Spread, 0.0, dt, &dw, &mut a, &mut ()).unwrap();
        DerivativeFree.step(&Spread, 0.0, dt, &dw, &mut b, &mut ()).unwrap();
        (a[0] - b[0]).abs()
    };
    let order = (difference(1e-3) / difference(1e-5)).log10() / 2.0;
    assert!((order - 1.5).abs() < 0.05, "{order}");
}

/// `E X_1^2` obeys `m' = -2 m + (1 + m)`, so that `m = 1 - exp(-t)` from 0; `E X_2^2` obeys `m' = -4 m + 1 + m`, so that
/// `m = (1 - exp(-3 t))/3`. Weak error of Euler-Maruyama and Milstein at h = 1/128 below 0.01; |z| < 4 besides.
#[test]
fn ensembles_take_every_method_for_diagonal_noise() {
    let config = EnsembleConfig { seed: 8, n_paths: 20_000, dt: 1.0 / 128.0, times: vec![1.0] };
    let observables = [
        Observable::Mean(&|_t, x: &[f64; 2]| x[0] * x[0]),
        Observable::Mean(&|_t, x: &[f64; 2]| x[1] * x[1]),
    ];
    let system = DiagonalNoise(Spread);
    let start = [0.0; 2];
    let runs = [
        simulate(&system, &EulerMaruyama, &start, &config, &observables).unwrap(),
        simulate(&system, &Milstein, &start, &config, &observables).unwrap(),
        simulate(&system, &Sriw1, &start, &config, &observables).unwrap(),
        simulate(&system, &DerivativeFree, &start, &config, &observables).unwrap(),
        simulate(&StratonovichForm(Spread), &Heun, &start, &config, &observables).unwrap(),
    ];
    let exact = [1.0 - (-1.0_f64).exp(), (1.0 - (-3.0_f64).exp()) / 3.0];
    for run in &runs {
        for (estimate, exact) in run.estimates[0].iter().zip(exact) {
            let standard_error = estimate.standard_error().unwrap();
            assert!(standard_error < 0.02, "{estimate}");
            assert!((estimate.value - exact).abs() < 0.01 + 4.0 * standard_error, "{estimate}");
        }
    }
}
