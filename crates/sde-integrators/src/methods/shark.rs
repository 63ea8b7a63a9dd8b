//! ShARK: two drift evaluations, strong order 1.5 for additive noise.

use crate::error::StepError;
use crate::integrator::{Integrator, apply};
use crate::noise::streams::Increment;
use crate::system::{Additive, Sde};

/// ShARK, the shifted additive-noise Runge-Kutta method: the default for additive noise.
///
/// $$ Z = X_n + g H, \quad k_1 = f(t_n, Z), \quad
///    k_2 = f\left(t_n + \tfrac56 h, Z + \tfrac56 (h k_1 + g w)\right), $$
/// $$ X_{n+1} = X_n + h \left(\tfrac25 k_1 + \tfrac35 k_2\right) + g w +
///    (g(t_{n+1}) - g(t_n)) \left(\tfrac12 w - H\right) $$
///
/// with `g = g(t_n)`. The source gives the method for constant noise; the last term extends it: the integral of a `g`
/// that is linear over the step. Solves `dX = f(t, X) dt + g(t) dB`; Ito and Stratonovich agree. Symbols: `h` = `dt`,
/// `w` = `dw.brownian`, `H` = `dw.space_time_area`.
///
/// Order (additive noise): strong 1.5, weak 2; 2 without noise.
///
/// Stable for: as Heun without noise, `|1 + z + z^2/2| < 1` with `z = h l`; for a lightly damped oscillator `h omega`
/// up to about `(8 xi)^(1/3)`.
///
/// Source: Foster, dos Reis and Strange 2024, High order splitting methods for SDEs satisfying a commutativity
/// condition, eq 6.1.
///
/// State-dependent noise does not compile:
///
/// ```compile_fail
/// use sde_integrators::{General, Increment, Integrator, Sde, Shark};
///
/// struct Growth;
///
/// impl Sde<1, 1> for Growth {
///     type Noise = General;
///     fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] { [0.1 * x[0]] }
///     fn noise(&self, _t: f64, x: &[f64; 1]) -> [[f64; 1]; 1] { [[0.5 * x[0]]] }
/// }
///
/// Shark.step(&Growth, 0.0, 0.1, &Increment::ZERO, &mut [1.0], &mut ());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Shark;

/// Time of the second stage, `5/6`.
const NODE: f64 = 5.0 / 6.0;
/// The weights of the two stages: `b_1 + b_2 = 1` and `b_2 c_2 = 1/2`.
const WEIGHTS: [f64; 2] = [0.4, 0.6];

impl<S, const D: usize, const M: usize> Integrator<S, D, M> for Shark
where
    S: Sde<D, M, Noise = Additive> + ?Sized,
{
    type Memory = ();

    #[inline]
    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<M>,
        x: &mut [f64; D],
        _memory: &mut (),
    ) -> Result<(), StepError> {
        let g = system.noise(t, x);
        let (kick, area) = (apply(&g, &dw.brownian), apply(&g, &dw.space_time_area));
        let mut stage: [f64; D] = std::array::from_fn(|i| x[i] + area[i]);
        let k_1 = system.drift(t, &stage);
        for i in 0..D {
            stage[i] += NODE * (dt * k_1[i] + kick[i]);
        }
        let k_2 = system.drift(t + NODE * dt, &stage);
        let late: [f64; M] = std::array::from_fn(|m| 0.5 * dw.brownian[m] - dw.space_time_area[m]);
        let (late_now, late_ahead) = (apply(&g, &late), apply(&system.noise(t + dt, x), &late));
        for i in 0..D {
            let drift = WEIGHTS[0] * k_1[i] + WEIGHTS[1] * k_2[i];
            x[i] += dt * drift + kick[i] + (late_ahead[i] - late_now[i]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The conditions of a two-stage method of order 2.
    #[test]
    fn the_weights_satisfy_the_conditions_of_order_two() {
        assert!((WEIGHTS[0] + WEIGHTS[1] - 1.0).abs() < 1e-15);
        assert!((WEIGHTS[1] * NODE - 0.5).abs() < 1e-15);
    }
}
