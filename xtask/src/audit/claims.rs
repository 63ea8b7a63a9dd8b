//! `cargo xtask audit claims`: physical mutants, judged by the claims of the proof and by the tests of crates.
//!
//! A mutant of `mutants.json` replaces one constant or sign, in a git worktree of its own below `target/mutants`. It is caught if a
//! test of a package under its key `test` fails, or a claim of accuracy of a case under its key `verify` (where the mutant breaks a
//! structure, also a structural claim). cargo-mutants makes mutants from syntax; these break a formula that a reader can name.

mod mutant;
mod page;
mod proof;

use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use crate::{USAGE, print, say, workspace};
use mutant::Mutant;
use page::{Outcome, Outcomes};
use proof::Proof;

const HELP: &str = "\
Builds the workspace with one constant or sign wrong at a time, then runs the tests and cases that have to notice.

Usage: cargo xtask audit claims [--only NAME]... [--crate NAME]... [--missing] [--list] [--record]

  --only NAME    run this mutant
  --crate NAME   run the mutants of this crate
  --missing      of these, run those without an outcome, or whose source or cases changed since
  --list         list the mutants
  --record       write docs/mutants.md and docs/mutants.json too, from all outcomes so far

Needs git and `timeout` (coreutils). Tracked files, changes included, are checked out into target/mutants,
which also holds the outcomes. The exit code is 1 if a mutant survived, did not compile or did not end.
";

#[derive(Debug, Default, PartialEq)]
struct Options {
    names: Vec<String>,
    crates: Vec<String>,
    is_missing: bool,
    is_list: bool,
    is_record: bool,
}

/// The command line after `audit claims`.
pub(super) fn run(arguments: &[String]) -> ExitCode {
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        return print(HELP);
    }
    let parsed = mutant::all().and_then(|all| {
        let options = options(arguments)?;
        Ok((choose(&all, &options)?, options, all))
    });
    let (chosen, options, all) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => {
            say(&format!("error: {error}\n"));
            return ExitCode::from(USAGE);
        }
    };
    if options.is_list {
        return print(&page::list(&chosen));
    }
    match audit(&chosen, &all, &options) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            say(&format!("error: {error}\n"));
            ExitCode::FAILURE
        }
    }
}

fn options(arguments: &[String]) -> Result<Options, String> {
    let mut options = Options::default();
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let mut value = || rest.next().cloned().ok_or(format!("{argument} needs a name"));
        match argument.as_str() {
            "--only" => options.names.push(value()?),
            "--crate" => options.crates.push(value()?),
            "--missing" => options.is_missing = true,
            "--list" => options.is_list = true,
            "--record" => options.is_record = true,
            other => return Err(format!("`audit claims` has no argument `{other}`\n\n{HELP}")),
        }
    }
    Ok(options)
}

/// The mutants of these names and crates; all without either.
fn choose(all: &[Mutant], options: &Options) -> Result<Vec<Mutant>, String> {
    let Options { names, crates, .. } = options;
    let unknown_name = names.iter().find(|name| all.iter().all(|m| m.name != **name));
    let unknown_crate = crates.iter().find(|name| all.iter().all(|m| m.package != **name));
    if let Some(unknown) = unknown_name.or(unknown_crate) {
        return Err(format!("no mutant has the name or crate `{unknown}`; `--list` lists all"));
    }
    let is_chosen = |mutant: &&Mutant| {
        names.is_empty() && crates.is_empty()
            || names.contains(&mutant.name)
            || crates.contains(&mutant.package)
    };
    Ok(all.iter().filter(is_chosen).cloned().collect())
}

