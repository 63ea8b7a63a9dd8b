//! Answers of a run in memory: what a scene asks for, each value with its error and how that error is known.
//!
//! A run of any kind returns [`Answers`]. `solve`, the trials of `advise` and of ablation studies, the lines on the terminal
//! and the first block of the page are made of them; nothing is read back from a file. An id is an identity that is compared,
//! never taken apart: what a consumer must know of a quantity is a field. This module knows no solver and no file.

use result_figures::number::short;
use result_pages::Note;
use sde_integrators::{Estimate, Uncertainty};
use serde::Serialize;

/// What a run answers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answers {
    /// CPU time of all threads (s).
    pub cpu_seconds: f64,
    /// Each quantity that the scene asks for, once, by the best estimator of its method; the first ones are shown first.
    pub list: Vec<Answer>,
}

/// A quantity that a scene asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Identity of the quantity among all methods that solve the scene, e.g. `moment/2-0`.
    pub id: String,
    /// Symbol or description, e.g. `E[q^2]`.
    pub words: String,
    /// Unit; empty for a dimensionless quantity.
    pub unit: String,
    /// Unit of its times; empty without times.
    pub time_unit: &'static str,
    /// What of a random quantity it is.
    pub statistic: Statistic,
    /// Where it is used.
    pub role: Role,
    /// Value at the last time.
    pub last: AnswerValue,
    /// Values at the times before, in order.
    pub earlier: Vec<AnswerValue>,
    /// Scale of the error of the last value: its magnitude, or that of terms that cancel in it.
    pub scale: f64,
    /// What a series leaves out of the last value, by its own terms: used for comparisons where no error is known, and no bound.
    pub truncation: Option<f64>,
}

/// A value of an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct AnswerValue {
    /// Start and end of the time that it is of, equal for an instant; none without times.
    pub window: Option<[f64; 2]>,
    /// The number with its error.
    pub number: Number,
    /// What is known of the error, in words, where [`ErrorOrigin::words`] do not say it.
    pub remark: Option<String>,
}

/// What of a random quantity an answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Statistic {
    /// A moment of powers of several quantities.
    Moment,
    /// A mean, or the value of a quantity that does not vary.
    Mean,
    /// A standard deviation.
    StandardDeviation,
    /// A probability.
    Probability,
}

/// Where an answer is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Shown first on the terminal and on the page, and compared between methods.
    Headline,
    /// Compared between methods.
    Compared,
    /// Shown first; methods are not compared by it.
    Shown,
}

/// A number with its error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Number {
    /// The value.
    pub value: f64,
    /// Its error; none if it is unknown.
    pub error: Option<f64>,
    /// How the error is known.
    pub error_kind: ErrorOrigin,
}

/// How an error is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorOrigin {
    /// From runs at a coarser resolution, with the order of the method.
    TwoResolutions,
    /// From whole runs that the estimate has not used.
    CheckRuns,
    /// Scatter of samples.
    StandardError,
    /// Half of a bootstrap interval of 95 %.
    Interval,
    /// A bound.
    Bound,
    /// A count.
    Exact,
    /// No error is known.
    Unknown,
}

/// An unknown error or quantity, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unknown {
    /// The quantities, and from which time on.
    pub what: String,
    /// Reason.
    pub reason: String,
}

impl Unknown {
    /// The warning that it is.
    #[must_use]
    pub fn note(&self) -> Note {
        Note::Warning(format!("unknown: {}: {}", self.what, self.reason))
    }
}

impl ErrorOrigin {
    /// How the error is known, in words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::TwoResolutions => "error from a run at a coarser resolution",
            Self::CheckRuns => "error from runs that the estimate has not used",
            Self::StandardError => "standard error of the samples",
            Self::Interval => "half of the 95 % bootstrap interval",
            Self::Bound => "error is a bound",
            Self::Exact => "a count, without error",
            Self::Unknown => "no error estimate",
        }
    }
}

impl From<Estimate> for Number {
    fn from(estimate: Estimate) -> Self {
        let (error, error_kind) = match estimate.uncertainty {
            Uncertainty::StandardError(error) => (error, ErrorOrigin::StandardError),
            Uncertainty::Bound(error) => (error, ErrorOrigin::Bound),
            Uncertainty::Unknown => (f64::INFINITY, ErrorOrigin::Unknown),
        };
        if error.is_finite() {
            Self { value: estimate.value, error: Some(error), error_kind }
        } else {
            Self { value: estimate.value, error: None, error_kind: ErrorOrigin::Unknown }
        }
    }
}

