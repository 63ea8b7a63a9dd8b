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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Context;
    use crate::claim::{Criterion, Measured, Reference};
    use crate::report::{Claim, ErrorKind};

    const METHOD: &str = "log-density fit, whitened, RK4, 1,700 particles";

    /// Moments and a probability with the shape, though not the numbers, of a real case.
    fn sample_claims(context: &Context<'_>) -> Vec<Claim> {
        let moment = |t: u32| {
            let subject =
                context.subject(&format!("second-moment-q/t{t}"), "E[q^2]", "m^2", METHOD);
            let (measured, reference) = (0.0412 + 1e-6 * f64::from(t), 0.0412);
            let criterion = Criterion::Within { tolerance: 2e-4, reason: "truncation, seen 4e-5" };
            let reference = Reference::uncertain(reference, 1e-7);
            Claim::judge(
                subject,
                ErrorKind::Relative,
                Measured::exact(measured),
                reference,
                criterion,
            )
        };
        let subject =
            context.subject("exceedance/cell-integrated/t6", "P(|q| > 1.5) at t = 6", "", METHOD);
        let criterion = Criterion::MonteCarlo { bias_bound: 0.01, reason: "time step bias" };
        let measured = Measured::sampled(4.9e-9, 2e-10);
        let tail =
            Claim::judge(subject, ErrorKind::Log10, measured, Reference::exact(4.8e-9), criterion);
        (1..=3).map(moment).chain([tail]).collect()
    }

    const CASES: [Case; 2] = [
        Case {
            id: "self-check/viscous-damper",
            title: "Made-up rows in the shape of real ones",
            source: "made up",
            cost: Profile::Quick,
            run: |context| Ok(sample_claims(context)),
        },
        Case {
            id: "self-check/stops",
            title: "A case that cannot be judged",
            source: "made up",
            cost: Profile::Quick,
            run: |_| Err("step collapsed at t = 3.2: dt = 3e-8 is below 1e-6 of a period".into()),
        },
    ];

    #[test]
    fn a_run_prints_its_rows_and_leaves_its_report() {
        let out = std::env::temp_dir().join(format!("verify-files-{}", std::process::id()));
        let json = out.join("copies").join("out.json");
        let options = Options {
            filters: Vec::new(),
            profile: Profile::Quick,
            out: out.clone(),
            json: Some(json.clone()),
        };
        let mut output = Vec::new();
        let report = verify(&CASES, &options, &mut output).unwrap();
        let text = String::from_utf8(output).unwrap();
        assert!(text.ends_with("\n4 passed, 1 failed\n"), "{text}");
        assert!(text.contains("FAIL self-check/stops/ran"), "{text}");
        let written = std::fs::read_to_string(out.join("report.json")).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&written).unwrap(), report);
        assert_eq!(std::fs::read_to_string(json).unwrap(), written);
        assert!(std::fs::read_to_string(out.join("index.html")).unwrap().contains("4 passed"));
        std::fs::remove_dir_all(&out).unwrap();
        // For the eye: `cargo test -p verification rows -- --nocapture`.
        print!("{text}");
    }

    #[test]
    fn a_list_counts_what_it_lists() {
        let listed = |cases: &[Case], filters: &[&str]| {
            let filters: Vec<String> = filters.iter().map(|&filter| filter.to_owned()).collect();
            let mut output = Vec::new();
            list(cases, &filters, &mut output).map(|()| String::from_utf8(output).unwrap())
        };
        assert!(listed(&CASES, &[]).unwrap().ends_with("2 cases\n"));
        assert!(listed(&CASES, &["damper"]).unwrap().ends_with("1 case\n"));
        assert!(listed(&CASES, &["nothing-like-it"]).is_err());
        assert_eq!(listed(&[], &[]).unwrap(), "0 cases\n");
    }
}
