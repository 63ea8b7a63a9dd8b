//! Semi-implicit Euler: velocity first, then position with the new velocity.

use crate::integrator::{Joints, apply, integrate_second_order_lanes};
use crate::noise::streams::Increment;
use crate::system::SecondOrder;

/// Semi-implicit (symplectic) Euler method, for second-order systems with additive noise.
///
/// $$ v_{n+1} = v_n + h a(t_n, q_n, v_n) + s(t_n) w_n, \qquad q_{n+1} = q_n + h v_{n+1} $$
///
/// Solves `q'' = a(t, q, q') + s(t) W`, with `a` the whole [`acceleration`](SecondOrder::acceleration); state
/// `(q_1.., v_1..)`. Symbols: `h` = `dt`, `w` = `dw.brownian`. It takes one force evaluation per
/// step, like [`EulerMaruyama`](crate::EulerMaruyama).
///
/// Order (additive noise): strong 1, weak 1; the error of the stationary `E[q^2]` of an oscillator is only `O(h^2)`.
/// For a damping ratio of 0.05 the relative error is +0.20, +0.043, +0.010, +2.5e-3, +6.3e-4 at `h omega` = 0.8, 0.4,
/// 0.2, 0.1, 0.05.
///
/// Stable for: `h omega < 2 (sqrt(1 + xi^2) - xi)`, with `xi` the damping ratio of the linear part.
///
/// Sources: without noise Hairer, Lubich and Wanner 2006, Geometric numerical integration, eq I.1.9; with noise
/// Mannella 2004, Quasisymplectic integrators for stochastic differential equations. The stability limit follows from
/// the trace `2 - c h - (h omega)^2` and the determinant `1 - c h` of one step, the errors from its stationary
/// covariance; both are in `tests/laws`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SemiImplicitEuler;

impl SemiImplicitEuler {
    /// Noise intensity over the step.
    #[inline]
    fn prepare<S, const N: usize, const M: usize>(
        system: &S,
        (t, _): (f64, f64),
        _joints: Joints,
        _memory: &mut (),
    ) -> [[f64; M]; N]
    where
        S: SecondOrder<N, M> + ?Sized,
    {
        system.noise_intensity(t)
    }

    /// A step leaves nothing to the next one.
    #[inline]
    fn open<S, const N: usize, const M: usize>(
        _system: &S,
        _time: (f64, f64),
        _state: (&mut [f64; N], &mut [f64; N]),
    ) where
        S: SecondOrder<N, M> + ?Sized,
    {
    }

    #[allow(clippy::inline_always, reason = "used in a loop over lanes")]
    #[inline(always)]
    fn advance<S, const N: usize, const M: usize>(
        system: &S,
        (t, dt): (f64, f64),
        dw: &Increment<M>,
        (q, v): (&mut [f64; N], &mut [f64; N]),
        intensity: &[[f64; M]; N],
    ) where
        S: SecondOrder<N, M> + ?Sized,
    {
        let acceleration = system.acceleration(t, q, v);
        let kick = apply(intensity, &dw.brownian);
        for k in 0..N {
            v[k] += dt * acceleration[k] + kick[k];
            q[k] += dt * v[k];
        }
    }
}

integrate_second_order_lanes!(SemiImplicitEuler, uses_area: false {
    1 => 2, ();
    2 => 4, ();
    3 => 6, ();
});
