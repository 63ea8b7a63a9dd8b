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

/// Aluminium 6061-T6. No strength: no source of its Johnson-Cook constants was found that could be checked.
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

/// Names of the entries of [`entry`]; each has some of the models.
pub const ENTRIES: [&str; 6] =
    ["steel", "steel_as_published", "copper", "aluminium", "water", "tnt"];

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
        ("mie_gruneisen", "water") => named!(water(units)),
        ("jwl", "tnt") => named!(tnt(units)),
        ("von_mises", "copper") => named!(copper_linear_hardening(units)),
        ("johnson_cook", "steel") => named!(steel_strength(units)),
        ("johnson_cook", "steel_as_published") => named!(steel_strength_as_published(units)),
        ("johnson_cook", "copper") => named!(copper_strength(units)),
        ("damage", "steel") => named!(steel_damage(units)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Detonation, JohnsonCook, JohnsonCookDamage, Jwl, MieGruneisen, VonMises};

    #[test]
    fn every_material_can_be_made_in_every_system() {
        for units in [Units::SI, Units::CM_G_US, Units::MM_MG_US] {
            for equation in [water, steel_equation, copper_equation, aluminium_equation] {
                MieGruneisen::new(equation(units)).unwrap();
            }
            for strength in [steel_strength, steel_strength_as_published, copper_strength] {
                JohnsonCook::new(strength(units)).unwrap();
            }
            VonMises::new(copper_linear_hardening(units)).unwrap();
            JohnsonCookDamage::new(steel_strength(units), steel_damage(units)).unwrap();
            Jwl::new(tnt(units), Detonation { point: [0.0; 3], cells: 1.0 }).unwrap();
        }
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
