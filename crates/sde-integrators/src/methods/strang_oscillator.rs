//! Strang splitting of a noisy oscillator into parts that are solved exactly.

use crate::integrator::{Joints, apply, integrate_second_order_lanes};
use crate::noise::streams::Increment;
use crate::system::SecondOrder;

/// A symmetric composition of exact flows, for second-order systems with additive noise.
///
/// With `h` = `dt`, one step from `t` to `t + h` is
///
/// 1. `R(h/2)`: `dv/dt = r(t, q, v)` at frozen time `t` and position,
/// 2. `O(h/2)`: `dv = -c v dt + s dB`, with the intensity `s(t + h/4)`,
/// 3. `A(h)`: `q'' = -omega^2 q`, a rotation by the angle `omega h` (a drift where `omega = 0`),
/// 4. `O(h/2)`, with `s(t + 3h/4)`,
/// 5. `R(h/2)`, at frozen time `t + h`,
///
/// $$ O(\tau): v \leftarrow e^{-c\tau} v + s \sqrt{\frac{1 - e^{-2c\tau}}{2c}} z, \qquad
///    A(h): \begin{pmatrix} q \cr v \end{pmatrix} \leftarrow
///    \begin{pmatrix} \cos\omega h & \omega^{-1}\sin\omega h \cr -\omega\sin\omega h & \cos\omega h \end{pmatrix}
///    \begin{pmatrix} q \cr v \end{pmatrix} . $$
///
/// The two normals `z` come from the increment of the step: `w/2 + sqrt(3) H` and `w/2 - sqrt(3) H` are independent
/// and `N(0, h/2)`. The first has the larger correlation with the first half of the path, so the method follows the
/// same path as every other method.
///
/// Solves `q'' + c q' + omega^2 q = r(t, q, q') + s(t) W`; state `(q_1.., v_1..)`. Time advances with `A`, so `r` is
/// always evaluated at consistent position and time.
///
/// Order (additive noise): strong 1, weak 2. With `r = 0` and constant `s` the stationary distribution of the
/// oscillator is exact at every step length. If `r` is not smooth in `v` (a power below one) the order of the
/// composition may decrease; the flow itself stays exact.
///
/// Stable for: every `h` with `r = 0`. A stiffness `k` in `r` requires about `h sqrt(k) < 2`: include it in `omega`.
///
/// Step 5 and step 1 of the next step are one flow of `r` over `h`, at one time and position. An ensemble combines
/// them where the state between them is unobserved; results are equal within roundoff.
///
/// Cost: two flows of `r`, one where steps are combined, and two intensities per step; exponential, sine and cosine
/// once per path and step length.
///
/// Sources: Strang 1968, On the construction and comparison of difference schemes; with noise Leimkuhler and Matthews
/// 2015, Molecular dynamics, chapter 7 (there the rotation is split further).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StrangOscillator;

/// Coefficients of the linear flows of [`StrangOscillator`], kept while step length and system do not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearFlows<const N: usize> {
    flows: [LinearFlow; N],
}

impl<const N: usize> Default for LinearFlows<N> {
    fn default() -> Self {
        Self { flows: [LinearFlow::NONE; N] }
    }
}

/// The linear flows of one degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LinearFlow {
    dt: f64,
    omega: f64,
    c: f64,
    /// `exp(-c h/2)`.
    decay: f64,
    /// Standard deviation of the half kick over that without damping, `sqrt((1 - exp(-c h))/(c h))`.
    kick: f64,
    /// `cos(omega h)`.
    cos: f64,
    /// `sin(omega h)/omega`.
    q_from_v: f64,
    /// `-omega sin(omega h)`.
    v_from_q: f64,
}

impl LinearFlow {
    /// Valid for no step length.
    const NONE: Self = Self {
        dt: f64::NAN,
        omega: 0.0,
        c: 0.0,
        decay: 1.0,
        kick: 1.0,
        cos: 1.0,
        q_from_v: 0.0,
        v_from_q: 0.0,
    };

