//! Runs benchmarks and records the measurements in `docs/benchmarks.md`: `cargo xtask bench [NAME]... --record`.

use std::path::Path;
use std::process::{Command, ExitCode};

use benches::page::{PAGE, file_of, render};
use benches::record::{
    RecordError, Recorded, TABLES, TARGETS, Tables, measured, read, write, write_text,
};
use benches::workspace;
use scene_runs::machine::{self, Machine};
use sde_integrators::SimdLevel;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let end = arguments.iter().position(|argument| argument == "--").unwrap_or(arguments.len());
    let (names, criterion) = arguments.split_at(end);
    match record(names, criterion) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("error: {error}\n"));
            ExitCode::FAILURE
        }
    }
}

fn record(names: &[String], criterion: &[String]) -> Result<(), RecordError> {
    if let Some(name) = names.iter().find(|name| !TARGETS.contains(&name.as_str())) {
        return Err(RecordError::NoTarget { name: name.clone() });
    }
    let files = machine::uncommitted().ok_or(RecordError::NoCommit)?;
    if !files.is_empty() {
        return Err(RecordError::Uncommitted { files });
    }
    let root = workspace();
    for target in TARGETS {
        if names.is_empty() || names.iter().any(|name| name == target) {
            let recorded = run(&root, target, criterion)?;
            write(&root.join(file_of(target)), &recorded)?;
            write_text(&root.join(PAGE), &render(&root)?)?;
            say(&format!("recorded {target} in {PAGE}\n"));
        }
    }
    Ok(())
}

/// Runs a target into a separate folder, so that no result of an earlier run is recorded.
fn run(root: &Path, target: &str, criterion: &[String]) -> Result<Recorded, RecordError> {
    let folder = root.join("target/bench-record").join(target);
    let tables = folder.join("tables.json");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)
            .map_err(|source| RecordError::File { path: folder.clone(), source })?;
    }
    let failed = || RecordError::Failed { name: target.to_owned() };
    let command = || {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.current_dir(root).args([
            "bench",
            "--package",
            "benches",
            "--features=rivals",
            "--bench",
            target,
        ]);
        cargo
    };
    // Built first, so that the build does not load the machine during the benchmark.
    let built = command().arg("--no-run").status();
    if !built.is_ok_and(|status| status.success()) {
        return Err(failed());
    }
    let before = Machine::read();
    let status =
        command().args(criterion).env("CRITERION_HOME", &folder).env(TABLES, &tables).status();
    if !status.is_ok_and(|status| status.success()) {
        return Err(failed());
    }
    let load = [&before, &Machine::read()].map(|machine| {
        machine.load_average.map_or_else(|| "unknown".to_owned(), |load| format!("{load:.1}"))
    });
    let typed: Vec<&str> = ["cargo xtask bench", target, "--record"]
        .into_iter()
        .chain(criterion.iter().map(String::as_str))
        .collect();
    Ok(Recorded {
        target: target.to_owned(),
        command: typed.join(" "),
        commit: machine::commit().ok_or(RecordError::NoCommit)?,
        date: machine::date(),
        cpu: before.cpu,
        cores: before.cores,
        instruction_set: SimdLevel::best().to_string(),
        load,
        tables: read::<Option<Tables>>(&tables)?.unwrap_or_default(),
        measured: measured(&folder)?,
    })
}

fn say(line: &str) {
    use std::io::Write;
    // Without stderr the exit code still reports the error.
    let _ = std::io::stderr().write_all(line.as_bytes());
}
