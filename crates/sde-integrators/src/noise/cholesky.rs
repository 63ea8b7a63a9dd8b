//! Cholesky factors of symmetric matrices: of some states, or of some thousand unknowns.

use simd_lanes::{Registers, SimdLevel, Work};

/// A pivot that is not above its limit, or not finite: the matrix is not positive definite within roundoff.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmallPivot {
    /// Row of the pivot.
    pub row: usize,
    /// The pivot: what is left of the diagonal entry.
    pub value: f64,
    /// What it must exceed.
    pub limit: f64,
}

/// The lower triangular `L` with `A = L L^T` of a symmetric matrix whose size is known at run time.
///
/// A matrix of a few thousand rows takes `n^3/3` products in vector registers. Each entry is one sum in the order of the columns,
/// so the factor is bitwise identical at every SIMD level.
///
/// Source: Golub and Van Loan 2013, Matrix Computations, algorithm 4.2.2 with the columns in blocks.
///
/// ```
/// use sde_integrators::Cholesky;
///
/// let factor = Cholesky::new(2, vec![4.0, 2.0, 2.0, 5.0], 1e-12).map_err(|small| small.value)?;
/// assert_eq!((factor.row(0), factor.row(1)), (&[2.0][..], &[1.0, 2.0][..]));
/// assert_eq!(factor.solve(vec![8.0, 8.0]), [1.5, 1.0]);
/// # Ok::<(), f64>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Cholesky {
    n: usize,
    /// Row after row of length `n`; what is above the diagonal is that of the matrix.
    rows: Vec<f64>,
}

impl Cholesky {
    /// Factorises a matrix of `n` rows, of which the lower triangle is read.
    ///
    /// Every pivot must exceed the part `least` of the diagonal entry of its row.
    ///
    /// # Errors
    /// The first pivot that does not.
    ///
    /// # Panics
    /// If the matrix has not `n` rows and columns, as in slice indexing.
    pub fn new(n: usize, mut matrix: Vec<f64>, least: f64) -> Result<Self, SmallPivot> {
        assert_eq!(matrix.len(), n * n, "entries of a square matrix");
        SimdLevel::best().run(Factorise { n, rows: &mut matrix, least })?;
        Ok(Self { n, rows: matrix })
    }

    /// Number of rows.
    #[must_use]
    pub const fn n_rows(&self) -> usize {
        self.n
    }

    /// Row `i` of `L`, up to its diagonal.
    ///
    /// # Panics
    /// If there is no such row, as in slice indexing.
    #[must_use]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.rows[i * self.n..][..=i]
    }

    /// Replaces the rows of `b`, each of length `width`, by those of `L^-1 b`.
    pub fn solve_lower(&self, b: &mut [f64], width: usize) {
        for i in 0..self.n {
            let (done, rest) = b.split_at_mut(i * width);
            let row = &mut rest[..width];
            for (j, factor) in self.row(i)[..i].iter().enumerate() {
                for (x, known) in row.iter_mut().zip(&done[j * width..(j + 1) * width]) {
                    *x -= factor * known;
                }
            }
            for x in row {
                *x /= self.rows[i * self.n + i];
            }
        }
    }

    /// `A^-1 b`.
    #[must_use]
    pub fn solve(&self, mut x: Vec<f64>) -> Vec<f64> {
        let (n, l) = (self.n, &self.rows);
        for i in 0..n {
            let inner: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
            x[i] = (x[i] - inner) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let inner: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
            x[i] = (x[i] - inner) / l[i * n + i];
        }
        x
    }

    /// The rows of `L` in sequence, each up to its diagonal.
    pub(crate) fn into_packed(self) -> Vec<f64> {
        let (n, mut rows) = (self.n, self.rows);
        let mut end = 0;
        for i in 0..n {
            rows.copy_within(i * n..=i * n + i, end);
            end += i + 1;
        }
        rows.truncate(end);
        rows.shrink_to_fit();
        rows
    }
}

/// The same of a small matrix: `L` with zeros above its diagonal.
///
/// # Errors
/// The first pivot that does not exceed the part `least` of its diagonal entry.
pub fn small_cholesky<const D: usize>(
    matrix: &[[f64; D]; D],
    least: f64,
) -> Result<[[f64; D]; D], SmallPivot> {
    let mut factor = [[0.0; D]; D];
    for row in 0..D {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| factor[row][k] * factor[column][k]).sum();
            let rest = matrix[row][column] - known;
            factor[row][column] = if row == column {
                root_of_pivot(row, rest, least * matrix[row][row].abs())?
            } else {
                rest / factor[column][column]
            };
        }
    }
    Ok(factor)
}

fn root_of_pivot(row: usize, value: f64, limit: f64) -> Result<f64, SmallPivot> {
    if value > limit && value.is_finite() {
        Ok(value.sqrt())
    } else {
        Err(SmallPivot { row, value, limit })
    }
}

/// Columns of a block.
const BLOCK: usize = 16;
/// Rows whose sums are in registers together.
const ROWS: usize = 2;

/// Replaces the lower triangle of a matrix by its factor, a block of columns after the other.
struct Factorise<'a> {
    n: usize,
    rows: &'a mut [f64],
    least: f64,
}

