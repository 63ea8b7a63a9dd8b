//! The flow stress of Johnson and Cook with the heat of plastic work.

use perturbation_moments::{Real, Scalar, when};
use simd_lanes::Mask;

use super::johnson_cook_return::{LEAST_STRAIN, Return};
use super::johnson_cook_state::JohnsonCookState;
use super::{LEAST_OVERSHOOT, Strength, Trial};
use crate::error::{Error, Fault, not_negative, positive, within};
use crate::tensor::Symmetric;
use crate::{LocalFlow, Now, Observed, StrengthFamily};

parameters! {
    /// What a [`JohnsonCook`] is made of.
    JohnsonCookParameters {
        /// `G > 0` (stress).
        shear_modulus,
        /// `A > 0`, the flow stress at no plastic strain (stress).
        a,
        /// `B >= 0`, the hardening (stress).
        b,
        /// `n > 0`, its exponent (no unit).
        n,
        /// `C >= 0`, the sensitivity to the rate (no unit).
        c,
        /// `m > 0`, the exponent of thermal softening (no unit).
        m,
        /// The rate at which `ln` of the relative rate is zero, above zero: 1/s in the unit system (1 per time).
        reference_rate,
        /// The least relative rate that counts, above zero. One, unless a table was made otherwise (no unit).
        rate_floor,
        /// The temperature of the reference state (K).
        room_temperature,
        /// The temperature of melting, above that of the room (K).
        melting_temperature,
        /// `chi` from 0 to 1, Taylor and Quinney's share of plastic work that heats (no unit).
        taylor_quinney,
        /// `rho_0 > 0` (mass per volume).
        density,
        /// `c_p > 0` (energy per mass and kelvin).
        specific_heat,
    }
}

/// A metal by its strain, rate and temperature.
///
/// $$ \sigma_y = (A + B \varepsilon_p^n) (1 + C \ln \dot\varepsilon^\ast) (1 - T^{\ast m}), \qquad
///    \Delta T^\ast = \frac{\chi J \sigma_y \Delta\varepsilon_p}{\rho_0 c_p (T_{melt} - T_{room})} $$
///
/// Symbols: $\dot\varepsilon^\ast$ = relative rate, $\sqrt{\tfrac23 \operatorname{dev} D : \operatorname{dev} D}$ over the
/// reference rate: the total rate, which is known before the return; below the floor it is the floor. $T^\ast$ =
/// `(T - T_room)/(T_melt - T_room)` after the step before, by the heat of plastic work alone, not of compression; from one on the
/// strength is zero.
///
/// The return solves $\sigma_{eq}^\ast - 3 G \Delta\varepsilon_p = \sigma_y(\varepsilon_p + \Delta\varepsilon_p)$ by a
/// safeguarded Newton method on the values, then by Newton steps in the arithmetic of `S`: two of them make first and second
/// derivatives of a jet exact. An overshoot below `1e-10` of the flow stress is elastic: at no plastic strain the derivative of
/// $\varepsilon_p^n$ is not finite.
///
/// Source: Johnson and Cook 1983; Chen et al. 2019, eq 11-20. The hardening of eq 19-20 is not constant here, and the
/// paper's reference rate and heat are in [`library::steel_strength_as_published`](crate::library::steel_strength_as_published).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JohnsonCook<S> {
    parameters: JohnsonCookParameters<S>,
    /// `chi/(rho_0 c_p (T_melt - T_room))`: homologous temperature per plastic work.
    heating: S,
    /// Natural logarithm of the floor.
    log_floor: S,
}

