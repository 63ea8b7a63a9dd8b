//! Printed form of the advice.

use std::io::Write;

use result_figures::markdown;
use result_figures::number::{percent, short};
use serde_json::Value;

use super::{Advice, AdviseError, Candidate, Unreached};
use crate::ladder::{Outcome, Trial};

/// Prints the trials, the cheapest methods, and the keys to write into the scene.
///
/// # Errors
/// [`AdviseError::Write`].
pub fn print(advice: &Advice, output: &mut dyn Write) -> Result<(), AdviseError> {
    let blocks = [tried(advice), cheapest(advice), verdict_words(advice)];
    let text = blocks.join("\n");
    writeln!(output, "{}", text.trim_end()).map_err(AdviseError::Write)
}

fn heads(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

/// What the error of a trial is.
pub(super) const ERRORS: &str = "Errors are relative; those of covariances are relative to the deviations. An error is the run's own \
     estimate, two standard errors of sampled values, or the deviation from other trials; for sampled trials a deviation beyond four \
     standard errors.";

fn tried(advice: &Advice) -> String {
    format!("{}\n{}", table(tried_rows(advice)), notes(advice))
}

fn table((heads, rows): (Vec<String>, Vec<Vec<String>>)) -> String {
    let rows: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|cell| markdown::text(cell)).collect()).collect();
    markdown::table(&heads, &rows)
}

/// The trials with their costs and errors: heads and rows.
pub(super) fn tried_rows(advice: &Advice) -> (Vec<String>, Vec<Vec<String>>) {
    let row = |trial: &Trial| {
        let method = advice.ladder.methods[trial.method].name.clone();
        let mut row = vec![method, trial.rung.label.clone()];
        match &trial.outcome {
            Outcome::Failed { reason, cpu_seconds } => {
                row.extend([
                    short(Some(*cpu_seconds)),
                    String::new(),
                    format!("ended: {reason}"),
                    String::new(),
                ]);
            }
            Outcome::Answered(answers) => {
                let worst = worst(advice, trial);
                row.push(short(Some(answers.cpu_seconds)));
                row.push(n_within(advice, trial));
                row.push(worst.as_ref().map_or_else(String::new, |(error, _)| percent(*error)));
                row.push(worst.map_or_else(String::new, |(_, words)| words));
            }
        }
        row
    };
    let within = format!("within {}", percent(advice.options.tolerance));
    let heads = heads(&["tried", "size", "CPU (s)", &within, "largest error", "in"]);
    (heads, advice.trials.iter().map(row).collect())
}

fn notes(advice: &Advice) -> String {
    let mut notes = format!("{ERRORS}\n");
    notes.push_str(advice.ladder.left_out);
    notes.push('\n');
    let unknown: Vec<&str> = (0..advice.judgements.len())
        .filter(|&q| !advice.is_known(q))
        .map(|q| advice.judgements[q].words.as_str())
        .collect();
    if !unknown.is_empty() {
        notes.push_str("Not compared, because no trial gives more than the order of magnitude: ");
        notes.push_str(&unknown.join(", "));
        notes.push_str(".\n");
    }
    notes
}

/// Errors of a trial over known quantities, with their indices.
pub(super) fn errors(advice: &Advice, trial: &Trial) -> Vec<(f64, usize)> {
    let of = |q: usize| Some((advice.judgements[q].error_of(trial)?, q));
    (0..advice.judgements.len()).filter(|&q| advice.is_known(q)).filter_map(of).collect()
}

/// Number of known quantities that a trial computes within the tolerance.
fn n_within(advice: &Advice, trial: &Trial) -> String {
    let errors = errors(advice, trial);
    let n = errors.iter().filter(|(error, _)| *error <= advice.options.tolerance).count();
    format!("{n} of {}", errors.len())
}

/// Largest error of a trial among known quantities, with the quantity.
fn worst(advice: &Advice, trial: &Trial) -> Option<(f64, String)> {
    let largest = errors(advice, trial).into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((largest.0, advice.judgements[largest.1].words.clone()))
}

