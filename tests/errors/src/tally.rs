//! How often the truth lies within the stated errors.

use std::collections::BTreeMap;
use std::fmt;

use crate::{Outcome, Verdict};

/// Multiples of the stated error within which the truth is counted.
const WITHIN: [f64; 4] = [1.0, 2.0, 5.0, 10.0];

/// Counts of one method.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Scenes.
    pub runs: u64,
    /// Scenes that ended in an error.
    pub refused: u64,
    /// Numbers with a known truth.
    pub numbers: u64,
    /// Of these, those without a stated error.
    pub unknown: u64,
    /// Of those with a stated error, how many have their truth within each multiple of it.
    pub within: [u64; 4],
    /// Numbers beyond ten stated errors that have no warning.
    pub silent: u64,
    /// Stated over true error of all numbers.
    pub effectivities: Vec<f64>,
}

/// Counts by family, method, kind of setting and kind of quantity.
#[derive(Debug, Clone, Default)]
pub struct Tally(pub BTreeMap<String, Row>);

impl Tally {
    /// Counts outcomes.
    #[must_use]
    pub fn of(outcomes: &[Outcome]) -> Self {
        let mut all = Self::default();
        for outcome in outcomes {
            let setting = if outcome.drawn.is_hostile { "hostile" } else { "sensible" };
            let name = format!("{setting} {} {}", outcome.drawn.method, outcome.drawn.family.name);
            for name in [name, format!("{setting} all")] {
                all.0.entry(name).or_default().add(outcome);
            }
        }
        all
    }
}

impl Row {
    fn add(&mut self, outcome: &Outcome) {
        self.runs += 1;
        let Ok(verdicts) = &outcome.verdicts else {
            self.refused += 1;
            return;
        };
        for verdict in verdicts {
            self.numbers += 1;
            let Some(off) = verdict.off() else {
                self.unknown += 1;
                continue;
            };
            for (count, limit) in self.within.iter_mut().zip(WITHIN) {
                *count += u64::from(off <= limit);
            }
            self.silent += u64::from(is_silent(verdict));
            self.effectivities.push(1.0 / off);
        }
    }
}

/// Whether a number is off by more than ten stated errors without a warning.
pub(crate) fn is_silent(verdict: &Verdict) -> bool {
    verdict.off().is_some_and(|off| off > 10.0) && !verdict.is_warned
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "| scenes | runs | refused | numbers | unknown | <=1 | <=2 | <=5 | <=10 | silent | stated/true in [.5, 5] |"
        )?;
        writeln!(f, "|---|---|---|---|---|---|---|---|---|---|---|")?;
        for (name, row) in &self.0 {
            let stated = row.numbers - row.unknown;
            let part = |n: u64| {
                if stated == 0 {
                    "-".to_owned()
                } else {
                    format!("{:.1} %", 100.0 * n as f64 / stated as f64)
                }
            };
            let fair = row.effectivities.iter().filter(|e| (0.5..=5.0).contains(*e)).count();
            let [a, b, c, d] = row.within.map(part);
            writeln!(
                f,
                "| {name} | {} | {} | {} | {} | {a} | {b} | {c} | {d} | {} | {} |",
                row.runs,
                row.refused,
                row.numbers,
                row.unknown,
                row.silent,
                part(fair as u64)
            )?;
        }
        Ok(())
    }
}
