//! Tamed Euler method: the drift increment of a step is bounded.

use crate::error::StepError;
use crate::field::{FieldIncrement, FieldIntegrator, FieldSde, Workspace};
use crate::integrator::{Integrator, apply};
use crate::noise::Increment;
use crate::system::Sde;

/// Tamed Euler method, for a drift that grows superlinearly.
///
/// $$ X_{n+1} = X_n + \frac{h f(t_n, X_n)}{1 + h |f(t_n, X_n)|} + g(t_n, X_n) w $$
///
/// Solves the Ito equation `dX = f dt + g dB`, for any noise. Symbols: `h` = `dt`, `w` = `dw.brownian`, `|f|` the
/// Euclidean norm. The drift changes a state by less than one unit per step, so the units of the state matter.
///
/// Order: strong 1/2 for general noise, 1 for additive noise; weak 1. The constant is large: the stationary `E[x^2]`
/// of `dX = -X^3 dt + sqrt(2) dB` is too large by 18.8 %, 8.3 %, 3.9 % at `h` = 0.1, 0.05, 0.025; the error of
/// Euler-Maruyama is 1.6 %, 0.72 %, 0.35 %. Use it to avoid explosion, not for statistics.
///
/// Stable for: the moments are bounded at every `h` for a one-sided Lipschitz drift of polynomial growth.
///
/// Source: Hutzenthaler, Jentzen and Kloeden 2012, Strong convergence of an explicit numerical method for SDEs with
/// nonglobally Lipschitz continuous coefficients, eq 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TamedEuler;

/// `h/(1 + h |f|)`. A norm that overflows gives a step of zero.
#[inline]
fn tamed_step(dt: f64, drift: &[f64]) -> f64 {
    let norm = drift.iter().map(|f| f * f).sum::<f64>().sqrt();
    dt / (1.0 + dt * norm)
}

impl<S, const D: usize, const M: usize> Integrator<S, D, M> for TamedEuler
where
    S: Sde<D, M> + ?Sized,
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
        let tamed = tamed_step(dt, &drift);
        for i in 0..D {
            x[i] += tamed * drift[i] + kick[i];
        }
        Ok(())
    }
}

impl FieldIntegrator for TamedEuler {
    type Memory = ();

    fn step<S: FieldSde + ?Sized>(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: FieldIncrement<'_>,
        x: &mut [f64],
        workspace: &mut Workspace,
        _memory: &mut (),
    ) -> Result<(), StepError> {
        let [drift] = workspace.buffers(x.len());
        system.drift(t, x, drift);
        let (intensity, tamed) = (system.intensity(t), tamed_step(dt, drift));
        for i in 0..x.len() {
            x[i] += tamed * drift[i] + intensity * dw.brownian[i];
        }
        Ok(())
    }
}
