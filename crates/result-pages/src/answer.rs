//! A quantity that was asked for, and what the reader must know of it.

use result_figures::number::{long, percent};

/// A value with its error.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The quantity, e.g. `E[q^2]` or `flow stress at H`.
    pub quantity: String,
    /// Time or condition, e.g. `t = 10 s`; may be empty.
    pub at: String,
    /// The value.
    pub value: f64,
    /// Its error in the same unit; none if it is unknown.
    pub error: Option<f64>,
    /// The upper bound, where no more is known: printed in place of value and error.
    pub bound: Option<f64>,
    /// Unit; empty for a dimensionless quantity.
    pub unit: String,
    /// How the error is known, in words.
    pub how: String,
}

/// A statement that precedes the answers.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Note {
    /// A result is missing, or not to be trusted as it is.
    Warning(String),
    /// Anything else that a reader should know.
    Remark(String),
}

impl Note {
    /// The statement.
    #[must_use]
    pub fn text(&self) -> &str {
        match self {
            Self::Warning(text) | Self::Remark(text) => text,
        }
    }

    /// Whether a result is missing or not to be trusted.
    #[must_use]
    pub const fn is_warning(&self) -> bool {
        matches!(self, Self::Warning(_))
    }
}

impl Answer {
    /// Value and error with the same number of decimals, two digits of the error: `0.0412 ± 0.0012`; a bound as `< 3.0e-7`.
    #[must_use]
    pub fn value_and_error(&self) -> String {
        match self.short_error() {
            Some(error) => format!("{} ± {error}", self.short_value()),
            None => self.short_value(),
        }
    }

    /// The value with the digits that its error leaves, six at most; six without an error; a bound as `< 3.0e-7`.
    #[must_use]
    pub fn short_value(&self) -> String {
        if let Some(bound) = self.bound {
            return below(bound);
        }
        let Some(error) = self.error.filter(|&error| error > 0.0) else {
            return long(self.value);
        };
        // One digit beyond the first of the error.
        let exponent = |x: f64| x.abs().log10().floor();
        let digits = (exponent(self.value) - exponent(error) + 2.0).clamp(1.0, 6.0);
        if self.value == 0.0 {
            return "0".to_owned();
        }
        digits_of(self.value, digits)
    }

    /// The error with two digits; a bound has none.
    #[must_use]
    pub fn short_error(&self) -> Option<String> {
        if self.bound.is_some() {
            return None;
        }
        let short = |error: f64| if error == 0.0 { "0".to_owned() } else { digits_of(error, 2.0) };
        self.error.map(short)
    }

    /// The error over the magnitude of the value, e.g. `0.31 %`; empty for an error as large as the value and for a bound.
    #[must_use]
    pub fn relative_error(&self) -> String {
        let is_known = |&error: &f64| self.bound.is_none() && error < self.value.abs();
        let known = self.error.filter(is_known);
        known.map_or_else(String::new, |error| percent(error / self.value.abs()))
    }
}

/// An upper bound in place of a value, with two digits: `< 3.0e-7`.
#[must_use]
pub fn below(bound: f64) -> String {
    format!("< {}", if bound == 0.0 { "0".to_owned() } else { digits_of(bound, 2.0) })
}

/// A number with a number of significant digits, in plain decimals between 1e-4 and 1e6.
fn digits_of(value: f64, digits: f64) -> String {
    let exponent = value.abs().log10().floor();
    if (-4.0..6.0).contains(&exponent) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to 9: six digits at most, down to 1e-4"
        )]
        let decimals = (digits - 1.0 - exponent).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to 5: six digits at most"
        )]
        let decimals = (digits - 1.0).max(0.0) as usize;
        format!("{value:.decimals$e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(value: f64, error: Option<f64>) -> Answer {
        let (quantity, at, unit, how) = ("q".into(), String::new(), "m".into(), String::new());
        Answer { quantity, at, value, error, bound: None, unit, how }
    }

    #[test]
    fn a_bound_is_shown_in_place_of_value_and_error() {
        let bound = Answer { bound: Some(4.2e-7), ..answer(1.7e-7, Some(2.5e-7)) };
        assert_eq!((bound.value_and_error(), bound.short_error()), ("< 4.2e-7".to_owned(), None));
        let small = Answer { bound: Some(0.012), ..answer(0.01, Some(0.002)) };
        assert_eq!(
            (small.short_value(), small.relative_error()),
            ("< 0.012".to_owned(), String::new())
        );
    }

    #[test]
    fn a_value_has_the_digits_that_its_error_leaves() {
        let shown = |value, error| answer(value, error).value_and_error();
        assert_eq!(shown(0.04123456, Some(0.00123)), "0.0412 ± 0.0012");
        assert_eq!(shown(1234.5678, Some(56.7)), "1235 ± 57");
        assert_eq!(shown(1.234e-7, Some(2.5e-7)), "1.2e-7 ± 2.5e-7");
        assert_eq!(shown(0.5, None), "0.500000");
        assert_eq!(shown(0.0, Some(0.03)), "0 ± 0.030");
        assert_eq!(shown(0.123456789, Some(1e-9)), "0.123457 ± 1.0e-9");
    }

    #[test]
    fn a_relative_error_needs_a_value_and_an_error() {
        assert_eq!(answer(2.0, Some(0.01)).relative_error(), "0.500 %");
        assert_eq!(answer(0.0, Some(0.01)).relative_error(), "");
        assert_eq!(answer(1e-8, Some(1e-7)).relative_error(), "");
        assert_eq!(answer(1.0, None).relative_error(), "");
    }
}
