//! Detonation products and their programmed burn.

use perturbation_moments::{Real, Scalar};
use simd_lanes::Mask;

use super::{EquationOfState, Line, Start};
use crate::error::{Error, finite, not_negative, positive};
use crate::{EquationFamily, Now};

parameters! {
    /// What a [`Jwl`] is made of.
    JwlParameters {
        /// `rho_0 > 0` of the explosive (mass per volume).
        density,
        /// `A >= 0` (stress).
        a,
        /// `B` (stress).
        b,
        /// `R1 > 0` (no unit).
        r1,
        /// `R2 > 0` (no unit).
        r2,
        /// `omega > 0` (no unit).
        omega,
        /// `E_0 > 0`, the chemical energy per reference volume (stress).
        energy,
        /// `D > 0`, the speed of the detonation (length per time).
        detonation_speed,
    }
}

/// Where and how an explosive is lit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detonation {
    /// The point that burns at `t = 0`, zeros beyond the dimension (length): in one dimension a plane.
    pub point: [f64; 3],
    /// The width of the burn front in grid cells, above zero.
    pub cells: f64,
}

/// An explosive by the equation of Jones, Wilkins and Lee, burnt by the clock.
///
/// $$ p = F \left[ A \left( 1 - \frac{\omega}{R_1 J} \right) e^{-R_1 J} + B \left( 1 - \frac{\omega}{R_2 J} \right) e^{-R_2 J}
///        + \frac{\omega e}{J} \right], \qquad F = \min\left( 1, \max\left( 0, \frac{D t - d}{w h} \right) \right) $$
///
/// Symbols: `e` = energy per reference volume, `E_0` before the burn (stress); `d` = distance of the particle at `t = 0` from
/// the point of detonation; `h` = cell, `w` = [`Detonation::cells`]. The front runs straight: no corner is turned,
/// and before it arrives the explosive bears no pressure.
///
/// The bulk modulus is that of the products, `F = 1`, also before the burn: the front outruns the sound of the explosive, and
/// the step must know.
///
/// Source: Lee, Hornig and Kury 1968 (UCRL-50422); programmed burn: Wilkins 1999.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jwl<S> {
    parameters: JwlParameters<S>,
    detonation: Detonation,
}

impl<S: Scalar> Jwl<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for density, `R1`, `R2`, `omega`, the energy, the detonation speed and the width of the front;
    /// [`Error::Negative`] for `A`; [`Error::NotFinite`] for `B` and the point.
    pub fn new(parameters: JwlParameters<S>, detonation: Detonation) -> Result<Self, Error> {
        let p = &parameters;
        positive("density", p.density.value())?;
        not_negative("a of JWL", p.a.value())?;
        finite("b of JWL", p.b.value())?;
        positive("r1", p.r1.value())?;
        positive("r2", p.r2.value())?;
        positive("omega", p.omega.value())?;
        positive("energy", p.energy.value())?;
        positive("detonation speed", p.detonation_speed.value())?;
        positive("width of the burn front in cells", detonation.cells)?;
        for coordinate in detonation.point {
            finite("point of detonation", coordinate)?;
        }
        Ok(Self { parameters, detonation })
    }
}

impl<S: Real> Jwl<S> {
    /// `exp(-R J)` before both terms, with `A` and `B`.
    #[inline(always)]
    fn exponentials(&self, volume: S) -> [S; 2] {
        let p = &self.parameters;
        [p.a * (p.r1 * volume * -1.0).exp(), p.b * (p.r2 * volume * -1.0).exp()]
    }
}

impl<S: Real> EquationOfState<S> for Jwl<S> {
    /// `d`, the distance from the point of detonation (length).
    type State = S::Primal;

    #[inline(always)]
    fn density(&self) -> S {
        self.parameters.density
    }

    fn start(&self, position: [f64; 3]) -> Start<S, S::Primal>
    where
        S: Scalar,
    {
        let square: f64 =
            position.iter().zip(self.detonation.point).map(|(x, y)| (x - y) * (x - y)).sum();
        Start { state: square.sqrt(), energy: self.parameters.energy, pressure: S::constant(0.0) }
    }

    #[inline(always)]
    fn line(&self, volume: S) -> Line<S> {
        let p = &self.parameters;
        let inverse = volume.recip();
        let [first, second] = self.exponentials(volume);
        let b = p.omega * inverse;
        let (one, two) = (b / p.r1 * -1.0 + 1.0, b / p.r2 * -1.0 + 1.0);
        Line { a: first * one + second * two, b }
    }

