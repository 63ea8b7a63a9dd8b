//! A schema of schemars, parsed into the forms that a page can show.

use serde_json::{Map, Value};

use super::error::SchemaError;

/// All types of a scene, the scene itself first, the others in reading order.
pub(super) struct Tree {
    pub(super) types: Vec<Named>,
}

/// A named type.
pub(super) struct Named {
    /// Name of the Rust type, e.g. `WindowScene`.
    pub(super) name: String,
    pub(super) about: String,
    pub(super) holds: Holds,
    /// Examples given with the type.
    pub(super) examples: Vec<Value>,
}

/// Kind of a value.
pub(super) enum Holds {
    Text,
    Number,
    Whole,
    Flag,
    /// A list of any length, or of a fixed length.
    List(Box<Holds>, Option<u64>),
    /// A map with keys chosen by the user.
    Map(Box<Holds>),
    Object(Vec<Key>),
    Choice(Vec<Variant>),
    /// Another type of the tree.
    Named(String),
}

/// A key of an object.
pub(super) struct Key {
    pub(super) name: String,
    pub(super) about: String,
    pub(super) presence: Presence,
    pub(super) holds: Holds,
    /// Examples given with the key.
    pub(super) examples: Vec<Value>,
}

/// Whether a key is required.
pub(super) enum Presence {
    Required,
    /// Default value.
    Default(Value),
    /// Optional; the description states the effect of its absence.
    Optional,
}

/// One of several values.
pub(super) struct Variant {
    /// Its word; none where the form of the value identifies it.
    pub(super) name: Option<String>,
    pub(super) about: String,
    /// Value of which the word is the key; none for a single word.
    pub(super) holds: Option<Holds>,
}

const DEFINITIONS: &str = "#/$defs/";

impl Tree {
    pub(super) fn read(solver: &'static str, schema: &Value) -> Result<Self, SchemaError> {
        let mut tree = Self { types: Vec::new() };
        let mut reader = Reader { solver, definitions: &schema["$defs"], waiting: Vec::new() };
        tree.types.push(reader.named("scene", schema)?);
        // Depth first: the types that a type uses follow it.
        let mut waiting = reader.take_waiting();
        while let Some(name) = waiting.pop() {
            if tree.get(&name).is_none() {
                let definition = &reader.definitions[&name];
                tree.types.push(reader.named(&name, definition)?);
                waiting.extend(reader.take_waiting());
            }
        }
        Ok(tree)
    }

    pub(super) fn get(&self, name: &str) -> Option<&Named> {
        self.types.iter().find(|named| named.name == name)
    }

    /// The type of the scene itself.
    pub(super) fn root(&self) -> &Named {
        &self.types[0]
    }
}

struct Reader<'a> {
    solver: &'static str,
    definitions: &'a Value,
    /// Types that were named and not yet parsed.
    waiting: Vec<String>,
}

