//! Runs cases one after the other; a case that errors or panics becomes a failed row and the others go on.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use cpu_time::ProcessTime;

use super::progress::Progress;
use super::select::well_formed;
use super::table::{Style, write_case, write_header};
use crate::case::{Case, Context, InlineChart, Profile, Shared};
use crate::causes::with_causes;
use crate::machine::Machine;
use crate::report::{CaseRecord, Claim, Report};

/// What a run brought.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The cases and their claims.
    pub report: Report,
    /// The pictures that cases asked to show.
    pub charts: Vec<InlineChart>,
}

/// Runs `cases` in order and prints each as it ends.
///
/// # Errors
/// Those of writing to `output`.
pub fn run_cases(
    cases: &[&Case],
    profile: Profile,
    style: Style,
    output: &mut dyn Write,
) -> io::Result<Outcome> {
    let machine = Machine::read();
    let (shared, charts) = (Shared::default(), Mutex::new(Vec::new()));
    let progress = Progress::new(cases.len());
    let mut seen = BTreeSet::new();
    let mut records = Vec::new();
    progress.suspend(|| write_header(style, output))?;
    for case in cases {
        progress.start(case.id);
        let tell = |what: &str| progress.tell(case.id, what);
        let context = Context::new(case.id, profile, &shared, &charts, &tell);
        let record = run_case(case, &context, &mut seen);
        progress.suspend(|| write_case(&record, style, output))?;
        progress.finish_case();
        records.push(record);
    }
    progress.finish();
    let charts = charts.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(Outcome { report: Report::new(profile, machine, records), charts })
}

/// Runs one case; `seen` holds the ids of all claims so far.
fn run_case(case: &Case, context: &Context<'_>, seen: &mut BTreeSet<String>) -> CaseRecord {
    let (start, cpu) = (Instant::now(), ProcessTime::now());
    // Whatever a panicking case leaves half done is its own: shared results are stored only when complete.
    let result = catch_unwind(AssertUnwindSafe(|| (case.run)(context)));
    let (seconds, cpu_seconds) = (start.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    let mut claims = match result {
        Ok(Ok(claims)) if claims.is_empty() => {
            vec![Claim::case_error(case.id, "the case claims nothing")]
        }
        Ok(Ok(claims)) => claims,
        Ok(Err(error)) => vec![Claim::case_error(case.id, &with_causes(error.as_ref()))],
        Err(panic) => {
            vec![Claim::case_error(case.id, &format!("panicked: {}", panic_message(&*panic)))]
        }
    };
    let faults: Vec<String> =
        claims.iter().filter_map(|claim| fault_of_id(&claim.id, case.id, seen)).collect();
    if !faults.is_empty() {
        claims.push(Claim::case_error(case.id, &faults.join("; ")));
    }
    CaseRecord {
        id: case.id.into(),
        title: case.title.into(),
        source: case.source.into(),
        seconds,
        cpu_seconds,
        claims,
        skipped: context.take_skipped(),
    }
}

fn fault_of_id(id: &str, case_id: &str, seen: &mut BTreeSet<String>) -> Option<String> {
    let belongs = id.strip_prefix(case_id).is_some_and(|rest| rest.starts_with('/'));
    if !belongs {
        return Some(format!("the claim id `{id}` does not begin with `{case_id}/`"));
    }
    if !well_formed(id) {
        return Some(format!("the claim id `{id}` is not lower-case words joined by `-` and `/`"));
    }
    (!seen.insert(id.to_owned())).then(|| format!("the claim id `{id}` is given twice"))
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("without a message")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::CaseError;
    use crate::claim::{Criterion, Measured, Reference};
    use crate::report::ErrorKind;

    fn claim(context: &Context<'_>, name: &str, value: f64) -> Claim {
        Claim::judge(
            context.subject(name, "x", "", "by hand"),
            ErrorKind::Absolute,
            Measured::exact(value),
            Reference::exact(1.0),
            Criterion::Within { tolerance: 0.5, reason: "a self-check" },
        )
    }

    const fn case(
        id: &'static str,
        run: fn(&Context<'_>) -> Result<Vec<Claim>, CaseError>,
    ) -> Case {
        Case { id, title: "a self-check", source: "none", cost: Profile::Quick, run }
    }

    fn run(cases: &[Case]) -> (Outcome, String) {
        let mut output = Vec::new();
        let selected: Vec<&Case> = cases.iter().collect();
        let outcome = run_cases(&selected, Profile::Quick, Style::plain(150), &mut output).unwrap();
        (outcome, String::from_utf8(output).unwrap())
    }

    #[test]
    fn a_case_that_errors_or_panics_is_a_failed_row_and_the_others_run() {
        let (outcome, text) = run(&[
            case("self-check/errs", |_| Err("the solver stopped at t = 3".into())),
            case("self-check/panics", |_| panic!("index out of range")),
            case("self-check/empty", |_| Ok(Vec::new())),
            case("self-check/holds", |context| Ok(vec![claim(context, "value", 1.25)])),
        ]);
        let report = &outcome.report;
        assert_eq!((report.passed, report.failed), (1, 3));
        let reasons: Vec<&str> = report.failures().map(|claim| claim.reason.as_str()).collect();
        assert_eq!(
            reasons,
            [
                "error: the solver stopped at t = 3",
                "error: panicked: index out of range",
                "error: the case claims nothing"
            ]
        );
        assert!(text.contains("the solver stopped at t = 3"), "{text}");
        assert_eq!(report.cases[0].claims[0].id, "self-check/errs/ran");
        assert!(text.lines().all(|line| line.chars().count() <= 150), "{text}");
    }

    #[test]
    fn claim_ids_that_repeat_or_do_not_belong_fail() {
        let (outcome, _) = run(&[
            case("self-check/twice", |context| {
                Ok(vec![claim(context, "x", 1.0), claim(context, "x", 1.0)])
            }),
            case("self-check/foreign", |context| {
                let mut foreign = claim(context, "x", 1.0);
                foreign.id = "elsewhere/x".into();
                Ok(vec![foreign])
            }),
        ]);
        let reasons: Vec<&str> =
            outcome.report.failures().map(|claim| claim.reason.as_str()).collect();
        assert_eq!(
            reasons,
            [
                "error: the claim id `self-check/twice/x` is given twice",
                "error: the claim id `elsewhere/x` does not begin with `self-check/foreign/`"
            ]
        );
    }

    #[test]
    fn cases_share_results_and_show_charts() {
        let share: fn(&Context<'_>) -> Result<Vec<Claim>, CaseError> = |context| {
            let value = context
                .shared("value", || Ok(if context.id.ends_with("first") { 1.0 } else { 9.0 }))?;
            context.show_chart("a chart", "<svg/>".into());
            Ok(vec![claim(context, "value", *value)])
        };
        let (outcome, _) =
            run(&[case("self-check/first", share), case("self-check/second", share)]);
        assert_eq!((outcome.report.passed, outcome.charts.len()), (2, 2));
        assert_eq!(outcome.charts[1].case_id, "self-check/second");
    }
}
