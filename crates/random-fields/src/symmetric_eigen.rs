//! Eigenvalues and eigenvectors of a symmetric matrix.

use crate::error::Error;

/// Most iterations for an eigenvalue; some two are usual.
const MOST_ITERATIONS: usize = 50;

/// Eigenvalues, descending, and unit eigenvectors of a symmetric matrix.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SymmetricEigen {
    pub(crate) values: Vec<f64>,
    /// Eigenvector after eigenvector.
    pub(crate) vectors: Vec<f64>,
}

/// By Householder's reduction to a tridiagonal matrix and implicit QL steps: about `9 n^3` operations, without instructions that
/// depend on the machine. The errors of eigenvalues are a few `n eps` of the largest.
///
/// Sources: Martin, Reinsch and Wilkinson 1968, Householder's tridiagonalization of a symmetric matrix; Bowdler, Martin, Reinsch and
/// Wilkinson 1968, The QR and QL algorithms for symmetric matrices.
///
/// # Errors
/// [`Error::NoConvergence`].
pub(crate) fn symmetric_eigen(n: usize, mut matrix: Vec<f64>) -> Result<SymmetricEigen, Error> {
    let (mut diagonal, mut beside) = tridiagonal(n, &mut matrix);
    diagonalise(n, &mut diagonal, &mut beside, &mut matrix)?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| diagonal[j].total_cmp(&diagonal[i]));
    let vectors = order.iter().flat_map(|&i| matrix[i * n..(i + 1) * n].iter().copied()).collect();
    Ok(SymmetricEigen { values: order.iter().map(|&i| diagonal[i]).collect(), vectors })
}

/// `Q^T A Q = T`: the diagonal of `T` and what is beside it, from the second row on; `A` becomes `Q^T`, row after row.
///
/// Rows from the last to the second are reflected onto the element before the diagonal. The reflection is
/// `1 - u u^T/h` with `h = |u|^2/2`; `u` stays in row `i` of the matrix until `Q` is multiplied together.
fn tridiagonal(n: usize, a: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut diagonal, mut beside, mut halves) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut p = vec![0.0; n];
    for i in (1..n).rev() {
        let (above, row) = a.split_at_mut(i * n);
        diagonal[i] = row[i];
        let u = &mut row[..i];
        let scale: f64 = u[..i - 1].iter().map(|x| x.abs()).sum();
        if scale == 0.0 {
            beside[i] = u[i - 1];
            continue;
        }
        let norm = u.iter().map(|x| x * x).sum::<f64>().sqrt();
        let end = u[i - 1];
        let reflected = if end > 0.0 { -norm } else { norm };
        beside[i] = reflected;
        u[i - 1] = end - reflected;
        // h = |u|^2/2 = norm^2 - end reflected
        let h = norm * norm - end * reflected;
        halves[i] = h;
        // p = A u/h of the leading block, whose rows are whole.
        for j in 0..i {
            p[j] = above[j * n..j * n + i].iter().zip(&*u).map(|(a, u)| a * u).sum::<f64>() / h;
        }
        let k = p[..i].iter().zip(&*u).map(|(p, u)| p * u).sum::<f64>() / (2.0 * h);
        for j in 0..i {
            p[j] -= k * u[j];
        }
        for j in 0..i {
            let (u_j, p_j) = (u[j], p[j]);
            let row = &mut above[j * n..j * n + i];
            for ((a, u), p) in row.iter_mut().zip(&*u).zip(&p) {
                *a -= u_j * p + p_j * u;
            }
        }
    }
    if n > 0 {
        diagonal[0] = a[0];
    }
    accumulate(n, a, &halves);
    (diagonal, beside)
}

/// Multiplies the reflections together: row `k` of the matrix becomes the image of unit vector `k` under the transpose.
fn accumulate(n: usize, a: &mut [f64], halves: &[f64]) {
    let mut q = vec![0.0; n * n];
    for k in 0..n {
        q[k * n + k] = 1.0;
    }
    // Q = H_{n-1} ... H_1, and A = Q T Q^T with T = H_1 ... H_{n-1} A H_{n-1} ... H_1. Rows of q hold columns of Q.
    for i in (1..n).filter(|&i| halves[i] > 0.0) {
        let u = &a[i * n..i * n + i];
        for row in q.chunks_exact_mut(n) {
            let dot: f64 = row[..i].iter().zip(u).map(|(q, u)| q * u).sum();
            let factor = dot / halves[i];
            for (q, u) in row[..i].iter_mut().zip(u) {
                *q -= factor * u;
            }
        }
    }
    a.copy_from_slice(&q);
}

