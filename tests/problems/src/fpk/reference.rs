//! Reference data of the density problems.

use std::collections::BTreeMap;

use result_figures::Reference;
use serde::Deserialize;
use serde_json::Value;

use crate::context::CaseError;

/// Values over time with their errors.
#[derive(Debug)]
pub struct ReferenceTable {
    times: Vec<f64>,
    data: Data,
    /// `[value, error]` per time, under a name per threshold; nothing where the file has none.
    first_passage: Value,
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
            "../../../../tests/reference/derived/fpk/linear_oscillator_exact.json"
        ))?;
        let relative_error = number(&values["relative_error"], "relative_error")?;
        Ok(Self {
            times: numbers(&values["times"], "times")?,
            data: Data::Exact { values, relative_error },
            first_passage: Value::Null,
        })
    }

    /// The viscous damper: grid, Monte Carlo and importance sampling.
    ///
    /// # Errors
    /// [`ReferenceError`], or that of the JSON.
    pub fn viscous_damper() -> Result<Self, CaseError> {
        let text = include_str!("../../../../tests/reference/derived/fpk/viscous_damper.json");
        Self::best(text, "first_passage_mc")
    }

    /// The Bouc-Wen oscillator: Monte Carlo and importance sampling.
    ///
    /// # Errors
    /// [`ReferenceError`], or that of the JSON.
    pub fn bouc_wen() -> Result<Self, CaseError> {
        Self::best(
            include_str!("../../../../tests/reference/derived/fpk/bouc_wen.json"),
            "first_passage",
        )
    }

    fn best(text: &str, first_passage: &str) -> Result<Self, CaseError> {
        let mut values: Value = serde_json::from_str(text)?;
        Ok(Self {
            times: numbers(&values["times"], "times")?,
            data: Data::Best(values["best"].take()),
            first_passage: values[first_passage].take(),
        })
    }

    /// A raw moment `E[q^a v^b z^c]`; the powers may stop at the last state of the system.
    #[must_use]
    pub fn moment<const D: usize>(&self, powers: [u32; D], t: f64) -> Option<Reference> {
        let name = moment_name(&powers);
        let k = self.at(t)?;
        match &self.data {
            Data::Exact { values, relative_error } => {
                let value = values[&name][k].as_f64()?;
                Some(Reference::uncertain(value, relative_error * value.abs()))
            }
            Data::Best(values) => entry(&values[&name][k]),
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

    /// `P(max |q| > T)` up to the time.
    #[must_use]
    pub fn first_passage(&self, threshold: f64, t: f64) -> Option<Reference> {
        entry(&self.first_passage[format!("FP_{threshold}")][self.at(t)?])
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

/// The key of a moment: `q2`, `qv`, `q2z2`.
fn moment_name(powers: &[u32]) -> String {
    let factor = |(state, power): (&str, &u32)| match power {
        0 => String::new(),
        1 => state.to_owned(),
        _ => format!("{state}{power}"),
    };
    ["q", "v", "z"].into_iter().zip(powers).map(factor).collect()
}

/// The bistable system `dX = (X - X^3) dt + sqrt(0.5) dB` from a normal law with mean 0.5 and variance 0.01.
#[derive(Debug, Deserialize)]
pub struct BistableReference {
    /// When.
    pub times: Vec<f64>,
    /// Where the density is known.
    pub x: Vec<f64>,
    /// The density, per time and place.
    pub pdf: Vec<Vec<f64>>,
    /// Size of the correction by extrapolation, per time; the error left is smaller.
    pub err_est: Vec<f64>,
    /// `E[X^0]` to `E[X^4]`, per time.
    pub moments: Vec<[f64; 5]>,
    /// `Z` of the stationary density `exp((x^2/2 - x^4/4)/D)/Z`.
    #[serde(rename = "Z")]
    pub normalisation: f64,
}

/// The stationary Duffing oscillator with `zeta = 0.05, w0 = 1, eps = 0.5, S0 = 0.1`.
#[derive(Debug, Deserialize)]
pub struct DuffingReference {
    /// `E[x^2]`.
    #[serde(rename = "E_x2")]
    pub displacement: f64,
    /// `E[v^2]`.
    #[serde(rename = "E_v2")]
    pub velocity: f64,
    /// `P(|x| > T)` by `T`.
    #[serde(rename = "P_abs_x_gt")]
    pub exceedance: BTreeMap<String, f64>,
}

#[derive(Debug, Deserialize)]
struct BistableAndDuffing {
    bistable: BistableReference,
    duffing: DuffingReference,
}

fn bistable_and_duffing() -> Result<BistableAndDuffing, CaseError> {
    Ok(serde_json::from_str(include_str!(
        "../../../../tests/reference/derived/fpk/bistable_and_duffing.json"
    ))?)
}

impl BistableReference {
    /// Reads the data.
    pub fn read() -> Result<Self, CaseError> {
        Ok(bistable_and_duffing()?.bistable)
    }
}

impl DuffingReference {
    /// Reads the data.
    pub fn read() -> Result<Self, CaseError> {
        Ok(bistable_and_duffing()?.duffing)
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
        assert!((damper.first_passage(0.75, 8.0).unwrap().value / 8.5174e-3 - 1.0).abs() < 1e-4);
        assert!(linear.first_passage(0.75, 8.0).is_none());
    }

    #[test]
    fn the_bouc_wen_table_holds_moments_of_all_three_states_and_a_far_tail() {
        let table = ReferenceTable::bouc_wen().unwrap();
        let value = |powers: [u32; 3]| table.moment(powers, 3.6).unwrap().value;
        assert!((value([2, 0, 0]) / 0.148804 - 1.0).abs() < 1e-5);
        assert!((value([0, 0, 2]) / 0.0993713 - 1.0).abs() < 1e-5);
        assert!((value([1, 0, 1]) / 0.115094 - 1.0).abs() < 1e-5);
        assert!((table.exceedance(2.0, 3.6).unwrap().value / 6.9e-7 - 1.0).abs() < 0.01);
        assert!(table.moment([6, 0, 0], 3.6).is_none() && table.exceedance(2.0, 1.0).is_none());
    }

    #[test]
    fn the_bistable_table_is_a_density_and_the_duffing_one_that_of_its_system() {
        let table = BistableReference::read().unwrap();
        assert_eq!((table.times.len(), table.pdf.len(), table.x.len()), (4, 4, 300));
        let spacing = table.x[1] - table.x[0];
        for (pdf, moments) in table.pdf.iter().zip(&table.moments) {
            // The trapezoidal rule on a density that vanishes at both ends; moments[0] is its mass.
            let mass: f64 = pdf.iter().sum::<f64>() * spacing;
            assert!((mass - moments[0]).abs() < 1e-6, "{mass}");
        }
        let duffing = DuffingReference::read().unwrap();
        assert!((duffing.velocity - 1.0).abs() < 1e-15 && duffing.exceedance.len() == 5);
    }
}
