//! How often the truth lies within the stated errors.

use std::collections::BTreeMap;
use std::fmt;

use scenes::answers::ErrorOrigin;

use crate::{Outcome, Verdict};

/// Multiples of the stated error within which the truth is counted.
const WITHIN: [f64; 4] = [1.0, 2.0, 5.0, 10.0];

/// Counts of some numbers.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Scenes.
    pub runs: u64,
    /// Scenes that ended in an error other than the limit on the time.
    pub refused: u64,
    /// Scenes that would have taken longer than the hunt allows.
    pub too_long: u64,
    /// Numbers with a known truth.
    pub numbers: u64,
    /// Of these, those without a stated error.
    pub unknown: u64,
    /// Of those with a stated error, how many have their truth within each multiple of it.
    pub within: [u64; 4],
    /// Numbers beyond ten stated errors that have no warning.
    pub silent: u64,
    /// Numbers with a stated error that is a bound: it may be far above the true one.
    pub bounds: u64,
    /// Other numbers whose stated error is between half and five times the true one, or both of which are roundoff.
    pub fair: u64,
}

/// Counts at sensible and at hostile settings: of all, by method and family, and by kind of quantity.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Of all scenes.
    pub all: BTreeMap<String, Row>,
    /// By family and method.
    pub by_method: BTreeMap<String, Row>,
    /// By kind of quantity: the first word of its id.
    pub by_quantity: BTreeMap<String, Row>,
}

impl Tally {
    /// Counts outcomes.
    #[must_use]
    pub fn of(outcomes: &[Outcome]) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            let setting = if outcome.drawn.is_hostile { "hostile" } else { "sensible" };
            let (family, method) = (outcome.drawn.family.name, outcome.drawn.method);
            let verdicts = outcome.verdicts.as_deref().unwrap_or_default();
            for row in [
                tally.all.entry(setting.to_owned()).or_default(),
                tally.by_method.entry(format!("{family}, {method}, {setting}")).or_default(),
            ] {
                row.count(outcome);
                for verdict in verdicts {
                    row.add(verdict);
                }
            }
            for verdict in verdicts {
                let kind = verdict.truth.id.split('/').next().unwrap_or_default();
                tally.by_quantity.entry(format!("{kind}, {setting}")).or_default().add(verdict);
            }
        }
        tally
    }
}

impl Row {
    fn count(&mut self, outcome: &Outcome) {
        self.runs += 1;
        if let Err(error) = &outcome.verdicts {
            // `Pace` says so.
            let is_too_long = error.contains("s are allowed");
            *(if is_too_long { &mut self.too_long } else { &mut self.refused }) += 1;
        }
    }

    fn add(&mut self, verdict: &Verdict) {
        self.numbers += 1;
        let Some(off) = verdict.off() else {
            self.unknown += 1;
            return;
        };
        for (count, limit) in self.within.iter_mut().zip(WITHIN) {
            *count += u64::from(off <= limit);
        }
        self.silent += u64::from(verdict.is_silent());
        if verdict.number.error_kind == ErrorOrigin::Bound {
            self.bounds += 1;
        } else {
            self.fair += u64::from((0.2..=2.0).contains(&off) || verdict.is_of_roundoff());
        }
    }

    /// Numbers with a stated error.
    const fn stated(&self) -> u64 {
        self.numbers - self.unknown
    }

    /// Part of the numbers with a stated error whose truth lies within two of them.
    #[must_use]
    pub fn within_two(&self) -> f64 {
        part(self.within[1], self.stated()).unwrap_or(1.0)
    }

    /// Part of the scenes that ended in an error.
    #[must_use]
    pub fn refused_part(&self) -> f64 {
        self.refused as f64 / (self.runs - self.too_long).max(1) as f64
    }
}

/// A part of a number of things; none of no thing.
fn part(count: u64, of: u64) -> Option<f64> {
    (of > 0).then(|| count as f64 / of as f64)
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &Self { runs, refused, too_long, numbers, unknown, silent, fair, .. } = self;
        if runs > 0 {
            write!(f, "{runs} | {refused} | {too_long}")?;
        } else {
            write!(f, " | | ")?;
        }
        write!(f, " | {numbers} | {unknown}")?;
        let estimates = self.stated() - self.bounds;
        let within = self.within.map(|count| part(count, self.stated()));
        for share in within.into_iter().chain([part(fair, estimates)]) {
            match share {
                Some(part) => write!(f, " | {:.1} %", 100.0 * part)?,
                None => write!(f, " | ")?,
            }
        }
        write!(f, " | {silent}")
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (of, rows) in [
            ("settings", &self.all),
            ("family, method, settings", &self.by_method),
            ("quantity, settings", &self.by_quantity),
        ] {
            writeln!(
                f,
                "| {of} | runs | refused | too long | numbers | unknown | within 1 | 2 | 5 | 10 | stated/true in [0.5, 5] | silent beyond 10 |"
            )?;
            writeln!(f, "|---|---|---|---|---|---|---|---|---|---|---|---|")?;
            for (name, row) in rows {
                writeln!(f, "| {name} | {row} |")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
