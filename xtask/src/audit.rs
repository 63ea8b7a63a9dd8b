//! `cargo xtask audit`: checks whose tools need not be there.
//!
//! What every change must pass is in `.ci/run`. These checks take longer or need more than the Rust toolchain; one whose tool
//! is absent is skipped, and the table at the end says so.

mod claims;
mod plans;
mod surroundings;
mod table;

use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use crate::{USAGE, cargo, print, say, workspace};
use plans::Plan;
use surroundings::Surroundings;
use table::{Outcome, Row};

const HELP: &str = "\
Checks whose tools need not be there; one that cannot run is skipped with its reason.

Usage: cargo xtask audit [NAME]... [--list]
       cargo xtask audit claims [--only MUTANT]... [--crate NAME]... [--list] [--record]

  NAME      run only these checks
  --list    list the checks
  claims    alone and first, takes arguments of its own: `audit claims --help`

The exit code is 1 if a check failed; a skipped one has not failed.
";

/// One check.
struct Check {
    name: &'static str,
    /// What holds if it passes, in a few words.
    purpose: &'static str,
    /// The subcommand of cargo that must be installed.
    tool: Option<&'static str>,
    plan: fn(&Surroundings) -> Plan,
}

const CHECKS: [Check; 13] = [
    Check {
        name: "language",
        purpose: "pages, comments and messages use the field's words, short sentences, short lines",
        tool: None,
        plan: plans::language,
    },
    Check {
        name: "deny",
        purpose: "licences, sources, bans and advisories of all dependencies",
        tool: Some("deny"),
        plan: plans::deny,
    },
    Check {
        name: "features",
        purpose: "each crate compiles with every set of its features",
        tool: Some("hack"),
        plan: plans::features,
    },
    Check {
        name: "semver",
        purpose: "versions admit the change of interfaces since the last release",
        tool: Some("semver-checks"),
        plan: plans::semver,
    },
    Check {
        name: "coverage",
        purpose: "lines and regions of the crates that their tests reach",
        tool: Some("llvm-cov"),
        plan: plans::coverage,
    },
    Check {
        name: "mutants",
        purpose: "tests of the small crates notice changed code",
        tool: Some("mutants"),
        plan: plans::mutants,
    },
    Check {
        name: "claims",
        purpose: "the claims of a crate notice one wrong constant or sign in it",
        tool: None,
        plan: plans::claims,
    },
    Check {
        name: "any-input",
        purpose: "a million inputs of each kind make no solver or reader panic, hang or eat memory",
        tool: None,
        plan: plans::any_input,
    },
    Check {
        name: "resume",
        purpose: "runs killed 52 times resume with bitwise identical results",
        tool: None,
        plan: plans::resume,
    },
    Check {
        name: "fuzz",
        purpose: "inputs that seek new paths in the code make no solver or reader panic, hang or eat memory",
        tool: Some("fuzz"),
        plan: plans::fuzz,
    },
    Check {
        name: "rivals",
        purpose: "benchmarks against crates that only they need are free of warnings and run",
        tool: None,
        plan: plans::rivals,
    },
    Check {
        name: "msrv",
        purpose: "the workspace compiles with the oldest Rust it names",
        tool: None,
        plan: plans::msrv,
    },
    Check {
        name: "publish",
        purpose: "each package is complete and compiles from its archive",
        tool: None,
        plan: plans::publish,
    },
];

/// The command line after `audit`.
pub(crate) fn run(arguments: &[String]) -> ExitCode {
    if let Some((first, rest)) = arguments.split_first()
        && first == "claims"
    {
        return claims::run(rest);
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
    let rows: Vec<Row> = chosen.iter().map(|check| carry_out(check, &surroundings)).collect();
    let shown = print(&format!("\n{}", table::text(&rows)));
    if rows.iter().any(|row| matches!(row.outcome, Outcome::Failed(_))) {
        ExitCode::FAILURE
    } else {
        shown
    }
}

/// The checks of these names, in the order of the table; all without a name. The first unknown name otherwise.
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
    CHECKS.iter().map(line).collect::<Vec<_>>().concat()
}

fn carry_out(check: &Check, surroundings: &Surroundings) -> Row {
    let started = Instant::now();
    let outcome = match (check.plan)(surroundings) {
        Plan::Skip(reason) => Outcome::Skipped(reason),
        Plan::Start(_) if check.tool.is_some_and(is_missing) => {
            Outcome::Skipped(format!("cargo-{} is not installed", check.tool.unwrap_or_default()))
        }
        Plan::Start(programs) => programs
            .iter()
            .map(|words| start(check.name, words))
            .find(|outcome| !matches!(outcome, Outcome::Passed))
            .unwrap_or(Outcome::Passed),
    };
    if let Outcome::Skipped(reason) = &outcome {
        say(&format!("== {}: skipped, {reason}\n", check.name));
    }
    Row { check: check.name, outcome, seconds: started.elapsed().as_secs_f64() }
}

/// Whether cargo has no such subcommand.
fn is_missing(tool: &str) -> bool {
    let mut version = cargo();
    version.args([tool, "--version"]).stdout(Stdio::null()).stderr(Stdio::null());
    !version.status().is_ok_and(|status| status.success())
}

fn start(name: &str, words: &[String]) -> Outcome {
    say(&format!("== {name}: {}\n", words.join(" ")));
    let (mut command, arguments) = match words.split_first() {
        Some((program, arguments)) if program == "cargo" => (cargo(), arguments),
        Some((program, arguments)) => (Command::new(program), arguments),
        None => return Outcome::Failed("nothing to start".to_owned()),
    };
    match command.args(arguments).current_dir(workspace()).status() {
        Ok(status) if status.success() => Outcome::Passed,
        Ok(status) => Outcome::Failed(status.to_string()),
        Err(error) => Outcome::Failed(format!("cannot start {}: {error}", words[0])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(chosen: &[&Check]) -> Vec<&'static str> {
        chosen.iter().map(|check| check.name).collect()
    }

    #[test]
    fn without_a_name_all_checks_are_chosen() {
        let all = choose(&[]).map(|chosen| chosen.len());
        assert_eq!(all, Ok(CHECKS.len()));
    }

    #[test]
    fn named_checks_run_in_the_order_of_the_table() {
        let words = ["publish".to_owned(), "deny".to_owned()];
        let chosen = choose(&words).map(|chosen| names(&chosen));
        assert_eq!(chosen, Ok(vec!["deny", "publish"]));
    }

    #[test]
    fn an_unknown_check_is_named() {
        let words = ["deny".to_owned(), "denny".to_owned()];
        assert_eq!(choose(&words).map(|chosen| names(&chosen)), Err("denny"));
    }

    #[test]
    fn no_two_checks_have_one_name() {
        let mut all: Vec<_> = CHECKS.iter().map(|check| check.name).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), CHECKS.len());
    }

    #[test]
    fn the_list_has_a_line_for_each_check() {
        assert_eq!(list().lines().count(), CHECKS.len());
    }

    #[test]
    fn a_subcommand_that_cargo_lacks_is_missing() {
        assert!(is_missing("no-such-subcommand-of-cargo"));
    }
}
