//! Loads that grow slowly, supports, laws of bonds.

use scenes::EnsemblePart;

use super::*;

/// A plate pulled slowly; each realisation takes a fraction of a second.
fn slow(changes: &[(&str, &str)]) -> String {
    let dynamics = PLATE.split("  \"dynamics\": ").nth(1).unwrap().split("  \"strength\"").next();
    let dynamics = format!("  \"dynamics\": {}", dynamics.unwrap());
    let quiet = "  \"dynamics\": { \"quasi_static\": { \"batch\": 0.02 } },\n";
    let few = ("\"realisations\": 12", "\"realisations\": 3");
    let all = [&[(dynamics.as_str(), quiet), few, ("[0, 11]", "[0, 2]")], changes].concat();
    with(&all)
}

const GRIPS: &str = "\"grips\": { \"height\": 0.002, \"hold\": \"clamped\" },";
const STRETCH: &str = "\"stretch\": { \"strain\": { \"over_critical_stretch\": 0.8 } }";
const SUPPORTS: &str = "\"supports\": [{ \"region\": { \"low\": [0, 0], \"high\": [0.016, 0.001] }, \"hold\": \"both\", \"protected\": 0.001 }],";
const LIFTED: &str = "\"displacement\": { \"region\": { \"low\": [0, 0.015], \"high\": [0.016, 0.016] }, \"until\": [0, 2e-6], \"protected\": 0.001 }";
const TOUGHNESS: &str = "\"toughness\": { \"energy_release_rate\": 3.8 }";
/// Bonds that break at once at this strength take 3.8 J/m^2.
const SOFTENING: &str =
    "\"toughness\": { \"softening\": { \"tensile_strength\": 14e6, \"fracture_energy\": 10 } }";
const SOLID: &str =
    "\"young_modulus\": 72e9, \"law\": { \"linear_solid\": { \"poisson_ratio\": 0.22 } }";

#[test]
fn every_law_runs_slowly_and_its_load_is_over_strain_or_displacement() {
    let cases: [&[(&str, &str)]; 4] = [
        &[],
        &[(TOUGHNESS, SOFTENING)],
        &[("\"young_modulus\": 72e9", SOLID)],
        &[(GRIPS, SUPPORTS), (STRETCH, LIFTED)],
    ];
    for (number, changes) in cases.into_iter().enumerate() {
        let ran = run_text(&slow(changes));
        let result = ran.result();
        assert!(result["failures"].as_array().unwrap().is_empty(), "{}", result["failures"]);
        assert!(result["broken_bonds"]["value"].as_f64().unwrap() > 10.0);
        let (resolved, load) = (&result["resolved"], &result["load"]);
        assert!(resolved["dt"].is_null() && resolved["duration"].is_null());
        let key = if number == 3 { "displacement" } else { "strain" };
        let end = resolved[format!("final_{key}")].as_f64().unwrap();
        assert_eq!(load.as_array().unwrap().len(), 10);
        assert!((load[9][key].as_f64().unwrap() / end - 1.0).abs() < 1e-12);
        // A plate, less its notch, as a bar of plane stress between plates that hold it.
        let first = load[0]["load"]["value"].as_f64().unwrap();
        let strain = if number == 3 { end / 0.015 } else { end } / 10.0;
        let bar = 72e9 * strain * 0.016 * 0.001;
        assert!(first > 0.5 * bar && first < 1.2 * bar, "{number}: {first} {bar}");
    }
}

