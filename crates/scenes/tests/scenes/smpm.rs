//! A complete run of a small scene, and its errors one by one.

use std::path::{Path, PathBuf};

use scenes::checkpoint::{CheckpointError, Reason, Start};
use scenes::{ALL, EnsemblePart, Options, Progress, RunError, run};
use serde_json::Value;
use tempfile::TempDir;
use twox_hash::XxHash64;

/// A steel plate impacts a wall, in uniaxial strain.
const PLATE: &str = r#"{
  "solver": "smpm",
  "title": "Plate impact",
  "units": "cm_g_us",
  "dimension": 1,
  "grid": { "cell": 0.1, "particles_per_cell": 2 },
  "scheme": { "shape": "cubic_b_spline", "transfer": "apic", "viscosity": { "quadratic": 1.5, "linear": 1 } },
  "boundaries": [{ "axis": 1, "position": 0, "side": "above", "kind": "symmetry" }],
  "materials": { "steel": { "equation": { "mie_gruneisen": { "library": "steel" } } } },
  "bodies": [
    { "name": "plate", "material": "steel", "shape": { "box": { "from": [0], "to": [3] } }, "velocity": [-0.1] }
  ],
  "random": [{ "parameter": "steel.equation.s1", "law": "normal", "coefficient_of_variation": 0.05 }],
  "method": "propagated",
  "gauges": [{ "name": "wake", "body": "plate", "within": [[0.2], [1.2]] }],
  "quantities": ["pressure", "density"],
  "times": [3, 4, [3, 4]],
  "levels": { "pressure": [0.475, 0.9] },
  "fields": true
}"#;

fn run_text(text: &str) -> (TempDir, Result<Vec<PathBuf>, RunError>) {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.json");
    std::fs::write(&scene, text).unwrap();
    let result = run(ALL, &scene, &Options::new(folder.path().join("out")), &Progress::silent());
    (folder, result.map(|it| it.files))
}

/// Runs again into the same folder.
fn again(folder: &Path, text: &str, start: Start) -> Result<Vec<PathBuf>, RunError> {
    let scene = folder.join("scene.json");
    std::fs::write(&scene, text).unwrap();
    let options = Options { start, ..Options::new(folder.join("out")) };
    run(ALL, &scene, &options, &Progress::silent()).map(|it| it.files)
}

fn gauges(out: &Path) -> Value {
    let text = std::fs::read_to_string(out.join("result.json")).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["gauges"].take()
}

const CHECKPOINTS: [&str; 2] = ["checkpoint-0.bin", "checkpoint-1.bin"];

fn checkpoints(out: &Path) -> [Option<Vec<u8>>; 2] {
    CHECKPOINTS.map(|name| std::fs::read(out.join(name)).ok())
}

/// A result and the bytes of its fields.
fn all_of(out: &Path) -> (Value, Vec<(PathBuf, Vec<u8>)>) {
    let mut fields: Vec<(PathBuf, Vec<u8>)> = std::fs::read_dir(out.join("fields"))
        .map(|entries| entries.map(|entry| entry.unwrap().path()).collect::<Vec<_>>())
        .unwrap_or_default()
        .into_iter()
        .map(|path| (path.file_name().unwrap().into(), std::fs::read(&path).unwrap()))
        .collect();
    fields.sort();
    (gauges(out), fields)
}

const TIMES: &str = "[3, 4, [3, 4]]";
const LONGER: &str = "[3, 4, [3, 4], [4, 5], 4.5]";

