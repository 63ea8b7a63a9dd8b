//! Documentation of scenes: a JSON schema and a page of all keys for each solver.
//!
//! Both are generated from the scene types: their doc comments are the descriptions, and those of numbers state the
//! unit in parentheses. Examples on a page come from built-in scenes, or else from the type,
//! `#[schemars(example = ...)]`.

mod error;
mod example;
mod given;
mod page;
mod rows;
#[cfg(test)]
mod tests;
mod tree;
mod unit;
mod value;

use std::io::Write;
use std::path::{Path, PathBuf};

use result_figures::finite;
use serde_json::{Value, json};

pub use self::error::SchemaError;
use self::example::{BuiltIn, Examples};
pub use self::given::scene_keys;
use self::page::{Described, page_path, schema_path};
use self::rows::rows;
use self::tree::Tree;
use crate::kind::{KIND_KEY, SceneKind};
use crate::output::{OutputError, write_text};

/// A generated file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Document {
    /// Its path relative to the folder of documents.
    pub path: PathBuf,
    /// Its contents.
    pub text: String,
}

/// Generates the schema and the page of keys of every solver, and the page that lists them, with examples from the scenes in a folder.
///
/// # Errors
/// [`SchemaError`] for a number without unit, a key without example, or a scene that violates its schema.
pub fn documents(table: &[SceneKind], scenes: &Path) -> Result<Vec<Document>, SchemaError> {
    let scenes = example::built_in(scenes)?;
    let (mut documents, mut described) = (Vec::new(), Vec::new());
    for kind in table {
        let schema = schema_of(kind);
        let text = finite::to_json(&schema)?;
        documents.push(Document { path: schema_path(kind.solver), text });
        described.push(describe(kind.solver, &schema, &scenes)?);
    }
    let page = |of: &Described| Document { path: page_path(of.solver), text: page::page(of) };
    documents.extend(described.iter().map(page));
    documents.push(Document { path: "scenes.md".into(), text: page::overview(&described) });
    Ok(documents)
}

/// Writes [`documents`] into a folder and prints the paths.
///
/// # Errors
/// [`SchemaError`].
pub fn write(
    table: &[SceneKind],
    scenes: &Path,
    out: &Path,
    output: &mut dyn Write,
) -> Result<(), SchemaError> {
    for Document { path, text } in documents(table, scenes)? {
        let path = out.join(path);
        let refused = |source| OutputError::Io { path: path.clone(), source };
        write_text(&path, &text).map_err(refused)?;
        writeln!(output, "{}", path.display()).map_err(SchemaError::Print)?;
    }
    Ok(())
}

/// Defaults in the schema of a type, as an object. Tests compare them with what parsing gives.
#[must_use]
pub fn defaults<T: schemars::JsonSchema>() -> serde_json::Map<String, Value> {
    let schema = schemars::schema_for!(T);
    let properties = schema.get("properties").and_then(Value::as_object).into_iter().flatten();
    let given = properties.filter_map(|(key, property)| Some((key, property.get("default")?)));
    given.map(|(key, default)| (key.clone(), default.clone())).collect()
}

/// Schema of a scene kind; the key `solver` has one value.
fn schema_of(kind: &SceneKind) -> Value {
    let mut schema = Value::from((kind.schema)());
    schema["title"] = json!(format!("Scene of {}", kind.solver));
    schema["properties"][KIND_KEY]["const"] = json!(kind.solver);
    schema
}

fn describe(
    solver: &'static str,
    schema: &Value,
    scenes: &[BuiltIn],
) -> Result<Described, SchemaError> {
    let tree = Tree::read(solver, schema)?;
    let scenes: Vec<BuiltIn> =
        scenes.iter().filter(|scene| scene.value[KIND_KEY] == solver).cloned().collect();
    let examples = Examples::find(&tree, &scenes)?;
    let (mut without_unit, mut without_example) = (Vec::new(), Vec::new());
    for named in &tree.types {
        for row in rows(named) {
            let path = || rows::join(&named.name, &row.path);
            if row.needs_unit() && unit::split(row.about).is_none() {
                without_unit.push(path());
            }
            // A single word is its own example.
            if row.holds.is_some() && examples.of(&named.name, &row.path).is_none() {
                without_example.push(path());
            }
        }
    }
    if !without_unit.is_empty() {
        return Err(SchemaError::NoUnit { solver, keys: without_unit });
    }
    if !without_example.is_empty() {
        return Err(SchemaError::NoExample { solver, keys: without_example });
    }
    Ok(Described { solver, tree, scenes, examples })
}