#[test]
fn a_solid_runs_in_time_and_in_single_precision() {
    let steps = ("\"steps\": 400", "\"steps\": 400, \"breaking\": \"bridge\"");
    let heun = ("\"leimkuhler_matthews\"", "\"heun\"");
    let solid = ("\"young_modulus\": 72e9", SOLID);
    for precision in ["\"f64\"", "\"f32\""] {
        let ran = run_text(&with(&[steps, heun, solid, ("\"f64\"", precision)]));
        let result = ran.result();
        assert!(result["failures"].as_array().unwrap().is_empty());
        assert!(result["failure_load"]["mean"]["value"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn a_slow_ensemble_has_the_same_bits_in_shards_and_after_a_checkpoint() {
    let text = slow(&[]);
    let ran = run_text(&text);
    let whole = ran.result();
    let shard = |k: u64| {
        let part = EnsemblePart::Shard(format!("{k}/2").parse().unwrap());
        let out = ran.folder().join(format!("shard-{k}"));
        ran.again(&Options { part, ..Options::new(out) }).unwrap().remove(0)
    };
    let part = EnsemblePart::Merged([2, 1].map(shard).to_vec());
    let merged = ran.again(&Options { part, ..Options::new(ran.folder().join("merged")) }).unwrap();
    let read = |path: &Path| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    };
    let merged = read(&merged[0]);
    // Two realisations, then one more after the checkpoint of these.
    let fewer = [("\"realisations\": 3", "\"realisations\": 2"), ("[0, 2]", "[0]")];
    let fewer = fewer.iter().fold(text.clone(), |text, (from, to)| text.replace(from, to));
    std::fs::write(ran.folder().join("scene.json"), fewer).unwrap();
    let out = || Options::new(ran.folder().join("grown"));
    ran.again(&out()).unwrap();
    std::fs::write(ran.folder().join("scene.json"), text.replace("[0, 2]", "[0]")).unwrap();
    let grown = ran.again(&Options { start: Start::GoOn, ..out() }).unwrap();
    let grown = read(&grown[0]);
    for key in ["realisations", "load", "path", "failure_load", "outcomes"] {
        assert_eq!(merged[key], whole[key], "{key}");
        assert_eq!(grown[key], whole[key], "{key}");
    }
}

/// Replaced text, replacement, key, part of the message.
const SLOW_MISTAKES: [[&str; 4]; 12] = [
    [
        "\"strength\": {",
        "\"time\": { \"step\": { \"z\": 1 }, \"steps\": 9 }, \"strength\": {",
        "time",
        "has no steps in time",
    ],
    ["\"f64\"", "\"f32\"", "ensemble.precision", "double precision"],
    ["\"batch\": 0.02", "\"batch\": 1", "dynamics.quasi_static.batch", "the batch of bonds is 1"],
    [
        "\"batch\": 0.02",
        "\"tolerance\": 0",
        "dynamics.quasi_static.tolerance",
        "the tolerance is 0",
    ],
    [STRETCH, "\"velocity\": { \"speed\": 1 }", "loading.velocity", "has no speed"],
    [STRETCH, LIFTED, "loading.displacement", "held by `grips`"],
    [GRIPS, SUPPORTS, "loading.stretch", "there are none"],
    [GRIPS, "", "loading", "nothing holds the body"],
    [
        TOUGHNESS,
        "\"toughness\": { \"softening\": { \"tensile_strength\": 14e6, \"fracture_energy\": 1 } }",
        "material.toughness.softening.fracture_energy",
        "the fracture energy is 1 J/m^2; bonds of this strength",
    ],
    [
        "\"young_modulus\": 72e9",
        "\"young_modulus\": 72e9, \"law\": { \"linear_solid\": { \"poisson_ratio\": 0.5 } }",
        "material.law.linear_solid.poisson_ratio",
        "Poisson's ratio is 0.5; it must lie between -1 and 0.5",
    ],
    [
        "\"strength\": {",
        "\"stiffness\": { \"weibull_by_volume\": { \"modulus\": 9, \"reference_volume\": 1 } }, \"strength\": {",
        "stiffness.weibull_by_volume",
        "is no weakest link",
    ],
    [
        GRIPS,
        "\"grips\": { \"height\": 0.002 }, \"supports\": [{ \"region\": { \"low\": [0, 0], \"high\": [1, 1] }, \"hold\": \"x\" }],",
        "supports",
        "held by `grips` already",
    ],
];

#[test]
fn mistakes_of_slow_loads_are_shown_where_they_stand() {
    for [right, wrong, path, words] in SLOW_MISTAKES {
        let found = mistake(&format!("slow-{path}"), &slow(&[(right, wrong)]));
        assert_eq!(found.0, path, "{}", found.1);
        assert!(found.1.contains(words), "{}", found.1);
    }
    let lifted = [(GRIPS, SUPPORTS), (STRETCH, LIFTED)];
    let more = |from: &str, to: &str| {
        let text = slow(&lifted);
        assert!(text.contains(from), "{from}");
        mistake("slow-lifted", &text.replace(from, to))
    };
    let found = more("[0, 0.015]", "[0, 0.0158]");
    assert_eq!(found.0, "loading.displacement.region");
    assert!(found.1.contains("no node lies in the region"), "{}", found.1);
    assert_eq!(more("[0, 2e-6]", "[0, 0]").0, "loading.displacement.until");
    assert_eq!(
        more("\"hold\": \"both\", \"protected\": 0.001", "\"hold\": \"both\", \"protected\": -1").0,
        "supports[0].protected"
    );
    let twice = more("\"high\": [0.016, 0.001]", "\"high\": [0.016, 0.016]");
    assert_eq!(twice.0, "supports", "{}", twice.1);
    let softens = mistake("softens-in-time", &with(&[(TOUGHNESS, SOFTENING)]));
    assert_eq!(softens.0, "material.toughness.softening");
    let field = PLATE.split("\"strength\": ").nth(1).unwrap().split(",\n  \"ensemble\"").next();
    let stiffness = format!("\"stiffness\": {},\n  \"ensemble\"", field.unwrap());
    let solid = ("\"young_modulus\": 72e9", SOLID);
    let varying = mistake("varying", &with(&[solid, ("\"ensemble\"", &stiffness)]));
    assert_eq!(varying.0, "stiffness", "{}", varying.1);
}
