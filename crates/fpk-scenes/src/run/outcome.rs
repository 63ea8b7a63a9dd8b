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
    ) -> Result<Completed, RunError> {
        let Self { content, stopped, planes, files } = self;
        for Unknown { what, reason } in &content.unknown {
            run.progress.stage(&format!("unknown: {what}: {reason}"));
        }
        let answers = answers::answers(&content.quantities, &content.work);
        let solved = Completed::here(run, answers, || {
            // A picture that cannot be drawn is no reason to lose an answer.
            let (mut drawings, mut absent) = (Vec::new(), Vec::new());
            let planes_drawn = planes.iter().map(PlaneAt::drawing);
            let drawn = charts(&content.quantities).map(|charts| charts.into_iter().map(Ok));
            match drawn {
                Ok(charts) => {
                    for drawing in charts.chain(planes_drawn) {
                        match drawing {
                            Ok(drawing) => drawings.push(drawing),
                            Err(error) => absent.push(format!("A picture is missing: {error}.")),
                        }
                    }
                }
                Err(error) => absent.push(format!("The charts are missing: {error}.")),
            }
            let motions = motion::motions(&planes);
            let mut report = findings::report(&content, shown.method, shown.sources);
            report.absent.extend(shown.absent.map(str::to_owned));
            report.absent.extend(absent);
            let result = ResultFile::new("run-result/1", shown.scene, &content)?;
            Ok(Output { result, files, drawings, motions, report })
        })?;
        Ok(solved.stopped(stopped))
    }
}