impl<S: Scalar> JohnsonCook<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Each refusal by the name of its parameter: not above zero, negative, out of range, not finite; a melting temperature
    /// that is not above the room's; a rate factor that is not above zero at the floor.
    pub fn new(parameters: JohnsonCookParameters<S>) -> Result<Self, Error> {
        let p = &parameters;
        positive("shear modulus", p.shear_modulus.value())?;
        positive("a of Johnson-Cook", p.a.value())?;
        not_negative("b of Johnson-Cook", p.b.value())?;
        positive("n of Johnson-Cook", p.n.value())?;
        not_negative("c of Johnson-Cook", p.c.value())?;
        positive("m of Johnson-Cook", p.m.value())?;
        positive("reference rate", p.reference_rate.value())?;
        positive("rate floor", p.rate_floor.value())?;
        not_negative("room temperature", p.room_temperature.value())?;
        positive("melting temperature", p.melting_temperature.value())?;
        if p.melting_temperature.value() <= p.room_temperature.value() {
            return Err(Error::OutOfOrder {
                name: "melting temperature",
                value: p.melting_temperature.value(),
                other: "room temperature",
                limit: p.room_temperature.value(),
            });
        }
        within("taylor quinney", p.taylor_quinney.value(), 0.0, 1.0)?;
        positive("density", p.density.value())?;
        positive("specific heat", p.specific_heat.value())?;
        let log_floor = p.rate_floor.ln();
        positive("1 + c ln(rate floor)", (p.c * log_floor + 1.0).value())?;
        let range = p.melting_temperature - p.room_temperature;
        let heating = p.taylor_quinney / (p.density * p.specific_heat * range);
        Ok(Self { parameters, heating, log_floor })
    }

    /// The parameters it was made of.
    #[must_use]
    pub fn parameters(&self) -> &JohnsonCookParameters<S> {
        &self.parameters
    }
}

impl<S: Real> JohnsonCook<S> {
    /// Newton steps after the values: one polishes the value, a second one the derivatives, where there are any.
    const POLISH: usize = if S::DERIVATIVES == 0 { 1 } else { 2 };

    /// The logarithm of the relative rate, of the floor below it.
    #[inline(always)]
    pub(crate) fn log_rate(&self, rate: &Symmetric<S>) -> S {
        let reference = self.parameters.reference_rate;
        let square = rate.square() * (2.0 / 3.0) / reference.squared();
        let floor = self.parameters.rate_floor.primal();
        let counts = (floor * floor).less(square.primal());
        when!(counts, square.ln() * 0.5, self.log_floor)
    }

    /// `1 - T*^m`; one in the cold, zero in the melt.
    #[inline(always)]
    fn softening(&self, temperature: S) -> S {
        let (zero, one) = (temperature.splat(0.0), temperature.splat(1.0));
        let is_warm = zero.less(temperature);
        let softened =
            when!(is_warm, (self.parameters.m * temperature.ln()).exp() * -1.0 + 1.0, one);
        S::select(temperature.at_least(one), zero, softened)
    }

    /// Yields where the mask is true: plastic strain, flow stress and temperature; the factor of the trial deviator, one elsewhere.
    #[inline(always)]
    fn yielding(
        &self,
        yields: S::Mask,
        (equivalent, factor): (S, S),
        volume: S,
        state: &mut JohnsonCookState<S>,
    ) -> Result<S, Fault> {
        let p = &self.parameters;
        let shear = p.shear_modulus * 3.0;
        let zero = factor.splat(0.0);
        let is_molten = yields.and(zero.less(factor).not());
        if is_molten.any() {
            // In the melt all deformation is plastic and no work is done.
            let strain = state.plastic_strain + equivalent / shear;
            state.plastic_strain = S::select(is_molten, strain, state.plastic_strain);
            state.flow_stress = S::select(is_molten, zero, state.flow_stress);
        }
        let of_deviator = S::select(is_molten, zero, zero.splat(1.0));
        let yields = yields.and(is_molten.not());
        if !yields.any() {
            return Ok(of_deviator);
        }
        let values = Return {
            overshoot: state.overshoot.primal(),
            shear: shear.primal(),
            factor: (p.b * factor).primal(),
            exponent: p.n.primal(),
            strain: state.plastic_strain.primal(),
            hardening: state.hardening.primal(),
        };
        let increment = values.increment(yields)?;
        let strain = values.strain + increment;
        let yields = yields.and(strain.at_least(strain.splat(LEAST_STRAIN)));
        let mut increment = S::from_primal(increment);
        let mut hardening = state.hardening;
        for _ in 0..Self::POLISH {
            let strain = state.plastic_strain + increment;
            let power = (p.n * strain.ln()).exp();
            let slope = power * p.n / strain;
            let residual = equivalent - shear * increment - factor * (p.a + p.b * power);
            let step = residual / (shear + factor * p.b * slope);
            increment = increment + step;
            // The step is at roundoff of the value, and of the first derivative after the first: linear is exact.
            hardening = power + slope * step;
        }
        let flow = equivalent - shear * increment;
        let heated = state.homologous_temperature + self.heating * volume * flow * increment;
        state.hardening = S::select(yields, hardening, state.hardening);
        state.plastic_strain =
            S::select(yields, state.plastic_strain + increment, state.plastic_strain);
        state.flow_stress = S::select(yields, flow, state.flow_stress);
        state.homologous_temperature = S::select(yields, heated, state.homologous_temperature);
        state.softening = S::select(yields, self.softening(heated), state.softening);
        Ok(S::select(yields, flow / equivalent, of_deviator))
    }
}

