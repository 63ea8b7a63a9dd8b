//! Writes the page of a run next to its results.

use std::path::{Path, PathBuf};

use result_pages::{Motion, Note, Page};
use serde_json::Value;

use crate::answers::Answers;
use crate::kind::RunError;
use crate::output::{OutputError, write_text};
use crate::report::Report;
use crate::result_file::{ResultFile, VERSION};
use crate::scene::SceneFile;
use crate::schema::scene_keys;

/// Name of the page.
pub(crate) const NAME: &str = "index.html";

/// What the page of a run is made of.
pub(crate) struct Content<'a> {
    pub(crate) solver: &'static str,
    /// Schema of the scenes of the solver.
    pub(crate) schema: &'a Value,
    pub(crate) answers: &'a Answers,
    /// Warnings and remarks, those on answers included.
    pub(crate) notes: Vec<Note>,
    pub(crate) report: Report,
    pub(crate) motions: Vec<Motion>,
    pub(crate) result: &'a ResultFile,
    /// Files of the run.
    pub(crate) written: &'a [PathBuf],
}

/// Writes `index.html` into a folder; returns its path.
///
/// # Errors
/// [`RunError::Output`] for a file that cannot be written; [`RunError::Page`] for content that a page cannot show.
pub(crate) fn write(
    file: &SceneFile,
    content: Content<'_>,
    folder: &Path,
) -> Result<PathBuf, RunError> {
    let Content { solver, schema, answers, notes, report, motions, result, written } = content;
    let mut keys =
        scene_keys(solver, schema, &result.scene, file.keys()).map_err(RunError::page)?;
    for key in &mut keys {
        key.unit = unit_words(&key.unit, &report.units);
    }
    let inside = |path: &PathBuf| path.strip_prefix(folder).unwrap_or(path).display().to_string();
    let page = Page {
        title: result.scene["title"].as_str().unwrap_or(solver).to_owned(),
        solver: solver.to_owned(),
        notes,
        answers: answers.headlines().map(crate::Answer::shown).collect(),
        motions,
        absent: report.absent,
        charts: report.charts,
        tables: report.tables,
        facts: report.facts,
        scene: keys,
        sources: report.sources,
        files: written.iter().map(inside).collect(),
        origin: origin(result),
    };
    let html = result_pages::render(&page).map_err(RunError::page)?;
    let path = folder.join(NAME);
    write_text(&path, &html).map_err(|source| OutputError::Io { path: path.clone(), source })?;
    Ok(path)
}

/// Version, commit and machine of a result, in a line.
fn origin(result: &ResultFile) -> String {
    let machine = &result.machine;
    let load = machine.load_average.map_or_else(|| "unknown".to_owned(), |load| load.to_string());
    format!(
        "scenes {VERSION}, commit {}; {}, {} of {} cores, load {load}, {} ({})",
        result.commit.as_deref().unwrap_or("unknown"),
        machine.cpu.as_deref().unwrap_or("unknown"),
        machine.threads,
        machine.cores,
        machine.os,
        machine.arch,
    )
}

/// A unit that names the key `units` of the scene, in these units: `cm/us` for `length/time of units`.
fn unit_words(unit: &str, units: &[(&str, &str)]) -> String {
    let of_scene = unit.strip_suffix(" of `units`").filter(|_| !units.is_empty());
    of_scene.map_or_else(
        || unit.to_owned(),
        |words| {
            units.iter().fold(words.to_owned(), |words, (kind, name)| words.replace(kind, name))
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_of_the_scene_is_written_out() {
        let units = [("length", "cm"), ("time", "us"), ("stress", "Mbar")];
        assert_eq!(unit_words("length/time^2 of `units`", &units), "cm/us^2");
        assert_eq!(unit_words("stress of `units`", &units), "Mbar");
        assert_eq!(unit_words("1/s", &units), "1/s");
        assert_eq!(unit_words("stress of `units`", &[]), "stress of `units`");
    }
}
