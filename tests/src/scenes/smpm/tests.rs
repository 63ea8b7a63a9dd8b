//! A small scene to its end, and its mistakes one by one.

use std::path::{Path, PathBuf};

use crate::checkpoint::Start;
use crate::scenes::{ALL, Options, Progress, RunError, run};

/// A plate of steel runs into a wall, in uniaxial strain.
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

fn run_text(name: &str, text: &str) -> (PathBuf, Result<Vec<PathBuf>, RunError>) {
    let folder = std::env::temp_dir().join(format!("smpm-scene-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let scene = folder.join("scene.json");
    std::fs::write(&scene, text).unwrap();
    let result = run(ALL, &scene, &Options::new(folder.join("out")), &Progress::silent());
    (folder, result)
}

#[test]
fn a_scene_runs_to_its_end_by_every_method() {
    let methods = [
        ("\"propagated\"", true),
        ("\"deterministic\"", false),
        ("{ \"frozen\": {} }", true),
        ("{ \"finite_difference\": { \"step\": 0.01 } }", true),
        ("\"sigma_points\"", true),
        ("{ \"monte_carlo\": { \"samples\": 20, \"seed\": 1, \"control\": true } }", true),
    ];
    for (number, (method, varies)) in methods.into_iter().enumerate() {
        let text = PLATE.replace("\"propagated\"", method);
        let (folder, written) = run_text(&format!("method-{number}"), &text);
        let written = written.unwrap();
        assert!(written.iter().all(|path| path.exists()), "{written:?}");
        let result = std::fs::read_to_string(&written[0]).unwrap();
        let result: serde_json::Value = serde_json::from_str(&result).unwrap();
        let pressure = &result["gauges"][0]["quantities"][0]["values"][2];
        // p = rho_0 (C + S_1 u) u within a per cent, and its deviation 5 % of rho_0 S_1 u^2; the frozen one twice that.
        let mean = pressure["mean"].as_f64().unwrap();
        assert!((mean / 0.474_420 - 1.0).abs() < 0.01, "{mean}");
        assert_eq!(pressure["standard_deviation"].is_number(), varies, "{method}");
        if varies {
            let deviation = pressure["standard_deviation"].as_f64().unwrap();
            let exact = 0.05 * 7.83 * 1.49 * 0.01;
            let frozen = if method.contains("frozen") { 2.08 } else { 1.0 };
            assert!((deviation / exact / frozen - 1.0).abs() < 0.1, "{method}: {deviation}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
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
    let gauges = |out: &Path| -> serde_json::Value {
        let text = std::fs::read_to_string(out.join("result.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["gauges"].take()
    };
    let checkpoints = |out: &Path| {
        ["checkpoint-0.bin", "checkpoint-1.bin"].map(|name| std::fs::read(out.join(name)).ok())
    };
    let (folder, written) = run_text("fewer", &of(20));
    written.unwrap();
    let out = folder.join("out");
    let (of_all, kept) = (gauges(&out), checkpoints(&out));
    let resume = |samples: u64| {
        std::fs::write(folder.join("scene.json"), of(samples)).unwrap();
        let options = Options { start: Start::GoOn, ..Options::new(&out) };
        run(ALL, &folder.join("scene.json"), &options, &Progress::silent()).unwrap();
        gauges(&out)
    };
    let (anew, written) = run_text("few", &of(8));
    written.unwrap();
    assert_eq!(resume(8), gauges(&anew.join("out")));
    assert_eq!(checkpoints(&out), kept);
    assert_eq!(resume(20), of_all);
    for folder in [folder, anew] {
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

#[test]
fn mistakes_are_shown_where_they_stand() {
    for (number, (right, wrong, path, words)) in [
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
    ]
    .into_iter()
    .enumerate()
    {
        assert!(PLATE.contains(right), "{right}");
        let (folder, result) = run_text(&format!("mistake-{number}"), &PLATE.replace(right, wrong));
        let RunError::Scene(error) = result.unwrap_err() else { panic!("{wrong}") };
        let mistake = error.mistake().unwrap();
        assert_eq!(mistake.path, path, "{}", mistake.message);
        assert!(mistake.message.contains(words), "{}", mistake.message);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

#[test]
fn the_defaults_that_the_schema_tells_are_those_of_the_solver() {
    use crate::scene::SceneFile;
    use crate::smpm::scene::{SchemeScene, SmpmScene};
    let read = |text: &str| -> SmpmScene {
        SceneFile::from_text("scene.json", text.to_owned()).unwrap().parse().unwrap()
    };
    let told = crate::schema::defaults::<SchemeScene>();
    assert!(!told.is_empty());
    let scene = read(PLATE);
    let with = |scheme| SmpmScene { scheme, ..scene.clone() }.config::<1>().unwrap();
    let usual = with(SchemeScene::default());
    assert_ne!(with(scene.scheme.clone()), usual);
    assert_eq!(with(serde_json::from_value(told.into()).unwrap()), usual);
}
