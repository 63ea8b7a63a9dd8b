//! Scenes whose constants vary in space: complete runs by every method, and their errors one by one.

use std::path::{Path, PathBuf};

use random_fields::{
    Correlation, CorrelationFunction, RandomField, SpatialCorrelation, Truncation,
};
use scenes::checkpoint::Start;
use scenes::{ALL, EnsemblePart, Options, Progress, RunError, run};
use serde_json::Value;
use tempfile::TempDir;

use crate::long_runs::refused_and_resumed;

/// An elastic bar runs into a wall, in uniaxial strain.
const BAR: &str = r#"{
  "solver": "smpm",
  "title": "Bar of random stiffness",
  "units": "mm_mg_us",
  "dimension": 1,
  "grid": { "cell": 0.5, "particles_per_cell": 2 },
  "boundaries": [{ "axis": 1, "position": 0, "side": "above", "kind": "symmetry" }],
  "materials": {
    "steel": {
      "equation": { "elastic_bulk": { "set": { "density": 7.8, "bulk_modulus": 160 } } },
      "strength": { "elastic": { "set": { "shear_modulus": 80 } } }
    }
  },
  "bodies": [
    { "name": "bar", "material": "steel", "shape": { "box": { "from": [0], "to": [20] } }, "velocity": [-0.01] }
  ],
  "random_fields": [
    {
      "parameters": ["steel.equation.bulk_modulus", "steel.strength.shear_modulus"],
      "marginal": { "lognormal": { "coefficient_of_variation": 0.1 } },
      "correlation": { "function": "matern32", "lengths": [5] },
      "terms": { "number": 9 }
    }
  ],
  "method": "propagated",
  "gauges": [{ "name": "end", "body": "bar", "at": [19.9] }],
  "quantities": ["position_1"],
  "times": [6],
  "fields": true
}"#;

fn run_text(text: &str) -> (TempDir, Result<Vec<PathBuf>, RunError>) {
    let folder = tempfile::tempdir().unwrap();
    let result = run_in(folder.path(), text, &Options::new(folder.path().join("out")));
    (folder, result)
}

fn run_in(folder: &Path, text: &str, options: &Options) -> Result<Vec<PathBuf>, RunError> {
    std::fs::create_dir_all(folder).unwrap();
    let scene = folder.join("scene.json");
    std::fs::write(&scene, text).unwrap();
    run(ALL, &scene, options, &Progress::silent()).map(|it| it.files)
}

fn result(out: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("result.json")).unwrap()).unwrap()
}

#[test]
fn every_method_gives_the_deviation_of_the_samples() {
    let methods = [
        "\"propagated\"",
        "{ \"finite_difference\": { \"step\": 0.01 } }",
        "{ \"forward_difference\": { \"step\": 0.01 } }",
        "{ \"monte_carlo\": { \"samples\": 80, \"seed\": 1, \"control\": true } }",
    ];
    let runs = [3, 19, 10, 83];
    let mut deviations = Vec::new();
    for (method, n_runs) in methods.into_iter().zip(runs) {
        let text = BAR.replace("\"propagated\"", method);
        let (_folder, written) = run_text(&text);
        let written = written.unwrap();
        let result = std::fs::read_to_string(&written[0]).unwrap();
        let result: Value = serde_json::from_str(&result).unwrap();
        let field = &result["random_fields"][0];
        assert_eq!(field["terms"], 9);
        let left_out = |key: &str| field[key].as_f64().unwrap();
        assert!((1e-4..0.05).contains(&left_out("mean_left_out_variance")));
        assert!(left_out("largest_left_out_variance") > left_out("mean_left_out_variance"));
        assert_eq!(result["work"]["runs"], n_runs, "{method}");
        let end = &result["gauges"][0]["quantities"][0]["values"][0];
        deviations.push(end["standard_deviation"].as_f64().unwrap());
        // The fields have the constants of a realisation.
        let fields = written.iter().find(|path| path.extension().is_some_and(|it| it == "vtu"));
        let fields = String::from_utf8_lossy(&std::fs::read(fields.unwrap()).unwrap()).into_owned();
        assert!(fields.contains("steel.equation.bulk_modulus"));
        assert!(fields.contains("\"position_1\"") && !fields.contains("position_1_mean"));
    }
    for deviation in &deviations[1..] {
        // Third derivatives, and the samples' own error with a control variate.
        assert!((deviation / deviations[0] - 1.0).abs() < 0.05, "{deviations:?}");
    }
}

