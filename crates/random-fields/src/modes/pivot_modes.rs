//! Modes of any correlation from points that cover a body.

use crate::correlations::spatial_correlation::SpatialCorrelation;
use crate::error::{Error, positive, same_length};
use crate::modes::truncation::Truncation;
use crate::pivoted_cholesky::{Enough, LowRank, pivoted_cholesky};
use crate::symmetric_eigen::symmetric_eigen;

/// Most pivots: their eigenvalue problem then takes some ten seconds.
pub(crate) const MOST_PIVOTS: usize = 1500;
/// Pivots for each term, where terms are counted.
const PIVOTS_PER_TERM: usize = 4;

/// Karhunen-Loève modes of the covariance that a Gaussian process has through pivots.
///
/// With the pivots `P` of a pivoted Cholesky factor, $K_{PP} = L L^T$, and $v(x) = L^{-1} k(P, x)$ the covariance
/// $v(x)^T v(y)$ is the correlation less that of what is left when the values at the pivots are known. Modes are
/// $\phi_j(x) = q_j^T v(x)$ with the eigenvectors $q_j$ of
///
/// $$ M = \sum_i w_i v(x_i) v(x_i)^T, \qquad \sum_i w_i = 1, $$
///
/// whose eigenvalues are the means of $\phi_j^2$ over the points that cover the body. $\phi(x) = k(x, P) B$ with
/// $B = L^{-T} Q$.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PivotModes<const D: usize> {
    correlation: SpatialCorrelation<D>,
    pivots: Vec<[f64; D]>,
    /// `B`, a row for each pivot.
    weights: Vec<f64>,
    shares: Vec<f64>,
}

impl<const D: usize> PivotModes<D> {
    /// From points with volumes; bounds and correlation are checked.
    pub(crate) fn new(
        points: &[[f64; D]],
        volumes: &[f64],
        correlation: &SpatialCorrelation<D>,
        truncation: Truncation,
    ) -> Result<Self, Error> {
        same_length("volumes of the points", volumes.len(), points.len())?;
        for (point, &value) in volumes.iter().enumerate() {
            if !(value > 0.0 && value.is_finite()) {
                let must = "greater than 0 and finite";
                return Err(Error::Point { name: "the volume", point, value, must });
            }
        }
        let whole: f64 = volumes.iter().sum();
        positive("volume of all points", whole)?;
        let roots: Vec<f64> = volumes.iter().map(|volume| (volume / whole).sqrt()).collect();
        let factor = cover(points, &roots, correlation, truncation)?;
        Self::from_factor(points, &roots, correlation, truncation, &factor)
    }

    /// From the factor of the covariance with rows and columns times the roots of the parts of the volume.
    fn from_factor(
        points: &[[f64; D]],
        roots: &[f64],
        correlation: &SpatialCorrelation<D>,
        truncation: Truncation,
        factor: &LowRank,
    ) -> Result<Self, Error> {
        let (n, k) = (points.len(), factor.pivots.len());
        let column = |j: usize| &factor.columns[j * n..(j + 1) * n];
        let mut moments = vec![0.0; k * k];
        for i in 0..k {
            for j in 0..=i {
                let moment = column(i).iter().zip(column(j)).map(|(a, b)| a * b).sum();
                moments[i * k + j] = moment;
                moments[j * k + i] = moment;
            }
        }
        let eigen = symmetric_eigen(k, moments)?;
        let n_terms = n_terms(truncation, &eigen.values, n)?;
        let mut weights = vec![0.0; k * n_terms];
        // L^T B = Q: L has the rows of the pivots, of which later columns are zero, over their roots.
        let l = |row: usize, j: usize| {
            let pivot = factor.pivots[row];
            column(j)[pivot] / roots[pivot]
        };
        for i in (0..k).rev() {
            for term in 0..n_terms {
                let known: f64 =
                    (i + 1..k).map(|row| l(row, i) * weights[row * n_terms + term]).sum();
                weights[i * n_terms + term] = (eigen.vectors[term * k + i] - known) / l(i, i);
            }
        }
        let pivots = factor.pivots.iter().map(|&pivot| points[pivot]).collect();
        let shares = eigen.values[..n_terms].to_vec();
        Ok(Self { correlation: *correlation, pivots, weights, shares })
    }

    pub(crate) fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// The weight of each pivot in a realisation: `B xi`.
    pub(crate) fn pivot_weights(&self, coefficients: &[f64]) -> Vec<f64> {
        let rows = self.weights.chunks_exact(self.shares.len());
        rows.map(|row| row.iter().zip(coefficients).map(|(b, xi)| b * xi).sum()).collect()
    }

    /// A realisation at a point, from the weights of its pivots.
    pub(crate) fn value(&self, pivot_weights: &[f64], x: &[f64; D]) -> f64 {
        let pivots = self.pivots.iter().zip(pivot_weights);
        pivots.map(|(pivot, weight)| self.correlation.between(x, pivot) * weight).sum()
    }

    /// All terms at a point.
    pub(crate) fn values(&self, x: &[f64; D], out: &mut [f64]) {
        out.fill(0.0);
        let rows = self.weights.chunks_exact(self.shares.len());
        for (pivot, row) in self.pivots.iter().zip(rows) {
            let correlation = self.correlation.between(x, pivot);
            for (out, weight) in out.iter_mut().zip(row) {
                *out += correlation * weight;
            }
        }
    }
}

/// A pivoted factor of the covariance of the points, weighed by their parts of the volume, so that its trace is the mean variance.
/// For a share it leaves half of what may be left, the other half is for the truncation of modes.
fn cover<const D: usize>(
    points: &[[f64; D]],
    roots: &[f64],
    correlation: &SpatialCorrelation<D>,
    truncation: Truncation,
) -> Result<LowRank, Error> {
    let entry =
        |i: usize, j: usize| roots[i] * roots[j] * correlation.between(&points[i], &points[j]);
    let (left, n_pivots) = match truncation {
        Truncation::Terms(asked) => (0.0, asked.saturating_mul(PIVOTS_PER_TERM).min(MOST_PIVOTS)),
        Truncation::Share(asked) => (0.5 * (1.0 - asked), MOST_PIVOTS),
    };
    let factor = pivoted_cholesky(points.len(), entry, Enough::TraceOrColumns(left, n_pivots))?;
    if let Truncation::Share(asked) = truncation {
        let reached = 1.0 - factor.rest.iter().sum::<f64>();
        if reached < asked {
            return Err(Error::TooManyTerms { n_terms: factor.pivots.len(), reached, asked });
        }
    }
    Ok(factor)
}

/// How many modes are kept.
fn n_terms(truncation: Truncation, shares: &[f64], n_points: usize) -> Result<usize, Error> {
    let roundoff = shares.len() as f64 * f64::EPSILON * shares[0];
    let available = shares.iter().take_while(|&&share| share > roundoff).count();
    match truncation {
        Truncation::Terms(asked) if asked > available => {
            Err(Error::TooFewPoints { asked, available, n_points })
        }
        Truncation::Terms(asked) => Ok(asked),
        Truncation::Share(asked) => {
            let mut sum = 0.0;
            for (count, share) in shares.iter().enumerate().take(available) {
                sum += share;
                if sum >= asked {
                    return Ok(count + 1);
                }
            }
            Err(Error::TooManyTerms { n_terms: available, reached: sum, asked })
        }
    }
}
