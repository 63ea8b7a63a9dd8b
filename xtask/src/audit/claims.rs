//! `cargo xtask audit claims`: mutation of the solvers, judged by the claims of the proof.
//!
//! The workspace is built with one constant or sign of a crate wrong, and the crate's own cases are run. A mutant is caught if at
//! least one claim of accuracy fails (or, where it breaks a structure, one of structure). Mutants are data, in `mutants.json`; they
//! are applied to a copy of the tree. Those whose cases reach no other mutated crate share a build.

mod mutant;
mod outcome;
mod page;
mod proof;
mod rounds;
mod scratch;
mod subject;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use crate::{USAGE, print, say, workspace};
use mutant::Mutant;
use outcome::{Outcome, Outcomes};
use proof::Proof;
use scratch::Scratch;
use subject::Sources;

const HELP: &str = "\
Builds the workspace with one constant or sign wrong at a time and runs the cases of the crate.

Usage: cargo xtask audit claims [--only NAME]... [--crate NAME]... [--missing] [--list] [--record] [--kept]

  --only NAME    run this mutant
  --crate NAME   run the mutants of this crate
  --missing      of these, run those without an outcome, or whose source or cases changed since
  --list         list the mutants
  --record       write docs/mutants.md and docs/mutants.json too, from all outcomes that were kept
  --kept         run nothing: print, or record, the outcomes that were kept

The tree is copied to target/mutants, where outcomes are kept as well. They are merged with those of
docs/mutants.json. The exit code is 1 if a mutant survived, did not compile or did not end.
";

/// The command line.
#[derive(Debug, Default, PartialEq)]
struct Options {
    names: Vec<String>,
    crates: Vec<String>,
    run: Run,
    is_record: bool,
}

/// Which of the chosen mutants to run.
#[derive(Debug, Default, PartialEq)]
enum Run {
    #[default]
    All,
    /// Those without an outcome that is up to date.
    Missing,
    /// None: outcomes that were kept.
    Kept,
    /// None: a list.
    List,
}

/// The command line after `audit claims`.
pub(super) fn run(arguments: &[String]) -> ExitCode {
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        return print(HELP);
    }
    let parsed = mutant::all().and_then(|all| {
        let options = options(arguments)?;
        let chosen = choose(&all, &options)?;
        Ok((options, chosen, all))
    });
    let (options, chosen, all) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => {
            say(&format!("error: {error}\n"));
            return ExitCode::from(USAGE);
        }
    };
    if options.run == Run::List {
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
            "--missing" => options.run = Run::Missing,
            "--list" => options.run = Run::List,
            "--record" => options.is_record = true,
            "--kept" => options.run = Run::Kept,
            other => return Err(format!("`audit claims` has no argument `{other}`\n\n{HELP}")),
        }
    }
    Ok(options)
}

/// The mutants of these names and crates; all without either.
fn choose(all: &[Mutant], options: &Options) -> Result<Vec<Mutant>, String> {
    let Options { names, crates, .. } = options;
    if let Some(unknown) = names.iter().find(|name| all.iter().all(|m| m.name != **name)) {
        return Err(format!("there is no mutant `{unknown}`; `audit claims --list` lists them"));
    }
    if let Some(unknown) = crates.iter().find(|name| all.iter().all(|m| m.package != **name)) {
        return Err(format!(
            "no mutant is of a crate `{unknown}`; `audit claims --list` lists them"
        ));
    }
    let is_chosen = |mutant: &&Mutant| {
        names.is_empty() && crates.is_empty()
            || names.contains(&mutant.name)
            || crates.contains(&mutant.package)
    };
    Ok(all.iter().filter(is_chosen).cloned().collect())
}

/// Runs these mutants, or takes what was kept of them; whether all were caught.
fn audit(chosen: &[Mutant], all: &[Mutant], options: &Options) -> Result<bool, String> {
    let root = workspace();
    let folder = root.join("target").join("mutants");
    let (recorded, recent) = (root.join("docs/mutants.json"), folder.join("outcomes.json"));
    let sources = Sources::read(&root, all)?;
    let hashes = all.iter().map(|mutant| (mutant.name.clone(), sources.hash(mutant))).collect();
    let mut outcomes = Outcomes::read(&[&recorded, &recent], hashes);
    if options.run != Run::Kept {
        let is_due = |mutant: &&Mutant| options.run == Run::All || outcomes.of(mutant).is_none();
        let due: Vec<Mutant> = chosen.iter().filter(is_due).cloned().collect();
        run_rounds(&due, &folder, &mut outcomes)?;
    }
    print(&format!("\n{}", page::table(chosen, &outcomes)));
    if options.is_record {
        let text = page::render(all, &outcomes, &scratch::machine());
        let path = root.join("docs/mutants.md");
        std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        outcomes.write(&recorded)?;
    }
    let n_caught = chosen.iter().filter(|mutant| outcomes.is_caught(mutant)).count();
    say(&format!("{n_caught} of {} mutants caught ({} in all)\n", chosen.len(), all.len()));
    Ok(n_caught == chosen.len())
}

/// Outcomes are written after each round, so that an audit that is interrupted keeps them.
fn run_rounds(chosen: &[Mutant], folder: &Path, outcomes: &mut Outcomes) -> Result<(), String> {
    if chosen.is_empty() {
        return Ok(());
    }
    let scratch = Scratch::copy(&workspace(), &folder.join("tree"))?;
    let commit = scratch::commit(&workspace());
    let proof = Proof { tree: scratch.root().to_owned(), target: build_folder(folder) };
    say("building and proving the tree without a mutant ...\n");
    let limit = proof.check_unchanged(chosen)?;
    let reaches = rounds::reaches(scratch.root())?;
    let rounds = rounds::rounds(chosen, &reaches);
    for (k, round) in rounds.iter().enumerate() {
        let names: Vec<&str> = round.iter().map(|mutant| mutant.name.as_str()).collect();
        say(&format!("[{}/{}] {}\n", k + 1, rounds.len(), names.join(", ")));
        for (mutant, outcome) in carry_out(round, &scratch, &proof, limit)? {
            say(&format!("    {}: {}\n", mutant.name, outcome.words()));
            outcomes.keep(mutant, commit.clone(), outcome);
        }
        outcomes.write(&folder.join("outcomes.json"))?;
    }
    Ok(())
}

/// Builds and proves a round; if its mutants do not compile together, each by itself.
fn carry_out<'a>(
    round: &[&'a Mutant],
    scratch: &Scratch,
    proof: &Proof,
    limit: f64,
) -> Result<Vec<(&'a Mutant, Outcome)>, String> {
    let started = Instant::now();
    let originals = scratch.apply(round)?;
    let built = proof.build();
    let result = match &built {
        Ok(()) => proof.judge(round, limit),
        Err(error) if round.len() == 1 => Ok(vec![Outcome::not_compiled(error)]),
        Err(_) => Ok(Vec::new()),
    };
    scratch::restore(&originals)?;
    let outcomes = result?;
    if outcomes.is_empty() {
        let alone = round.iter().map(|&mutant| carry_out(&[mutant], scratch, proof, limit));
        return Ok(alone.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect());
    }
    let seconds = started.elapsed().as_secs_f64() / round.len() as f64;
    let timed = outcomes.into_iter().map(|outcome| Outcome { seconds, ..outcome });
    Ok(round.iter().copied().zip(timed).collect())
}

/// Where mutants are built: of a folder of its own, since their profile is.
fn build_folder(folder: &Path) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    target.map_or_else(|| folder.join("build"), |target| target.join("mutants"))
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
