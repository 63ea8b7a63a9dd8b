//! SK-ROCK: explicit stabilised method whose stability region grows with the square of the number of stages.

use crate::error::{Error, StepError};
use crate::field::{FieldIncrement, FieldIntegrator, FieldSde, Workspace};
use crate::integrator::{Integrator, apply};
use crate::noise::Increment;
use crate::system::Sde;

/// SK-ROCK, the stochastic second-kind orthogonal Runge-Kutta-Chebyshev method, for stiff drifts with real spectrum.
///
/// With `s` stages, `T_i` the Chebyshev polynomials, `w_0 = 1 + eta/s^2`, `w_1 = T_s(w_0)/T_s'(w_0)`:
///
/// $$ K_1 = X_n + \mu_1 h f(t_n, X_n + \nu_1 g w) + \kappa_1 g w, $$
/// $$ K_i = \mu_i h f(t_n + c_{i-1} h, K_{i-1}) + \nu_i K_{i-1} + \kappa_i K_{i-2}, \qquad X_{n+1} = K_s, $$
/// $$ \mu_1 = \frac{w_1}{w_0}, \quad \nu_1 = \frac{s w_1}2, \quad \kappa_1 = \frac{s w_1}{w_0}, \qquad
///    \mu_i = 2 w_1 \frac{T_{i-1}}{T_i}, \quad \nu_i = 2 w_0 \frac{T_{i-1}}{T_i}, \quad
///    \kappa_i = -\frac{T_{i-2}}{T_i} $$
///
/// with `K_0 = X_n`, all `T_i` at `w_0`, and `g = g(t_n, X_n)`. Solves the Ito equation `dX = f dt + g dB`, for any
/// noise. Symbols: `h` = `dt`, `w` = `dw.brownian` in the step, `eta` the [`DAMPING`](Self::DAMPING).
///
/// Order: strong 1/2 and weak 1 for general noise, strong 1 for additive noise; 1 without noise.
///
/// Stable for: in the mean square of `dX = l X dt + m X dB`, with `p = l h` and `x = w_0 + w_1 p`, where
/// `A^2 + B^2 m^2 h < 1`, `A = T_s(x)/T_s(w_0)`, `B = (U_{s-1}(x)/U_{s-1}(w_0)) (1 + w_1 p/2)`. This covers nearly
/// every stable equation with `|p| < (2 - 4 eta/3) s^2`, for any noise. The drift must be dissipative: an undamped
/// oscillator is unstable.
///
/// Cost: `s` drift evaluations and one noise evaluation per step.
///
/// Source: Abdulle, Almuslimani and Vilmart 2018, Optimal explicit stabilized integrator of weak order 1 for stiff and
/// ergodic stochastic differential equations, eq 2.4.
///
/// ```
/// use sde_integrators::SkRock;
///
/// // Over 0.17 units of time Euler-Maruyama would take 85 drifts or more.
/// assert_eq!(SkRock::for_stiffness(1000.0, 0.17)?.n_stages(), 10);
/// # Ok::<(), sde_integrators::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SkRock {
    stages: Vec<Stage>,
    /// `nu_1`, the fraction of the noise added before the first drift evaluation.
    noise_ahead: f64,
}

/// Coefficients of one stage, and the time of its drift evaluation as a fraction of the step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stage {
    mu: f64,
    nu: f64,
    kappa: f64,
    node: f64,
}

impl SkRock {
    /// `eta`, the source's value.
    pub const DAMPING: f64 = 0.05;
    /// Largest number of stages: beyond it roundoff in the recurrence is significant.
    pub const MAX_STAGES: u64 = 1000;

    /// A method with `n_stages` stages, 1 to [`MAX_STAGES`](Self::MAX_STAGES).
    ///
    /// # Errors
    /// [`Error::TooFew`], [`Error::TooMany`].
    pub fn new(n_stages: u64) -> Result<Self, Error> {
        let quantity = "stages";
        if n_stages == 0 {
            return Err(Error::TooFew { quantity, value: 0, limit: 1 });
        }
        if n_stages > Self::MAX_STAGES {
            let (value, limit) = (n_stages as f64, Self::MAX_STAGES as f64);
            return Err(Error::TooMany { quantity, value, limit });
        }
        let s = n_stages as f64;
        let w_0 = 1.0 + Self::DAMPING / (s * s);
        // T_i and T_i' at w_0 by their recurrence.
        let (mut t, mut slope) = (vec![1.0, w_0], vec![0.0, 1.0]);
        for _ in 2..=n_stages {
            let n = t.len();
            t.push(2.0 * w_0 * t[n - 1] - t[n - 2]);
            slope.push(2.0 * t[n - 1] + 2.0 * w_0 * slope[n - 1] - slope[n - 2]);
        }
        let last = t.len() - 1;
        let w_1 = t[last] / slope[last];
        let first = Stage { mu: w_1 / w_0, nu: 1.0, kappa: s * w_1 / w_0, node: 0.0 };
        let mut stages = vec![first];
        let mut nodes = [0.0, w_1 / w_0];
        for i in 2..t.len() {
            let (mu, nu) = (2.0 * w_1 * t[i - 1] / t[i], 2.0 * w_0 * t[i - 1] / t[i]);
            let kappa = -t[i - 2] / t[i];
            stages.push(Stage { mu, nu, kappa, node: nodes[1] });
            nodes = [nodes[1], mu + nu * nodes[1] + kappa * nodes[0]];
        }
        Ok(Self { stages, noise_ahead: 0.5 * s * w_1 })
    }

