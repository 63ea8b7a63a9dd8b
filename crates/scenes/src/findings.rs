//! What a run found, in words and numbers for its last lines on the terminal and for its page.
//!
//! A kind of scene reads it from the `result.json` of a run, so both show the numbers of that file.
#![cfg_attr(
    not(all(feature = "fpk", feature = "smpm", feature = "peridyn")),
    allow(dead_code, reason = "each solver uses a part of it")
)]

pub(crate) mod sources;

use result_figures::number::short;
use result_pages::{Answer, Cell, Chart, Fact, Note, Source, Table};
use serde::Deserialize;
use serde_json::Value;

/// What a run found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Findings {
    /// The answers that are shown first.
    pub answers: Vec<Answer>,
    /// Number of further values.
    pub n_more: usize,
    /// Warnings and remarks.
    pub notes: Vec<Note>,
    /// Why a field is not shown, and which key of the scene turns it on.
    pub absent: Vec<String>,
    /// Charts.
    pub charts: Vec<Chart>,
    /// Tables of the results.
    pub tables: Vec<Table>,
    /// Method, work and convergence.
    pub facts: Vec<Fact>,
    /// What to cite.
    pub sources: Vec<Source>,
}

/// Reason why a quantity or its error is unknown, as `result.json` has it.
#[derive(Debug, Deserialize)]
pub(crate) struct ReadUnknown {
    what: String,
    reason: String,
}

/// A number of `result.json` with its error.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct ReadNumber {
    pub(crate) value: f64,
    pub(crate) error: Option<f64>,
    pub(crate) error_kind: String,
}

/// A quantile of `result.json`.
#[derive(Debug, Deserialize)]
pub(crate) struct ReadQuantile {
    pub(crate) probability: f64,
    #[serde(flatten)]
    pub(crate) number: ReadNumber,
}

/// Largest number of rows of a table that holds all values over time.
const MOST_ROWS: usize = 400;

impl ReadUnknown {
    /// The warning that it is.
    pub(crate) fn note(&self) -> Note {
        Note::Warning(format!("unknown: {}: {}", self.what, self.reason))
    }
}

impl Findings {
    /// Adds a fact.
    pub(crate) fn fact(&mut self, name: &str, text: impl Into<String>) {
        self.facts.push(Fact { name: name.to_owned(), text: text.into() });
    }

    /// Adds the counts of an object as facts, `steps` as "steps"; a count that is `null` is left out.
    pub(crate) fn counts(&mut self, work: &Value) {
        for (name, value) in work.as_object().into_iter().flatten() {
            let Some(number) = value.as_f64() else { continue };
            let words = name.replace('_', " ");
            match words.strip_suffix(" seconds") {
                Some(words) => {
                    self.fact(
                        &format!("{} time", words.replace("cpu", "CPU")),
                        format!("{} s", short(Some(number))),
                    );
                }
                None => self.fact(&words, value.to_string()),
            }
        }
    }

    /// Adds a note for the answers that are smaller than their error.
    pub(crate) fn note_order_of_magnitude(&mut self) {
        let is_small =
            |answer: &&Answer| answer.error.is_some_and(|error| error >= answer.value.abs());
        let small: Vec<String> =
            self.answers.iter().filter(is_small).map(|answer| answer.quantity.clone()).collect();
        if !small.is_empty() {
            let text = format!(
                "known by a bound alone, since the error is as large: {}",
                small.join(", ")
            );
            self.notes.push(Note::Warning(text));
        }
    }

    /// Adds notes for answers without an error, which are not to be mistaken for exact ones.
    pub(crate) fn note_unknown_errors(&mut self) {
        let unknown = self.answers.iter().filter(|answer| answer.error.is_none());
        let unknown: Vec<&str> = unknown.map(|answer| answer.quantity.as_str()).collect();
        let text = match unknown.len() {
            0 => return,
            n if n == self.answers.len() => "these answers have no error estimate".to_owned(),
            _ => format!("without an error estimate: {}", unknown.join(", ")),
        };
        self.notes.push(Note::Remark(text));
    }

    /// Adds a table of values over time, of those at the last time alone if there are many.
    pub(crate) fn table_over_time(&mut self, table: Table, last: Table) {
        self.tables.push(if table.rows.len() <= MOST_ROWS { table } else { last });
    }
}

/// `error_kind` in words.
pub(crate) fn how(error_kind: &str) -> String {
    match error_kind {
        "two_resolutions" => "error from a run at a coarser resolution",
        "standard_error" => "standard error of the samples",
        "bound" => "error is a bound",
        "exact" => "a count, without error",
        _ => "no error estimate",
    }
    .to_owned()
}

/// A cell with six digits; empty for none.
pub(crate) fn cell(value: Option<f64>) -> Cell {
    value.map_or_else(
        || Cell::text(""),
        |value| Cell::number(result_figures::number::long(value), value),
    )
}

/// A cell with a number that was given, all its digits.
#[cfg(any(feature = "smpm", feature = "peridyn"))]
pub(crate) fn given_cell(value: f64) -> Cell {
    Cell::number(result_figures::number::exact(value), value)
}

/// A cell with three digits; empty for none.
pub(crate) fn short_cell(value: Option<f64>) -> Cell {
    value.map_or_else(|| Cell::text(""), |value| Cell::number(short(Some(value)), value))
}

/// A method of a scene in words: its name and its parameters.
pub(crate) fn method_words(method: &Value) -> String {
    match method {
        Value::String(word) => word.replace('_', " "),
        Value::Object(map) => {
            let of = |(name, parameters): (&String, &Value)| {
                let name = name.replace('_', " ");
                match parameters {
                    Value::Object(keys) if keys.is_empty() => name,
                    Value::Object(keys) => {
                        let key = |(key, value): (&String, &Value)| {
                            let value =
                                value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                            format!("{} {value}", key.replace('_', " "))
                        };
                        format!("{name}: {}", keys.iter().map(key).collect::<Vec<_>>().join(", "))
                    }
                    other => format!("{name} {other}"),
                }
            };
            map.iter().map(of).collect::<Vec<_>>().join("; ")
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_method_is_its_name_with_its_parameters() {
        assert_eq!(method_words(&json!("forward_difference")), "forward difference");
        assert_eq!(
            method_words(&json!({ "guided_paths": { "samples": 200, "step": 0.01 } })),
            "guided paths: samples 200, step 0.01"
        );
    }

    #[test]
    fn small_and_unknown_answers_are_named() {
        let answer = |quantity: &str, value: f64, error| Answer {
            quantity: quantity.to_owned(),
            at: String::new(),
            value,
            error,
            bound: None,
            unit: String::new(),
            how: String::new(),
        };
        let answers = vec![
            answer("a", 1.0, Some(0.1)),
            answer("b", 1e-9, Some(1e-8)),
            answer("c", 1.0, None),
        ];
        let mut findings = Findings { answers, ..Findings::default() };
        findings.note_order_of_magnitude();
        findings.note_unknown_errors();
        let texts: Vec<&str> = findings.notes.iter().map(Note::text).collect();
        assert!(texts[0].ends_with(": b") && texts[1].ends_with(": c"), "{texts:?}");
    }
}