#[test]
fn a_longer_scene_goes_on_from_a_shorter_one_by_every_method_without_samples() {
    let methods = [
        "\"propagated\"",
        "\"deterministic\"",
        "{ \"frozen\": {} }",
        "{ \"finite_difference\": { \"step\": 0.01 } }",
        "\"sigma_points\"",
    ];
    for method in methods {
        let of = |times: &str| PLATE.replace("\"propagated\"", method).replace(TIMES, times);
        let (whole, written) = run_text(&of(LONGER));
        written.unwrap();
        let (folder, written) = run_text(&of(TIMES));
        written.unwrap();
        let (out, short) = (folder.path().join("out"), gauges(&folder.path().join("out")));
        again(folder.path(), &of(LONGER), Start::GoOn).unwrap();
        assert_eq!(all_of(&out), all_of(&whole.path().join("out")), "{method}");
        let kept = checkpoints(&out);
        again(folder.path(), &of(TIMES), Start::GoOn).unwrap();
        assert_eq!((gauges(&out), checkpoints(&out)), (short, kept), "{method}");
        let error = again(folder.path(), &of("[3.5, 4]"), Start::GoOn).unwrap_err();
        let RunError::Scene(error) = error else { panic!("{error}") };
        let mistake = error.mistake().unwrap();
        assert_eq!(mistake.path, "times");
        assert!(mistake.help.as_deref().is_some_and(|help| help.contains("--overwrite")));
    }
}

#[test]
fn a_frame_that_is_gone_is_missed_by_its_name() {
    let (folder, written) = run_text(PLATE);
    written.unwrap();
    std::fs::remove_file(folder.path().join("out/fields/fields-0000.vtu")).unwrap();
    let error = again(folder.path(), PLATE, Start::GoOn).unwrap_err();
    let RunError::Solver(error) = error else { panic!("{error}") };
    assert!(error.to_string().contains("fields-0000.vtu"), "{error}");
    again(folder.path(), PLATE, Start::Overwrite).unwrap();
}

/// The content follows eight letters and its length; its hash follows the content.
fn with_right_hash(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - 8;
    let hash = XxHash64::oneshot(0, &bytes[..end]);
    bytes[end..].copy_from_slice(&hash.to_le_bytes());
    bytes
}

#[test]
fn a_checkpoint_of_a_single_run_is_refused_where_it_is_damaged_and_never_ends_in_a_panic() {
    let text = PLATE.replace("\"fields\": true", "\"fields\": false");
    let text = text.replace("\"propagated\"", "\"deterministic\"");
    let (folder, written) = run_text(&text);
    written.unwrap();
    let out = folder.path().join("out");
    let newest = checkpoints(&out).into_iter().flatten().max_by_key(Vec::len);
    let newest = &newest.expect("a run leaves a checkpoint at its end");
    let resume = |bytes: &[u8]| {
        for name in CHECKPOINTS {
            std::fs::write(out.join(name), bytes).unwrap();
        }
        // The final state is not restored: more steps follow.
        again(folder.path(), &text.replace(TIMES, LONGER), Start::GoOn)
    };
    let refused = |bytes: &[u8]| {
        let error = resume(bytes).unwrap_err();
        let RunError::Checkpoint(CheckpointError::Refused(all)) = error else { panic!("{error}") };
        all.into_iter().next().unwrap().reason
    };
    assert!(matches!(refused(&newest[..newest.len() / 2]), Reason::CutOff { .. }));
    let mut flipped = newest.clone();
    flipped[newest.len() / 2] ^= 4;
    assert!(matches!(refused(&flipped), Reason::Damaged { .. }));
    resume(newest).unwrap();
    let whole = gauges(&out);
    let (mut n_refused, mut n_same, mut n_other) = (0, 0, 0);
    for place in (16..newest.len() - 16).step_by(newest.len() / 61) {
        for word in [f64::NAN.to_bits(), u64::MAX] {
            let mut forged = newest.clone();
            forged[place..place + 8].copy_from_slice(&word.to_le_bytes());
            match resume(&with_right_hash(forged)) {
                Err(_) => n_refused += 1,
                Ok(_) if gauges(&out) == whole => n_same += 1,
                Ok(_) => n_other += 1,
            }
        }
    }
    // A sum may be any number; a snapshot has a hash of its own, and the head is that of the scene.
    assert!(n_refused > 60, "{n_refused} refused, {n_same} the same, {n_other} other");
}

/// A method by eight replicas of scrambled Sobol' points.
fn quasi(method: &str, points: u64, further: &str) -> String {
    format!("{{ \"{method}\": {{ \"points\": {points}, \"replicas\": 8, \"seed\": 1{further} }} }}")
}

