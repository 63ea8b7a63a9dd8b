//! Named materials with the source of every constant, in any system of [`Units`].
//!
//! The functions give parameters over `f64`. [`map`](MieGruneisenParameters::map) makes some of them random:
//!
//! ```
//! use perturbation_moments::{Jet, Scalar};
//! use constitutive_models::{JohnsonCook, MieGruneisen, Solid, Units, library};
//!
//! // Steel whose A varies along the first direction of a jet.
//! let strength = library::steel_strength(Units::CM_G_US).map(|name, value| match name {
//!     "a" => Jet::variable(value, 0),
//!     _ => Jet::constant(value),
//! });
//! let steel = Solid {
//!     equation: MieGruneisen::new(
//!         library::steel_equation(Units::CM_G_US).map(|_, value| Jet::constant(value)),
//!     )?,
//!     strength: JohnsonCook::new(strength)?,
//! };
//! # let _ = steel;
//! # Ok::<(), constitutive_models::Error>(())
//! ```
//!
//! Each constant states how well it is known: *looked up* is what several public sources agree on, *from memory* is what no
//! look-up has confirmed, *chosen* is a choice of this library.

use super::{
    JohnsonCookDamageParameters, JohnsonCookParameters, JwlParameters, MieGruneisenParameters,
    Units, VonMisesParameters,
};

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
    JwlParameters {
        density: units.density(1630.0),
        a: units.stress(371.2e9),
        b: units.stress(3.231e9),
        r1: 4.15,
        r2: 0.95,
        omega: 0.30,
        energy: units.stress(7.0e9),
        detonation_speed: units.velocity(6930.0),
    }
}

/// Water; to be wrapped in a [`TensionCutOff`](super::TensionCutOff).
///
/// | constant | value | source |
/// |---|---|---|
/// | density | 1000 kg/m³ | chosen |
/// | C | 1480 m/s | chosen, from memory as Steinberg's (1987, 1996): no public code or page that has them was found |
/// | S1, S2, S3 | 2.56, -1.986, 0.2268 | likewise |
/// | gamma0, a | 0.5, 0 | likewise |
///
/// The effect of this choice, measured once on `contact_explosion.json` against `U_s = 1647 m/s + 1.921 u_p`, gamma0 = 0.1 and
/// 998 kg/m³ (also from memory). Until 9 us all gauges in the plate agree within 1e-4 of the largest value. Until 14 us means
/// differ by 0.1 % (flow stress), 3.7 % (S_11), 4.0 % (S_22) and 1.7 % (pressure) of the largest mean, standard deviations by at
/// most 0.1, 5, 9 and 2 %.
#[must_use]
pub fn water(units: Units) -> MieGruneisenParameters<f64> {
    MieGruneisenParameters {
        density: units.density(1000.0),
        sound_speed: units.velocity(1480.0),
        s1: 2.56,
        s2: -1.986,
        s3: 0.2268,
        gruneisen: 0.5,
        gruneisen_slope: 0.0,
    }
}

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
    MieGruneisenParameters {
        density: units.density(7830.0),
        sound_speed: units.velocity(4569.0),
        s1: 1.49,
        s2: 0.0,
        s3: 0.0,
        gruneisen: 2.17,
        gruneisen_slope: 0.46,
    }
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
    JohnsonCookParameters {
        shear_modulus: units.stress(77.5e9),
        a: units.stress(792e6),
        b: units.stress(510e6),
        n: 0.26,
        c: 0.014,
        m: 1.03,
        reference_rate: units.rate(1.0),
        rate_floor: 1.0,
        room_temperature: 294.0,
        melting_temperature: 1793.0,
        taylor_quinney: 0.9,
        density: units.density(7830.0),
        specific_heat: units.specific_heat(477.0),
    }
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
    JohnsonCookDamageParameters {
        d1: 0.05,
        d2: 3.44,
        d3: -2.12,
        d4: 0.002,
        d5: 0.61,
        spall_strength: units.stress(2.5e9),
    }
}

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
    MieGruneisenParameters {
        density: units.density(8930.0),
        sound_speed: units.velocity(3940.0),
        s1: 1.49,
        s2: 0.0,
        s3: 0.0,
        gruneisen: 1.96,
        gruneisen_slope: 0.0,
    }
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
    JohnsonCookParameters {
        shear_modulus: units.stress(117e9 / (2.0 * 1.35)),
        a: units.stress(90e6),
        b: units.stress(292e6),
        n: 0.31,
        c: 0.025,
        m: 1.09,
        reference_rate: units.rate(1.0),
        rate_floor: 1.0,
        room_temperature: 294.0,
        melting_temperature: 1356.0,
        taylor_quinney: 0.9,
        density: units.density(8930.0),
        specific_heat: units.specific_heat(383.0),
    }
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
    MieGruneisenParameters {
        density: units.density(2700.0),
        sound_speed: units.velocity(5240.0),
        s1: 1.40,
        s2: 0.0,
        s3: 0.0,
        gruneisen: 1.97,
        gruneisen_slope: 0.0,
    }
}