impl Reader<'_> {
    /// Types named since the last call, the last one first.
    fn take_waiting(&mut self) -> Vec<String> {
        let mut names = std::mem::take(&mut self.waiting);
        names.reverse();
        names
    }

    fn named(&mut self, name: &str, schema: &Value) -> Result<Named, SchemaError> {
        let (holds, examples) = (self.holds(name, schema)?, examples(schema));
        Ok(Named { name: name.to_owned(), about: about(schema), holds, examples })
    }

    fn holds(&mut self, place: &str, schema: &Value) -> Result<Holds, SchemaError> {
        if let Some(name) = schema["$ref"].as_str().and_then(|path| path.strip_prefix(DEFINITIONS))
        {
            self.waiting.push(name.to_owned());
            return Ok(Holds::Named(name.to_owned()));
        }
        if let Some(choices) = schema["anyOf"].as_array() {
            return self.any_of(place, choices);
        }
        if let Some(choices) = schema["oneOf"].as_array() {
            let variants: Result<Vec<_>, _> =
                choices.iter().map(|choice| self.variants(place, choice)).collect();
            return Ok(Holds::Choice(variants?.into_iter().flatten().collect()));
        }
        if schema.get("const").or_else(|| schema.get("enum")).is_some() {
            let mut words = self.variants(place, schema)?;
            // The description belongs to the key, which has it.
            for word in &mut words {
                word.about.clear();
            }
            return Ok(Holds::Choice(words));
        }
        match kind(schema) {
            Some("string") => Ok(Holds::Text),
            Some("number") => Ok(Holds::Number),
            Some("integer") => Ok(Holds::Whole),
            Some("boolean") => Ok(Holds::Flag),
            Some("array") => {
                let (least, most) = (schema["minItems"].as_u64(), schema["maxItems"].as_u64());
                let count = most.filter(|_| least == most);
                Ok(Holds::List(Box::new(self.holds(place, &schema["items"])?), count))
            }
            Some("object") => self.object(place, schema),
            _ => Err(self.form(place, schema)),
        }
    }

    fn object(&mut self, place: &str, schema: &Value) -> Result<Holds, SchemaError> {
        let Some(properties) = schema["properties"].as_object() else {
            if schema["additionalProperties"] == false {
                return Ok(Holds::Object(Vec::new()));
            }
            return Ok(Holds::Map(Box::new(self.holds(place, &schema["additionalProperties"])?)));
        };
        let required = schema["required"].as_array().map_or(&[][..], Vec::as_slice);
        let key = |(name, property): (&String, &Value)| {
            let place = format!("{place}.{name}");
            Ok(Key {
                name: name.clone(),
                about: about(property),
                presence: match &property["default"] {
                    _ if required.iter().any(|key| key == name) => Presence::Required,
                    Value::Null => Presence::Optional,
                    default => Presence::Default(default.clone()),
                },
                holds: self.holds(&place, property)?,
                examples: examples(property),
            })
        };
        properties.iter().map(key).collect::<Result<_, _>>().map(Holds::Object)
    }

    /// Several forms; an optional form is that form.
    fn any_of(&mut self, place: &str, choices: &[Value]) -> Result<Holds, SchemaError> {
        let choices: Vec<&Value> =
            choices.iter().filter(|choice| kind(choice) != Some("null")).collect();
        if let [only] = choices[..] {
            return self.holds(place, only);
        }
        let variant = |choice: &&Value| {
            let holds = Some(self.holds(place, choice)?);
            Ok(Variant { name: None, about: about(choice), holds })
        };
        choices.iter().map(variant).collect::<Result<_, _>>().map(Holds::Choice)
    }

    /// The words of an externally tagged enum: alone, or the only key of an object.
    fn variants(&mut self, place: &str, schema: &Value) -> Result<Vec<Variant>, SchemaError> {
        let word = |word: &Value| {
            let name = word.as_str().map(str::to_owned).ok_or_else(|| self.form(place, schema))?;
            Ok(Variant { name: Some(name), about: about(schema), holds: None })
        };
        if let Some(constant) = schema.get("const") {
            return Ok(vec![word(constant)?]);
        }
        if let Some(words) = schema["enum"].as_array() {
            return words.iter().map(word).collect();
        }
        let properties = schema["properties"].as_object().map(Map::iter);
        let mut properties = properties.into_iter().flatten();
        let (Some((name, property)), None) = (properties.next(), properties.next()) else {
            return Err(self.form(place, schema));
        };
        let holds = Some(self.holds(&format!("{place}.{name}"), property)?);
        Ok(vec![Variant { name: Some(name.clone()), about: about(schema), holds }])
    }

    fn form(&self, place: &str, schema: &Value) -> SchemaError {
        let (solver, place) = (self.solver, place.to_owned());
        SchemaError::Form { solver, place, schema: schema.to_string() }
    }
}

/// The type that a schema names, besides `null`.
fn kind(schema: &Value) -> Option<&str> {
    match &schema["type"] {
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).find(|kind| *kind != "null"),
        kind => kind.as_str(),
    }
}

fn examples(schema: &Value) -> Vec<Value> {
    schema["examples"].as_array().cloned().unwrap_or_default()
}

/// A description on one line.
fn about(schema: &Value) -> String {
    let words = schema["description"].as_str().unwrap_or_default();
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}
