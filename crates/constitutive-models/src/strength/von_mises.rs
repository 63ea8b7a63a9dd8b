//! Von Mises plasticity with linear hardening.

use perturbation_moments::{Real, Scalar};
use simd_lanes::Mask;

use super::{LEAST_OVERSHOOT, Strength, Trial};
use crate::error::{Error, Fault, not_negative, positive};
use crate::tensor::Symmetric;
use crate::{LocalFlow, Now, Observed, StrengthFamily};

parameters! {
    /// What a [`VonMises`] is made of.
    VonMisesParameters {
        /// `G > 0` (stress).
        shear_modulus,
        /// The flow stress at no plastic strain, above zero (stress).
        yield_stress,
        /// `H >= 0` (stress).
        hardening_modulus,
    }
}

/// A flow stress that grows linearly with the plastic strain, by radial return.
///
/// $$ \Delta\varepsilon_p = \frac{\sigma_{eq}^\ast - \sigma_y^n}{3G + H}, \qquad
///    \sigma_y^{n+1} = \sigma_y^n + H \Delta\varepsilon_p, \qquad
///    S^{n+1} = \frac{\sigma_y^{n+1}}{\sigma_{eq}^\ast} S^\ast $$
///
/// Symbols: $S^\ast$ = trial deviator, turned as in [`ElasticShear`](super::ElasticShear);
/// $\sigma_{eq}^\ast = \sqrt{\tfrac32 S^\ast : S^\ast}$ over all nine components.
///
/// Source: Chen et al. 2019, eq 13-20; eq 17 lacks the trial deviator in print.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VonMises<S> {
    parameters: VonMisesParameters<S>,
}

/// What a particle of a [`VonMises`] material remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VonMisesState<S> {
    /// The deviator (stress).
    pub deviator: Symmetric<S>,
    /// The equivalent plastic strain.
    pub plastic_strain: S,
    /// The trial von Mises stress less the flow stress at the last step (stress).
    pub overshoot: S,
}

impl<S: Scalar> VonMises<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for shear modulus and yield stress, [`Error::Negative`] for the hardening modulus.
    pub fn new(parameters: VonMisesParameters<S>) -> Result<Self, Error> {
        positive("shear modulus", parameters.shear_modulus.value())?;
        positive("yield stress", parameters.yield_stress.value())?;
        not_negative("hardening modulus", parameters.hardening_modulus.value())?;
        Ok(Self { parameters })
    }
}

impl<S: Real> VonMises<S> {
    #[inline(always)]
    fn flow(&self, plastic_strain: S) -> S {
        self.parameters.yield_stress + self.parameters.hardening_modulus * plastic_strain
    }
}

impl<S: Real> Strength<S> for VonMises<S> {
    type State = VonMisesState<S>;

    fn start(&self) -> VonMisesState<S>
    where
        S: Scalar,
    {
        let zero = S::constant(0.0);
        VonMisesState { deviator: Symmetric::zero(), plastic_strain: zero, overshoot: zero }
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, state: &mut VonMisesState<S>) -> Result<S, Fault> {
        let VonMisesParameters { shear_modulus, hardening_modulus, .. } = self.parameters;
        let before = state.deviator;
        let trial = Trial::new(now, &before, shear_modulus);
        let equivalent = trial.equivalent(shear_modulus)?;
        let flow = self.flow(state.plastic_strain);
        state.overshoot = equivalent - flow;
        state.deviator = trial.deviator;
        let yields = (flow.primal() * LEAST_OVERSHOOT).less(state.overshoot.primal());
        if yields.any() {
            let zero = flow.splat(0.0);
            let increment = state.overshoot / (shear_modulus * 3.0 + hardening_modulus);
            let increment = S::select(yields, increment, zero);
            state.plastic_strain = state.plastic_strain + increment;
            let factor = (flow + hardening_modulus * increment) / equivalent;
            let returned = trial.deviator.scaled(factor);
            state.deviator = Symmetric::select(yields, &returned, &trial.deviator);
        }
        Ok(trial.work(now, &before, &state.deviator))
    }

