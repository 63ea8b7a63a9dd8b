//! The trait that turns a particle's history into its stress.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::{Real, Scalar};

use crate::error::Fault;
use crate::local::{LocalResponse, LocalState};
use crate::observed::Observed;
use crate::tensor::Symmetric;

/// What a step does to a particle: all that a material may look at.
#[derive(Debug, Clone, Copy)]
pub struct Now<S> {
    /// `L_ij = dv_i/dx_j` over the step (1 per unit of time).
    pub velocity_gradient: [[S; 3]; 3],
    /// The step (time).
    pub dt: f64,
    /// Time at the end of the step.
    pub time: f64,
    /// `V/V_0` before the step.
    pub volume_before: S,
    /// `V/V_0` after it, above zero.
    pub volume: S,
    /// `q >= 0`, the bulk viscosity, which acts as a pressure and whose work heats the particle (stress).
    pub viscosity: S,
    /// The edge of a grid cell (length).
    pub cell: f64,
}

/// A constitutive model. Stresses are those of Cauchy, tension positive.
///
/// It is pure in the state: the same history gives a bitwise identical result. Branches look at values, so that a jet takes the path
/// of the run it differentiates: [`Scalar::value`] where `S` is one number, masks where the text is to serve several particles at
/// once ([`MaterialFamily`](crate::MaterialFamily)).
pub trait Material<S: Real>: std::fmt::Debug + Send + Sync {
    /// What a particle remembers.
    type State: Copy + std::fmt::Debug + Send + Sync;

    /// `rho_0 > 0`, the density of the reference state (mass per volume).
    fn density(&self) -> S;

    /// The density of a particle with this state, where `usual` is that of the material.
    #[doc(hidden)]
    #[inline(always)]
    fn density_of(&self, _state: &Self::State, usual: S) -> S {
        usual
    }

    /// The state of a particle at `t = 0`; `position` has zeros beyond the dimension.
    fn start(&self, position: [f64; 3]) -> Self::State
    where
        S: Scalar;

    /// The stress at `t = 0`; none unless the material says otherwise.
    fn start_stress(&self, _state: &Self::State) -> Symmetric<S>
    where
        S: Scalar,
    {
        Symmetric::zero()
    }

    /// Advances the state over a step; the stress at its end, without the bulk viscosity.
    ///
    /// # Errors
    /// Where the state leaves the range of the model: what, its value, and what it must be. The state is then of no use.
    fn update(&self, now: &Now<S>, state: &mut Self::State) -> Result<Symmetric<S>, Fault>;

    /// `sqrt((K + 4G/3)/rho)`, the speed of a longitudinal wave in the present state: what limits the step and scales the
    /// linear bulk viscosity. `volume` is `V/V_0`.
    fn wave_speed(&self, volume: S, state: &Self::State) -> S;

    /// What can be observed of a state besides the stress.
    fn observe(&self, state: &Self::State) -> Observed<S>
    where
        S: Scalar;

    /// `e`, internal energy per reference volume (stress): that of [`observe`](Self::observe), which every step asks for.
    #[inline(always)]
    fn energy(&self, state: &Self::State) -> S
    where
        S: Scalar,
    {
        self.observe(state).energy
    }

    /// Pressure and flow stress by the formulas of the model at a state that is taken for certain: the derivatives of Chen et
    /// al. (2019, eq 31-35), which leave out that the state depends on the parameters too. `None` where the model has no such
    /// formulas.
    fn at_local_state(&self, _state: &LocalState) -> Option<LocalResponse<S>>
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

    /// The same for those numbers of a state that a step may change: the first of them.
    #[doc(hidden)]
    #[inline(always)]
    fn visit_changing(&self, state: &mut Self::State, visit: impl FnMut(&mut S)) {
        let _ = self.visit_numbers(state, visit);
    }

    /// Calls with every number that it is made of, with those that follow from others, always in the same order: what is written
    /// there is the new number. [`Varying`](crate::Varying) needs it; false, the default, says that not all that may differ
    /// between particles is shown.
    #[inline(always)]
    fn visit_constants(&mut self, _visit: impl FnMut(&mut S)) -> bool {
        false
    }
}
