//! The seam of the methods: one step.

use crate::error::StepError;
use crate::lane_increments::{LANES, LaneIncrements};
use crate::noise::Increment;

/// Which ends of a step meet another step of the same length, with nobody looking at the state between them.
///
/// A method whose step ends as the next begins may leave that end open and do both at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Joints {
    /// The step before this one was taken with `after` set.
    pub before: bool,
    /// The step after this one will be taken with `before` set.
    pub after: bool,
}

/// A method that takes one step of a system with `D` states and `M` Brownian motions.
///
/// A step owns no clock, no storage and no randomness: time, increment and memory come from outside. The bound that an
/// implementation puts on `S` names what it needs: any [`Sde`](crate::Sde), one with additive noise, or the parts of a
/// [`SecondOrder`](crate::SecondOrder) system.
pub trait Integrator<S: ?Sized, const D: usize, const M: usize>: Sync {
    /// What the method keeps of a path between steps, other than its state: the last normal, the last iterate.
    type Memory: Default + Clone + Send;

    /// Whether the method looks at [`Increment::space_time_area`]. Where it does not, an ensemble does not draw it.
    const USES_AREA: bool = true;

    /// Move `x` from `t` to `t + dt`, along the increment `dw` over that step.
    ///
    /// # Errors
    /// Where the method cannot take the step. A non-finite result is no error here; whoever drives the steps checks.
    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<M>,
        x: &mut [f64; D],
        memory: &mut Self::Memory,
    ) -> Result<(), StepError>;

    /// Move [`LANES`] paths of an ensemble, whose memories have seen the same steps: to the bit what [`step`](Self::step)
    /// does with each. A step that is not possible is told to `failed`, with its lane.
    ///
    /// Provided: a loop over the lanes, which the compiler turns into vector instructions where step and system are
    /// inlined and have no branch. A method that does something once for all lanes does it here.
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

    /// The same for a step whose ends may meet others: to roundoff what [`step_lanes`](Self::step_lanes) does, once all
    /// joints are closed.
    ///
    /// Provided: [`step_lanes`](Self::step_lanes), for a method that has nothing to join.
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

/// Make a method that advances `(q, v)` an integrator of the state `(q_1.., v_1..)`, for 1, 2 and 3 degrees of freedom.
macro_rules! integrate_second_order {
    ($method:ty { $($n:literal => $d:literal, $memory:ty;)+ }) => { $(
        impl<S, const M: usize> $crate::integrator::Integrator<S, $d, M> for $method
        where
            S: $crate::system::SecondOrder<$n, M> + ?Sized,
        {
            type Memory = $memory;

            #[inline]
            fn step(
                &self,
                system: &S,
                t: f64,
                dt: f64,
                dw: &$crate::noise::Increment<M>,
                x: &mut [f64; $d],
                memory: &mut Self::Memory,
            ) -> Result<(), $crate::error::StepError> {
                let mut q = std::array::from_fn(|k| x[k]);
                let mut v = std::array::from_fn(|k| x[$n + k]);
                Self::advance::<S, $n, M>(system, (t, dt), dw, (&mut q, &mut v), memory);
                x[..$n].copy_from_slice(&q);
                x[$n..].copy_from_slice(&v);
                Ok(())
            }
        }
    )+ };
}
pub(crate) use integrate_second_order;

/// The same for a method that does part of a step once for all paths of an ensemble: `prepare(system, t, dt, joints,
/// memory)` gives what `advance` needs of time, step length and system, whatever the path. Where no step has come before,
/// `open(system, t, dt, q, v)` does first what `advance` leaves to do at such a joint.
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
                dw: &$crate::noise::Increment<M>,
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
                dw: &$crate::lane_increments::LaneIncrements<M>,
                x: &mut [[f64; $crate::lane_increments::LANES]; $d],
                memory: &mut [Self::Memory; $crate::lane_increments::LANES],
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
                dw: &$crate::lane_increments::LaneIncrements<M>,
                x: &mut [[f64; $crate::lane_increments::LANES]; $d],
                memory: &mut [Self::Memory; $crate::lane_increments::LANES],
                _failed: &mut dyn FnMut(usize, $crate::error::StepError),
            ) {
                // All have seen the same steps: the first memory is that of every lane.
                let prepared = Self::prepare::<S, $n, M>(system, (t, dt), joints, &mut memory[0]);
                // A loop of its own: within the other, it would be computed and thrown away where there is a joint.
                if !joints.before {
                    for lane in 0..$crate::lane_increments::LANES {
                        let mut q = std::array::from_fn(|k| x[k][lane]);
                        let mut v = std::array::from_fn(|k| x[$n + k][lane]);
                        Self::open::<S, $n, M>(system, (t, dt), (&mut q, &mut v));
                        for k in 0..$n {
                            x[k][lane] = q[k];
                            x[$n + k][lane] = v[k];
                        }
                    }
                }
                for lane in 0..$crate::lane_increments::LANES {
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

/// `g w`: the increments of the Brownian motions as they act on each row.
#[allow(clippy::inline_always, reason = "it stands in loops over lanes")]
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
