//! Examples: for each key the first in a built-in scene, else that of its type.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::error::SchemaError;
use super::rows::{Row, is_list_of_words, join, label, rows};
use super::tree::{Holds, Tree};
use crate::scene::SceneFile;
use crate::scene::folder::files_by_name;

/// A built-in scene.
#[derive(Debug, Clone)]
pub(super) struct BuiltIn {
    /// Folder and name, e.g. `fpk/duffing`.
    pub(super) name: String,
    pub(super) value: Value,
}

/// A value and its scene; none for an example of a type.
pub(super) struct Example {
    pub(super) value: Value,
    pub(super) scene: Option<String>,
}

/// Examples by type and path.
#[derive(Default)]
pub(super) struct Examples(BTreeMap<(String, String), Example>);

/// Scenes in the subfolders of a folder, by name.
pub(super) fn built_in(folder: &Path) -> Result<Vec<BuiltIn>, SchemaError> {
    let files = files_by_name(folder);
    let files = files.map_err(|(path, source)| SchemaError::Folder { path, source })?;
    let scene = |(name, path): (String, PathBuf)| {
        Ok(BuiltIn { name, value: SceneFile::read(&path)?.keys().clone() })
    };
    files.into_iter().map(scene).collect()
}

impl Examples {
    pub(super) fn find(tree: &Tree, scenes: &[BuiltIn]) -> Result<Self, SchemaError> {
        let mut examples = Self::default();
        for scene in scenes {
            let mut walk = Walk { tree, scene: Some(&scene.name), found: &mut examples };
            walk.value(&tree.root().name, "", &tree.root().holds, &scene.value)?;
        }
        for named in &tree.types {
            let mut walk = Walk { tree, scene: None, found: &mut examples };
            for example in &named.examples {
                walk.value(&named.name, "", &named.holds, example)?;
            }
            for Row { path, holds, examples, .. } in rows(named) {
                for example in examples {
                    walk.note(&named.name, &path, example);
                    holds.map_or(Ok(()), |holds| walk.value(&named.name, &path, holds, example))?;
                }
            }
        }
        Ok(examples)
    }

    pub(super) fn of(&self, named: &str, path: &str) -> Option<&Example> {
        self.0.get(&(named.to_owned(), path.to_owned()))
    }
}

/// Traverses a value together with its schema.
struct Walk<'a> {
    tree: &'a Tree,
    scene: Option<&'a str>,
    found: &'a mut Examples,
}

impl Walk<'_> {
    /// Records the value at a path of a type, and all values below it.
    fn value(
        &mut self,
        named: &str,
        path: &str,
        holds: &Holds,
        value: &Value,
    ) -> Result<(), SchemaError> {
        match (holds, value) {
            (Holds::Named(name), _) => match self.tree.get(name) {
                Some(inner) => self.value(name, "", &inner.holds, value),
                None => Err(self.misfit(named, path, value)),
            },
            (Holds::Object(keys), Value::Object(map)) => {
                map.iter().try_for_each(|(name, value)| {
                    let path = join(path, name);
                    let key = keys.iter().find(|key| key.name == *name);
                    let key = key.ok_or_else(|| self.misfit(named, &path, value))?;
                    self.note(named, &path, value);
                    self.value(named, &path, &key.holds, value)
                })
            }
            (Holds::Choice(_), _) => self.choice(named, path, holds, value),
            (Holds::List(of, count), Value::Array(list))
                if count.is_none_or(|count| count == list.len() as u64) =>
            {
                list.iter().try_for_each(|value| self.value(named, path, of, value))
            }
            (Holds::Map(of), Value::Object(map)) => {
                map.values().try_for_each(|value| self.value(named, path, of, value))
            }
            (Holds::Text, Value::String(_))
            | (Holds::Number, Value::Number(_))
            | (Holds::Flag, Value::Bool(_)) => Ok(()),
            (Holds::Whole, Value::Number(number)) if number.is_u64() => Ok(()),
            _ => Err(self.misfit(named, path, value)),
        }
    }

    fn choice(
        &mut self,
        named: &str,
        path: &str,
        holds: &Holds,
        value: &Value,
    ) -> Result<(), SchemaError> {
        let Holds::Choice(variants) = holds else { return Err(self.misfit(named, path, value)) };
        let word = match value {
            Value::String(word) => Some(word),
            Value::Object(map) => map.keys().next().filter(|_| map.len() == 1),
            _ => None,
        };
        let chosen = variants.iter().find(|variant| match (&variant.name, &variant.holds) {
            (Some(name), None) => value.as_str() == Some(name),
            (Some(name), Some(_)) => value.is_object() && word == Some(name),
            (None, holds) => matches!(
                (holds, value),
                (Some(Holds::Number), Value::Number(_)) | (Some(Holds::List(..)), Value::Array(_))
            ),
        });
        let chosen = chosen.ok_or_else(|| self.misfit(named, path, value))?;
        if is_list_of_words(variants) {
            return Ok(());
        }
        let path = join(path, &label(chosen));
        self.note(named, &path, value);
        match (&chosen.holds, word) {
            (Some(holds), Some(word)) => self.value(named, &path, holds, &value[word]),
            (Some(holds), None) => self.value(named, &path, holds, value),
            (None, _) => Ok(()),
        }
    }

    /// Keeps the first value.
    fn note(&mut self, named: &str, path: &str, value: &Value) {
        let scene = self.scene.map(str::to_owned);
        let place = (named.to_owned(), path.to_owned());
        self.found.0.entry(place).or_insert_with(|| Example { value: value.clone(), scene });
    }

    fn misfit(&self, named: &str, path: &str, value: &Value) -> SchemaError {
        SchemaError::Misfit {
            source_of_it: self.scene.map_or_else(
                || format!("an example of {named}"),
                |scene| format!("the scene {scene}"),
            ),
            place: join(named, path),
            value: value.to_string(),
        }
    }
}