impl<S: Real> Strength<S> for JohnsonCook<S> {
    type State = JohnsonCookState<S>;

    fn start(&self) -> JohnsonCookState<S>
    where
        S: Scalar,
    {
        let zero = S::constant(0.0);
        JohnsonCookState {
            deviator: Symmetric::zero(),
            plastic_strain: zero,
            homologous_temperature: zero,
            flow_stress: self.parameters.a * (self.parameters.c * self.log_floor + 1.0),
            overshoot: zero,
            hardening: zero,
            softening: S::constant(1.0),
        }
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, state: &mut JohnsonCookState<S>) -> Result<S, Fault> {
        let p = &self.parameters;
        let before = state.deviator;
        let trial = Trial::new(now, &before, p.shear_modulus);
        let equivalent = trial.equivalent(p.shear_modulus)?;
        let factor = (p.c * self.log_rate(&trial.rate) + 1.0) * state.softening;
        let flow = (p.a + p.b * state.hardening) * factor;
        state.flow_stress = flow;
        state.overshoot = equivalent - flow;
        state.deviator = trial.deviator;
        let yields = (flow.primal() * LEAST_OVERSHOOT).less(state.overshoot.primal());
        if yields.any() {
            let returned = self.yielding(yields, (equivalent, factor), now.volume, state)?;
            state.deviator = trial.deviator.scaled(returned);
        }
        Ok(trial.work(now, &before, &state.deviator))
    }

    #[inline(always)]
    fn deviator(&self, state: &JohnsonCookState<S>) -> Option<Symmetric<S>> {
        Some(state.deviator)
    }

    #[inline(always)]
    fn shear_modulus(&self, _state: &JohnsonCookState<S>) -> Option<S> {
        Some(self.parameters.shear_modulus)
    }

    #[inline(always)]
    fn observe(&self, state: &JohnsonCookState<S>) -> Observed<S>
    where
        S: Scalar,
    {
        let p = &self.parameters;
        Observed {
            plastic_strain: state.plastic_strain,
            flow_stress: state.flow_stress,
            temperature: state.homologous_temperature
                * (p.melting_temperature - p.room_temperature),
            overshoot: state.overshoot,
            ..Observed::of_energy(S::constant(0.0))
        }
    }

    /// The rate is the one that gives the flow stress seen.
    fn flow_at(&self, observed: &Observed<f64>) -> Option<LocalFlow<S>>
    where
        S: Scalar,
    {
        let p = &self.parameters;
        let strain = observed.plastic_strain;
        let hardening =
            if strain > LEAST_STRAIN { (p.n * strain.ln()).exp() } else { S::constant(0.0) };
        let range = p.melting_temperature.value() - p.room_temperature.value();
        let softening = self.softening(S::constant(observed.temperature / range));
        let quasistatic = (p.a + p.b * hardening) * softening;
        let factor = observed.flow_stress / quasistatic.value();
        let log_rate = if p.c.value() > 0.0 && factor.is_finite() {
            (factor - 1.0) / p.c.value()
        } else {
            0.0
        };
        let slope = p.b.value() * p.n.value() * hardening.value() / strain;
        Some(LocalFlow {
            stress: quasistatic * (p.c * log_rate + 1.0),
            hardening_modulus: if strain > LEAST_STRAIN {
                slope * softening.value() * factor
            } else {
                f64::INFINITY
            },
            shear_modulus: p.shear_modulus.value(),
        })
    }

