//! The proof as a page of the documents: every claim with its value, reference, tolerance and reason, in tables that can be read.

mod rows;

use result_figures::markdown::{self, text};
use result_figures::number::{counted, short};
use scenes::machine;

use self::rows::{Rows, of_case};
use crate::case::Profile;
use crate::report::{CaseRecord, Claim, Counts, Report};

const HOW_TO_READ: &str = "How to read it. A claim is one of three kinds. *Accuracy*: the error against a reference is within its \
tolerance, or within its bias bound and four standard errors. *Structural*: equal bits, counts, typed errors, properties without a \
reference value. *Regression bound*: the value or the error stays where it was measured; this says nothing on accuracy. *used* is \
the part of the tolerance that the error takes. A case of many claims shows the worst of each quantity and reason, the worst first, \
and *of* how many; what failed, is a regression bound or misses an aim comes before them and is all there. *by* and *why* are \
numbers in the lists below a table. A claim is *loose* if its tolerance is over ten times the error and its reason does not begin with \
`roundoff:`, `statistics:` or `chaos:`. CPU time is that of all threads; what several cases share is counted in the first that asks.\n";

/// The page of a report.
#[must_use]
pub fn render_page(report: &Report) -> String {
    let crates = crates(report);
    let mut parts = vec![head(report), summary(report, &crates), failures(report)];
    for name in crates {
        parts.push(format!("\n## {name}\n"));
        let cases = report.cases.iter().filter(|case| crate_of(case) == name);
        parts.extend(cases.map(|case| section(case, report.profile)));
    }
    parts.concat()
}

fn head(report: &Report) -> String {
    let date = machine::date().unwrap_or_else(|| "date unknown".to_owned());
    let (flag, counts) = (flag(report.profile), report.counts());
    format!(
        "# Verification\n\nWritten by `cargo xtask verify --record{flag}`: profile {}, {}, {}, \
         {counts}; {} loose. {date}; {}; {}; version {}; CPU time {} s.\n\n`cargo xtask verify --stale` says which cases, scenes \
         and references changed since. A change of a solver is not among them: run again.\n\n{HOW_TO_READ}",
        report.profile.name(),
        counted(report.cases.len(), "case"),
        counted(counts.all(), "claim"),
        counts.loose,
        report.machine.hardware(),
        machine::commit_words(report.commit.as_deref()),
        report.version,
        seconds(report.cases.iter().map(|case| case.cpu_seconds).sum()),
    )
}

/// The crates in the order in which they first appear.
fn crates(report: &Report) -> Vec<&str> {
    let mut names = Vec::new();
    for name in report.cases.iter().map(crate_of) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn crate_of(case: &CaseRecord) -> &str {
    case.id.split('/').next().unwrap_or(&case.id)
}

fn summary(report: &Report, crates: &[&str]) -> String {
    let row = |name: &&str| {
        let cases = || report.cases.iter().filter(|case| crate_of(case) == *name);
        let counts = Counts::of(cases().flat_map(|case| &case.claims));
        vec![
            format!("[{name}](#{name})"),
            cases().count().to_string(),
            counts.all().to_string(),
            counts.accuracy.to_string(),
            counts.structural.to_string(),
            counts.regression_bounds.to_string(),
            counts.failed.to_string(),
            counts.loose.to_string(),
            seconds(cases().map(|case| case.cpu_seconds).sum()),
        ]
    };
    let heads = [
        "crate",
        "cases",
        "claims",
        "accuracy",
        "structural",
        "regression bounds",
        "failed",
        "loose",
        "CPU (s)",
    ];
    let rows: Vec<Vec<String>> = crates.iter().map(row).collect();
    format!("\n{}", markdown::table(&heads.map(str::to_owned), &rows))
}

/// The claims that did not hold, with their reasons, before anything else.
fn failures(report: &Report) -> String {
    let line = |claim: &Claim| format!("- **failed** `{}`: {}\n", claim.id, text(&claim.reason));
    let lines: Vec<String> = report.failures().map(line).collect();
    if lines.is_empty() { String::new() } else { format!("\n## What failed\n\n{}", lines.concat()) }
}

fn section(case: &CaseRecord, profile: Profile) -> String {
    let n_failed = case.claims.iter().filter(|claim| !claim.passed).count();
    let verdict =
        if n_failed == 0 { "all passed".to_owned() } else { format!("**{n_failed} failed**") };
    let n_claims = counted(case.claims.len(), "claim");
    let flag = flag(profile);
    let heading = format!(
        "\n### {}\n\n{}. Source: {}.\n\n`cargo xtask verify {}{flag}`: {n_claims}, {verdict}, CPU {} s.\n\n",
        case.id,
        text(&case.title),
        text(case.source.trim_end_matches('.')),
        case.id,
        seconds(case.cpu_seconds),
    );
    let Rows { table, left_out, methods, reasons } = of_case(case);
    let left_out = left_out.map_or_else(String::new, |left_out| {
        format!("\n{left_out}: `cargo xtask verify {}{flag} --json FILE` has all.\n", case.id)
    });
    let skipped: Vec<String> =
        case.skipped.iter().map(|what| format!("\nSkipped {}.\n", text(what))).collect();
    [
        heading,
        table,
        left_out,
        skipped.concat(),
        numbered("By", &methods),
        numbered("Why", &reasons),
    ]
    .concat()
}

/// A list to which a column of the table refers.
fn numbered(what: &str, list: &[String]) -> String {
    if list.is_empty() {
        return String::new();
    }
    let line = |(i, words): (usize, &String)| format!("{}. {}\n", i + 1, text(words));
    let lines: Vec<String> = list.iter().enumerate().map(line).collect();
    format!("\n{what}:\n\n{}", lines.concat())
}

/// The word that the command of a recorded run needs.
const fn flag(profile: Profile) -> &'static str {
    match profile {
        Profile::Quick => " --quick",
        Profile::Default => "",
        Profile::Full => " --full",
    }
}

fn seconds(seconds: f64) -> String {
    short(Some(seconds))
}

#[cfg(test)]
mod tests;
