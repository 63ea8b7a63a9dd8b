//! Conversion of keys to a type, and positions of keys in the text: serde provides the path of an error, the syntax tree its position.

use std::collections::BTreeMap;
use std::ops::Range;

use jsonc_parser::ast::{Object, Value};
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};
use serde::de::{DeserializeOwned, IgnoredAny};

use super::error::{Objection, Origin, SceneError};
use super::retired::{Retired, retired_at};
use crate::nearest::nearest;

/// A key that is unknown, missing or of another type, with its path.
pub type WrongKey = serde_path_to_error::Error<serde_json::Error>;

/// Parses keys as a type that implements `Deserialize`.
///
/// # Errors
/// [`WrongKey`].
pub fn read_keys<T: DeserializeOwned>(keys: &serde_json::Value) -> Result<T, WrongKey> {
    serde_path_to_error::deserialize(keys)
}

/// Parses the keys of a scene as plain JSON.
///
/// It rejects comments, trailing commas, duplicate keys and numbers beyond the range of a double.
pub(super) fn keys(origin: &Origin) -> Result<serde_json::Value, SceneError> {
    let keys = serde_json::from_str(&origin.text);
    // serde_json has better syntax messages and is stricter; numbers out of range are reported with their key, from
    // the tree.
    if let Err(error) = &keys
        && let Err(syntax) = serde_json::from_str::<IgnoredAny>(&origin.text)
    {
        return Err(here(origin, if is_range(error) { &syntax } else { error }));
    }
    check_tree(origin, &parse(origin)?)?;
    keys.map_err(|error| here(origin, &error))
}

fn is_range(error: &serde_json::Error) -> bool {
    error.to_string().starts_with("number out of range")
}

/// An error of serde at the position where it stopped.
fn here(origin: &Origin, error: &serde_json::Error) -> SceneError {
    let end = offset_of(&origin.text, error.line(), error.column());
    let is_word = |letter: char| letter.is_alphanumeric() || letter == '-';
    let word = origin.text[..end].trim_end_matches(is_word).len();
    let help = what_to_write(&origin.text[word..]).map(str::to_owned);
    SceneError::at(origin, "", end..end + 1, without_position(error), "here", help)
}

/// What to write instead of what other dialects of JSON allow, by the text from the word at which a plain parser stops.
fn what_to_write(rest: &str) -> Option<&'static str> {
    const OTHERS: [(&[&str], &str); 5] = [
        (&["\u{feff}"], "the file begins with a byte order mark; save it as UTF-8 without one"),
        (&["//", "/*", "#"], "JSON has no comments; say it in `title`"),
        (
            &["NaN", "nan", "Infinity", "-Infinity", "inf", "-inf"],
            "only finite numbers are values; without a key its default applies",
        ),
        (&["'"], "a text is written in double quotes"),
        (&["True", "False", "TRUE", "FALSE"], "write `true` or `false`"),
    ];
    let starts = |words: &[&str]| words.iter().any(|word| rest.starts_with(word));
    OTHERS.iter().find(|(words, _)| starts(words)).map(|&(_, help)| help)
}

/// The syntax tree of plain JSON, with positions.
fn parse(origin: &Origin) -> Result<Value<'_>, SceneError> {
    let strict = ParseOptions {
        allow_comments: false,
        allow_loose_object_property_names: false,
        allow_trailing_commas: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: false,
        allow_bare_decimal_point_numbers: false,
        allow_non_finite_numbers: false,
        allow_extended_string_escapes: false,
    };
    let tree = parse_to_ast(&origin.text, &CollectOptions::default(), &strict);
    let tree = tree.map_err(|error| {
        let range = error.range();
        SceneError::at(origin, "", range.start..range.end, error.kind().to_string(), "here", None)
    })?;
    tree.value.ok_or_else(|| SceneError::Empty { path: origin.name.clone() })
}

