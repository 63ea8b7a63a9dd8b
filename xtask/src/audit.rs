//! `cargo xtask audit`: checks whose tools need not be there.
//!
//! What every change must pass is in `.ci/run`. These checks take longer or need more than the Rust toolchain; one whose tool
//! is absent is skipped, and the table at the end says so.

mod claims;
mod surroundings;

use std::fmt::Write as _;
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use crate::{USAGE, cargo, print, run_package, say, workspace};
use surroundings::Surroundings;

const HELP: &str = "\
Checks whose tools need not be there; one that cannot run is skipped with its reason.

Usage: cargo xtask audit [NAME]... [--list]
       cargo xtask audit claims [--only MUTANT]... [--crate NAME]... [--list] [--record]
       cargo xtask audit errors [--runs N] [--seed S] [--method NAME]... [--family NAME]... [--each]

  NAME      run only these checks
  --list    list the checks
  claims    alone and first, takes arguments of its own: `audit claims --help`
  errors    the same: `audit errors --help`

The exit code is 1 if a check failed; a skipped one has not failed.
";

/// The oldest Rust that the workspace names.
const RUST_VERSION: &str = env!("CARGO_PKG_RUST_VERSION");

/// One check.
struct Check {
    name: &'static str,
    /// What holds if it passes, in a few words.
    purpose: &'static str,
    programs: Programs,
}

/// The programs of a check, which are run one after the other; the first that fails ends it.
///
/// A program is a line of words. One of cargo whose subcommand is not installed is skipped.
enum Programs {
    Lines(&'static [&'static str]),
    /// One line, completed by `--package` with each crate that is published.
    OfCrates(&'static str),
    /// What depends on the surroundings, or why there is nothing to run.
    Found(fn(&Surroundings) -> Result<Vec<String>, String>),
}

use Programs::{Found, Lines, OfCrates};

const fn check(name: &'static str, purpose: &'static str, programs: Programs) -> Check {
    Check { name, purpose, programs }
}

const CHECKS: [Check; 14] = [
    check(
        "language",
        "pages, comments and messages use the field's words, short sentences, short lines",
        // One of the tests of this package, so that `.ci/run` holds it too.
        Lines(&["cargo test --package xtask --test tree language"]),
    ),
    check(
        "deny",
        "licences, sources, bans and advisories of all dependencies",
        Lines(&["cargo deny check"]),
    ),
    check(
        "features",
        "each crate compiles with every set of its features",
        // MPI need not be there.
        OfCrates("cargo hack check --feature-powerset --exclude-features mpi --no-dev-deps"),
    ),
    check(
        "semver",
        "versions admit the change of interfaces since the last release",
        Found(|surroundings| match surroundings.release_tags.lines().next() {
            Some(tag) => Ok(vec![format!("cargo semver-checks --workspace --baseline-rev {tag}")]),
            None => Err("no tag v* of a release to compare with".to_owned()),
        }),
    ),
    check(
        "coverage",
        "lines and regions of the crates that their tests reach",
        OfCrates("cargo llvm-cov --summary-only"),
    ),
    check(
        "mutants",
        "tests of the small crates notice changed code",
        // The crates whose tests are quick: a mutant costs a build and a run of them.
        Lines(&[
            "cargo mutants --output target --package smoothing-kernels --package particle-store",
        ]),
    ),
    check(
        "claims",
        "the claims of a crate notice one wrong constant or sign in it",
        Lines(&["cargo xtask audit claims"]),
    ),
    check(
        "errors",
        "on scenes drawn at random with known answers the truth lies within the errors that are stated",
        Lines(&["cargo xtask audit errors --runs 1000"]),
    ),
    check(
        "any-input",
        "a million inputs of each kind make no solver or reader panic, hang or eat memory",
        Lines(&["cargo --config env.PROPTEST_CASES='1000000' test --release --test any_input"]),
    ),
    check(
        "resume",
        "runs killed 52 times resume with bitwise identical results",
        Lines(&["cargo xtask verify run/resume --full"]),
    ),
    check(
        "fuzz",
        "inputs that seek new paths in the code make no solver or reader panic, hang or eat memory",
        Found(|surroundings| {
            Ok(surroundings.fuzz_targets.iter().map(|target| fuzz(target)).collect())
        }),
    ),
    check(
        "rivals",
        "benchmarks against crates that only they need are free of warnings and run",
        // What `.ci/run` does with the other benchmarks.
        Lines(&[
            "cargo clippy --workspace --all-targets --features benches/rivals -- -D warnings",
            "cargo test --workspace --features benches/rivals --bench neighbour --bench particles -- --test",
        ]),
    ),
    check(
        "msrv",
        "the workspace compiles with the oldest Rust it names",
        Found(|surroundings| match toolchain(&surroundings.toolchains, RUST_VERSION) {
            Some(name) => Ok(vec![format!(
                "rustup run {name} cargo check --locked --workspace --all-targets"
            )]),
            None => Err(format!("rustup has no toolchain {RUST_VERSION}")),
        }),
    ),
    check(
        "publish",
        "each package is complete and compiles from its archive",
        Lines(&["cargo publish --locked --workspace --dry-run"]),
    ),
];

