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

mod explosives;
mod other_metals;
mod steels;
mod water;

pub use self::explosives::{composition_b, tnt};
pub use self::other_metals::{
    aluminium_damage, aluminium_equation, aluminium_strength, copper_damage, copper_equation,
    copper_linear_hardening, copper_strength, lead_damage, lead_equation, lead_strength,
    titanium_damage, titanium_equation, titanium_strength, tungsten_alloy_equation,
    tungsten_alloy_strength,
};
pub use self::steels::{
    steel_damage, steel_equation, steel_strength, steel_strength_as_published, tool_steel_strength,
    weldox_460e_damage, weldox_460e_equation, weldox_460e_strength,
};
pub use self::water::water;
use super::{
    JohnsonCookDamageParameters, JohnsonCookParameters, JwlParameters, MieGruneisenParameters,
    Units,
};

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

/// Products by JWL from density (kg/m³), `A`, `B` (Pa), `R1`, `R2`, omega, `E0` (Pa) and detonation speed (m/s).
fn products(units: Units, constants: [f64; 8]) -> JwlParameters<f64> {
    let [density, a, b, r1, r2, omega, energy, detonation_speed] = constants;
    JwlParameters {
        density: units.density(density),
        a: units.stress(a),
        b: units.stress(b),
        r1,
        r2,
        omega,
        energy: units.stress(energy),
        detonation_speed: units.velocity(detonation_speed),
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

/// The parameters of a model that the library has under the name of a material.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// `mie_gruneisen`, `jwl`, `von_mises`, `johnson_cook` or `damage`.
    pub model: &'static str,
    /// The material.
    pub name: &'static str,
    /// Where the constants are from, in short; the functions of this module have a source for each.
    pub source: &'static str,
    /// The parameters by their names, in any units.
    pub parameters: fn(Units) -> Vec<(&'static str, f64)>,
}

macro_rules! all_entries {
    ($(($model:literal, $name:literal) => $constants:ident: $source:literal,)+) => {
        /// Every model of every material.
        pub const ALL: &[Entry] = &[$(Entry {
            model: $model,
            name: $name,
            source: $source,
            parameters: |units| {
                let mut named = Vec::new();
                let _ = $constants(units).map(|name, value: f64| named.push((name, value)));
                named
            },
        }),+];
    };
}

all_entries! {
    ("mie_gruneisen", "steel") => steel_equation: "density of 4340, shocks of stainless steel 304 by two public tables; table 2 of Chen et al. 2019",
    ("mie_gruneisen", "weldox_460e") => weldox_460e_equation: "as `steel`, at the density of Weldox 460 E",
    ("mie_gruneisen", "tool_steel") => weldox_460e_equation: "as `steel`, at the density of Weldox 460 E",
    ("mie_gruneisen", "copper") => copper_equation: "OFHC, the Taylor bar of MPM3D-F90",
    ("mie_gruneisen", "aluminium") => aluminium_equation: "the material database of Payette (Sandia); S2, S3 and a are not in it",
    ("mie_gruneisen", "titanium") => titanium_equation: "Ti-6Al-4V, from memory as Steinberg's",
    ("mie_gruneisen", "tungsten_alloy") => tungsten_alloy_equation: "7 % nickel and iron, from memory as Steinberg's of tungsten",
    ("mie_gruneisen", "lead") => lead_equation: "the debris cloud of MPM3D-F90",
    ("mie_gruneisen", "water") => water: "chosen, from memory as Steinberg's (1987, 1996)",
    ("jwl", "tnt") => tnt: "Dobratz and Crawford 1985",
    ("jwl", "composition_b") => composition_b: "Dobratz and Crawford 1985, in part from memory",
    ("von_mises", "tool_steel") => tool_steel_strength: "Børvik et al. 2001, from memory",
    ("von_mises", "copper") => copper_linear_hardening: "OFHC, the Taylor bar of MPM3D-F90",
    ("johnson_cook", "steel") => steel_strength: "4340, Johnson and Cook 1983; table 5 of Chen et al. 2019",
    ("johnson_cook", "steel_as_published") => steel_strength_as_published: "4340, Johnson and Cook 1983, with the reference rate and the heat that reproduce table 6 of Chen et al. 2019: not physical",
    ("johnson_cook", "weldox_460e") => weldox_460e_strength: "Børvik, Hopperstad, Berstad and Langseth 2002, in part from memory",
    ("johnson_cook", "copper") => copper_strength: "OFHC, Johnson and Cook 1983",
    ("johnson_cook", "aluminium") => aluminium_strength: "6061-T6, in part the material database of Payette (Sandia), in part from memory",
    ("johnson_cook", "titanium") => titanium_strength: "Ti-6Al-4V, from memory as Lesuer's (2000)",
    ("johnson_cook", "tungsten_alloy") => tungsten_alloy_strength: "7 % nickel and iron, Johnson and Cook 1983, from memory",
    ("johnson_cook", "lead") => lead_strength: "the debris cloud of MPM3D-F90",
    ("damage", "steel") => steel_damage: "4340, Johnson and Cook 1985; the spall strength is chosen",
    ("damage", "weldox_460e") => weldox_460e_damage: "Børvik et al. 2002, by a public code",
    ("damage", "copper") => copper_damage: "OFHC, Johnson and Cook 1985, from memory",
    ("damage", "aluminium") => aluminium_damage: "6061-T6, published in decks for LS-DYNA",
    ("damage", "titanium") => titanium_damage: "Ti-6Al-4V, Distefano et al. 2022, table 7",
    ("damage", "lead") => lead_damage: "the debris cloud of MPM3D-F90",
}

/// The parameters of a model by their names, if the library has them under the name of a material.
#[must_use]
pub fn entry(model: &str, name: &str, units: Units) -> Option<Vec<(&'static str, f64)>> {
    let of = |entry: &&Entry| (entry.model, entry.name) == (model, name);
    ALL.iter().find(of).map(|entry| (entry.parameters)(units))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Detonation, JohnsonCook, JohnsonCookDamage, Jwl, MieGruneisen, VonMises, VonMisesParameters,
    };

    #[test]
    fn every_entry_can_be_made_in_every_system() {
        macro_rules! made {
            ($parameters:ident, $model:literal, $name:expr, $units:expr) => {{
                let found = entry($model, $name, $units).unwrap();
                let of =
                    |name| Ok::<f64, crate::Error>(found.iter().find(|it| it.0 == name).unwrap().1);
                $parameters::try_from_names(of).unwrap()
            }};
        }
        assert!(ALL.len() > 20);
        for units in [Units::SI, Units::CM_G_US, Units::MM_MG_US, Units::MM_TONNE_S] {
            let flow = |name| made!(JohnsonCookParameters, "johnson_cook", name, units);
            for &Entry { model, name, source, .. } in ALL {
                assert!(!source.is_empty(), "{model} {name}");
                match model {
                    "mie_gruneisen" => drop(
                        MieGruneisen::new(made!(
                            MieGruneisenParameters,
                            "mie_gruneisen",
                            name,
                            units
                        ))
                        .unwrap(),
                    ),
                    "johnson_cook" => drop(JohnsonCook::new(flow(name)).unwrap()),
                    "von_mises" => drop(
                        VonMises::new(made!(VonMisesParameters, "von_mises", name, units)).unwrap(),
                    ),
                    "jwl" => {
                        let burn = Detonation { point: [0.0; 3], cells: 1.0 };
                        Jwl::new(made!(JwlParameters, "jwl", name, units), burn)
                            .map(|_| ())
                            .unwrap();
                    }
                    "damage" => {
                        let breaks = made!(JohnsonCookDamageParameters, "damage", name, units);
                        JohnsonCookDamage::new(flow(name), breaks).map(|_| ()).unwrap();
                    }
                    other => panic!("{other}"),
                }
            }
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
