//! What may stand under the models of a material: the parameters by name, with what each is, and the entries of the library.

use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};
use smpm::material::{
    ElasticBulkParameters, ElasticShearParameters, JohnsonCookDamageParameters,
    JohnsonCookParameters, JwlParameters, MieGruneisenParameters, NeoHookeanParameters,
    StiffenedGasParameters, Units, VonMisesParameters,
};

use super::material_scene::{
    EquationScene, LIBRARY, Library, Names, ParameterScene, StrengthScene, damage_library,
};

/// Quantities whose unit follows from that of the scene, as the solver calls them.
const OF_UNITS: [&str; 5] =
    ["stress", "mass per volume", "length per time", "1 per time", "energy per mass and kelvin"];

/// A function that gives the schema of a model: its parameters, and an empty scene of it that knows its library.
macro_rules! models {
    ($($name:ident: $parameters:ident, $library:expr;)+) => { $(
        pub(super) fn $name(_: &mut SchemaGenerator) -> Schema {
            let (names, meanings) = ($parameters::<f64>::NAMES, $parameters::<f64>::MEANINGS);
            parameters(names, meanings, $library)
        }
    )+ };
}

const NONE: ParameterScene = ParameterScene::NONE;

models! {
    mie_gruneisen: MieGruneisenParameters, |name| EquationScene::MieGruneisen(NONE).library(name, Units::SI);
    stiffened_gas: StiffenedGasParameters, |name| EquationScene::StiffenedGas(NONE).library(name, Units::SI);
    jwl: JwlParameters, |name| EquationScene::Jwl(NONE).library(name, Units::SI);
    elastic_bulk: ElasticBulkParameters, |name| EquationScene::ElasticBulk(NONE).library(name, Units::SI);
    neo_hookean: NeoHookeanParameters, |name| EquationScene::NeoHookean(NONE).library(name, Units::SI);
    elastic: ElasticShearParameters, |name| StrengthScene::Elastic(NONE).library(name, Units::SI);
    von_mises: VonMisesParameters, |name| StrengthScene::VonMises(NONE).library(name, Units::SI);
    johnson_cook: JohnsonCookParameters, |name| StrengthScene::JohnsonCook(NONE).library(name, Units::SI);
    damage: JohnsonCookDamageParameters, |name| damage_library(name, Units::SI);
}

/// What stands under a model: an entry of the library and what is set anew, or all parameters where the library has none.
fn parameters(names: Names, meanings: Names, library: impl Fn(&str) -> Option<Library>) -> Schema {
    let parameter = |(&name, meaning): (&&'static str, &&str)| {
        (name.to_owned(), json!({ "description": of_units(meaning), "type": "number" }))
    };
    let mut numbers: Map<String, Value> = names.iter().zip(meanings).map(parameter).collect();
    let entries: Vec<&str> = LIBRARY.into_iter().filter(|name| library(name).is_some()).collect();
    let Some(first) = entries.first() else {
        return object(&json!({ "set": set("All parameters.", &numbers, names) }), &["set"]);
    };
    let mut examples = Vec::new();
    for (name, value) in library(first).unwrap_or_default() {
        numbers[name]["examples"] = json!([value]);
        examples.push(json!({ name: value }));
    }
    examples.truncate(1);
    let about = format!(
        "Parameters that the library does not have, or has otherwise. The examples are those of `{first}` in `si`."
    );
    let mut anew = set(&about, &numbers, &[]);
    anew["examples"] = json!(examples);
    let about = "The entry of the library whose parameters are taken; without it all must be set.";
    let entry = json!({ "description": about, "type": "string", "enum": entries });
    object(&json!({ "library": entry, "set": anew }), &[])
}

fn set(about: &str, numbers: &Map<String, Value>, required: &[&str]) -> Value {
    let mut set = Value::from(object(&json!(numbers), required));
    set["description"] = json!(about);
    set
}

/// An object of these keys and no others.
fn object(properties: &Value, required: &[&str]) -> Schema {
    json_schema!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

/// A meaning in the words of a scene, whose key `units` says in which units its numbers are.
fn of_units(meaning: &str) -> String {
    OF_UNITS.iter().fold(meaning.trim().to_owned(), |text, quantity| {
        text.replace(&format!("({quantity})"), &format!("({quantity} of `units`)"))
    })
}

pub(super) fn air() -> EquationScene {
    let numbers = [("density", 1.2), ("exponent", 1.4), ("stiffness", 0.0), ("pressure", 1e5)];
    EquationScene::StiffenedGas(ParameterScene::of_numbers(&numbers))
}

pub(super) fn bulk() -> EquationScene {
    let numbers = [("density", 2700.0), ("bulk_modulus", 70e9)];
    EquationScene::ElasticBulk(ParameterScene::of_numbers(&numbers))
}

pub(super) fn rubber() -> EquationScene {
    let numbers = [("density", 1100.0), ("shear_modulus", 0.5e6), ("bulk_modulus", 25e6)];
    EquationScene::NeoHookean(ParameterScene::of_numbers(&numbers))
}

pub(super) fn shear() -> StrengthScene {
    StrengthScene::Elastic(ParameterScene::of_numbers(&[("shear_modulus", 26e9)]))
}

pub(super) fn hardening() -> StrengthScene {
    let numbers = [("shear_modulus", 77.5e9), ("yield_stress", 400e6), ("hardening_modulus", 1e9)];
    StrengthScene::VonMises(ParameterScene::of_numbers(&numbers))
}
