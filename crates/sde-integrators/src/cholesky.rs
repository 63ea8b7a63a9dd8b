//! Cholesky factor of a small symmetric matrix.

/// A pivot that does not exceed roundoff.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BadPivot {
    pub(crate) row: usize,
    pub(crate) pivot: f64,
    pub(crate) limit: f64,
}

/// The lower triangle `L` with `A = L L^T`; reads only the lower triangle of `A`.
///
/// A pivot must exceed `D eps A_ii`, below which it is roundoff.
/// Source: Higham 2002, Accuracy and stability of numerical algorithms, algorithm 10.2.
pub(crate) fn factor<const D: usize>(a: &[[f64; D]; D]) -> Result<[[f64; D]; D], BadPivot> {
    let mut l = [[0.0; D]; D];
    for row in 0..D {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| l[row][k] * l[column][k]).sum();
            let rest = a[row][column] - known;
            l[row][column] = if row == column {
                let limit = D as f64 * f64::EPSILON * a[row][row].abs();
                if rest.is_nan() || rest <= limit {
                    return Err(BadPivot { row, pivot: rest, limit });
                }
                rest.sqrt()
            } else {
                rest / l[column][column]
            };
        }
    }
    Ok(l)
}

/// `L^-1 b`.
pub(crate) fn solve_lower<const D: usize>(l: &[[f64; D]; D], b: &[f64; D]) -> [f64; D] {
    let mut y = *b;
    for row in 0..D {
        let known: f64 = (0..row).map(|k| l[row][k] * y[k]).sum();
        y[row] = (b[row] - known) / l[row][row];
    }
    y
}