fn cheapest(advice: &Advice) -> String {
    table(cheapest_rows(advice))
}

/// The cheapest method for each quantity, with the runner-up: heads and rows.
pub(super) fn cheapest_rows(advice: &Advice) -> (Vec<String>, Vec<Vec<String>>) {
    let row = |q: usize| {
        let judgement = &advice.judgements[q];
        let relative = judgement.error / judgement.scale;
        let value = format!("{} ({})", short(Some(judgement.value)), percent(relative));
        let candidates = advice.candidates(q);
        let mut cells = candidates.iter().map(|candidate| cells(advice, candidate));
        let none = || ["none".to_owned(), String::new()];
        let first = cells.next().unwrap_or_else(|| [why_not(advice, q), String::new()]);
        let second = cells.next().unwrap_or_else(none);
        [vec![judgement.words.clone(), value], first.to_vec(), second.to_vec()].concat()
    };
    let known = (0..advice.judgements.len()).filter(|&q| advice.is_known(q));
    let within = format!("cheapest within {}", percent(advice.options.tolerance));
    let names = ["quantity", "value (known to)", &within, "CPU (s)", "runner-up", "CPU (s)"];
    (heads(&names), known.map(row).collect())
}

fn cells(advice: &Advice, candidate: &Candidate) -> [String; 2] {
    let method = &advice.ladder.methods[candidate.method];
    let rung = advice.rung(candidate);
    let name = rung.map_or_else(|| method.name.clone(), |rung| method.at(&rung.label));
    let mark = if candidate.needed.beyond > 1.0 + 1e-9 { "~" } else { "" };
    [name, format!("{mark}{}", short(Some(candidate.needed.cost)))]
}

/// The method with the smallest error, and why it does not reach the tolerance.
fn why_not(advice: &Advice, quantity: usize) -> String {
    let unreached = advice.needs[quantity].iter().enumerate();
    let nearest = unreached.filter_map(|(method, need)| match need {
        Err(Unreached::NotFalling { error }) => Some((method, *error, "and it does not decrease")),
        Err(Unreached::TooFar { error }) => {
            Some((method, *error, "and the required size is too far from the trials"))
        }
        Ok(_) | Err(Unreached::NoAnswer) => None,
    });
    match nearest.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((method, error, why)) => {
            let name = &advice.ladder.methods[method].name;
            format!("none; {name} has {} {why}", percent(error))
        }
        None => "none".to_owned(),
    }
}

/// What solves the whole scene.
pub(super) enum Verdict {
    /// The cheapest method, in words, and the keys of the scene that choose it.
    Best { words: String, keys: Vec<String> },
    /// Why there is none.
    None(String),
}

pub(super) fn verdict(advice: &Advice) -> Verdict {
    let within = percent(advice.options.tolerance);
    let candidates = advice.candidates_for_all();
    let Some((best, rung)) = candidates.first().and_then(|it| Some((it, advice.rung(it)?))) else {
        return Verdict::None(format!(
            "No method reaches {within} for all of them. Raise --budget, or select fewer quantities by --quantity."
        ));
    };
    let name = advice.ladder.methods[best.method].at(&rung.label);
    let cost = short(Some(best.needed.cost));
    let seen = if best.needed.beyond > 1.0 + 1e-9 {
        format!("expected, {:.1} times the largest size tried", best.needed.beyond)
    } else {
        "as tried".to_owned()
    };
    let keys = rung.choice.iter().map(|(key, value)| format!("\"{key}\": {}", compact(value)));
    let words = format!("For all of them within {within}: {name}, {cost} s of CPU ({seen}).");
    Verdict::Best { words, keys: keys.collect() }
}

fn verdict_words(advice: &Advice) -> String {
    match verdict(advice) {
        Verdict::Best { words, keys } => {
            format!("{words}\nWrite into the scene:\n  {}\n", keys.join(",\n  "))
        }
        Verdict::None(words) => words,
    }
}

fn compact(value: &Value) -> String {
    serde_json::to_string(value).unwrap_or_default()
}
