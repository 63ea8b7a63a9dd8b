//! The advice as one page.

use std::path::{Path, PathBuf};

use result_figures::number::{percent, short};
use result_pages::{Answer, Cell, Chart, Fact, Note, Page, Point, Series, Table};

use super::words::{Verdict, cheapest_rows, errors, tried_rows, verdict};
use super::{Advice, AdviseError};
use crate::kind::{RunError, SceneKind, kind_of};
use crate::output::{OutputError, write_text};
use crate::page::NAME;
use crate::scene::SceneFile;

/// Writes `index.html` into a folder, which is made if it is not there; returns its path.
///
/// # Errors
/// [`AdviseError::Run`] for a scene or a folder that cannot be read or written.
pub fn write_page(
    table: &[SceneKind],
    scene: &Path,
    advice: &Advice,
    out: &Path,
) -> Result<PathBuf, AdviseError> {
    let file = SceneFile::read(scene)?;
    let kind = kind_of(table, &file)?;
    let html = result_pages::render(&page(kind, &file, advice)).map_err(RunError::page)?;
    let path = out.join(NAME);
    let failed = |source| RunError::from(OutputError::Io { path: path.clone(), source });
    std::fs::create_dir_all(out).map_err(failed)?;
    write_text(&path, &html).map_err(failed)?;
    Ok(path)
}

fn page(kind: &SceneKind, file: &SceneFile, advice: &Advice) -> Page {
    let title = file.keys()["title"].as_str().unwrap_or(kind.solver);
    let tolerance = percent(advice.options.tolerance);
    Page {
        title: format!("Which method for: {title}"),
        solver: format!("{}, errors up to {tolerance}", kind.solver),
        notes: notes(advice),
        answers: answers(advice),
        charts: charts(advice),
        tables: tables(advice),
        facts: facts(advice),
        origin: format!("scenes {}", env!("CARGO_PKG_VERSION")),
        ..Page::default()
    }
}

/// The verdict, and the quantities that are left out of it.
fn notes(advice: &Advice) -> Vec<Note> {
    let mut notes = vec![match verdict(advice) {
        Verdict::Best { words, keys } => {
            Note::Remark(format!("{words} Keys for the scene: {{ {} }}", keys.join(", ")))
        }
        Verdict::None(words) => Note::Warning(words),
    }];
    let unknown = (0..advice.judgements.len()).filter(|&q| !advice.is_known(q)).map(|q| {
        let words = &advice.judgements[q].words;
        Note::Warning(format!(
            "{words}: not compared, no trial gives more than its order of magnitude"
        ))
    });
    notes.extend(unknown);
    notes
}

/// The value of each quantity by its most accurate trial.
fn answers(advice: &Advice) -> Vec<Answer> {
    let answer = |q: usize| {
        let judgement = &advice.judgements[q];
        let trial = &advice.trials[judgement.best];
        let method = advice.ladder.methods[trial.method].at(&trial.rung.label);
        Answer {
            quantity: judgement.words.clone(),
            at: String::new(),
            value: judgement.value,
            error: Some(judgement.error),
            bound: None,
            unit: String::new(),
            how: format!("from the most accurate trial, {method}"),
        }
    };
    (0..advice.judgements.len()).filter(|&q| advice.is_known(q)).map(answer).collect()
}

/// The largest error of each trial over its CPU time, a line for each method.
fn charts(advice: &Advice) -> Vec<Chart> {
    let mut series: Vec<Series> = advice
        .ladder
        .methods
        .iter()
        .map(|method| Series { name: method.name.clone(), points: Vec::new() })
        .collect();
    for trial in &advice.trials {
        let largest = errors(advice, trial).into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let Some(((y, q), answers)) = largest.zip(trial.answers()) else { continue };
        if answers.cpu_seconds > 0.0 && y.is_finite() {
            let how = format!("in {}", advice.judgements[q].words);
            let point =
                Point { x: answers.cpu_seconds, y, error: None, bound: None, how, spread: None };
            series[trial.method].points.push(point);
        }
    }
    series.retain(|it| !it.points.is_empty());
    for line in &mut series {
        line.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    if series.is_empty() {
        return Vec::new();
    }
    vec![Chart {
        title: "Largest error of each trial over its cost".to_owned(),
        x_label: "CPU time (s)".to_owned(),
        y_label: "relative error".to_owned(),
        is_logarithmic: true,
        x_is_logarithmic: true,
        spread: String::new(),
        series,
    }]
}

fn tables(advice: &Advice) -> Vec<Table> {
    let table = |title: &str, about: &str, (heads, rows): (Vec<String>, Vec<Vec<String>>)| Table {
        title: title.to_owned(),
        about: about.to_owned(),
        heads,
        rows: rows.into_iter().map(|row| row.into_iter().map(cell).collect()).collect(),
    };
    let beyond = "A size marked ~ is larger than those tried; its cost and error are extrapolated.";
    vec![
        table("Cheapest methods", beyond, cheapest_rows(advice)),
        table("Trials", advice.ladder.left_out, tried_rows(advice)),
    ]
}

/// A number sorts as one.
fn cell(text: String) -> Cell {
    match text.trim_start_matches('~').parse::<f64>() {
        Ok(number) if number.is_finite() => Cell::number(text, number),
        _ => Cell::text(text),
    }
}

fn facts(advice: &Advice) -> Vec<Fact> {
    let fact = |name: &str, text: String| Fact { name: name.to_owned(), text };
    let seconds: f64 =
        advice.trials.iter().filter_map(|it| it.answers()).map(|it| it.cpu_seconds).sum();
    vec![
        fact("tolerance", format!("{} of each value", percent(advice.options.tolerance))),
        fact("budget of a trial", format!("{} CPU s", short(Some(advice.options.budget)))),
        fact(
            "trials",
            format!("{} runs, {} CPU s together", advice.trials.len(), short(Some(seconds))),
        ),
        fact("error of a trial", super::words::ERRORS.to_owned()),
    ]
}
