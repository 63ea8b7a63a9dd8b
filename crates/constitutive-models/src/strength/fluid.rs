//! No strength.

use perturbation_moments::{Real, Scalar};

use super::Strength;
use crate::error::Fault;
use crate::tensor::Symmetric;
use crate::{Now, Observed, StrengthFamily};

/// A material that bears pressure only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Fluid;

impl<S: Real> Strength<S> for Fluid {
    type State = ();

    fn start(&self)
    where
        S: Scalar,
    {
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, _state: &mut ()) -> Result<S, Fault> {
        Ok(now.volume.splat(0.0))
    }

    #[inline(always)]
    fn deviator(&self, _state: &()) -> Option<Symmetric<S>> {
        None
    }

    #[inline(always)]
    fn shear_modulus(&self, _state: &()) -> Option<S> {
        None
    }

    #[inline(always)]
    fn observe(&self, _state: &()) -> Observed<S>
    where
        S: Scalar,
    {
        Observed::of_energy(S::constant(0.0))
    }
}

impl<F: Scalar> StrengthFamily<F> for Fluid {
    type In<S: Real> = Self;

    #[inline(always)]
    fn in_numbers<S: Real>(&self, _of: impl Fn(F) -> S + Copy) -> Self {
        Self
    }

    #[inline(always)]
    fn filled<S: Real>(&self, _number: S) {}
}
