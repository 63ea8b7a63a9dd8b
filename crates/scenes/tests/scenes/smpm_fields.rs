//! Scenes whose constants vary in space: complete runs by every method, and their errors one by one.

use std::path::PathBuf;

use random_fields::{
    Correlation, CorrelationFunction, RandomField, SpatialCorrelation, Truncation,
};
use scenes::{ALL, Options, Progress, RunError, run};
use serde_json::Value;

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

fn run_text(name: &str, text: &str) -> (PathBuf, Result<Vec<PathBuf>, RunError>) {
    let folder = std::env::temp_dir().join(format!("smpm-field-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let scene = folder.join("scene.json");
    std::fs::write(&scene, text).unwrap();
    let result = run(ALL, &scene, &Options::new(folder.join("out")), &Progress::silent());
    (folder, result)
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
    for (number, (method, n_runs)) in methods.into_iter().zip(runs).enumerate() {
        let text = BAR.replace("\"propagated\"", method);
        let (folder, written) = run_text(&format!("method-{number}"), &text);
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
        std::fs::remove_dir_all(&folder).unwrap();
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
    let (folder, written) = run_text("polygon", &text);
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
    std::fs::remove_dir_all(&folder).unwrap();
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
    for (number, &(right, wrong, path, words)) in MISTAKES.iter().enumerate() {
        assert!(BAR.contains(right), "{right}");
        let mut text = BAR.replacen(right, wrong, 1);
        if wrong.contains("neo_hookean") {
            text = text.replace(", \"steel.strength.shear_modulus\"", "");
        }
        let (folder, result) = run_text(&format!("mistake-{number}"), &text);
        let RunError::Scene(error) = result.unwrap_err() else { panic!("{wrong}") };
        let mistake = error.mistake().unwrap();
        assert_eq!(mistake.path, path, "{}", mistake.message);
        assert!(mistake.message.contains(words), "{}", mistake.message);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
