//! Johnson and Cook's fracture on top of their flow stress.

use perturbation_moments::Scalar;

use super::{JohnsonCook, JohnsonCookParameters, JohnsonCookState, Strength, StrengthKind};
use crate::error::{Error, Fault, finite, not_negative, positive};
use crate::material::{LocalFlow, Now, Observed};
use crate::tensor::Symmetric;

parameters! {
    /// What a [`JohnsonCookDamage`] needs besides a flow stress.
    JohnsonCookDamageParameters {
        /// `D1 >= 0` (no unit).
        d1,
        /// `D2 >= 0`; `D1 + D2` above zero (no unit).
        d2,
        /// `D3`, negative where tension embrittles (no unit).
        d3,
        /// `D4`, the effect of the rate (no unit).
        d4,
        /// `D5`, that of the temperature (no unit).
        d5,
        /// The tension at which a particle spalls, above zero (stress).
        spall_strength,
    }
}

/// A [`JohnsonCook`] metal that breaks.
///
/// $$ \varepsilon_f = \left( D_1 + D_2 e^{D_3 \sigma^\ast} \right) (1 + D_4 \ln \dot\varepsilon^\ast) (1 + D_5 T^\ast), \qquad
///    D = \sum \frac{\Delta\varepsilon_p}{\varepsilon_f}, \qquad \sigma^\ast = -p/\sigma_y $$
///
/// A particle fails where `D >= 1` or its tension reaches the spall strength. From then on it bears pressure, but no deviator and
/// no tension. Before, damage does not soften it.
///
/// Domain: $\sigma^\ast \le 1.5$, the range that the source fitted; above it 1.5 is taken.
///
/// Source: Johnson and Cook 1985.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JohnsonCookDamage<S> {
    flow: JohnsonCook<S>,
    parameters: JohnsonCookDamageParameters<S>,
}

/// What a particle of a [`JohnsonCookDamage`] material remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JohnsonCookDamageState<S> {
    /// Of the flow stress.
    pub flow: JohnsonCookState<S>,
    /// `D`, from 0 to 1.
    pub damage: S,
    /// Whether it has failed.
    pub failed: bool,
    /// The plastic strain of this step over the factors of rate and temperature, until the pressure is known.
    pending: S,
}

/// The largest triaxiality for which the source gives the strain at fracture.
const LARGEST_TRIAXIALITY: f64 = 1.5;

impl<S: Scalar> JohnsonCookDamage<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// As [`JohnsonCook::new`]; [`Error::Negative`] for `D1` and `D2`, [`Error::NotPositive`] for their sum and the spall
    /// strength, [`Error::NotFinite`] for the others.
    pub fn new(
        flow: JohnsonCookParameters<S>,
        parameters: JohnsonCookDamageParameters<S>,
    ) -> Result<Self, Error> {
        let p = &parameters;
        not_negative("d1", p.d1.value())?;
        not_negative("d2", p.d2.value())?;
        positive("d1 + d2", (p.d1 + p.d2).value())?;
        finite("d3", p.d3.value())?;
        finite("d4", p.d4.value())?;
        finite("d5", p.d5.value())?;
        positive("spall strength", p.spall_strength.value())?;
        Ok(Self { flow: JohnsonCook::new(flow)?, parameters })
    }

    /// Refuses a factor of the strain at fracture that is not above zero.
    fn above_zero(quantity: &'static str, factor: S) -> Result<S, Fault> {
        let value = factor.value();
        if value > 0.0 {
            Ok(factor)
        } else {
            Err(Fault { quantity, value, must: "greater than 0" })
        }
    }
}

impl<S: Scalar + std::fmt::Debug + Send + Sync> Strength<S> for JohnsonCookDamage<S> {
    type State = JohnsonCookDamageState<S>;

    const KIND: StrengthKind = StrengthKind::JohnsonCookDamage;

    fn start(&self) -> JohnsonCookDamageState<S> {
        let zero = S::constant(0.0);
        JohnsonCookDamageState {
            flow: self.flow.start(),
            damage: zero,
            failed: false,
            pending: zero,
        }
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, state: &mut JohnsonCookDamageState<S>) -> Result<S, Fault> {
        let zero = S::constant(0.0);
        state.pending = zero;
        if state.failed {
            return Ok(zero);
        }
        let (strain, temperature) = (state.flow.plastic_strain, state.flow.homologous_temperature);
        let work = self.flow.update(now, &mut state.flow)?;
        let increment = state.flow.plastic_strain - strain;
        if increment.value() > 0.0 {
            let p = &self.parameters;
            let rate = Symmetric::part_of(&now.velocity_gradient).deviator();
            let by_rate = p.d4 * self.flow.log_rate(&rate) + 1.0;
            let by_heat = p.d5 * temperature + 1.0;
            state.pending = increment
                / (Self::above_zero("1 + D4 ln(rate) of the strain at fracture", by_rate)?
                    * Self::above_zero("1 + D5 T of the strain at fracture", by_heat)?);
        }
        Ok(work)
    }

