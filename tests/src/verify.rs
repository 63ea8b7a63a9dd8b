//! The proof: runs the cases, prints their claims, writes the report.

mod page;
mod progress;
mod run;
mod select;
mod table;

use std::io::Write;
use std::path::{Path, PathBuf};

pub use self::page::render_page;
pub use self::run::{Outcome, run_cases};
pub use self::select::{TableError, check_table, select};
pub use self::table::{Style, write_failures, write_summary};

use crate::case::{Case, Profile};
use crate::finite::{self, JsonError};
use crate::report::Report;

/// What is to be run, and where the report goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Parts of case ids, or ids of claims; none runs all.
    pub filters: Vec<String>,
    /// How much is run.
    pub profile: Profile,
    /// Where `report.json` and `index.html` go.
    pub out: PathBuf,
    /// A second copy of the report.
    pub json: Option<PathBuf>,
}

/// Why there is no report. Claims that fail are in the report instead.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum VerifyError {
    /// A filter selects nothing.
    #[error("no case matches `{filter}`")]
    NoMatch {
        /// The filter.
        filter: String,
        /// The nearest id, and where all are listed.
        #[help]
        help: String,
    },
    /// A filter selects only cases that this profile leaves out.
    #[error("`{filter}` matches only cases that the profile {} leaves out, e.g. `{id}`", .profile.name())]
    #[diagnostic(help("`{id}` runs with --{}", .cost.name()))]
    OutsideProfile {
        /// The filter.
        filter: String,
        /// A case it would match.
        id: String,
        /// The profile asked for.
        profile: Profile,
        /// The profile that case needs.
        cost: Profile,
    },
    /// The profile has no case at all: a proof of nothing is not a pass.
    #[error("there is no case to run in the profile {}", .profile.name())]
    NothingToRun {
        /// The profile asked for.
        profile: Profile,
    },
    /// The table of cases is wrong.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The report holds a number that is not finite.
    #[error("the report cannot be written")]
    Json(#[from] JsonError),
    /// The page could not be made.
    #[error("the page of the report cannot be made")]
    Page(#[from] minijinja::Error),
    /// A file or the terminal could not be written.
    #[error("cannot write {}", .path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Runs what `options` selects, prints one row per claim to `output`, writes the report.
///
/// # Errors
/// [`VerifyError`] if nothing is selected or something cannot be written; never for a claim that fails.
pub fn verify(
    cases: &[Case],
    options: &Options,
    output: &mut dyn Write,
) -> Result<Report, VerifyError> {
    check_table(cases)?;
    let selected = select(cases, &options.filters, options.profile)?;
    let style = Style::of_terminal();
    let outcome = run_cases(&selected, options.profile, style, output).map_err(to_terminal)?;
    let report = outcome.report;
    write_file(&options.out.join("report.json"), &finite::to_json(&report)?)?;
    write_file(&options.out.join("index.html"), &render_page(&report, &outcome.charts)?)?;
    if let Some(path) = &options.json {
        write_file(path, &finite::to_json(&report)?)?;
    }
    write_failures(&report, output).map_err(to_terminal)?;
    writeln!(output, "report: {}", options.out.join("index.html").display())
        .map_err(to_terminal)?;
    write_summary(&report, output).map_err(to_terminal)?;
    Ok(report)
}

/// Prints id, smallest profile and title of what `filters` select in any profile.
///
/// # Errors
/// [`VerifyError::NoMatch`] for a filter that selects nothing; [`VerifyError::Write`].
pub fn list(cases: &[Case], filters: &[String], output: &mut dyn Write) -> Result<(), VerifyError> {
    check_table(cases)?;
    let selected = if cases.is_empty() && filters.is_empty() {
        Vec::new()
    } else {
        select(cases, filters, Profile::Full)?
    };
    let width = selected.iter().map(|case| case.id.len()).max().unwrap_or(0);
    for case in &selected {
        writeln!(output, "{:width$}  {:7}  {}", case.id, case.cost.name(), case.title)
            .map_err(to_terminal)?;
    }
    let noun = if selected.len() == 1 { "case" } else { "cases" };
    writeln!(output, "{} {noun}", selected.len()).map_err(to_terminal)
}

fn to_terminal(source: std::io::Error) -> VerifyError {
    VerifyError::Write { path: "the terminal".into(), source }
}

fn write_file(path: &Path, text: &str) -> Result<(), VerifyError> {
    crate::output::write_text(path, text)
        .map_err(|source| VerifyError::Write { path: path.into(), source })
}
