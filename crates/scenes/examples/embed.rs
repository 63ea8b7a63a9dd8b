//! Solves a scene given as text and prints its answers, each with its error and how that is known.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

// docs: embed
const SCENE: &str = r#"{
  "solver": "fpk-sph", "title": "A building with a viscous damper",
  "system": { "viscous_damper": {
    "structure": { "natural_frequency": 3.14, "damping_ratio": 0.01, "noise_intensity": 0.2, "window": "stationary" },
    "damper_coefficient": 0.25, "damper_exponent": 0.35 } },
  "initial": { "gaussian": { "mean": [0, 0], "standard_deviation": [0.15, 0.1] } },
  "method": { "flow_map_fit": { "count": [25, 25], "reach": 5 } },
  "times": { "until": 2, "every": 1 }, "moments": [[2, 0]], "thresholds": [0.5]
}"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let answers = scenes::solve(&scenes::SceneFile::from_text("damper", SCENE.to_owned())?)?;
    for answer in answers.list {
        println!("{answer}: {}", answer.last.number.error_kind.words());
    }
    Ok(())
}
// docs: end
