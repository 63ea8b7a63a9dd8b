//! Rows of a table of keys.

use serde_json::Value;

use super::tree::{Holds, Named, Presence, Variant};

/// A key of a type, or one of its choices.
pub(super) struct Row<'a> {
    /// Path from the type, e.g. `single_peak.peak_time`.
    pub(super) path: String,
    pub(super) about: &'a str,
    /// Whether the key must be given; none for a choice.
    pub(super) presence: Option<&'a Presence>,
    /// What the value is; none for a single word.
    pub(super) holds: Option<&'a Holds>,
    /// Examples given with the key.
    pub(super) examples: &'a [Value],
}

impl Row<'_> {
    pub(super) fn needs_unit(&self) -> bool {
        self.holds.is_some_and(is_numeric)
    }

    /// Whether the row may state a unit: for words and numbers; parentheses in other descriptions are no units.
    pub(super) fn may_have_unit(&self) -> bool {
        self.holds.is_none_or(is_numeric)
    }
}

/// Whether a value consists of numbers only.
fn is_numeric(holds: &Holds) -> bool {
    match holds {
        Holds::Number | Holds::Whole => true,
        Holds::List(of, _) | Holds::Map(of) => is_numeric(of),
        _ => false,
    }
}

/// All keys and choices of a type, including those of its inline objects; named types have their own rows.
pub(super) fn rows(named: &Named) -> Vec<Row<'_>> {
    let mut rows = Vec::new();
    collect("", &named.holds, &mut rows);
    rows
}

fn collect<'a>(path: &str, holds: &'a Holds, rows: &mut Vec<Row<'a>>) {
    match holds {
        Holds::Object(keys) => {
            for key in keys {
                let path = join(path, &key.name);
                rows.push(Row {
                    path: path.clone(),
                    about: &key.about,
                    presence: Some(&key.presence),
                    holds: Some(&key.holds),
                    examples: &key.examples,
                });
                collect(&path, &key.holds, rows);
            }
        }
        Holds::Choice(variants) if !is_list_of_words(variants) => {
            for variant in variants {
                let path = join(path, &label(variant));
                let (about, holds) = (variant.about.as_str(), variant.holds.as_ref());
                rows.push(Row { path: path.clone(), about, presence: None, holds, examples: &[] });
                if let Some(holds) = holds {
                    collect(&path, holds, rows);
                }
            }
        }
        Holds::List(of, _) | Holds::Map(of) => collect(path, of, rows),
        _ => {}
    }
}

/// Whether choices are words without descriptions.
pub(super) fn is_list_of_words(variants: &[Variant]) -> bool {
    variants.iter().all(|variant| variant.about.is_empty() && variant.holds.is_none())
}

/// The word of a choice, or its form.
pub(super) fn label(variant: &Variant) -> String {
    let form = || match &variant.holds {
        Some(Holds::Number) => "a number".to_owned(),
        Some(Holds::List(_, Some(count))) => format!("a list of {count}"),
        _ => "another form".to_owned(),
    };
    variant.name.clone().unwrap_or_else(form)
}

/// Joins a path and a key; either may be empty.
pub(super) fn join(path: &str, key: &str) -> String {
    let dot = if path.is_empty() || key.is_empty() { "" } else { "." };
    format!("{path}{dot}{key}")
}
