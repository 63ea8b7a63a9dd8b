//! Johnson and Cook's fracture on top of their flow stress.

use perturbation_moments::{Real, Scalar};
use simd_lanes::Mask;

use super::{JohnsonCook, JohnsonCookParameters, JohnsonCookState, Strength};
use crate::error::{Error, Fault, finite, not_negative, positive};
use crate::tensor::Symmetric;
use crate::{LocalFlow, Now, Observed, StrengthFamily};

parameters! {
    /// What a [`JohnsonCookDamage`] needs besides a flow stress.
    JohnsonCookDamageParameters {
        /// `D1`, of either sign; infinite for a particle that no strain breaks (no unit).
        d1,
        /// `D2 >= 0`; `D1 + D2`, the strain at fracture under shear, above zero (no unit).
        d2,
        /// `D3`, negative where tension embrittles (no unit).
        d3,
        /// `D4`, the effect of the rate (no unit).
        d4,
        /// `D5`, that of the temperature (no unit).
        d5,
        /// The tension at which a particle spalls, above zero; infinite for one that does not (stress).
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
/// Domain: $\sigma^\ast \le 1.5$, the range that the source fitted; above it 1.5 is taken. Cards with `D1 < 0` have a triaxiality
/// from which $D_1 + D_2 e^{D_3 \sigma^\ast}$ is not above zero: there `1e-6` is taken, so that the particle fails at the next
/// plastic strain.
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
    /// `D`, from 0 to 1: one where it has failed.
    pub damage: S,
    /// The plastic strain of this step over the factors of rate and temperature, until the pressure is known.
    pending: S,
}

/// The largest triaxiality for which the source gives the strain at fracture.
const LARGEST_TRIAXIALITY: f64 = 1.5;

/// The least strain at fracture by triaxiality, the customary one of programs that read such cards.
const LEAST_STRAIN_AT_FRACTURE: f64 = 1e-6;

impl JohnsonCookDamageParameters<f64> {
    /// The triaxiality from which `1e-6` is taken for `D1 + D2 exp(D3 eta)` (no unit); none where that is larger up to 1.5.
    #[must_use]
    pub fn brittle_from(&self) -> Option<f64> {
        let from = ((LEAST_STRAIN_AT_FRACTURE - self.d1) / self.d2).ln() / self.d3;
        (self.d3 < 0.0 && from < LARGEST_TRIAXIALITY).then_some(from)
    }
}

impl<S: Scalar> JohnsonCookDamage<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// As [`JohnsonCook::new`]; [`Error::Negative`] for `D2`, [`Error::NotPositive`] for `D1 + D2` and the spall strength,
    /// [`Error::NotFinite`] for the others.
    pub fn new(
        flow: JohnsonCookParameters<S>,
        parameters: JohnsonCookDamageParameters<S>,
    ) -> Result<Self, Error> {
        let p = &parameters;
        not_negative("d2", p.d2.value())?;
        if p.d1.value() != f64::INFINITY {
            finite("d1", p.d1.value())?;
            positive("d1 + d2", (p.d1 + p.d2).value())?;
        }
        finite("d3", p.d3.value())?;
        finite("d4", p.d4.value())?;
        finite("d5", p.d5.value())?;
        if p.spall_strength.value() != f64::INFINITY {
            positive("spall strength", p.spall_strength.value())?;
        }
        Ok(Self { flow: JohnsonCook::new(flow)?, parameters })
    }
}

/// Refuses a factor of the strain at fracture that is not above zero where the mask is true.
#[inline(always)]
fn above_zero<S: Real>(mask: S::Mask, quantity: &'static str, factor: S) -> Result<(), Fault> {
    let holds = factor.splat(0.0).less(factor).or(mask.not());
    Fault::unless(holds, factor, quantity, "greater than 0")
}

impl<S: Real> JohnsonCookDamageState<S> {
    /// Where it has failed.
    #[inline(always)]
    pub fn has_failed(&self) -> S::Mask {
        self.damage.at_least(self.damage.splat(1.0))
    }
}

impl<S: Real> Strength<S> for JohnsonCookDamage<S> {
    type State = JohnsonCookDamageState<S>;