impl Number {
    /// A value with a standard error, if it has one.
    #[must_use]
    pub const fn sampled(value: f64, error: Option<f64>) -> Self {
        let is_known = error.is_some();
        let error_kind = if is_known { ErrorOrigin::StandardError } else { ErrorOrigin::Unknown };
        Self { value, error, error_kind }
    }

    /// Upper bound of a number that cannot be negative, where no more is known of it.
    #[must_use]
    pub fn upper_bound(&self) -> Option<f64> {
        let error = self.error.filter(|&error| error >= self.value)?;
        let bound = self.value + error;
        (self.error_kind == ErrorOrigin::Bound && bound > 0.0).then_some(bound)
    }

    /// A point of a chart of the page.
    #[must_use]
    pub fn point(&self, x: f64) -> result_pages::Point {
        result_pages::Point {
            x,
            y: self.value,
            error: self.error,
            bound: None,
            how: self.error_kind.words().to_owned(),
            spread: None,
        }
    }
}

impl AnswerValue {
    /// A value without times.
    #[must_use]
    pub const fn of(number: Number) -> Self {
        Self { window: None, number, remark: None }
    }

    /// A value at a time.
    #[must_use]
    pub const fn at(t: f64, number: Number) -> Self {
        Self { window: Some([t, t]), number, remark: None }
    }
}

impl Answers {
    /// The answer with this id.
    #[must_use]
    pub fn get(&self, id: &str) -> Option<&Answer> {
        self.list.iter().find(|answer| answer.id == id)
    }

    /// Answers by which methods are compared.
    pub fn compared(&self) -> impl Iterator<Item = &Answer> {
        self.list.iter().filter(|answer| answer.role != Role::Shown)
    }

    /// Answers that are shown first.
    pub fn headlines(&self) -> impl Iterator<Item = &Answer> {
        self.list.iter().filter(|answer| answer.role != Role::Compared)
    }

    /// Notes on answers that are shown first: those as small as their error, and those without an error, which are not to be
    /// mistaken for exact ones.
    #[must_use]
    pub fn notes(&self) -> Vec<Note> {
        let mut notes = Vec::new();
        let words = |is: fn(&Number) -> bool| -> Vec<&str> {
            let of = self.headlines().filter(|answer| is(&answer.last.number));
            of.map(|answer| answer.words.as_str()).collect()
        };
        let small = words(|it| it.error.is_some_and(|error| error >= it.value.abs()));
        if !small.is_empty() {
            let small = small.join(", ");
            notes.push(Note::Warning(format!(
                "known by a bound alone, since the error is as large: {small}"
            )));
        }
        let unknown = words(|it| it.error.is_none());
        if unknown.len() == self.headlines().count() && !unknown.is_empty() {
            notes.push(Note::Remark("these answers have no error estimate".to_owned()));
        } else if !unknown.is_empty() {
            notes.push(Note::Remark(format!("without an error estimate: {}", unknown.join(", "))));
        }
        notes
    }
}

impl Answer {
    /// An answer without times, unit or other scale than its magnitude, which is compared.
    #[must_use]
    pub fn new(id: String, words: String, statistic: Statistic, last: AnswerValue) -> Self {
        let scale = last.number.value.abs();
        Self {
            id,
            words,
            unit: String::new(),
            time_unit: "",
            statistic,
            role: Role::Compared,
            last,
            earlier: Vec::new(),
            scale,
            truncation: None,
        }
    }

    /// The error by which the last value is compared with that of another run: two standard errors of a sampled value, else its
    /// error, else what a series leaves out.
    #[must_use]
    pub fn margin(&self) -> Option<f64> {
        let Number { value, error, error_kind } = self.last.number;
        let Some(error) = error else { return self.truncation };
        Some(match (error_kind, self.statistic) {
            (ErrorOrigin::StandardError, Statistic::Probability) if value > 0.0 && value < 1.0 => {
                above_frequency(value, error)
            }
            (ErrorOrigin::StandardError, _) => 2.0 * error,
            _ => error,
        })
    }

    /// As the page and the terminal show it.
    #[must_use]
    pub fn shown(&self) -> result_pages::Answer {
        let AnswerValue { window, number, remark } = &self.last;
        let time_unit = self.time_unit;
        let at = window.map_or_else(String::new, |[from, to]| {
            if from >= to {
                format!("t = {to} {time_unit}")
            } else {
                format!("t = {from} to {to} {time_unit}")
            }
        });
        let is_probability = self.statistic == Statistic::Probability;
        result_pages::Answer {
            quantity: self.words.clone(),
            at,
            value: number.value,
            error: number.error,
            bound: number.upper_bound().filter(|bound| is_probability && *bound < 1.0),
            unit: self.unit.clone(),
            how: remark.clone().unwrap_or_else(|| number.error_kind.words().to_owned()),
        }
    }
}

