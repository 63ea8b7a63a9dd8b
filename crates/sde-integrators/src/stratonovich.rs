//! Stratonovich systems, and their conversion to Ito form.

use crate::system::{Additive, General, Sde};

/// A Stratonovich stochastic differential equation,
///
/// $$ dX = f(t, X) dt + g(t, X) \circ dB . $$
///
/// It is a separate trait, so a method for one form does not compile with a system of the other. For additive noise
/// both forms agree: every [`Sde`] with [`Additive`] noise is a [`StratonovichSde`] too.
///
/// ```compile_fail
/// use sde_integrators::{EulerMaruyama, Increment, Integrator, StratonovichSde};
///
/// struct Growth;
///
/// impl StratonovichSde<1, 1> for Growth {
///     fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] { [0.1 * x[0]] }
///     fn noise(&self, _t: f64, x: &[f64; 1]) -> [[f64; 1]; 1] { [[0.5 * x[0]]] }
/// }
///
/// // Euler-Maruyama solves Ito equations: the trait bound `Growth: Sde<1, 1>` is not satisfied.
/// EulerMaruyama.step(&Growth, 0.0, 0.1, &Increment::ZERO, &mut [1.0], &mut ());
/// ```
pub trait StratonovichSde<const D: usize, const M: usize>: Sync {
    /// `f(t, x)`, per unit of time.
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D];

    /// `g(t, x)`, row per state, column per Brownian motion, per square root of time.
    fn noise(&self, t: f64, x: &[f64; D]) -> [[f64; M]; D];
}

/// Additive noise has no correction term.
impl<S, const D: usize, const M: usize> StratonovichSde<D, M> for S
where
    S: Sde<D, M, Noise = Additive> + ?Sized,
{
    #[inline]
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        Sde::drift(self, t, x)
    }

    #[inline]
    fn noise(&self, t: f64, x: &[f64; D]) -> [[f64; M]; D] {
        Sde::noise(self, t, x)
    }
}

/// The same process as a [`StratonovichSde`] in Ito form, for any noise,
///
/// $$ f^{Ito}_i = f_i + \frac12 \sum_j \sum_k g_{kj} \frac{\partial g_{ij}}{\partial x_k} . $$
///
/// The sum is the derivative of each column of `g` along itself, computed by a central difference: relative error
/// about 1e-10, and two evaluations of `g` per motion and drift.
///
/// Source: Kloeden and Platen 1992, eq 4.9.11.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ItoForm<S>(
    /// The system in Stratonovich form.
    pub S,
);

impl<S, const D: usize, const M: usize> Sde<D, M> for ItoForm<S>
where
    S: StratonovichSde<D, M>,
{
    type Noise = General;

    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        let mut drift = self.0.drift(t, x);
        let g = self.0.noise(t, x);
        let scale = x.iter().fold(1.0_f64, |largest, value| largest.max(value.abs()));
        for j in 0..M {
            let length = g.iter().fold(0.0_f64, |largest, row| largest.max(row[j].abs()));
            if length == 0.0 {
                continue;
            }
            let step = f64::EPSILON.cbrt() * scale / length;
            let along = |sign: f64| {
                let moved = std::array::from_fn(|k| x[k] + sign * step * g[k][j]);
                self.0.noise(t, &moved)
            };
            let (above, below) = (along(1.0), along(-1.0));
            for i in 0..D {
                drift[i] += 0.25 * (above[i][j] - below[i][j]) / step;
            }
        }
        drift
    }

    #[inline]
    fn noise(&self, t: f64, x: &[f64; D]) -> [[f64; M]; D] {
        self.0.noise(t, x)
    }
}
