//! Complete runs of small plates.

pub(crate) mod inference;
mod points;
mod slow;

use std::path::Path;

use scenes::checkpoint::Start;
use scenes::{Options, RunError};

use crate::harness::{SceneRun, changed, no_shard_is_refused_first};

/// A plate of 16 by 16 nodes with a field of strength and a little noise.
const PLATE: &str = include_str!("../small/peridyn/notched.json");

/// The strength of that plate.
const FIELD: &str = "'strength': {
    'field': {
      'marginal': { 'lognormal': { 'coefficient_of_variation': 0.1 } },
      'correlation': { 'function': 'matern32', 'length': 0.006 }
    }
  }";

fn with(changes: &[(&str, &str)]) -> String {
    changed(PLATE, changes)
}

#[test]
fn a_scene_tells_its_resolved_inputs_and_every_number_with_its_error() {
    let ran = SceneRun::of(PLATE);
    let result = ran.result();
    let resolved = |key: &str| result["resolved"][key].as_f64().unwrap();
    assert_eq!((resolved("nodes"), resolved("z")), (256.0, 0.9));
    // sqrt(4 pi G0/(9 E delta)) of plane stress.
    let stretch = (4.0 * std::f64::consts::PI * 3.8 / (9.0 * 72e9 * 2.015e-3)).sqrt();
    assert!((resolved("critical_stretch") / stretch - 1.0).abs() < 1e-12);
    assert!((resolved("final_strain") / (0.8 * stretch) - 1.0).abs() < 1e-12);
    assert!((resolved("noise_ratio") - 20.0).abs() < 1e-12);
    let outcomes = result["outcomes"].as_array().unwrap();
    let of = |outcome: &serde_json::Value| outcome["probability"]["value"].as_f64().unwrap();
    // Each probability is a multiple of one twelfth.
    assert!((outcomes.iter().map(of).sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(result["realisations"].as_array().unwrap().len(), 12);
    assert_eq!(result["load"].as_array().unwrap().len(), 10);
    let load = &result["load"][0]["load"];
    assert!(load["value"].as_f64().unwrap() > 0.0);
    assert_eq!(load["error_kind"], "standard_error");
    assert_eq!(result["work"]["bond_steps"], resolved("bonds") * 400.0 * 12.0);
    let files: Vec<_> = ran.written.iter().flatten().filter_map(|path| path.file_name()).collect();
    for file in ["paths.svg", "load.svg", "realisation-0000.vtu", "realisation-0011.vtu"] {
        assert!(files.contains(&std::ffi::OsStr::new(file)), "{file}");
    }
}

#[test]
fn every_dynamics_mobility_and_strength_runs() {
    let identity = "'identity': { 'value': 1 }";
    let correlation = "'correlation': { 'function': 'gaussian', 'length': 0.002 }";
    let dense = format!("'dense': {{ 'value': 2, {correlation}, 'nugget': 0.1 }}");
    let low_rank =
        format!("'low_rank': {{ 'value': 2, {correlation}, 'nugget': 0.1, 'tolerance': 1e-3 }}");
    let lognormal = "'lognormal': { 'coefficient_of_variation': 0.1 }";
    let stiffness = FIELD.replace("'strength'", "'strength': 'uniform', 'stiffness'");
    let scheme = "'leimkuhler_matthews'";
    let cases: [&[(&str, &str)]; 8] = [
        &[(FIELD, &stiffness), ("'clamped'", "'clamped', 'protected': 0.004")],
        &[(identity, &dense)],
        &[(identity, &low_rank), ("'f64'", "'f32'")],
        &[(scheme, "'heun'"), ("'steps': 400", "'steps': 400, 'breaking': 'bridge'")],
        &[(scheme, "{ 'theta': 0.5 }"), ("0.9", "3")],
        &[(FIELD, "'strength': 'uniform'")],
        &[(lognormal, "'weibull': { 'shape': 8 }"), ("{ 'shells': 2 }", "{ 'length': 0.0021 }")],
        &[(lognormal, "'normal': { 'coefficient_of_variation': 0.1 }"), ("'clamped'", "'sliding'")],
    ];
    let inertial = include_str!("../small/peridyn/plate.json");
    let noisy =
        changed(inertial, &[("'temperature': 'zero'", "'temperature': { 'joule': 1e-12 }")]);
    for text in cases.map(with).into_iter().chain([noisy]) {
        let result = SceneRun::of(&text).result();
        let broken = result["broken_bonds"]["value"].as_f64().unwrap();
        assert!(broken.is_finite() && result["failures"].as_array().unwrap().is_empty());
    }
}

#[test]
fn realisations_that_do_not_differ_say_nothing_of_an_error() {
    let plate = include_str!("../small/peridyn/plate.json");
    let field = plate.find("{\n    \"field\"").unwrap();
    let end = plate.find("\"ensemble\"").unwrap();
    let uniform = format!("{}\"uniform\",\n  {}", &plate[..field], &plate[end..]);
    for n in [1, 3] {
        let one = format!("'realisations': {n}");
        let changes = [
            ("'realisations': 4", one.as_str()),
            ("[0, 2]", "[]"),
            ("'sliding'", "'sliding', 'protected': 0.005"),
        ];
        let result = SceneRun::of(&changed(&uniform, &changes)).result();
        for number in [&result["failure_load"]["mean"], &result["load"][3]["load"]] {
            assert!(number["value"].as_f64().unwrap() > 0.0 && number["error"].is_null());
            assert_eq!(number["error_kind"], "unknown");
        }
        assert_eq!(
            result["unknown"].as_array().unwrap().last().unwrap()["what"],
            "error of the lattice"
        );
    }
    let cut = "'spacing': 0.001, 'holes': [{ 'box': { 'low': [-0.001, 0.0095], 'high': [0.02, 0.0138] } }],";
    let ran = SceneRun::of(&changed(plate, &[("'spacing': 0.001,", cut)]));
    assert_eq!(ran.mistake().path, "body.holes");
}

#[test]
fn a_velocity_of_the_grips_is_a_strain_at_the_end() {
    let stretch = "'stretch': { 'strain': { 'over_critical_stretch': 0.8 } }";
    let changes = [
        (stretch, "'velocity': { 'speed': 1e-3 }"),
        ("'z': 0.9", "'dt': 1e-9"),
        ("'value': 1 ", "'value': 2 "),
    ];
    let strain =
        SceneRun::of(&with(&changes)).result()["resolved"]["final_strain"].as_f64().unwrap();
    // Both edges, 400 steps, over 16 mm.
    assert!((strain / (2.0 * 1e-3 * 400e-9 / 0.016) - 1.0).abs() < 1e-12, "{strain}");
}

#[test]
fn realisations_of_a_checkpoint_that_are_not_the_first_asked_for_are_refused_and_kept() {
    let of = |n: u64| {
        let n = format!("'realisations': {n}");
        with(&[("'steps': 400", "'steps': 10"), ("'realisations': 12", &n), ("[0, 11]", "[]")])
    };
    let ran = SceneRun::of(&of(6));
    ran.result();
    ran.shard("2/2", "shard").unwrap();
    let part = scenes::EnsemblePart::Shard("2/2".parse().unwrap());
    for (n, options, words) in [
        (4, ran.options("out"), "6 realisations from number 0 on; requested are 4"),
        (
            8,
            Options { part, ..ran.options("shard") },
            "3 realisations from number 3 on; requested are 4 from number 4 on",
        ),
    ] {
        ran.write(&of(n));
        let checkpoint = options.out.join("checkpoint-1.bin");
        let kept = std::fs::read(&checkpoint).unwrap();
        let refused = ran.again(&Options { start: Start::GoOn, ..options }).unwrap_err();
        let RunError::Solver(error) = refused else { panic!("{refused}") };
        assert!(error.to_string().contains(words), "{error}");
        assert_eq!(std::fs::read(&checkpoint).unwrap(), kept);
    }
}

/// The step exceeds every stable step, which only the built body shows.
#[test]
fn a_file_that_is_no_shard_is_refused_before_the_body_is_built() {
    no_shard_is_refused_first(&SceneRun::of(&with(&[("'z': 0.9", "'dt': 1")])));
}

#[test]
fn an_unknown_key_is_told_the_nearest() {
    let ran = SceneRun::of(&with(&[("'spacing'", "'spaceing'")]));
    assert_eq!(ran.mistake().help.as_deref(), Some("did you mean `spacing`?"));
}

#[test]
fn built_in_scenes_can_be_read_and_built() {
    use scenes::peridyn::points::Cloud;
    use scenes::peridyn::scene::CrackScene;
    use scenes::peridyn::scene_problem::CrackProblem;
    use scenes::scene::SceneFile;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes/peridyn");
    let mut n_scenes = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "json") {
            continue;
        }
        let file = SceneFile::read(&path).unwrap();
        if file.text_at_top("solver").unwrap() != "peridyn-sde" {
            continue;
        }
        let scene: CrackScene = file.parse().unwrap();
        let cloud = Cloud::of_body(&scene.body, file.folder()).unwrap();
        let nodes = CrackProblem::new(&scene, cloud).unwrap().resolved.nodes;
        let whole = scene.body.size.iter().map(|side| side / scene.body.spacing).product::<f64>();
        let holes = whole - nodes as f64;
        assert!(if scene.body.holes.is_empty() { holes < 0.5 } else { holes > 0.5 });
        n_scenes += 1;
    }
    assert!(n_scenes >= 4);
}
