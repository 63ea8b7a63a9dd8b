//! A run of one scene of each solver, and the pictures of the README that come from runs.

use std::path::Path;
use std::process::ExitCode;

use crate::{RECORD, build_options, cargo, run_arguments, say, start, workspace};

/// A scene, the folder of its run, and the picture of it that pages show.
struct Run {
    scene: &'static str,
    folder: &'static str,
    picture: &'static str,
    recorded: &'static str,
}

const RUNS: [Run; 3] = [
    Run {
        scene: "tests/scenes/fpk/viscous_damper.json",
        folder: "fpk-sph",
        picture: "exceedance.svg",
        recorded: "fpk-exceedance.svg",
    },
    Run {
        scene: "tests/scenes/smpm/contact_explosion.json",
        folder: "smpm",
        picture: "flow_stress.svg",
        recorded: "smpm-flow-stress.svg",
    },
    Run {
        scene: "tests/scenes/peridyn/notched_plate_ensemble.json",
        folder: "peridyn-sde",
        picture: "paths.svg",
        recorded: "peridyn-paths.svg",
    },
];

/// Runs the scenes into `target/gallery`; with `--record` copies their pictures into `docs/pictures`.
pub(crate) fn run(rest: &[String]) -> ExitCode {
    let is_record = match rest {
        [] => false,
        [option] if option == RECORD => true,
        _ => {
            say("error: gallery takes no argument but --record\n");
            return ExitCode::from(crate::USAGE);
        }
    };
    for run in &RUNS {
        let ended = start(cargo().args(arguments(run)));
        if ended != ExitCode::SUCCESS {
            return ended;
        }
    }
    for run in &RUNS {
        let page = out(run).join("index.html");
        say(&format!("page: {}\n", page.display()));
        if is_record && let Err(error) = copy(&out(run).join(run.picture), run.recorded) {
            say(&format!("error: {error}\n"));
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn out(run: &Run) -> std::path::PathBuf {
    workspace().join("target/gallery").join(run.folder)
}

fn arguments(run: &Run) -> Vec<String> {
    let words = [
        "run".to_owned(),
        workspace().join(run.scene).display().to_string(),
        "--out".to_owned(),
        out(run).display().to_string(),
        "--overwrite".to_owned(),
    ];
    // All solvers are needed, so they are built once.
    run_arguments("scenes", &build_options(&["gallery".to_owned()]), &words)
}

fn copy(picture: &Path, recorded: &str) -> Result<(), String> {
    let to = workspace().join("docs/pictures").join(recorded);
    std::fs::copy(picture, &to)
        .map(drop)
        .map_err(|error| format!("cannot copy {} to {}: {error}", picture.display(), to.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_scenes_and_recorded_pictures_exist() {
        for run in &RUNS {
            assert!(workspace().join(run.scene).is_file(), "{}", run.scene);
            assert!(
                workspace().join("docs/pictures").join(run.recorded).is_file(),
                "{}",
                run.recorded
            );
        }
    }
}
