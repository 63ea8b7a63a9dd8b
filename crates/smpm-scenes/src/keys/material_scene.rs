//! Materials of a scene: library parameters, overridden parameters, random parameters.

use std::collections::BTreeMap;

use result_figures::number::tidy;
use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smpm::material::library::{ALL, entry};
use smpm::material::{
    Detonation, ElasticBulk, ElasticBulkParameters, ElasticShear, ElasticShearParameters, Fluid,
    JohnsonCook, JohnsonCookDamage, JohnsonCookDamageParameters, JohnsonCookParameters, Jwl,
    JwlParameters, MieGruneisen, MieGruneisenParameters, Model, NeoHookean, NeoHookeanParameters,
    Solid, StiffenedGas, StiffenedGasParameters, TensionCutOff, Units, VonMises,
    VonMisesParameters,
};
use smpm::{Number, ParameterError};

use super::keyword_file_scene::KeywordFileScene;
pub use super::material_part::{MaterialPart, Numbers};
use super::material_schema;

/// A material: equation of state and strength model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialScene {
    /// Equation of state: pressure.
    pub equation: EquationScene,
    /// Strength model: deviatoric stress; a fluid without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strength: Option<StrengthScene>,
    /// Johnson-Cook damage, for the strength `johnson_cook` only; none without this key. With `spall_strength` alone a particle fails by
    /// tension and by nothing else; without it, by strain and by nothing else. Where the strength is
    /// of a `keyword_file`, the constants that are not set are too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "material_schema::damage", example = ParameterScene::of_library("steel"))]
    pub damage: Option<ParameterScene>,
    /// Largest tension of a fluid (stress of `units`); unlimited without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tension_limit: Option<f64>,
    /// File with constants that neither `set` nor `library` of a part gives; none without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = KeywordFileScene::example())]
    pub keyword_file: Option<KeywordFileScene>,
    /// Programmed burn of an explosive; required with `jwl`, and only valid with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detonation: Option<DetonationScene>,
}

