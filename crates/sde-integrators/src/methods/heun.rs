//! Heun's method, for Stratonovich equations.

use crate::error::StepError;
use crate::integrator::{Integrator, apply};
use crate::noise::streams::Increment;
use crate::stratonovich::StratonovichSde;

/// Heun's method: an Euler predictor, then drift and noise averaged over both ends.
///
/// $$ \bar X = X_n + h f(t_n, X_n) + g(t_n, X_n) w, $$
/// $$ X_{n+1} = X_n + \frac h2 \left(f(t_n, X_n) + f(t_{n+1}, \bar X)\right) +
///    \frac12 \left(g(t_n, X_n) + g(t_{n+1}, \bar X)\right) w $$
///
/// Solves the Stratonovich equation `dX = f dt + g o dB`. Symbols: `h` = `dt`, `w` = `dw.brownian`.
///
/// Order: strong 1 and weak 1 for additive, diagonal and other commuting noise, strong 1/2 for general noise; 2
/// without noise.
///
/// Stable for: in the mean square of `dX = l X dt + m X dB` (Ito) where `E (1 + z + z^2/2)^2 < 1` with
/// `z = (l - m^2/2) h + m w`: less than Milstein for weak noise, more than Euler-Maruyama for strong noise. For a
/// lightly damped oscillator the limit is about `(8 xi)^(1/3)`: 0.445, 0.80, 1.40 for `xi` = 0.01, 0.05, 0.2.
///
/// Source: Rümelin 1982, Numerical treatment of stochastic differential equations; Kloeden and Platen 1992, section
/// 15.5.
///
/// An Ito equation with state-dependent noise does not compile:
///
/// ```compile_fail
/// use sde_integrators::{General, Heun, Increment, Integrator, Sde};
///
/// struct Growth;
///
/// impl Sde<1, 1> for Growth {
///     type Noise = General;
///     fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] { [0.1 * x[0]] }
///     fn noise(&self, _t: f64, x: &[f64; 1]) -> [[f64; 1]; 1] { [[0.5 * x[0]]] }
/// }
///
/// Heun.step(&Growth, 0.0, 0.1, &Increment::ZERO, &mut [1.0], &mut ());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Heun;

impl<S, const D: usize, const M: usize> Integrator<S, D, M> for Heun
where
    S: StratonovichSde<D, M> + ?Sized,
{
    type Memory = ();
    const USES_AREA: bool = false;

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
        let drift = system.drift(t, x);
        let kick = apply(&system.noise(t, x), &dw.brownian);
        let predicted = std::array::from_fn(|i| x[i] + dt * drift[i] + kick[i]);
        let drift_ahead = system.drift(t + dt, &predicted);
        let kick_ahead = apply(&system.noise(t + dt, &predicted), &dw.brownian);
        for i in 0..D {
            x[i] += 0.5 * (dt * (drift[i] + drift_ahead[i]) + kick[i] + kick_ahead[i]);
        }
        Ok(())
    }
}