/// Mie-Grüneisen from density (kg/m³), sound speed (m/s), `S1` and `gamma0`; the other constants are zero.
fn shock(units: Units, constants: [f64; 4]) -> MieGruneisenParameters<f64> {
    let [density, sound_speed, s1, gruneisen] = constants;
    MieGruneisenParameters {
        density: units.density(density),
        sound_speed: units.velocity(sound_speed),
        s1,
        s2: 0.0,
        s3: 0.0,
        gruneisen,
        gruneisen_slope: 0.0,
    }
}

/// Johnson and Cook's flow stress from `G`, `A`, `B` (Pa), `n`, `C`, `m`, reference rate (1/s), melting temperature (K), density (kg/m³) and
/// specific heat (J/(kg K)); room at 294 K, a rate floor of one and nine tenths of the plastic work as heat are chosen.
fn flow(units: Units, constants: [f64; 10]) -> JohnsonCookParameters<f64> {
    let [shear, a, b, n, c, m, rate, melting_temperature, density, heat] = constants;
    JohnsonCookParameters {
        shear_modulus: units.stress(shear),
        a: units.stress(a),
        b: units.stress(b),
        n,
        c,
        m,
        reference_rate: units.rate(rate),
        rate_floor: 1.0,
        room_temperature: 294.0,
        melting_temperature,
        taylor_quinney: 0.9,
        density: units.density(density),
        specific_heat: units.specific_heat(heat),
    }
}

