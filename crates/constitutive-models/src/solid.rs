//! An equation of state and a strength make a material.

use perturbation_moments::{Real, Scalar, when};

use super::{
    ElasticBulk, ElasticBulkParameters, ElasticShear, ElasticShearParameters, EquationFamily,
    EquationOfState, LocalResponse, LocalState, Material, MaterialFamily, Now, Observed, Strength,
    StrengthFamily,
};
use crate::equation_of_state::at_least;
use crate::error::{Error, Fault, positive};
use crate::tensor::Symmetric;
use simd_lanes::Mask;

/// A material by its equation of state and its strength, each checked when it was made.
///
/// $$ \sigma = S - p I, \qquad e^{n+1} = e^n + \Delta w_S - \left( \tfrac12 (p^n + p^{n+1}) + q \right) \Delta J $$
///
/// Symbols: `S` = deviator, `e` = energy per reference volume, $\Delta w_S$ = work of the deviator, `q` = bulk viscosity. The
/// pressure is linear in the energy, so the implicit equation has a closed solution:
/// $p^{n+1} = (a + b e_h)/(1 + \tfrac12 b \Delta J)$ with $e_h = e^n + \Delta w_S - \tfrac12 (p^n + 2 q) \Delta J$. One
/// step from rest of any length lands on the Hugoniot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid<E, Y> {
    /// Pressure.
    pub equation: E,
    /// Deviator.
    pub strength: Y,
}

/// What a particle of a [`Solid`] remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidState<S, T, Y> {
    /// `e`, energy per reference volume (stress).
    pub energy: S,
    /// The pressure without the bulk viscosity (stress).
    pub pressure: S,
    /// Of the equation of state.
    pub equation: T,
    /// Of the strength.
    pub strength: Y,
}

impl<S: Real, E: EquationOfState<S>, Y: Strength<S>> Material<S> for Solid<E, Y> {
    type State = SolidState<S, E::State, Y::State>;

    fn density(&self) -> S {
        self.equation.density()
    }

    fn start(&self, position: [f64; 3]) -> Self::State
    where
        S: Scalar,
    {
        let start = self.equation.start(position);
        SolidState {
            energy: start.energy,
            pressure: start.pressure,
            equation: start.state,
            strength: self.strength.start(),
        }
    }

    /// A gas starts under its pressure.
    fn start_stress(&self, state: &Self::State) -> Symmetric<S>
    where
        S: Scalar,
    {
        Symmetric::isotropic(state.pressure * -1.0)
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, state: &mut Self::State) -> Result<Symmetric<S>, Fault> {
        self.equation.admit(now.volume)?;
        let mut line = self.equation.line(now.volume);
        let half_change = (now.volume - now.volume_before) * 0.5;
        let work = self.strength.update(now, &mut state.strength)?;
        if let Some(share) = self.equation.advance(now, &mut state.equation) {
            line.a = line.a * share;
            line.b = line.b * share;
        }
        let half_way = state.energy + work - (state.pressure + now.viscosity * 2.0) * half_change;
        let mut solved = line.a;
        if E::KNOWS_ENERGY {
            let resistance = line.b * half_change + 1.0;
            let mut is_solved = resistance.splat(0.0).less(resistance);
            solved = (line.a + line.b * half_way) / resistance;
            // Debris: where the pressure after a step at the least pressure is below it, the least is the solution, however far the
            // step compresses. Where there is no solution and the particle is still loose, it bears no pressure yet.
            let (zero, one) = (resistance.splat(0.0), resistance.splat(1.0));
            let strength = self.strength.least_pressure(&state.strength);
            for least in [strength, self.equation.least_pressure()].into_iter().flatten() {
                let is_slack = (line.a + line.b * (half_way - least * half_change)).less(least);
                let is_loose = least.is_finite().and(one.less(now.volume)).and(is_solved.not());
                solved = S::select(is_loose, zero, S::select(is_slack, least, solved));
                is_solved = is_solved.or(is_slack).or(is_loose);
            }
            Fault::unless(
                is_solved,
                resistance,
                "1 + b dJ/2 of the energy of a step",
                "greater than 0: the step compresses too much; debris needs `damage` or a limit of tension",
            )?;
        }
        let solved = at_least(solved, self.equation.least_pressure());
        let pressure = self.strength.carry(solved, &mut state.strength)?;
        Fault::unless(pressure.is_finite(), pressure, "the pressure", "finite")?;
        state.pressure = pressure;
        state.energy = half_way - pressure * half_change;
        Ok(match self.strength.deviator(&state.strength) {
            Some(deviator) => deviator - Symmetric::isotropic(pressure),
            None => Symmetric::isotropic(pressure * -1.0),
        })
    }