/// Rejects duplicate keys, numbers beyond the range of a double, and texts that would move the cursor of a terminal.
fn check_tree(origin: &Origin, tree: &Value<'_>) -> Result<(), SceneError> {
    let mut open = vec![(String::new(), tree)];
    while let Some((path, value)) = open.pop() {
        match value {
            Value::NumberLit(number) if !number.value.parse::<f64>().is_ok_and(f64::is_finite) => {
                let message =
                    format!("the number {} is beyond the range of a double", number.value);
                let help = Some("the largest double is 1.8e308".to_owned());
                let range = range_of(value);
                return Err(SceneError::at(origin, &path, range, message, "too large", help));
            }
            Value::StringLit(text) => check_text(origin, &path, (&text.value, range_of(value)))?,
            Value::Object(object) => {
                check_keys(origin, &path, object)?;
                // Last in, first out: the first error in the text is reported.
                let inner = object.properties.iter().rev();
                open.extend(
                    inner.map(|property| (join(&path, property.name.as_str()), &property.value)),
                );
            }
            Value::Array(array) => {
                let inner = array.elements.iter().enumerate().rev();
                open.extend(inner.map(|(i, element)| (format!("{path}[{i}]"), element)));
            }
            _ => {}
        }
    }
    Ok(())
}

fn check_text(
    origin: &Origin,
    path: &str,
    (text, range): (&str, Range<usize>),
) -> Result<(), SceneError> {
    let is_moving = |letter: &char| letter.is_control() && !matches!(letter, '\n' | '\t');
    let Some(found) = text.chars().find(is_moving) else { return Ok(()) };
    let message = format!("the text has the control character U+{:04X}", u32::from(found));
    Err(SceneError::at(origin, path, range, message, "not printable", None))
}

fn check_keys(origin: &Origin, path: &str, object: &Object<'_>) -> Result<(), SceneError> {
    let mut first_line = BTreeMap::new();
    for property in &object.properties {
        let (name, range) = (property.name.as_str(), range_of(&property.name));
        check_text(origin, path, (name, range.clone()))?;
        let line = origin.text[..range.start].matches('\n').count() + 1;
        if let Some(first) = first_line.insert(name, line) {
            let message = format!("the key `{name}` is given twice");
            let help = Some(format!("it was first given in line {first}"));
            let path = join(path, name);
            return Err(SceneError::at(origin, &path, range, message, "second time", help));
        }
    }
    Ok(())
}

/// Adds the position to an error of serde; a name that the type of scene had once is reported with its successor.
pub(super) fn locate(origin: &Origin, had_once: &[Retired], wrong: &WrongKey) -> SceneError {
    let path = wrong.path().to_string();
    let path = path.trim_start_matches('.');
    let message = in_plain_words(&wrong.inner().to_string());
    let tree = match parse(origin) {
        Ok(tree) => tree,
        Err(error) => return error,
    };
    let words: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let unknown_key = message.starts_with("unknown key");
    if let Some(&word) = words.first()
        && (unknown_key || message.starts_with("unknown variant"))
    {
        let parent = if unknown_key { without_last(path, word) } else { path };
        let range = key_in(find(&tree, parent).value, word);
        let whole = join(parent, word);
        if let Some(retired) = retired_at(had_once, &whole) {
            let message = format!("`{word}` was removed: use {}", retired.successor);
            return SceneError::at(origin, &whole, range, message, "removed", None);
        }
        let suggestion = nearest(word, words[1..].iter().copied());
        let help = suggestion.map(|suggestion| format!("did you mean `{suggestion}`?"));
        let path = if unknown_key { whole } else { path.to_owned() };
        let label = if unknown_key { "unknown key" } else { "unknown variant" };
        return SceneError::at(origin, &path, range, message, label, help);
    }
    if let Some(&word) = words.first()
        && message.starts_with("missing key")
    {
        let start = range_of(find(&tree, path).value).start;
        let label = format!("`{word}` is missing in this object");
        return SceneError::at(origin, path, start..start + 1, message, &label, None);
    }
    let value = find(&tree, path).value;
    let range = range_of(value);
    if let Value::Object(object) = value
        && message.ends_with("expected map with a single key")
    {
        let names: Vec<String> =
            object.properties.iter().map(|key| format!("`{}`", key.name.as_str())).collect();
        let message = match names.as_slice() {
            [] => "one key is expected; none is given".to_owned(),
            _ => format!("one key is expected; {} are given: {}", names.len(), names.join(", ")),
        };
        let place = object.properties.get(1).map_or(range, |second| range_of(&second.name));
        return SceneError::at(origin, path, place, message, "one too many", None);
    }
    if let Value::StringLit(text) = value
        && message.contains("unit variant, expected")
    {
        let message = format!("`{}` has keys of its own", text.value);
        let help = Some(format!("write {{ \"{}\": {{ ... }} }} with them", text.value));
        return SceneError::at(origin, path, range, message, "a name alone", help);
    }
    SceneError::at(origin, path, range, message, "this value", None)
}

