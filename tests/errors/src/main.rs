//! The `stated-errors` command.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use scenes::causes::with_causes;
use serde_json::json;
use stated_errors::{Hunt, Outcome, Tally, Verdict, hunt, judged, known, page};

/// Draws scenes with known answers at random, runs them, and says how often the truth lies within the stated errors
#[derive(Debug, Parser)]
#[command(name = "stated-errors", bin_name = "cargo xtask audit errors", version)]
struct Cli {
    /// Number of scenes
    #[arg(long, default_value_t = 300)]
    runs: u64,
    /// Seed of all scenes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of the first scene
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Draw from this family alone
    #[arg(long)]
    family: Vec<String>,
    /// Run scenes of this method alone
    #[arg(long)]
    method: Vec<String>,
    /// Longest run (s)
    #[arg(long, default_value_t = 60.0)]
    longest: f64,
    /// Run this scene of a known answer instead
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Print a line for each scene
    #[arg(long)]
    each: bool,
    /// Write what was found to docs/errors.md
    #[arg(long)]
    record: bool,
    /// Where scenes with a false error go [default: target/errors]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    match execute(Cli::parse(), &mut io::stdout()) {
        Ok(code) => code,
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn execute(cli: Cli, output: &mut dyn Write) -> io::Result<ExitCode> {
    let out = cli.out.unwrap_or_else(|| PathBuf::from("target/errors"));
    let asked = Hunt {
        runs: cli.runs,
        seed: cli.seed,
        first: cli.first,
        families: cli.family,
        methods: cli.method,
        longest: Duration::from_secs_f64(cli.longest),
        threads: std::thread::available_parallelism().map_or(1, usize::from),
    };
    if let Some(path) = cli.scene {
        return replayed(&path, asked.longest, output);
    }
    let (mut failure, each, seed) = (None, cli.each, cli.seed);
    let outcomes = hunt(&asked, &mut |outcome| {
        let done = written(outcome, seed, &out, each.then_some(&mut io::stdout()));
        failure = failure.take().or(done.err());
    });
    failure.map_or(Ok(()), Err)?;
    let tally = Tally::of(&outcomes);
    writeln!(output, "{tally}")?;
    if cli.record {
        std::fs::write("docs/errors.md", page(&asked, &outcomes, &tally))?;
    }
    let is_sound = tally.all.values().all(|row| row.silent == 0);
    Ok(if is_sound { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs a scene and prints its numbers beside the truth.
fn replayed(path: &Path, longest: Duration, output: &mut dyn Write) -> io::Result<ExitCode> {
    let scene: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let drawn = known(scene).ok_or_else(|| io::Error::other("no answer of the scene is known"))?;
    let judged = judged(&drawn, longest);
    for verdict in judged.map_err(|error| io::Error::other(with_causes(&error)))? {
        writeln!(output, "{}", words(&verdict))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A number beside its truth.
fn words(verdict: &Verdict) -> String {
    let (id, t) = (&verdict.truth.id, verdict.truth.time.unwrap_or_default());
    let (value, truth) = (verdict.number.value, verdict.truth.value);
    let off = verdict.off().map_or("error unknown".to_owned(), |off| format!("{off:.2} errors"));
    let error = verdict.number.error.map_or(String::new(), |error| format!(" +- {error:.1e}"));
    format!("{off}: {id} at {t}: {value:.6e}{error}, true {truth:.6e}")
}

/// Writes a scene whose error is false, with the truth, and a line for it.
fn written(
    outcome: &Outcome,
    seed: u64,
    out: &Path,
    lines: Option<&mut dyn Write>,
) -> io::Result<()> {
    let Outcome { index, drawn, verdicts, seconds } = outcome;
    let worst = verdicts.as_ref().ok().and_then(|all| {
        let off = |v: &Verdict| v.off().unwrap_or_default();
        all.iter().max_by(|a, b| off(a).total_cmp(&off(b)))
    });
    let line = match (verdicts, worst) {
        (Err(error), _) => format!("refused: {error}"),
        (_, None) => "no number with a known truth".to_owned(),
        (_, Some(worst)) => words(worst),
    };
    let hostile = if drawn.is_hostile { "hostile " } else { "" };
    if let Some(lines) = lines {
        writeln!(
            lines,
            "{seed}-{index} {seconds:.1} s {hostile}{} {}: {line}",
            drawn.family.name, drawn.method
        )?;
        lines.flush()?;
    }
    if worst.is_some_and(|worst| worst.off().is_some_and(|off| off > 5.0)) || verdicts.is_err() {
        std::fs::create_dir_all(out)?;
        let mut scene = drawn.scene.clone();
        scene["title"] = json!(line);
        std::fs::write(out.join(format!("{seed}-{index}.json")), format!("{scene:#}\n"))?;
    }
    Ok(())
}
