//! A linear operator without a matrix, as a user writes it: three masses on a line.

use sde_integrators::{
    Additive, DiagonalFactor, FieldPath, FieldSde, Integrator, LinearOperator, LinearTheta, Noise,
    Sde, StochasticTheta,
};

/// `40 (x_{i-1} - 2 x_i + x_{i+1})` with cold ends.
struct SecondDifference;

impl LinearOperator for SecondDifference {
    fn n_unknowns(&self) -> usize {
        3
    }

    fn apply(&self, x: &[f64], result: &mut [f64]) {
        for (i, value) in result.iter_mut().enumerate() {
            let left = if i > 0 { x[i - 1] } else { 0.0 };
            let right = x.get(i + 1).copied().unwrap_or(0.0);
            *value = 40.0 * (left - 2.0 * x[i] + right);
        }
    }
}

/// The noisy heat equation, as a field and as a small state.
struct Heat(DiagonalFactor);

impl FieldSde for Heat {
    type Factor = DiagonalFactor;

    fn drift(&self, _: f64, x: &[f64], drift: &mut [f64]) {
        SecondDifference.apply(x, drift);
    }

    fn factor(&self) -> &DiagonalFactor {
        &self.0
    }
}

impl Sde<3, 3> for Heat {
    type Noise = Additive;

    fn drift(&self, _: f64, x: &[f64; 3]) -> [f64; 3] {
        let mut drift = [0.0; 3];
        SecondDifference.apply(x, &mut drift);
        drift
    }

    fn noise(&self, _: f64, _: &[f64; 3]) -> [[f64; 3]; 3] {
        [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]]
    }
}

/// Newton's method leaves roundoff and conjugate gradients 1e-10 of a step: 1e-8 after 50 steps.
#[test]
fn a_field_with_an_operator_is_the_theta_method_of_a_small_state() {
    let heat = Heat(DiagonalFactor::new(vec![0.5; 3]).unwrap());
    let (noise, dt, start) = (Noise::new(10), 0.1, [0.4, -0.2, 0.1]);
    for theta in [0.5, 1.0] {
        let field = LinearTheta::new(theta, SecondDifference).unwrap();
        let small = StochasticTheta::new(theta).unwrap();
        let mut path = FieldPath::new(&heat, &field, &noise, 4, start.to_vec()).unwrap();
        let (mut increments, mut x) = (noise.path::<3>(4), start);
        for _ in 0..50 {
            let dw = increments.next_increment(dt);
            small.step(&heat, path.time(), dt, &dw, &mut x, &mut ()).unwrap();
            path.step(dt).unwrap();
        }
        for (a, b) in path.state().iter().zip(x) {
            assert!((a - b).abs() < 1e-8 && b.abs() > 1e-4, "theta {theta}: {a} and {b}");
        }
    }
}
