//! The proof: runs the cases, prints their verdicts, writes the report.

mod numbers;
mod page;
mod progress;
mod recorded;
mod run;
mod select;
mod stale;
mod table;

use std::io::Write;
use std::path::{Path, PathBuf};

use reference_problems::record::{self, RecordError, Recording};
use result_figures::finite::{self, JsonError};
use result_figures::number;

pub use self::numbers::render_numbers;
pub use self::page::render_html;
pub use self::recorded::render_page;
pub use self::run::run_cases;
pub use self::select::{TableError, check_table, select};
pub use self::table::{Rows, Style, write_loose, write_summary};
use crate::case::{Case, Profile};
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
    /// Whether it goes into the documents too.
    pub recording: Recording,
    /// What has a row in what is printed.
    pub rows: Rows,
    /// Whether loose claims are listed.
    pub loose: Loose,
}

/// Whether the claims with a loose tolerance are listed; they are counted in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loose {
    /// Each with its error, tolerance and reason.
    Listed,
    /// Their number.
    Counted,
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
    /// The report cannot be recorded.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    /// A proof with loose claims is not recorded.
    #[error("{} a tolerance over ten times the error and no reason for it:\n  {}", have(.claims.len()), .claims.join("\n  "))]
    #[diagnostic(help(
        "tighten the tolerance, or begin the reason with `roundoff: `, `statistics: ` or `chaos: ` where that is true"
    ))]
    LooseClaims {
        /// Id, error, tolerance and reason of each.
        claims: Vec<String>,
    },
    /// The page could not be made.
    #[error("the page of the report cannot be made")]
    Page(#[from] minijinja::Error),
    /// The record cannot be read.
    #[error("cannot read {}", .path.display())]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
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
    let recorded = recorded(options)?;
    let style = Style::of_terminal(options.rows);
    let report = run_cases(&selected, options.profile, style, output).map_err(to_terminal)?;
    write_file(&options.out.join("report.json"), &finite::to_json(&report)?)?;
    write_file(&options.out.join("index.html"), &render_html(&report)?)?;
    if let Some(path) = &options.json {
        write_file(path, &finite::to_json(&report)?)?;
    }
    if options.loose == Loose::Listed {
        write_loose(&report, output).map_err(to_terminal)?;
    }
    writeln!(output, "report: {}", options.out.join("index.html").display())
        .map_err(to_terminal)?;
    write_summary(&report, output).map_err(to_terminal)?;
    if let Some(path) = &recorded {
        refuse_loose(&report)?;
        write_file(path, &render_page(&report))?;
        write_file(&path.with_extension("json"), &render_numbers(&report))?;
    }
    Ok(report)
}

/// An error seen on one machine fails no run on another, but what is recorded has no loose claims.
fn refuse_loose(report: &Report) -> Result<(), VerifyError> {
    let loose = report.claims().filter(|claim| claim.is_loose());
    let claims: Vec<String> = loose.map(table::loose_words).collect();
    if claims.is_empty() { Ok(()) } else { Err(VerifyError::LooseClaims { claims }) }
}

fn have(count: usize) -> String {
    format!("{} {}", number::counted(count, "claim"), if count == 1 { "has" } else { "have" })
}

/// Where the report is recorded.
fn recorded(options: &Options) -> Result<Option<PathBuf>, VerifyError> {
    let Recording::On(root) = &options.recording else { return Ok(None) };
    if let Some(filter) = options.filters.first() {
        return Err(RecordError::Part { filter: filter.clone() }.into());
    }
    Ok(Some(record::verification(root)))
}

/// Prints whether the recorded proof of the workspace at `root`, of the default profile, was made from other cases, scenes or
/// references than there are.
///
/// # Errors
/// [`VerifyError`] if the record cannot be read.
pub fn stale(cases: &[Case], root: &Path, output: &mut dyn Write) -> Result<(), VerifyError> {
    let path = record::verification(root).with_extension("json");
    let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
    let verdict = match std::fs::read_to_string(&path) {
        Ok(text) => {
            let of_profile = cases.iter().filter(|case| case.cost <= Profile::Default);
            let ids = of_profile.map(|case| case.id.to_owned()).collect();
            stale::verdict(&text, &name, &ids, root)
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            format!("warning: {name} does not exist; `cargo xtask verify --record` writes it")
        }
        Err(source) => return Err(VerifyError::Read { path, source }),
    };
    writeln!(output, "{verdict}").map_err(to_terminal)
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
    writeln!(output, "{}", number::counted(selected.len(), "case")).map_err(to_terminal)
}

fn to_terminal(source: std::io::Error) -> VerifyError {
    VerifyError::Write { path: "the terminal".into(), source }
}

fn write_file(path: &Path, text: &str) -> Result<(), VerifyError> {
    scenes::output::write_text(path, text)
        .map_err(|source| VerifyError::Write { path: path.into(), source })
}

#[cfg(test)]
mod tests {
    use result_figures::{Measured, Reference};

    use super::*;
    use crate::case::{Context, Run};
    use crate::report::Claim;

    const METHOD: &str = "log-density fit, whitened, RK4, 1,700 particles";

