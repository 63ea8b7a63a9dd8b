//! The stochastic theta method: implicit in the drift.

use crate::error::{Error, StepError};
use crate::integrator::{Integrator, apply};
use crate::methods::linear_solve::solve;
use crate::noise::streams::Increment;
use crate::system::Sde;

/// The stochastic theta method, implicit in the drift.
///
/// $$ X_{n+1} = X_n + h \left((1 - \theta) f(t_n, X_n) + \theta f(t_{n+1}, X_{n+1})\right) + g(t_n, X_n) w $$
///
/// Solves the Ito equation `dX = f dt + g dB`, for any noise. Symbols: `h` = `dt`, `w` = `dw.brownian`. `theta` = 0 is
/// Euler-Maruyama, 1/2 the trapezoidal rule, 1 backward Euler.
///
/// Order: strong 1/2 for general noise, 1 for additive noise; weak 1, but 2 for the trapezoidal rule with constant
/// additive noise. Without noise it is 1, for the trapezoidal rule 2.
///
/// Stable for: in the mean square of `dX = l X dt + m X dB` where
/// `(1 + (1 - theta) l h)^2 + m^2 h < (1 - theta l h)^2`; for `theta >= 1/2` this holds whenever the equation itself
/// is stable. The trapezoidal rule has the exact stationary covariance of a linear system with additive noise, at
/// every `h`. Backward Euler is dissipative: at `h omega = 0.1` and a damping ratio of 0.05 it loses half of the
/// stationary `E[q^2]`.
///
/// Newton's method with a forward-difference Jacobian ends when the correction is below [`TOLERANCE`](Self::TOLERANCE)
/// of the state; it converges superlinearly, so the remaining error is roundoff.
///
/// Cost: per step one noise evaluation, and per iteration `D + 1` drift evaluations.
///
/// Sources: Kloeden and Platen 1992, eq 12.2.2; stability: Higham 2000, Mean-square and asymptotic stability of the
/// stochastic theta method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StochasticTheta {
    theta: f64,
}

impl StochasticTheta {
    /// `theta = 1/2`.
    pub const TRAPEZOIDAL: Self = Self { theta: 0.5 };
    /// `theta = 1`.
    pub const BACKWARD_EULER: Self = Self { theta: 1.0 };
    /// Largest correction that ends the iteration, relative to the largest state.
    pub const TOLERANCE: f64 = 1e-9;
    /// Largest number of iterations.
    pub const MAX_ITERATIONS: usize = 50;

    /// A method with `0 <= theta <= 1`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn new(theta: f64) -> Result<Self, Error> {
        if (0.0..=1.0).contains(&theta) {
            Ok(Self { theta })
        } else {
            Err(Error::OutOfRange { quantity: "theta", value: theta, from: 0.0, to: 1.0 })
        }
    }

    /// `theta`.
    #[must_use]
    pub const fn theta(&self) -> f64 {
        self.theta
    }
}

impl<S, const D: usize, const M: usize> Integrator<S, D, M> for StochasticTheta
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
        let drift = system.drift(t, x);
        let kick = apply(&system.noise(t, x), &dw.brownian);
        let explicit = (1.0 - self.theta) * dt;
        let known: [f64; D] = std::array::from_fn(|i| x[i] + explicit * drift[i] + kick[i]);
        *x = if self.theta > 0.0 {
            implicit(system, t + dt, self.theta * dt, &known, x)?
        } else {
            known
        };
        Ok(())
    }
}

fn largest<const D: usize>(x: &[f64; D]) -> f64 {
    x.iter().fold(
        0.0,
        |largest, value| if value.is_nan() { f64::NAN } else { largest.max(value.abs()) },
    )
}

/// Solves `y = known + tau f(t, y)` by Newton's method; a correction that increases the residual is halved.
fn implicit<S, const D: usize, const M: usize>(
    system: &S,
    t: f64,
    tau: f64,
    known: &[f64; D],
    guess: &[f64; D],
) -> Result<[f64; D], StepError>
where
    S: Sde<D, M> + ?Sized,
{
    let (mut y, mut correction) = (*guess, [0.0; D]);
    let (mut least, mut last, mut limit) = (f64::INFINITY, f64::INFINITY, 0.0);
    for _ in 0..StochasticTheta::MAX_ITERATIONS {
        let drift = system.drift(t, &y);
        let residual = std::array::from_fn(|i| known[i] + tau * drift[i] - y[i]);
        let size = largest(&residual);
        if size.is_nan() || size > least {
            for i in 0..D {
                correction[i] *= 0.5;
                y[i] -= correction[i];
            }
            continue;
        }
        least = size;
        let jacobian = implicit_jacobian(system, t, tau, &y, &drift);
        correction = solve(jacobian, residual)?;
        for i in 0..D {
            y[i] += correction[i];
        }
        last = largest(&correction);
        limit = StochasticTheta::TOLERANCE * largest(&y).max(largest(known));
        if last <= limit {
            return Ok(y);
        }
    }
    let iterations = StochasticTheta::MAX_ITERATIONS;
    Err(StepError::NotConverged { iterations, residual: last, limit })
}

/// `1 - tau f'` by forward differences.
fn implicit_jacobian<S, const D: usize, const M: usize>(
    system: &S,
    t: f64,
    tau: f64,
    y: &[f64; D],
    drift: &[f64; D],
) -> [[f64; D]; D]
where
    S: Sde<D, M> + ?Sized,
{
    let mut jacobian = [[0.0; D]; D];
    for j in 0..D {
        let mut moved = *y;
        moved[j] += f64::EPSILON.sqrt() * y[j].abs().max(1.0);
        let length = moved[j] - y[j];
        let drift_moved = system.drift(t, &moved);
        for i in 0..D {
            let slope = (drift_moved[i] - drift[i]) / length;
            jacobian[i][j] = f64::from(u8::from(i == j)) - tau * slope;
        }
    }
    jacobian
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::Additive;

    /// `x' = x^2`: backward Euler requires `y = x + h y^2`, without a real root for `4 h x > 1`.
    struct Square;

    impl Sde<1, 1> for Square {
        type Noise = Additive;

        fn drift(&self, _t: f64, x: &[f64; 1]) -> [f64; 1] {
            [x[0] * x[0]]
        }

        fn noise(&self, _t: f64, _x: &[f64; 1]) -> [[f64; 1]; 1] {
            [[0.0]]
        }
    }

    #[test]
    fn an_equation_without_a_root_is_a_typed_error_and_leaves_the_state() {
        let method = StochasticTheta::BACKWARD_EULER;
        let mut x = [1.0];
        method.step(&Square, 0.0, 0.2, &Increment::ZERO, &mut x, &mut ()).unwrap();
        let root = (1.0 - (1.0 - 0.8_f64).sqrt()) / 0.4;
        assert!((x[0] - root).abs() < 1e-14 * root, "{}", x[0]);
        let mut x = [1.0];
        let error = method.step(&Square, 0.0, 0.3, &Increment::ZERO, &mut x, &mut ()).unwrap_err();
        assert!(
            matches!(
                error,
                StepError::NotConverged { iterations: 50, .. } | StepError::Singular { .. }
            ),
            "{error}"
        );
        assert_eq!(x.map(f64::to_bits), [1.0_f64.to_bits()]);
    }

    #[test]
    fn theta_outside_zero_to_one_is_refused() {
        for theta in [-0.1, 1.1, f64::NAN] {
            assert!(matches!(StochasticTheta::new(theta), Err(Error::OutOfRange { .. })));
        }
        assert_eq!(StochasticTheta::new(0.5), Ok(StochasticTheta::TRAPEZOIDAL));
    }
}
