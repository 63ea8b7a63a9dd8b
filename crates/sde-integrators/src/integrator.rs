//! The integrator trait: one step of a method.

use crate::error::StepError;
use crate::noise::lane_increments::{LANES, LaneIncrements};
use crate::noise::streams::Increment;

/// Which ends of a step adjoin another step of the same length, with the state between them unobserved.
///
/// A method whose step ends as the next begins may leave that end open and combine both parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Joints {
    /// The previous step was taken with `after` set.
    pub before: bool,
    /// The next step will be taken with `before` set.
    pub after: bool,
}

/// A method that takes one step of a system with `D` states and `M` Brownian motions.
///
/// A step owns no clock, storage or random numbers: time, increment and memory are arguments. The bound of an
/// implementation on `S` states its requirements: any [`Sde`](crate::Sde), additive noise, or the parts of a
/// [`SecondOrder`](crate::SecondOrder) system.
pub trait Integrator<S: ?Sized, const D: usize, const M: usize>: Sync {
    /// Data of a path kept between steps, other than its state, such as the noise of the last step.
    type Memory: Default + Clone + Send;

    /// Whether the method uses [`Increment::space_time_area`]. Otherwise an ensemble does not draw it.
    const USES_AREA: bool = true;

    /// Advances `x` from `t` to `t + dt` along the increment `dw` over that step.
    ///
    /// # Errors
    /// If the method cannot take the step. A non-finite result is no error here; the caller checks.
    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<M>,
        x: &mut [f64; D],
        memory: &mut Self::Memory,
    ) -> Result<(), StepError>;

    /// Advances [`LANES`] paths of an ensemble, whose memories have taken the same steps.
    ///
    /// The result is bitwise identical to [`step`](Self::step) on each path. If a step fails, `failed` receives its
    /// lane and error.
    ///
    /// The default loops over the lanes; the compiler vectorises the loop if step and system are inlined and have no
    /// branch. A method overrides it to do common work once for all lanes.
    #[allow(
        clippy::inline_always,
        reason = "what is not inlined into a dispatched function is not compiled for its registers"
    )]
    #[allow(clippy::too_many_arguments, reason = "those of a step, and who fails")]
    #[inline(always)]
    fn step_lanes(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &LaneIncrements<M>,
        x: &mut [[f64; LANES]; D],
        memory: &mut [Self::Memory; LANES],
        failed: &mut dyn FnMut(usize, StepError),
    ) {
        for lane in 0..LANES {
            let mut state = std::array::from_fn(|i| x[i][lane]);
            let dw = dw.lane(lane);
            if let Err(error) = self.step(system, t, dt, &dw, &mut state, &mut memory[lane]) {
                failed(lane, error);
            }
            for i in 0..D {
                x[i][lane] = state[i];
            }
        }
    }

    /// The same for a step whose ends may adjoin other steps.
    ///
    /// It equals [`step_lanes`](Self::step_lanes) within roundoff once all joints are closed.
    ///
    /// The default calls [`step_lanes`](Self::step_lanes), for a method without joints.
    #[allow(
        clippy::inline_always,
        reason = "what is not inlined into a dispatched function is not compiled for its registers"
    )]
    #[allow(clippy::too_many_arguments, reason = "those of a step, its ends, and who fails")]
    #[inline(always)]
    fn step_lanes_joined(
        &self,
        _joints: Joints,
        system: &S,
        t: f64,
        dt: f64,
        dw: &LaneIncrements<M>,
        x: &mut [[f64; LANES]; D],
        memory: &mut [Self::Memory; LANES],
        failed: &mut dyn FnMut(usize, StepError),
    ) {
        self.step_lanes(system, t, dt, dw, x, memory, failed);
    }
}