    /// Moments and a probability with the shape, though not the numbers, of a real case.
    fn sample_claims(context: &Context<'_>) -> Vec<Claim> {
        let moment = |t: u32| {
            let (measured, reference) = (0.0412 + 1e-6 * f64::from(t), 0.0412);
            context
                .subject(format!("second-moment-q/t{t}"), "E[q^2]", METHOD)
                .unit("m^2")
                .relative(measured, Reference::uncertain(reference, 1e-7))
                .within(2e-4)
                .because("truncation, seen 4e-5")
        };
        let tail = context
            .subject("exceedance/cell-integrated/t6", "P(|q| > 1.5) at t = 6", METHOD)
            .log10(Measured::sampled(4.9e-9, 2e-10), 4.8e-9)
            .monte_carlo(0.01)
            .because("time step bias");
        (1..=3).map(moment).chain([tail]).collect()
    }

    const CASES: [Case; 2] = [
        Case {
            id: "self-check/viscous-damper",
            title: "Made-up rows in the shape of real ones",
            source: "made up",
            cost: Profile::Quick,
            run: Run::Together(|context| Ok(sample_claims(context))),
        },
        Case {
            id: "self-check/stops",
            title: "A case that cannot be judged",
            source: "made up",
            cost: Profile::Quick,
            run: Run::Together(|_| {
                Err("step collapsed at t = 3.2: dt = 3e-8 is below 1e-6 of a period".into())
            }),
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
            recording: Recording::Off,
            rows: Rows::Claims,
            loose: Loose::Listed,
        };
        let mut output = Vec::new();
        let report = verify(&CASES, &options, &mut output).unwrap();
        let text = String::from_utf8(output).unwrap();
        let last = "\n4 of accuracy, 0 structural, 0 regression bounds; 1 failed\n";
        assert!(text.ends_with(last), "{text}");
        assert!(text.contains("\n0 loose claims (tolerance"), "{text}");
        assert!(text.contains("FAIL self-check/stops/ran"), "{text}");
        let written = std::fs::read_to_string(out.join("report.json")).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&written).unwrap(), report);
        assert_eq!(std::fs::read_to_string(json).unwrap(), written);
        assert!(std::fs::read_to_string(out.join("index.html")).unwrap().contains("4 of accuracy"));
        std::fs::remove_dir_all(&out).unwrap();
        // For the eye: `cargo test -p verification rows -- --nocapture`.
        print!("{text}");
    }

    fn recording(root: &Path, filters: &[&str]) -> Options {
        Options {
            filters: filters.iter().map(|&filter| filter.to_owned()).collect(),
            profile: Profile::Quick,
            out: root.join("target"),
            json: None,
            recording: Recording::On(root.into()),
            rows: Rows::Cases,
            loose: Loose::Counted,
        }
    }

    /// A folder for the documents of a workspace.
    fn workspace(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("{name}-{}", std::process::id()))
    }

    #[test]
    fn a_recorded_proof_has_a_page_and_its_numbers() {
        let root = workspace("verify-record");
        let mut output = Vec::new();
        stale(&CASES, &root, &mut output).unwrap();
        assert_eq!(
            String::from_utf8(output).unwrap(),
            "warning: docs/verification.json does not exist; `cargo xtask verify --record` writes it\n"
        );
        verify(&CASES, &recording(&root, &[]), &mut Vec::new()).unwrap();
        let page = std::fs::read_to_string(root.join("docs/verification.md")).unwrap();
        assert!(
            page.contains("4 of accuracy, 0 structural, 0 regression bounds; 1 failed"),
            "{page}"
        );
        let numbers = std::fs::read_to_string(root.join("docs/verification.json")).unwrap();
        let numbers: serde_json::Value = serde_json::from_str(&numbers).unwrap();
        assert_eq!(numbers["claims"].as_object().unwrap().len(), 5);
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn a_proof_with_a_loose_claim_is_listed_but_not_recorded() {
        let cases = [Case {
            id: "self-check/loose",
            run: Run::Together(|context| {
                let subject = context.subject("value", "x", "by hand");
                let compared = subject.relative(1.0 + 1e-6, 1.0);
                Ok(vec![compared.within(1e-4).because("truncation")])
            }),
            ..CASES[0]
        }];
        let root = workspace("verify-loose");
        let options = Options { loose: Loose::Listed, ..recording(&root, &[]) };
        let mut output = Vec::new();
        let error = verify(&cases, &options, &mut output).unwrap_err();
        let words = "self-check/loose/value: error +1.00e-6, tolerance 1.00e-4: truncation";
        assert!(error.to_string().contains("1 claim has a tolerance"), "{error}");
        assert!(error.to_string().contains(words), "{error}");
        let text = String::from_utf8(output).unwrap();
        assert!(text.contains(&format!("LOOSE {words}\n")), "{text}");
        assert!(text.contains("1 loose claim ("), "{text}");
        assert!(!root.join("docs").exists());
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn a_part_of_the_proof_is_not_recorded() {
        let root = workspace("verify-part");
        let error = verify(&CASES, &recording(&root, &["damper"]), &mut Vec::new()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the proof is recorded as a whole, not the part that `damper` selects"
        );
        assert!(!root.exists());
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