#[test]
fn sobol_indices_by_two_methods_are_those_of_the_hugoniot_and_more_points_continue_a_run() {
    let two = PLATE.replace(
        "\"random\": [",
        "\"random\": [{ \"parameter\": \"steel.equation.sound_speed\", \"law\": \"normal\", \"coefficient_of_variation\": 0.02 }, ",
    );
    let of = |method: &str| {
        two.replace("\"propagated\"", method).replace("\"fields\": true", "\"fields\": false")
    };
    let shares = |out: &Path| gauges(out)[0]["quantities"][0]["values"][2]["sobol_indices"].take();
    let number = |share: &Value, key: &str| share[key].as_f64().unwrap();
    // p = rho_0 (C + S_1 u) u: variances as the squares of 0.02 C and 0.05 S_1 u.
    let (by_c, by_s) = ((0.02 * 0.457_f64).powi(2), (0.05 * 1.49 * 0.1_f64).powi(2));
    let exact = [by_c / (by_c + by_s), by_s / (by_c + by_s)];
    let (folder, written) = run_text(&of(&quasi("sobol_indices", 4, "")));
    written.unwrap();
    let out = folder.path().join("out");
    again(folder.path(), &of(&quasi("sobol_indices", 8, "")), Start::GoOn).unwrap();
    let continued = gauges(&out);
    let (anew, written) = run_text(&of(&quasi("sobol_indices", 8, "")));
    written.unwrap();
    assert_eq!(continued, gauges(&anew.path().join("out")));
    let fitted = of(&quasi("quasi_monte_carlo", 8, ", \"control\": true"));
    let (of_fit, written) = run_text(&fitted);
    written.unwrap();
    // 64 points: the design knows indices to a tenth, the polynomial much better.
    for (out, largest) in [(out, 0.25), (of_fit.path().join("out"), 0.02)] {
        let shares = shares(&out);
        for (k, exact) in exact.into_iter().enumerate() {
            for index in ["first", "total"] {
                let value = number(&shares[k], index);
                let error = number(&shares[k], &format!("{index}_standard_error"));
                // Of the two derivatives one is 1 % high and one 2.5 % low at this cell.
                assert!((value - exact).abs() < 4.0 * error + 0.03, "{shares} {exact}");
                assert!(error < largest, "{shares}");
            }
        }
    }
}

#[test]
fn a_scene_runs_to_its_end_by_every_method() {
    let methods = [
        ("\"propagated\"", true),
        ("\"deterministic\"", false),
        ("{ \"frozen\": {} }", true),
        ("{ \"finite_difference\": { \"step\": 0.01 } }", true),
        ("{ \"forward_difference\": { \"step\": 0.01 } }", true),
        ("\"sigma_points\"", true),
        ("{ \"monte_carlo\": { \"samples\": 20, \"seed\": 1, \"control\": true } }", true),
        (&quasi("quasi_monte_carlo", 2, ", \"control\": true"), true),
        (&quasi("quasi_monte_carlo", 4, ", \"control\": false"), true),
        (&quasi("sobol_indices", 4, ""), true),
        ("{ \"multilevel\": { \"tolerance\": 0.06, \"seed\": 1 } }", true),
    ];
    for (method, varies) in methods {
        let text = PLATE.replace("\"propagated\"", method);
        let (_folder, written) = run_text(&text);
        let written = written.unwrap();
        assert!(written.iter().all(|path| path.exists()), "{written:?}");
        let result = std::fs::read_to_string(&written[0]).unwrap();
        let result: Value = serde_json::from_str(&result).unwrap();
        let pressure = &result["gauges"][0]["quantities"][0]["values"][2];
        // p = rho_0 (C + S_1 u) u within one per cent, and its deviation 5 % of rho_0 S_1 u^2; the frozen one twice
        // that.
        let mean = pressure["mean"].as_f64().unwrap();
        assert!((mean / 0.474_420 - 1.0).abs() < 0.01, "{mean}");
        assert_eq!(pressure["standard_deviation"].is_number(), varies, "{method}");
        if varies {
            let deviation = pressure["standard_deviation"].as_f64().unwrap();
            let exact = 0.05 * 7.83 * 1.49 * 0.01;
            let frozen = if method.contains("frozen") { 2.08 } else { 1.0 };
            assert!((deviation / exact / frozen - 1.0).abs() < 0.1, "{method}: {deviation}");
        }
    }
}

