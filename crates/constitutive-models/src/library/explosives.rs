//! Explosives: their products by JWL.

use super::products;
use crate::{JwlParameters, Units};

/// Trinitrotoluene, its products by JWL.
///
/// | constant | value | source |
/// |---|---|---|
/// | density | 1630 kg/m³ | Dobratz and Crawford 1985 (LLNL handbook), looked up in public codes |
/// | A, B | 371.2, 3.231 GPa | likewise |
/// | R1, R2, omega | 4.15, 0.95, 0.30 | likewise; tables with omega = 0.35 and E0 = 6 GPa exist |
/// | E0 | 7.0 GPa | likewise; with it the detonation of Chapman and Jouguet has D = 6929 m/s and p = 21.0 GPa |
/// | detonation speed | 6930 m/s | likewise |
#[must_use]
pub fn tnt(units: Units) -> JwlParameters<f64> {
    products(units, [1630.0, 371.2e9, 3.231e9, 4.15, 0.95, 0.30, 7.0e9, 6930.0])
}

/// Composition B, its products by JWL.
///
/// | constant | value | source |
/// |---|---|---|
/// | density, A, omega | 1717 kg/m³, 524.2 GPa, 0.34 | Dobratz and Crawford 1985, looked up in a public code |
/// | B, R1, R2, E0, detonation speed | 7.678 GPa, 4.2, 1.1, 8.5 GPa, 7980 m/s | likewise, from memory |
#[must_use]
pub fn composition_b(units: Units) -> JwlParameters<f64> {
    products(units, [1717.0, 524.2e9, 7.678e9, 4.2, 1.1, 0.34, 8.5e9, 7980.0])
}