    #[inline(always)]
    fn deviator(&self, state: &VonMisesState<S>) -> Option<Symmetric<S>> {
        Some(state.deviator)
    }

    #[inline(always)]
    fn shear_modulus(&self, _state: &VonMisesState<S>) -> Option<S> {
        Some(self.parameters.shear_modulus)
    }

    #[inline(always)]
    fn observe(&self, state: &VonMisesState<S>) -> Observed<S>
    where
        S: Scalar,
    {
        Observed {
            plastic_strain: state.plastic_strain,
            flow_stress: self.flow(state.plastic_strain),
            overshoot: state.overshoot,
            ..Observed::of_energy(S::constant(0.0))
        }
    }

    fn flow_at(&self, observed: &Observed<f64>) -> Option<LocalFlow<S>>
    where
        S: Scalar,
    {
        Some(LocalFlow {
            stress: self.flow(S::constant(observed.plastic_strain)),
            hardening_modulus: self.parameters.hardening_modulus.value(),
            shear_modulus: self.parameters.shear_modulus.value(),
        })
    }

    #[inline(always)]
    fn visit_numbers(&self, state: &mut VonMisesState<S>, mut visit: impl FnMut(&mut S)) -> bool {
        let VonMisesState { deviator, plastic_strain, overshoot } = state;
        for k in 0..6 {
            visit(&mut deviator.0[k]);
        }
        visit(plastic_strain);
        visit(overshoot);
        true
    }

    shows_constants!();
}

family_member!(StrengthFamily, Strength: VonMises { }, number => VonMisesState {
    deviator: Symmetric([number; 6]),
    plastic_strain: number,
    overshoot: number,
});

#[cfg(test)]
mod tests {
    use perturbation_moments::Jet;

    use super::super::laws::stretching;
    use super::*;
    use crate::tensor::von_mises as equivalent_stress;

    const STEEL: VonMisesParameters<f64> = VonMisesParameters {
        shear_modulus: 77500.0,
        yield_stress: 800.0,
        hardening_modulus: 1500.0,
    };

    fn stretched<S: Scalar + std::fmt::Debug + Send + Sync>(
        p: VonMisesParameters<S>,
        strain: f64,
    ) -> VonMisesState<S> {
        let material = VonMises::new(p).unwrap();
        let mut state = material.start();
        for _ in 0..50 {
            material.update(&stretching(strain, 0.02), &mut state).unwrap();
        }
        state
    }

    #[test]
    fn monotonic_loading_has_a_closed_form() {
        // sigma = 3 G (eps - eps_p) = Y + H eps_p; the return is exact for any step.
        let state = stretched(STEEL, 0.05);
        let closed = (3.0 * 77500.0 * 0.05 - 800.0) / (3.0 * 77500.0 + 1500.0);
        assert!((state.plastic_strain - closed).abs() < 1e-14);
        let equivalent: f64 = equivalent_stress(&state.deviator);
        assert!((equivalent - (800.0 + 1500.0 * closed)).abs() < 1e-9);
        // Along x two thirds of it, the paper's bound on abs(S11)/sigma_y.
        assert!((state.deviator.0[0] / equivalent - 2.0 / 3.0).abs() < 1e-13);
    }

    #[test]
    fn jets_carry_the_derivatives_of_the_closed_form() {
        let state = stretched(
            VonMisesParameters {
                shear_modulus: Jet::variable(77500.0, 0),
                yield_stress: Jet::variable(800.0, 1),
                hardening_modulus: Jet::variable(1500.0, 2),
            },
            0.05,
        );
        let g = Jet::variable(77500.0, 0) * 3.0;
        let (y, h) = (Jet::variable(800.0, 1), Jet::variable(1500.0, 2));
        let closed = (g * 0.05 - y) / (g + h);
        for k in 0..3 {
            let scale = closed.first[k].abs();
            assert!((state.plastic_strain.first[k] - closed.first[k]).abs() < 1e-9 * scale);
            let difference = state.plastic_strain.second[k] - closed.second[k];
            assert!(difference.abs() < 1e-9 * (closed.second[k].abs() + scale * scale));
        }
    }
}
