//! The deviator of the stress.

mod elastic_shear;
mod fluid;
mod johnson_cook;
mod johnson_cook_damage;
mod johnson_cook_return;
mod johnson_cook_state;
mod von_mises;

use perturbation_moments::{Real, Scalar, when};

use crate::error::Fault;
use crate::tensor::Symmetric;
use crate::{LocalFlow, Now, Observed};

pub use elastic_shear::{ElasticShear, ElasticShearParameters};
pub use fluid::Fluid;
pub use johnson_cook::{JohnsonCook, JohnsonCookParameters};
pub use johnson_cook_damage::{
    JohnsonCookDamage, JohnsonCookDamageParameters, JohnsonCookDamageState,
};
pub use johnson_cook_state::JohnsonCookState;
pub use von_mises::{VonMises, VonMisesParameters, VonMisesState};

/// How a material resists a change of shape.
pub trait Strength<S: Real>: std::fmt::Debug + Send + Sync {
    /// What a particle remembers.
    type State: Copy + std::fmt::Debug + Send + Sync;

    /// A particle at `t = 0`.
    fn start(&self) -> Self::State
    where
        S: Scalar;

    /// Advances the deviator over a step; its work per reference volume (stress).
    ///
    /// # Errors
    /// Where the state leaves the range of the model.
    fn update(&self, now: &Now<S>, state: &mut Self::State) -> Result<S, Fault>;

    /// The deviator of the stress, after [`carry`](Self::carry) (stress); `None` for none at all.
    fn deviator(&self, state: &Self::State) -> Option<Symmetric<S>>;

    /// The shear modulus in the present state (stress); `None` where no shear wave runs.
    fn shear_modulus(&self, state: &Self::State) -> Option<S>;

    /// What can be observed; the energy is left at zero.
    fn observe(&self, state: &Self::State) -> Observed<S>
    where
        S: Scalar;

    /// The flow stress at a plastic strain, rate and temperature that are taken for certain; `None` where nothing yields.
    fn flow_at(&self, _observed: &Observed<f64>) -> Option<LocalFlow<S>>
    where
        S: Scalar,
    {
        None
    }

    /// Calls with every number that a state is made of, always in the same order: what is written there is the new state.
    /// Snapshots need it; false, the default of states that hold anything, says that there can be none.
    #[inline(always)]
    fn visit_numbers(&self, _state: &mut Self::State, _visit: impl FnMut(&mut S)) -> bool {
        size_of::<Self::State>() == 0
    }

    /// Calls with every number that it is made of, with those that follow from others, always in the same order: what is written
    /// there is the new number. [`Varying`](crate::Varying) needs it; false, the default, says that not all that may differ
    /// between particles is shown.
    #[inline(always)]
    fn visit_constants(&mut self, _visit: impl FnMut(&mut S)) -> bool {
        false
    }

    /// The least pressure that the material bears in the present state, `None` for any: what has failed bears no tension.
    #[inline(always)]
    fn least_pressure(&self, _state: &Self::State) -> Option<S> {
        None
    }

    /// The pressure that the material bears at the end of the step, given the one that its equation of state asks for: what
    /// has failed bears no tension.
    ///
    /// # Errors
    /// Where the state leaves the range of the model.
    #[inline(always)]
    fn carry(&self, pressure: S, _state: &mut Self::State) -> Result<S, Fault> {
        Ok(pressure)
    }
}

/// What an overshoot of the yield surface must exceed to count, relative to the flow stress: below it the derivatives of the
/// return at no plastic strain, `0^(n - 1)`, would not be finite.
pub(crate) const LEAST_OVERSHOOT: f64 = 1e-10;

/// The deviator that a step would lead to without yield (Chen et al. 2019, eq 13).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trial<S> {
    /// The deviator of the rate of deformation (1 per time).
    pub(crate) rate: Symmetric<S>,
    /// The old deviator, turned, and `2 G dt` times the rate.
    pub(crate) deviator: Symmetric<S>,
}

impl<S: Real> Trial<S> {
    #[inline(always)]
    pub(crate) fn new(now: &Now<S>, before: &Symmetric<S>, shear_modulus: S) -> Self {
        let rate = Symmetric::part_of(&now.velocity_gradient).deviator();
        let turned = before.turned(&now.velocity_gradient, now.dt);
        Self { rate, deviator: turned + rate.scaled(shear_modulus * (2.0 * now.dt)) }
    }

    /// The trial von Mises stress (eq 14). At a stress of zero, where it has no derivative, a constant zero.
    ///
    /// # Errors
    /// Where it is not finite.
    #[inline(always)]
    pub(crate) fn equivalent(&self, shear_modulus: S) -> Result<S, Fault> {
        let square = self.deviator.square();
        let scale = shear_modulus.primal() * 1e-20;
        Fault::unless(
            square.is_finite(),
            square,
            "the square of the trial deviator",
            "finite: the rate of deformation is out of range",
        )?;
        let is_stressed = (scale * scale).less(square.primal());
        Ok(when!(is_stressed, (square * 1.5).sqrt(), square.splat(0.0)))
    }

    /// `(S_n + S_{n+1})/2 : D dt`, per reference volume.
    #[inline(always)]
    pub(crate) fn work(&self, now: &Now<S>, before: &Symmetric<S>, after: &Symmetric<S>) -> S {
        let volume = (now.volume_before + now.volume) * (0.25 * now.dt);
        (*before + *after).contract(&self.rate) * volume
    }
}

#[cfg(test)]
pub(crate) mod laws {
    use perturbation_moments::Scalar;

    use super::Now;

    /// A step of pure shear deformation `diag(r, -r/2, -r/2)`, whose equivalent rate is `r`, at constant volume.
    pub(crate) fn stretching<S: Scalar>(rate: f64, dt: f64) -> Now<S> {
        let c = S::constant;
        let zero = c(0.0);
        Now {
            velocity_gradient: [
                [c(rate), zero, zero],
                [zero, c(-0.5 * rate), zero],
                [zero, zero, c(-0.5 * rate)],
            ],
            dt,
            time: 0.0,
            volume_before: c(1.0),
            volume: c(1.0),
            viscosity: zero,
            cell: 1.0,
        }
    }
}
