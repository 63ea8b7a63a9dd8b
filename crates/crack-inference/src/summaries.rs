//! A few numbers of each realisation or plate: heights of a crack, a failure load.

use sde_integrators::Estimate;

use crate::error::{Error, at_least, finite, same_count};

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
    pub(crate) fn moments(&self) -> (Vec<f64>, Vec<f64>) {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;

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
