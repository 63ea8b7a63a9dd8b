//! Steels.

use super::{flow, fracture, shock};
use crate::{
    JohnsonCookDamageParameters, JohnsonCookParameters, MieGruneisenParameters, Units,
    VonMisesParameters,
};

/// The steel of Chen et al. (2019): strength of 4340, equation of state of 304.
///
/// | constant | value | source |
/// |---|---|---|
/// | density | 7830 kg/m³ | 4340 steel, looked up; a table of shocks lists the other constants with 7896, as stainless steel 304 |
/// | C, S1 | 4569 m/s, 1.49 | looked up in two public tables |
/// | S2, S3 | 0, 0 | likewise |
/// | gamma0, a | 2.17, 0.46 | likewise; the paper's Table 2 |
#[must_use]
pub fn steel_equation(units: Units) -> MieGruneisenParameters<f64> {
    MieGruneisenParameters { gruneisen_slope: 0.46, ..shock(units, [7830.0, 4569.0, 1.49, 2.17]) }
}

/// 4340 steel.
///
/// | constant | value | source |
/// |---|---|---|
/// | A, B, n, C, m | 792 MPa, 510 MPa, 0.26, 0.014, 1.03 | Johnson and Cook 1983, looked up; the paper's Table 5 |
/// | reference rate | 1 1/s | Johnson and Cook 1983 |
/// | rate floor | 1 | chosen: the rate was not fitted below |
/// | G | 77.5 GPa | looked up in one public code |
/// | melting temperature | 1793 K | likewise |
/// | room temperature | 294 K | looked up: 293 to 295 in public tables |
/// | density, specific heat | 7830 kg/m³, 477 J/(kg K) | looked up |
/// | chi | 0.9 | likewise: Taylor and Quinney 1934 |
#[must_use]
pub fn steel_strength(units: Units) -> JohnsonCookParameters<f64> {
    flow(units, [77.5e9, 792e6, 510e6, 0.26, 0.014, 1.03, 1.0, 1793.0, 7830.0, 477.0])
}

/// 4340 steel with the two choices that reproduce Table 6 of Chen et al. (2019), not physical: the reference rate is one per
/// **microsecond**, in whatever units, so that `1 + C ln(rate)` is below one; plastic work does not heat.
///
/// The rate counts down to 1/s (floor 1e-6). All else is [`steel_strength`]. See docs/errata.md, eq 11.
#[must_use]
pub fn steel_strength_as_published(units: Units) -> JohnsonCookParameters<f64> {
    JohnsonCookParameters {
        reference_rate: units.rate(1e6),
        rate_floor: 1e-6,
        taylor_quinney: 0.0,
        ..steel_strength(units)
    }
}

/// Fracture of 4340 steel.
///
/// | constant | value | source |
/// |---|---|---|
/// | D1 to D5 | 0.05, 3.44, -2.12, 0.002, 0.61 | looked up in an input of 4340 for Abaqus and in a converter, which names Johnson and Cook 1985; `d3` by the triaxiality mean stress over equivalent stress, so below zero |
/// | spall strength | 2.5 GPa | chosen, of the order of spall tests on steels: give your own. It is the tension at which a particle breaks |
#[must_use]
pub fn steel_damage(units: Units) -> JohnsonCookDamageParameters<f64> {
    fracture(units, [0.05, 3.44, -2.12, 0.002, 0.61, 2.5e9])
}

/// The structural steel Weldox 460 E; with the equation of state of [`steel_equation`] at its density.
///
/// | constant | value | source |
/// |---|---|---|
/// | A, B, n, C | 490 MPa, 383 MPa, 0.45, 0.0114 | Børvik, Hopperstad, Berstad and Langseth 2002, looked up in a public deck that cites them |
/// | reference rate | 5e-4 1/s | likewise |
/// | m, melting temperature, specific heat | 0.94, 1800 K, 452 J/(kg K) | from memory, of the same authors |
/// | G | 200 GPa / (2 (1 + 0.33)) | the same deck |
#[must_use]
pub fn weldox_460e_strength(units: Units) -> JohnsonCookParameters<f64> {
    flow(units, [200e9 / 2.66, 490e6, 383e6, 0.45, 0.0114, 0.94, 5e-4, 1800.0, 7850.0, 452.0])
}

/// Shocks in the steel Weldox 460 E: [`steel_equation`] at its density.
#[must_use]
pub fn weldox_460e_equation(units: Units) -> MieGruneisenParameters<f64> {
    MieGruneisenParameters { density: units.density(7850.0), ..steel_equation(units) }
}

/// Fracture of the steel Weldox 460 E.
///
/// | constant | value | source |
/// |---|---|---|
/// | D1 to D5 | 0.0705, 1.732, -0.54, -0.0123, 0 | Børvik et al. 2002; looked up in a public code, under the name of steel |
/// | spall strength | none | give your own |
#[must_use]
pub fn weldox_460e_damage(units: Units) -> JohnsonCookDamageParameters<f64> {
    fracture(units, [0.0705, 1.732, -0.54, -0.0123, 0.0, f64::INFINITY])
}

/// Hardened tool steel of blunt projectiles (Arne).
///
/// | constant | value | source |
/// |---|---|---|
/// | G | 204 GPa / (2 (1 + 0.33)) | Børvik et al. 2001, from memory |
/// | yield stress, hardening modulus | 1900, 15000 MPa | likewise |
#[must_use]
pub fn tool_steel_strength(units: Units) -> VonMisesParameters<f64> {
    VonMisesParameters {
        shear_modulus: units.stress(204e9 / 2.66),
        yield_stress: units.stress(1900e6),
        hardening_modulus: units.stress(15e9),
    }
}
