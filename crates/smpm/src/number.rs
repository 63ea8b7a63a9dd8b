//! The number type of a run.

use perturbation_moments::{Gradient, Jet, LANES, Scalar};

use self::sealed::Carried;

/// A number that particles and nodes carry: `f64`, or a [`Jet`] or [`Gradient`], which carries the derivatives of its history.
///
/// A material may be computed with any [`Scalar`]; a run takes one of these three. Shape functions are `f64` in the transfer, with
/// their derivatives.
pub trait Number: Scalar + Carried + std::fmt::Debug + Send + Sync + 'static {}

impl<S: Scalar + Carried + std::fmt::Debug + Send + Sync + 'static> Number for S {}

/// What the transfer knows of a number; it keeps [`Number`] to the types for which that is written.
pub(crate) mod sealed {
    use perturbation_moments::LANES;

    /// A number whose derivatives the transfer knows.
    pub trait Carried: Sized {
        /// Whether the step is compiled with this crate; else it is compiled with the program that runs it.
        const IS_COMPILED: bool;

        /// Highest order of its derivatives.
        const ORDER: usize;

        /// The value, to be written.
        fn value_mut(&mut self) -> &mut f64;

        /// Derivatives of an order along all directions.
        fn derivatives(&self, order: usize) -> Option<&[f64; LANES]>;

        /// The same, to be written.
        fn derivatives_mut(&mut self, order: usize) -> Option<&mut [f64; LANES]>;
    }
}

#[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
impl Carried for f64 {
    const IS_COMPILED: bool = true;
    const ORDER: usize = 0;

    #[inline(always)]
    fn value_mut(&mut self) -> &mut f64 {
        self
    }

    #[inline(always)]
    fn derivatives(&self, _order: usize) -> Option<&[f64; LANES]> {
        None
    }

    #[inline(always)]
    fn derivatives_mut(&mut self, _order: usize) -> Option<&mut [f64; LANES]> {
        None
    }
}

/// A number with derivatives, by order: `order => field`.
macro_rules! carried {
    ($number:ty, $is_compiled:expr, $highest:literal: $($order:pat => $field:ident),+) => {
        #[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
        impl Carried for $number {
            const IS_COMPILED: bool = $is_compiled;
            const ORDER: usize = $highest;

            #[inline(always)]
            fn value_mut(&mut self) -> &mut f64 {
                &mut self.value
            }

            #[inline(always)]
            fn derivatives(&self, order: usize) -> Option<&[f64; LANES]> {
                match order {
                    $($order => Some(&self.$field),)+
                    _ => None,
                }
            }

            #[inline(always)]
            fn derivatives_mut(&mut self, order: usize) -> Option<&mut [f64; LANES]> {
                match order {
                    $($order => Some(&mut self.$field),)+
                    _ => None,
                }
            }
        }
    };
}

carried!(Jet, true, 2: 1 => first, 2 => second);
carried!(Gradient, false, 1: 1 => first);

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