/// A wedge in the plane: its box is that of its corners, and a product of exponentials has its eigenfunctions there.
#[test]
fn a_polygon_with_a_separable_field_is_expanded_on_the_box_of_its_corners() {
    let text = BAR
        .replace("\"dimension\": 1", "\"dimension\": 2")
        .replace(
            "{ \"box\": { \"from\": [0], \"to\": [20] } }, \"velocity\": [-0.01]",
            "{ \"polygon\": { \"corners\": [[0, 0], [20, 0], [0, 10]] } }, \"velocity\": [-0.01, 0]",
        )
        .replace("\"cell\": 0.5", "\"cell\": 1")
        .replace(
            "{ \"function\": \"matern32\", \"lengths\": [5] }",
            "{ \"function\": \"exponential\", \"lengths\": [5, 2], \"separable\": true }",
        )
        .replace("\"at\": [19.9]", "\"at\": [0.25, 0.25]")
        .replace("\"propagated\"", "\"deterministic\"");
    let (_folder, written) = run_text(&text);
    let result = std::fs::read_to_string(&written.unwrap()[0]).unwrap();
    let result: Value = serde_json::from_str(&result).unwrap();
    // Half of the places of a lattice of 40 by 20; none is on the inclined edge.
    assert_eq!(result["work"]["particles"], 400);
    let of = |length| Correlation { function: CorrelationFunction::Exponential, length };
    let correlation = SpatialCorrelation::separable([of(5.0), of(2.0)]);
    let corners = [[0.0, 0.0], [20.0, 10.0]];
    let field = RandomField::on_box(corners, correlation, Truncation::Terms(9)).unwrap();
    let left_out = &result["random_fields"][0]["mean_left_out_variance"];
    let expected = field.mean_left_out_variance();
    assert_eq!(left_out.as_f64().map(f64::to_bits), Some(expected.to_bits()));
}

/// The bar by multilevel Monte Carlo, to a tolerance, with more keys of the method.
fn on_grids(tolerance: f64, more: &str) -> String {
    let method =
        format!("{{ \"multilevel\": {{ \"tolerance\": {tolerance}, \"seed\": 3{more} }} }}");
    let text =
        BAR.replace("\"propagated\"", &method).replace("\"fields\": true", "\"fields\": false");
    text.replace("\"times\"", "\"levels\": { \"position_1\": [19.867] },\n  \"times\"")
}

#[test]
fn a_plan_that_would_take_too_long_is_refused_and_goes_on_where_it_was() {
    refused_and_resumed("levels", &on_grids(0.4, ""));
}

#[test]
fn most_samples_are_on_coarse_grids_and_a_continued_run_has_the_bits_of_a_new_one() {
    let (folder, written) = run_text(&on_grids(0.2, ""));
    written.unwrap();
    let out = folder.path().join("out");
    let resumed = Options { start: Start::GoOn, ..Options::new(&out) };
    run_in(folder.path(), &on_grids(0.1, ""), &resumed).unwrap();
    let on = |n_threads: usize| {
        let (folder, text) = (folder.path().join(format!("{n_threads}")), on_grids(0.1, ""));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| run_in(&folder, &text, &Options::new(folder.join("out")))).unwrap();
        result(&folder.join("out"))
    };
    let (continued, anew) = (result(&out), on(1));
    for key in ["gauges", "multilevel", "notes"] {
        assert_eq!(continued[key], anew[key]);
        assert_eq!(on(2)[key], anew[key]);
    }
    let grids = anew["multilevel"]["grids"].as_array().unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    assert_eq!(
        grids.iter().map(|grid| number(&grid["cell"])).collect::<Vec<_>>(),
        [4.0, 2.0, 1.0, 0.5]
    );
    // Waves on a few cells are another response.
    let is_used: Vec<bool> = grids.iter().map(|grid| grid["is_used"] == true).collect();
    assert_eq!(is_used, [false, false, true, true], "{grids:?}");
    let notes = anew["notes"].to_string();
    assert!(
        notes.contains("grids of cell 4, 2 do not pay and are dropped: the difference"),
        "{notes}"
    );
    assert!(number(&grids[3]["samples"]) < 0.2 * number(&grids[2]["samples"]), "{grids:?}");
    assert_eq!(anew["multilevel"]["is_reached"], true);
    let end = &anew["gauges"][0]["quantities"][0]["values"][0];
    let (variance, error) = (number(&end["variance"]), number(&end["variance_standard_error"]));
    assert!((0.02..=0.1).contains(&(error / variance)), "{end}");
    // The deviation by derivatives, whose third order is at most a few per cent.
    let (of_series, written) = run_text(BAR);
    written.unwrap();
    let series = &result(&of_series.path().join("out"))["gauges"][0]["quantities"][0]["values"][0];
    let apart = number(&series["variance"]) - variance;
    assert!(apart.abs() < 4.0 * error + 0.05 * variance, "{series} {end}");
    // The same point on each grid; the nearest particle of the coarser one starts an eighth to the side.
    let change = number(&end["change_from_coarser_grid"]["mean"]);
    assert!(change.abs() < 1e-3, "{end}");
    let chance = &end["exceedance"][0];
    let of_normal = &series["exceedance"];
    assert!(of_normal.is_null() && number(&chance["standard_error"]) > 0.0, "{chance}");
    // The level is the median of a normal distribution to 0.15 deviations.
    let error = number(&chance["standard_error"]);
    assert!(
        (number(&chance["probability"]) - 0.5).abs() < 0.06 + 4.0 * error && error < 0.1,
        "{chance}"
    );
}

