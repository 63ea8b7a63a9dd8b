//! Runs cases on all cores; a case that errors or panics becomes a failed row and the others go on.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Sender};
use std::time::Instant;

use scenes::causes::with_causes;
use scenes::clock::CpuClock;
use scenes::machine::Machine;

use super::progress::Progress;
use super::select::well_formed;
use super::table::{Style, write_case, write_header};
use crate::case::{Case, Context, Profile, Run, Shared};
use crate::report::{CaseRecord, Claim, Report};

/// What all cases of a run share.
#[derive(Debug)]
struct Proof<'a> {
    cases: &'a [&'a Case],
    profile: Profile,
    shared: Shared,
    progress: Progress,
}

/// A finished case, by its place in the table.
type Ended = (usize, CaseRecord);

/// Runs `cases` and prints each in the order of the table.
///
/// Each case has one core; those that run alone have all of them, after the others. The result does not depend on it.
///
/// # Errors
/// Those of writing to `output`.
pub fn run_cases(
    cases: &[&Case],
    profile: Profile,
    style: Style,
    output: &mut dyn Write,
) -> io::Result<Report> {
    let machine = Machine::read();
    let progress = Progress::new(cases.len());
    progress.suspend(|| write_header(style, output))?;
    let proof = Proof { cases, profile, shared: Shared::default(), progress };
    let (sender, ended) = mpsc::channel();
    let mut printed = Printed::new(cases.len());
    std::thread::scope(|scope| {
        let proof = &proof;
        // The sender goes with the thread: at its end nothing more is waited for.
        scope.spawn(move || proof.run(&sender));
        let taken =
            ended.iter().try_for_each(|case| printed.take(case, &proof.progress, style, output));
        // Nothing more is run for an output that cannot be written.
        drop(ended);
        taken
    })?;
    proof.progress.finish();
    Ok(Report::new(profile, machine, printed.records))
}

impl Proof<'_> {
    /// Those that run together on as many threads as there are cores, then the others one by one.
    fn run(&self, ended: &Sender<Ended>) {
        let (together, alone): (Vec<_>, Vec<_>) = (0..self.cases.len())
            .partition(|&index| matches!(self.cases[index].run, Run::Together(_)));
        let together = self.longest_first(together);
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..rayon::current_num_threads().min(together.len()) {
                let (sender, together, next) = (ended.clone(), &together, &next);
                scope.spawn(move || self.work(together, next, &sender));
            }
        });
        for index in alone {
            // The receiver is gone where the output could not be written.
            if ended.send(self.run_case(index)).is_err() {
                return;
            }
        }
    }

    /// Takes one case after the other into a pool of one thread.
    fn work(&self, cases: &[usize], next: &AtomicUsize, ended: &Sender<Ended>) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        while let Some(&index) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let case = match &pool {
                Ok(pool) => pool.install(|| self.run_case(index)),
                Err(_) => self.run_case(index),
            };
            if ended.send(case).is_err() {
                return;
            }
        }
    }

    /// A long case that begins last is waited for.
    fn longest_first(&self, mut cases: Vec<usize>) -> Vec<usize> {
        cases.sort_by_key(|&index| std::cmp::Reverse(self.cases[index].cost));
        cases
    }

    fn run_case(&self, index: usize) -> Ended {
        let case = self.cases[index];
        self.progress.start(case.id);
        let tell = |what: &str| self.progress.tell(case.id, what);
        let context = Context::new(case.id, self.profile, &self.shared, &tell);
        let (start, cpu) = (Instant::now(), CpuClock::start());
        // What a panicking case leaves half done is its own: shared results are stored only when complete.
        let (Run::Together(run) | Run::Alone(run)) = case.run;
        let result = catch_unwind(AssertUnwindSafe(|| run(&context)));
        let (seconds, cpu_seconds) = (start.elapsed().as_secs_f64(), cpu.seconds());
        let claims = match result {
            Ok(Ok(claims)) if claims.is_empty() => {
                vec![Claim::case_error(case.id, "the case claims nothing")]
            }
            Ok(Ok(claims)) => claims,
            Ok(Err(error)) => vec![Claim::case_error(case.id, &with_causes(error.as_ref()))],
            Err(panic) => {
                vec![Claim::case_error(case.id, &format!("panicked: {}", panic_message(&*panic)))]
            }
        };
        let (id, title, source) = (case.id.into(), case.title.into(), case.source.into());
        let skipped = context.into_skipped();
        (index, CaseRecord { id, title, source, seconds, cpu_seconds, claims, skipped })
    }
}

