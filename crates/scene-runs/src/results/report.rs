//! What the page of a run shows beside its answers: notes, charts, tables, facts, sources.
//!
//! A solver makes it from what its run holds in memory. This module knows no solver.

use result_figures::number::short;
use result_pages::{Cell, Chart, Fact, Note, Series, Source, Table};
use serde::Serialize;
use serde_json::Value;

use crate::answers::Number;

/// What a page shows beside the answers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
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
    /// Kinds of unit that the scene chooses and their names, e.g. `length` and `cm`.
    pub units: Vec<(&'static str, &'static str)>,
}

/// Largest number of rows of a table that holds all values over time.
const MOST_ROWS: usize = 400;

impl Report {
    /// Adds a fact.
    pub fn fact(&mut self, name: &str, text: impl Into<String>) {
        self.facts.push(Fact { name: name.to_owned(), text: text.into() });
    }

    /// Adds the counts of a record as facts, `path_steps` as "path steps"; a count that is not known is left out.
    pub fn counts(&mut self, work: &impl Serialize) {
        let work = serde_json::to_value(work).unwrap_or_default();
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

    /// Pictures that could be drawn; the page says why one is missing, since a picture is no reason to lose an answer.
    pub fn drawn<T, E: std::fmt::Display>(
        &mut self,
        what: &str,
        drawn: Result<Vec<T>, E>,
    ) -> Vec<T> {
        drawn.unwrap_or_else(|error| {
            self.absent.push(format!("The {what} are missing: {error}."));
            Vec::new()
        })
    }

    /// Adds a table of values over time, of those at the last time alone if there are many.
    pub fn table_over_time(&mut self, table: Table, last: Table) {
        self.tables.push(if table.rows.len() <= MOST_ROWS { table } else { last });
    }
}

/// A linear chart of some lines.
#[must_use]
pub fn chart(title: String, [x_label, y_label]: [String; 2], series: Vec<Series>) -> Chart {
    let (is_logarithmic, x_is_logarithmic, spread) = (false, false, String::new());
    Chart { title, x_label, y_label, is_logarithmic, x_is_logarithmic, spread, series }
}

/// A table without a description.
#[must_use]
pub fn table(title: &str, heads: &[&str], rows: Vec<Vec<Cell>>) -> Table {
    let heads = heads.iter().map(|&head| head.to_owned()).collect();
    Table { title: title.to_owned(), about: String::new(), heads, rows }
}

/// Cells of a number: value and error.
#[must_use]
pub fn number_cells(number: &Number) -> [Cell; 2] {
    [cell(Some(number.value)), short_cell(number.error)]
}

/// A cell with six digits; empty for none.
#[must_use]
pub fn cell(value: Option<f64>) -> Cell {
    value.map_or_else(
        || Cell::text(""),
        |value| Cell::number(result_figures::number::long(value), value),
    )
}

/// A cell with a number that was given, all its digits.
#[must_use]
pub fn given_cell(value: f64) -> Cell {
    Cell::number(result_figures::number::exact(value), value)
}

/// A cell with three digits; empty for none.
#[must_use]
pub fn short_cell(value: Option<f64>) -> Cell {
    value.map_or_else(|| Cell::text(""), |value| Cell::number(short(Some(value)), value))
}

/// A method of a scene in words: its name and its parameters.
#[must_use]
pub fn method_words(method: &impl Serialize) -> String {
    let method = serde_json::to_value(method).unwrap_or_default();
    match &method {
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
}
