//! The first-order variance of responses by fewer runs than there are coefficients.

use perturbation_moments::MonteCarlo;

use super::field_study::{FieldExperiment, FieldStudy};
use crate::error::Error;

/// A direction that adds less than this part of its length to the ones before is one of them, within roundoff.
const ROUNDOFF: f64 = 1e-8;

/// The first-order variance of a response, of which a part is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CapturedVariance {
    /// By the slopes along orthonormal directions: a lower bound of the first-order variance.
    pub captured: f64,
    /// An unbiased estimate of the rest, by slopes along random directions at right angles to these.
    pub rest: f64,
    /// Its standard error: the rest times $\sqrt{2/r}$ for `r` random directions, as far as the slopes are normal.
    pub rest_standard_error: f64,
}

impl CapturedVariance {
    /// The first-order variance.
    #[must_use]
    pub fn variance(&self) -> f64 {
        self.captured + self.rest
    }
}

/// First-order variances by few runs.
#[derive(Debug, Clone, PartialEq)]
pub struct SubspaceVariance {
    /// Of every response.
    pub of_responses: Vec<CapturedVariance>,
    /// Runs in numbers, with the reference run.
    pub n_runs: usize,
}

impl<X: FieldExperiment<D>, const D: usize> FieldStudy<'_, X, D> {
    /// The first-order variance $|g|^2$ of every response by one-sided differences along given directions, made orthonormal, and along
    /// `n_random` random ones at right angles to them:
    ///
    /// $$ |g|^2 = \sum_{j=1}^m (g \cdot q_j)^2 + |P g|^2, \qquad \operatorname{E} (n - m)(g \cdot u)^2 = |P g|^2 $$
    ///
    /// Symbols: `n` coefficients, `m` directions, `P` = projection at right angles to them, `u` = a direction of length one, uniform in
    /// the image of `P`. Directions that matter are the modes of a field at the places of gauges and around them: the gradient of a
    /// response to constants at points is a combination of the modes there.
    ///
    /// # Errors
    /// As [`forward_differences`](Self::forward_differences).
    pub fn subspace_variance(
        &self,
        step: f64,
        directions: &[Vec<f64>],
        (n_random, seed): (usize, u64),
    ) -> Result<SubspaceVariance, Error> {
        let n = self.n_coefficients();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for direction in directions {
            self.check(direction.len())?;
            basis.extend(orthonormal_to(&basis, direction));
        }
        let m = basis.len();
        let mut all = basis.clone();
        if m < n {
            let judge = MonteCarlo { seed, n_samples: 0 };
            for realisation in 0..n_random as u64 {
                let mut normals = vec![0.0; n];
                judge.fill_normals(realisation, &mut normals);
                all.extend(orthonormal_to(&basis, &normals));
            }
        }
        let slopes = self.forward_differences(step, &all)?;
        let of = |slopes: &Vec<f64>| {
            let squares = |slopes: &[f64]| slopes.iter().map(|slope| slope * slope).sum::<f64>();
            let (known, random) = slopes.split_at(m);
            let count = random.len().max(1) as f64;
            let rest = squares(random) * (n - m) as f64 / count;
            CapturedVariance {
                captured: squares(known),
                rest,
                rest_standard_error: rest * (2.0 / count).sqrt(),
            }
        };
        let of_responses = slopes.iter().map(of).collect();
        Ok(SubspaceVariance { of_responses, n_runs: 1 + all.len() })
    }
}

/// The part of a vector at right angles to a basis, of length one; `None` where nothing but roundoff is left.
fn orthonormal_to(basis: &[Vec<f64>], vector: &[f64]) -> Option<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut rest = vector.to_vec();
    let whole = dot(&rest, &rest).sqrt();
    // Twice is enough (Kahan; Parlett 1980, section 6-9).
    for _ in 0..2 {
        for q in basis {
            let along = dot(q, &rest);
            rest.iter_mut().zip(q).for_each(|(rest, q)| *rest -= along * q);
        }
    }
    let length = dot(&rest, &rest).sqrt();
    (length > ROUNDOFF * whole).then(|| rest.iter().map(|x| x / length).collect())
}