/// Johnson and Cook's fracture from `D1` to `D5` and the spall strength (Pa), infinite where nothing spalls.
fn fracture(
    units: Units,
    [d1, d2, d3, d4, d5, spall]: [f64; 6],
) -> JohnsonCookDamageParameters<f64> {
    JohnsonCookDamageParameters { d1, d2, d3, d4, d5, spall_strength: units.stress(spall) }
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
/// [`JohnsonCookDamage`](super::JohnsonCookDamage).
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

/// Composition B, its products by JWL.
///
/// | constant | value | source |
/// |---|---|---|
/// | density, A, omega | 1717 kg/m³, 524.2 GPa, 0.34 | Dobratz and Crawford 1985, looked up in a public code |
/// | B, R1, R2, E0, detonation speed | 7.678 GPa, 4.2, 1.1, 8.5 GPa, 7980 m/s | likewise, from memory |
#[must_use]
pub fn composition_b(units: Units) -> JwlParameters<f64> {
    JwlParameters {
        density: units.density(1717.0),
        a: units.stress(524.2e9),
        b: units.stress(7.678e9),
        r1: 4.2,
        r2: 1.1,
        omega: 0.34,
        energy: units.stress(8.5e9),
        detonation_speed: units.velocity(7980.0),
    }
}

/// Names of the entries of [`entry`]; each has some of the models.
pub const ENTRIES: [&str; 12] = [
    "steel",
    "steel_as_published",
    "weldox_460e",
    "tool_steel",
    "copper",
    "aluminium",
    "titanium",
    "tungsten_alloy",
    "lead",
    "water",
    "tnt",
    "composition_b",
];

/// The parameters of a model by their names, if the library has them under the name of an entry. The model is `mie_gruneisen`, `jwl`,
/// `von_mises`, `johnson_cook` or `damage`.
#[must_use]
pub fn entry(model: &str, name: &str, units: Units) -> Option<Vec<(&'static str, f64)>> {
    macro_rules! named {
        ($parameters:expr) => {{
            let mut named = Vec::new();
            let _ = $parameters.map(|name, value: f64| named.push((name, value)));
            Some(named)
        }};
    }
    match (model, name) {
        ("mie_gruneisen", "steel") => named!(steel_equation(units)),
        ("mie_gruneisen", "copper") => named!(copper_equation(units)),
        ("mie_gruneisen", "aluminium") => named!(aluminium_equation(units)),
        ("mie_gruneisen", "weldox_460e") => named!(weldox_460e_equation(units)),
        ("mie_gruneisen", "tool_steel") => named!(weldox_460e_equation(units)),
        ("mie_gruneisen", "titanium") => named!(titanium_equation(units)),
        ("mie_gruneisen", "tungsten_alloy") => named!(tungsten_alloy_equation(units)),
        ("mie_gruneisen", "lead") => named!(lead_equation(units)),
        ("mie_gruneisen", "water") => named!(water(units)),
        ("jwl", "tnt") => named!(tnt(units)),
        ("jwl", "composition_b") => named!(composition_b(units)),
        ("von_mises", "tool_steel") => named!(tool_steel_strength(units)),
        ("von_mises", "copper") => named!(copper_linear_hardening(units)),
        ("johnson_cook", "steel") => named!(steel_strength(units)),
        ("johnson_cook", "steel_as_published") => named!(steel_strength_as_published(units)),
        ("johnson_cook", "copper") => named!(copper_strength(units)),
        ("johnson_cook", "weldox_460e") => named!(weldox_460e_strength(units)),
        ("johnson_cook", "aluminium") => named!(aluminium_strength(units)),
        ("johnson_cook", "titanium") => named!(titanium_strength(units)),
        ("johnson_cook", "tungsten_alloy") => named!(tungsten_alloy_strength(units)),
        ("johnson_cook", "lead") => named!(lead_strength(units)),
        ("damage", "weldox_460e") => named!(weldox_460e_damage(units)),
        ("damage", "aluminium") => named!(aluminium_damage(units)),
        ("damage", "titanium") => named!(titanium_damage(units)),
        ("damage", "lead") => named!(lead_damage(units)),
        ("damage", "copper") => named!(copper_damage(units)),
        ("damage", "steel") => named!(steel_damage(units)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Detonation, JohnsonCook, JohnsonCookDamage, Jwl, MieGruneisen, VonMises};

    #[test]
    fn every_entry_can_be_made_in_every_system() {
        macro_rules! made {
            ($parameters:ident, $model:literal, $name:expr, $units:expr) => {
                entry($model, $name, $units).map(|found| {
                    $parameters::try_from_names(|name| {
                        let number = found.iter().find(|(known, _)| *known == name);
                        Ok::<f64, crate::Error>(number.unwrap().1)
                    })
                    .unwrap()
                })
            };
        }
        let mut n_models = 0;
        for units in [Units::SI, Units::CM_G_US, Units::MM_MG_US, Units::MM_TONNE_S] {
            for name in ENTRIES {
                let shock = made!(MieGruneisenParameters, "mie_gruneisen", name, units);
                let flow = made!(JohnsonCookParameters, "johnson_cook", name, units);
                let hardening = made!(VonMisesParameters, "von_mises", name, units);
                let products = made!(JwlParameters, "jwl", name, units);
                let breaks = made!(JohnsonCookDamageParameters, "damage", name, units);
                let has =
                    [shock.is_some(), flow.is_some(), hardening.is_some(), products.is_some()];
                assert!(has.contains(&true), "{name}");
                n_models += has.iter().filter(|&&has| has).count();
                let _ = shock.map(|it| MieGruneisen::new(it).unwrap());
                let _ = flow.map(|it| JohnsonCook::new(it).unwrap());
                let _ = hardening.map(|it| VonMises::new(it).unwrap());
                let burn = Detonation { point: [0.0; 3], cells: 1.0 };
                let _ = products.map(|it| Jwl::new(it, burn).unwrap());
                if let Some(breaks) = breaks {
                    JohnsonCookDamage::new(flow.unwrap(), breaks).unwrap();
                }
            }
        }
        assert_eq!(n_models % 4, 0);
        assert!(n_models / 4 > 15);
    }

    #[test]
    fn in_centimetre_gram_microsecond_they_read_as_in_the_literature() {
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-13, "{a} {b}");
        let strength = steel_strength(Units::CM_G_US);
        close(strength.a, 7.92e-3);
        close(strength.reference_rate, 1e-6);
        close(steel_strength_as_published(Units::CM_G_US).reference_rate, 1.0);
        close(steel_equation(Units::CM_G_US).sound_speed, 0.4569);
        close(copper_linear_hardening(Units::CM_G_US).yield_stress, 1.57e-3);
        close(copper_linear_hardening(Units::CM_G_US).hardening_modulus, 4.25e-3);
        close(tnt(Units::CM_G_US).a, 3.712);
        close(tnt(Units::CM_G_US).density, 1.63);
        // rho_0 c_p: megabar per kelvin.
        close(strength.density * strength.specific_heat, 7830.0 * 477.0 / 1e11);
    }
}
