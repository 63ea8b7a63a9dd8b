//! The kinds of scene that can be run.
//!
//! A kind is one file here, with its scene types, and one line in [`ALL`].
//! A scene names its kind by the key `solver` at the top, which its type declares too.

mod fpk;
mod peridyn;
mod smpm;

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use schemars::Schema;

use crate::case::{CaseError, Context, Profile, Shared};
use crate::nearest::nearest;
use crate::output::OutputError;
use crate::scene::{Objection, SceneError, SceneFile};

/// The key that names the kind of a scene.
pub const KIND_KEY: &str = "solver";

/// Every kind of scene.
pub const ALL: &[SceneKind] = &[fpk::KIND, smpm::KIND, peridyn::KIND];

/// One entry of the table [`ALL`].
#[derive(Debug, Clone, Copy)]
pub struct SceneKind {
    /// The value of the key `solver`, e.g. `fpk-sph`.
    pub solver: &'static str,
    /// The schema of its scenes, by `schemars::schema_for!`.
    pub schema: fn() -> Schema,
    /// Reads the scene as its type, runs it, writes into the folder and returns what it wrote.
    pub run: fn(&SceneFile, &Path, &Context<'_>) -> Result<Vec<PathBuf>, RunError>,
}

/// Why a scene was not run to its end.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum RunError {
    /// The scene is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// There is no kind of scene yet.
    #[error("no kind of scene can be run yet")]
    NoKinds,
    /// The solver refused or stopped.
    #[error("the run ended in an error")]
    Solver(#[source] CaseError),
    /// A result could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl RunError {
    /// Takes any error of a solver: `simulation.step().map_err(RunError::solver)?`.
    pub fn solver(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Solver(Box::new(error))
    }
}

/// Runs a scene file; `tell` hears in a few words what is being done.
///
/// # Errors
/// [`RunError`].
pub fn run(
    table: &[SceneKind],
    scene: &Path,
    out: &Path,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Vec<PathBuf>, RunError> {
    let file = SceneFile::read(scene)?;
    let kind = kind_of(table, &file)?;
    let (shared, inline) = (Shared::default(), Mutex::new(Vec::new()));
    (kind.run)(&file, out, &Context::new(kind.solver, Profile::Default, &shared, &inline, tell))
}

fn kind_of<'a>(table: &'a [SceneKind], file: &SceneFile) -> Result<&'a SceneKind, RunError> {
    if table.is_empty() {
        return Err(RunError::NoKinds);
    }
    let solver = file.text_at_top(KIND_KEY)?;
    table.iter().find(|kind| kind.solver == solver).ok_or_else(|| {
        let known: Vec<&str> = table.iter().map(|kind| kind.solver).collect();
        let hint = match nearest(&solver, known.iter().copied()) {
            Some(nearest) => format!("did you mean `{nearest}`?"),
            None => format!("there are: {}", known.join(", ")),
        };
        file.object_to(
            &Objection::new(KIND_KEY, format!("there is no solver `{solver}`")).with_help(hint),
        )
        .into()
    })
}

#[cfg(test)]
mod tests {
    use schemars::{JsonSchema, schema_for};
    use serde::Deserialize;

    use super::*;
    use crate::scene::Scene;

    #[derive(Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    struct Decay {
        #[serde(rename = "solver")]
        _solver: String,
        rate: f64,
    }

    impl Scene for Decay {
        fn check(&self) -> Result<(), Objection> {
            if self.rate < 0.0 {
                Err(Objection::new("rate", "a rate must not be negative"))
            } else {
                Ok(())
            }
        }
    }

    const TABLE: [SceneKind; 1] = [SceneKind {
        solver: "decay",
        schema: || schema_for!(Decay),
        run: |file, out, _| {
            let scene: Decay = file.parse()?;
            if scene.rate > 10.0 {
                return Err(RunError::solver(std::io::Error::other("too stiff")));
            }
            let path = out.join("result.json");
            crate::output::write_json(&path, &serde_json::json!({ "final": (-scene.rate).exp() }))?;
            Ok(vec![path])
        },
    }];

    fn run_text(text: &str) -> Result<Vec<PathBuf>, RunError> {
        use std::sync::atomic::{AtomicUsize, Ordering};
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let next = NEXT.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("scene-run-{}-{next}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let scene = folder.join("scene.json");
        std::fs::write(&scene, text).unwrap();
        let result = run(&TABLE, &scene, &folder.join("out"), &|_| {});
        if let Ok(paths) = &result {
            assert!(paths.iter().all(|path| path.exists()));
        }
        std::fs::remove_dir_all(&folder).unwrap();
        result
    }

    #[test]
    fn a_scene_is_run_by_its_kind() {
        assert_eq!(run_text("{\"solver\": \"decay\", \"rate\": 1}").unwrap().len(), 1);
    }

    #[test]
    fn an_unknown_kind_names_the_nearest_and_mistakes_reach_the_user() {
        let error = run_text("{\"solver\": \"decey\", \"rate\": 1}").unwrap_err();
        let RunError::Scene(error) = error else { panic!("{error}") };
        let mistake = error.mistake().unwrap();
        assert_eq!((mistake.line, mistake.column), (1, 12));
        assert_eq!(mistake.help.as_deref(), Some("did you mean `decay`?"));
        assert!(matches!(
            run_text("{\"solver\": \"decay\", \"rate\": -1}"),
            Err(RunError::Scene(_))
        ));
        assert!(matches!(
            run_text("{\"solver\": \"decay\", \"rate\": 99}"),
            Err(RunError::Solver(_))
        ));
        assert!(matches!(
            run(&[], Path::new("x"), Path::new("y"), &|_| {}),
            Err(RunError::Scene(_))
        ));
    }
}
