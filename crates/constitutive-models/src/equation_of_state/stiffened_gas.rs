//! The stiffened gas.

use perturbation_moments::{Real, Scalar};

use super::{EquationOfState, Line, Start};
use crate::EquationFamily;
use crate::error::{Error, not_negative, positive};

parameters! {
    /// What a [`StiffenedGas`] is made of.
    StiffenedGasParameters {
        /// `rho_0 > 0` (mass per volume).
        density,
        /// `gamma > 1`, the ratio of specific heats (no unit).
        exponent,
        /// `p_inf >= 0` (stress); zero for an ideal gas.
        stiffness,
        /// The pressure at `t = 0`, above `-p_inf` (stress).
        pressure,
    }
}

/// A gas with an inner pressure.
///
/// $$ p = (\gamma - 1) \frac{e}{J} - \gamma p_\infty, \qquad \rho c^2 = \gamma (p + p_\infty) $$
///
/// Symbols: `e` = energy per reference volume (stress). With $p_\infty = 0$ it is the ideal gas. Particles start at the
/// pressure of the parameters.
///
/// Source: Harlow and Amsden 1971; Menikoff and Plohr 1989.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffenedGas<S> {
    parameters: StiffenedGasParameters<S>,
}

impl<S: Scalar> StiffenedGas<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the density and `p + p_inf`, [`Error::Negative`] for `p_inf`, [`Error::OutOfOrder`] for an
    /// exponent that is not above one.
    pub fn new(parameters: StiffenedGasParameters<S>) -> Result<Self, Error> {
        let p = &parameters;
        positive("density", p.density.value())?;
        positive("exponent", p.exponent.value())?;
        if p.exponent.value() <= 1.0 {
            let value = p.exponent.value();
            return Err(Error::OutOfOrder { name: "exponent", value, other: "one", limit: 1.0 });
        }
        not_negative("stiffness", p.stiffness.value())?;
        positive("pressure + stiffness", (p.pressure + p.stiffness).value())?;
        Ok(Self { parameters })
    }
}

impl<S: Real> EquationOfState<S> for StiffenedGas<S> {
    type State = ();

    #[inline(always)]
    fn density(&self) -> S {
        self.parameters.density
    }

    fn start(&self, _position: [f64; 3]) -> Start<S, ()>
    where
        S: Scalar,
    {
        let p = &self.parameters;
        let energy = (p.pressure + p.exponent * p.stiffness) / (p.exponent - 1.0);
        Start { state: (), energy, pressure: p.pressure }
    }

    #[inline(always)]
    fn line(&self, volume: S) -> Line<S> {
        let p = &self.parameters;
        Line { a: p.exponent * p.stiffness * -1.0, b: (p.exponent - 1.0) / volume }
    }

    #[inline(always)]
    fn slope(&self, volume: S) -> Line<S> {
        let p = &self.parameters;
        Line { a: volume.splat(0.0), b: (p.exponent * -1.0 + 1.0) / volume.squared() }
    }
}

family_member!(EquationFamily, EquationOfState: StiffenedGas {  }, _number => ());

#[cfg(test)]
mod tests {
    use super::super::laws::{pressure, slopes_and_bulk_modulus};
    use super::*;

    #[test]
    fn it_starts_at_its_pressure_with_the_sound_speed_of_the_closed_form() {
        for (exponent, stiffness, start) in [(1.4, 0.0, 0.1), (4.4, 6000.0, 1.0)] {
            let gas = StiffenedGas::new(StiffenedGasParameters {
                density: 1.2,
                exponent,
                stiffness,
                pressure: start,
            })
            .unwrap();
            let Start { energy, .. } = gas.start([0.0; 3]);
            assert!((pressure(&gas, 1.0, energy) - start).abs() < 1e-11);
            let closed: f64 = exponent * (start + stiffness);
            assert!((gas.bulk_modulus(1.0, energy) / closed - 1.0).abs() < 1e-12);
            slopes_and_bulk_modulus(&gas, &[0.4, 1.0, 3.0], energy);
        }
    }

    #[test]
    fn an_exponent_of_one_is_refused() {
        let gas =
            StiffenedGasParameters { density: 1.0, exponent: 1.0, stiffness: 0.0, pressure: 1.0 };
        assert!(matches!(StiffenedGas::new(gas), Err(Error::OutOfOrder { name: "exponent", .. })));
        let vacuum = StiffenedGasParameters { exponent: 1.4, pressure: 0.0, ..gas };
        assert!(matches!(StiffenedGas::new(vacuum), Err(Error::NotPositive { .. })));
    }
}
