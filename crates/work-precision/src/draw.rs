//! Drawing of charts and stability maps by name.

use std::io::Write;
use std::path::PathBuf;

use result_figures::Drawing;
use result_figures::number::counted;
use scenes::nearest::nearest;
use scenes::output::{write_drawing, write_text};

use crate::overview::{self, OverviewError};
use reference_problems::context::{CaseError, Context, Profile, Shared};
use reference_problems::record::Recording;

/// One entry of a table of charts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChartKind {
    /// Name on the command line.
    pub(crate) name: &'static str,
    /// One line for `--list`.
    pub(crate) title: &'static str,
    /// Runs the methods and returns the drawings.
    pub(crate) draw: fn(&Context<'_>) -> Result<Vec<Drawing>, CaseError>,
}

/// Error of drawing a chart or a stability sweep, which `what` names.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(crate) enum ChartsError {
    #[error("no {what} is called `{name}`")]
    NoMatch {
        what: &'static str,
        name: String,
        /// Nearest name, or all names.
        #[help]
        help: String,
    },
    /// A run of the chart ended in an error.
    #[error("the {what} `{name}` could not be made")]
    Failed { what: &'static str, name: &'static str, source: CaseError },
    /// A file or standard output could not be written.
    #[error("cannot write the {what}")]
    Write { what: &'static str, source: std::io::Error },
    #[error("the page of recorded charts cannot be made")]
    Overview(#[from] OverviewError),
}

/// Charts to draw, and the folder of the files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Options {
    /// Chart or stability sweep, for messages.
    pub(crate) what: &'static str,
    /// Names from the table; a name also selects entries that begin with it and a dash. None draws all.
    pub(crate) names: Vec<String>,
    pub(crate) profile: Profile,
    /// Folder of the files.
    pub(crate) out: PathBuf,
    /// Whether they are recorded in the documents too.
    pub(crate) recording: Recording,
}

/// Draws the entries selected by `options` and prints the path of each picture.
pub(crate) fn draw(
    table: &[ChartKind],
    options: &Options,
    output: &mut dyn Write,
) -> Result<(), ChartsError> {
    let what = options.what;
    let to_file = |source| ChartsError::Write { what, source };
    let shared = Shared::default();
    let recorded = options.recording.charts();
    let tell = |text: &str| {
        // A failure to show progress does not stop a run.
        let _ = writeln!(std::io::stderr(), "{text}");
    };
    for kind in select(table, options)? {
        tell(&format!("{}: {}", kind.name, kind.title));
        let context = Context::new(kind.name, options.profile, &shared, &tell);
        let drawings = (kind.draw)(&context).map_err(|source| ChartsError::Failed {
            what,
            name: kind.name,
            source,
        })?;
        for drawing in drawings {
            let picture = write_drawing(&drawing, &options.out).map_err(to_file)?;
            writeln!(output, "{}", picture.display()).map_err(to_file)?;
            if let Some(folder) = &recorded {
                write_drawing(&drawing, folder).map_err(to_file)?;
            }
            if !drawing.table.is_empty() {
                writeln!(output, "{}", drawing.table).map_err(to_file)?;
            }
        }
    }
    if let Some(folder) = &recorded {
        let page = folder.join(overview::PAGE);
        write_text(&page, &overview::overview(folder)?).map_err(to_file)?;
        writeln!(output, "{}", page.display()).map_err(to_file)?;
    }
    Ok(())
}

/// Prints name and title of every entry.
pub(crate) fn list(
    table: &[ChartKind],
    what: &'static str,
    output: &mut dyn Write,
) -> Result<(), ChartsError> {
    let to_terminal = |source| ChartsError::Write { what, source };
    for kind in table {
        writeln!(output, "{:16}  {}", kind.name, kind.title).map_err(to_terminal)?;
    }
    writeln!(output, "{}", counted(table.len(), what)).map_err(to_terminal)
}

