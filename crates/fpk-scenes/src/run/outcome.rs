//! Results of a scene by a method, and what is shown and written of them.

use std::path::PathBuf;

use result_figures::Drawing;
use result_pages::Source;
use scene_runs::answers::Unknown;
use scene_runs::kind::{Completed, Output, Run, RunError};
use scene_runs::result_file::ResultFile;
use serde::Serialize;

use super::pictures::PlaneAt;
use super::record::{Content, Series};
use super::{answers, findings, motion};

/// Results of a scene by a method.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) content: Content,
    /// The error that ended the run before its last time.
    pub(crate) stopped: Option<fpk_sph::Error>,
    /// Marginal densities over planes of two states.
    pub(crate) planes: Vec<PlaneAt>,
    /// Files already written.
    pub(crate) files: Vec<PathBuf>,
}

impl From<Content> for Outcome {
    fn from(content: Content) -> Self {
        Self { content, ..Self::default() }
    }
}

/// What a kind of scene adds to the results.
pub(crate) struct Presentation<'a, S, M> {
    pub(crate) scene: &'a S,
    pub(crate) method: &'a M,
    pub(crate) sources: &'a [Source],
    /// Why the page shows no field over time, where it shows none.
    pub(crate) absent: Option<&'static str>,
}

impl Outcome {
    /// The answers, and with a folder `result.json`, the page and pictures, of which `charts` are drawn over time.
    pub(crate) fn completed<S: Serialize, M: Serialize>(
        self,
        run: &Run<'_>,
        shown: &Presentation<'_, S, M>,
        charts: impl FnOnce(&[Series]) -> Result<Vec<Drawing>, RunError>,
    ) -> Completed {
        let Self { content, stopped, planes, files } = self;
        for Unknown { what, reason } in &content.unknown {
            run.progress.stage(&format!("unknown: {what}: {reason}"));
        }
        let answers = answers::answers(&content.quantities, &content.work);
        let solved = Completed::here(run, answers, || {
            let motions = motion::motions(&planes);
            let mut report = findings::report(&content, shown.method, shown.sources);
            report.absent.extend(shown.absent.map(str::to_owned));
            let mut drawings = report.drawn("charts", charts(&content.quantities));
            for plane in &planes {
                let drawn = plane.drawing().map(|drawing| vec![drawing]);
                drawings.extend(report.drawn("pictures of densities", drawn));
            }
            let result = ResultFile::new("run-result/1", shown.scene, &content)?;
            Ok(Output { result, files, drawings, motions, report })
        });
        solved.stopped(stopped)
    }
}