/// A target of cargo-fuzz, which ends after so many inputs or so many seconds; an input of more than a minute is a hang.
///
/// Without a sanitizer the stable toolchain suffices. Inputs have any length from the first, since a snapshot is one.
fn fuzz(target: &str) -> String {
    format!(
        "cargo fuzz run --fuzz-dir tests/fuzz --sanitizer none {target} \
         -- -runs=1000000 -max_total_time=600 -timeout=60 -len_control=0 -max_len=16384"
    )
}

/// The name of a toolchain of this version, of any patch level, in what `rustup toolchain list` prints.
fn toolchain<'a>(list: &'a str, version: &str) -> Option<&'a str> {
    let is_of_version = |name: &&str| match name.strip_prefix(version) {
        Some(rest) => rest.is_empty() || rest.starts_with(['.', '-']),
        None => false,
    };
    list.lines().filter_map(|line| line.split_whitespace().next()).find(is_of_version)
}

/// How a check ended: with what its program ended if it failed, or why it was not run.
enum Outcome {
    Passed,
    Failed(String),
    Skipped(String),
}

impl Outcome {
    fn words(&self) -> String {
        match self {
            Self::Passed => "passed".to_owned(),
            Self::Failed(how) => format!("failed: {how}"),
            Self::Skipped(reason) => format!("skipped: {reason}"),
        }
    }
}

/// The command line after `audit`.
pub(crate) fn run(arguments: &[String]) -> ExitCode {
    // A list of checks may name them too: with arguments of their own they are commands.
    match arguments.split_first() {
        Some((first, rest)) if first == "claims" => return claims::run(rest),
        Some((first, rest)) if first == "errors" => {
            return run_package("stated-errors", false, rest);
        }
        _ => {}
    }
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        return print(HELP);
    }
    if arguments.iter().any(|argument| argument == "--list") {
        return print(&list());
    }
    let chosen = match choose(arguments) {
        Ok(chosen) => chosen,
        Err(unknown) => {
            say(&format!("error: there is no check `{unknown}`\n\n{}", list()));
            return ExitCode::from(USAGE);
        }
    };
    let surroundings = match Surroundings::look() {
        Ok(surroundings) => surroundings,
        Err(error) => {
            say(&format!("error: cannot list crates, or targets of cargo-fuzz: {error}\n"));
            return ExitCode::FAILURE;
        }
    };
    let (mut table, mut has_failed) = (String::new(), false);
    for check in chosen {
        let started = Instant::now();
        let outcome = carry_out(check, &surroundings);
        has_failed |= matches!(outcome, Outcome::Failed(_));
        let seconds = started.elapsed().as_secs_f64();
        let _ = writeln!(table, "{:<10}{seconds:>8.1} s  {}", check.name, outcome.words());
    }
    let shown = print(&format!("\n{table}"));
    if has_failed { ExitCode::FAILURE } else { shown }
}

/// The checks of these names in the order of the table, or all without a name; an error is the first unknown name.
fn choose(names: &[String]) -> Result<Vec<&'static Check>, &str> {
    let known = |name: &str| CHECKS.iter().any(|check| check.name == name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        return Err(unknown);
    }
    let chosen = |check: &&Check| names.is_empty() || names.iter().any(|name| name == check.name);
    Ok(CHECKS.iter().filter(chosen).collect())
}

fn list() -> String {
    let line = |check: &Check| format!("{:<10}{}\n", check.name, check.purpose);
    CHECKS.iter().map(line).collect()
}

