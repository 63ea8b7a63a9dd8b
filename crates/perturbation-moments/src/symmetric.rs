//! Symmetric matrices: eigenvalues and factor, also of positive semidefinite ones.

/// Largest number of sweeps over all pairs.
///
/// Convergence is quadratic and typically takes six, so a finite matrix never reaches the limit.
const MOST_SWEEPS: usize = 60;

/// The eigenvalues of a symmetric matrix in ascending order, by cyclic Jacobi rotations.
///
/// Source: Golub and Van Loan 2013, Matrix Computations, algorithm 8.5.3.
pub(crate) fn eigenvalues<const N: usize>(matrix: &[[f64; N]; N]) -> [f64; N] {
    let mut a = *matrix;
    for _ in 0..MOST_SWEEPS {
        let mut rotated = false;
        for p in 0..N {
            for q in p + 1..N {
                if a[p][q].abs() > f64::EPSILON * 1e-3 * (a[p][p].abs() + a[q][q].abs()) {
                    rotate(&mut a, p, q);
                    rotated = true;
                }
            }
        }
        if !rotated {
            break;
        }
    }
    let mut values = std::array::from_fn(|i| a[i][i]);
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The rotation of the plane (p, q) that makes `a[p][q]` zero.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], p: usize, q: usize) {
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let sign = if tau < 0.0 { -1.0 } else { 1.0 };
    let tangent = sign / (tau.abs() + tau.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    for k in 0..N {
        let (x, y) = (a[k][p], a[k][q]);
        (a[k][p], a[k][q]) = (cosine * x - sine * y, sine * x + cosine * y);
    }
    for k in 0..N {
        let (x, y) = (a[p][k], a[q][k]);
        (a[p][k], a[q][k]) = (cosine * x - sine * y, sine * x + cosine * y);
    }
    (a[p][q], a[q][p]) = (0.0, 0.0);
}

/// A lower triangular `L` with `S = L L^T` for a positive semidefinite `S` of unit diagonal.
///
/// If a pivot is roundoff, the row depends on those before it, and its column of the factor is zero.
pub(crate) fn factor<const N: usize>(matrix: &[[f64; N]; N]) -> [[f64; N]; N] {
    let mut l = [[0.0; N]; N];
    for j in 0..N {
        let pivot = matrix[j][j] - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
        if pivot <= roundoff(N) {
            continue;
        }
        l[j][j] = pivot.sqrt();
        for i in j + 1..N {
            let rest = matrix[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = rest / l[j][j];
        }
    }
    l
}

/// Magnitude below which an eigenvalue or pivot of a matrix with unit diagonal counts as zero.
pub(crate) const fn roundoff(n: usize) -> f64 {
    16.0 * f64::EPSILON * n as f64
}
