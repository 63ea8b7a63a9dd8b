//! Schemas of material models: parameters by name, with their meanings, and the library entries.

use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};
use smpm::material::library::{ALL, entry};
use smpm::material::{
    ElasticBulkParameters, ElasticShearParameters, JohnsonCookDamageParameters,
    JohnsonCookParameters, JwlParameters, MieGruneisenParameters, NeoHookeanParameters,
    StiffenedGasParameters, Units, VonMisesParameters,
};

/// Quantities whose unit follows from the scene, as the solver names them.
const OF_UNITS: [&str; 5] =
    ["stress", "mass per volume", "length per time", "1 per time", "energy per mass and kelvin"];

/// A function that returns the schema of each model, by its key in a scene.
macro_rules! models {
    ($($name:ident: $parameters:ident;)+) => { $(
        pub(crate) fn $name(_: &mut SchemaGenerator) -> Schema {
            let (names, meanings) = ($parameters::<f64>::NAMES, $parameters::<f64>::MEANINGS);
            parameters(stringify!($name), names, meanings)
        }
    )+ };
}

models! {
    mie_gruneisen: MieGruneisenParameters;
    stiffened_gas: StiffenedGasParameters;
    jwl: JwlParameters;
    elastic_bulk: ElasticBulkParameters;
    neo_hookean: NeoHookeanParameters;
    elastic: ElasticShearParameters;
    von_mises: VonMisesParameters;
    johnson_cook: JohnsonCookParameters;
    damage: JohnsonCookDamageParameters;
}

/// Schema of a model: a library entry and overridden parameters, or all parameters where the library has none.
fn parameters(model: &str, names: &[&'static str], meanings: &[&str]) -> Schema {
    let library = |name: &str| entry(model, name, Units::SI);
    let parameter = |(&name, meaning): (&&str, &&str)| {
        (name.to_owned(), json!({ "description": of_units(meaning), "type": "number" }))
    };
    let mut numbers: Map<String, Value> = names.iter().zip(meanings).map(parameter).collect();
    let entries: Vec<&str> = ALL.iter().filter(|it| it.model == model).map(|it| it.name).collect();
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
        "Parameters that the library lacks, or that differ from it. The examples are those of `{first}` in `si`."
    );
    let mut anew = set(&about, &numbers, &[]);
    anew["examples"] = json!(examples);
    let about = "Library entry of the parameters; without it all must be set, or in the file of the material.";
    let entry = json!({ "description": about, "type": "string", "enum": entries });
    object(&json!({ "library": entry, "set": anew }), &[])
}

fn set(about: &str, numbers: &Map<String, Value>, required: &[&str]) -> Value {
    let mut set = Value::from(object(&json!(numbers), required));
    set["description"] = json!(about);
    set
}

/// An object with these keys and no others.
fn object(properties: &Value, required: &[&str]) -> Schema {
    json_schema!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

/// A meaning in terms of a scene, whose key `units` sets the units of its numbers.
fn of_units(meaning: &str) -> String {
    OF_UNITS.iter().fold(meaning.trim().to_owned(), |text, quantity| {
        text.replace(&format!("({quantity})"), &format!("({quantity} of `units`)"))
    })
}
