//! Kinds of scene.
//!
//! A kind is a type of scene with a `const KIND: SceneKind`, and one line in a table of kinds that a program passes. A
//! scene names its kind by the top-level key `solver`, which its type declares too.

mod blocks;
mod ensemble;
mod folder_lock;
mod inputs;
mod kind_run;
mod options;
mod pace;
mod part;
mod progress;
mod run_error;
mod shards;
mod solution;

use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use mpi_ensembles::Ranks;
use schemars::Schema;
use serde_json::Value;

pub use self::blocks::{BlockRecord, Cut, JobRecord};
pub use self::ensemble::{Computed, Ensemble, Items};
pub use self::inputs::Inputs;
use self::kind_run::Results;
pub use self::kind_run::Run;
pub use self::options::Options;
pub use self::pace::{Limit, Pace, TooLong};
pub use self::part::{EnsemblePart, Place};
pub use self::progress::Progress;
pub use self::run_error::{RunError, SolverError};
pub use self::solution::{Completed, Finished, Found, Output, Solution};
use crate::answers::Answers;
use crate::checkpoint::Checkpoint;
use crate::ladder::Ladder;
use crate::models::Ingredient;
pub use crate::scene::KIND_KEY;
use crate::scene::{Objection, SceneError, SceneFile};

/// A kind of scene: what a program needs to read, run, compare and describe its scenes.
#[derive(Debug, Clone, Copy)]
pub struct SceneKind {
    /// The value of the key `solver`, e.g. `fpk-sph`.
    pub solver: &'static str,
    /// The schema of its scenes, by `schemars::schema_for!`.
    pub schema: fn() -> Schema,
    /// Parses and checks a scene without running it.
    pub check: fn(&SceneFile) -> Result<(), SceneError>,
    /// Parses and solves a scene; what is found stays in memory, except for fields and shards.
    pub run: fn(&SceneFile, &Run<'_>) -> Result<Completed, RunError>,
    /// Methods that solve a scene, its own first.
    pub ladder: fn(&SceneFile) -> Result<Ladder, RunError>,
    /// Ingredients that can be left out of a scene.
    pub ingredients: fn(&serde_json::Map<String, Value>) -> Vec<Ingredient>,
}

impl SceneKind {
    /// Runs a scene of this kind and writes its results.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn run_file(
        &self,
        file: &SceneFile,
        options: &Options,
        progress: &Progress,
    ) -> Result<Finished, RunError> {
        self.run_file_on(file, options, progress, None)
    }

    fn run_file_on(
        &self,
        file: &SceneFile,
        options: &Options,
        progress: &Progress,
        ranks: Option<&dyn Ranks>,
    ) -> Result<Finished, RunError> {
        if ranks.is_some() && options.part != EnsemblePart::Whole {
            return Err(RunError::PartOnRanks);
        }
        let (solver, results) = (self.solver, Results::InFolder);
        let (checkpoint, lock) = (OnceLock::new(), OnceLock::new());
        let run = Run { progress, solver, options, results, checkpoint, lock, ranks };
        let schema = Value::from((self.schema)());
        let finished = (self.run)(file, &run)?.write(file, &run, &schema)?;
        // Where a file could not be written, the checkpoint stays, and `--resume` continues.
        let checkpoint = run.checkpoint.get().filter(|_| finished.unwritten.is_none());
        checkpoint.map_or(Ok(()), Checkpoint::end)?;
        Ok(finished)
    }

    /// Runs a scene of this kind in memory: no file is read, other than those that the scene names, and none is written.
    ///
    /// A part of the run that would take longer than `longest` is refused.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn solve(
        &self,
        file: &SceneFile,
        longest: Option<Duration>,
        progress: &Progress,
    ) -> Result<Answers, RunError> {
        let options = &Options { longest, ..Options::new("") };
        let (solver, results, ranks) = (self.solver, Results::InMemory, None);
        let (checkpoint, lock) = (OnceLock::new(), OnceLock::new());
        let run = Run { progress, solver, options, results, checkpoint, lock, ranks };
        match (self.run)(file, &run)? {
            Completed::Here(solution) => {
                let Solution { answers, stopped, .. } = *solution;
                stopped.map_or(Ok(answers), |error| Err(RunError::Solver(error)))
            }
            Completed::Elsewhere(_) => Err(RunError::NoShards),
        }
    }
}

/// Runs a scene file.
///
/// # Errors
/// [`RunError`].
pub fn run(
    table: &[SceneKind],
    scene: &Path,
    options: &Options,
    progress: &Progress,
) -> Result<Finished, RunError> {
    let file = SceneFile::read(scene)?;
    kind_of(table, &file)?.run_file(&file, options, progress)
}

/// Runs a scene file as one rank of a job; results are bitwise identical to those of [`run`].
///
/// The ranks share an ensemble block by block. All of them call it with the same arguments; rank 0 writes the results
/// and returns their paths.
///
/// # Errors
/// Those of [`run`]; [`RunError::Job`], after which the caller must abort the job; [`RunError::PartOnRanks`].
pub fn run_on_ranks(
    table: &[SceneKind],
    scene: &Path,
    options: &Options,
    progress: &Progress,
    ranks: &dyn Ranks,
) -> Result<Finished, RunError> {
    let file = SceneFile::read(scene)?;
    kind_of(table, &file)?.run_file_on(&file, options, progress, Some(ranks))
}