    fn start(&self) -> JohnsonCookDamageState<S>
    where
        S: Scalar,
    {
        let zero = S::constant(0.0);
        JohnsonCookDamageState { flow: self.flow.start(), damage: zero, pending: zero }
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, state: &mut JohnsonCookDamageState<S>) -> Result<S, Fault> {
        let zero = now.volume.splat(0.0);
        state.pending = zero;
        let bears = state.has_failed().not();
        if !bears.any() {
            return Ok(zero);
        }
        let before = state.flow;
        let work = self.flow.update(now, &mut state.flow)?;
        state.flow = JohnsonCookState::select(bears, &state.flow, &before);
        let increment = state.flow.plastic_strain - before.plastic_strain;
        let yields = bears.and(zero.less(increment));
        if yields.any() {
            let p = &self.parameters;
            let rate = Symmetric::part_of(&now.velocity_gradient).deviator();
            let by_rate = p.d4 * self.flow.log_rate(&rate) + 1.0;
            let by_heat = p.d5 * before.homologous_temperature + 1.0;
            above_zero(yields, "1 + D4 ln(rate) of the strain at fracture", by_rate)?;
            above_zero(yields, "1 + D5 T of the strain at fracture", by_heat)?;
            state.pending = S::select(yields, increment / (by_rate * by_heat), zero);
        }
        Ok(S::select(bears, work, zero))
    }

    #[inline(always)]
    fn least_pressure(&self, state: &JohnsonCookDamageState<S>) -> Option<S> {
        let zero = state.damage.splat(0.0);
        Some(S::select(state.has_failed(), zero, zero.splat(f64::NEG_INFINITY)))
    }

    #[inline(always)]
    fn carry(&self, pressure: S, state: &mut JohnsonCookDamageState<S>) -> Result<S, Fault> {
        let p = &self.parameters;
        let (zero, one) = (pressure.splat(0.0), pressure.splat(1.0));
        let flow = state.flow.flow_stress;
        let bears = state.has_failed().not();
        let grows = bears.and(zero.less(state.pending)).and(zero.less(flow));
        if grows.any() {
            let triaxiality = pressure / flow * -1.0;
            let largest = pressure.splat(LARGEST_TRIAXIALITY);
            let triaxiality = S::select(largest.less(triaxiality), largest, triaxiality);
            let strain = p.d1 + p.d2 * (p.d3 * triaxiality).exp();
            let least = strain.splat(LEAST_STRAIN_AT_FRACTURE);
            let strain = S::select(strain.less(least), least, strain);
            let grown = state.damage + state.pending / strain;
            state.damage = S::select(grows, grown, state.damage);
        }
        let spalls = (pressure * -1.0).at_least(p.spall_strength);
        let fails = bears.and(state.has_failed().or(spalls));
        if fails.any() {
            state.damage = S::select(fails, one, state.damage);
            let (deviator, none) = (&mut state.flow.deviator, Symmetric::isotropic(zero));
            *deviator = Symmetric::select(fails, &none, deviator);
            state.flow.flow_stress = S::select(fails, zero, state.flow.flow_stress);
            state.flow.overshoot = S::select(fails, zero, state.flow.overshoot);
        }
        let is_slack = state.has_failed().and(pressure.less(zero));
        Ok(S::select(is_slack, zero, pressure))
    }

    #[inline(always)]
    fn deviator(&self, state: &JohnsonCookDamageState<S>) -> Option<Symmetric<S>> {
        Some(state.flow.deviator)
    }

    #[inline(always)]
    fn shear_modulus(&self, state: &JohnsonCookDamageState<S>) -> Option<S> {
        let whole = self.flow.shear_modulus(&state.flow)?;
        Some(S::select(state.has_failed(), whole.splat(0.0), whole))
    }

    #[inline(always)]
    fn observe(&self, state: &JohnsonCookDamageState<S>) -> Observed<S>
    where
        S: Scalar,
    {
        Observed { damage: state.damage, ..self.flow.observe(&state.flow) }
    }

    fn flow_at(&self, observed: &Observed<f64>) -> Option<LocalFlow<S>>
    where
        S: Scalar,
    {
        self.flow.flow_at(observed).filter(|_| observed.damage < 1.0)
    }