/// Reports an objection at its value, or at the nearest enclosing one.
pub(super) fn object_to(origin: &Origin, objection: &Objection) -> SceneError {
    let Objection { path, message, help } = objection;
    let range = parse(origin).map_or(0..0, |tree| {
        let place = find(&tree, path);
        let range = range_of(place.value);
        // An object is marked at its key or its opening brace: underlining all of it is less clear.
        match place.value {
            Value::Object(_) | Value::Array(_) => place.key.unwrap_or(range.start..range.start + 1),
            _ => range,
        }
    });
    SceneError::at(origin, path, range, message.clone(), "this value", help.clone())
}

struct Place<'t, 'a> {
    key: Option<Range<usize>>,
    value: &'t Value<'a>,
}

/// The value at `path`, or the innermost existing one along it.
fn find<'t, 'a>(tree: &'t Value<'a>, path: &str) -> Place<'t, 'a> {
    let mut place = Place { key: None, value: tree };
    for step in path
        .split(['.', '['])
        .map(|step| step.trim_end_matches(']'))
        .filter(|step| !step.is_empty())
    {
        match place.value {
            Value::Object(object) => {
                let Some(property) = object.get(step) else { break };
                place = Place { key: Some(range_of(&property.name)), value: &property.value };
            }
            Value::Array(array) => {
                let Some(element) = step.parse::<usize>().ok().and_then(|i| array.elements.get(i))
                else {
                    break;
                };
                place = Place { key: None, value: element };
            }
            _ => break,
        }
    }
    place
}

fn key_in(value: &Value<'_>, key: &str) -> Range<usize> {
    let property = value.as_object().and_then(|object| object.get(key));
    property.map_or_else(|| range_of(value), |property| range_of(&property.name))
}

fn range_of(of: &impl Ranged) -> Range<usize> {
    of.range().start..of.range().end
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

fn without_last<'p>(path: &'p str, key: &str) -> &'p str {
    path.strip_suffix(key).map_or(path, |parent| parent.trim_end_matches('.'))
}

/// The message of serde_json without its own position, which is where it stopped reading.
fn without_position(error: &serde_json::Error) -> String {
    let text = error.to_string();
    text.split_once(" at line ").map_or(text.as_str(), |(message, _)| message).to_owned()
}

/// Replaces Rust's names of types and keys by terms of a scene file.
fn in_plain_words(message: &str) -> String {
    let message = message.replacen("unknown field", "unknown key", 1).replacen(
        "missing field",
        "missing key",
        1,
    );
    for (rust, plain) in [
        ("f64", "a number"),
        ("usize", "a whole number"),
        ("u64", "a whole number"),
        ("u32", "a whole number"),
    ] {
        if let Some(start) = message.strip_suffix(&format!("expected {rust}")) {
            return format!("{start}expected {plain}");
        }
    }
    message
}

/// Byte offset of a line and column of serde_json, which count from 1 and in bytes.
fn offset_of(text: &str, line: usize, column: usize) -> usize {
    let lines_before: usize =
        text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let mut offset = (lines_before + column.saturating_sub(1)).min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}