/// Runs these mutants and writes their outcomes; whether all were caught.
fn audit(chosen: &[Mutant], all: &[Mutant], options: &Options) -> Result<bool, String> {
    let (root, folder) = (workspace(), workspace().join("target/mutants"));
    let (recorded, recent) = (root.join("docs/mutants.json"), folder.join("outcomes.json"));
    let mut outcomes = Outcomes::read(&[&recorded, &recent], mutant::hashes(&root, all)?);
    let is_due = |mutant: &&Mutant| !options.is_missing || !outcomes.is_current(mutant);
    let due: Vec<Mutant> = chosen.iter().filter(is_due).cloned().collect();
    if !due.is_empty() {
        let (tree, commit) = (folder.join("tree"), check_out(&root, &folder.join("tree"))?);
        say("building and running the tree without a mutant ...\n");
        let proof = Proof::prepare(tree, folder.join("build"), &due)?;
        for (k, mutant) in due.iter().enumerate() {
            let started = Instant::now();
            let verdict = judge(mutant, &proof)?;
            let seconds = started.elapsed().as_secs_f64();
            let outcome = Outcome { commit: commit.clone(), verdict, seconds };
            say(&format!("[{}/{}] {}: {}\n", k + 1, due.len(), mutant.name, outcome.words()));
            outcomes.insert(mutant, outcome);
            // After each mutant, so that an interrupted audit loses one at most.
            outcomes.write(&recent)?;
        }
    }
    print(&format!("\n{}", page::table(chosen, &outcomes)));
    if options.is_record {
        let path = root.join("docs/mutants.md");
        std::fs::write(&path, page::render(all, &outcomes))
            .map_err(|error| format!("{}: {error}", path.display()))?;
        outcomes.write(&recorded)?;
    }
    let n_caught = chosen.iter().filter(|mutant| outcomes.is_caught(mutant)).count();
    say(&format!("{n_caught} of {} mutants caught ({} in all)\n", chosen.len(), all.len()));
    Ok(n_caught == chosen.len())
}

/// Applies a mutant, runs what has to catch it, and puts the file back.
fn judge(mutant: &Mutant, proof: &Proof) -> Result<page::Verdict, String> {
    let path = proof.tree.join(&mutant.file);
    let error = |error: std::io::Error| format!("{}: {error}", path.display());
    let original = std::fs::read_to_string(&path).map_err(error)?;
    std::fs::write(&path, mutant.applied(&original)?).map_err(error)?;
    let verdict = proof.judge(mutant);
    std::fs::write(&path, original).map_err(error)?;
    verdict
}

/// Checks the tracked files out into a worktree, with their changes; returns the commit, `-dirty` appended if there are any.
fn check_out(root: &Path, tree: &Path) -> Result<String, String> {
    let head = git(root, &["rev-parse", "--short=12", "HEAD"])?;
    // A commit of the changes that is on no branch; nothing without changes.
    let changed = git(root, &["stash", "create"])?;
    let commit = if changed.is_empty() { &head } else { &changed };
    if tree.join(".git").exists() {
        git(tree, &["checkout", "--quiet", "--force", "--detach", commit])?;
    } else {
        let path = tree.to_string_lossy();
        git(root, &["worktree", "add", "--quiet", "--force", "--detach", &path, commit])?;
    }
    Ok(if changed.is_empty() { head } else { format!("{head}-dirty") })
}

fn git(folder: &Path, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new("git").args(arguments).current_dir(folder).output();
    let output = output.map_err(|error| format!("cannot start git: {error}"))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned());
    }
    Err(format!("git {}: {}", arguments.join(" "), String::from_utf8_lossy(&output.stderr)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn mutants_are_chosen_by_name_and_by_crate() {
        let all = mutant::all().unwrap();
        let chosen = |text: &str| choose(&all, &options(&words(text)).unwrap());
        assert_eq!(chosen("").unwrap().len(), all.len());
        let named = chosen("--only fpk-div-d --crate smpm").unwrap();
        assert!(named.iter().all(|m| m.name == "fpk-div-d" || m.package == "smpm"));
        assert!(named.iter().any(|m| m.name == "fpk-div-d") && named.len() > 1);
        assert!(chosen("--only nothing").unwrap_err().contains("nothing"));
        assert!(chosen("--crate nothing").unwrap_err().contains("nothing"));
    }

    #[test]
    fn arguments_that_mean_nothing_are_named() {
        assert!(options(&words("--only")).unwrap_err().contains("--only"));
        assert!(options(&words("--onyl x")).unwrap_err().contains("--onyl"));
    }
}
