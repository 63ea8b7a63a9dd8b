//! Systems of units of a scene, and of a file that it names.

use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smpm::Quantity;
use smpm::material::Units;

/// Systems of units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Factors { length: 0.0254, mass: 175.127, time: 1.0 })]
pub enum UnitsScene {
    /// Metre, kilogram, second; stress in pascal.
    Si,
    /// Centimetre, gram, microsecond; stress in megabar.
    CmGUs,
    /// Millimetre, milligram, microsecond; stress in gigapascal.
    MmMgUs,
    /// Millimetre, kilogram, millisecond; stress in gigapascal.
    MmKgMs,
    /// Millimetre, gram, millisecond; stress in megapascal.
    MmGMs,
    /// Millimetre, tonne, second; stress in megapascal.
    MmTonneS,
    /// Any other: its units of length, mass and time in SI.
    Factors {
        /// The unit of length (m).
        length: f64,
        /// The unit of mass (kg).
        mass: f64,
        /// The unit of time (s).
        time: f64,
    },
}

impl UnitsScene {
    /// Units of the scene.
    ///
    /// # Errors
    /// An [`Objection`] to a factor that is not above zero.
    pub fn units(self) -> Result<Units, Objection> {
        Ok(match self {
            Self::Si => Units::SI,
            Self::CmGUs => Units::CM_G_US,
            Self::MmMgUs => Units::MM_MG_US,
            Self::MmKgMs => Units::MM_KG_MS,
            Self::MmGMs => Units::MM_G_MS,
            Self::MmTonneS => Units::MM_TONNE_S,
            Self::Factors { length, mass, time } => Units::new(length, mass, time)
                .map_err(|error| Objection::new("units.factors", error.to_string()))?,
        })
    }

    /// Names of length, time, stress, density and velocity.
    #[must_use]
    pub const fn names(self) -> [&'static str; 5] {
        match self {
            Self::Si => ["m", "s", "Pa", "kg/m^3", "m/s"],
            Self::CmGUs => ["cm", "us", "Mbar", "g/cm^3", "cm/us"],
            Self::MmMgUs => ["mm", "us", "GPa", "mg/mm^3", "mm/us"],
            Self::MmKgMs => ["mm", "ms", "GPa", "kg/mm^3", "mm/ms"],
            Self::MmGMs => ["mm", "ms", "MPa", "g/mm^3", "mm/ms"],
            Self::MmTonneS => ["mm", "s", "MPa", "t/mm^3", "mm/s"],
            Self::Factors { .. } => ["L", "T", "M/(L T^2)", "M/L^3", "L/T"],
        }
    }

    /// Unit of a quantity; empty for a dimensionless one.
    #[must_use]
    pub const fn of(self, quantity: Quantity) -> &'static str {
        let [length, _, stress, density, velocity] = self.names();
        match quantity {
            Quantity::PlasticStrain | Quantity::Damage => "",
            Quantity::Temperature => "K",
            Quantity::Density => density,
            Quantity::Position(_) => length,
            Quantity::Velocity(_) => velocity,
            _ => stress,
        }
    }
}