    #[inline(always)]
    fn carry(&self, pressure: S, state: &mut JohnsonCookDamageState<S>) -> Result<S, Fault> {
        let p = &self.parameters;
        let flow = state.flow.flow_stress;
        if !state.failed && state.pending.value() > 0.0 && flow.value() > 0.0 {
            let triaxiality = pressure / flow * -1.0;
            let triaxiality = if triaxiality.value() > LARGEST_TRIAXIALITY {
                S::constant(LARGEST_TRIAXIALITY)
            } else {
                triaxiality
            };
            let by_triaxiality = p.d1 + p.d2 * (p.d3 * triaxiality).exp();
            let strain =
                Self::above_zero("D1 + D2 exp(D3 s) of the strain at fracture", by_triaxiality)?;
            state.damage = state.damage + state.pending / strain;
        }
        let spalls = -pressure.value() >= p.spall_strength.value();
        if !state.failed && (state.damage.value() >= 1.0 || spalls) {
            state.failed = true;
            state.damage = S::constant(1.0);
            state.flow.deviator = Symmetric::zero();
            state.flow.flow_stress = S::constant(0.0);
            state.flow.overshoot = S::constant(0.0);
        }
        Ok(if state.failed && pressure.value() < 0.0 { S::constant(0.0) } else { pressure })
    }

    #[inline(always)]
    fn deviator(&self, state: &JohnsonCookDamageState<S>) -> Symmetric<S> {
        state.flow.deviator
    }

    #[inline(always)]
    fn shear_modulus(&self, state: &JohnsonCookDamageState<S>) -> S {
        if state.failed { S::constant(0.0) } else { self.flow.shear_modulus(&state.flow) }
    }

    #[inline(always)]
    fn observe(&self, state: &JohnsonCookDamageState<S>) -> Observed<S> {
        Observed { damage: state.damage, ..self.flow.observe(&state.flow) }
    }

    fn flow_at(&self, observed: &Observed<f64>) -> Option<LocalFlow<S>> {
        self.flow.flow_at(observed).filter(|_| observed.damage < 1.0)
    }

    fn visit_numbers(
        &self,
        state: &mut JohnsonCookDamageState<S>,
        visit: &mut dyn FnMut(&mut S),
    ) -> bool {
        let mut failed = S::constant(f64::from(u8::from(state.failed)));
        visit(&mut state.damage);
        visit(&mut state.pending);
        visit(&mut failed);
        state.failed = failed.value() != 0.0;
        self.flow.visit_numbers(&mut state.flow, visit)
    }
}

#[cfg(test)]
mod tests {
    use super::super::laws::stretching;
    use super::*;

    /// Megapascal, second; no rate, no heat, no hardening: the damage has a closed form.
    const FLOW: JohnsonCookParameters<f64> = JohnsonCookParameters {
        shear_modulus: 77500.0,
        a: 800.0,
        b: 0.0,
        n: 0.26,
        c: 0.0,
        m: 1.03,
        reference_rate: 1.0,
        rate_floor: 1.0,
        room_temperature: 294.0,
        melting_temperature: 1793.0,
        taylor_quinney: 0.0,
        density: 7830.0,
        specific_heat: 477.0e-6,
    };

    const DAMAGE: JohnsonCookDamageParameters<f64> = JohnsonCookDamageParameters {
        d1: 0.05,
        d2: 3.44,
        d3: -2.12,
        d4: 0.002,
        d5: 0.61,
        spall_strength: 2500.0,
    };

    #[test]
    fn at_constant_triaxiality_it_fails_at_the_strain_at_fracture() {
        let material = JohnsonCookDamage::new(FLOW, DAMAGE).unwrap();
        let mut state = material.start();
        let (pressure, rate, dt) = (-640.0, 100.0, 1e-5);
        let fracture = (0.05 + 3.44 * (-2.12_f64 * 0.8).exp()) * (1.0 + 0.002 * 100.0_f64.ln());
        let mut steps = 0;
        while !state.failed {
            steps += 1;
            assert!(steps < 10_000);
            material.update(&stretching(rate, dt), &mut state).unwrap();
            let carried = material.carry(pressure, &mut state).unwrap();
            let expected = if state.failed { 0.0 } else { pressure };
            assert!((carried - expected).abs() < 1e-12);
        }
        // Up to the last step.
        let strain = state.flow.plastic_strain;
        assert!((strain - fracture).abs() <= rate * dt, "{strain} {fracture}");
        assert_eq!(material.deviator(&state), Symmetric::zero());
        assert_eq!(
            (material.carry(-5.0, &mut state), material.carry(5.0, &mut state)),
            (Ok(0.0), Ok(5.0))
        );
        // Nor does it bear anything later.
        assert_eq!(material.update(&stretching(rate, dt), &mut state), Ok(0.0));
        assert_eq!(material.deviator(&state), Symmetric::zero());
    }

    #[test]
    fn tension_at_the_spall_strength_breaks_it_at_once() {
        let material = JohnsonCookDamage::new(FLOW, DAMAGE).unwrap();
        let mut state = material.start();
        assert_eq!(material.carry(-2499.0, &mut state), Ok(-2499.0));
        assert_eq!(material.carry(-2501.0, &mut state), Ok(0.0));
        assert!(state.failed && material.observe(&state).damage >= 1.0);
    }

    #[test]
    fn a_strain_at_fracture_of_zero_is_a_fault() {
        let brittle = JohnsonCookDamageParameters { d4: -1.0, ..DAMAGE };
        let material = JohnsonCookDamage::new(FLOW, brittle).unwrap();
        let mut state = material.start();
        let result = material.update(&stretching(100.0, 1e-3), &mut state);
        assert!(result.unwrap_err().to_string().contains("D4"));
    }
}
