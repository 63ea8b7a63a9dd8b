//! Every key of a scene with its value and unit, defaults included.

use result_pages::SceneKey;
use serde_json::Value;

use super::SchemaError;
use super::rows::{is_list_of_words, join};
use super::tree::{Holds, Presence, Tree, Variant};
use super::unit;
use super::value::compact;

/// Value of an optional key that a scene leaves out.
const NONE: &str = "none";

/// Every key of a scene with this schema: those of `resolved`, which has the defaults of its types, and those that it leaves out.
///
/// A key that is not in `given`, the text of the scene, has its default.
///
/// # Errors
/// [`SchemaError::Form`] for a schema that cannot be shown.
pub fn scene_keys(
    solver: &'static str,
    schema: &Value,
    resolved: &Value,
    given: &Value,
) -> Result<Vec<SceneKey>, SchemaError> {
    let tree = Tree::read(solver, schema)?;
    let mut walk = Walk { tree: &tree, keys: Vec::new() };
    let at = At { path: String::new(), about: &tree.root().about };
    walk.visit(&tree.root().holds, &at, resolved, Some(given));
    Ok(walk.keys)
}

struct Walk<'a> {
    tree: &'a Tree,
    keys: Vec<SceneKey>,
}

/// A place in a scene with the description of its key.
struct At<'a> {
    path: String,
    about: &'a str,
}

impl<'a> Walk<'a> {
    fn row(&mut self, at: &At<'_>, value: String, is_default: bool) {
        let (unit, meaning) = unit::split(at.about).unwrap_or(("", at.about.to_owned()));
        let unit = if unit == "no unit" { String::new() } else { unit.to_owned() };
        self.keys.push(SceneKey { key: at.path.clone(), value, unit, is_default, meaning });
    }

    fn visit(&mut self, holds: &'a Holds, at: &At<'a>, value: &Value, given: Option<&Value>) {
        match (holds, value) {
            (Holds::Named(name), _) => match self.tree.get(name) {
                Some(named) => self.visit(&named.holds, at, value, given),
                None => self.row(at, compact(value), given.is_none()),
            },
            (Holds::Object(keys), Value::Object(map)) => {
                for key in keys {
                    let inner = At { path: join(&at.path, &key.name), about: &key.about };
                    let given = given.and_then(|given| given.get(&key.name));
                    match (map.get(&key.name), &key.presence) {
                        (Some(value), _) if !value.is_null() => {
                            self.visit(&key.holds, &inner, value, given);
                        }
                        (_, Presence::Default(value)) => self.row(&inner, compact(value), true),
                        _ => self.row(&inner, NONE.to_owned(), true),
                    }
                }
            }
            (Holds::Choice(variants), _) if !is_list_of_words(variants) => {
                self.choice(variants, at, value, given);
            }
            (Holds::Map(of), Value::Object(map)) => {
                for (name, value) in map {
                    let inner = At { path: join(&at.path, name), about: at.about };
                    self.visit(of, &inner, value, given.and_then(|given| given.get(name)));
                }
            }
            (Holds::List(of, _), Value::Array(list)) if !is_plain(of) => {
                for (k, value) in list.iter().enumerate() {
                    let inner = At { path: format!("{}[{k}]", at.path), about: at.about };
                    self.visit(of, &inner, value, given.and_then(|given| given.get(k)));
                }
            }
            _ => self.row(at, compact(value), given.is_none()),
        }
    }

    /// The variant that the value has: a word, an object of which the word is the only key, or a form.
    fn choice(
        &mut self,
        variants: &'a [Variant],
        at: &At<'a>,
        value: &Value,
        given: Option<&Value>,
    ) {
        if let Some((word, inner)) = value.as_object().and_then(|map| map.iter().next()) {
            let is_it = |variant: &&Variant| variant.name.as_deref() == Some(word);
            if let Some(holds) = variants.iter().find(is_it).and_then(|it| it.holds.as_ref()) {
                let about = variants.iter().find(is_it).map_or(at.about, |it| &it.about);
                let place = At { path: join(&at.path, word), about };
                let n = self.keys.len();
                self.visit(holds, &place, inner, given.and_then(|given| given.get(word)));
                // A variant without keys is still the choice.
                if self.keys.len() == n {
                    self.row(&place, compact(inner), given.is_none());
                }
                return;
            }
        }
        let fits = |variant: &&Variant| {
            variant.name.is_none() && variant.holds.as_ref().is_some_and(|it| self.fits(it, value))
        };
        match variants.iter().find(fits).and_then(|variant| variant.holds.as_ref()) {
            Some(holds) => self.visit(holds, at, value, given),
            None => self.row(at, compact(value), given.is_none()),
        }
    }

    fn fits(&self, holds: &Holds, value: &Value) -> bool {
        match holds {
            Holds::Named(name) => self.tree.get(name).is_some_and(|it| self.fits(&it.holds, value)),
            Holds::List(..) => value.is_array(),
            Holds::Object(_) | Holds::Map(_) => value.is_object(),
            Holds::Choice(_) => value.is_string() || value.is_object(),
            Holds::Number | Holds::Whole => value.is_number(),
            Holds::Text => value.is_string(),
            Holds::Flag => value.is_boolean(),
        }
    }
}

/// Whether the entries of a list are numbers or words, so that the list is one value.
fn is_plain(holds: &Holds) -> bool {
    match holds {
        Holds::Text | Holds::Number | Holds::Whole | Holds::Flag => true,
        Holds::List(of, _) => is_plain(of),
        Holds::Choice(variants) => variants.iter().all(|variant| match &variant.holds {
            None => true,
            Some(holds) => is_plain(holds),
        }),
        Holds::Object(_) | Holds::Map(_) | Holds::Named(_) => false,
    }
}