    /// Zero where the tangent is not positive: no longitudinal wave runs there.
    #[inline(always)]
    fn wave_speed(&self, volume: S, state: &Self::State) -> S {
        let mut modulus = self.equation.bulk_modulus(volume, state.energy);
        if let Some(shear) = self.strength.shear_modulus(&state.strength) {
            modulus = modulus + shear * (4.0 / 3.0);
        }
        let zero = modulus.splat(0.0);
        when!(zero.less(modulus), (modulus * volume / self.equation.density()).sqrt(), zero)
    }

    #[inline(always)]
    fn observe(&self, state: &Self::State) -> Observed<S>
    where
        S: Scalar,
    {
        Observed { energy: state.energy, ..self.strength.observe(&state.strength) }
    }

    #[inline(always)]
    fn energy(&self, state: &Self::State) -> S
    where
        S: Scalar,
    {
        state.energy
    }

    /// The line at a certain volume and energy, times what burn or a cut-off has left of it.
    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>>
    where
        S: Scalar,
    {
        let line = self.equation.line(S::constant(state.volume));
        let full = line.a + line.b * state.observed.energy;
        // Without burn or cut-off the ratio is one within roundoff; at no pressure there is nothing to differentiate.
        let share = if full.value() == 0.0 { 0.0 } else { state.pressure / full.value() };
        let flow = self.strength.flow_at(&state.observed);
        Some(LocalResponse { pressure: full * share, flow })
    }

    #[inline(always)]
    fn visit_numbers(&self, state: &mut Self::State, mut visit: impl FnMut(&mut S)) -> bool {
        visit(&mut state.energy);
        visit(&mut state.pressure);
        self.equation.visit_numbers(&mut state.equation, &mut visit)
            && self.strength.visit_numbers(&mut state.strength, &mut visit)
    }

    #[inline(always)]
    fn visit_constants(&mut self, mut visit: impl FnMut(&mut S)) -> bool {
        self.equation.visit_constants(&mut visit) && self.strength.visit_constants(&mut visit)
    }
}

impl<F: Scalar, E: EquationFamily<F>, Y: StrengthFamily<F>> MaterialFamily<F> for Solid<E, Y> {
    type In<S: Real> = Solid<E::In<S>, Y::In<S>>;

    #[inline(always)]
    fn in_numbers<S: Real>(&self, of: impl Fn(F) -> S + Copy) -> Self::In<S> {
        Solid { equation: self.equation.in_numbers(of), strength: self.strength.in_numbers(of) }
    }

    #[inline(always)]
    fn filled<S: Real>(&self, number: S) -> <Self::In<S> as Material<S>>::State {
        SolidState {
            energy: number,
            pressure: number,
            equation: self.equation.filled(number),
            strength: self.strength.filled(number),
        }
    }
}

parameters! {
    /// What a [`LinearElasticSolid`] is made of.
    LinearElasticParameters {
        /// `rho_0 > 0` (mass per volume).
        density,
        /// `E > 0`, Young's modulus (stress).
        young_modulus,
        /// `nu`, Poisson's ratio, above -1 and below 1/2 (no unit).
        poisson_ratio,
    }
}

