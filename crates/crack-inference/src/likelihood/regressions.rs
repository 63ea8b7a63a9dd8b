//! Mean and covariance of summaries as numbers without constraints, one after the other.

use crate::error::Error;
use crate::factor::Factor;
use crate::summaries::Summaries;

/// Numbers that mean and covariance of `K` summaries are made of: each summary by those before it,
///
/// $$ x_i = m_i + \sum_{j < i} \phi_{ij} (x_j - m_j) + \sqrt{d_i} \epsilon_i . $$
///
/// In order: `m_i`, then `phi_ij` row after row, then `ln d_i`. They are `K (K + 3)/2`.
/// Source: Pourahmadi 1999, Joint mean-covariance models with applications to longitudinal data, eq 3.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) n_summaries: usize,
}

impl Layout {
    pub(crate) fn len(self) -> usize {
        self.n_summaries * (self.n_summaries + 3) / 2
    }

    pub(crate) fn slope(self, i: usize, j: usize) -> usize {
        self.n_summaries + i * (i - 1) / 2 + j
    }

    pub(crate) fn log_variance(self, i: usize) -> usize {
        self.len() - self.n_summaries + i
    }

    /// `U`, the inverse of `1 - phi`: lower triangle with ones on its diagonal, row after row.
    pub(crate) fn mixing(self, numbers: &[f64]) -> Vec<f64> {
        let k = self.n_summaries;
        let mut u = vec![0.0; k * k];
        for i in 0..k {
            u[i * k + i] = 1.0;
            for j in 0..i {
                let slope = numbers[self.slope(i, j)];
                for column in 0..=j {
                    u[i * k + column] += slope * u[j * k + column];
                }
            }
        }
        u
    }

    /// `U D U^T`.
    pub(crate) fn covariance(self, numbers: &[f64], mixing: &[f64]) -> Vec<f64> {
        let k = self.n_summaries;
        let variance = |i: usize| simd_lanes::exp(numbers[self.log_variance(i)]);
        let variances: Vec<f64> = (0..k).map(variance).collect();
        let mut covariance = vec![0.0; k * k];
        for i in 0..k {
            for j in 0..=i {
                let terms = (0..=j).map(|l| mixing[i * k + l] * variances[l] * mixing[j * k + l]);
                covariance[i * k + j] = terms.sum();
                covariance[j * k + i] = covariance[i * k + j];
            }
        }
        covariance
    }
}

/// These numbers, estimated from an ensemble, and the covariance of their errors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Regressions {
    pub(crate) numbers: Vec<f64>,
    /// Row after row.
    pub(crate) covariance: Vec<f64>,
    pub(crate) n_realisations: usize,
}

impl Regressions {
    /// Least squares of each summary on those before it; the logarithm of the unbiased variance of what is left, with
    /// `1/(degrees of freedom)` for the bias of a logarithm. The covariance of the errors is made of how much each realisation
    /// moves each number, so that no law is supposed (White 1980, A heteroskedasticity-consistent covariance matrix estimator).
    ///
    /// # Errors
    /// [`Error::NotPositiveDefinite`] where a summary is constant or follows from others.
    pub(crate) fn new(ensemble: &Summaries) -> Result<Self, Error> {
        let layout = Layout { n_summaries: ensemble.n_summaries() };
        let (k, n) = (layout.n_summaries, ensemble.n_realisations());
        let (mean, covariance) = ensemble.moments();
        let factor = Factor::new(k, &covariance)?;
        let freedom = |i: usize| (n - 1 - i) as f64;
        let inflation = |i: usize| (n - 1) as f64 / freedom(i);
        let mut numbers = vec![0.0; layout.len()];
        numbers[..k].copy_from_slice(&mean);
        for i in 0..k {
            let mut slopes: Vec<f64> = (0..i).map(|j| factor.at(i, j)).collect();
            factor.solve_upper(&mut slopes);
            for j in 0..i {
                numbers[layout.slope(i, j)] = slopes[j];
            }
            let variance = factor.at(i, i) * factor.at(i, i) * inflation(i);
            numbers[layout.log_variance(i)] = simd_lanes::ln(variance) + 1.0 / freedom(i);
        }
        let mut errors = vec![0.0; layout.len() * layout.len()];
        let scale = 1.0 / (n as f64 * (n - 1) as f64);
        for row in ensemble.rows() {
            let away: Vec<f64> = (0..k).map(|i| row[i] - mean[i]).collect();
            let moved = moves(layout, &factor, &away, inflation);
            for (a, line) in errors.chunks_exact_mut(layout.len()).enumerate() {
                for (error, b) in line.iter_mut().zip(&moved) {
                    *error += scale * moved[a] * b;
                }
            }
        }
        Ok(Self { numbers, covariance: errors, n_realisations: n })
    }
}

