//! Values in readable form, shortened where they are long.

use serde_json::{Number, Value};

/// Largest number of characters of a value in a table.
const MOST: usize = 64;

/// Shown part of a value.
#[derive(Clone, Copy)]
struct Cut {
    /// Levels of nested values.
    depth: usize,
    /// Entries of a list.
    entries: usize,
    /// Keys of an object.
    keys: usize,
}

const ALL: usize = usize::MAX;

/// Cuts of a value, from none to its outermost level.
const CUTS: [Cut; 8] = [
    Cut { depth: ALL, entries: ALL, keys: ALL },
    Cut { depth: ALL, entries: 3, keys: ALL },
    Cut { depth: ALL, entries: 2, keys: ALL },
    Cut { depth: 1, entries: 2, keys: ALL },
    Cut { depth: 0, entries: 2, keys: ALL },
    Cut { depth: 1, entries: 2, keys: 2 },
    Cut { depth: 0, entries: 2, keys: 2 },
    Cut { depth: 0, entries: 1, keys: 1 },
];

/// A value on one line; long values omit entries and nested values.
pub(super) fn compact(value: &Value) -> String {
    let fits = |text: &String| text.chars().count() <= MOST;
    CUTS.iter().map(|&cut| line(value, cut)).find(fits).unwrap_or_else(|| {
        let start: String = value.to_string().chars().take(MOST).collect();
        format!("{start}...")
    })
}

fn line(value: &Value, cut: Cut) -> String {
    let inner = |value: &Value| match value {
        Value::Array(list) if cut.depth == 0 && !list.is_empty() => "[...]".to_owned(),
        Value::Object(map) if cut.depth == 0 && !map.is_empty() => "{ ... }".to_owned(),
        _ => line(value, Cut { depth: cut.depth.saturating_sub(1), ..cut }),
    };
    let rest = |count: usize, most: usize| (count > most).then(|| "...".to_owned());
    match value {
        Value::Array(list) => {
            let shown = list.iter().take(cut.entries).map(inner);
            let shown: Vec<String> = shown.chain(rest(list.len(), cut.entries)).collect();
            format!("[{}]", shown.join(", "))
        }
        Value::Object(map) if map.is_empty() => "{}".to_owned(),
        Value::Object(map) => {
            let entry = |(key, value): (&String, &Value)| format!("\"{key}\": {}", inner(value));
            let shown = map.iter().take(cut.keys).map(entry);
            let shown: Vec<String> = shown.chain(rest(map.len(), cut.keys)).collect();
            format!("{{ {} }}", shown.join(", "))
        }
        Value::Number(number) => number_of(number),
        _ => value.to_string(),
    }
}

/// Integers as they are; other large or small numbers in scientific notation.
fn number_of(number: &Number) -> String {
    match number.as_f64() {
        Some(value) if number.is_f64() && value != 0.0 && !(1e-4..1e6).contains(&value.abs()) => {
            format!("{value:e}")
        }
        Some(value) if number.is_f64() => value.to_string(),
        _ => number.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn short_values_are_whole_and_long_ones_keep_their_outside() {
        assert_eq!(
            compact(&json!({ "gaussian": { "mean": [0, 0.5] } })),
            r#"{ "gaussian": { "mean": [0, 0.5] } }"#
        );
        assert_eq!(
            compact(&json!([72e9, 0.25, 1e-6, -3, 0.0, {}])),
            "[7.2e10, 0.25, 1e-6, -3, 0, {}]"
        );
        let long = json!({ "structure": { "mean": (0..40).collect::<Vec<_>>() } });
        assert_eq!(compact(&long), r#"{ "structure": { "mean": [0, 1, 2, ...] } }"#);
        let keys: Value = ('a'..='z').map(|c| (c.to_string(), json!({ "x": [1] }))).collect();
        assert_eq!(compact(&keys), r#"{ "a": { "x": [...] }, "b": { "x": [...] }, ... }"#);
        assert_eq!(compact(&json!((0..40).collect::<Vec<_>>())), "[0, 1, 2, ...]");
    }
}
