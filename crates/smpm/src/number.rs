//! The number type of a run.

use std::any::Any;

use lanes::{dispatch, dispatch_narrow};
use perturbation_moments::{Gradient, Scalar};

/// A number that particles and nodes carry: `f64`, or a [`Jet`](perturbation_moments::Jet), which carries the derivatives of
/// its history, or a [`Gradient`]. Any [`Scalar`] that threads may share becomes one by `impl Number for MyScalar {}`.
pub trait Number: Scalar + std::fmt::Debug + Send + Sync + 'static {
    /// The dimensions in which the step is compiled with this crate; in others it is compiled with who runs it.
    #[doc(hidden)]
    const COMPILED: &'static [usize] = &[];

    /// The step of a simulation with such numbers, in one of these dimensions.
    #[doc(hidden)]
    fn compiled_step(_dimension: usize) -> &'static (dyn Any + Send + Sync) {
        &()
    }
}

impl Number for Gradient {}

/// Whether the step is compiled with this crate.
pub(crate) const fn is_compiled<S: Number>(dimension: usize) -> bool {
    let mut k = 0;
    while k < S::COMPILED.len() {
        if S::COMPILED[k] == dimension {
            return true;
        }
        k += 1;
    }
    false
}

/// Whether a value is finite, by one comparison: `is_finite` beside others becomes a test of bits, of twenty instructions.
#[inline(always)]
#[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
pub(crate) fn is_finite(value: f64) -> bool {
    value.abs() <= f64::MAX
}

/// Whether it is as small as an `f64`, of which a register takes several: a constant, for choices between paths that say the same.
pub(crate) const fn is_plain<S>() -> bool {
    size_of::<S>() == size_of::<f64>()
}

/// Runs work on nodes compiled for the registers that suit its numbers: four plain ones are those of a node in the plane.
#[inline(always)]
#[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
pub(crate) fn in_registers_of<S, R>(work: impl FnMut() -> R) -> R {
    if const { is_plain::<S>() } { dispatch_narrow(work) } else { dispatch(work) }
}