/// The cases that have been printed, and those that wait for one above them.
struct Printed {
    waiting: Vec<Option<CaseRecord>>,
    records: Vec<CaseRecord>,
    /// The ids of all claims so far.
    seen: BTreeSet<String>,
}

impl Printed {
    fn new(n_cases: usize) -> Self {
        let waiting = (0..n_cases).map(|_| None).collect();
        Self { waiting, records: Vec::new(), seen: BTreeSet::new() }
    }

    /// Prints all whose turn has come.
    fn take(
        &mut self,
        (index, record): Ended,
        progress: &Progress,
        style: Style,
        output: &mut dyn Write,
    ) -> io::Result<()> {
        progress.finish_case();
        self.waiting[index] = Some(record);
        while let Some(mut record) = self.waiting.get_mut(self.records.len()).and_then(Option::take)
        {
            self.check_ids(&mut record);
            progress.suspend(|| write_case(&record, style, output))?;
            self.records.push(record);
        }
        Ok(())
    }

    fn check_ids(&mut self, record: &mut CaseRecord) {
        let seen = &mut self.seen;
        let ids = record.claims.iter().map(|claim| &claim.id);
        let faults: Vec<String> = ids.filter_map(|id| fault_of_id(id, &record.id, seen)).collect();
        if !faults.is_empty() {
            record.claims.push(Claim::case_error(&record.id, &faults.join("; ")));
        }
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
    use super::super::table::Rows;
    use super::*;
    use crate::case::CaseResult;

    fn claim(context: &Context<'_>, name: &str, value: f64) -> Claim {
        context
            .subject(name, "x", "by hand")
            .absolute(value, 1.0)
            .within(0.5)
            .because("a self-check")
    }

    const fn case(id: &'static str, run: fn(&Context<'_>) -> CaseResult) -> Case {
        let (title, source) = ("a self-check", "none");
        Case { id, title, source, cost: Profile::Quick, run: Run::Together(run) }
    }

    fn run(cases: &[Case]) -> (Report, String) {
        let mut output = Vec::new();
        let selected: Vec<&Case> = cases.iter().collect();
        let report =
            run_cases(&selected, Profile::Quick, Style::plain(150, Rows::Claims), &mut output)
                .unwrap();
        (report, String::from_utf8(output).unwrap())
    }

    #[test]
    fn a_case_that_errors_or_panics_is_a_failed_row_and_the_others_run() {
        let (report, text) = run(&[
            case("self-check/errs", |_| Err("the solver stopped at t = 3".into())),
            case("self-check/panics", |_| panic!("index out of range")),
            case("self-check/empty", |_| Ok(Vec::new())),
            case("self-check/holds", |context| Ok(vec![claim(context, "value", 1.25)])),
        ]);
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
    }

    #[test]
    fn claim_ids_that_repeat_or_do_not_belong_fail() {
        let (report, _) = run(&[
            case("self-check/twice", |context| {
                Ok(vec![claim(context, "x", 1.0), claim(context, "x", 1.0)])
            }),
            case("self-check/foreign", |context| {
                let mut foreign = claim(context, "x", 1.0);
                foreign.id = "elsewhere/x".into();
                Ok(vec![foreign])
            }),
        ]);
        let reasons: Vec<&str> = report.failures().map(|claim| claim.reason.as_str()).collect();
        assert_eq!(
            reasons,
            [
                "error: the claim id `self-check/twice/x` is given twice",
                "error: the claim id `elsewhere/x` does not begin with `self-check/foreign/`"
            ]
        );
    }

    #[test]
    fn cases_share_results() {
        // Which of the two comes first is not known.
        static COMPUTED: AtomicUsize = AtomicUsize::new(0);
        let share: fn(&Context<'_>) -> CaseResult = |context| {
            let value = context.shared("value", || {
                COMPUTED.fetch_add(1, Ordering::Relaxed);
                Ok(1.0)
            })?;
            Ok(vec![claim(context, "value", *value)])
        };
        let (report, _) = run(&[case("self-check/first", share), case("self-check/second", share)]);
        assert_eq!((report.passed, COMPUTED.load(Ordering::Relaxed)), (2, 1));
    }
}
