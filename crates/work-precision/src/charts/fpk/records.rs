//! Cost and error of a run of a method, and their charts.

use result_figures::{
    Drawing, DrawingError, Measure, Method, Run, RunOutcome, Words, WorkPrecision,
};
use scenes::machine::Machine;
use serde::Serialize;

use super::question::{Quantity, Question};
use crate::charts::cost::{cost_in_seconds, run};

/// One run of one method for one quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Record {
    /// The quantity.
    pub(super) quantity: String,
    /// The method.
    pub(super) method: String,
    /// Its parameter.
    pub(super) label: String,
    /// CPU time on one thread (s).
    pub(super) cpu_seconds: f64,
    /// Half the range of that time over repeated runs.
    pub(super) cpu_spread: f64,
    /// Result or failure.
    pub(super) outcome: Outcome,
}

/// One scene with the results of all methods.
pub(super) struct Scene {
    /// Prefix of the names of its charts.
    name: &'static str,
    pub(super) title: &'static str,
    /// Quantities, moments first.
    pub(super) quantities: Vec<Quantity>,
    pub(super) records: Vec<Record>,
}

impl Scene {
    pub(super) const fn new(name: &'static str, title: &'static str) -> Self {
        Self { name, title, quantities: Vec::new(), records: Vec::new() }
    }

    /// Takes in the quantities of a question, and what a method found.
    pub(super) fn add<const D: usize>(&mut self, question: &Question<D>, records: Vec<Record>) {
        self.quantities.extend(question.quantities.iter().cloned());
        self.records.extend(records);
    }
}

/// Result or failure of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Outcome {
    /// A deterministic result with its relative error against the reference.
    Off {
        /// Magnitude of the error.
        error: f64,
    },
    /// A sampled result.
    Sampled {
        /// Its relative standard error.
        predicted: f64,
        /// Standard error of that estimate, if known.
        uncertainty: Option<f64>,
        /// Relative error of this sample, if it has a result.
        seen: Option<f64>,
    },
    /// No result.
    Nothing {
        /// Reason.
        reason: String,
    },
}

impl Record {
    /// Error by which methods are compared: of a deterministic result the error, of a sampled one the standard error.
    pub(super) const fn error(&self) -> Option<f64> {
        match self.outcome {
            Outcome::Off { error } => Some(error),
            Outcome::Sampled { predicted, .. } => Some(predicted),
            Outcome::Nothing { .. } => None,
        }
    }

    fn run(&self) -> Run {
        let outcome = match &self.outcome {
            // A logarithmic axis cannot show an error of zero.
            Outcome::Off { error } if *error > 0.0 => {
                RunOutcome::Error { value: *error, standard_error: None }
            }
            Outcome::Off { .. } => {
                RunOutcome::Failed { reason: "no error to the last digit".into() }
            }
            Outcome::Sampled { predicted, uncertainty, .. } => {
                RunOutcome::Error { value: *predicted, standard_error: *uncertainty }
            }
            Outcome::Nothing { reason } => RunOutcome::Failed { reason: reason.clone() },
        };
        let label = match self.outcome {
            Outcome::Sampled { predicted, seen: Some(seen), .. } => {
                format!("{} ({:.1})", self.label, seen / predicted)
            }
            _ => self.label.clone(),
        };
        run((self.cpu_seconds, self.cpu_spread), outcome, Some(label))
    }
}

/// Methods in a list of records, in order of first appearance.
pub(super) fn methods<'r>(records: impl Iterator<Item = &'r Record>) -> Vec<&'r str> {
    let mut names: Vec<&str> = Vec::new();
    for record in records {
        if !names.contains(&record.method.as_str()) {
            names.push(&record.method);
        }
    }
    names
}

/// One chart for each quantity of a scene.
pub(super) fn charts(scene: &Scene) -> Result<Vec<Drawing>, DrawingError> {
    let mut drawings = Vec::new();
    for quantity in &scene.quantities {
        let records = || scene.records.iter().filter(|r| r.quantity == quantity.name);
        let series = methods(scene.records.iter())
            .into_iter()
            .map(|name| Method {
                name: name.to_owned(),
                runs: records().filter(|r| r.method == name).map(Record::run).collect(),
            })
            .filter(|method| !method.runs.is_empty())
            .collect();
        let words = Words {
            title: quantity.title.clone(),
            subtitle: scene.title.into(),
            x_label: "CPU time on one thread (s)".into(),
            y_label: "relative error".into(),
            caption: vec![
                format!(
                    "Sampled methods: the relative standard error; in brackets the observed error, in standard errors. \
                     Others: the error against the reference, whose own error is {:.0e}.",
                    quantity.reference_error
                ),
                "Across: median CPU time of three runs, the bar half their range (one run beyond 1 s).".into(),
                Machine::read().caption(),
            ],
        };
        let name = format!("{}-{}", scene.name, quantity.name);
        let reading = cost_in_seconds(Measure::Relative, quantity.reference_error);
        drawings.push(Drawing::work_precision(&name, &WorkPrecision { words, reading, series })?);
    }
    Ok(drawings)
}
