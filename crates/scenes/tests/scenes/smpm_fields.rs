//! Scenes whose constants vary in space: complete runs by every method.

use random_fields::{
    Correlation, CorrelationFunction, RandomField, SpatialCorrelation, Truncation,
};
use scenes::RunError;
use serde_json::Value;

use crate::harness::{SceneRun, changed};
use crate::long_runs::refused_and_resumed;

/// An elastic bar runs into a wall, in uniaxial strain.
const BAR: &str = include_str!("../small/smpm/bar.json");

fn end_of(result: &Value) -> &Value {
    &result["gauges"][0]["quantities"][0]["values"][0]
}

#[test]
fn every_method_gives_the_deviation_of_the_samples() {
    let mut deviations = Vec::new();
    for (method, n_runs) in [
        ("'propagated'", 3),
        ("{ 'finite_difference': { 'step': 0.01 } }", 19 + 4),
        ("{ 'forward_difference': { 'step': 0.01 } }", 10 + 4),
        ("{ 'monte_carlo': { 'samples': 80, 'seed': 1, 'control': true } }", 83),
    ] {
        let ran = SceneRun::of(&changed(BAR, &[("'propagated'", method)]));
        let result = ran.result();
        let field = &result["random_fields"][0];
        assert_eq!(field["terms"], 9);
        let left_out = |key: &str| field[key].as_f64().unwrap();
        assert!((1e-4..0.05).contains(&left_out("mean_left_out_variance")));
        assert!(left_out("largest_left_out_variance") > left_out("mean_left_out_variance"));
        assert_eq!(result["work"]["runs"], n_runs, "{method}");
        deviations.push(end_of(&result)["standard_deviation"].as_f64().unwrap());
        // The fields have the constants of a realisation.
        let fields = std::fs::read(ran.out().join("fields/fields-0000.vtu")).unwrap();
        let fields = String::from_utf8_lossy(&fields);
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
    let text = changed(
        BAR,
        &[
            ("'dimension': 1", "'dimension': 2"),
            (
                "{ 'box': { 'from': [0], 'to': [20] } }, 'velocity': [-0.01]",
                "{ 'polygon': { 'corners': [[0, 0], [20, 0], [0, 10]] } }, 'velocity': [-0.01, 0]",
            ),
            ("'cell': 0.5", "'cell': 1"),
            (
                "{ 'function': 'matern32', 'lengths': [5] }",
                "{ 'function': 'exponential', 'lengths': [5, 2], 'separable': true }",
            ),
            ("'at': [19.9]", "'at': [0.25, 0.25]"),
            ("'propagated'", "'deterministic'"),
        ],
    );
    let result = SceneRun::of(&text).result();
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

/// The bar by multilevel Monte Carlo, to a tolerance.
fn on_grids(tolerance: f64) -> String {
    let method = format!("{{ 'multilevel': {{ 'tolerance': {tolerance}, 'seed': 3 }} }}");
    let levels = "'levels': { 'position_1': [19.867] },\n  'times'";
    changed(
        BAR,
        &[("'propagated'", &method), ("'fields': true", "'fields': false"), ("'times'", levels)],
    )
}

#[test]
fn a_plan_that_would_take_too_long_is_refused_and_goes_on_where_it_was() {
    refused_and_resumed(&on_grids(0.4));
}

#[test]
fn most_samples_are_on_coarse_grids_and_a_continued_run_has_the_bits_of_a_new_one() {
    let continued = SceneRun::of(&on_grids(0.2));
    continued.resume(&on_grids(0.1)).unwrap();
    let continued = continued.result();
    let on = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| SceneRun::of(&on_grids(0.1))).result()
    };
    let [anew, on_two] = [1, 2].map(on);
    for key in ["gauges", "multilevel", "notes"] {
        assert_eq!(continued[key], anew[key]);
        assert_eq!(on_two[key], anew[key]);
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
    let end = end_of(&anew);
    let (variance, error) = (number(&end["variance"]), number(&end["variance_standard_error"]));
    assert!((0.02..=0.1).contains(&(error / variance)), "{end}");
    // The deviation by derivatives, whose third order is at most a few per cent.
    let of_series = SceneRun::of(BAR).result();
    let series = end_of(&of_series);
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
fn a_plan_has_no_shards() {
    let ran = SceneRun::of(&on_grids(0.4));
    let refused = ran.shard("1/2", "shard");
    assert!(matches!(refused, Err(RunError::NoShardsOfAPlan)), "{refused:?}");
}
