//! A few numbers of a crack and of its load: what an inference compares.

use super::record::CrackRecord;
use crate::error::{Error, positive};
use crate::path::height_at;

/// What of the load is a summary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadSummary {
    /// Nothing.
    None,
    /// The largest mean of a window (force).
    FailureLoad,
    /// Its natural logarithm: nearer to a line in the logarithm of a strength.
    LogFailureLoad,
}

/// Which numbers of a realisation are its summaries: heights, then the load.
#[derive(Debug, Clone, PartialEq)]
pub struct SummaryConfig {
    /// The abscissae at which the height of the path is taken (length); empty for the load alone.
    pub abscissae: Vec<f64>,
    /// What of the load.
    pub load: LoadSummary,
}

/// Summaries of realisations, and the numbers of those without, by reason.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CrackSummaries {
    /// A row of numbers for each realisation that has all of them.
    pub rows: Vec<Vec<f64>>,
    /// The run failed, or the body broke elsewhere.
    pub failed: usize,
    /// Heights are asked for and the crack did not come to all abscissae, or there was none.
    pub short: usize,
    /// A load is asked for and was not observed.
    pub no_load: usize,
}

impl SummaryConfig {
    /// The summaries of records.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the logarithm of a load.
    pub fn of_records(&self, records: &[CrackRecord]) -> Result<CrackSummaries, Error> {
        let mut found = CrackSummaries::default();
        for record in records {
            if !record.outcome.counts() {
                found.failed += 1;
                continue;
            }
            let heights = self.abscissae.iter().map(|&x| height_at(&record.path, x));
            let Some(mut row) = heights.collect::<Option<Vec<f64>>>() else {
                found.short += 1;
                continue;
            };
            match (self.load, record.failure_load) {
                (LoadSummary::None, _) => {}
                (_, None) => {
                    found.no_load += 1;
                    continue;
                }
                (LoadSummary::FailureLoad, Some(load)) => row.push(load),
                (LoadSummary::LogFailureLoad, Some(load)) => {
                    positive("a failure load", load)?;
                    row.push(simd_lanes::ln(load));
                }
            }
            found.rows.push(row);
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;
    use crate::CrackPath;
    use crate::statistics::CrackOutcome;

    fn record(k: u64, end: f64, load: Option<f64>) -> CrackRecord {
        let path = CrackPath::from_points(vec![[0.0; 2], [end, end * k as f64]]).unwrap();
        CrackRecord::of_path(k, Some(&path), None, load)
    }

    #[test]
    fn heights_come_first_and_realisations_without_summaries_are_counted_by_reason() {
        let mut records = vec![record(1, 4.0, Some(5.0)), record(2, 2.5, Some(6.0))];
        records.push(record(3, 4.0, None));
        records.push(CrackRecord::without_crack(3, CrackOutcome::GripsBroken));
        records.push(CrackRecord::of_path(4, None, None, Some(7.0)));
        let config = SummaryConfig { abscissae: vec![1.0, 3.0], load: LoadSummary::LogFailureLoad };
        let found = config.of_records(&records).unwrap();
        assert_eq!((found.failed, found.short, found.no_load), (1, 2, 1));
        assert_eq!(found.rows.len(), 1);
        for (value, expected) in found.rows[0].iter().zip([1.0, 3.0, 5.0_f64.ln()]) {
            assert!((value - expected).abs() < 1e-15);
        }
        let alone = SummaryConfig { abscissae: vec![], load: LoadSummary::FailureLoad };
        assert_eq!(alone.of_records(&records).unwrap().rows, [[5.0], [6.0], [7.0]]);
        let below = [record(0, 1.0, Some(-1.0))];
        let config = SummaryConfig { abscissae: vec![], load: LoadSummary::LogFailureLoad };
        assert!(matches!(config.of_records(&below), Err(Error::Parameter { .. })));
    }
}
