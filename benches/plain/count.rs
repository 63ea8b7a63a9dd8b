//! Instructions of a step, counted by valgrind: the same on a busy machine as on a quiet one.

use std::process::Command;

use crate::case::{Case, Failure, Who};

/// Steps of the shorter run and of the longer one, whose difference is free of what a start costs.
const STEPS: [u32; 2] = [5, 25];

/// Counts instructions.
const VALGRIND: &str = "valgrind";

/// What a program is started with to be counted.
pub(crate) const RUN: &str = "run";

/// Whether there is a valgrind to count with, and which.
pub(crate) fn version() -> Option<String> {
    let output = Command::new(VALGRIND).arg("--version").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Instructions for each element and step.
///
/// # Errors
/// Where the program cannot be started, or says no count.
pub(crate) fn per_element(case: &Case, who: Who) -> Result<f64, Failure> {
    let n_elements = who.start(case, case.edges[1])?.n_elements();
    let [short, long] = STEPS.map(|steps| total(case, who, steps));
    let steps = f64::from(STEPS[1] - STEPS[0]);
    Ok((long? - short?) / (steps * n_elements as f64))
}

/// Instructions of a whole run.
fn total(case: &Case, who: Who, steps: u32) -> Result<f64, Failure> {
    let output = Command::new(VALGRIND)
        .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
        .arg(std::env::current_exe()?)
        .args([RUN, case.name, who.name(), &steps.to_string()])
        .output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    match references(&said) {
        Some(count) if output.status.success() => Ok(count),
        _ => Err(format!("valgrind counted nothing of {}: {said}", case.name).into()),
    }
}

/// Of the line `==1234== I   refs:      1,234,567`.
fn references(said: &str) -> Option<f64> {
    let line = said.lines().find(|line| line.contains("refs:"))?;
    line.rsplit(':').next()?.trim().replace(',', "").parse().ok()
}

/// Runs as it is counted: `run CASE WHO STEPS`.
///
/// # Errors
/// Where there is no such case, and those of the run.
pub(crate) fn run(cases: &[&Case], arguments: &[String]) -> Result<(), Failure> {
    let [name, who, steps] = arguments else { return Err("run CASE ours|plain STEPS".into()) };
    let case = cases.iter().find(|case| case.name == *name).ok_or("there is no such case")?;
    let who = if *who == Who::Ours.name() { Who::Ours } else { Who::Plain };
    let mut run = who.start(case, case.edges[1])?;
    for _ in 0..steps.parse()? {
        run.step()?;
    }
    Ok(())
}
