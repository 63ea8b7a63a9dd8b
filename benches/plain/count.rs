//! Instructions of a step, counted by valgrind: independent of the load of the machine.

use std::process::Command;

use crate::case::{Case, Failure, Who};

/// Steps of the shorter and of the longer run, whose difference excludes the initialisation.
const STEPS: [u32; 2] = [5, 25];

/// The program that counts instructions.
const VALGRIND: &str = "valgrind";

/// Argument that starts a counted run.
pub(crate) const RUN: &str = "run";

/// Version of valgrind, if it is installed.
pub(crate) fn version() -> Option<String> {
    let output = Command::new(VALGRIND).arg("--version").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Instructions per element and step.
///
/// # Errors
/// If the program cannot be started, or prints no count.
pub(crate) fn per_element(case: &Case, who: Who) -> Result<f64, Failure> {
    let n_elements = who.start(case, case.edges[1])?.n_elements();
    let [short, long] = STEPS.map(|steps| total(case, who, steps));
    let steps = f64::from(STEPS[1] - STEPS[0]);
    Ok((long? - short?) / (steps * n_elements as f64))
}

/// Instructions of a complete run.
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

/// The count in the line `==1234== I   refs:      1,234,567`.
fn references(said: &str) -> Option<f64> {
    let line = said.lines().find(|line| line.contains("refs:"))?;
    line.rsplit(':').next()?.trim().replace(',', "").parse().ok()
}

/// Executes a counted run: `run CASE WHO STEPS`.
///
/// # Errors
/// If there is no such case, and errors of the run.
pub(crate) fn run(cases: &[&Case], arguments: &[String]) -> Result<(), Failure> {
    let [name, who, steps] = arguments else { return Err("run CASE `ours|plain` STEPS".into()) };
    let case = cases.iter().find(|case| case.name == *name).ok_or("there is no such case")?;
    let who = if *who == Who::Ours.name() { Who::Ours } else { Who::Plain };
    let mut run = who.start(case, case.edges[1])?;
    for _ in 0..steps.parse()? {
        run.step()?;
    }
    Ok(())
}
