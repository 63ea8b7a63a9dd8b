//! The number type of a run.

use perturbation_moments::{Jet, LANES, Scalar};

use self::sealed::Carried;

/// A number that particles and nodes carry: `f64`, or a [`Jet`], which carries the derivatives of its history.
///
/// A material may be computed with any [`Scalar`]; a run takes one of these two. Shape functions are `f64` in the transfer, with
/// their derivatives.
pub trait CarriedNumber: Scalar + Carried + std::fmt::Debug + Send + Sync + 'static {}

impl<S: Scalar + Carried + std::fmt::Debug + Send + Sync + 'static> CarriedNumber for S {}

/// What the transfer knows of a number; it keeps [`CarriedNumber`] to the types for which that is written.
pub(crate) mod sealed {
    use perturbation_moments::LANES;

    /// A number whose derivatives the transfer knows.
    pub trait Carried: Sized {
        /// Highest order of its derivatives.
        const ORDER: usize;

        /// The value, to be written.
        fn value_mut(&mut self) -> &mut f64;

        /// Derivatives of an order along all directions.
        fn derivatives(&self, order: usize) -> Option<&[f64; LANES]>;

        /// The same, to be written.
        fn derivatives_mut(&mut self, order: usize) -> Option<&mut [f64; LANES]>;

        /// How many `f64` it is made of.
        const PARTS: usize;

        /// Part number `part`.
        fn part(&self, part: usize) -> f64;

        /// From its parts: `part(k)` is number `k`.
        fn from_parts(part: impl Fn(usize) -> f64) -> Self;
    }
}

#[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
impl Carried for f64 {
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

    const PARTS: usize = 1;

    fn part(&self, _part: usize) -> f64 {
        *self
    }

    fn from_parts(part: impl Fn(usize) -> f64) -> Self {
        part(0)
    }
}

#[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
impl Carried for Jet {
    const ORDER: usize = 2;

    #[inline(always)]
    fn value_mut(&mut self) -> &mut f64 {
        &mut self.value
    }

    #[inline(always)]
    fn derivatives(&self, order: usize) -> Option<&[f64; LANES]> {
        match order {
            1 => Some(&self.first),
            2 => Some(&self.second),
            _ => None,
        }
    }

    #[inline(always)]
    fn derivatives_mut(&mut self, order: usize) -> Option<&mut [f64; LANES]> {
        match order {
            1 => Some(&mut self.first),
            2 => Some(&mut self.second),
            _ => None,
        }
    }

    const PARTS: usize = 1 + 2 * LANES;

    fn part(&self, part: usize) -> f64 {
        match part {
            0 => self.value,
            _ if part <= LANES => self.first[part - 1],
            _ => self.second[part - 1 - LANES],
        }
    }

    fn from_parts(part: impl Fn(usize) -> f64) -> Self {
        Self {
            value: part(0),
            first: std::array::from_fn(|k| part(1 + k)),
            second: std::array::from_fn(|k| part(1 + LANES + k)),
        }
    }
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
