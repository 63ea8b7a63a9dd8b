//! Milstein's method for diagonal noise.

use crate::diagonal::DiagonalSde;
use crate::error::StepError;
use crate::integrator::Integrator;
use crate::noise::streams::Increment;

/// Milstein's method, for diagonal noise.
///
/// $$ X_{n+1} = X_n + h f(t_n, X_n) + b w + \frac12 b b' (w^2 - h) $$
///
/// per state, with `b` and its derivative at `(t_n, X_n)`. Solves the Ito equation `dX_i = f_i dt + b_i(t, X_i) dB_i`.
/// Symbols: `h` = `dt`, `w` = `dw.brownian`.
///
/// Order: strong 1 and weak 1 for diagonal noise. For additive noise it equals Euler-Maruyama. Noise that does not
/// commute would require the Lévy area between motions, and does not compile.
///
/// Stable for: in the mean square of `dX = l X dt + m X dB` where `(1 + l h)^2 + q + q^2/2 < 1` with `q = m^2 h`. The
/// region is smaller than that of Euler-Maruyama: the method is more accurate on a path, but explodes at smaller
/// steps.
///
/// Source: Milstein 1975, Approximate integration of stochastic differential equations; Kloeden and Platen 1992,
/// eq 10.3.12.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Milstein;

impl<S, const D: usize> Integrator<S, D, D> for Milstein
where
    S: DiagonalSde<D> + ?Sized,
{
    type Memory = ();
    const USES_AREA: bool = false;

    #[inline]
    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<D>,
        x: &mut [f64; D],
        _memory: &mut (),
    ) -> Result<(), StepError> {
        let drift = system.drift(t, x);
        let (b, slope) = (system.intensity(t, x), system.intensity_derivative(t, x));
        for i in 0..D {
            let w = dw.brownian[i];
            x[i] += dt * drift[i] + b[i] * (w + 0.5 * slope[i] * (w * w - dt));
        }
        Ok(())
    }
}
