//! A system as a user writes it, with noise that depends on the state.

use sde_integrators::{
    EnsembleConfig, EulerMaruyama, General, Increment, Integrator, Observable, Sde,
    check_diffusion_divergence, simulate,
};

/// Geometric Brownian motion, `dX = mu X dt + sigma X dB`.
struct GeometricBrownianMotion {
    mu: f64,
    sigma: f64,
}

impl Sde<1, 1> for GeometricBrownianMotion {
    type Noise = General;

    fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] {
        [self.mu * x[0]]
    }

    fn noise(&self, _t: f64, x: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.sigma * x[0]]]
    }
}

/// The same with its divergence in closed form, right or off by a factor.
struct WithDivergence(GeometricBrownianMotion, f64);

impl Sde<1, 1> for WithDivergence {
    type Noise = General;

    fn drift(&self, t: f64, x: &[f64; 1]) -> [f64; 1] {
        self.0.drift(t, x)
    }

    fn noise(&self, t: f64, x: &[f64; 1]) -> [[f64; 1]; 1] {
        self.0.noise(t, x)
    }

    fn diffusion_divergence(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] {
        [self.1 * self.0.sigma * self.0.sigma * x[0]]
    }
}

const SYSTEM: GeometricBrownianMotion = GeometricBrownianMotion { mu: 0.3, sigma: 0.5 };

/// `D = sigma^2 x^2/2`, so `div D = sigma^2 x`. Central differences are exact for a square but for roundoff, `eps^(2/3)`.
#[test]
fn the_divergence_by_differences_is_the_closed_form() {
    for x in [-3.0, 0.1, 2.0, 40.0] {
        assert!((SYSTEM.diffusion(0.0, &[x])[0][0] - 0.125 * x * x).abs() < 1e-13 * x * x);
        let divergence = SYSTEM.diffusion_divergence(0.0, &[x])[0];
        assert!((divergence - 0.25 * x).abs() < 1e-9 * x.abs().max(1.0), "{divergence} at {x}");
    }
    let states = [[-3.0], [0.1], [2.0]];
    assert!(check_diffusion_divergence(&WithDivergence(SYSTEM, 1.0), 0.0, &states) < 1e-9);
    assert!(check_diffusion_divergence(&WithDivergence(SYSTEM, 1.01), 0.0, &states) > 1e-3);
}

/// One step of Euler-Maruyama multiplies by `1 + mu h + sigma w`, so `E X = (1 + mu h)^n` to the digit; |z| < 4.
#[test]
fn an_ensemble_has_the_mean_of_the_method() {
    let config = EnsembleConfig { seed: 6, n_paths: 100_000, dt: 0.25, times: vec![1.0] };
    let observables = [Observable::Mean(&|_t, x: &[f64; 1]| x[0])];
    let ensemble = simulate(&SYSTEM, &EulerMaruyama, &[1.0], &config, &observables).unwrap();
    let estimate = ensemble.estimates[0][0];
    let z = (estimate.value - 1.075_f64.powi(4)) / estimate.standard_error().unwrap();
    assert!(z.abs() < 4.0, "{estimate}");
}

/// The factor by which one step multiplies the state.
fn factor(h: f64, w: f64) -> f64 {
    let mut x = [1.0];
    let dw = Increment { brownian: [w], space_time_area: [0.0] };
    EulerMaruyama.step(&SYSTEM, 0.0, h, &dw, &mut x, &mut ()).expect("a step");
    x[0]
}

/// `sqrt(E (X_h - X_{h/2})^2)` at time 1. The factors are quadratic at most in each half increment, so that two points
/// `+-sqrt(h/2)` for each give the expectations exactly.
fn strong_difference(n_steps: i32) -> f64 {
    let h = 1.0 / f64::from(n_steps);
    let point = (0.5 * h).sqrt();
    let (mut coarse, mut cross, mut fine) = (0.0, 0.0, 0.0);
    for (w_1, w_2) in [(point, point), (point, -point), (-point, point), (-point, -point)] {
        let whole = factor(h, w_1 + w_2);
        let halves = factor(0.5 * h, w_1) * factor(0.5 * h, w_2);
        coarse += 0.25 * whole * whole;
        cross += 0.25 * whole * halves;
        fine += 0.25 * halves * halves;
    }
    (coarse.powi(n_steps) - 2.0 * cross.powi(n_steps) + fine.powi(n_steps)).sqrt()
}

/// Deterministic; tolerance 0.02 for the next term of the error.
#[test]
fn euler_maruyama_has_strong_order_one_half_and_weak_order_one_for_general_noise() {
    let levels = [64, 128, 256, 512, 1024];
    for pair in levels.windows(2) {
        let strong = (strong_difference(pair[0]) / strong_difference(pair[1])).log2();
        assert!((strong - 0.5).abs() < 0.02, "strong {strong}");
        let weak = |n: i32| 0.3_f64.exp() - factor(1.0 / f64::from(n), 0.0).powi(n);
        let order = (weak(pair[0]) / weak(pair[1])).log2();
        assert!((order - 1.0).abs() < 0.02, "weak {order}");
    }
}
