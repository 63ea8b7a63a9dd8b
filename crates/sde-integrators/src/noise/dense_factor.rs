//! Noise factor of a full covariance.

use crate::error::Error;
use crate::noise::cholesky::Cholesky;
use crate::noise::components::{Block, entries, for_components, multiply, multiply_transposed};
use crate::noise::noise_factor::{NoiseFactor, require_finite, require_length};

/// Cholesky factor of a full covariance, for a few thousand unknowns: `O(n^3)` once, `O(n^2)` per step.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseFactor {
    n: usize,
    /// Rows in sequence, each up to its diagonal.
    rows: Vec<f64>,
}

impl DenseFactor {
    /// Factorises the covariance per unit of time, given row by row.
    ///
    /// It must be positive definite, and symmetric to `1e-12` of its diagonal.
    ///
    /// # Errors
    /// [`Error::WrongLength`], [`Error::NotFinite`], [`Error::CovarianceNotSymmetric`],
    /// [`Error::CovarianceNotPositiveDefinite`] with the first row that fails.
    pub fn new(n: usize, covariance: &[f64]) -> Result<Self, Error> {
        require_symmetric(n, covariance)?;
        let factor = Cholesky::new(n, covariance.to_vec(), 0.0)
            .map_err(|small| Error::CovarianceNotPositiveDefinite { row: small.row })?;
        Ok(Self { n, rows: factor.into_packed() })
    }

    /// The same by faer, for large covariances: as fast up to 1,000 unknowns, 1.6 times as fast with 2,000, 2.2 with 4,000.
    ///
    /// Its sums, and so the last bits of the factor, depend on the registers of the machine.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    #[cfg(feature = "faer")]
    pub fn by_faer(n: usize, covariance: &[f64]) -> Result<Self, Error> {
        require_symmetric(n, covariance)?;
        let matrix = faer::Mat::from_fn(n, n, |row, column| covariance[row * n + column]);
        let factor = matrix.llt(faer::Side::Lower).map_err(|error| match error {
            faer::linalg::solvers::LltError::NonPositivePivot { index } => {
                Error::CovarianceNotPositiveDefinite { row: index }
            }
        })?;
        let l = factor.L();
        let rows = (0..n).flat_map(|row| (0..=row).map(move |column| l[(row, column)])).collect();
        Ok(Self { n, rows })
    }

    /// Row `i` of the triangle, up to its diagonal.
    ///
    /// # Panics
    /// If there is no such row, as in slice indexing.
    #[must_use]
    pub fn row(&self, i: usize) -> &[f64] {
        // Number of entries before row i: 1 + 2 + .. + i.
        &self.rows[i * (i + 1) / 2..(i + 1) * (i + 2) / 2]
    }

    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        (0..self.n).map(|i| self.row(i))
    }

    for_components!();

    fn apply_block<const C: usize>(&self, of: Block, z: &[f64], result: &mut [f64]) -> usize {
        multiply::<C>(self.rows().map(entries), of, z, result)
    }

    fn apply_transposed_block<const C: usize>(
        &self,
        of: Block,
        x: &[f64],
        result: &mut [f64],
    ) -> usize {
        multiply_transposed::<C>(self.n, self.rows().map(entries), of, x, result)
    }
}

/// A square matrix of finite numbers, symmetric to `1e-12` of its diagonal.
fn require_symmetric(n: usize, covariance: &[f64]) -> Result<(), Error> {
    require_length("entries of the covariance", covariance.len(), n.saturating_mul(n))?;
    require_finite("entry of the covariance", covariance)?;
    for row in 0..n {
        for column in 0..row {
            let difference = (covariance[row * n + column] - covariance[column * n + row]).abs();
            let limit =
                1e-12 * (covariance[row * n + row] * covariance[column * n + column]).abs().sqrt();
            if difference > limit {
                return Err(Error::CovarianceNotSymmetric { row, column, difference, limit });
            }
        }
    }
    Ok(())
}

impl NoiseFactor for DenseFactor {
    fn n_unknowns(&self) -> usize {
        self.n
    }

    fn n_motions(&self) -> usize {
        self.n
    }

    fn apply(&self, z: &[f64], result: &mut [f64]) {
        for (result, row) in result.iter_mut().zip(self.rows()) {
            *result = row.iter().zip(z).map(|(l, z)| l * z).sum();
        }
    }

    fn apply_transposed(&self, x: &[f64], result: &mut [f64]) {
        result.fill(0.0);
        for (x, row) in x.iter().zip(self.rows()) {
            for (result, l) in result.iter_mut().zip(row) {
                *result += l * x;
            }
        }
    }
}
