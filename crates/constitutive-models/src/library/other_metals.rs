//! Metals that are no steels.

use super::{flow, fracture, shock};
use crate::{
    JohnsonCookDamageParameters, JohnsonCookParameters, MieGruneisenParameters, Units,
    VonMisesParameters,
};

/// Copper, OFHC.
///
/// | constant | value | source |
/// |---|---|---|
/// | density | 8930 kg/m³ | the Taylor bar of a public code (MPM3D-F90), looked up |
/// | C, S1 | 3940 m/s, 1.49 | likewise |
/// | S2, S3, a | 0, 0, 0 | likewise |
/// | gamma0 | 1.96 | likewise; Steinberg 1996 has 2.02 |
#[must_use]
pub fn copper_equation(units: Units) -> MieGruneisenParameters<f64> {
    shock(units, [8930.0, 3940.0, 1.49, 1.96])
}

/// Copper, OFHC, hardening linearly: the constants with which MPM3D-F90 runs its Taylor bar.
///
/// | constant | value | source |
/// |---|---|---|
/// | G | 43.33 GPa | E = 117 GPa and nu = 0.35 of the Taylor bar of MPM3D-F90, looked up |
/// | yield stress, hardening modulus | 157, 425 MPa | likewise: `sjc 157.0 425.0 1.0 0.0`, Johnson and Cook's form with n = 1, C = 0 and no heat |
///
/// Whether they were fitted to the bar of Johnson and Holmquist (1988) at 190 m/s, which they reproduce, the input does not
/// say. [`copper_strength`] has the constants of other tests; the Taylor bars distinguish them (docs/methods/smpm.md).
#[must_use]
pub fn copper_linear_hardening(units: Units) -> VonMisesParameters<f64> {
    VonMisesParameters {
        shear_modulus: units.stress(117e9 / (2.0 * 1.35)),
        yield_stress: units.stress(157e6),
        hardening_modulus: units.stress(425e6),
    }
}

/// Copper, OFHC.
///
/// | constant | value | source |
/// |---|---|---|
/// | A, B, n, C, m | 90 MPa, 292 MPa, 0.31, 0.025, 1.09 | Johnson and Cook 1983, looked up in public tables |
/// | reference rate, melting temperature | 1 1/s, 1356 K | likewise |
/// | rate floor | 1 | chosen |
/// | G | 43.33 GPa | E = 117 GPa and nu = 0.35 of the Taylor bar of MPM3D-F90, looked up |
/// | room temperature | 294 K | looked up |
/// | density, specific heat | 8930 kg/m³, 383 J/(kg K) | looked up; other tables have 8960 kg/m³ |
/// | chi | 0.9 | chosen: Taylor and Quinney 1934 |
#[must_use]
pub fn copper_strength(units: Units) -> JohnsonCookParameters<f64> {
    let shear = 117e9 / (2.0 * 1.35);
    flow(units, [shear, 90e6, 292e6, 0.31, 0.025, 1.09, 1.0, 1356.0, 8930.0, 383.0])
}

/// Aluminium 6061-T6.
///
/// | constant | value | source |
/// |---|---|---|
/// | density | 2700 kg/m³ | material database of Payette (Sandia), looked up |
/// | C, S1 | 5240 m/s, 1.40 | likewise |
/// | S2, S3, a | 0, 0, 0 | not in the database |
/// | gamma0 | 1.97 | likewise |
#[must_use]
pub fn aluminium_equation(units: Units) -> MieGruneisenParameters<f64> {
    shock(units, [2700.0, 5240.0, 1.40, 1.97])
}

/// Aluminium 6061-T6.
///
/// | constant | value | source |
/// |---|---|---|
/// | A, B, n, C, m | 324 MPa, 114 MPa, 0.42, 0.002, 1.34 | B and n looked up in the material database of Payette (Sandia); the others from memory, as in decks for LS-DYNA |
/// | G, melting temperature, specific heat | 26 GPa, 925 K, 896 J/(kg K) | G and heat likewise looked up; the temperature from memory |
/// | reference rate | 1 1/s | from memory |
#[must_use]
pub fn aluminium_strength(units: Units) -> JohnsonCookParameters<f64> {
    flow(units, [26e9, 324e6, 114e6, 0.42, 0.002, 1.34, 1.0, 925.0, 2700.0, 896.0])
}

/// Fracture of aluminium 6061-T6. Above a triaxiality of 1.35 its strain at fracture by triaxiality is below zero: see
/// [`JohnsonCookDamage`](crate::JohnsonCookDamage).
///
/// | constant | value | source |
/// |---|---|---|
/// | D1 to D5 | -0.77, 1.45, -0.47, 0, 1.6 | published in decks for LS-DYNA |
/// | spall strength | none | give your own |
#[must_use]
pub fn aluminium_damage(units: Units) -> JohnsonCookDamageParameters<f64> {
    fracture(units, [-0.77, 1.45, -0.47, 0.0, 1.6, f64::INFINITY])
}