    #[inline(always)]
    fn visit_numbers(
        &self,
        state: &mut JohnsonCookState<S>,
        mut visit: impl FnMut(&mut S),
    ) -> bool {
        let JohnsonCookState {
            deviator,
            plastic_strain,
            homologous_temperature,
            flow_stress,
            overshoot,
            hardening,
            softening,
        } = state;
        for k in 0..6 {
            visit(&mut deviator.0[k]);
        }
        visit(plastic_strain);
        visit(flow_stress);
        visit(overshoot);
        visit(homologous_temperature);
        visit(hardening);
        visit(softening);
        true
    }

    shows_constants!(heating, log_floor);
}

family_member!(StrengthFamily, Strength: JohnsonCook { heating, log_floor }, number => JohnsonCookState {
    deviator: Symmetric([number; 6]),
    plastic_strain: number,
    homologous_temperature: number,
    flow_stress: number,
    overshoot: number,
    hardening: number,
    softening: number,
});

#[cfg(test)]
mod tests {
    use perturbation_moments::Jet;

    use super::super::laws::stretching;
    use super::*;
    use crate::tensor::von_mises as equivalent_stress;

    /// Megapascal, second; 4340 steel.
    const STEEL: JohnsonCookParameters<f64> = JohnsonCookParameters {
        shear_modulus: 77500.0,
        a: 792.0,
        b: 510.0,
        n: 0.26,
        c: 0.014,
        m: 1.03,
        reference_rate: 1.0,
        rate_floor: 1.0,
        room_temperature: 294.0,
        melting_temperature: 1793.0,
        taylor_quinney: 0.9,
        density: 7830.0,
        specific_heat: 477.0e-6,
    };

    #[test]
    fn on_the_surface_the_stress_is_the_printed_formula() {
        let material = JohnsonCook::new(STEEL).unwrap();
        let mut state = material.start();
        for _ in 0..100 {
            let temperature = state.homologous_temperature;
            material.update(&stretching(1e4, 1e-7), &mut state).unwrap();
            let equivalent: f64 = equivalent_stress(&state.deviator);
            if state.plastic_strain > 0.0 {
                let printed = (792.0 + 510.0 * state.plastic_strain.powf(0.26))
                    * (1.0 + 0.014 * 1e4_f64.ln())
                    * (1.0 - temperature.powf(1.03));
                assert!((equivalent - printed).abs() < 1e-9 * printed);
                assert!((state.flow_stress - printed).abs() < 1e-9 * printed);
            }
        }
        assert!((0.05..0.1).contains(&state.plastic_strain));
        // chi times the plastic work over rho c_p: about 0.9 * 1150 * 0.095/3.735.
        let rise = material.observe(&state).temperature;
        assert!((20.0..32.0).contains(&rise), "{rise}");
    }

    #[test]
    fn below_the_reference_rate_the_rate_does_not_count() {
        let slow = |rate: f64| {
            let material = JohnsonCook::new(STEEL).unwrap();
            let mut state = material.start();
            for _ in 0..50 {
                material.update(&stretching(rate, 0.001 / rate), &mut state).unwrap();
            }
            state.flow_stress
        };
        assert!((slow(1e-3) - slow(0.5)).abs() < 1e-9);
        assert!(slow(10.0) > 1.03 * slow(0.5));
    }

    #[test]
    fn the_melt_bears_no_shear() {
        // So little capacity that one plastic step melts: smoothly, softening would only approach it.
        let hot = JohnsonCookParameters { specific_heat: 477.0e-12, ..STEEL };
        let material = JohnsonCook::new(hot).unwrap();
        let mut state = material.start();
        for _ in 0..20 {
            material.update(&stretching(1e4, 1e-7), &mut state).unwrap();
        }
        assert!(state.homologous_temperature >= 1.0);
        assert_eq!((state.deviator, state.flow_stress), (Symmetric::zero(), 0.0));
    }

