//! Which solver a scene needs, so that a first run compiles no other.

use std::path::Path;

/// The solvers that a scene may name, and the feature of `scenes` that has each.
const FEATURES: [(&str, &str); 5] = [
    ("fpk-sph", "fpk"),
    ("random-vibration", "fpk"),
    ("smpm", "smpm"),
    ("peridyn-sde", "peridyn"),
    ("peridyn-sde-inference", "peridyn"),
];

/// Options for cargo that leave out all solvers but that of the scene among these arguments of `run`, `advise` or `merge`.
///
/// None where no argument is a file that names a known solver: then all are built, and the command itself says what is wrong.
pub(crate) fn features(arguments: &[String]) -> Vec<String> {
    let solver = arguments
        .iter()
        .filter(|argument| Path::new(argument).extension().is_some_and(|it| it == "json"))
        .find_map(|path| solver_of(&std::fs::read_to_string(path).ok()?).map(str::to_owned));
    let feature = FEATURES.iter().find(|(name, _)| solver.as_deref() == Some(*name));
    feature.map_or_else(Vec::new, |(_, feature)| {
        vec!["--no-default-features".to_owned(), format!("--features=cli,{feature}")]
    })
}

/// The value of the key `solver` in the text of a scene, which may have comments.
fn solver_of(text: &str) -> Option<&str> {
    let (_, rest) = text.split_once("\"solver\"")?;
    let value = rest.trim_start().strip_prefix(':')?.trim_start().strip_prefix('"')?;
    value.split_once('"').map(|(solver, _)| solver)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace;

    fn features_of(scene: &str) -> Vec<String> {
        let path = workspace().join("tests/scenes").join(scene).to_string_lossy().into_owned();
        features(&["--out".to_owned(), "out".to_owned(), path])
    }

    #[test]
    fn a_scene_needs_the_solver_that_it_names() {
        for (scene, feature) in [
            ("fpk/viscous_damper.json", "fpk"),
            ("fpk/two_storey.json", "fpk"),
            ("smpm/contact_explosion.json", "smpm"),
            ("peridyn/plate_with_hole.json", "peridyn"),
            ("peridyn/infer_toughness.json", "peridyn"),
        ] {
            let expected =
                ["--no-default-features".to_owned(), format!("--features=cli,{feature}")];
            assert_eq!(features_of(scene), expected, "{scene}");
        }
    }

    #[test]
    fn all_solvers_are_built_where_the_scene_does_not_say() {
        assert!(features_of("fpk/there_is_no_such_scene.json").is_empty());
        assert_eq!(solver_of("// a comment\n{ \"solver\" : \"smpm\" }"), Some("smpm"));
        assert_eq!(solver_of("{ \"solver\": 3 }"), None);
    }

    #[test]
    fn the_features_are_those_of_scenes() {
        let manifest = workspace().join("crates/scenes/Cargo.toml");
        let manifest = std::fs::read_to_string(manifest).expect("the manifest of scenes");
        for (_, feature) in FEATURES {
            assert!(manifest.contains(&format!("\n{feature} = [")), "{feature}");
        }
    }
}
