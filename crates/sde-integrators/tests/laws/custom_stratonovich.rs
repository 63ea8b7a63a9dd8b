//! A system in the sense of Stratonovich as a user writes it: a unit vector that noise turns.

use sde_integrators::{
    EulerMaruyama, Heun, Increment, Integrator, ItoForm, Noise, Sde, StratonovichSde,
};

/// `dX = (-X_2, X_1) o dB`: `X` turns by the angle `B` and keeps its length.
struct Turning;

impl StratonovichSde<2, 1> for Turning {
    fn drift(&self, _t: f64, _x: &[f64; 2]) -> [f64; 2] {
        [0.0; 2]
    }

    fn noise(&self, _t: f64, x: &[f64; 2]) -> [[f64; 1]; 2] {
        [[-x[1]], [x[0]]]
    }
}

/// In the sense of Ito the drift is `-X/2`; tolerance of the differences: eps^(2/3).
#[test]
fn the_ito_form_has_the_correction_of_the_book() {
    for x in [[1.0, 0.0], [-0.6, 2.5]] {
        let drift = ItoForm(Turning).drift(0.0, &x);
        assert!((drift[0] + 0.5 * x[0]).abs() < 1e-10 && (drift[1] + 0.5 * x[1]).abs() < 1e-10);
        assert_eq!(ItoForm(Turning).noise(0.0, &x).concat(), [-x[1], x[0]]);
    }
}

/// Root mean square distance to `(cos B, sin B)` at time 1 over 400 paths of `n` steps.
fn distance(n: usize, step: impl Fn(f64, &Increment<1>, &mut [f64; 2])) -> f64 {
    let dt = 1.0 / n as f64;
    let mut sum = 0.0;
    for realisation in 0..400 {
        let mut path = Noise::new(5).path::<1>(realisation);
        let (mut x, mut angle) = ([1.0, 0.0], 0.0_f64);
        for _ in 0..n {
            let dw = path.next_increment(dt);
            angle += dw.brownian[0];
            step(dt, &dw, &mut x);
        }
        sum += (x[0] - angle.cos()).powi(2) + (x[1] - angle.sin()).powi(2);
    }
    (sum / 400.0).sqrt()
}

/// Heun solves the equation itself with order 1, Euler-Maruyama its Ito form with order 1/2. With 400 paths a mean
/// square is known to about 10 %, an order over a factor of 16 in steps to 0.03: tolerance 0.15.
#[test]
fn heun_solves_it_and_euler_solves_its_ito_form() {
    let heun = |n| distance(n, |dt, dw, x| Heun.step(&Turning, 0.0, dt, dw, x, &mut ()).unwrap());
    let euler = |n| {
        distance(n, |dt, dw, x| {
            EulerMaruyama.step(&ItoForm(Turning), 0.0, dt, dw, x, &mut ()).unwrap();
        })
    };
    let order = |error: &dyn Fn(usize) -> f64| (error(32) / error(512)).log2() / 4.0;
    assert!((order(&heun) - 1.0).abs() < 0.15, "{}", order(&heun));
    assert!((order(&euler) - 0.5).abs() < 0.15, "{}", order(&euler));
}
