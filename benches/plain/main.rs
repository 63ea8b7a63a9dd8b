//! Hand-written baselines, each for exactly one case, compared with the steps of the library.
//!
//! A feature that a scene does not use (random parameters, histories, bond failure, noise, contact, further
//! dimensions) must cost nothing. First both are compared after twenty steps, because different work is no comparison.
//! Then both are timed alternately. If valgrind is installed, the instructions of a step are counted: the difference
//! of two runs of different length excludes the initialisation. Valgrind does not support AVX-512, so its widest
//! registers are those of AVX2.
//!
//! `cargo xtask bench plain` does all of it; `-- peridyn` only the cases with that name.
//!
//! fpk-sph has no baseline. The feature that its scenes may omit, state-dependent noise, is omitted by a type. Its
//! density has no bond failure, histories or random parameters that a baseline could omit.

mod bonded;
mod case;
mod cases;
mod count;
mod fluid;
mod grid;
mod lattice;
mod list;
mod material_points;

use std::io::Write;
use std::process::ExitCode;

use benches::ratios::{Ratios, Work};
use benches::record::Listed;
use rayon::ThreadPoolBuilder;

use case::{Case, Failure, Who, require_agreement};
use cases::CASES;

/// Largest ratio of the library's instructions to those of the baseline.
const MOST: f64 = 1.05;

fn time(case: &Case, ratios: &mut Ratios) -> Result<(), Failure> {
    let edge = case.edges[usize::from(!ratios.is_measured())];
    let (mut ours, mut plain) = (Who::Ours.start(case, edge)?, Who::Plain.start(case, edge)?);
    let n_elements = ours.n_elements();
    let (mut failed, mut other) = (Ok(()), Ok(()));
    // A failed run takes no further steps.
    let step_ours = || {
        if failed.is_ok() {
            failed = ours.step();
        }
    };
    let step_plain = || {
        if other.is_ok() {
            other = plain.step();
        }
    };
    let work = Work::new(case.name, n_elements, "ours", step_ours);
    ratios.measure(work.rival("plain", step_plain));
    failed.and(other)
}

/// Table of instructions, or why it is missing.
fn count(cases: &[&Case], ratios: &mut Ratios) -> Result<(), Failure> {
    let Some(version) = count::version() else {
        ratios.note("instructions: skipped, valgrind is not installed");
        return Ok(());
    };
    let mut rows = Vec::new();
    for case in cases {
        let [ours, plain] = [Who::Ours, Who::Plain].map(|who| count::per_element(case, who));
        let (ours, plain) = (ours?, plain?);
        let ratio = ours / plain;
        rows.push(vec![
            case.name.to_owned(),
            case.what.to_owned(),
            case.element.to_owned(),
            format!("{ours:.1}"),
            format!("{plain:.1}"),
            format!("{ratio:.3}"),
            if ratio <= MOST { "reached" } else { "not reached" }.to_owned(),
        ]);
    }
    let most = format!("asked: {MOST} at most");
    let head = ["case", "scene", "a step of one", "ours", "plain", "ours / plain", &most];
    ratios.list(Listed {
        title: format!(
            "Instructions, counted by {version}, whose widest registers are those of AVX2"
        ),
        head: head.map(String::from).to_vec(),
        rows,
    });
    Ok(())
}

fn all(cases: &[&Case]) -> Result<(), Failure> {
    let mut ratios = Ratios::from_args("plain");
    let wanted: Vec<&Case> = cases.iter().copied().filter(|case| ratios.wants(case.name)).collect();
    for case in &wanted {
        require_agreement(case)?;
        time(case, &mut ratios)?;
    }
    if ratios.is_measured() {
        count(&wanted, &mut ratios)?;
    }
    ratios.print();
    Ok(())
}

/// Runs on one thread; returns an error as text, which can leave it.
fn start() -> Result<(), String> {
    let cases: Vec<&Case> = CASES.iter().collect();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string())?;
    pool.install(|| {
        let outcome = match arguments.split_first() {
            Some((first, rest)) if first == count::RUN => count::run(&cases, rest),
            _ => all(&cases),
        };
        outcome.map_err(|error| error.to_string())
    })
}

fn main() -> ExitCode {
    let Err(error) = start() else { return ExitCode::SUCCESS };
    // Without stderr the exit code still reports the error.
    let _ = writeln!(std::io::stderr(), "error: {error}");
    ExitCode::FAILURE
}
