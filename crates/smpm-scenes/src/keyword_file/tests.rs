//! Cards of keyword files against constants of the library.

use std::path::Path;

use serde_json::{Value, json};
use smpm::material::Units;
use smpm::material::library::entry;

use super::cards::{Cards, fields, number_of};
use crate::material_scene::{MaterialPart, MaterialScene, Numbers};

fn steel(file: &Value) -> Value {
    json!({
        "keyword_file": file,
        "equation": { "mie_gruneisen": {} },
        "strength": { "johnson_cook": { "set": { "taylor_quinney": 0.9, "rate_floor": 1 } } },
        "damage": {},
    })
}

/// A material of a scene in SI, beside which are the files of the tests of scenes.
fn read(keys: Value) -> (MaterialScene, Numbers) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/tests/small/smpm");
    let mut material: MaterialScene = serde_json::from_value(keys).unwrap();
    material.read_file(&folder, &Units::SI, "steel").unwrap();
    let numbers = material.numbers(Units::SI, "steel").unwrap();
    (material, numbers)
}

#[test]
fn a_card_gives_the_material_of_the_same_constants_in_si() {
    for (path, units) in [("steel.k", "mm_kg_ms"), ("steel_by_commas.k", "mm_tonne_s")] {
        let (material, numbers) = read(steel(&json!({ "path": path, "units": units })));
        // The library has the constants of the same papers, in SI.
        for (part, model) in [
            (MaterialPart::Equation, "mie_gruneisen"),
            (MaterialPart::Strength, "johnson_cook"),
            (MaterialPart::Damage, "damage"),
        ] {
            for (name, expected) in entry(model, "steel", Units::SI).unwrap() {
                let value = numbers[&(part, name)];
                let is_close = (value - expected).abs() <= 1e-15 * expected.abs();
                assert!(is_close, "{model} {name} {value}");
            }
        }
        let (file, constants) = material.keyword_file.unwrap().read.unwrap();
        assert_eq!(file.path, path);
        assert_eq!(constants.cards[0], ("*EOS_GRUNEISEN 9".to_owned(), Vec::new()));
        assert_eq!(constants.cards[1], ("*MAT_JOHNSON_COOK 7".into(), vec!["VP 1".into()]));
    }
}

#[test]
fn cards_of_other_models_are_read() {
    let values = |mid: u64, part: &str, model: Value| -> Vec<(&str, f64)> {
        let mut keys = steel(&json!({ "path": "cards.k", "units": "si", "mid": mid, "eosid": 1 }));
        if part != "damage" {
            keys["strength"] = Value::Null;
            keys["damage"] = Value::Null;
        }
        if mid == 31 {
            keys["detonation"] = json!({ "point": [0], "cells": 2 });
            keys["keyword_file"]["eosid"] = Value::Null;
        }
        keys[part] = model;
        read(keys).1.into_iter().map(|((_, name), value)| (name, value)).collect()
    };
    let found = values(21, "strength", json!({ "von_mises": {} }));
    let hardening = ("hardening_modulus", 200e9 * 2e9 / 198e9);
    for constant in [("shear_modulus", 80e9), ("yield_stress", 400e6), hardening] {
        assert!(found.contains(&constant), "{found:?}");
    }
    let found = values(31, "equation", json!({ "jwl": {} }));
    let of_library = entry("jwl", "tnt", Units::SI).unwrap();
    assert!(of_library.iter().all(|constant| found.contains(constant)), "{found:?}");
    // Without constants of fracture nothing breaks, and without a shear modulus it follows from those of shells.
    let found = values(1, "damage", json!({}));
    assert!(found.contains(&("shear_modulus", 80e9)), "{found:?}");
    assert_eq!(found.iter().filter(|(_, value)| value.is_infinite()).count(), 2);
    // A constant that is set is not read: this card breaks by another stress.
    let found = values(4, "damage", json!({ "set": { "spall_strength": 2e9 } }));
    assert!(found.contains(&("spall_strength", 2e9)), "{found:?}");
}

#[test]
fn an_error_lists_the_cards_of_a_file_and_nothing_else_of_it() {
    let listed = |text: &str| {
        let kind = ("MAT_NONE", "MAT_000", ["MID"].as_slice());
        Cards::of(text, "key", "file").card(kind, None).unwrap_err().help.unwrap()
    };
    let help =
        listed("secret\n*EOS_JWL secret\n1,2\n*SECRET\n*mat_015_title\nsecret\n1\n*INCLUDE\n");
    assert_eq!(help, "it has *EOS_JWL, *INCLUDE, *MAT_015; files that it includes are not read");
    assert!(listed("secret\n").starts_with("it has no *MAT_ and no *EOS_;"));
}

#[test]
fn numbers_are_those_of_fortran_and_nothing_else() {
    let numbers = ["", "-.5", "1.5D3", "1.5-3", "-1e-3"].map(number_of);
    assert_eq!(numbers, [0.0, -0.5, 1500.0, 0.0015, -1e-3].map(Some));
    for field in ["1 2", "nan", "inf", "&a", "1e999", "-"] {
        assert_eq!(number_of(field), None, "{field}");
    }
    assert_eq!(fields("         7         8"), ["7", "8"]);
}
