//! Errors of the generator, on small scenes.

use std::path::PathBuf;

use schemars::{JsonSchema, schema_for};
use serde::Deserialize;

use super::*;

/// A decay.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "only its schema is looked at")]
struct Decay {
    /// Always `decay`.
    solver: String,
    /// How fast (1/s).
    rate: f64,
    /// Where it starts.
    #[serde(default)]
    start: Start,
}

/// A start.
#[derive(Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Start {
    /// At one.
    #[default]
    One,
    /// At a place.
    At {
        /// The place (m).
        place: [f64; 2],
    },
}

#[derive(Deserialize, JsonSchema)]
#[expect(dead_code, reason = "only its schema is looked at")]
struct WithoutUnit {
    solver: String,
    /// How fast.
    rate: Vec<f64>,
}

const DECAY: SceneKind = SceneKind {
    solver: "decay",
    schema: || schema_for!(Decay),
    check: |_| Ok(()),
    run: |_, _| Err(crate::kind::RunError::NoKinds),
    ladder: |_| Err(crate::kind::RunError::NoKinds),
    ingredients: |_| Vec::new(),
};

/// A temporary folder of scenes, removed at the end.
struct Scenes(PathBuf);

impl Scenes {
    fn of(name: &str, texts: &[&str]) -> Self {
        let folder = std::env::temp_dir().join(format!("schema-{}-{name}", std::process::id()));
        std::fs::create_dir_all(folder.join("decay")).unwrap();
        for (number, text) in texts.iter().enumerate() {
            std::fs::write(folder.join(format!("decay/{number}.json")), text).unwrap();
        }
        Self(folder)
    }
}

impl Drop for Scenes {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const ONE: &str = r#"{ "solver": "decay", "rate": 0.5, "start": "one" }"#;
const AT: &str = r#"{ "solver": "decay", "rate": 72e9, "start": { "at": { "place": [1, 2] } } }"#;

#[test]
fn a_page_has_a_line_for_each_key_with_unit_default_and_the_first_example() {
    let scenes = Scenes::of("page", &[ONE, AT]);
    let documents = documents(&[DECAY], &scenes.0).unwrap();
    let paths: Vec<String> =
        documents.iter().map(|document| document.path.display().to_string()).collect();
    assert_eq!(paths, ["schema/decay.schema.json", "scenes/decay.md", "scenes.md"]);
    let page = &documents[1].text;
    for line in [
        "| `rate` | number | 1/s | *required* | How fast. | `0.5` in [decay/0] |",
        "| `start` | [start](#decay-start): `one`, `at` |  | `\"one\"` | Where it starts. | `\"one\"` in [decay/0] |",
        "| `one` | word |  |  | At one. | `\"one\"` in [decay/0] |",
        "| `at.place` | list of 2 numbers | m | *required* | The place. | `[1, 2]` in [decay/1] |",
        "<a id=\"decay-start\"></a>",
        "[decay/1]: ../../tests/scenes/decay/1.json",
    ] {
        assert!(page.lines().any(|of_page| of_page == line), "{line}\n{page}");
    }
    let schema: Value = serde_json::from_str(&documents[0].text).unwrap();
    assert_eq!(schema["properties"]["solver"]["const"], "decay");
}

#[test]
fn a_number_without_unit_is_refused_by_name() {
    let kind = SceneKind { schema: || schema_for!(WithoutUnit), ..DECAY };
    let scenes = Scenes::of("unit", &[r#"{ "solver": "decay", "rate": [1] }"#]);
    let Err(SchemaError::NoUnit { keys, .. }) = documents(&[kind], &scenes.0) else { panic!() };
    assert_eq!(keys, ["scene.rate"]);
}

#[test]
fn keys_that_no_scene_shows_are_named() {
    let scenes = Scenes::of("example", &[ONE]);
    let Err(SchemaError::NoExample { keys, .. }) = documents(&[DECAY], &scenes.0) else { panic!() };
    assert_eq!(keys, ["Start.at", "Start.at.place"]);
}

#[test]
fn a_scene_that_does_not_fit_its_schema_is_named_with_the_place() {
    for (name, text, place) in [
        ("key", r#"{ "solver": "decay", "speed": 1 }"#, "scene.speed"),
        ("type", r#"{ "solver": "decay", "rate": "fast" }"#, "scene.rate"),
        ("word", r#"{ "solver": "decay", "rate": 1, "start": "two" }"#, "Start"),
        (
            "length",
            r#"{ "solver": "decay", "start": { "at": { "place": [1] } } }"#,
            "Start.at.place",
        ),
    ] {
        let scenes = Scenes::of(name, &[text]);
        let Err(SchemaError::Misfit { place: found, source_of_it, .. }) =
            documents(&[DECAY], &scenes.0)
        else {
            panic!("{text}")
        };
        assert_eq!((found.as_str(), source_of_it.as_str()), (place, "the scene decay/0"));
    }
}