/// Titanium Ti-6Al-4V.
///
/// | constant | value | source |
/// |---|---|---|
/// | density, C, S1, gamma0 | 4428 kg/m³, 5130 m/s, 1.028, 1.23 | from memory, as Steinberg's |
#[must_use]
pub fn titanium_equation(units: Units) -> MieGruneisenParameters<f64> {
    shock(units, [4428.0, 5130.0, 1.028, 1.23])
}

/// Titanium Ti-6Al-4V.
///
/// | constant | value | source |
/// |---|---|---|
/// | A, B, n, C, m | 1098 MPa, 1092 MPa, 0.93, 0.014, 1.1 | from memory, as Lesuer's (2000) |
/// | G, melting temperature, specific heat, reference rate | 41.9 GPa, 1878 K, 580 J/(kg K), 1 1/s | likewise |
#[must_use]
pub fn titanium_strength(units: Units) -> JohnsonCookParameters<f64> {
    flow(units, [41.9e9, 1098e6, 1092e6, 0.93, 0.014, 1.1, 1.0, 1878.0, 4428.0, 580.0])
}

/// Fracture of titanium Ti-6Al-4V.
///
/// | constant | value | source |
/// |---|---|---|
/// | D1 to D5 | -0.09, 0.25, -0.5, 0.014, 3.87 | Distefano et al. 2022, table 7, looked up; they name Zhang et al. 2015 |
/// | spall strength | none | give your own |
#[must_use]
pub fn titanium_damage(units: Units) -> JohnsonCookDamageParameters<f64> {
    fracture(units, [-0.09, 0.25, -0.5, 0.014, 3.87, f64::INFINITY])
}

/// Tungsten alloy, 7 % nickel and iron.
///
/// | constant | value | source |
/// |---|---|---|
/// | density, C, S1, gamma0 | 17000 kg/m³, 4029 m/s, 1.23, 1.54 | from memory, as Steinberg's of tungsten |
#[must_use]
pub fn tungsten_alloy_equation(units: Units) -> MieGruneisenParameters<f64> {
    shock(units, [17000.0, 4029.0, 1.23, 1.54])
}

/// Tungsten alloy, 7 % nickel and iron.
///
/// | constant | value | source |
/// |---|---|---|
/// | A, B, n, C, m | 1506 MPa, 177 MPa, 0.12, 0.016, 1.0 | Johnson and Cook 1983, from memory |
/// | G, melting temperature, specific heat, reference rate | 160 GPa, 1723 K, 134 J/(kg K), 1 1/s | likewise |
#[must_use]
pub fn tungsten_alloy_strength(units: Units) -> JohnsonCookParameters<f64> {
    flow(units, [160e9, 1506e6, 177e6, 0.12, 0.016, 1.0, 1.0, 1723.0, 17000.0, 134.0])
}

/// Lead.
///
/// | constant | value | source |
/// |---|---|---|
/// | density, C, S1, gamma0 | 11350 kg/m³, 2092 m/s, 1.45, 2.0 | the debris cloud of a public code (MPM3D-F90), looked up |
#[must_use]
pub fn lead_equation(units: Units) -> MieGruneisenParameters<f64> {
    shock(units, [11350.0, 2092.0, 1.45, 2.0])
}

/// Lead.
///
/// | constant | value | source |
/// |---|---|---|
/// | G, A, B, n, C, m | 7.9 GPa, 12 MPa, 125 MPa, 1, 0, 1 | the debris cloud of MPM3D-F90, looked up |
/// | melting temperature, specific heat | 600 K, 129 J/(kg K) | likewise |
#[must_use]
pub fn lead_strength(units: Units) -> JohnsonCookParameters<f64> {
    flow(units, [7.9e9, 12e6, 125e6, 1.0, 0.0, 1.0, 1.0, 600.0, 11350.0, 129.0])
}

/// Fracture of lead: at a plastic strain of three, or a tension of 150 MPa.
///
/// | constant | value | source |
/// |---|---|---|
/// | D1, spall strength | 3, 150 MPa | the debris cloud of MPM3D-F90, looked up |
#[must_use]
pub fn lead_damage(units: Units) -> JohnsonCookDamageParameters<f64> {
    fracture(units, [3.0, 0.0, 0.0, 0.0, 0.0, 150e6])
}

/// Fracture of OFHC copper.
///
/// | constant | value | source |
/// |---|---|---|
/// | D1 to D5 | 0.54, 4.89, -3.03, 0.014, 1.12 | Johnson and Cook 1985, from memory |
/// | spall strength | none | give your own |
#[must_use]
pub fn copper_damage(units: Units) -> JohnsonCookDamageParameters<f64> {
    fracture(units, [0.54, 4.89, -3.03, 0.014, 1.12, f64::INFINITY])
}
