//! What a particle of a Johnson-Cook metal remembers.

use perturbation_moments::Real;

use crate::tensor::Symmetric;

/// What a particle of a [`JohnsonCook`](super::JohnsonCook) material remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JohnsonCookState<S> {
    /// The deviator (stress).
    pub deviator: Symmetric<S>,
    /// The equivalent plastic strain.
    pub plastic_strain: S,
    /// The homologous temperature.
    pub homologous_temperature: S,
    /// The flow stress at the rate of the last step (stress).
    pub flow_stress: S,
    /// The trial von Mises stress less the flow stress at the last step (stress).
    pub overshoot: S,
    /// `eps_p^n`: an elastic step takes no power.
    pub(super) hardening: S,
    /// `1 - T*^m`, likewise.
    pub(super) softening: S,
}

impl<S: Real> JohnsonCookState<S> {
    /// `inside` in the lanes where the mask is true, `outside` in the others.
    #[inline(always)]
    pub(crate) fn select(mask: S::Mask, inside: &Self, outside: &Self) -> Self {
        Self {
            deviator: Symmetric::select(mask, &inside.deviator, &outside.deviator),
            plastic_strain: S::select(mask, inside.plastic_strain, outside.plastic_strain),
            homologous_temperature: S::select(
                mask,
                inside.homologous_temperature,
                outside.homologous_temperature,
            ),
            flow_stress: S::select(mask, inside.flow_stress, outside.flow_stress),
            overshoot: S::select(mask, inside.overshoot, outside.overshoot),
            hardening: S::select(mask, inside.hardening, outside.hardening),
            softening: S::select(mask, inside.softening, outside.softening),
        }
    }
}