    /// The method with the fewest stages that is stable for a drift with eigenvalues in `-spectral_radius..0`.
    ///
    /// The criterion is `h |l| < (2 - 4 eta/3) s^2` with a margin of one tenth.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for an invalid `spectral_radius` or `dt`, [`Error::TooMany`] if they require too many
    /// stages.
    pub fn for_stiffness(spectral_radius: f64, dt: f64) -> Result<Self, Error> {
        for (quantity, value) in [("spectral radius", spectral_radius), ("dt", dt)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::NotPositive { quantity, value });
            }
        }
        let per_square = 0.9 * (2.0 - 4.0 / 3.0 * Self::DAMPING);
        let asked = (spectral_radius * dt / per_square).sqrt().ceil().max(1.0);
        let limit = Self::MAX_STAGES as f64;
        if asked > limit {
            return Err(Error::TooMany { quantity: "stages", value: asked, limit });
        }
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 1 to 1000"
        )]
        Self::new(asked as u64)
    }

    /// `s`, the number of stages.
    #[must_use]
    pub const fn n_stages(&self) -> usize {
        self.stages.len()
    }
}

impl<S, const D: usize, const M: usize> Integrator<S, D, M> for SkRock
where
    S: Sde<D, M> + ?Sized,
{
    type Memory = ();
    const USES_AREA: bool = false;

    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<M>,
        x: &mut [f64; D],
        _memory: &mut (),
    ) -> Result<(), StepError> {
        let kick = apply(&system.noise(t, x), &dw.brownian);
        let ahead = std::array::from_fn(|k| x[k] + self.noise_ahead * kick[k]);
        let (first, rest) = (self.stages[0], &self.stages[1..]);
        let drift = system.drift(t, &ahead);
        let mut before = *x;
        let mut now: [f64; D] =
            std::array::from_fn(|k| x[k] + first.mu * dt * drift[k] + first.kappa * kick[k]);
        for stage in rest {
            let drift = system.drift(t + stage.node * dt, &now);
            let next = std::array::from_fn(|k| {
                stage.mu * dt * drift[k] + stage.nu * now[k] + stage.kappa * before[k]
            });
            (before, now) = (now, next);
        }
        *x = now;
        Ok(())
    }
}

impl FieldIntegrator for SkRock {
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
        let [drift, before, now] = workspace.buffers(x.len());
        let intensity = system.intensity(t);
        let (first, rest) = (self.stages[0], &self.stages[1..]);
        for k in 0..x.len() {
            now[k] = x[k] + self.noise_ahead * intensity * dw.brownian[k];
        }
        system.drift(t, now, drift);
        before.copy_from_slice(x);
        for k in 0..x.len() {
            now[k] = x[k] + first.mu * dt * drift[k] + first.kappa * intensity * dw.brownian[k];
        }
        for stage in rest {
            system.drift(t + stage.node * dt, now, drift);
            for k in 0..x.len() {
                let next = stage.mu * dt * drift[k] + stage.nu * now[k] + stage.kappa * before[k];
                (before[k], now[k]) = (now[k], next);
            }
        }
        x.copy_from_slice(now);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `nu_i + kappa_i = 1` (a constant is preserved), the nodes end at 1 (consistent time), and the noise of a zero
    /// drift is complete: `kappa_1` times the product of the recurrence is 1.
    #[test]
    fn the_coefficients_are_consistent() {
        for n_stages in [1, 2, 3, 5, 10, 20, 200] {
            let method = SkRock::new(n_stages).unwrap();
            let first = method.stages[0];
            let (mut time, mut noise) = ([0.0, first.mu], [0.0, first.kappa]);
            for stage in &method.stages[1..] {
                assert!((stage.nu + stage.kappa - 1.0).abs() < 1e-12);
                time = [time[1], stage.mu + stage.nu * time[1] + stage.kappa * time[0]];
                noise = [noise[1], stage.nu * noise[1] + stage.kappa * noise[0]];
            }
            assert!((time[1] - 1.0).abs() < 1e-11, "{n_stages} stages: {}", time[1]);
            assert!((noise[1] - 1.0).abs() < 1e-11, "{n_stages} stages: {}", noise[1]);
        }
    }

    #[test]
    fn numbers_of_stages_out_of_range_are_refused() {
        assert!(matches!(SkRock::new(0), Err(Error::TooFew { .. })));
        assert!(matches!(SkRock::new(1001), Err(Error::TooMany { .. })));
        assert!(matches!(SkRock::for_stiffness(f64::NAN, 0.1), Err(Error::NotPositive { .. })));
        assert!(matches!(SkRock::for_stiffness(1e9, 1.0), Err(Error::TooMany { .. })));
        // 193.7 is the limit of ten stages: a tenth less fits.
        assert_eq!(SkRock::for_stiffness(174.0, 1.0).unwrap().n_stages(), 10);
        assert_eq!(SkRock::for_stiffness(175.0, 1.0).unwrap().n_stages(), 11);
    }
}