#[test]
fn fewer_samples_than_a_checkpoint_holds_are_the_first_of_them_and_none_is_lost() {
    let of = |samples: u64| {
        let method = format!(
            "{{ \"monte_carlo\": {{ \"samples\": {samples}, \"seed\": 1, \"control\": false }} }}"
        );
        PLATE.replace("\"propagated\"", &method).replace("\"fields\": true", "\"fields\": false")
    };
    let (folder, written) = run_text(&of(20));
    written.unwrap();
    let out = folder.path().join("out");
    let (of_all, kept) = (gauges(&out), checkpoints(&out));
    let resume = |samples: u64| {
        again(folder.path(), &of(samples), Start::GoOn).unwrap();
        gauges(&out)
    };
    let (anew, written) = run_text(&of(8));
    written.unwrap();
    assert_eq!(resume(8), gauges(&anew.path().join("out")));
    assert_eq!(checkpoints(&out), kept);
    assert_eq!(resume(20), of_all);
}

/// The plate is too fast for its equation of state, which only a run shows.
#[test]
fn a_file_that_is_no_shard_is_refused_before_anything_is_run() {
    let sampled = r#"{ "monte_carlo": { "samples": 8, "seed": 1, "control": false } }"#;
    let text = PLATE.replace("[-0.1]", "[-5]").replace("\"propagated\"", sampled);
    let (folder, whole) = run_text(&text);
    assert!(matches!(whole, Err(RunError::Solver(_))), "{whole:?}");
    let file = folder.path().join("scene.json");
    let part = EnsemblePart::Merged(vec![file.clone()]);
    let options = Options { part, ..Options::new(folder.path().join("joined")) };
    let joined = run(ALL, &file, &options, &Progress::silent());
    assert!(matches!(joined, Err(RunError::Checkpoint(CheckpointError::Refused(_)))), "{joined:?}");
}

fn assert_mistake((right, wrong): (&str, &str), path: &str, words: &str) {
    assert!(PLATE.contains(right), "{right}");
    let (_folder, result) = run_text(&PLATE.replace(right, wrong));
    let RunError::Scene(error) = result.unwrap_err() else { panic!("{wrong}") };
    let mistake = error.mistake().unwrap();
    assert_eq!(mistake.path, path, "{}", mistake.message);
    assert!(mistake.message.contains(words), "{}", mistake.message);
}

#[test]
fn mistakes_in_gravity_and_polygons_are_shown_where_they_are() {
    for (right, wrong, path, words) in [
        (
            "\"dimension\": 1",
            "\"dimension\": 1, \"gravity_history\": [[0, 0], [1, 1]]",
            "gravity_history",
            "there is no `gravity`",
        ),
        (
            "\"dimension\": 1",
            "\"dimension\": 1, \"gravity\": [1], \"gravity_history\": [[1, 0], [0.5, 1]]",
            "gravity_history[1]",
            "must not be less than 1",
        ),
        (
            "{ \"box\": { \"from\": [0], \"to\": [3] } }",
            "{ \"polygon\": { \"corners\": [[0], [3], [2]] } }",
            "bodies[0].shape.polygon",
            "in two dimensions",
        ),
    ] {
        assert_mistake((right, wrong), path, words);
    }
}

