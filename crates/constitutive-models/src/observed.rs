//! Observable quantities of a material besides its stress.

use perturbation_moments::Scalar;

/// What a material shows of itself. A quantity that it does not have is zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed<S> {
    /// `e`, internal energy per reference volume (stress).
    pub energy: S,
    /// The equivalent plastic strain.
    pub plastic_strain: S,
    /// The present flow stress (stress); zero where nothing yields.
    pub flow_stress: S,
    /// Temperature above that of the reference state.
    pub temperature: S,
    /// Damage, from 0 to 1.
    pub damage: S,
    /// The trial von Mises stress less the flow stress at the last step: yield where positive. How near zero it is in terms of
    /// its own derivatives says whether a sample would have switched.
    pub overshoot: S,
}

impl<S: Scalar> Observed<S> {
    /// A material without plasticity.
    #[must_use]
    pub fn of_energy(energy: S) -> Self {
        let zero = S::constant(0.0);
        Self {
            energy,
            plastic_strain: zero,
            flow_stress: zero,
            temperature: zero,
            damage: zero,
            overshoot: zero,
        }
    }
}