impl std::fmt::Display for Answer {
    /// Words, value, error and unit: `E[q^2] = 0.0412 ± 0.0012 m^2`.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let shown = self.shown();
        write!(formatter, "{} = {}", self.words, shown.value_and_error())?;
        if self.last.number.error.is_none() {
            let truncation = self.truncation.map(|it| format!(", series {}", short(Some(it))));
            write!(formatter, " (error unknown{})", truncation.unwrap_or_default())?;
        }
        if self.unit.is_empty() { Ok(()) } else { write!(formatter, " {}", self.unit) }
    }
}

/// Upper limit of a probability above its counted frequency at two standard errors [wilson1927].
///
/// With few counted events the deviation of the frequency is as uncertain as their number.
fn above_frequency(frequency: f64, standard_error: f64) -> f64 {
    const Z: f64 = 2.0;
    // n in s.e.^2 = p (1 - p) / n.
    let z2_over_n = (Z * standard_error).powi(2) / (frequency * (1.0 - frequency));
    let half = (Z * Z * standard_error.powi(2) + 0.25 * z2_over_n * z2_over_n).sqrt();
    (frequency + 0.5 * z2_over_n + half) / (1.0 + z2_over_n) - frequency
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(statistic: Statistic, value: f64, error: Option<f64>, kind: ErrorOrigin) -> Answer {
        let number = Number { value, error, error_kind: kind };
        let last = AnswerValue::at(2.0, number);
        let words = value.to_string();
        let role = Role::Headline;
        Answer { role, time_unit: "s", ..Answer::new(String::new(), words, statistic, last) }
    }

    #[test]
    fn sampled_values_are_compared_by_two_standard_errors_and_others_by_their_error() {
        let margin = |statistic, kind| answer(statistic, 0.2, Some(0.01), kind).margin().unwrap();
        assert!((margin(Statistic::Mean, ErrorOrigin::StandardError) - 0.02).abs() < 1e-15);
        assert!((margin(Statistic::Mean, ErrorOrigin::Interval) - 0.01).abs() < 1e-15);
        // 1,600 samples.
        let counted = margin(Statistic::Probability, ErrorOrigin::StandardError);
        assert!((counted - 0.0207).abs() < 1e-4, "{counted}");
        let series = answer(Statistic::Mean, 0.2, None, ErrorOrigin::Unknown);
        assert_eq!(series.margin(), None);
        assert_eq!(Answer { truncation: Some(0.1), ..series }.margin(), Some(0.1));
    }

    #[test]
    fn one_event_is_not_known_to_within_two_of_its_deviations() {
        // (1 + 2 + 2 sqrt(1 + 1)) / n - 1 / n.
        let n = 1e6;
        let above = above_frequency(1.0 / n, 1.0 / n);
        assert!((above * n - 4.828).abs() < 1e-3, "{above}");
    }

    #[test]
    fn a_probability_that_is_no_larger_than_its_bound_is_shown_as_a_bound_and_a_moment_is_not() {
        let shown = |statistic, value, error| {
            answer(statistic, value, Some(error), ErrorOrigin::Bound).shown().value_and_error()
        };
        assert_eq!(shown(Statistic::Probability, 1.7e-7, 2.5e-7), "< 4.2e-7");
        assert_eq!(shown(Statistic::Probability, 1e-3, 2e-5), "0.001000 ± 2.0e-5");
        // No more than that it is a probability.
        assert!(!shown(Statistic::Probability, 1.0, 1.0).contains('<'));
        assert_eq!(shown(Statistic::Moment, -0.01, 0.02), "-0.010 ± 0.020");
    }

    #[test]
    fn small_and_unknown_answers_are_named() {
        let mean = |value, error| answer(Statistic::Mean, value, error, ErrorOrigin::StandardError);
        let list = vec![mean(1.0, Some(0.1)), mean(1e-9, Some(1e-8)), mean(3.0, None)];
        let notes = Answers { cpu_seconds: 0.0, list }.notes();
        let texts: Vec<&str> = notes.iter().map(Note::text).collect();
        assert!(texts[0].ends_with(": 0.000000001") && texts[1].ends_with(": 3"), "{texts:?}");
    }
}