impl Work<f64> for Factorise<'_> {
    type Output = Result<(), SmallPivot>;

    #[allow(clippy::inline_always, reason = "it is compiled for the registers of the level")]
    #[inline(always)]
    fn run<R: Registers<f64>>(self, _: R) -> Result<(), SmallPivot> {
        let Self { n, rows, least } = self;
        let mut above = Vec::with_capacity(n);
        for first in (0..n).step_by(BLOCK) {
            let width = BLOCK.min(n - first);
            // The rows of the block as columns, so that a product with one number fills a register.
            above.clear();
            above.extend((0..first).map(|k| -> [f64; BLOCK] {
                std::array::from_fn(|c| if c < width { rows[(first + c) * n + k] } else { 0.0 })
            }));
            let mut row = first;
            while row < n {
                let group: [usize; ROWS] = std::array::from_fn(|r| (row + r).min(n - 1));
                let mut sums = [[0.0; BLOCK]; ROWS];
                let [a, b] = group.map(|row| &rows[row * n..row * n + first]);
                for ((column, a), b) in above.iter().zip(a).zip(b) {
                    for c in 0..BLOCK {
                        sums[0][c] += a * column[c];
                        sums[1][c] += b * column[c];
                    }
                }
                for (r, sums) in sums.iter().enumerate().take(ROWS.min(n - row)) {
                    finish_row(rows, n, row + r, first..first + width, sums, least)?;
                }
                row += ROWS;
            }
        }
        Ok(())
    }
}

/// The entries of a row in a block of columns, with the sums over all columns before the block.
#[allow(clippy::inline_always, reason = "used in a dispatched function")]
#[inline(always)]
fn finish_row(
    rows: &mut [f64],
    n: usize,
    row: usize,
    block: std::ops::Range<usize>,
    sums: &[f64; BLOCK],
    least: f64,
) -> Result<(), SmallPivot> {
    let (done, rest) = rows.split_at_mut(row * n);
    let own = &mut rest[..n];
    for (column, sum) in block.clone().zip(sums) {
        if column > row {
            break;
        }
        let mut known = *sum;
        if column == row {
            for value in &own[block.start..column] {
                known += value * value;
            }
            own[row] = root_of_pivot(row, own[row] - known, least * own[row].abs())?;
        } else {
            let other = &done[column * n..=column * n + column];
            for (a, b) in own[block.start..column].iter().zip(&other[block.start..column]) {
                known += a * b;
            }
            own[column] = (own[column] - known) / other[column];
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `1 / (1 + |i - j|)`: convex and falling, so positive definite (Polya).
    fn matrix(n: usize) -> Vec<f64> {
        (0..n * n).map(|k| 1.0 / (1.0 + (k / n).abs_diff(k % n) as f64)).collect()
    }

    /// One sum for each entry, in the order of the columns.
    fn entry_by_entry(n: usize, mut a: Vec<f64>) -> Vec<f64> {
        for i in 0..n {
            for j in 0..=i {
                let mut known = 0.0;
                for k in 0..j {
                    known += a[i * n + k] * a[j * n + k];
                }
                let rest = a[i * n + j] - known;
                a[i * n + j] = if i == j { rest.sqrt() } else { rest / a[j * n + j] };
            }
        }
        a
    }

    #[test]
    fn blocks_at_every_level_give_the_bits_of_one_entry_after_the_other() {
        for n in [0, 1, 2, 15, 16, 17, 31, 32, 33, 50, 97] {
            let expected = entry_by_entry(n, matrix(n));
            for level in SimdLevel::available() {
                let mut rows = matrix(n);
                level.run(Factorise { n, rows: &mut rows, least: 0.0 }).unwrap();
                for i in 0..n {
                    for j in 0..=i {
                        let (found, expected) = (rows[i * n + j], expected[i * n + j]);
                        assert_eq!(found.to_bits(), expected.to_bits(), "{level}: {i}, {j} of {n}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_small_matrix_has_the_factor_of_a_large_one() {
        const D: usize = 6;
        let given: [[f64; D]; D] =
            std::array::from_fn(|i| std::array::from_fn(|j| matrix(D)[i * D + j]));
        let (small, large) =
            (small_cholesky(&given, 0.0).unwrap(), Cholesky::new(D, matrix(D), 0.0).unwrap());
        for (i, row) in small.iter().enumerate() {
            assert_eq!(large.row(i), &row[..=i]);
            assert!(row[i + 1..].iter().all(|x| x.abs() <= 0.0));
        }
        let packed = large.clone().into_packed();
        assert_eq!(packed.len(), D * (D + 1) / 2);
        assert_eq!(&packed[10..15], large.row(4));
    }

    #[test]
    fn what_is_no_covariance_is_refused_with_its_row_and_limit() {
        let indefinite = [[1.0, 2.0], [2.0, 1.0]];
        let expected = SmallPivot { row: 1, value: -3.0, limit: 0.0 };
        assert_eq!(small_cholesky(&indefinite, 0.0), Err(expected));
        assert_eq!(Cholesky::new(2, indefinite.concat(), 0.0), Err(expected));
        // The pivot of row 1 is a quarter of its diagonal entry.
        let nearly = [[4.0, 3.0], [3.0, 3.0]];
        assert!(small_cholesky(&nearly, 0.24).is_ok());
        let small = small_cholesky(&nearly, 0.26).unwrap_err();
        assert_eq!((small.row, small.value), (1, 0.75));
        for value in [f64::NAN, f64::INFINITY] {
            assert_eq!(small_cholesky(&[[value]], 0.0).map_err(|small| small.row), Err(0));
        }
    }

    #[test]
    fn solutions_satisfy_the_equations() {
        let n = 40;
        let factor = Cholesky::new(n, matrix(n), 1e-12).unwrap();
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let x = factor.solve(b.clone());
        for (row, b) in matrix(n).chunks_exact(n).zip(&b) {
            let image: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((image - b).abs() < 1e-13, "{image} {b}");
        }
        let mut half = b.clone();
        factor.solve_lower(&mut half, 1);
        let square: f64 = half.iter().map(|y| y * y).sum();
        let expected: f64 = b.iter().zip(&x).map(|(b, x)| b * x).sum();
        assert!((square / expected - 1.0).abs() < 1e-12);
    }
}
