//! Reference data of the density problems.

use serde_json::Value;

use crate::case::CaseError;
use crate::claim::Reference;

/// Values over time with their errors.
#[derive(Debug)]
pub struct ReferenceTable {
    times: Vec<f64>,
    data: Data,
}

#[derive(Debug)]
enum Data {
    /// Plain lists with one relative error; exceedance as rows over thresholds.
    Exact { values: Value, relative_error: f64 },
    /// `[value, error, source]` or `null` per time, under a name per quantity.
    Best(Value),
}

/// A reference file that does not hold what it should.
#[derive(Debug, thiserror::Error)]
#[error("reference data: {what} is missing or of another form")]
pub struct ReferenceError {
    what: String,
}

impl ReferenceTable {
    /// The linear oscillator: exact.
    ///
    /// # Errors
    /// [`ReferenceError`], or that of the JSON.
    pub fn linear_oscillator() -> Result<Self, CaseError> {
        let values: Value = serde_json::from_str(include_str!(
            "../../reference/derived/fpk/linear_oscillator_exact.json"
        ))?;
        let relative_error = number(&values["relative_error"], "relative_error")?;
        Ok(Self {
            times: numbers(&values["times"], "times")?,
            data: Data::Exact { values, relative_error },
        })
    }

    /// The viscous damper: grid, Monte Carlo and importance sampling.
    ///
    /// # Errors
    /// [`ReferenceError`], or that of the JSON.
    pub fn viscous_damper() -> Result<Self, CaseError> {
        let mut values: Value =
            serde_json::from_str(include_str!("../../reference/derived/fpk/viscous_damper.json"))?;
        Ok(Self {
            times: numbers(&values["times"], "times")?,
            data: Data::Best(values["best"].take()),
        })
    }

    /// A raw moment `E[q^a v^b]`.
    #[must_use]
    pub fn moment(&self, powers: [u32; 2], t: f64) -> Option<Reference> {
        let name = match powers {
            [2, 0] => "q2",
            [1, 1] => "qv",
            [0, 2] => "v2",
            [4, 0] => "q4",
            [2, 2] => "q2v2",
            [0, 4] => "v4",
            _ => return None,
        };
        let k = self.at(t)?;
        match &self.data {
            Data::Exact { values, relative_error } => {
                let value = values[name][k].as_f64()?;
                Some(Reference::uncertain(value, relative_error * value.abs()))
            }
            Data::Best(values) => entry(&values[name][k]),
        }
    }

    /// `P(|q| > T)`.
    #[must_use]
    pub fn exceedance(&self, threshold: f64, t: f64) -> Option<Reference> {
        let k = self.at(t)?;
        match &self.data {
            Data::Exact { values, .. } => {
                let column = values["T"]
                    .as_array()?
                    .iter()
                    .position(|value| value.as_f64() == Some(threshold))?;
                let value = values["P_abs_q_gt_T"][k][column].as_f64()?;
                // erfc at z standard deviations has the condition z^2, at most 50 where it is used.
                Some(Reference::uncertain(value, 1e-9 * value))
            }
            Data::Best(values) => entry(&values[format!("P_abs_q_gt_{threshold}")][k]),
        }
    }

    /// The times of the table.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    fn at(&self, t: f64) -> Option<usize> {
        self.times.iter().position(|&time| (time - t).abs() < 1e-9)
    }
}

fn entry(entry: &Value) -> Option<Reference> {
    Some(Reference::uncertain(entry[0].as_f64()?, entry[1].as_f64()?))
}

fn number(value: &Value, what: &str) -> Result<f64, ReferenceError> {
    value.as_f64().ok_or_else(|| ReferenceError { what: what.into() })
}

fn numbers(value: &Value, what: &str) -> Result<Vec<f64>, ReferenceError> {
    let list = value.as_array().ok_or_else(|| ReferenceError { what: what.into() })?;
    list.iter().map(|value| number(value, what)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_hold_what_the_paper_problem_needs() {
        let linear = ReferenceTable::linear_oscillator().unwrap();
        assert!((linear.moment([2, 0], 6.0).unwrap().value - 0.09686840881097407).abs() < 1e-17);
        // erfc(1 / sqrt(2 * 0.0968684)) = 1.3136e-3.
        assert!((linear.exceedance(1.0, 6.0).unwrap().value / 1.3136e-3 - 1.0).abs() < 1e-4);
        let damper = ReferenceTable::viscous_damper().unwrap();
        assert!((damper.exceedance(1.5, 6.0).unwrap().value / 4.782e-9 - 1.0).abs() < 1e-3);
        assert!(damper.exceedance(1.5, 1.0).is_none() && damper.moment([2, 0], 9.0).is_none());
    }
}
