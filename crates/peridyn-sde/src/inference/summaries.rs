//! A few numbers of a crack and of a load curve.

use sde_integrators::Estimate;

use crate::ensemble::CrackRun;
use crate::error::{Error, at_least, finite};
use crate::path::height_at;
use crate::statistics::CrackRecord;

/// What of the load curve is a summary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadSummary {
    /// Nothing.
    None,
    /// The largest mean of a window (force).
    FailureLoad,
    /// Its natural logarithm: nearer to a line in the logarithm of a strength.
    LogFailureLoad,
    /// The mean of every window (force).
    Windows,
}

/// Which numbers of a realisation are its summaries: heights, then loads.
#[derive(Debug, Clone, PartialEq)]
pub struct SummaryConfig {
    /// The abscissae at which the height of the path is taken (length); empty for the load alone.
    pub abscissae: Vec<f64>,
    /// What of the load curve.
    pub load: LoadSummary,
}

/// Realisations without summaries, by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Absent {
    /// The run failed, or the body broke elsewhere.
    pub failed: usize,
    /// Heights are asked for and the crack did not come to all abscissae, or there was none.
    pub short: usize,
    /// A load is asked for and was not observed.
    pub no_load: usize,
}

impl Absent {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> usize {
        self.failed + self.short + self.no_load
    }
}

/// The summaries of the realisations that have all of them: `n` rows of `K` numbers. The others are counted.
///
/// A likelihood made of them is that of a plate given that its summaries exist: do not omit plates with shorter cracks from the
/// data because of their values. The information in the probability of a complete crack is not used.
/// [`Summaries::share`] returns this probability.
#[derive(Debug, Clone, PartialEq)]
pub struct Summaries {
    width: usize,
    values: Vec<f64>,
    absent: Absent,
}

impl Summaries {
    /// From rows of equal length, one for each realisation that has its summaries.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no row or rows without a number, [`Error::Count`] for rows of different lengths,
    /// [`Error::NotFinite`].
    pub fn new(rows: &[Vec<f64>], absent: Absent) -> Result<Self, Error> {
        at_least("realisations with summaries", rows.len(), 1)?;
        let width = rows[0].len();
        at_least("summaries", width, 1)?;
        for row in rows {
            same_count("summaries of a realisation", row.len(), width)?;
            row.iter().try_for_each(|&value| finite("a summary", value))?;
        }
        Ok(Self { width, values: rows.concat(), absent })
    }

    /// How many numbers a realisation has, `K`.
    #[must_use]
    pub fn n_summaries(&self) -> usize {
        self.width
    }

    /// How many realisations have them, `n`.
    #[must_use]
    pub fn n_realisations(&self) -> usize {
        self.values.len() / self.width
    }

    /// Those of each realisation.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.width)
    }

    /// Those without.
    #[must_use]
    pub fn absent(&self) -> Absent {
        self.absent
    }

    /// The probability that a realisation has its summaries.
    ///
    /// # Errors
    /// None that can occur: there is a realisation.
    pub fn share(&self) -> Result<Estimate, Error> {
        let n = self.n_realisations();
        Ok(Estimate::probability(n as u64, (n + self.absent.total()) as u64)?)
    }

    /// Mean (`K`) and unbiased covariance (`K` rows of `K`).
    pub(super) fn moments(&self) -> (Vec<f64>, Vec<f64>) {
        let (k, n) = (self.width, self.n_realisations() as f64);
        let mut mean = vec![0.0; k];
        for row in self.rows() {
            for i in 0..k {
                mean[i] += row[i] / n;
            }
        }
        let mut covariance = vec![0.0; k * k];
        for row in self.rows() {
            for i in 0..k {
                for j in 0..k {
                    covariance[i * k + j] += (row[i] - mean[i]) * (row[j] - mean[j]);
                }
            }
        }
        for c in &mut covariance {
            *c /= n - 1.0;
        }
        (mean, covariance)
    }
}

impl SummaryConfig {
    /// The summaries of the realisations of a run.
    ///
    /// # Errors
    /// As [`SummaryConfig::of_records`].
    pub fn of_run(&self, run: &CrackRun) -> Result<Summaries, Error> {
        self.of_records(&run.records, &run.loads)
    }

