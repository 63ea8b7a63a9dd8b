//! No strength.

use perturbation_moments::Scalar;

use super::{Strength, StrengthKind};
use crate::error::Fault;
use crate::material::{Now, Observed};
use crate::tensor::Symmetric;

/// A material that bears pressure only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Fluid;

impl<S: Scalar> Strength<S> for Fluid {
    type State = ();

    const KIND: StrengthKind = StrengthKind::Fluid;

    fn start(&self) {}

    #[inline(always)]
    fn update(&self, _now: &Now<S>, _state: &mut ()) -> Result<S, Fault> {
        Ok(S::constant(0.0))
    }

    #[inline(always)]
    fn deviator(&self, _state: &()) -> Symmetric<S> {
        Symmetric::zero()
    }

    #[inline(always)]
    fn shear_modulus(&self, _state: &()) -> S {
        S::constant(0.0)
    }

    #[inline(always)]
    fn observe(&self, _state: &()) -> Observed<S> {
        Observed::of_energy(S::constant(0.0))
    }
}
