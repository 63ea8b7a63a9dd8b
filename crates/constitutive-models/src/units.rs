//! Consistent systems of units.

use crate::error::{Error, positive};

/// A system of units by its length, mass and time in SI; temperature is in kelvin in all of them.
///
/// ```
/// use constitutive_models::Units;
///
/// // Centimetre, gram, microsecond: stress in megabar.
/// assert_eq!(Units::CM_G_US.stress(1e11), 1.0);
/// assert!((Units::CM_G_US.velocity(6930.0) - 0.693).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    length: f64,
    mass: f64,
    time: f64,
}

impl Units {
    /// Metre, kilogram, second; pascal.
    pub const SI: Self = Self { length: 1.0, mass: 1.0, time: 1.0 };
    /// Centimetre, gram, microsecond; megabar.
    pub const CM_G_US: Self = Self { length: 1e-2, mass: 1e-3, time: 1e-6 };
    /// Millimetre, milligram, microsecond; gigapascal.
    pub const MM_MG_US: Self = Self { length: 1e-3, mass: 1e-6, time: 1e-6 };

    /// Millimetre, kilogram, millisecond; gigapascal.
    pub const MM_KG_MS: Self = Self { length: 1e-3, mass: 1.0, time: 1e-3 };
    /// Millimetre, gram, millisecond; megapascal.
    pub const MM_G_MS: Self = Self { length: 1e-3, mass: 1e-3, time: 1e-3 };
    /// Millimetre, tonne, second; megapascal.
    pub const MM_TONNE_S: Self = Self { length: 1e-3, mass: 1e3, time: 1.0 };

    /// The units of length (m), mass (kg) and time (s).
    ///
    /// # Errors
    /// [`Error::NotPositive`] for a unit that is not above zero.
    pub fn new(length: f64, mass: f64, time: f64) -> Result<Self, Error> {
        positive("unit of length", length)?;
        positive("unit of mass", mass)?;
        positive("unit of time", time)?;
        Ok(Self { length, mass, time })
    }

    /// Pascal into these units; energy per volume too.
    #[must_use]
    pub fn stress(&self, pascal: f64) -> f64 {
        pascal * (self.length * self.time * self.time) / self.mass
    }

    /// Kilograms per cubic metre into these units.
    #[must_use]
    pub fn density(&self, kilograms_per_cubic_metre: f64) -> f64 {
        kilograms_per_cubic_metre * (self.length * self.length * self.length) / self.mass
    }

    /// Metres per second into these units.
    #[must_use]
    pub fn velocity(&self, metres_per_second: f64) -> f64 {
        metres_per_second * self.time / self.length
    }

    /// One per second into these units.
    #[must_use]
    pub fn rate(&self, per_second: f64) -> f64 {
        per_second * self.time
    }

    /// Joule per kilogram and kelvin into these units.
    #[must_use]
    pub fn specific_heat(&self, joule_per_kilogram_kelvin: f64) -> f64 {
        joule_per_kilogram_kelvin * (self.time * self.time) / (self.length * self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_consistent() {
        for units in [
            Units::SI,
            Units::CM_G_US,
            Units::MM_MG_US,
            Units::MM_KG_MS,
            Units::MM_G_MS,
            Units::MM_TONNE_S,
            Units::new(0.3, 2.0, 7.0).unwrap(),
        ] {
            // rho v^2 is a stress, and rho c_p T one too.
            let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
            let kinetic = units.density(7830.0) * units.velocity(450.0).powi(2);
            assert!(close(kinetic, units.stress(7830.0 * 450.0 * 450.0)));
            let thermal = units.density(7830.0) * units.specific_heat(477.0);
            assert!(close(thermal, units.stress(7830.0 * 477.0)));
            assert!(close(units.rate(2.0), units.velocity(2.0) * units.length));
        }
        for (units, unit) in
            [(Units::MM_KG_MS, 1e9), (Units::MM_G_MS, 1e6), (Units::MM_TONNE_S, 1e6)]
        {
            assert!((units.stress(unit) - 1.0).abs() < 1e-15);
        }
        assert!(Units::new(1.0, 0.0, 1.0).is_err());
    }
}