/// Linear elasticity in rates: for small strain and any rotation.
///
/// $$ \mathring\sigma = K \operatorname{tr}(D) I + 2 G \operatorname{dev} D, \qquad
///    K = \frac{E}{3 (1 - 2\nu)}, \quad G = \frac{E}{2 (1 + \nu)} $$
pub type LinearElasticSolid<S> = Solid<ElasticBulk<S>, ElasticShear<S>>;

impl<S: Scalar> LinearElasticSolid<S> {
    /// From Young's modulus and Poisson's ratio.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for density, Young's modulus, `1 + nu` and `1 - 2 nu`.
    pub fn linear_elastic(parameters: LinearElasticParameters<S>) -> Result<Self, Error> {
        let LinearElasticParameters { density, young_modulus, poisson_ratio } = parameters;
        positive("young modulus", young_modulus.value())?;
        let (sum, difference) = (poisson_ratio + 1.0, poisson_ratio * -2.0 + 1.0);
        positive("1 + poisson ratio", sum.value())?;
        positive("1 - 2 poisson ratio", difference.value())?;
        let bulk_modulus = young_modulus / (difference * 3.0);
        let shear_modulus = young_modulus / (sum * 2.0);
        Ok(Self {
            equation: ElasticBulk::new(ElasticBulkParameters { density, bulk_modulus })?,
            strength: ElasticShear::new(ElasticShearParameters { shear_modulus })?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fluid, MieGruneisen, TensionCutOff, Units, library};

    /// A step that changes the volume along x alone.
    fn squeezed(before: f64, after: f64) -> Now<f64> {
        let mut velocity_gradient = [[0.0; 3]; 3];
        velocity_gradient[0][0] = after / before - 1.0;
        Now {
            velocity_gradient,
            dt: 1.0,
            time: 1.0,
            volume_before: before,
            volume: after,
            viscosity: 0.0,
            cell: 1.0,
        }
    }

    #[test]
    fn one_step_from_rest_lands_on_the_hugoniot() {
        let equation = MieGruneisen::new(library::steel_equation(Units::CM_G_US)).unwrap();
        let solid = Solid { equation, strength: Fluid };
        for particle_velocity in [0.01, 0.1, 0.2] {
            let shock = 0.4569 + 1.49 * particle_velocity;
            let mut state = Material::<f64>::start(&solid, [0.0; 3]);
            let now = squeezed(1.0, 1.0 - particle_velocity / shock);
            let stress = solid.update(&now, &mut state).unwrap();
            let exact = 7.83 * shock * particle_velocity;
            assert!((stress.0[0] + exact).abs() < 1e-13, "{stress:?} {exact}");
            let energy = 0.5 * 7.83 * particle_velocity * particle_velocity;
            assert!((state.energy - energy).abs() < 1e-14);
        }
    }

    #[test]
    fn the_work_of_the_bulk_viscosity_heats() {
        let equation = MieGruneisen::new(library::steel_equation(Units::CM_G_US)).unwrap();
        let solid = Solid { equation, strength: Fluid };
        let mut state = Material::<f64>::start(&solid, [0.0; 3]);
        let now = Now { viscosity: 0.01, ..squeezed(1.0, 0.9) };
        let stress = solid.update(&now, &mut state).unwrap();
        // e = (p/2 + q) 0.1, and the pressure is that of the line at this energy, without q.
        let pressure = -stress.0[0];
        assert!((state.energy - (0.5 * pressure + 0.01) * 0.1).abs() < 1e-15);
        let line = solid.equation.line(0.9);
        assert!((pressure - (line.a + line.b * state.energy)).abs() < 1e-14);
    }

    #[test]
    fn beyond_the_pole_it_says_so() {
        let equation = MieGruneisen::new(library::steel_equation(Units::CM_G_US)).unwrap();
        let solid = Solid { equation, strength: Fluid };
        let mut state = Material::<f64>::start(&solid, [0.0; 3]);
        let fault = solid.update(&squeezed(1.0, 0.3), &mut state).unwrap_err();
        assert!(fault.quantity.contains("Hugoniot"));
    }

    #[test]
    fn water_bears_no_tension_beyond_its_limit_and_recovers() {
        let equation = MieGruneisen::new(library::water(Units::SI)).unwrap();
        let solid = Solid { equation: TensionCutOff::new(equation, 1e5).unwrap(), strength: Fluid };
        let mut state = Material::<f64>::start(&solid, [0.0; 3]);
        let opened = solid.update(&squeezed(1.0, 1.1), &mut state).unwrap();
        assert!((opened.0[0] - 1e5).abs() < 1e-9);
        // Work against the mean of rest and the limit.
        assert!((state.energy - 0.5 * 1e5 * 0.1).abs() < 1e-6);
        assert!(solid.wave_speed(1.1, &state) > 1000.0);
        let closed = solid.update(&squeezed(1.1, 0.99), &mut state).unwrap();
        assert!(closed.0[0] < -1e7);
    }

    #[test]
    fn debris_closes_by_more_than_an_energy_would_bear_and_then_bears_pressure() {
        let equation = MieGruneisen::new(library::steel_equation(Units::CM_G_US)).unwrap();
        let gamma = equation.line(3.0).b;
        let (far, near) = (1.0 + 6.0 / gamma, 1.0 + 1.0 / gamma);
        // A step from J = far to near changes gamma J by five: more than two.
        let loose = TensionCutOff::new(equation, 0.0).unwrap();
        let solid = Solid { equation: loose, strength: Fluid };
        let mut state = Material::<f64>::start(&solid, [0.0; 3]);
        let opened = solid.update(&squeezed(1.0, far), &mut state).unwrap();
        assert_eq!(opened, Symmetric::zero());
        let closing = solid.update(&squeezed(far, near), &mut state).unwrap();
        assert_eq!((closing, state.energy), (Symmetric::zero(), 0.0));
        let closed = solid.update(&squeezed(near, 0.95), &mut state);
        assert!(closed.unwrap().0[0] < 0.0);
        // Hot debris, whose pressure is above zero at any volume, bears none while a step has no solution.
        let mut state = Material::<f64>::start(&solid, [0.0; 3]);
        let _ = solid.update(&squeezed(1.0, far), &mut state).unwrap();
        state.energy = 10.0;
        assert_eq!(solid.update(&squeezed(far, near), &mut state).unwrap(), Symmetric::zero());
        // The error of one that bears tension says what to do.
        let bonded = Solid { equation, strength: Fluid };
        let mut state = Material::<f64>::start(&bonded, [0.0; 3]);
        let _ = bonded.update(&squeezed(1.0, far), &mut state).unwrap();
        let fault = bonded.update(&squeezed(far, near), &mut state).unwrap_err();
        assert!(fault.to_string().contains("damage"), "{fault}");
    }

    #[test]
    fn the_elastic_solid_has_the_moduli_and_speed_of_the_closed_form() {
        let (density, young_modulus, poisson_ratio) = (2.0, 7.0, 0.25);
        let solid = LinearElasticSolid::linear_elastic(LinearElasticParameters {
            density,
            young_modulus,
            poisson_ratio,
        })
        .unwrap();
        let mut state = solid.start([0.0; 3]);
        let longitudinal: f64 = young_modulus * (1.0 - poisson_ratio)
            / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
        assert!((solid.wave_speed(1.0, &state) - (longitudinal / density).sqrt()).abs() < 1e-14);
        let stress = solid.update(&squeezed(1.0, 1.0 + 1e-6), &mut state).unwrap();
        // Small strain: the next order is 1e-6 of it.
        assert!((stress.0[0] / (longitudinal * 1e-6) - 1.0).abs() < 1e-5);
        let refused = LinearElasticParameters { density, young_modulus, poisson_ratio: 0.5 };
        assert!(matches!(
            LinearElasticSolid::linear_elastic(refused),
            Err(Error::NotPositive { name: "1 - 2 poisson ratio", .. })
        ));
    }
}