/// Implicit QL steps on a tridiagonal matrix; rows of `vectors` are rotated with it.
fn diagonalise(n: usize, d: &mut [f64], e: &mut [f64], vectors: &mut [f64]) -> Result<(), Error> {
    e.rotate_left(usize::from(n > 0));
    for l in 0..n {
        for iteration in 0.. {
            let is_small = |m: usize| e[m].abs() <= f64::EPSILON * (d[m].abs() + d[m + 1].abs());
            let m = (l..n - 1).find(|&m| is_small(m)).unwrap_or(n - 1);
            if m == l {
                break;
            }
            if iteration == MOST_ITERATIONS {
                return Err(Error::NoConvergence { index: l, limit: MOST_ITERATIONS });
            }
            ql_step(n, [l, m], d, e, vectors);
        }
    }
    Ok(())
}

/// One implicit QL step on rows `l` to `m`, with Wilkinson's shift.
fn ql_step(n: usize, [l, m]: [usize; 2], d: &mut [f64], e: &mut [f64], vectors: &mut [f64]) {
    let g = (d[l + 1] - d[l]) / (2.0 * e[l]);
    let r = libm::hypot(g, 1.0);
    let mut g = d[m] - d[l] + e[l] / (g + if g >= 0.0 { r } else { -r });
    let (mut sine, mut cosine, mut p) = (1.0, 1.0, 0.0);
    for i in (l..m).rev() {
        let (f, b) = (sine * e[i], cosine * e[i]);
        let r = libm::hypot(f, g);
        e[i + 1] = r;
        if r == 0.0 {
            d[i + 1] -= p;
            e[m] = 0.0;
            return;
        }
        (sine, cosine) = (f / r, g / r);
        g = d[i + 1] - p;
        let r = (d[i] - g) * sine + 2.0 * cosine * b;
        p = sine * r;
        d[i + 1] = g + p;
        g = cosine * r - b;
        let (lower, upper) = vectors[i * n..(i + 2) * n].split_at_mut(n);
        for (low, high) in lower.iter_mut().zip(upper) {
            let turned = *high;
            *high = sine * *low + cosine * turned;
            *low = cosine * *low - sine * turned;
        }
    }
    d[l] -= p;
    e[l] = g;
    e[m] = 0.0;
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;

    fn checks(n: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        let found = symmetric_eigen(n, matrix.clone()).unwrap();
        let size = found.values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let limit = 10.0 * n as f64 * f64::EPSILON;
        for i in 0..n {
            let v = &found.vectors[i * n..(i + 1) * n];
            for row in 0..n {
                let image: f64 = (0..n).map(|k| matrix[row * n + k] * v[k]).sum();
                assert!((image - found.values[i] * v[row]).abs() < limit * size, "{i}, {row}");
            }
            for j in 0..n {
                let w = &found.vectors[j * n..(j + 1) * n];
                let product: f64 = v.iter().zip(w).map(|(v, w)| v * w).sum();
                assert!((product - f64::from(i == j)).abs() < limit, "{i}, {j}: {product}");
            }
        }
        assert!(found.values.windows(2).all(|pair| pair[0] >= pair[1]));
        found.values
    }

    #[test]
    fn second_difference_has_its_known_eigenvalues() {
        let n = 40;
        let values = checks(n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        for (k, value) in values.iter().enumerate() {
            let angle = (n - k) as f64 * std::f64::consts::PI / (n + 1) as f64;
            assert!((value - (2.0 - 2.0 * angle.cos())).abs() < 1e-14, "{k}: {value}");
        }
    }

    #[test]
    fn full_degenerate_and_tiny_matrices_are_diagonalised() {
        checks(60, |i, j| (-(i.abs_diff(j) as f64) / 7.0).exp());
        checks(25, |i, j| (-(i.abs_diff(j) as f64 / 9.0).powi(2)).exp());
        checks(12, |i, j| f64::from(i == j));
        checks(9, |_, _| 1.0);
        checks(2, |i, j| 1.0 + (i + j) as f64);
        assert_eq!(checks(1, |_, _| -3.0), [-3.0]);
    }
}
