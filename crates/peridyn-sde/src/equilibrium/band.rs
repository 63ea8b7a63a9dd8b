//! Cholesky factor of a symmetric band matrix.

use crate::error::Error;

/// The lower half of a symmetric matrix whose entries farther than `width` from the diagonal are zero, row by row; once
/// factored, its Cholesky factor.
#[derive(Debug, Clone, Default)]
pub(super) struct Band {
    width: usize,
    n: usize,
    rows: Vec<f64>,
}

impl Band {
    pub(super) fn zero(n: usize, width: usize) -> Self {
        Self { width, n, rows: vec![0.0; n * (width + 1)] }
    }

    /// Where the entry of a row and a column at most as large is.
    fn at(&self, row: usize, column: usize) -> usize {
        row * (self.width + 1) + column + self.width - row
    }

    /// Adds to an entry and its mirror image, given once.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        let at = self.at(row.max(column), row.min(column));
        self.rows[at] += value;
    }

    pub(super) fn diagonal(&self, row: usize) -> f64 {
        self.rows[self.at(row, row)]
    }

    /// Replaces the matrix by its factor.
    pub(super) fn factor(&mut self) -> Result<(), Error> {
        for row in 0..self.n {
            let first = row.saturating_sub(self.width);
            for column in first..=row {
                // Both rows from the first column that they share.
                let from = first.max(column.saturating_sub(self.width));
                let (a, b) = (self.at(row, from), self.at(column, from));
                let length = column - from;
                let dot: f64 = self.rows[a..a + length]
                    .iter()
                    .zip(&self.rows[b..b + length])
                    .map(|(a, b)| a * b)
                    .sum();
                let at = self.at(row, column);
                let rest = self.rows[at] - dot;
                if column < row {
                    self.rows[at] = rest / self.diagonal(column);
                } else if rest > 0.0 {
                    self.rows[at] = rest.sqrt();
                } else {
                    return Err(Error::NotPositiveDefinite { row, limit: 0.0 });
                }
            }
        }
        Ok(())
    }

    /// Solves with the factor, in place.
    pub(super) fn solve(&self, x: &mut [f64]) {
        for row in 0..self.n {
            let first = row.saturating_sub(self.width);
            let at = self.at(row, first);
            let known = &x[first..row];
            let dot: f64 =
                self.rows[at..at + known.len()].iter().zip(known).map(|(a, x)| a * x).sum();
            x[row] = (x[row] - dot) / self.diagonal(row);
        }
        for row in (0..self.n).rev() {
            let first = row.saturating_sub(self.width);
            let at = self.at(row, first);
            let solved = x[row] / self.diagonal(row);
            x[row] = solved;
            for (x, a) in x[first..row].iter_mut().zip(&self.rows[at..]) {
                *x -= solved * a;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_is_solved() {
        // -1 2.5 -1 with a second neighbour of 0.25.
        let n = 12;
        let mut band = Band::zero(n, 2);
        let entry =
            |i: usize, j: usize| [2.5, -1.0, 0.25].get(i.abs_diff(j)).copied().unwrap_or(0.0);
        for i in 0..n {
            for j in i.saturating_sub(2)..=i {
                band.add(j, i, entry(i, j));
            }
        }
        let exact: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut x: Vec<f64> =
            (0..n).map(|i| (0..n).map(|j| entry(i, j) * exact[j]).sum()).collect();
        band.factor().unwrap();
        band.solve(&mut x);
        for (x, exact) in x.iter().zip(&exact) {
            assert!((x - exact).abs() < 1e-13, "{x} {exact}");
        }
        let mut singular = Band::zero(2, 1);
        singular.add(0, 0, 1.0);
        assert_eq!(singular.factor(), Err(Error::NotPositiveDefinite { row: 1, limit: 0.0 }));
    }
}