/// Parses and checks a scene without running it.
///
/// # Errors
/// [`RunError::Scene`], [`RunError::NoKinds`].
pub fn check(table: &[SceneKind], file: &SceneFile) -> Result<(), RunError> {
    Ok((kind_of(table, file)?.check)(file)?)
}

/// Looks up the kind of a scene.
///
/// # Errors
/// [`RunError::Scene`] for a solver that is not in the table.
pub fn kind_of<'a>(table: &'a [SceneKind], file: &SceneFile) -> Result<&'a SceneKind, RunError> {
    if table.is_empty() {
        return Err(RunError::NoKinds);
    }
    let solver = file.text_at_top(KIND_KEY)?;
    table.iter().find(|kind| kind.solver == solver).ok_or_else(|| {
        let known: Vec<&str> = table.iter().map(|kind| kind.solver).collect();
        let objection = Objection::new(KIND_KEY, format!("there is no solver `{solver}`"));
        let others = || {
            let known = known.join(", ");
            format!("this build has {known}; any other is a feature of the package `scenes`")
        };
        file.object_to(&objection.with_nearest(&solver, &known, others)).into()
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use result_pages::Note;
    use schemars::{JsonSchema, schema_for};
    use serde::Deserialize;

    use super::*;
    use crate::answers::{Answer, AnswerValue, Number, Role, Statistic};
    use crate::report::Report;
    use crate::result_file::ResultFile;
    use crate::scene::{Scene, WrongKey, read_keys};

    #[derive(Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    struct Decay {
        #[serde(rename = "solver")]
        _solver: String,
        rate: f64,
    }

    impl Scene for Decay {
        type Built = ();

        fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
            read_keys(keys)
        }

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
        check: |file| file.parse::<Decay>().map(drop),
        run: |file, run| {
            let (scene, ()) = run.build::<Decay>(file)?;
            if scene.rate > 10.0 {
                return Err(RunError::solver(std::io::Error::other("too stiff")));
            }
            let number = Number::sampled((-scene.rate).exp(), None);
            // A rate of 7 has a result without a number for one of its keys, one of 8 none that can be made.
            let recorded =
                if scene.rate.to_bits() == 7f64.to_bits() { f64::INFINITY } else { number.value };
            let last = AnswerValue::of(number);
            let answer = Answer::new("final".into(), "final".into(), Statistic::Mean, last);
            let answer = Answer { role: Role::Headline, ..answer };
            let answers = Answers { cpu_seconds: 0.0, list: vec![answer] };
            Ok(Completed::here(run, answers, || {
                if scene.rate.to_bits() == 8f64.to_bits() {
                    return Err(RunError::solver(std::io::Error::other("no result")));
                }
                let content = BTreeMap::from([("value", recorded)]);
                let result = ResultFile::new("decay/1", &file.keys(), &content)?;
                let (files, drawings, motions) = (Vec::new(), Vec::new(), Vec::new());
                Ok(Output { result, files, drawings, motions, report: Report::default() })
            }))
        },
        ladder: |_| Err(RunError::NoKinds),
        ingredients: |_| Vec::new(),
    }];

    fn run_text(text: &str) -> Result<Finished, RunError> {
        use std::sync::atomic::{AtomicUsize, Ordering};
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let next = NEXT.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("scene-run-{}-{next}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let scene = folder.join("scene.json");
        std::fs::write(&scene, text).unwrap();
        let result = run(&TABLE, &scene, &Options::new(folder.join("out")), &Progress::silent());
        if let Ok(finished) = &result {
            assert!(finished.files.iter().all(|path| path.exists()));
        }
        std::fs::remove_dir_all(&folder).unwrap();
        result
    }

    #[test]
    fn a_scene_is_run_by_its_kind() {
        let text = "{\"solver\": \"decay\", \"rate\": 1}";
        let Finished { files, found, .. } = run_text(text).unwrap();
        let names: Vec<_> = files.iter().filter_map(|path| path.file_name()).collect();
        assert_eq!(names, ["result.json", "index.html"]);
        let Found { answers, notes } = found.unwrap();
        assert_eq!(notes.len(), 1);
        // The answers without a folder are the same.
        let file = SceneFile::from_text("decay", text.to_owned()).unwrap();
        assert_eq!(TABLE[0].solve(&file, None, &Progress::silent()).unwrap(), answers);
        assert!((answers.list[0].last.number.value - (-1f64).exp()).abs() < 1e-15);
    }

    #[test]
    fn an_answer_outlives_a_number_that_is_not_finite_and_a_result_that_fails() {
        let Finished { files, found, unwritten, null } =
            run_text("{\"solver\": \"decay\", \"rate\": 7}").unwrap();
        assert!(files.len() == 2 && unwritten.is_none());
        assert_eq!(null.unwrap(), "`value` is inf, not a finite number");
        let warned =
            |note: &Note| matches!(note, Note::Warning(text) if text.contains("`value` is inf"));
        assert!(found.unwrap().notes.iter().any(warned));
        let Finished { files, found, unwritten, .. } =
            run_text("{\"solver\": \"decay\", \"rate\": 8}").unwrap();
        assert!(files.is_empty() && matches!(unwritten, Some(RunError::Solver(_))));
        assert!((found.unwrap().answers.list[0].last.number.value - (-8f64).exp()).abs() < 1e-15);
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
            run(&[], Path::new("x"), &Options::new("y"), &Progress::silent()),
            Err(RunError::Scene(_))
        ));
    }
}
