//! The lines of a table of keys.

use serde_json::Value;

use super::tree::{Holds, Named, Presence, Variant};

/// A key of a type, or one of its choices.
pub(super) struct Row<'a> {
    /// From the type on, e.g. `single_peak.peak_time`.
    pub(super) path: String,
    pub(super) about: &'a str,
    /// None for a choice.
    pub(super) presence: Option<&'a Presence>,
    /// None for a word alone.
    pub(super) holds: Option<&'a Holds>,
    /// Given with the key.
    pub(super) examples: &'a [Value],
}

impl Row<'_> {
    pub(super) fn needs_unit(&self) -> bool {
        self.holds.is_some_and(is_numeric)
    }

    /// A word may stand for what has one; parentheses in what is said of other values are not theirs.
    pub(super) fn may_have_unit(&self) -> bool {
        self.holds.is_none_or(is_numeric)
    }
}

/// Whether a value is numbers and nothing else.
fn is_numeric(holds: &Holds) -> bool {
    match holds {
        Holds::Number | Holds::Whole => true,
        Holds::List(of, _) | Holds::Map(of) => is_numeric(of),
        _ => false,
    }
}

/// All keys and choices of a type, those of its own objects below them; other types have their own.
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

/// Whether choices are words that need no explanation.
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

/// A path with a key behind it; either may be empty.
pub(super) fn join(path: &str, key: &str) -> String {
    let dot = if path.is_empty() || key.is_empty() { "" } else { "." };
    format!("{path}{dot}{key}")
}
