//! Cholesky factor of a small covariance.

/// The lower triangle `L` of `A = L L^T`, row after row of length `n`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cholesky {
    n: usize,
    rows: Vec<f64>,
}

/// A pivot that is not above its limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SmallPivot {
    pub(crate) row: usize,
    pub(crate) value: f64,
    pub(crate) limit: f64,
}

impl Cholesky {
    /// Of a symmetric matrix. Pivots must exceed the part `least` of the diagonal entry of their row.
    pub(crate) fn new(n: usize, mut matrix: Vec<f64>, least: f64) -> Result<Self, SmallPivot> {
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
                let value = matrix[i * n + j] - known;
                if i > j {
                    matrix[i * n + j] = value / matrix[j * n + j];
                    continue;
                }
                let limit = least * matrix[i * n + i];
                if value.is_nan() || value <= limit {
                    return Err(SmallPivot { row: i, value, limit });
                }
                matrix[i * n + i] = value.sqrt();
            }
        }
        Ok(Self { n, rows: matrix })
    }

    /// Replaces the rows of `b`, each of length `width`, by those of `L^-1 b`.
    pub(crate) fn solve_lower(&self, b: &mut [f64], width: usize) {
        for i in 0..self.n {
            let (done, rest) = b.split_at_mut(i * width);
            let row = &mut rest[..width];
            for j in 0..i {
                let factor = self.rows[i * self.n + j];
                for (x, known) in row.iter_mut().zip(&done[j * width..(j + 1) * width]) {
                    *x -= factor * known;
                }
            }
            for x in row {
                *x /= self.rows[i * self.n + i];
            }
        }
    }
}
