//! Euler-Maruyama method.

use crate::error::StepError;
use crate::integrator::{Integrator, apply};
use crate::noise::lane_increments::{LANES, LaneIncrements};
use crate::noise::streams::Increment;
use crate::system::{NoiseClass, Sde};

/// Euler-Maruyama method, for any system.
///
/// $$ X_{n+1} = X_n + h f(t_n, X_n) + g(t_n, X_n) w_n $$
///
/// Solves the Ito equation `dX = f dt + g dB`. Symbols: `h` = `dt`, `w` = `dw.brownian`.
///
/// Order: strong 1/2 and weak 1 for general noise, strong 1 and weak 1 for additive noise.
///
/// Stable for: `|1 + h l| < 1` with every eigenvalue `l` of the linearised drift. For an oscillator with damping ratio
/// `xi <= 1` the limit is `h omega < 2 xi`: light damping requires very small steps. Within the limit the stationary
/// variance is too large by a factor of `1/(1 - h omega/(2 xi))` to leading order. Use
/// [`SemiImplicitEuler`](crate::SemiImplicitEuler) at the same cost or [`StrangOscillator`](crate::StrangOscillator)
/// there. For a drift that grows superlinearly some path explodes at any step length.
///
/// Sources: Maruyama 1955, Continuous Markov processes and stochastic equations; orders: Kloeden and Platen 1992,
/// theorems 10.2.2 and 14.1.5. It is the Monte Carlo method of Canor and Denoël 2013, section 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EulerMaruyama;

impl<S, const D: usize, const M: usize> Integrator<S, D, M> for EulerMaruyama
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
        for i in 0..D {
            x[i] += dt * drift[i] + kick[i];
        }
        Ok(())
    }

    #[allow(
        clippy::inline_always,
        reason = "what is not inlined into a dispatched function is not compiled for its registers"
    )]
    #[inline(always)]
    fn step_lanes(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &LaneIncrements<M>,
        x: &mut [[f64; LANES]; D],
        _memory: &mut [(); LANES],
        _failed: &mut dyn FnMut(usize, StepError),
    ) {
        // State-independent noise is evaluated once.
        let common = system.noise(t, &std::array::from_fn(|i| x[i][0]));
        for lane in 0..LANES {
            let state = std::array::from_fn(|i| x[i][lane]);
            let noise = if S::Noise::STATE_DEPENDENT { system.noise(t, &state) } else { common };
            let drift = system.drift(t, &state);
            let kick = apply(&noise, &dw.lane(lane).brownian);
            for i in 0..D {
                x[i][lane] += dt * drift[i] + kick[i];
            }
        }
    }
}