    #[inline(always)]
    fn slope(&self, volume: S) -> Line<S> {
        let p = &self.parameters;
        let inverse = volume.recip();
        let [first, second] = self.exponentials(volume);
        let b = p.omega * inverse;
        let by_volume = b * inverse;
        let (one, two) = (by_volume / p.r1 + b - p.r1, by_volume / p.r2 + b - p.r2);
        Line { a: first * one + second * two, b: by_volume * -1.0 }
    }

    #[inline(always)]
    fn advance(&self, now: &Now<S>, distance: &mut S::Primal) -> Option<S> {
        let passed = self.parameters.detonation_speed * now.time - S::from_primal(*distance);
        let burnt = passed * (1.0 / (self.detonation.cells * now.cell));
        let (none, all) = (burnt.splat(0.0), burnt.splat(1.0));
        let is_burnt = burnt.at_least(all);
        if is_burnt.all() {
            return None;
        }
        let begun = S::select(none.at_least(burnt), none, burnt);
        Some(S::select(is_burnt, all, begun))
    }

    #[inline(always)]
    fn visit_numbers(&self, state: &mut S::Primal, mut visit: impl FnMut(&mut S)) -> bool {
        let mut distance = S::from_primal(*state);
        visit(&mut distance);
        *state = distance.primal();
        true
    }
}

family_member!(EquationFamily, EquationOfState: Jwl { ; detonation }, number => number.primal());

#[cfg(test)]
mod tests {
    use super::super::laws::{pressure, slopes_and_bulk_modulus};
    use super::*;

    const TNT: JwlParameters<f64> = JwlParameters {
        density: 1.63,
        a: 3.712,
        b: 0.03231,
        r1: 4.15,
        r2: 0.95,
        omega: 0.3,
        energy: 0.07,
        detonation_speed: 0.693,
    };

    const LIT: Detonation = Detonation { point: [1.0, 2.0, 0.0], cells: 1.0 };

    #[test]
    fn slopes_and_bulk_modulus_are_derivatives() {
        slopes_and_bulk_modulus(&Jwl::new(TNT, LIT).unwrap(), &[0.6, 1.0, 4.0], 0.07);
    }

    #[test]
    fn its_isentropes_have_a_closed_form() {
        // p = A exp(-R1 J) + B exp(-R2 J) + c J^-(1 + omega); e by its integral.
        let jwl = Jwl::new(TNT, LIT).unwrap();
        let c = 0.01;
        for volume in [0.7_f64, 1.0, 5.0] {
            let [first, second] = jwl.exponentials(volume);
            let rest = c * volume.powf(-1.3);
            let energy = first / 4.15 + second / 0.95 + rest * volume / 0.3;
            let closed = first + second + rest;
            assert!((pressure(&jwl, volume, energy) - closed).abs() < 1e-14);
            let modulus = volume * (4.15 * first + 0.95 * second) + 1.3 * rest;
            assert!((jwl.bulk_modulus(volume, energy) - modulus).abs() < 1e-13);
        }
    }

    #[test]
    fn it_burns_when_the_front_arrives_and_over_a_cell() {
        let jwl = Jwl::new(TNT, LIT).unwrap();
        let mut distance = jwl.start([4.0, 6.0, 0.0]).state;
        assert!((distance - 5.0).abs() < 1e-15);
        let mut share = |passed: f64| {
            let now = Now {
                velocity_gradient: [[0.0; 3]; 3],
                dt: 0.1,
                time: (5.0 + passed) / 0.693,
                volume_before: 1.0,
                volume: 1.0,
                viscosity: 0.0,
                cell: 0.5,
            };
            jwl.advance(&now, &mut distance)
        };
        assert_eq!(share(-0.1), Some(0.0));
        assert!((share(0.25).unwrap() - 0.5).abs() < 1e-14);
        assert_eq!(share(0.51), None);
    }

    #[test]
    fn a_burn_velocity_of_zero_is_refused() {
        let still = JwlParameters { detonation_speed: 0.0, ..TNT };
        assert_eq!(
            Jwl::new(still, LIT).unwrap_err(),
            Error::NotPositive { name: "detonation speed", value: 0.0 }
        );
        let thin = Detonation { cells: 0.0, ..LIT };
        assert!(matches!(Jwl::new(TNT, thin), Err(Error::NotPositive { .. })));
    }
}