#[test]
fn mistakes_are_shown_where_they_stand() {
    for (right, wrong, path, words) in [
        (
            "\"mie_gruneisen\": { \"library\": \"steel\" }",
            "\"mie_gruneisen\": { \"library\": \"steel\", \"set\": { \"density\": -7.8 } }",
            "materials.steel",
            "density",
        ),
        (
            "steel.equation.s1\", \"law\": \"normal\", \"coefficient_of_variation\": 0.05",
            "steel.equation.sound_speed\", \"law\": \"normal\", \"coefficient_of_variation\": 0.4",
            "random[0].coefficient_of_variation",
            "chance",
        ),
        ("[[0.2], [1.2]]", "[[4.2], [5.2]]", "gauges[0]", "inside the body"),
        ("steel.equation.s1", "steel.equation.s4", "random[0].parameter", "s4"),
        ("\"pressure\", \"density\"", "\"presure\", \"density\"", "quantities[0]", "presure"),
        ("\"axis\": 1", "\"axis\": 2", "boundaries[0].axis", "axis 2"),
        ("[3, 4, [3, 4]]", "[3, 4, [4, 3]]", "times", "window"),
        ("\"dimension\": 1", "\"dimension\": 1, \"gravity\": [0, 0]", "gravity", "2 coordinates"),
        ("\"from\": [0]", "\"from\": [0, 1]", "bodies[0].shape.box.from", "2 coordinates"),
        (
            "\"propagated\"",
            &quasi("sobol_indices", 12, ""),
            "method.sobol_indices.points",
            "12 Sobol' points, must be a power of two",
        ),
        (
            "\"propagated\"",
            &quasi("quasi_monte_carlo", 4, ", \"control\": true").replace(": 8", ": 4"),
            "method.quasi_monte_carlo.replicas",
            "4 replicas, at least 8 needed",
        ),
    ] {
        assert_mistake((right, wrong), path, words);
    }
}

/// Two bodies in the plane, one of which burns.
const CHARGE: &str = r#"{
  "solver": "smpm",
  "title": "Charge and plate",
  "units": "cm_g_us",
  "dimension": 2,
  "grid": { "cell": 0.5, "particles_per_cell": 2 },
  "materials": {
    "tnt": { "equation": { "jwl": { "library": "tnt" } }, "detonation": { "point": [0, 1], "cells": 2 } },
    "steel": { "equation": { "mie_gruneisen": { "library": "steel" } } }
  },
  "bodies": [
    { "name": "charge", "material": "tnt", "shape": { "box": { "from": [0, 0], "to": [2, 2] } } },
    { "name": "plate", "material": "steel", "shape": { "box": { "from": [2, 0], "to": [3, 2] } } }
  ],
  "method": "deterministic",
  "gauges": [
    { "name": "near", "body": "plate", "at": [2.25, 1] },
    { "name": "far", "body": "plate", "at": [2.75, 1] }
  ],
  "quantities": ["pressure"],
  "times": [0.1]
}"#;

#[test]
fn bodies_that_cannot_be_are_refused_before_anything_runs() {
    for (from, to, path, part) in [
        (
            "\"from\": [2, 0], \"to\": [3, 2]",
            "\"from\": [1.5, 0], \"to\": [3, 2]",
            "bodies[1].shape",
            "overlap: 16 of the 48 particles of `plate` lie in `charge`",
        ),
        ("\"name\": \"plate\"", "\"name\": \"charge\"", "bodies[1].name", "another body `charge`"),
        ("\"name\": \"far\"", "\"name\": \"near\"", "gauges[1].name", "another gauge `near`"),
        (
            "\"point\": [0, 1]",
            "\"point\": [4, 1]",
            "materials.tnt.detonation.point",
            "the nearest particle is 2.125 away",
        ),
    ] {
        assert!(CHARGE.contains(from));
        let (_folder, written) = run_text(&CHARGE.replacen(from, to, 1));
        let error = written.unwrap_err();
        let RunError::Scene(error) = error else { panic!("{error}") };
        let mistake = error.mistake().unwrap();
        assert_eq!(mistake.path, path);
        assert!(mistake.message.contains(part), "{}", mistake.message);
    }
}

#[test]
fn a_size_off_the_lattice_is_noted_in_the_result() {
    for (to, notes) in [
        ("[3, 2]", 0),
        // 4.8 and 8.4 spacings: five and eight are filled.
        ("[3.2, 2.1]", 2),
    ] {
        let text = CHARGE.replacen("\"to\": [3, 2]", &format!("\"to\": {to}"), 1);
        let (folder, written) = run_text(&text);
        written.unwrap();
        let result = std::fs::read_to_string(folder.path().join("out/result.json")).unwrap();
        let result: Value = serde_json::from_str(&result).unwrap();
        let noted = result["notes"].as_array().map_or(&[][..], Vec::as_slice);
        assert_eq!(noted.len(), notes);
        if notes > 0 {
            let text = noted[0].as_str().unwrap();
            assert!(text.contains("`plate` is 1.25 along axis 1, not 1.2"), "{text}");
        }
    }
}
