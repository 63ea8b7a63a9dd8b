//! Built-in scenes with changed bytes, numbers and texts, and with keys removed, duplicated or given foreign values.

use std::ops::Range;
use std::path::Path;
use std::sync::LazyLock;

use jsonc_parser::ast::Value;
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};
use proptest::prelude::*;
use proptest::sample::Index;
use scenes::scene::SceneFile;
use scenes::{ALL, RunError, check};

/// Texts of all built-in scenes, found from this package and from that of the cargo-fuzz targets.
pub(crate) static SCENES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let root = above
        .map(|folder| folder.join("tests/scenes"))
        .find(|root| root.join("fpk").is_dir())
        .unwrap();
    let folders = std::fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = folders
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "json"))
        .collect();
    files.sort();
    let built_in = files.iter().map(|file| std::fs::read_to_string(file).unwrap());
    let mut texts: Vec<String> = built_in.collect();
    // Methods that no built-in scene uses.
    let fit = "\"flow_map_fit\": { \"count\": [49, 49], \"reach\": 7 }";
    let damper = texts.iter().find(|text| text.contains(fit)).unwrap().clone();
    texts.extend(METHODS.map(|method| damper.replacen(fit, method, 1)));
    texts
});

const METHODS: [&str; 5] = [
    r#""conservative_grid": { "cells": 64, "reach": 8, "steps_per_period": 40 }"#,
    r#""statistical_linearisation": { "step": 0.05 }"#,
    r#""guided_paths": { "samples": 100, "step": 0.1, "seed": 1 }"#,
    r#""canor_denoel_2013": { "count": [9, 9], "half_width": [0.6, 0.4], "courant": 0.8, "support_over_spacing": 2.5 }"#,
    r#""subset_simulation": { "samples": 100, "correlation": 0.8, "runs": 4, "step": 0.1,
        "seed": 1 }"#,
];

/// Change of a text.
#[derive(Debug, Clone)]
pub(crate) enum Change {
    Number(Index, String),
    Text(Index, String),
    Value(Index, String),
    /// Replaces the first value by the second.
    Copy(Index, Index),
    Remove(Index),
    Double(Index),
    Byte(Index, u8),
    Cut(Index),
    /// Wraps a value in a number of lists.
    Nest(Index, usize),
}

/// A number in various notations.
fn number() -> impl Strategy<Value = String> {
    let ends = "0 -0 -1 1 2 3 0.5 1.5 1e-300 5e-324 1e-999 1e308 -1e308 1e309 1e99999 1e19 1e9 1e6 \
                255 256 4294967295 4294967296 9223372036854775807 18446744073709551615 \
                18446744073709551616 0.1e 01 .5 NaN Infinity";
    prop_oneof![
        4 => prop::sample::select(ends.split(' ').collect::<Vec<_>>()).prop_map(str::to_owned),
        1 => any::<f64>().prop_map(|x| format!("{x:e}")),
        1 => any::<u64>().prop_map(|n| n.to_string()),
        2 => (-10.0..10.0).prop_map(|x: f64| x.to_string()),
    ]
}

pub(crate) fn change() -> impl Strategy<Value = Change> {
    let texts = ["\"\"", "\"é\\u0000\"", "\"\\ud800\"", "\"a.b[0]\"", "\"smpm\"", "\"q\""];
    let text = || prop::sample::select(texts.to_vec()).prop_map(str::to_owned);
    let values = ["null", "true", "{}", "[]", "[[]]", "{\"a\": 1}", "[1, 2, 3, 4, 5, 6, 7, 8]"];
    let value = prop::sample::select(values.to_vec()).prop_map(str::to_owned);
    let place = any::<Index>;
    prop_oneof![
        8 => (place(), number()).prop_map(|(at, number)| Change::Number(at, number)),
        2 => (place(), text()).prop_map(|(at, text)| Change::Text(at, text)),
        2 => (place(), value).prop_map(|(at, value)| Change::Value(at, value)),
        4 => (place(), place()).prop_map(|(at, from)| Change::Copy(at, from)),
        3 => place().prop_map(Change::Remove),
        1 => place().prop_map(Change::Double),
        2 => (place(), any::<u8>()).prop_map(|(at, byte)| Change::Byte(at, byte)),
        1 => place().prop_map(Change::Cut),
        1 => (place(), 1_usize..100_000).prop_map(|(at, depth)| Change::Nest(at, depth)),
    ]
}

/// Positions of elements in a text.
#[derive(Debug, Default)]
struct Places {
    members: Vec<Range<usize>>,
    values: Vec<Range<usize>>,
    numbers: Vec<Range<usize>>,
    texts: Vec<Range<usize>>,
}

