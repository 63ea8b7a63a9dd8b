//! Pressure as a function of volume and energy.

mod elastic_bulk;
mod jwl;
mod mie_gruneisen;
mod stiffened_gas;
mod tension_cut_off;

use perturbation_moments::{Real, Scalar};

use crate::Now;
use crate::error::Fault;

pub use elastic_bulk::{ElasticBulk, ElasticBulkParameters};
pub use jwl::{Detonation, Jwl, JwlParameters};
pub use mie_gruneisen::{MieGruneisen, MieGruneisenParameters};
pub use stiffened_gas::{StiffenedGas, StiffenedGasParameters};
pub use tension_cut_off::TensionCutOff;

/// A pressure that is linear in the energy, `p = a + b e`, at one volume; or the derivatives of both by the volume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line<S> {
    /// The pressure at no energy (stress).
    pub a: S,
    /// The pressure per energy (pure number).
    pub b: S,
}

/// A particle before the first step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<S, T> {
    /// What the equation of state remembers.
    pub state: T,
    /// `e`, internal energy per reference volume (stress).
    pub energy: S,
    /// The pressure (stress).
    pub pressure: S,
}

/// An equation of state that is linear in the energy per reference volume, so that the energy of a step is found in closed
/// form:
///
/// $$ p = a(J) + b(J) e, \qquad J = V/V_0 $$
///
/// Four methods say all of a usual one. The others are for burn, for tension and for a range that ends.
pub trait EquationOfState<S: Real>: std::fmt::Debug + Send + Sync {
    /// What a particle remembers besides volume and energy; mostly `()`.
    type State: Copy + std::fmt::Debug + Send + Sync;

    /// Whether the pressure depends on the energy at all; false says that `b` is zero at every volume, and is not looked at.
    const KNOWS_ENERGY: bool = true;

    /// `rho_0 > 0` (mass per volume).
    fn density(&self) -> S;

    /// A particle at `t = 0`; `position` has zeros beyond the dimension.
    fn start(&self, position: [f64; 3]) -> Start<S, Self::State>
    where
        S: Scalar;

    /// `a` and `b` at `J = volume`.
    fn line(&self, volume: S) -> Line<S>;

    /// `da/dJ` and `db/dJ` at `J = volume`.
    fn slope(&self, volume: S) -> Line<S>;

    /// Advances what is remembered; the share of the pressure that acts, `None` for all of it.
    #[inline(always)]
    fn advance(&self, _now: &Now<S>, _state: &mut Self::State) -> Option<S> {
        None
    }

    /// Calls with every number that a state is made of, always in the same order: what is written there is the new state.
    /// Snapshots need it; false, the default of states that hold anything, says that there can be none.
    #[inline(always)]
    fn visit_numbers(&self, _state: &mut Self::State, _visit: impl FnMut(&mut S)) -> bool {
        size_of::<Self::State>() == 0
    }

    /// Calls with every number that it is made of, with those that follow from others, always in the same order: what is written
    /// there is the new number. [`Varying`](crate::Varying) needs it; false, the default, says that not all that may differ
    /// between particles is shown.
    #[inline(always)]
    fn visit_constants(&mut self, _visit: impl FnMut(&mut S)) -> bool {
        false
    }

    /// The least pressure that the material bears, `None` for any.
    #[inline(always)]
    fn least_pressure(&self) -> Option<S> {
        None
    }

    /// Refuses a volume at which there is no pressure.
    ///
    /// # Errors
    /// What is out of range there.
    #[inline(always)]
    fn admit(&self, _volume: S) -> Result<(), Fault> {
        Ok(())
    }

    /// `rho dp/drho` at constant entropy, where `de = -p dJ`:
    ///
    /// $$ K = J \left( b p - \frac{da}{dJ} - \frac{db}{dJ} e \right) $$
    #[inline(always)]
    fn bulk_modulus(&self, volume: S, energy: S) -> S {
        let (line, slope) = (self.line(volume), self.slope(volume));
        let pressure = at_least(line.a + line.b * energy, self.least_pressure());
        (line.b * pressure - slope.a - slope.b * energy) * volume
    }
}

/// The pressure, or the least one that is borne.
#[inline(always)]
pub(crate) fn at_least<S: Real>(pressure: S, least: Option<S>) -> S {
    match least {
        Some(least) => S::select(pressure.less(least), least, pressure),
        None => pressure,
    }
}

#[cfg(test)]
pub(crate) mod laws {
    use perturbation_moments::Scalar;

    use super::EquationOfState;

    /// The slopes against central differences of the lines, and the bulk modulus against the pressure along a short isentrope.
    pub(crate) fn slopes_and_bulk_modulus<E: EquationOfState<f64>>(
        equation: &E,
        volumes: &[f64],
        energy: f64,
    ) {
        let scale = equation.bulk_modulus(1.0, energy);
        for &volume in volumes {
            // Truncation h^2 and roundoff 1e-16/h.
            let h = 1e-5;
            let (above, below) = (equation.line(volume + h), equation.line(volume - h));
            let slope = equation.slope(volume);
            assert!(
                (slope.a - (above.a - below.a) / (2.0 * h)).abs() < 1e-7 * scale,
                "a, {volume}"
            );
            assert!((slope.b - (above.b - below.b) / (2.0 * h)).abs() < 1e-7, "b, {volume}");
            let line = equation.line(volume);
            let pressure = line.a + line.b * energy;
            // The energy to second order along the isentrope: e' = -p, e'' = K/J.
            let modulus = equation.bulk_modulus(volume, energy);
            let along = |h: f64| {
                let line = equation.line(volume + h);
                line.a + line.b * (energy - pressure * h + 0.5 * modulus / volume * h * h)
            };
            let difference = -volume * (along(h) - along(-h)) / (2.0 * h);
            assert!((modulus - difference).abs() < 1e-7 * scale, "{modulus} {difference}");
        }
    }

    /// The pressure of a line at an energy.
    pub(crate) fn pressure<S: Scalar, E: EquationOfState<S>>(
        equation: &E,
        volume: S,
        energy: S,
    ) -> S {
        let line = equation.line(volume);
        line.a + line.b * energy
    }
}