/// Implements `Integrator` for a method that advances `(q, v)`, and does part of a step once for all paths of an ensemble.
///
/// The states are `(q_1.., v_1..)` with 1, 2 and 3 degrees of freedom.
///
/// `prepare(system, t, dt, joints, memory)` computes what `advance` needs of time, step length and system, independent
/// of the path. Without a previous step, `open(system, t, dt, q, v)` first performs the part that `advance` omits at
/// such a joint.
macro_rules! integrate_second_order_lanes {
    ($method:ty, uses_area: $uses_area:literal { $($n:literal => $d:literal, $memory:ty;)+ }) => { $(
        impl<S, const M: usize> $crate::integrator::Integrator<S, $d, M> for $method
        where
            S: $crate::system::SecondOrder<$n, M> + ?Sized,
        {
            type Memory = $memory;
            const USES_AREA: bool = $uses_area;

            #[inline]
            fn step(
                &self,
                system: &S,
                t: f64,
                dt: f64,
                dw: &$crate::noise::streams::Increment<M>,
                x: &mut [f64; $d],
                memory: &mut Self::Memory,
            ) -> Result<(), $crate::error::StepError> {
                let joints = $crate::integrator::Joints::default();
                let prepared = Self::prepare::<S, $n, M>(system, (t, dt), joints, memory);
                let mut q = std::array::from_fn(|k| x[k]);
                let mut v = std::array::from_fn(|k| x[$n + k]);
                Self::open::<S, $n, M>(system, (t, dt), (&mut q, &mut v));
                Self::advance::<S, $n, M>(system, (t, dt), dw, (&mut q, &mut v), &prepared);
                x[..$n].copy_from_slice(&q);
                x[$n..].copy_from_slice(&v);
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
                dw: &$crate::noise::lane_increments::LaneIncrements<M>,
                x: &mut [[f64; $crate::noise::lane_increments::LANES]; $d],
                memory: &mut [Self::Memory; $crate::noise::lane_increments::LANES],
                failed: &mut dyn FnMut(usize, $crate::error::StepError),
            ) {
                let joints = $crate::integrator::Joints::default();
                self.step_lanes_joined(joints, system, t, dt, dw, x, memory, failed);
            }

            #[allow(
                clippy::inline_always,
                reason = "what is not inlined into a dispatched function is not compiled for its registers"
            )]
            #[inline(always)]
            fn step_lanes_joined(
                &self,
                joints: $crate::integrator::Joints,
                system: &S,
                t: f64,
                dt: f64,
                dw: &$crate::noise::lane_increments::LaneIncrements<M>,
                x: &mut [[f64; $crate::noise::lane_increments::LANES]; $d],
                memory: &mut [Self::Memory; $crate::noise::lane_increments::LANES],
                _failed: &mut dyn FnMut(usize, $crate::error::StepError),
            ) {
                // All lanes have taken the same steps: the first memory is that of every lane.
                let prepared = Self::prepare::<S, $n, M>(system, (t, dt), joints, &mut memory[0]);
                // A separate loop: inside the other one it would be computed and discarded at joints.
                if !joints.before {
                    for lane in 0..$crate::noise::lane_increments::LANES {
                        let mut q = std::array::from_fn(|k| x[k][lane]);
                        let mut v = std::array::from_fn(|k| x[$n + k][lane]);
                        Self::open::<S, $n, M>(system, (t, dt), (&mut q, &mut v));
                        for k in 0..$n {
                            x[k][lane] = q[k];
                            x[$n + k][lane] = v[k];
                        }
                    }
                }
                for lane in 0..$crate::noise::lane_increments::LANES {
                    let mut q = std::array::from_fn(|k| x[k][lane]);
                    let mut v = std::array::from_fn(|k| x[$n + k][lane]);
                    let dw = dw.lane(lane);
                    Self::advance::<S, $n, M>(system, (t, dt), &dw, (&mut q, &mut v), &prepared);
                    for k in 0..$n {
                        x[k][lane] = q[k];
                        x[$n + k][lane] = v[k];
                    }
                }
            }
        }
    )+ };
}
pub(crate) use integrate_second_order_lanes;

/// `g w`: contribution of the Brownian increments to each row.
#[allow(clippy::inline_always, reason = "used in loops over lanes")]
#[inline(always)]
pub(crate) fn apply<const R: usize, const M: usize>(g: &[[f64; M]; R], w: &[f64; M]) -> [f64; R] {
    let mut sum = [0.0; R];
    for (value, row) in sum.iter_mut().zip(g) {
        for (a, b) in row.iter().zip(w) {
            *value += a * b;
        }
    }
    sum
}
