//! What in the constants of a scene is likely to be a mistake of units: said as a note, never changed.

use result_figures::number::short;
use scene_runs::scene::Objection;
use smpm::material::JohnsonCookDamageParameters;

use super::material_scene::MaterialPart::{self, Damage, Equation, Strength};
use super::material_units::unit;
use crate::scene::SmpmScene;

/// A constant: its part and name, the range in SI in which those of real materials lie, and what another value may be.
type Usual = (MaterialPart, &'static str, [f64; 2], &'static str);

/// From aerogel to osmium, from the slowest plastics to diamond, from lead to water, with room to spare.
const USUAL: [Usual; 7] = [
    (Equation, "density", [0.05, 25_000.0], "a density of another system of units"),
    (Equation, "sound_speed", [100.0, 20_000.0], "a speed of another system of units"),
    (Equation, "s1", [0.0, 4.0], "the slope of a shock speed has no unit"),
    (Strength, "shear_modulus", [1e4, 1e12], "a stress of another system of units"),
    (Strength, "specific_heat", [50.0, 15_000.0], "a heat of another system of units"),
    (Strength, "reference_rate", [1e-5, 1e4], "a rate in 1/s with another unit of time"),
    (Strength, "melting_temperature", [200.0, 5000.0], "a temperature in another unit"),
];

/// Shear modulus over `rho c^2`, of all solids with a sound speed; ten times too far on either side.
const STIFFNESS: [f64; 2] = [1e-4, 10.0];

impl SmpmScene {
    /// A note for each constant of a material that no real material has, with the likely mistake.
    ///
    /// # Errors
    /// Those of [`Self::numbers`].
    pub(crate) fn implausible(&self) -> Result<Vec<String>, Objection> {
        let units = self.units.units()?;
        let mut notes = Vec::new();
        for (material, numbers) in self.numbers()? {
            let of = |part, name| numbers.get(&(part, name)).copied();
            for (part, name, [low, high], mistake) in USUAL {
                let (in_si_unit, of_si) = unit(name);
                let one = of_si(&units, 1.0);
                let Some(value) = of(part, name) else { continue };
                let in_si = value / one;
                if in_si < low || in_si > high {
                    let [is, low, high, in_si] =
                        [value, low, high, in_si].map(|number| short(Some(number)));
                    let likely = short(Some(value * one));
                    notes.push(format!(
                        "material `{material}`: {name} {is} is {in_si} {in_si_unit}; materials have {low} to {high}: {mistake}? {is} {in_si_unit} would be {likely}"
                    ));
                }
            }
            let damage = |name| of(Damage, name).ok_or(());
            if let Ok(damage) = JohnsonCookDamageParameters::try_from_names(damage)
                && let Some(from) = damage.brittle_from()
            {
                notes.push(format!(
                    "material `{material}`: D1 + D2 exp(D3 eta) is below zero from a triaxiality eta of {} on; 1e-6 is taken there, so that it breaks at once",
                    short(Some(from))
                ));
            }
            let stiffness = of(Strength, "shear_modulus")
                .zip(of(Equation, "density"))
                .zip(of(Equation, "sound_speed"))
                .map(|((shear, density), speed)| shear / (density * speed * speed));
            if let Some(stiffness) =
                stiffness.filter(|it| !(STIFFNESS[0]..=STIFFNESS[1]).contains(it))
            {
                notes.push(format!(
                    "material `{material}`: shear modulus over density times sound speed squared is {}; solids have 0.01 to 1: one of the three is of another system of units?",
                    short(Some(stiffness))
                ));
            }
        }
        Ok(notes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn notes(change: impl FnOnce(&mut Value)) -> Vec<String> {
        let text = include_str!("../../../../tests/scenes/smpm/taylor_bar.json");
        let mut scene: Value = serde_json::from_str(text).unwrap();
        scene["materials"]["copper"]["strength"] =
            json!({ "johnson_cook": { "library": "copper" } });
        change(&mut scene);
        SmpmScene::read("scene.json", &scene.to_string()).unwrap().implausible().unwrap()
    }

    #[test]
    fn constants_of_another_system_of_units_are_noted_with_what_they_would_be() {
        assert_eq!(notes(|_| ()), Vec::<String>::new());
        for (part, name, value, says) in [
            ("strength/johnson_cook", "reference_rate", 1.0, "1.00e-6"),
            ("strength/johnson_cook", "specific_heat", 383.0, "J/(kg K) would be"),
            ("equation/mie_gruneisen", "density", 8.93e-6, "kg/m^3"),
            ("equation/mie_gruneisen", "s1", 1490.0, "slope"),
        ] {
            let found = notes(|scene| {
                let materials = scene["materials"].as_object_mut().unwrap();
                let material = materials.values_mut().next().unwrap();
                if name == "density" {
                    // Both densities of the material.
                    material["strength"]["johnson_cook"]["set"] = json!({ "density": value });
                }
                material.pointer_mut(&format!("/{part}")).unwrap()["set"][name] = json!(value);
            });
            assert!(found.iter().any(|it| it.contains(name) && it.contains(says)), "{found:?}");
        }
    }

    #[test]
    fn a_card_whose_strain_at_fracture_is_below_zero_is_noted() {
        let found = notes(|scene| {
            let material = &mut scene["materials"]["copper"];
            material["damage"] =
                json!({ "set": { "d1": -0.77, "d2": 1.45, "d3": -0.47, "d4": 0, "d5": 1.6 } });
        });
        assert!(found.len() == 1 && found[0].contains("a triaxiality eta of 1.35"), "{found:?}");
    }
}
