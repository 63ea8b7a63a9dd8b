//! Schema of the quantity names, each with its meaning.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};
use smpm::Quantity;

/// Schema type of the name of a [`Quantity`].
#[derive(Debug, Clone, Copy)]
pub struct QuantityName;

impl JsonSchema for QuantityName {
    fn schema_name() -> Cow<'static, str> {
        "QuantityName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let name = |quantity: Quantity| -> Value {
            json!({ "type": "string", "const": quantity.to_string(), "description": meaning(quantity) })
        };
        let names: Vec<Value> = Quantity::all().map(name).collect();
        json_schema!({ "description": "Quantities, by their names; axes are 1, 2 and 3.", "oneOf": names })
    }
}

fn meaning(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Pressure => "Pressure (stress of `units`).",
        Quantity::Stress(..) => "A component of the stress (stress of `units`).",
        Quantity::Deviator(..) => "A component of the deviatoric stress (stress of `units`).",
        Quantity::VonMises => "Von Mises stress (stress of `units`).",
        Quantity::FlowStress => "Current flow stress (stress of `units`).",
        Quantity::PlasticStrain => "Equivalent plastic strain (no unit).",
        Quantity::Temperature => "Temperature rise above the reference state (K).",
        Quantity::Damage => "Damage, from 0 to 1 (no unit).",
        Quantity::Energy => "Internal energy per reference volume (stress of `units`).",
        Quantity::Density => "Mass per volume (density of `units`).",
        Quantity::Position(_) => "A coordinate (length of `units`).",
        Quantity::Velocity(_) => "A component of the velocity (length/time of `units`).",
    }
}