fn carry_out(check: &Check, surroundings: &Surroundings) -> Outcome {
    let lines = match check.programs {
        Lines(lines) => Ok(lines.iter().map(|&line| line.to_owned()).collect()),
        OfCrates(line) => {
            let packages = surroundings.crates.iter().map(|name| format!(" --package {name}"));
            Ok(vec![format!("{line}{}", packages.collect::<String>())])
        }
        Found(programs) => programs(surroundings),
    };
    let outcome = match lines {
        Err(reason) => Outcome::Skipped(reason),
        Ok(lines) => lines
            .iter()
            .map(|line| start(check.name, line))
            .find(|outcome| !matches!(outcome, Outcome::Passed))
            .unwrap_or(Outcome::Passed),
    };
    if let Outcome::Skipped(reason) = &outcome {
        say(&format!("== {}: skipped, {reason}\n", check.name));
    }
    outcome
}

/// Whether cargo has no such subcommand.
fn is_missing(tool: &str) -> bool {
    let mut version = cargo();
    version.args([tool, "--version"]).stdout(Stdio::null()).stderr(Stdio::null());
    !version.status().is_ok_and(|status| status.success())
}

fn start(name: &str, line: &str) -> Outcome {
    const INSTALLED_APART: [&str; 6] =
        ["deny", "hack", "semver-checks", "llvm-cov", "mutants", "fuzz"];
    let words: Vec<&str> = line.split_whitespace().collect();
    let (mut command, arguments) = match words[..] {
        ["cargo", tool, ..] if INSTALLED_APART.contains(&tool) && is_missing(tool) => {
            return Outcome::Skipped(format!("cargo-{tool} is not installed"));
        }
        ["cargo", ref arguments @ ..] => (cargo(), arguments),
        [program, ref arguments @ ..] => (Command::new(program), arguments),
        [] => return Outcome::Failed("nothing to start".to_owned()),
    };
    say(&format!("== {name}: {line}\n"));
    match command.args(arguments).current_dir(workspace()).status() {
        Ok(status) if status.success() => Outcome::Passed,
        Ok(status) => Outcome::Failed(status.to_string()),
        Err(error) => Outcome::Failed(format!("cannot start {}: {error}", words[0])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_checks_run_in_the_order_of_the_table_and_an_unknown_one_is_named() {
        let names = |words: &[&'static str]| {
            let words: Vec<String> = words.iter().map(|&word| word.to_owned()).collect();
            let chosen = choose(&words).map_err(str::to_owned);
            chosen.map(|chosen| chosen.iter().map(|check| check.name).collect::<Vec<_>>())
        };
        assert_eq!(names(&[]).map(|chosen| chosen.len()), Ok(CHECKS.len()));
        assert_eq!(names(&["publish", "deny"]), Ok(vec!["deny", "publish"]));
        assert_eq!(names(&["deny", "denny"]), Err("denny".to_owned()));
    }

    #[test]
    fn a_check_without_its_tool_or_its_toolchain_is_skipped_with_the_reason() {
        let nothing = Surroundings {
            crates: Vec::new(),
            fuzz_targets: Vec::new(),
            toolchains: String::new(),
            release_tags: String::new(),
        };
        for (name, reason) in [("msrv", RUST_VERSION), ("semver", "no tag")] {
            let [check] = choose(&[name.to_owned()]).unwrap()[..] else { panic!("not one") };
            let outcome = carry_out(check, &nothing).words();
            assert!(outcome.contains("skipped") && outcome.contains(reason), "{outcome}");
        }
        assert!(is_missing("no-such-subcommand-of-cargo"));
    }

    #[test]
    fn the_oldest_rust_is_found_at_any_patch_level_and_by_no_other_number() {
        let list = "stable-x86_64-unknown-linux-gnu (active, default)\n\
                    1.890.0-x86_64-unknown-linux-gnu\n1.89.1-x86_64-unknown-linux-gnu\n";
        assert_eq!(toolchain(list, "1.89"), Some("1.89.1-x86_64-unknown-linux-gnu"));
        assert_eq!(toolchain("1.89-x86_64-apple-darwin", "1.89"), Some("1.89-x86_64-apple-darwin"));
        assert_eq!(toolchain(list, "1.8"), None);
        assert_eq!(toolchain("", "1.89"), None);
    }
}