#[test]
fn what_multilevel_cannot_have_is_refused() {
    for (text, path, words) in [
        (on_grids(0.0, ""), "tolerance", "must be greater than 0"),
        (on_grids(0.1, ", \"pilot\": 7"), "pilot", "there must be 8"),
        (on_grids(0.1, ", \"most_runs\": 0"), "most_runs", "0 runs"),
        (on_grids(0.01, ", \"most_runs\": 30"), "most_runs", "at most 30 are allowed"),
        (on_grids(0.1, ", \"coarsest_cell\": 3"), "coarsest_cell", "power of two: 1, 2, ..."),
        (on_grids(0.1, ", \"coarsest_cell\": 0.5"), "coarsest_cell", "power of two: 1, 2, ..."),
        (
            on_grids(0.1, ", \"coarsest_cell\": 8"),
            "coarsest_cell",
            "there is no grid of cell 8: length 1 of body `bar` is 2.5 cells of 8",
        ),
        (
            on_grids(0.1, "").replace("\"cell\": 0.5", "\"cell\": 4"),
            "",
            "no grid with twice the cell 4 of the scene: length 1 of body `bar` is 2.5 cells of 8",
        ),
    ] {
        let (_folder, result) = run_text(&text);
        let RunError::Scene(error) = result.unwrap_err() else { panic!("{words}") };
        let mistake = error.mistake().unwrap();
        let path = ["method.multilevel", path].join(".");
        assert_eq!(mistake.path, path.trim_end_matches('.'), "{}", mistake.message);
        assert!(mistake.message.contains(words), "{}", mistake.message);
    }
    let folder = tempfile::tempdir().unwrap();
    let part = EnsemblePart::Shard("1/2".parse().unwrap());
    let options = Options { part, ..Options::new(folder.path().join("out")) };
    let refused = run_in(folder.path(), &on_grids(0.1, ""), &options);
    assert!(matches!(refused, Err(RunError::NoShardsOfAPlan)), "{refused:?}");
}

const MARGINAL: &str = "\"lognormal\": { \"coefficient_of_variation\": 0.1 }";

/// What is replaced in the scene, by what, where the mistake is shown, and a part of its message.
const MISTAKES: &[(&str, &str, &str, &str)] = &[
    ("bulk_modulus\",", "bulk_module\",", "random_fields[0].parameters[0]", "bulk_module"),
    ("\"steel.equation.b", "\"stel.equation.b", "random_fields[0].parameters[0]", "stel"),
    (
        "steel.strength.shear",
        "steel.equation.bulk",
        "random_fields[0].parameters[1]",
        "given twice",
    ),
    ("\"number\": 9", "\"number\": 0", "random_fields[0].terms.number", "number of terms is 0"),
    (
        "\"lengths\": [5]",
        "\"lengths\": [0]",
        "random_fields[0].correlation.lengths",
        "correlation length is 0",
    ),
    (
        "\"lengths\": [5]",
        "\"lengths\": [20001]",
        "random_fields[0].correlation.lengths",
        "1000 times the size of the body",
    ),
    (
        "\"lengths\": [5]",
        "\"lengths\": [0.001]",
        "random_fields[0].correlation.lengths",
        "at most 1e4",
    ),
    (
        "\"lengths\": [5]",
        "\"lengths\": [5, 5]",
        "random_fields[0].correlation.lengths",
        "2 coordinates",
    ),
    (
        MARGINAL,
        "\"normal\": { \"coefficient_of_variation\": 0.3 }",
        "random_fields[0].marginal.normal.coefficient_of_variation",
        "below 0 with the probability",
    ),
    (
        MARGINAL,
        "\"weibull\": { \"coefficient_of_variation\": 20 }",
        "random_fields[0].marginal.weibull.coefficient_of_variation",
        "must lie between",
    ),
    ("\"propagated\"", "\"sigma_points\"", "method", "does not go with"),
    (
        "\"method\"",
        "\"random\": [{ \"parameter\": \"steel.strength.shear_modulus\", \"law\": \"normal\", \"coefficient_of_variation\": 0.01 }], \"method\"",
        "random_fields",
        "not both",
    ),
    (
        "{ \"elastic_bulk\": { \"set\": { \"density\": 7.8, \"bulk_modulus\": 160 } } },\n      \"strength\": { \"elastic\": { \"set\": { \"shear_modulus\": 80 } } }",
        "{ \"neo_hookean\": { \"set\": { \"density\": 7.8, \"bulk_modulus\": 160, \"shear_modulus\": 80 } } }",
        "random_fields[0].parameters",
        "cannot vary in space",
    ),
];

#[test]
fn mistakes_in_random_fields_are_shown_where_they_are() {
    for &(right, wrong, path, words) in MISTAKES {
        assert!(BAR.contains(right), "{right}");
        let mut text = BAR.replacen(right, wrong, 1);
        if wrong.contains("neo_hookean") {
            text = text.replace(", \"steel.strength.shear_modulus\"", "");
        }
        let (_folder, result) = run_text(&text);
        let RunError::Scene(error) = result.unwrap_err() else { panic!("{wrong}") };
        let mistake = error.mistake().unwrap();
        assert_eq!(mistake.path, path, "{}", mistake.message);
        assert!(mistake.message.contains(words), "{}", mistake.message);
    }
}
