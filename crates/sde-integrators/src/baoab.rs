//! BAOAB: a Langevin splitting with accurate positions.

use crate::integrator::{apply, integrate_second_order};
use crate::noise::Increment;
use crate::system::SecondOrder;

/// BAOAB splitting of Langevin dynamics, for second-order systems with additive noise.
///
/// With `h` = `dt`, one step from `t` to `t + h` is
///
/// 1. `B(h/2)`: `dv/dt = r(t, q, v) - omega^2 q` at frozen time `t` and position: first the flow of `r`, then the kick,
/// 2. `A(h/2)`: `dq/dt = v`,
/// 3. `O(h)`: `dv = -c v dt + s dB`, with the intensity `s(t + h/2)`,
/// 4. `A(h/2)`,
/// 5. `B(h/2)` in reverse order, at frozen time `t + h`,
///
/// $$ O(h): v \leftarrow e^{-ch} v + s \sqrt{\frac{1 - e^{-2ch}}{2ch}} w . $$
///
/// Solves `q'' + c q' + omega^2 q = r(t, q, q') + s(t) W`; state `(q_1.., v_1..)`. Symbols: `w` = `dw.brownian`. For
/// Langevin dynamics the noise is `s = sqrt(2 c kT/m)`, which balances the friction `c`; other noise is allowed.
///
/// Order (additive noise): strong 1, weak 2. For a linear oscillator (`r = 0`, constant `s`) the stationary `E[q^2]`
/// is exact at every stable step. The velocity at the ends of a step is too small,
/// `E[v^2] = (1 - (h omega)^2/4) kT/m`; that of the half step is exact, and [`HalfStep`] stores it.
///
/// Stable for: `h omega < 2`, for any damping.
///
/// Cost: two flows of `r` and one intensity per step.
///
/// Source: Leimkuhler and Matthews 2013, Rational construction of stochastic numerical methods for molecular sampling.
/// Velocity of the half step of the half step: Zhang, Liu, Yan, Tuckerman and Liu 2019, Unified
/// efficient thermostat scheme for the canonical ensemble.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Baoab;

/// The velocity at the half step, after the noise: compute temperatures from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfStep<const N: usize> {
    velocity: [f64; N],
}

impl<const N: usize> HalfStep<N> {
    /// `v` at the middle of the last step; zero before the first.
    #[must_use]
    pub const fn velocity(&self) -> [f64; N] {
        self.velocity
    }
}

impl<const N: usize> Default for HalfStep<N> {
    fn default() -> Self {
        Self { velocity: [0.0; N] }
    }
}

impl Baoab {
    #[inline]
    fn advance<S, const N: usize, const M: usize>(
        system: &S,
        (t, dt): (f64, f64),
        dw: &Increment<M>,
        (q, v): (&mut [f64; N], &mut [f64; N]),
        memory: &mut HalfStep<N>,
    ) where
        S: SecondOrder<N, M> + ?Sized,
    {
        let (omega, c, half) = (system.natural_frequency(), system.linear_damping(), 0.5 * dt);
        let noise = apply(&system.noise_intensity(t + half), &dw.brownian);
        system.remaining_flow(t, half, q, v);
        for k in 0..N {
            v[k] -= half * omega[k] * omega[k] * q[k];
            q[k] += half * v[k];
            let damping = c[k] * dt;
            let kick = if damping > 0.0 {
                (-(-2.0 * damping).exp_m1() / (2.0 * damping)).sqrt()
            } else {
                1.0
            };
            v[k] = (-damping).exp() * v[k] + kick * noise[k];
            q[k] += half * v[k];
        }
        memory.velocity = *v;
        for k in 0..N {
            v[k] -= half * omega[k] * omega[k] * q[k];
        }
        system.remaining_flow(t + dt, half, q, v);
    }
}

integrate_second_order!(Baoab {
    1 => 2, HalfStep<1>;
    2 => 4, HalfStep<2>;
    3 => 6, HalfStep<3>;
});