    /// The summaries of records, with the means of the windows of the load of each; these may be empty where they are not asked
    /// for.
    ///
    /// # Errors
    /// [`Error::Count`] for loads of other realisations or of another number of windows; [`Error::NotFinite`];
    /// [`Error::NotPositive`] for the logarithm of a load; [`Error::TooFew`] where no realisation has summaries.
    pub fn of_records(
        &self,
        records: &[CrackRecord],
        loads: &[Vec<f64>],
    ) -> Result<Summaries, Error> {
        same_count("load curves", loads.len(), records.len())?;
        let (mut rows, mut absent) = (vec![], Absent::default());
        for (record, loads) in records.iter().zip(loads) {
            if !record.outcome.counts() {
                absent.failed += 1;
                continue;
            }
            let heights = self.abscissae.iter().map(|&x| height_at(&record.path, x));
            let Some(mut row) = heights.collect::<Option<Vec<f64>>>() else {
                absent.short += 1;
                continue;
            };
            if let Some(load) = self.load(record, loads)? {
                row.extend(load);
                rows.push(row);
            } else {
                absent.no_load += 1;
            }
        }
        Summaries::new(&rows, absent)
    }

    fn load(&self, record: &CrackRecord, loads: &[f64]) -> Result<Option<Vec<f64>>, Error> {
        let alone = |load: f64| vec![load];
        Ok(match self.load {
            LoadSummary::None => Some(vec![]),
            LoadSummary::FailureLoad => record.failure_load.map(alone),
            LoadSummary::LogFailureLoad => match record.failure_load {
                Some(load) => {
                    crate::error::positive("a failure load", load)?;
                    Some(alone(simd_lanes::ln(load)))
                }
                None => None,
            },
            LoadSummary::Windows => Some(loads.to_vec()).filter(|loads| !loads.is_empty()),
        })
    }
}

pub(super) fn same_count(name: &'static str, value: usize, expected: usize) -> Result<(), Error> {
    if value == expected { Ok(()) } else { Err(Error::Count { name, value, expected }) }
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
        let loads = vec![vec![]; 5];
        let summaries = config.of_records(&records, &loads).unwrap();
        let rows: Vec<&[f64]> = summaries.rows().collect();
        assert_eq!(rows.len(), 1);
        for (value, expected) in rows[0].iter().zip([1.0, 3.0, 5.0_f64.ln()]) {
            assert!((value - expected).abs() < 1e-15);
        }
        assert_eq!(summaries.absent(), Absent { failed: 1, short: 2, no_load: 1 });
        assert!((summaries.share().unwrap().value - 0.2).abs() < 1e-15);
        let alone = SummaryConfig { abscissae: vec![], load: LoadSummary::FailureLoad };
        let loads_alone = alone.of_records(&records, &loads).unwrap();
        assert_eq!(loads_alone.rows().collect::<Vec<_>>(), [[5.0], [6.0], [7.0]]);
    }

    #[test]
    fn windows_are_taken_whole_and_of_one_length() {
        let config = SummaryConfig { abscissae: vec![], load: LoadSummary::Windows };
        let records = [record(0, 1.0, None), record(1, 1.0, None)];
        let taken = config.of_records(&records, &[vec![1.0, 2.0], vec![3.0, 4.0]]).unwrap();
        assert_eq!(taken.rows().collect::<Vec<_>>(), [[1.0, 2.0], [3.0, 4.0]]);
        let refused = config.of_records(&records, &[vec![1.0, 2.0], vec![3.0]]);
        assert!(matches!(refused, Err(Error::Count { value: 1, expected: 2, .. })));
        let refused = config.of_records(&records, &[vec![1.0, 2.0]]);
        assert!(matches!(refused, Err(Error::Count { value: 1, expected: 2, .. })));
    }

    #[test]
    fn numbers_that_are_none_and_ensembles_without_summaries_are_refused() {
        let of = |rows: &[Vec<f64>]| Summaries::new(rows, Absent::default());
        assert!(matches!(of(&[vec![1.0, f64::NAN]]), Err(Error::NotFinite { .. })));
        assert!(matches!(of(&[]), Err(Error::TooFew { .. })));
        assert!(matches!(of(&[vec![]]), Err(Error::TooFew { .. })));
        assert!(matches!(of(&[vec![1.0], vec![1.0, 2.0]]), Err(Error::Count { .. })));
    }

    #[test]
    fn moments_are_those_of_the_rows() {
        let rows = [vec![1.0, 2.0], vec![3.0, 2.0], vec![5.0, 5.0]];
        let (mean, covariance) = Summaries::new(&rows, Absent::default()).unwrap().moments();
        let (expected_mean, expected) = ([3.0, 3.0], [4.0, 3.0, 3.0, 3.0]);
        assert!(mean.iter().zip(expected_mean).all(|(a, b)| (a - b).abs() < 1e-15));
        assert!(covariance.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14));
    }
}
