//! The deformation of lattice cells: volumes, and gradients carried from the lattice to the deformed cells.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::Lanes;

use super::cell_geometry::determinant;
use super::small_matrices::{eigen, solve_transposed};

/// `det F`: by its formula up to four dimensions, which a loop over cells computes in registers, and by elimination beyond.
#[inline(always)]
pub(crate) fn volume<const D: usize>(f: &[[f64; D]; D]) -> f64 {
    match D {
        1 => f[0][0],
        2 => f[0][0] * f[1][1] - f[0][1] * f[1][0],
        3 => {
            f[0][0] * cofactor(f, 0, 0) + f[0][1] * cofactor(f, 0, 1) + f[0][2] * cofactor(f, 0, 2)
        }
        4 => {
            let ([low, high], mut det) = (minors(f), 0.0);
            for m in 0..6 {
                det += SIGNS[m] * low[m] * high[5 - m];
            }
            det
        }
        _ => determinant(f),
    }
}

/// Pairs of columns of four; the sixth less a pair are the other two columns.
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
/// Signs of the permutations that bring a pair of columns to the front.
const SIGNS: [f64; 6] = [1.0, -1.0, 1.0, 1.0, -1.0, 1.0];

/// The minors of the first two rows and of the last two rows of a matrix of four rows, over [`PAIRS`] of columns.
#[inline(always)]
fn minors<const D: usize>(f: &[[f64; D]; D]) -> [[f64; 6]; 2] {
    let mut minors = [[0.0; 6]; 2];
    for (half, minors) in minors.iter_mut().enumerate() {
        let (a, b) = (2 * half, 2 * half + 1);
        for m in 0..6 {
            let [p, q] = PAIRS[m];
            minors[m] = f[a][p] * f[b][q] - f[a][q] * f[b][p];
        }
    }
    minors
}

/// The cofactors of a matrix of four rows, by the minors of the two rows in which the cofactor's is not.
#[inline(always)]
fn cofactors_of_four<const D: usize>(f: &[[f64; D]; D]) -> [[f64; D]; D] {
    let minors = minors(f);
    let mut cofactors = [[0.0; D]; D];
    for k in 0..4 {
        // The other row of its half, and the minors of the other half.
        let (beside, others) = (k ^ 1, &minors[1 - k / 2]);
        for m in 0..6 {
            // Columns `p` and `q` go with the minor of the other two.
            let [p, q] = PAIRS[m];
            let minor = SIGNS[m] * others[5 - m];
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            cofactors[k][p] += sign * f[beside][q] * minor;
            cofactors[k][q] -= sign * f[beside][p] * minor;
        }
    }
    cofactors
}

/// The cofactor of an entry of a matrix of three rows.
#[inline(always)]
fn cofactor<const D: usize>(f: &[[f64; D]; D], k: usize, l: usize) -> f64 {
    let (a, b, p, q) = ((k + 1) % 3, (k + 2) % 3, (l + 1) % 3, (l + 2) % 3);
    f[a][p] * f[b][q] - f[a][q] * f[b][p]
}

/// `F^-T g`: by cofactors up to four dimensions and by elimination beyond.
#[inline(always)]
pub(crate) fn push_forward<const D: usize>(f: &[[f64; D]; D], g: &[f64; D]) -> [f64; D] {
    let mut out = [0.0; D];
    match D {
        1 => out[0] = g[0] / f[0][0],
        2 => {
            let inverse = 1.0 / volume(f);
            out[0] = (f[1][1] * g[0] - f[1][0] * g[1]) * inverse;
            out[1] = (f[0][0] * g[1] - f[0][1] * g[0]) * inverse;
        }
        3 => {
            let inverse = 1.0 / volume(f);
            for k in 0..3 {
                for l in 0..3 {
                    out[k] += cofactor(f, k, l) * g[l];
                }
                out[k] *= inverse;
            }
        }
        4 => {
            let inverse = 1.0 / volume(f);
            let cofactors = cofactors_of_four(f);
            for k in 0..4 {
                for l in 0..4 {
                    out[k] += cofactors[k][l] * g[l];
                }
                out[k] *= inverse;
            }
        }
        _ => return solve_transposed(f, g),
    }
    out
}

/// `trace(F^-1 A F^-T)` of a symmetric `A`: by cofactors up to four dimensions and by elimination beyond.
#[inline(always)]
pub(crate) fn trace_on_lattice<const D: usize>(f: &[[f64; D]; D], a: &[[f64; D]; D]) -> f64 {
    // The rows of the adjugate, `det F` times those of the inverse.
    let mut rows = [[0.0; D]; D];
    match D {
        1 => rows[0][0] = 1.0,
        2 => {
            (rows[0][0], rows[0][1]) = (f[1][1], -f[0][1]);
            (rows[1][0], rows[1][1]) = (-f[1][0], f[0][0]);
        }
        3 => {
            for k in 0..3 {
                for l in 0..3 {
                    rows[l][k] = cofactor(f, k, l);
                }
            }
        }
        4 => {
            let cofactors = cofactors_of_four(f);
            for k in 0..4 {
                for l in 0..4 {
                    rows[l][k] = cofactors[k][l];
                }
            }
        }
        _ => return trace_by_elimination(f, a),
    }
    let mut trace = 0.0;
    for row in &rows {
        for k in 0..D {
            let mut along = 0.0;
            for l in 0..D {
                along += a[k][l] * row[l];
            }
            trace += row[k] * along;
        }
    }
    let det = volume(f);
    trace / (det * det)
}

