//! Small matrices on the stack: a linear system and a symmetric eigenproblem.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Lanes, Mask};

/// `x` with `A^T x = b`, by elimination with partial pivoting; infinite or NaN where `A` is singular.
pub(crate) fn solve_transposed<const D: usize>(a: &[[f64; D]; D], b: &[f64; D]) -> [f64; D] {
    let mut m: [[f64; D]; D] = std::array::from_fn(|k| std::array::from_fn(|l| a[l][k]));
    let mut x = *b;
    for k in 0..D {
        let pivot = (k..D).max_by(|&p, &q| m[p][k].abs().total_cmp(&m[q][k].abs())).unwrap_or(k);
        m.swap(pivot, k);
        x.swap(pivot, k);
        for i in k + 1..D {
            let factor = m[i][k] / m[k][k];
            for j in k + 1..D {
                m[i][j] -= factor * m[k][j];
            }
            x[i] -= factor * x[k];
        }
    }
    for k in (0..D).rev() {
        for j in k + 1..D {
            x[k] -= m[k][j] * x[j];
        }
        x[k] /= m[k][k];
    }
    x
}

/// `A^-1`; none where `A` is singular.
pub(crate) fn inverse<const D: usize>(a: &[[f64; D]; D]) -> Option<[[f64; D]; D]> {
    // Row k of the inverse is the solution of A^T x = e_k.
    let row = |k: usize| solve_transposed(a, &std::array::from_fn(|l| f64::from(u8::from(k == l))));
    let inverse: [[f64; D]; D] = std::array::from_fn(row);
    inverse.as_flattened().iter().all(|value| value.is_finite()).then_some(inverse)
}

/// `x` with `A x = b`; infinite or NaN where `A` is singular.
pub(crate) fn solve<const D: usize>(a: &[[f64; D]; D], b: &[f64; D]) -> [f64; D] {
    solve_transposed(&std::array::from_fn(|k| std::array::from_fn(|l| a[l][k])), b)
}

/// Most sweeps of the Jacobi method; six suffice for six dimensions.
const MOST_SWEEPS: usize = 20;

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, or of one in each lane, by the cyclic Jacobi method (Golub
/// & Van Loan 2013, section 8.5). A lane that has converged stays as it is, whatever the others need.
#[inline(always)]
pub(crate) fn eigen<N: Lanes<Number = f64>, const D: usize>(
    mut a: [[N; D]; D],
) -> ([N; D], [[N; D]; D]) {
    let (zero, one) = (a[0][0].splat(0.0), a[0][0].splat(1.0));
    let mut v = [[zero; D]; D];
    for k in 0..D {
        v[k][k] = one;
    }
    for _ in 0..MOST_SWEEPS {
        let (mut off, mut diagonal) = (zero, zero);
        for p in 0..D {
            diagonal = diagonal + a[p][p] * a[p][p];
            for q in p + 1..D {
                off = off + a[p][q] * a[p][q];
            }
        }
        let turns = (zero.splat(f64::EPSILON * f64::EPSILON) * diagonal).less(off);
        if !turns.any() {
            break;
        }
        for p in 0..D {
            for q in p + 1..D {
                rotate(&mut a, &mut v, (p, q), turns);
            }
        }
    }
    let mut values = [zero; D];
    for k in 0..D {
        values[k] = a[k][k];
    }
    (values, v)
}

/// The rotation that makes `a[p][q]` zero, in the lanes of a mask.
#[inline(always)]
fn rotate<N: Lanes<Number = f64>, const D: usize>(
    a: &mut [[N; D]; D],
    v: &mut [[N; D]; D],
    (p, q): (usize, usize),
    turns: N::Mask,
) {
    let (zero, one) = (a[p][q].splat(0.0), a[p][q].splat(1.0));
    let theta = (a[q][q] - a[p][p]) / (a[p][q] + a[p][q]);
    let sign = N::select(theta.less(zero), zero - one, one);
    let tangent = sign / (theta.abs() + (theta * theta + one).sqrt());
    // Zero where there is nothing to turn: the identity.
    let tangent = N::select(turns.and(zero.less(a[p][q].abs())), tangent, zero);
    let c = one / (tangent * tangent + one).sqrt();
    let s = tangent * c;
    for k in 0..D {
        (a[k][p], a[k][q]) = (c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]);
        (v[k][p], v[k][q]) = (c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]);
    }
    for k in 0..D {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transposed_system_by_hand() {
        // A^T = [[2, 1], [0, 4]]: x = (1, 2) gives b = (4, 8).
        let x = solve_transposed(&[[2.0, 0.0], [1.0, 4.0]], &[4.0, 8.0]);
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
    }

    #[test]
    fn eigenvectors_rebuild_the_matrix() {
        let a = [[4.0, 1.0, -0.5], [1.0, 2.0, 0.3], [-0.5, 0.3, 0.1]];
        let (values, v) = eigen(a);
        for k in 0..3 {
            for l in 0..3 {
                let rebuilt: f64 = (0..3).map(|m| v[k][m] * values[m] * v[l][m]).sum();
                assert!((rebuilt - a[k][l]).abs() < 1e-14);
            }
        }
    }
}