    #[test]
    fn jets_at_the_first_yield_are_finite_and_right() {
        // One step from rest to eps_p of 1e-9 and more: the closed form by implicit differentiation,
        // (3 G + H) x' = -(dsigma_y/da) at fixed x.
        for over in [1e-8, 1e-3, 0.3] {
            let seeded = STEEL.map(|name, value| match name {
                "a" => Jet::variable(value, 0),
                "n" => Jet::variable(value, 1),
                _ => Jet::constant(value),
            });
            let material = JohnsonCook::new(seeded).unwrap();
            let mut state = material.start();
            let c2 = 1.0 + 0.014 * 1e4_f64.ln();
            let strain = 792.0 * c2 / (3.0 * 77500.0) * (1.0 + over);
            material.update(&stretching(1e4, strain / 1e4), &mut state).unwrap();
            let x = state.plastic_strain;
            assert!(x.value > 0.0);
            let slope = 3.0 * 77500.0 + 510.0 * c2 * 0.26 * x.value.powf(0.26 - 1.0);
            let by_n = -510.0 * c2 * x.value.powf(0.26) * x.value.ln() / slope;
            // The overshoot is a difference: 1e-16 of the stress is 1e-8 of 1e-8.
            assert!((x.first[0] / (-c2 / slope) - 1.0).abs() < 1e-6, "{over}");
            assert!((x.first[1] / by_n - 1.0).abs() < 1e-6, "{over}");
            assert!(state.deviator.0.iter().all(|s| s.second.iter().all(|d| d.is_finite())));
        }
        // Right behind the tolerance, with exponents for which the strain underflows, nothing is NaN.
        for n in [0.01, 0.05, 0.26, 1.0, 2.0] {
            for over in [1.01e-10, 1e-9, 1e-6] {
                let seeded = JohnsonCookParameters { n, c: 0.0, ..STEEL }
                    .map(|name, value| Jet::variable(value, usize::from(name == "n")));
                let material = JohnsonCook::new(seeded).unwrap();
                let mut state = material.start();
                let strain = 792.0 / (3.0 * 77500.0) * (1.0 + over);
                for dt in [strain / 1e4, 1e-7] {
                    material.update(&stretching(1e4, dt), &mut state).unwrap();
                    let numbers = [state.plastic_strain, state.flow_stress, state.softening];
                    let finite = |y: &Jet| {
                        y.value.is_finite()
                            && y.first.iter().chain(&y.second).all(|d| d.is_finite())
                    };
                    assert!(numbers.iter().chain(&state.deviator.0).all(finite), "{n} {over}");
                }
                assert!(state.plastic_strain.value > 0.0);
            }
        }
        // At rest too.
        let material = JohnsonCook::new(STEEL.map(|_, value| Jet::variable(value, 0))).unwrap();
        let mut state = material.start();
        material.update(&stretching(0.0, 1.0), &mut state).unwrap();
        assert!(state.overshoot.first[0].is_finite());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let refused = |p| JohnsonCook::new(p).unwrap_err();
        assert!(matches!(
            refused(JohnsonCookParameters { melting_temperature: 200.0, ..STEEL }),
            Error::OutOfOrder { name: "melting temperature", .. }
        ));
        assert!(matches!(
            refused(JohnsonCookParameters { taylor_quinney: 1.1, ..STEEL }),
            Error::OutOfRange { name: "taylor quinney", .. }
        ));
        assert!(matches!(
            refused(JohnsonCookParameters { rate_floor: 1e-40, ..STEEL }),
            Error::NotPositive { name: "1 + c ln(rate floor)", .. }
        ));
        assert!(matches!(
            refused(JohnsonCookParameters { n: 0.0, ..STEEL }),
            Error::NotPositive { name: "n of Johnson-Cook", .. }
        ));
    }
}