    #[inline(always)]
    fn visit_numbers(
        &self,
        state: &mut JohnsonCookDamageState<S>,
        mut visit: impl FnMut(&mut S),
    ) -> bool {
        visit(&mut state.damage);
        visit(&mut state.pending);
        self.flow.visit_numbers(&mut state.flow, &mut visit)
    }
}

impl<F: Scalar> StrengthFamily<F> for JohnsonCookDamage<F> {
    type In<S: Real> = JohnsonCookDamage<S>;

    #[inline(always)]
    fn in_numbers<S: Real>(&self, of: impl Fn(F) -> S + Copy) -> JohnsonCookDamage<S> {
        let parameters = self.parameters.map(
            #[inline(always)]
            |_, number| of(number),
        );
        JohnsonCookDamage { flow: self.flow.in_numbers(of), parameters }
    }

    #[inline(always)]
    fn filled<S: Real>(&self, number: S) -> JohnsonCookDamageState<S> {
        let flow = self.flow.filled(number);
        JohnsonCookDamageState { flow, damage: number, pending: number }
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
        while !state.has_failed() {
            steps += 1;
            assert!(steps < 10_000);
            material.update(&stretching(rate, dt), &mut state).unwrap();
            let carried = material.carry(pressure, &mut state).unwrap();
            let expected = if state.has_failed() { 0.0 } else { pressure };
            assert!((carried - expected).abs() < 1e-12);
        }
        // Up to the last step.
        let strain = state.flow.plastic_strain;
        assert!((strain - fracture).abs() <= rate * dt, "{strain} {fracture}");
        assert_eq!(material.deviator(&state), Some(Symmetric::zero()));
        assert_eq!(
            (material.carry(-5.0, &mut state), material.carry(5.0, &mut state)),
            (Ok(0.0), Ok(5.0))
        );
        // Nor does it bear anything later.
        assert_eq!(material.update(&stretching(rate, dt), &mut state), Ok(0.0));
        assert_eq!(material.deviator(&state), Some(Symmetric::zero()));
    }

    #[test]
    fn tension_at_the_spall_strength_breaks_it_at_once() {
        let material = JohnsonCookDamage::new(FLOW, DAMAGE).unwrap();
        let mut state = material.start();
        assert_eq!(material.carry(-2499.0, &mut state), Ok(-2499.0));
        assert_eq!(material.carry(-2501.0, &mut state), Ok(0.0));
        assert!(state.has_failed() && material.observe(&state).damage >= 1.0);
    }

    #[test]
    fn cards_below_zero_break_under_tension_and_an_infinite_strain_never_breaks() {
        // Above a triaxiality of 1.35 this card's strain at fracture is below zero.
        let card = JohnsonCookDamageParameters {
            d1: -0.77,
            d2: 1.45,
            d3: -0.47,
            d4: 0.0,
            d5: 0.0,
            spall_strength: f64::INFINITY,
        };
        let after_a_step = |parameters, pressure| {
            let material = JohnsonCookDamage::new(FLOW, parameters).unwrap();
            let mut state = material.start();
            material.update(&stretching(1e4, 2e-6), &mut state).unwrap();
            material.carry(pressure, &mut state).unwrap();
            (state.flow.plastic_strain, state.damage)
        };
        let (strain, damage) = after_a_step(card, -0.33 * 800.0);
        let at_fracture = -0.77 + 1.45 * (-0.47_f64 * 0.33).exp();
        assert!(strain > 0.0 && (damage - strain / at_fracture).abs() < 1e-14, "{damage}");
        assert!(after_a_step(card, -1.45 * 800.0).1 >= 1.0);
        let from = card.brittle_from().unwrap();
        assert!((card.d1 + card.d2 * (card.d3 * from).exp() - 1e-6).abs() < 1e-15, "{from}");
        assert_eq!(DAMAGE.brittle_from(), None);
        let by_tension =
            JohnsonCookDamageParameters { d1: f64::INFINITY, d2: 0.0, d3: 0.0, ..card };
        assert!(after_a_step(by_tension, -1.45 * 800.0).1 <= 0.0);
        assert_eq!(by_tension.brittle_from(), None);
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
