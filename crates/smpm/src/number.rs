//! The number type of a run.

use std::any::Any;

use perturbation_moments::{Gradient, LANES, Scalar};
use simd_lanes::dispatch;

/// A number that particles and nodes carry: `f64`, or a [`Jet`](perturbation_moments::Jet), which carries the derivatives of
/// its history, or a [`Gradient`]. Any [`Scalar`] that threads may share becomes one by `impl Number for MyScalar {}`.
///
/// Shape functions of jets and gradients are `f64` in the transfer, with their derivatives (except with GIMP). For a type
/// of one's own they are numbers of this type; a jet by either way has the same values, and derivatives equal within roundoff.
pub trait Number: Scalar + std::fmt::Debug + Send + Sync + 'static {
    /// The dimensions in which the step is compiled with this crate; in others it is compiled with who runs it.
    #[doc(hidden)]
    const COMPILED: &'static [usize] = &[];

    /// The step of a simulation with such numbers, in one of these dimensions.
    #[doc(hidden)]
    fn compiled_step(_dimension: usize) -> &'static (dyn Any + Send + Sync) {
        &()
    }

    /// Highest order of the derivatives that it shows the step; zero where the step knows no more than its arithmetic. The next
    /// functions answer for orders from one to this.
    #[doc(hidden)]
    const ORDER: usize = 0;

    /// The value, to be written.
    #[doc(hidden)]
    fn value_mut(&mut self) -> Option<&mut f64> {
        None
    }

    /// Derivatives of an order along all directions.
    #[doc(hidden)]
    fn derivatives(&self, _order: usize) -> Option<&[f64; LANES]> {
        None
    }

    /// The same, to be written.
    #[doc(hidden)]
    fn derivatives_mut(&mut self, _order: usize) -> Option<&mut [f64; LANES]> {
        None
    }
}

/// Shows the derivatives of a number, by order: `order => field`.
macro_rules! show_derivatives {
    ($highest:literal: $($order:pat => $field:ident),+) => {
        const ORDER: usize = $highest;

        #[inline(always)]
        fn value_mut(&mut self) -> Option<&mut f64> {
            Some(&mut self.value)
        }

        #[inline(always)]
        fn derivatives(&self, order: usize) -> Option<&[f64; perturbation_moments::LANES]> {
            match order {
                $($order => Some(&self.$field),)+
                _ => None,
            }
        }

        #[inline(always)]
        fn derivatives_mut(
            &mut self,
            order: usize,
        ) -> Option<&mut [f64; perturbation_moments::LANES]> {
            match order {
                $($order => Some(&mut self.$field),)+
                _ => None,
            }
        }
    };
}
pub(crate) use show_derivatives;

#[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
impl Number for Gradient {
    show_derivatives!(1: 1 => first);
}

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

/// Runs work on one particle after the other: compiled for the registers of this machine where a number fills them. Those of `f64` are
/// in lanes, except for the few particles of a small body.
#[inline(always)]
#[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
pub(crate) fn one_by_one<S>(mut work: impl FnMut()) {
    if const { is_plain::<S>() } {
        work();
    } else {
        dispatch(work);
    }
}
