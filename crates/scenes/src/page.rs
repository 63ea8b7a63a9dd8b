//! Writes the page of a run next to its results.
#![cfg_attr(
    not(all(feature = "fpk", feature = "smpm", feature = "peridyn")),
    allow(dead_code, reason = "each solver uses it")
)]

use std::path::{Path, PathBuf};

use result_pages::{Motion, Page};
use serde_json::Value;

use crate::kind::{PageFile, Run, RunError, SceneKind};
use crate::output::{OutputError, write_text};
use crate::scene::SceneFile;
use crate::schema::scene_keys;

/// Name of the page.
pub(crate) const NAME: &str = "index.html";

/// Writes `index.html` from the `result.json` of a run, with its moving fields; returns its path, unless no page is wanted.
///
/// # Errors
/// [`RunError::Output`] for files that cannot be read or written; [`RunError::Page`] for content that a page cannot show.
pub(crate) fn write(
    kind: &SceneKind,
    file: &SceneFile,
    run: &Run<'_>,
    motions: Vec<Motion>,
    written: &[PathBuf],
) -> Result<Option<PathBuf>, RunError> {
    if run.page() == PageFile::Omit {
        return Ok(None);
    }
    let result = read(&run.out().join("result.json"))?;
    let page = page(kind, file, &result, motions, (run.out(), written))?;
    let html = result_pages::render(&page).map_err(RunError::page)?;
    let path = run.out().join(NAME);
    write_text(&path, &html).map_err(|source| OutputError::Io { path: path.clone(), source })?;
    Ok(Some(path))
}

fn read(path: &Path) -> Result<Value, RunError> {
    let refused = |source| OutputError::Io { path: path.to_owned(), source };
    let text = std::fs::read_to_string(path).map_err(refused)?;
    serde_json::from_str(&text).map_err(RunError::page)
}

fn page(
    kind: &SceneKind,
    file: &SceneFile,
    result: &Value,
    motions: Vec<Motion>,
    (out, written): (&Path, &[PathBuf]),
) -> Result<Page, RunError> {
    let found = (kind.findings)(result).map_err(RunError::page)?;
    let scene = &result["scene"];
    let mut keys = scene_keys(kind, scene, file.keys()).map_err(RunError::page)?;
    for key in &mut keys {
        key.unit = unit_words(&key.unit, scene);
    }
    let relative = |path: &PathBuf| path.strip_prefix(out).unwrap_or(path).display().to_string();
    Ok(Page {
        title: scene["title"].as_str().unwrap_or(kind.solver).to_owned(),
        solver: kind.solver.to_owned(),
        notes: found.notes,
        answers: found.answers,
        n_more: found.n_more,
        motions,
        absent: found.absent,
        charts: found.charts,
        tables: found.tables,
        facts: found.facts,
        scene: keys,
        sources: found.sources,
        files: written.iter().map(relative).collect(),
        origin: origin(result),
    })
}

/// Version, commit and machine of a result, in a line.
fn origin(result: &Value) -> String {
    let word = |pointer: &str| match result.pointer(pointer) {
        Some(Value::String(text)) => text.clone(),
        Some(Value::Null) | None => "unknown".to_owned(),
        Some(other) => other.to_string(),
    };
    format!(
        "scenes {}, commit {}; {}, {} of {} cores, load {}, {} ({})",
        word("/version"),
        word("/commit"),
        word("/machine/cpu"),
        word("/machine/threads"),
        word("/machine/cores"),
        word("/machine/load_average"),
        word("/machine/os"),
        word("/machine/arch"),
    )
}

/// A unit that names the key `units` of the scene, in these units: `cm/us` for `length/time of units`.
fn unit_words(unit: &str, scene: &Value) -> String {
    #[cfg(feature = "smpm")]
    if let Some(words) = unit.strip_suffix(" of `units`") {
        use serde::Deserialize;

        use crate::smpm::scene::UnitsScene;

        if let Ok(units) = UnitsScene::deserialize(&scene["units"]) {
            let kinds = ["length", "time", "stress", "density", "velocity"];
            let names = kinds.into_iter().zip(units.names());
            return names.fold(words.to_owned(), |words, (kind, name)| words.replace(kind, name));
        }
    }
    let _ = scene;
    unit.to_owned()
}

#[cfg(all(test, feature = "smpm"))]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_unit_of_the_scene_is_written_out() {
        let scene = json!({ "units": "cm_g_us" });
        assert_eq!(unit_words("length/time^2 of `units`", &scene), "cm/us^2");
        assert_eq!(unit_words("stress of `units`", &scene), "Mbar");
        assert_eq!(unit_words("1/s", &scene), "1/s");
    }
}