fn select<'a>(
    table: &'a [ChartKind],
    options: &Options,
) -> Result<Vec<&'a ChartKind>, ChartsError> {
    let what = options.what;
    for name in &options.names {
        if !table.iter().any(|kind| belongs(kind, name)) {
            let names: Vec<&str> = table.iter().map(|kind| kind.name).collect();
            let help = match nearest(name, names.iter().copied()) {
                Some(nearest) => format!("did you mean `{nearest}`?"),
                None => format!("available: {}", names.join(", ")),
            };
            return Err(ChartsError::NoMatch { what, name: name.clone(), help });
        }
    }
    let wanted = |kind: &&ChartKind| {
        options.names.is_empty() || options.names.iter().any(|name| belongs(kind, name))
    };
    Ok(table.iter().filter(wanted).collect())
}

/// Whether an entry has the name, or begins with the name and a dash.
fn belongs(kind: &ChartKind, name: &str) -> bool {
    kind.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use result_figures::WorkPrecision;

    use super::*;

    const TABLE: [ChartKind; 2] = [
        ChartKind {
            name: "sample",
            title: "made up",
            draw: |_| {
                Ok(vec![Drawing::work_precision(
                    "sample_cost",
                    &result_figures::samples::work_precision(),
                )?])
            },
        },
        ChartKind { name: "fails", title: "made up", draw: |_| Err("no result".into()) },
    ];

    fn options(names: &[&str], out: PathBuf) -> Options {
        let names = names.iter().map(|&name| name.to_owned()).collect();
        let recording = Recording::Off;
        Options { what: "chart", names, profile: Profile::Default, out, recording }
    }

    #[test]
    fn a_picture_and_its_numbers_are_written() {
        let folder = std::env::temp_dir().join(format!("chart-files-{}", std::process::id()));
        let mut output = Vec::new();
        draw(&TABLE, &options(&["sample"], folder.clone()), &mut output).unwrap();
        let svg = std::fs::read_to_string(folder.join("sample_cost.svg")).unwrap();
        let json = std::fs::read_to_string(folder.join("sample_cost.json")).unwrap();
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
        let mut numbers: serde_json::Value = serde_json::from_str(&json).unwrap();
        let cheapest = numbers.as_object_mut().unwrap().remove("cheapest").unwrap();
        let sample = result_figures::samples::work_precision();
        assert_eq!(serde_json::from_value::<WorkPrecision>(numbers).unwrap(), sample);
        assert_eq!(
            serde_json::from_value::<Vec<result_figures::Choice>>(cheapest).unwrap(),
            result_figures::choices(&sample)
        );
        let output = String::from_utf8(output).unwrap();
        assert!(output.contains("sample_cost.svg") && output.contains("| error within |"));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn what_is_recorded_goes_to_the_documents_too_with_a_page_of_all() {
        let root = std::env::temp_dir().join(format!("chart-record-{}", std::process::id()));
        let mut options = options(&["sample"], root.join("target"));
        let documents = root.join("docs/charts");
        draw(&TABLE, &options, &mut Vec::new()).unwrap();
        assert!(!documents.exists());
        options.recording = Recording::On(root.clone());
        draw(&TABLE, &options, &mut Vec::new()).unwrap();
        for name in ["sample_cost.svg", "sample_cost.json"] {
            let read = |folder: &Path| std::fs::read_to_string(folder.join(name)).unwrap();
            assert_eq!(read(&documents), read(&options.out));
        }
        let page = std::fs::read_to_string(documents.join("README.md")).unwrap();
        assert!(page.contains("(sample_cost.svg)"), "{page}");
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn rows_of_a_chart_stand_before_its_choices() {
        let drawing =
            Drawing::work_precision("a", &result_figures::samples::work_precision()).unwrap();
        let table = drawing.table.clone();
        assert_eq!(drawing.with_rows("  row").table, format!("  row\n{table}"));
    }

    #[test]
    fn unknown_names_and_failed_runs_are_errors() {
        let run = |name: &str| draw(&TABLE, &options(&[name], PathBuf::new()), &mut Vec::new());
        match run("smaple").unwrap_err() {
            ChartsError::NoMatch { help, .. } => assert_eq!(help, "did you mean `sample`?"),
            other => panic!("{other}"),
        }
        assert!(matches!(run("fails"), Err(ChartsError::Failed { name: "fails", .. })));
    }
}
