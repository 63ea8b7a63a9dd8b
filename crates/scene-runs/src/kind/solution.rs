//! What a run finds, in memory, and what is left of it once it is written.

use std::path::PathBuf;

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
    /// What is written into the folder of the results; none of a run without one.
    pub output: Option<Output>,
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

/// A run that has written its results.
#[derive(Debug)]
pub struct Finished {
    /// Files written, `result.json` first.
    pub files: Vec<PathBuf>,
    /// What the run found; none of a shard, and on a rank without the results.
    pub found: Option<Found>,
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
    /// A solution on this process, of which `output` makes what is written, if the run has a folder.
    ///
    /// # Errors
    /// Those of `output`.
    pub fn here(
        run: &Run<'_>,
        answers: Answers,
        output: impl FnOnce() -> Result<Output, RunError>,
    ) -> Result<Self, RunError> {
        let output = run.folder().map(|_| output()).transpose()?;
        Ok(Self::Here(Box::new(Solution { answers, stopped: None, output })))
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
            Self::Elsewhere(files) => return Ok(Finished { files, found: None }),
        };
        let (mut files, mut notes) = (Vec::new(), answers.notes());
        if let (Some(folder), Some(output)) = (run.folder(), output) {
            let Output { result, files: written, drawings, motions, report } = output;
            let path = folder.join(result_file::NAME);
            let refused = |source| OutputError::Io { path: path.clone(), source };
            write_text(&path, &result.text).map_err(refused)?;
            files.push(path);
            files.extend(written);
            for drawing in drawings {
                files.push(write_drawing(&drawing, folder).map_err(RunError::solver)?);
            }
            notes.splice(0..0, report.notes.iter().cloned());
            let content = page::Content {
                solver: run.solver,
                schema,
                answers: &answers,
                notes: notes.clone(),
                report,
                motions,
                result: &result,
                written: &files,
            };
            let page = page::write(file, content, folder)?;
            files.push(page);
        }
        // The results so far are written; the early end is the outcome of the run.
        stopped.map_or(Ok(Finished { files, found: Some(Found { answers, notes }) }), |error| {
            Err(RunError::Solver(error))
        })
    }
}