impl Places {
    /// None for text that is no JSON.
    fn of(text: &str) -> Self {
        let mut places = Self::default();
        let tree = parse_to_ast(text, &CollectOptions::default(), &ParseOptions::default());
        let mut open: Vec<Value<'_>> = tree.ok().and_then(|tree| tree.value).into_iter().collect();
        while let Some(value) = open.pop() {
            let range = value.start()..value.end();
            places.values.push(range.clone());
            match value {
                Value::NumberLit(_) => places.numbers.push(range),
                Value::StringLit(_) => places.texts.push(range),
                Value::Array(array) => open.extend(array.elements),
                Value::Object(object) => {
                    for property in object.properties {
                        places.members.push(property.start()..property.end());
                        open.push(property.value);
                    }
                }
                _ => {}
            }
        }
        places
    }
}

fn chosen(ranges: &[Range<usize>], at: Index) -> Option<Range<usize>> {
    (!ranges.is_empty()).then(|| at.get(ranges).clone())
}

/// The text with a range replaced.
fn with(text: &str, range: Option<Range<usize>>, instead: &str) -> Option<String> {
    let range = range?;
    Some([&text[..range.start], instead, &text[range.end..]].concat())
}

/// None if this change does not apply.
pub(crate) fn changed(text: &str, change: &Change) -> Option<String> {
    let places = || Places::of(text);
    match change {
        Change::Number(at, number) => with(text, chosen(&places().numbers, *at), number),
        Change::Text(at, instead) => with(text, chosen(&places().texts, *at), instead),
        Change::Value(at, value) => with(text, chosen(&places().values, *at), value),
        Change::Copy(at, from) => {
            let values = places().values;
            with(text, chosen(&values, *at), &text[chosen(&values, *from)?])
        }
        Change::Remove(at) => {
            let member = chosen(&places().members, *at)?;
            let behind = &text[member.end..];
            let comma = behind.trim_start().starts_with(',').then(|| behind.find(',')).flatten();
            let end = comma.map_or(member.end, |comma| member.end + comma + 1);
            let start = match comma {
                Some(_) => member.start,
                // The last member of an object is removed with its preceding comma.
                None => text[..member.start].trim_end().trim_end_matches(',').len(),
            };
            with(text, Some(start..end), "")
        }
        Change::Double(at) => {
            let member = chosen(&places().members, *at)?;
            with(text, Some(member.start..member.start), &format!("{}, ", &text[member]))
        }
        Change::Byte(at, byte) => {
            let mut bytes = text.as_bytes().to_vec();
            *bytes.get_mut(at.index(text.len().max(1)))? = *byte;
            Some(String::from_utf8_lossy(&bytes).into_owned())
        }
        Change::Cut(at) => {
            let end = at.index(text.len() + 1);
            Some(String::from_utf8_lossy(&text.as_bytes()[..end]).into_owned())
        }
        Change::Nest(at, depth) => {
            let value = chosen(&places().values, *at)?;
            let nested = [&"[".repeat(*depth), &text[value.clone()], &"]".repeat(*depth)].concat();
            with(text, Some(value), &nested)
        }
    }
}

/// The error has a position in the text and can be displayed.
fn show(error: RunError, text: &str) -> Result<(), TestCaseError> {
    if let RunError::Scene(error) = &error
        && let Some(mistake) = error.mistake()
    {
        prop_assert!(mistake.line >= 1 && mistake.line <= text.matches('\n').count() + 1);
        prop_assert!(mistake.column >= 1 && mistake.column <= text.chars().count() + 1);
    }
    let shown = format!("{:?}", miette::Report::new(error));
    prop_assert!(!shown.is_empty());
    Ok(())
}

/// The text is a scene, or gives an error with a position that can be displayed.
pub(crate) fn is_read_or_says_why_not(text: &str) -> Result<(), TestCaseError> {
    let read = SceneFile::from_text("scene.json", text.to_owned()).map_err(RunError::from);
    match read.and_then(|file| check(ALL, &file)) {
        Ok(()) => Ok(()),
        Err(error) => show(error, text),
    }
}

proptest! {
    #[test]
    fn a_scene_is_read_or_says_why_not(
        scene in any::<Index>(),
        changes in prop::collection::vec(change(), 1..5),
    ) {
        let mut text = scene.get(&SCENES).clone();
        for change in &changes {
            text = changed(&text, change).unwrap_or(text);
            // A tree this deep is not inspected further.
            if matches!(change, Change::Nest(..)) {
                break;
            }
        }
        is_read_or_says_why_not(&text)?;
    }
}