/// An equation of state with its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::air(), example = Self::bulk(), example = Self::rubber())]
pub enum EquationScene {
    /// Mie-Grüneisen: a solid or a liquid from its shock Hugoniot.
    MieGruneisen(#[schemars(schema_with = "material_schema::mie_gruneisen")] ParameterScene),
    /// A stiffened gas; an ideal gas with `stiffness` 0.
    StiffenedGas(#[schemars(schema_with = "material_schema::stiffened_gas")] ParameterScene),
    /// Jones-Wilkins-Lee with programmed burn: an explosive.
    Jwl(#[schemars(schema_with = "material_schema::jwl")] ParameterScene),
    /// A constant bulk modulus; with the strength `elastic`.
    ElasticBulk(#[schemars(schema_with = "material_schema::elastic_bulk")] ParameterScene),
    /// A compressible neo-Hookean solid: pressure and deviatoric stress together.
    NeoHookean(#[schemars(schema_with = "material_schema::neo_hookean")] ParameterScene),
}

/// A strength with its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::shear(), example = Self::hardening())]
pub enum StrengthScene {
    /// Linear elastic.
    Elastic(#[schemars(schema_with = "material_schema::elastic")] ParameterScene),
    /// A flow stress that increases linearly with the plastic strain.
    VonMises(#[schemars(schema_with = "material_schema::von_mises")] ParameterScene),
    /// Johnson-Cook: flow stress of a metal from strain, rate and temperature.
    JohnsonCook(#[schemars(schema_with = "material_schema::johnson_cook")] ParameterScene),
}

/// Parameters by name: a library entry in the units of the scene, and overridden values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterScene {
    /// Library entry of the parameters; without it all must be set, or in the file of the material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub library: Option<String>,
    /// Parameters that the library lacks, or that differ from it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, f64>,
}

/// A programmed burn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DetonationScene {
    /// Detonation point (length of `units`).
    pub point: Vec<f64>,
    /// Number of cells over which the front is spread (no unit).
    pub cells: f64,
}

type Names = &'static [&'static str];

/// Relative difference within which two densities are those of one material: sources for a metal differ by one to three per cent, and
/// its heating by as much.
const SAME_DENSITY: f64 = 0.05;

impl EquationScene {
    fn air() -> Self {
        let numbers = [("density", 1.2), ("exponent", 1.4), ("stiffness", 0.0), ("pressure", 1e5)];
        Self::StiffenedGas(ParameterScene::of_numbers(&numbers))
    }

    fn bulk() -> Self {
        let numbers = [("density", 2700.0), ("bulk_modulus", 70e9)];
        Self::ElasticBulk(ParameterScene::of_numbers(&numbers))
    }

    fn rubber() -> Self {
        let numbers = [("density", 1100.0), ("shear_modulus", 0.5e6), ("bulk_modulus", 25e6)];
        Self::NeoHookean(ParameterScene::of_numbers(&numbers))
    }

    /// The key, the parameter names and the given values.
    fn parts(&self) -> (&'static str, Names, &ParameterScene) {
        match self {
            Self::MieGruneisen(given) => {
                ("mie_gruneisen", MieGruneisenParameters::<f64>::NAMES, given)
            }
            Self::StiffenedGas(given) => {
                ("stiffened_gas", StiffenedGasParameters::<f64>::NAMES, given)
            }
            Self::Jwl(given) => ("jwl", JwlParameters::<f64>::NAMES, given),
            Self::ElasticBulk(given) => {
                ("elastic_bulk", ElasticBulkParameters::<f64>::NAMES, given)
            }
            Self::NeoHookean(given) => ("neo_hookean", NeoHookeanParameters::<f64>::NAMES, given),
        }
    }
}

impl StrengthScene {
    fn shear() -> Self {
        Self::Elastic(ParameterScene::of_numbers(&[("shear_modulus", 26e9)]))
    }

    fn hardening() -> Self {
        let numbers =
            [("shear_modulus", 77.5e9), ("yield_stress", 400e6), ("hardening_modulus", 1e9)];
        Self::VonMises(ParameterScene::of_numbers(&numbers))
    }

    /// Takes all parameters that are not overridden from another library entry.
    pub fn take_from(&mut self, library: &str) {
        let (Self::Elastic(given) | Self::VonMises(given) | Self::JohnsonCook(given)) = self;
        given.library = Some(library.to_owned());
    }

    pub(super) fn parts(&self) -> (&'static str, Names, &ParameterScene) {
        match self {
            Self::Elastic(given) => ("elastic", ElasticShearParameters::<f64>::NAMES, given),
            Self::VonMises(given) => ("von_mises", VonMisesParameters::<f64>::NAMES, given),
            Self::JohnsonCook(given) => {
                ("johnson_cook", JohnsonCookParameters::<f64>::NAMES, given)
            }
        }
    }
}

/// Names of the library that have a model.
fn with_model(model: &str) -> Vec<&'static str> {
    ALL.iter().filter(|entry| entry.model == model).map(|entry| entry.name).collect()
}

impl ParameterScene {
    fn of_numbers(numbers: &[(&str, f64)]) -> Self {
        let set = numbers.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        Self { library: None, set }
    }

    fn of_library(name: &str) -> Self {
        Self { library: Some(name.to_owned()), set: BTreeMap::new() }
    }

    /// Every parameter of a part, by name; `model` is the key of its model.
    fn read(
        &self,
        (part, model, names): (MaterialPart, &str, Names),
        units: Units,
        path: &str,
        of_file: &Numbers,
        numbers: &mut Numbers,
    ) -> Result<(), Objection> {
        let otherwise = |name: &'static str| {
            of_file.get(&(part, name)).copied().or_else(|| self.default_of(part, name, numbers))
        };
        let base = match &self.library {
            None => Vec::new(),
            Some(name) => entry(model, name, units).ok_or_else(|| {
                let message = format!("the library has no `{name}` for this model");
                Objection::new(format!("{path}.library"), message)
                    .with_help(format!("it has {}", with_model(model).join(", ")))
            })?,
        };
        if let Some(name) = self.set.keys().find(|name| !names.contains(&name.as_str())) {
            let message = format!("there is no parameter `{name}`");
            let all = || format!("available: {}", names.join(", "));
            let objection = Objection::new(format!("{path}.set.{name}"), message);
            return Err(objection.with_nearest(name, names, all));
        }
        let mut read = Vec::new();
        for &name in names {
            let of_library = || base.iter().find(|(known, _)| *known == name).map(|(_, v)| *v);
            let given = self.set.get(name).copied().or_else(of_library);
            let value = given.or_else(|| otherwise(name)).ok_or_else(|| {
                let message = format!("the parameter `{name}` is missing");
                Objection::new(path, message).with_help(format!(
                    "give it under `set`, or a `library`; the model needs {}",
                    names.join(", ")
                ))
            })?;
            read.push(((part, name), value));
        }
        numbers.extend(read);
        Ok(())
    }

    /// A parameter that may be left out: the density of the strength is that of the equation of state; without a spall strength
    /// nothing spalls, and with it alone nothing is damaged by strain.
    fn default_of(&self, part: MaterialPart, name: &str, numbers: &Numbers) -> Option<f64> {
        match (part, name) {
            (MaterialPart::Strength, "density") => {
                numbers.get(&(MaterialPart::Equation, "density")).copied()
            }
            (MaterialPart::Damage, "spall_strength") => Some(f64::INFINITY),
            (MaterialPart::Damage, _) if self.set.keys().eq(["spall_strength"]) => {
                Some(if name == "d1" { f64::INFINITY } else { 0.0 })
            }
            _ => None,
        }
    }
}

impl MaterialScene {
    /// Its models: part, key, names of the parameters, and those given.
    pub(crate) fn models(&self) -> Vec<(MaterialPart, &'static str, Names, &ParameterScene)> {
        let (key, names, given) = self.equation.parts();
        let mut models = vec![(MaterialPart::Equation, key, names, given)];
        if let Some((key, names, given)) = self.strength.as_ref().map(StrengthScene::parts) {
            models.push((MaterialPart::Strength, key, names, given));
        }
        let names = JohnsonCookDamageParameters::<f64>::NAMES;
        models.extend(self.damage.iter().map(|it| (MaterialPart::Damage, "damage", names, it)));
        models
    }

    /// All its parameters.
    ///
    /// # Errors
    /// An [`Objection`] to a missing or unknown parameter, and to incompatible parts.
    pub fn numbers(&self, units: Units, path: &str) -> Result<Numbers, Objection> {
        let mut numbers = Numbers::new();
        let read = self.keyword_file.as_ref().and_then(|file| file.read.as_ref());
        let of_file = read.map(|(_, constants)| &constants.numbers);
        let none = Numbers::new();
        for (part, key, names, given) in self.models() {
            let at = match part {
                MaterialPart::Equation => format!("{path}.equation.{key}"),
                MaterialPart::Strength => format!("{path}.strength.{key}"),
                MaterialPart::Damage => format!("{path}.damage"),
            };
            given.read((part, key, names), units, &at, of_file.unwrap_or(&none), &mut numbers)?;
        }
        self.check_parts(path)?;
        Self::check_density(&numbers, path)?;
        Ok(numbers)
    }

    /// The strength heats the density of the equation of state.
    fn check_density(numbers: &Numbers, path: &str) -> Result<(), Objection> {
        let of = |part| numbers.get(&(part, "density")).copied();
        let pair = of(MaterialPart::Equation).zip(of(MaterialPart::Strength));
        let Some((equation, strength)) =
            pair.filter(|(a, b)| (a - b).abs() > SAME_DENSITY * a.abs())
        else {
            return Ok(());
        };
        let message = format!(
            "the density of the strength is {}, that of the equation of state {}: plastic work would heat another mass",
            tidy(strength),
            tidy(equation)
        );
        let help = format!("write \"density\": {} under `set` of the strength", tidy(equation));
        Err(Objection::new(format!("{path}.strength"), message).with_help(help))
    }

    fn check_parts(&self, path: &str) -> Result<(), Objection> {
        use EquationScene as E;
        use StrengthScene as Y;
        let known = matches!(
            (&self.equation, &self.strength),
            (E::MieGruneisen(_), _)
                | (E::StiffenedGas(_) | E::Jwl(_) | E::NeoHookean(_), None)
                | (E::ElasticBulk(_), Some(Y::Elastic(_)))
        );
        if !known {
            let message = "this equation of state does not go with this strength";
            return Err(Objection::new(path, message).with_help(
                "mie_gruneisen goes with any; elastic_bulk with elastic; stiffened_gas, jwl and neo_hookean with none",
            ));
        }
        if self.damage.is_some() && !matches!(self.strength, Some(Y::JohnsonCook(_))) {
            let message = "damage goes with the strength `johnson_cook` only";
            return Err(Objection::new(format!("{path}.damage"), message));
        }
        let fluid = matches!((&self.equation, &self.strength), (E::MieGruneisen(_), None));
        if self.tension_limit.is_some() && !fluid {
            let message = "a tension limit goes with `mie_gruneisen` without strength only";
            return Err(Objection::new(format!("{path}.tension_limit"), message)
                .with_help(
                    "a solid spalls by `damage`: {\"set\": {\"spall_strength\": ..}} with the strength johnson_cook",
                ));
        }
        if matches!(self.equation, E::Jwl(_)) != self.detonation.is_some() {
            let message = "`detonation` goes with `jwl`, and `jwl` with it";
            return Err(Objection::new(path, message));
        }
        Ok(())
    }

    /// Key of a parameter such as `equation.s1`.
    ///
    /// # Errors
    /// An [`Objection`] at `path` with the nearest name.
    pub fn parameter(
        numbers: &Numbers,
        name: &str,
        path: &str,
    ) -> Result<(MaterialPart, &'static str), Objection> {
        let words: Vec<(String, (MaterialPart, &'static str))> = numbers
            .keys()
            .map(|&(part, name)| {
                let word =
                    MaterialPart::ALL.iter().find(|(p, _)| *p == part).map_or("", |(_, word)| word);
                (format!("{word}.{name}"), (part, name))
            })
            .collect();
        words.iter().find(|(word, _)| word == name).map(|(_, key)| *key).ok_or_else(|| {
            let message = format!("the material has no parameter `{name}`");
            let words: Vec<&str> = words.iter().map(|(word, _)| word.as_str()).collect();
            Objection::new(path, message)
                .with_nearest(name, &words, || "e.g. `equation.s1` or `strength.a`".to_owned())
        })
    }

    /// The material with numbers that may be random, of a scene whose parts go together.
    ///
    /// # Errors
    /// Errors of the model.
    pub fn model<S: Number>(
        &self,
        of: &dyn Fn(MaterialPart, &'static str) -> S,
    ) -> Result<Model<S>, ParameterError> {
        let given = |part: MaterialPart| {
            move |name: &'static str| -> Result<S, ParameterError> { Ok(of(part, name)) }
        };
        let (equation, strength) = (given(MaterialPart::Equation), given(MaterialPart::Strength));
        Ok(match &self.equation {
            EquationScene::StiffenedGas(_) => {
                let equation =
                    StiffenedGas::new(StiffenedGasParameters::try_from_names(equation)?)?;
                Solid { equation, strength: Fluid }.into()
            }
            EquationScene::Jwl(_) => {
                let burn = self.detonation.as_ref();
                let coordinate =
                    |k: usize| burn.and_then(|burn| burn.point.get(k)).copied().unwrap_or(0.0);
                let detonation = Detonation {
                    point: std::array::from_fn(coordinate),
                    cells: burn.map_or(0.0, |burn| burn.cells),
                };
                let equation = Jwl::new(JwlParameters::try_from_names(equation)?, detonation)?;
                Solid { equation, strength: Fluid }.into()
            }
            EquationScene::ElasticBulk(_) => {
                let equation = ElasticBulk::new(ElasticBulkParameters::try_from_names(equation)?)?;
                let parameters = ElasticShearParameters::try_from_names(strength)?;
                Solid { equation, strength: ElasticShear::new(parameters)? }.into()
            }
            EquationScene::NeoHookean(_) => {
                NeoHookean::new(NeoHookeanParameters::try_from_names(equation)?)?.into()
            }
            EquationScene::MieGruneisen(_) => {
                let equation =
                    MieGruneisen::new(MieGruneisenParameters::try_from_names(equation)?)?;
                match (&self.strength, self.tension_limit) {
                    (None, Some(limit)) => {
                        let equation = TensionCutOff::new(equation, S::constant(limit))?;
                        Solid { equation, strength: Fluid }.into()
                    }
                    (None, None) => Solid { equation, strength: Fluid }.into(),
                    (Some(StrengthScene::Elastic(_)), _) => {
                        let parameters = ElasticShearParameters::try_from_names(strength)?;
                        Solid { equation, strength: ElasticShear::new(parameters)? }.into()
                    }
                    (Some(StrengthScene::VonMises(_)), _) => {
                        let parameters = VonMisesParameters::try_from_names(strength)?;
                        Solid { equation, strength: VonMises::new(parameters)? }.into()
                    }
                    (Some(StrengthScene::JohnsonCook(_)), _) => {
                        let flow = JohnsonCookParameters::try_from_names(strength)?;
                        if self.damage.is_none() {
                            return Ok(Solid { equation, strength: JohnsonCook::new(flow)? }.into());
                        }
                        let damage = given(MaterialPart::Damage);
                        let damage = JohnsonCookDamageParameters::try_from_names(damage)?;
                        Solid { equation, strength: JohnsonCookDamage::new(flow, damage)? }.into()
                    }
                }
            }
        })
    }
}
