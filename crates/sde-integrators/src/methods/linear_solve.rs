//! Solution of a small linear system.

use crate::error::StepError;

/// `A^-1 b` by Gaussian elimination with row interchanges.
///
/// # Errors
/// [`StepError::Singular`] if no pivot of a column exceeds roundoff.
pub(crate) fn solve<const D: usize>(
    mut a: [[f64; D]; D],
    mut b: [f64; D],
) -> Result<[f64; D], StepError> {
    let scale = a.iter().flatten().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let limit = D as f64 * f64::EPSILON * scale;
    for column in 0..D {
        let mut largest = column;
        for row in column + 1..D {
            if a[row][column].abs() > a[largest][column].abs() {
                largest = row;
            }
        }
        let pivot = a[largest][column];
        if pivot.is_nan() || pivot.abs() <= limit {
            return Err(StepError::Singular { row: column, pivot, limit });
        }
        a.swap(column, largest);
        b.swap(column, largest);
        for row in column + 1..D {
            let factor = a[row][column] / pivot;
            for k in column..D {
                a[row][k] -= factor * a[column][k];
            }
            b[row] -= factor * b[column];
        }
    }
    for row in (0..D).rev() {
        let known: f64 = (row + 1..D).map(|k| a[row][k] * b[k]).sum();
        b[row] = (b[row] - known) / a[row][row];
    }
    Ok(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_that_needs_an_interchange_is_solved() {
        let x = solve([[0.0, 2.0], [3.0, 1.0]], [4.0, 5.0]).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
    }

    #[test]
    fn a_singular_system_is_refused_with_its_pivot() {
        let error = solve([[1.0, 2.0], [2.0, 4.0]], [1.0, 1.0]).unwrap_err();
        assert!(matches!(error, StepError::Singular { row: 1, .. }), "{error}");
    }
}