/// `trace(F^-1 A F^-T)` by elimination.
fn trace_by_elimination<const D: usize>(f: &[[f64; D]; D], a: &[[f64; D]; D]) -> f64 {
    let transposed = std::array::from_fn(|k| std::array::from_fn(|l| f[l][k]));
    // B = F^-1 A, then trace(B F^-T) = trace(F^-1 B^T).
    let mut half = [[0.0; D]; D];
    for l in 0..D {
        let column = std::array::from_fn(|k| a[k][l]);
        let solved = solve_transposed(&transposed, &column);
        for k in 0..D {
            half[k][l] = solved[k];
        }
    }
    (0..D).map(|k| solve_transposed(&transposed, &half[k])[k]).sum()
}

/// Whether an upright `F` is known to have no singular value of `least` or less: `det F` is at most the smallest of them times
/// the Frobenius norm to the power `D - 1`, over a constant.
#[inline(always)]
pub(crate) fn is_thick<const D: usize>(f: &[[f64; D]; D], least: f64) -> bool {
    let norm_squared = f.as_flattened().iter().fold(0.0, |sum, value| sum + value * value);
    let mean = norm_squared / (D.max(2) - 1) as f64;
    let det = volume(f);
    match D {
        1 => det > least,
        // Squares, so that no root is taken.
        2 => det * det.abs() > least * least * mean,
        3 => det > least * mean,
        _ => det > least * mean.powf(0.5 * (D as f64 - 1.0)),
    }
}

/// `F^-T g` with singular values of `F` no smaller than `least`:
///
/// $$ \sum_m v_m \frac{v_m \cdot F g}{\max(s_m^2, l^2)}, \qquad F F^T = \sum_m s_m^2 v_m v_m^T . $$
#[inline(always)]
pub(crate) fn damped_push_forward<N: Lanes<Number = f64>, const D: usize>(
    f: &[[N; D]; D],
    g: &[N; D],
    least: f64,
) -> [N; D] {
    let zero = g[0].splat(0.0);
    let (mut square, mut fg, mut out) = ([[zero; D]; D], [zero; D], [zero; D]);
    for k in 0..D {
        for l in 0..D {
            for m in 0..D {
                square[k][l] = square[k][l] + f[k][m] * f[l][m];
            }
            fg[k] = fg[k] + f[k][l] * g[l];
        }
    }
    let (values, vectors) = eigen(square);
    let least = zero.splat(least * least);
    for m in 0..D {
        let mut along = zero;
        for k in 0..D {
            along = along + vectors[k][m] * fg[k];
        }
        let part = along / values[m].max(least);
        for k in 0..D {
            out[k] = out[k] + vectors[k][m] * part;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix without symmetry, upright and thick.
    fn matrix<const D: usize>() -> [[f64; D]; D] {
        std::array::from_fn(|k| {
            std::array::from_fn(|l| {
                (if k == l { 4.0 } else { 0.0 }) + (1.3 * (k * D + l) as f64).sin()
            })
        })
    }

    fn agrees<const D: usize>() {
        let (f, g) = (matrix::<D>(), std::array::from_fn(|k| 0.7 - 0.4 * k as f64));
        let error = volume(&f) / determinant(&f) - 1.0;
        assert!(error.abs() < 1e-14, "volume in {D}-D: {error:e}");
        let mut square = [[0.0; D]; D];
        for k in 0..D {
            for l in 0..D {
                square[k][l] = (0..D).map(|m| f[k][m] * f[l][m]).sum();
            }
        }
        let thickness = eigen(square).0.into_iter().fold(f64::INFINITY, f64::min).sqrt();
        assert!(!is_thick(&f, 1.000001 * thickness), "{D}-D: above {thickness}");
        assert!(is_thick(&f, 0.05 * thickness), "{D}-D: far below {thickness}");
        let exact = solve_transposed(&f, &g);
        let damped = damped_push_forward(&f, &g, 0.5 * thickness);
        for (k, found) in push_forward(&f, &g).into_iter().enumerate() {
            // Roundoff of numbers of order 1 times the condition of the matrix, below 10.
            assert!((found - exact[k]).abs() < 1e-14, "{D}-D: {found} {}", exact[k]);
            assert!((damped[k] - exact[k]).abs() < 1e-13, "{D}-D: {} {}", damped[k], exact[k]);
        }
        let error = trace_on_lattice(&f, &square) / trace_by_elimination(&f, &square) - 1.0;
        assert!(error.abs() < 1e-13, "trace in {D}-D: {error:e}");
    }

    #[test]
    fn formulas_agree_with_elimination_and_with_eigenvectors() {
        agrees::<1>();
        agrees::<2>();
        agrees::<3>();
        agrees::<4>();
        agrees::<6>();
    }

    #[test]
    fn a_gradient_across_a_thin_cell_is_damped_and_one_along_it_is_not() {
        // F = diag(1, 0.01) with least 0.1: 1/1 along, 0.01/0.1^2 across.
        let found = damped_push_forward(&[[1.0, 0.0], [0.0, 0.01]], &[3.0, 5.0], 0.1);
        assert!((found[0] - 3.0).abs() < 1e-14 && (found[1] - 5.0).abs() < 1e-13, "{found:?}");
    }
}