    #[cold]
    fn new(dt: f64, omega: f64, c: f64) -> Self {
        let (damping, angle) = (c * dt, omega * dt);
        let (sin, cos) = angle.sin_cos();
        Self {
            dt,
            omega,
            c,
            decay: (-0.5 * damping).exp(),
            kick: if damping > 0.0 { (-(-damping).exp_m1() / damping).sqrt() } else { 1.0 },
            cos,
            q_from_v: if angle > 0.0 { dt * (sin / angle) } else { dt },
            v_from_q: -omega * sin,
        }
    }

    #[inline]
    fn rotate(&self, q: &mut f64, v: &mut f64) {
        (*q, *v) = (self.cos * *q + self.q_from_v * *v, self.v_from_q * *q + self.cos * *v);
    }
}

/// Data of a step common to all paths.
struct Prepared<const N: usize, const M: usize> {
    flows: [LinearFlow; N],
    /// Intensities of the two kicks.
    intensities: [[[f64; M]; N]; 2],
    /// Length of the last flow of `r`: half a step, or to the middle of the next step.
    closing: f64,
}

impl StrangOscillator {
    #[inline]
    fn prepare<S, const N: usize, const M: usize>(
        system: &S,
        (t, dt): (f64, f64),
        joints: Joints,
        memory: &mut LinearFlows<N>,
    ) -> Prepared<N, M>
    where
        S: SecondOrder<N, M> + ?Sized,
    {
        let (omega, c) = (system.natural_frequency(), system.linear_damping());
        for (k, flow) in memory.flows.iter_mut().enumerate() {
            let known = [(flow.dt, dt), (flow.omega, omega[k]), (flow.c, c[k])];
            if known.iter().any(|(kept, now)| kept.to_bits() != now.to_bits()) {
                *flow = LinearFlow::new(dt, omega[k], c[k]);
            }
        }
        let intensities = [0.25, 0.75].map(|part| system.noise_intensity(t + part * dt));
        let closing = if joints.after { dt } else { 0.5 * dt };
        Prepared { flows: memory.flows, intensities, closing }
    }

    #[allow(clippy::inline_always, reason = "used in a loop over lanes")]
    #[inline(always)]
    fn open<S, const N: usize, const M: usize>(
        system: &S,
        (t, dt): (f64, f64),
        (q, v): (&mut [f64; N], &mut [f64; N]),
    ) where
        S: SecondOrder<N, M> + ?Sized,
    {
        system.remaining_flow(t, 0.5 * dt, q, v);
    }

    #[allow(clippy::inline_always, reason = "used in a loop over lanes")]
    #[inline(always)]
    fn advance<S, const N: usize, const M: usize>(
        system: &S,
        (t, dt): (f64, f64),
        dw: &Increment<M>,
        (q, v): (&mut [f64; N], &mut [f64; N]),
        prepared: &Prepared<N, M>,
    ) where
        S: SecondOrder<N, M> + ?Sized,
    {
        let (mut first, mut second) = ([0.0; M], [0.0; M]);
        for m in 0..M {
            let (half, skew) = (0.5 * dw.brownian[m], SQRT_3 * dw.space_time_area[m]);
            (first[m], second[m]) = (half + skew, half - skew);
        }
        let first = apply(&prepared.intensities[0], &first);
        let second = apply(&prepared.intensities[1], &second);

        for (k, flow) in prepared.flows.iter().enumerate() {
            v[k] = flow.decay * v[k] + flow.kick * first[k];
            flow.rotate(&mut q[k], &mut v[k]);
            v[k] = flow.decay * v[k] + flow.kick * second[k];
        }
        system.remaining_flow(t + dt, prepared.closing, q, v);
    }
}

const SQRT_3: f64 = 1.7320508075688772;

integrate_second_order_lanes!(StrangOscillator, uses_area: true {
    1 => 2, LinearFlows<1>;
    2 => 4, LinearFlows<2>;
    3 => 6, LinearFlows<3>;
});
