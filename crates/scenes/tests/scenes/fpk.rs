//! Output of a run, and its continuation.

use scenes::RunError;

use crate::harness::{SceneRun, changed, checkpoints, result_in};

/// A scene of a few particles and steps.
const SMALL: &str = include_str!("../small/fpk/bouc_wen.json");

#[test]
fn a_run_in_three_dimensions_writes_result_pictures_and_cloud() {
    let ran = SceneRun::of(SMALL);
    let result = ran.result();
    let written = ran.written.as_ref().unwrap();
    for expected in
        ["result.json", "cloud/cloud.pvd", "moments.svg", "exceedance.svg", "plane-q-z-t0.200.svg"]
    {
        assert!(written.contains(&ran.out().join(expected)), "{expected} is not in {written:?}");
    }
    let cloud = std::fs::read(ran.out().join("cloud/cloud-0001.vtu")).unwrap();
    assert!(cloud.starts_with(b"<?xml"), "no file of VTK");
    let quantity = result["quantities"].as_array().unwrap();
    let named = |id: &str| quantity.iter().find(|series| series["id"] == id).unwrap();
    assert_eq!(named("moment/0-0-2")["quantity"], "E[z^2]");
    assert_eq!(named("exceedance-cell/0.1")["quantity"], "P(|z| > 0.1)");
    // At the start sigma_z = 0.05; a ball of 4 sigma holds all but 1.1e-3 of the mass.
    let z = named("moment/0-0-2")["values"][0]["value"].as_f64().unwrap();
    assert!((z / 0.0025 - 1.0).abs() < 0.05, "{z}");
}

#[test]
fn an_earlier_end_than_that_of_a_checkpoint_is_told_from_it_and_leaves_it_as_it_is() {
    let planes = ",\n  'planes': { 'states': [['q', 'z']], 'times': [0.2] }";
    // With steps so short that those with longer ones, for the error, come to the end too: one that does not is not kept.
    let steps = ("'reach': 4 }", "'reach': 4, 'steps_per_period': 160 }");
    let longer = changed(SMALL, &[(planes, ""), steps]);
    let ran = SceneRun::of(&longer);
    let kept = checkpoints(&ran.out());
    ran.resume(&changed(&longer, &[("'until': 0.2", "'until': 0.1")])).unwrap();
    assert!(checkpoints(&ran.out()) == kept && !kept.is_empty());
    let series = std::fs::read_to_string(ran.out().join("cloud/cloud.pvd")).unwrap();
    assert_eq!(series.matches("<DataSet ").count(), 1, "{series}");
    assert_eq!(ran.result()["quantities"][0]["values"].as_array().unwrap().len(), 1);
}

#[test]
fn another_number_of_paths_than_a_checkpoint_has_is_refused_and_leaves_it_as_it_is() {
    let paths = |n: u64| {
        let method = format!("'monte_carlo': {{ 'paths': {n}, 'step': 0.02, 'seed': 1 }}");
        changed(SMALL, &[("'flow_map_fit': { 'spacing': 0.8, 'reach': 4 }", &method)])
    };
    let ran = SceneRun::of(&paths(200));
    let kept = checkpoints(&ran.out());
    let error = ran.resume(&paths(100)).unwrap_err();
    assert!(matches!(error, RunError::Checkpoint(_)), "{error:?}");
    assert!(error.to_string().contains("is of another scene"), "{error}");
    assert!(checkpoints(&ran.out()) == kept && !kept.is_empty());
}

#[test]
fn a_filter_that_is_conditioned_out_leaves_the_questions_about_the_structure() {
    // A building with a viscous damper behind soil, whose states are conditioned out.
    let behind_soil = include_str!("../small/fpk/behind_soil.json");
    let longer = changed(behind_soil, &[("'until': 1", "'until': 2")]);
    let ran = SceneRun::of(behind_soil);
    // It goes on bit for bit.
    ran.resume(&longer).unwrap();
    let found = &result_in(&ran.out())["quantities"];
    assert_eq!(&SceneRun::of(&longer).result()["quantities"], found);
    // E[q^2] at t = 2 by 4,000,000 paths of Heun's method, 0.07 %.
    let last = found[0]["values"].as_array().unwrap().last().unwrap()["value"].as_f64().unwrap();
    let error = last / 0.0111849 - 1.0;
    // A spacing of 0.5: 0.1 % seen.
    assert!(error.abs() < 0.005, "{error:e}");
    // No lattice shows the error of one covariance of the filter, so that none is stated.
    for series in found.as_array().unwrap() {
        let is_asked = ["moment", "exceedance"]
            .iter()
            .any(|of| series["id"].as_str().unwrap().starts_with(of));
        let is_unknown = |at: &serde_json::Value| at["error"].is_null() && at["note"].is_string();
        assert!(
            !is_asked || series["values"].as_array().unwrap().iter().all(is_unknown),
            "{series}"
        );
    }
}

#[test]
fn a_cubic_spring_behind_soil_needs_fresh_lattices_and_its_run_says_so() {
    let built_in = include_str!("../../../../tests/scenes/fpk/duffing_kanai_tajimi.json");
    let short = [
        (",\n  'planes': { 'states': [['q', 'v']], 'times': [6] }", ""),
        ("'spacing': 0.25", "'spacing': 0.5"),
        ("'until': 6", "'until': 1"),
    ];
    let text = changed(built_in, &short);
    let on_one = changed(&text, &[(", 'fresh_lattices': {}", "")]);
    for (text, is_on_one) in [(text, false), (on_one, true)] {
        let said = SceneRun::of(&text).result()["unknown"].to_string();
        assert!(said.contains("one covariance"), "{said}");
        assert_eq!(said.contains("add `fresh_lattices`"), is_on_one, "{said}");
    }
}
