//! What a run finds, in memory, and what is left of it once it is written.

use std::path::{Path, PathBuf};

use result_figures::Drawing;
use result_pages::{Motion, Note};
use serde_json::Value;

use super::ensemble::Computed;
use super::kind_run::Run;
use super::run_error::{RunError, SolverError};
use crate::answers::Answers;
use crate::output::{OutputError, write_drawing, write_text};
use crate::page;
use crate::report::Report;
use crate::result_file::{self, ResultFile};
use crate::scene::SceneFile;

/// Outcome of a run on this process: the solution of its scene, unless it is elsewhere.
pub type Completed = Computed<Box<Solution>>;

/// The solution of a scene, before anything of it is written.
#[derive(Debug)]
pub struct Solution {
    /// What the scene asks for.
    pub answers: Answers,
    /// Why the run ended before its last time.
    pub stopped: Option<SolverError>,
    /// What is written into the folder of the results, or why it could not be made; none of a run without a folder.
    pub output: Option<Result<Output, RunError>>,
}

/// What a run writes into its folder.
#[derive(Debug)]
pub struct Output {
    /// `result.json`.
    pub result: ResultFile,
    /// Files that the run has written already, such as fields over time.
    pub files: Vec<PathBuf>,
    /// Pictures.
    pub drawings: Vec<Drawing>,
    /// Fields of the page over time or over realisations.
    pub motions: Vec<Motion>,
    /// What else the page shows.
    pub report: Report,
}

/// A run at its end.
#[derive(Debug, Default)]
pub struct Finished {
    /// Files written, `result.json` first.
    pub files: Vec<PathBuf>,
    /// What the run found; none of a shard, and on a rank without the results.
    pub found: Option<Found>,
    /// Why a file could not be written. What was found is to be shown all the same.
    pub unwritten: Option<RunError>,
    /// The first number that is not finite, in words: `null` in `result.json`.
    pub null: Option<String>,
}

/// What a run found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// What the scene asks for.
    pub answers: Answers,
    /// Warnings and remarks.
    pub notes: Vec<Note>,
}

impl Completed {
    /// A solution on this process, of which `output` makes what is written, if the run has a folder. Answers outlive its errors.
    #[must_use]
    pub fn here(
        run: &Run<'_>,
        answers: Answers,
        output: impl FnOnce() -> Result<Output, RunError>,
    ) -> Self {
        let output = run.folder().map(|_| output());
        Self::Here(Box::new(Solution { answers, stopped: None, output }))
    }

    /// A solution of a run that ended before its last time for a reason, if there is one.
    #[must_use]
    pub fn stopped(mut self, reason: Option<impl Into<SolverError>>) -> Self {
        if let Self::Here(solution) = &mut self {
            solution.stopped = reason.map(Into::into);
        }
        self
    }

    /// Writes `result.json`, pictures and page.
    pub(super) fn write(
        self,
        file: &SceneFile,
        run: &Run<'_>,
        schema: &Value,
    ) -> Result<Finished, RunError> {
        let Solution { answers, stopped, output } = match self {
            Self::Here(solution) => *solution,
            Self::Elsewhere(files) => return Ok(Finished { files, ..Finished::default() }),
        };
        let notes = answers.notes();
        let (mut found, mut finished) = (Found { answers, notes }, Finished::default());
        if let (Some(folder), Some(output)) = (run.folder(), output) {
            let to = Destination { file, solver: run.solver, schema, folder };
            let written = output.and_then(|output| output.write(&mut found, &mut finished, &to));
            finished.unwritten = written.err();
        }
        finished.found = Some(found);
        // The results so far are written; the early end is the outcome of the run.
        stopped.map_or(Ok(finished), |error| Err(RunError::Solver(error)))
    }
}

/// Where the results of a scene are written.
struct Destination<'a> {
    file: &'a SceneFile,
    solver: &'static str,
    schema: &'a Value,
    folder: &'a Path,
}

impl Output {
    /// Writes `result.json`, pictures and page, and adds the notes of the page to what was found.
    fn write(
        self,
        found: &mut Found,
        finished: &mut Finished,
        to: &Destination<'_>,
    ) -> Result<(), RunError> {
        let Self { result, files, drawings, motions, report } = self;
        let null =
            |number: &String| Note::Warning(format!("null in `{}`: {number}", result_file::NAME));
        found.notes.splice(0..0, report.notes.iter().cloned());
        found.notes.extend(result.not_finite.as_ref().map(null));
        finished.null.clone_from(&result.not_finite);
        let written = &mut finished.files;
        let path = to.folder.join(result_file::NAME);
        let refused = |source| OutputError::Io { path: path.clone(), source };
        write_text(&path, &result.text).map_err(refused)?;
        written.push(path);
        written.extend(files);
        for drawing in drawings {
            written.push(write_drawing(&drawing, to.folder).map_err(RunError::solver)?);
        }
        let content = page::Content {
            solver: to.solver,
            schema: to.schema,
            answers: &found.answers,
            notes: found.notes.clone(),
            report,
            motions,
            result: &result,
            written,
        };
        let page = page::write(to.file, content, to.folder)?;
        written.push(page);
        Ok(())
    }
}
