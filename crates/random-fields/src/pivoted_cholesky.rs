//! A few columns that make up most of a covariance.

use crate::error::{Error, finite};

/// Most numbers that are kept: 2 GB of them.
const MOST_NUMBERS: usize = 1 << 28;

/// When enough columns are there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Enough {
    /// What is left of the trace is at most this part of it.
    Trace(f64),
    /// What is left of any entry of the diagonal is at most this.
    Largest(f64),
    /// What is left of the trace is at most this part of it, or so many columns are there.
    TraceOrColumns(f64, usize),
}

/// Columns `U` with `A = U U^T + R`, where the remainder `R` is positive semidefinite.
#[derive(Debug, Clone, PartialEq)]
pub struct LowRank {
    /// Column after column, of `n` entries each.
    pub columns: Vec<f64>,
    /// The diagonal of the remainder.
    pub rest: Vec<f64>,
    /// The row of the pivot of each column.
    pub pivots: Vec<usize>,
}

/// Cholesky's factorisation with the largest diagonal entry of the remainder as the next pivot, of which the first of equals
/// is taken. `O(n k^2)` operations and `n k` numbers for `k` columns; `n k` entries of the matrix are asked for.
///
/// It ends where the remainder is roundoff of the matrix, `n eps` of the largest diagonal entry, whatever is asked for.
///
/// Source: Harbrecht, Peters and Schneider 2012, On the low-rank approximation by the pivoted Cholesky decomposition,
/// algorithm 1.
///
/// # Errors
/// [`Error::NotFinite`] for an entry; [`Error::NotPositiveDefinite`] for a diagonal entry of the remainder below zero by more
/// than roundoff; [`Error::TooManyColumns`].
pub fn pivoted_cholesky(
    n: usize,
    entry: impl Fn(usize, usize) -> f64,
    enough: Enough,
) -> Result<LowRank, Error> {
    let mut rest: Vec<f64> = (0..n).map(|i| entry(i, i)).collect();
    rest.iter().try_for_each(|&value| finite(ENTRY, value))?;
    let trace: f64 = rest.iter().sum();
    let limit = n as f64 * f64::EPSILON * largest(&rest).1;
    let (mut columns, mut pivots): (Vec<f64>, Vec<usize>) = (vec![], vec![]);
    while columns.len() < n * n {
        let (pivot, value) = largest(&rest);
        let is_enough = match enough {
            Enough::Trace(part) => rest.iter().sum::<f64>() <= part * trace,
            Enough::Largest(most) => value <= most,
            Enough::TraceOrColumns(part, n_columns) => {
                pivots.len() >= n_columns || rest.iter().sum::<f64>() <= part * trace
            }
        };
        if is_enough || value <= limit {
            break;
        }
        if columns.len() + n > MOST_NUMBERS {
            let n_columns = columns.len() / n;
            return Err(Error::TooManyColumns { n_columns, n_nodes: n, limit: MOST_NUMBERS });
        }
        let mut next: Vec<f64> = (0..n).map(|i| entry(i, pivot)).collect();
        for column in columns.chunks_exact(n) {
            let factor = column[pivot];
            for (next, u) in next.iter_mut().zip(column) {
                *next -= factor * u;
            }
        }
        let root = value.sqrt();
        for (i, next) in next.iter_mut().enumerate() {
            *next /= root;
            finite(ENTRY, *next)?;
            rest[i] -= *next * *next;
        }
        rest[pivot] = 0.0;
        columns.append(&mut next);
        pivots.push(pivot);
    }
    match rest.iter().position(|&value| value < -limit) {
        Some(row) => Err(Error::NotPositiveDefinite { row, limit: -limit }),
        None => Ok(LowRank { columns, rest, pivots }),
    }
}

const ENTRY: &str = "an entry of the covariance";

/// The first of the largest.
fn largest(values: &[f64]) -> (usize, f64) {
    let mut found = (0, f64::NEG_INFINITY);
    for (i, &value) in values.iter().enumerate() {
        if value > found.1 {
            found = (i, value);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;

    /// `min(i, j) + 1`: the covariance of a random walk.
    fn walk(i: usize, j: usize) -> f64 {
        (i.min(j) + 1) as f64
    }

    #[test]
    fn all_columns_make_up_the_whole_matrix() {
        let n = 12;
        let LowRank { columns, rest, .. } = pivoted_cholesky(n, walk, Enough::Trace(0.0)).unwrap();
        assert_eq!(columns.len(), n * n);
        assert!(rest.iter().all(|rest| rest.abs() < 1e-14));
        for i in 0..n {
            for j in 0..n {
                let product: f64 = columns.chunks_exact(n).map(|u| u[i] * u[j]).sum();
                // Twelve products of numbers up to sqrt(12).
                assert!((product - walk(i, j)).abs() < 1e-13, "({i}, {j}): {product}");
            }
        }
    }

    #[test]
    fn remainder_of_the_trace_is_within_the_tolerance_and_not_far_below() {
        let n = 60;
        let LowRank { columns, rest, .. } = pivoted_cholesky(n, walk, Enough::Trace(0.05)).unwrap();
        let trace: f64 = (1..=n).map(|i| i as f64).sum();
        let left = rest.iter().sum::<f64>() / trace;
        assert!(left <= 0.05 && left > 0.01, "{left}");
        // The last pivot is taken first: with two columns a third of the walk is left, with twelve hardly any.
        let rank = columns.len() / n;
        assert!((2..12).contains(&rank), "{rank}");
    }

    #[test]
    fn matrix_of_rank_one_has_one_column() {
        let found = pivoted_cholesky(5, |i, j| ((i + 1) * (j + 1)) as f64, Enough::Trace(1e-12));
        assert_eq!(found.unwrap().columns, [1.0, 2.0, 3.0, 4.0, 5.0]);
    }

    #[test]
    fn entries_that_are_no_numbers_are_refused_wherever_they_are() {
        for bad in [f64::NAN, f64::INFINITY] {
            for place in [(0, 0), (3, 3), (4, 1)] {
                let at = |i: usize, j: usize| (i.max(j), i.min(j)) == place;
                let entry = |i, j| if at(i, j) { bad } else { walk(i, j) };
                let found = pivoted_cholesky(6, entry, Enough::Trace(1e-6));
                assert!(matches!(found, Err(Error::NotFinite { .. })), "{place:?} {found:?}");
            }
        }
    }

    #[test]
    fn indefinite_matrix_is_refused_with_its_row() {
        // Eigenvalues 3 and -1: after the first pivot 1 - 4 is left in row 1.
        let found = pivoted_cholesky(2, |i, j| if i == j { 1.0 } else { 2.0 }, Enough::Trace(1e-3));
        let Err(Error::NotPositiveDefinite { row, .. }) = found else { unreachable!("{found:?}") };
        assert_eq!(row, 1);
    }
}
