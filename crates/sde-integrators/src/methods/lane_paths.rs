//! What a guided ensemble simulates: [`LANES`] paths at a time, of a small state or of a state of any length.

use crate::error::StepError;
use crate::integrator::{Integrator, Joints};
use crate::noise::lane_increments::{LANES, LaneIncrements};

/// Paths in lanes, driven by `M` Brownian motions: a system with a method that takes its steps.
///
/// States are rows of [`LANES`] values, one row for each state: an array where their number is known at compile time,
/// otherwise a vector.
pub trait LanePaths<const M: usize>: Sync {
    /// The states of [`LANES`] paths.
    type States: AsRef<[[f64; LANES]]> + AsMut<[[f64; LANES]]> + Clone;
    /// Data of the paths kept between steps, other than their states.
    type Memory;

    /// Whether the method uses [`LaneIncrements::space_time_area`].
    const USES_AREA: bool;

    /// States of zero, and the memory before the first step.
    fn start(&self) -> (Self::States, Self::Memory);

    /// Advances the paths by a step; `failed` receives lane and error of a path whose step failed.
    #[allow(clippy::too_many_arguments, reason = "those of a step in lanes, as in Integrator")]
    fn step(
        &self,
        joints: Joints,
        t: f64,
        dt: f64,
        dw: &LaneIncrements<M>,
        x: &mut Self::States,
        memory: &mut Self::Memory,
        failed: &mut dyn FnMut(usize, StepError),
    );
}

/// Paths of a system with `D` states by any [`Integrator`].
#[derive(Debug)]
pub struct SmallPaths<'a, S: ?Sized, I, const D: usize> {
    /// The system.
    pub system: &'a S,
    /// The method.
    pub integrator: &'a I,
}

impl<S, I, const D: usize, const M: usize> LanePaths<M> for SmallPaths<'_, S, I, D>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
{
    type States = [[f64; LANES]; D];
    type Memory = [I::Memory; LANES];

    const USES_AREA: bool = I::USES_AREA;

    fn start(&self) -> (Self::States, Self::Memory) {
        ([[0.0; LANES]; D], std::array::from_fn(|_| I::Memory::default()))
    }

    #[allow(
        clippy::inline_always,
        reason = "what is not inlined into a dispatched function is not compiled for its registers"
    )]
    #[inline(always)]
    fn step(
        &self,
        joints: Joints,
        t: f64,
        dt: f64,
        dw: &LaneIncrements<M>,
        x: &mut Self::States,
        memory: &mut Self::Memory,
        failed: &mut dyn FnMut(usize, StepError),
    ) {
        self.integrator.step_lanes_joined(joints, self.system, t, dt, dw, x, memory, failed);
    }
}