/// By how much a realisation moves each number, times the number of realisations.
fn moves(
    layout: Layout,
    factor: &Factor,
    away: &[f64],
    inflation: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let k = layout.n_summaries;
    let mut moved = vec![0.0; layout.len()];
    moved[..k].copy_from_slice(away);
    let mut whitened = away.to_vec();
    factor.solve_lower(&mut whitened);
    for i in 0..k {
        let weight = inflation(i).sqrt();
        let rest = factor.at(i, i) * whitened[i];
        let mut slopes = whitened[..i].to_vec();
        factor.solve_upper(&mut slopes);
        for j in 0..i {
            moved[layout.slope(i, j)] = weight * slopes[j] * rest;
        }
        moved[layout.log_variance(i)] = weight * (whitened[i] * whitened[i] - 1.0);
    }
    moved
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use sde_integrators::{Accumulator, Noise, Purpose};

    use super::*;
    use crate::summaries::Absent;

    /// `x_0 = 1 + 2 e_0`, `x_1 = 3 + 0.5 (x_0 - 1) + 0.1 e_1`.
    fn ensemble(id: u64, n: usize) -> Summaries {
        let mut stream = Noise::new(4).stream(Purpose::Field, id);
        let rows: Vec<Vec<f64>> = (0..n)
            .map(|_| {
                let [a, b] = stream.next_normal_pair();
                vec![1.0 + 2.0 * a, 3.0 + a + 0.1 * b]
            })
            .collect();
        Summaries::new(&rows, Absent::default()).unwrap()
    }

    #[test]
    fn numbers_are_those_of_the_law_and_their_errors_those_of_repetitions() {
        let expected = [1.0, 3.0, 0.5, 4_f64.ln(), 0.01_f64.ln()];
        let (mut found, mut stated) = ([Accumulator::default(); 5], [Accumulator::default(); 5]);
        for id in 0..1000 {
            let of = Regressions::new(&ensemble(id, 60)).unwrap();
            for i in 0..5 {
                found[i].push(of.numbers[i]);
                stated[i].push(of.covariance[i * 6]);
            }
        }
        for i in 0..5 {
            let mean = found[i].estimate().unwrap();
            // The logarithm of a variance is biased by 1/(3 nu^2) after its correction: 1e-4.
            let error = (mean.value - expected[i]).abs();
            assert!(error < 4.0 * mean.standard_error().unwrap() + 2e-4, "{i}: {mean}");
            // A variance from 1000 repetitions has an error of 4.5 %; the sandwich is biased by some 1/n, kurtosis and all.
            let ratio = stated[i].mean() / found[i].variance().unwrap();
            assert!((ratio - 1.0).abs() < 4.0 * 0.045 + 0.06, "{i}: {ratio}");
        }
    }

    #[test]
    fn covariance_made_of_the_numbers_is_the_one_they_came_from() {
        let ensemble = ensemble(0, 1_000);
        let layout = Layout { n_summaries: 2 };
        let numbers = Regressions::new(&ensemble).unwrap().numbers;
        let made = layout.covariance(&numbers, &layout.mixing(&numbers));
        let (_, expected) = ensemble.moments();
        // But for factors of 1 + O(2/n) on the variances.
        for (made, expected) in made.iter().zip(&expected) {
            assert!((made / expected - 1.0).abs() < 4e-3, "{made} {expected}");
        }
    }
}
