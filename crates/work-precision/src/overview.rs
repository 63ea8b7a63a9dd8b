//! The page of all recorded pictures, by solver, with the table of the cheapest method under each.

use std::io;
use std::path::{Path, PathBuf};

use result_figures::markdown::text;
use result_figures::{Choice, Reading, Words, choices_table};
use serde::Deserialize;

/// Name of the page in the folder of the pictures.
pub(crate) const PAGE: &str = "README.md";

/// First word of a picture's name, and its solver.
const SOLVERS: [(&str, &str); 6] = [
    ("fpk", "fpk-sph"),
    ("smpm", "smpm"),
    ("peridyn", "peridyn-sde"),
    ("sde", "sde-integrators"),
    ("kernels", "smoothing-kernels"),
    ("mpi", "mpi-ensembles"),
];

const HEAD: &str = "# Charts\n\nWritten by `cargo xtask chart --record` and `cargo xtask stability --record`, which also write the \
pictures and, for each, its data as JSON. The caption of a picture states machine, load and commit. Losses are included.\n\n\
Below a chart of error against cost is the cheapest method for a tolerance. For each method it is the cheapest run from which all \
more expensive runs are within the tolerance, standard errors included, so an error that happens to cross zero does not count. \
A runner-up whose cost differs by less than the scatter is equally good.\n";

/// A recorded file cannot be read, or its data have no title.
#[derive(Debug, thiserror::Error)]
#[error("{} does not say what its picture shows", .path.display())]
pub(crate) struct OverviewError {
    /// The file.
    pub(crate) path: PathBuf,
    /// Error of the file system, or position in the JSON.
    pub(crate) source: io::Error,
}

/// Title and labels in the data of a picture.
#[derive(Debug, Deserialize)]
struct Numbers {
    words: Words,
    #[serde(default)]
    reading: Option<Reading>,
    #[serde(default)]
    cheapest: Vec<Choice>,
}

/// The page of the pictures in `folder`.
pub(crate) fn overview(folder: &Path) -> Result<String, OverviewError> {
    let files = files(folder)?;
    let mut solvers: Vec<&str> = Vec::new();
    // In the order of the table, then the others.
    let known = SOLVERS.iter().map(|(_, solver)| *solver);
    let present = |solver: &str| files.iter().any(|file| solver_of(file) == solver);
    solvers.extend(known.filter(|solver| present(solver)));
    for solver in files.iter().map(|file| solver_of(file)) {
        if !solvers.contains(&solver) {
            solvers.push(solver);
        }
    }
    let links: Vec<String> =
        solvers.iter().map(|solver| format!("[{solver}](#{solver})")).collect();
    let mut parts = vec![format!("{HEAD}\n{}\n", links.join(", "))];
    for solver in solvers {
        parts.push(format!("\n## {solver}\n"));
        for file in files.iter().filter(|file| solver_of(file) == solver) {
            parts.push(entry(folder, file)?);
        }
    }
    Ok(parts.concat())
}

/// The pictures and pages in `folder` by name, pages first.
fn files(folder: &Path) -> Result<Vec<String>, OverviewError> {
    let refused = |source| OverviewError { path: folder.into(), source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(refused)? {
        let name = entry.map_err(refused)?.file_name().to_string_lossy().into_owned();
        if name != PAGE && (is_page(&name) || has_ending(&name, "svg")) {
            files.push(name);
        }
    }
    files.sort_by_key(|name| (!is_page(name), name.clone()));
    Ok(files)
}

fn is_page(file: &str) -> bool {
    has_ending(file, "md")
}

fn has_ending(file: &str, ending: &str) -> bool {
    Path::new(file).extension().is_some_and(|found| found == ending)
}

fn solver_of(file: &str) -> &str {
    let name = file.rsplit_once('.').map_or(file, |(name, _)| name);
    let word = name.split('-').next().unwrap_or(name);
    SOLVERS.iter().find(|(first, _)| *first == word).map_or(word, |(_, solver)| solver)
}

fn entry(folder: &Path, file: &str) -> Result<String, OverviewError> {
    let read = |path: &Path| {
        let refused = |source| OverviewError { path: path.into(), source };
        std::fs::read_to_string(path).map_err(refused)
    };
    if is_page(file) {
        let content = read(&folder.join(file))?;
        let title = content.lines().next().unwrap_or(file).trim_start_matches("# ");
        return Ok(format!("\n[{title}]({file})\n"));
    }
    let path = folder.join(file).with_extension("json");
    let numbers: Numbers = serde_json::from_str(&read(&path)?)
        .map_err(|source| OverviewError { path: path.clone(), source: source.into() })?;
    let (title, subtitle) = (text(&numbers.words.title), text(&numbers.words.subtitle));
    let beside = Path::new(file).with_extension("json");
    let table = numbers.reading.map_or_else(String::new, |reading| {
        let table = choices_table(&numbers.cheapest, &reading);
        if table.is_empty() { table } else { format!("\n{table}") }
    });
    Ok(format!(
        "\n### {title}\n\n{subtitle}; [numbers]({})\n\n![{title}]({file})\n{table}",
        beside.display()
    ))
}

#[cfg(test)]
mod tests {
    use result_figures::{Drawing, Scale, samples};

    use super::*;

    fn folder(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("overview-{name}-{}", std::process::id()))
    }

    #[test]
    fn every_picture_stands_under_its_solver_with_its_table() {
        let folder = folder("page");
        let cost = Drawing::work_precision("fpk-cost", &samples::work_precision()).unwrap();
        let time = Drawing::time_series("sde-moments", &samples::time_series(Scale::Log)).unwrap();
        let page = Drawing::page("fpk-all", "# All methods\n".into(), &1).unwrap();
        for drawing in [&time, &cost, &page] {
            scenes::output::write_drawing(drawing, &folder).unwrap();
        }
        let page = overview(&folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text} in\n{page}"));
        let places = [
            at("\n## fpk-sph\n"),
            at("[All methods](fpk-all.md)"),
            at("### Error against cost"),
            at("[numbers](fpk-cost.json)"),
            at("![Error against cost](fpk-cost.svg)"),
            at(&cost.table),
            at("\n## sde-integrators\n"),
            at("![Second moments](sde-moments.svg)"),
        ];
        assert!(places.is_sorted(), "{page}");
        assert_eq!(page.matches("| error within |").count(), 1);
    }

    #[test]
    fn the_page_of_what_is_recorded_can_be_made() {
        let page = overview(&reference_problems::record::workspace().join("docs/charts")).unwrap();
        for (_, solver) in SOLVERS {
            assert!(page.contains(&format!("\n## {solver}\n")), "{solver}");
        }
        if let Some(folder) = std::env::var_os("SAMPLE_FOLDER") {
            std::fs::write(Path::new(&folder).join(PAGE), page).unwrap();
        }
    }

    #[test]
    fn a_picture_whose_numbers_say_nothing_is_named() {
        let folder = folder("mute");
        scenes::output::write_text(&folder.join("fpk-a.svg"), "<svg/>").unwrap();
        let missing = overview(&folder).unwrap_err();
        scenes::output::write_text(&folder.join("fpk-a.json"), "[1]").unwrap();
        let mute = overview(&folder).unwrap_err();
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(matches!(missing, OverviewError { path, .. } if path.ends_with("fpk-a.json")));
        assert!(matches!(mute, OverviewError { path, .. } if path.ends_with("fpk-a.json")));
    }
}
