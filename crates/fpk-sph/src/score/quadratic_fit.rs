//! Weighted least squares of degree two around a point, in any dimension, on the stack.

/// Unknowns of a quadratic in `D` variables: value, gradient, upper triangle of the Hessian.
pub(crate) const fn unknowns(dimension: usize) -> usize {
    1 + dimension + dimension * (dimension + 1) / 2
}

/// Room for `D = 6`.
const MOST_UNKNOWNS: usize = unknowns(6);

/// Smallest pivot of the factorised normal matrix over its diagonal entry that still counts as determined: the fit's
/// relative error is then about `f64::EPSILON / 1e-11`, 2e-5 of the largest term.
pub(crate) const SMALLEST_PIVOT: f64 = 1e-11;

/// Normal equations of `min sum_j w_j (c_0 + g.u_j + u_j.H u_j / 2 - f_j)^2`.
#[derive(Debug, Clone)]
pub(crate) struct NormalEquations<const D: usize> {
    /// Lower triangle by rows.
    matrix: [f64; MOST_UNKNOWNS * (MOST_UNKNOWNS + 1) / 2],
    right_side: [f64; MOST_UNKNOWNS],
}

/// The fitted quadratic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quadratic<const D: usize> {
    pub(crate) value: f64,
    pub(crate) gradient: [f64; D],
    pub(crate) hessian: [[f64; D]; D],
}

impl<const D: usize> NormalEquations<D> {
    pub(crate) fn new() -> Self {
        Self {
            matrix: [0.0; MOST_UNKNOWNS * (MOST_UNKNOWNS + 1) / 2],
            right_side: [0.0; MOST_UNKNOWNS],
        }
    }

    /// Forgets all points.
    pub(crate) fn clear(&mut self) {
        let n = unknowns(D);
        self.matrix[..n * (n + 1) / 2].fill(0.0);
        self.right_side[..n].fill(0.0);
    }

    /// Adds the value `f` at the offset `u` with weight `w`.
    #[inline]
    pub(crate) fn add(&mut self, u: &[f64; D], w: f64, f: f64) {
        let n = unknowns(D);
        let mut basis = [0.0; MOST_UNKNOWNS];
        basis[0] = 1.0;
        let mut next = 1 + D;
        for i in 0..D {
            basis[1 + i] = u[i];
            for j in i..D {
                basis[next] = u[i] * u[j];
                next += 1;
            }
        }
        let mut entry = 0;
        for k in 0..n {
            let weighted = w * basis[k];
            self.right_side[k] += weighted * f;
            for value in &basis[..=k] {
                self.matrix[entry] += weighted * value;
                entry += 1;
            }
        }
    }

    /// Solves by Cholesky factorisation, or gives the smallest relative pivot met.
    #[inline]
    pub(crate) fn solve(&mut self) -> Result<Quadratic<D>, f64> {
        let n = unknowns(D);
        let row = |i: usize| i * (i + 1) / 2;
        let (a, b) = (&mut self.matrix, &mut self.right_side);
        for j in 0..n {
            let diagonal = a[row(j) + j];
            let mut pivot = diagonal;
            for k in 0..j {
                pivot -= a[row(j) + k] * a[row(j) + k];
            }
            let relative = pivot / diagonal;
            if relative.is_nan() || relative < SMALLEST_PIVOT {
                return Err(relative);
            }
            let root = pivot.sqrt();
            a[row(j) + j] = root;
            for i in j + 1..n {
                let mut entry = a[row(i) + j];
                for k in 0..j {
                    entry -= a[row(i) + k] * a[row(j) + k];
                }
                a[row(i) + j] = entry / root;
            }
        }
        for i in 0..n {
            for k in 0..i {
                b[i] -= a[row(i) + k] * b[k];
            }
            b[i] /= a[row(i) + i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                b[i] -= a[row(k) + i] * b[k];
            }
            b[i] /= a[row(i) + i];
        }
        Ok(unpack(b))
    }
}

/// Coefficients of `u_i u_j` are Hessian entries off the diagonal and half of them on it.
fn unpack<const D: usize>(coefficients: &[f64; MOST_UNKNOWNS]) -> Quadratic<D> {
    let mut quadratic =
        Quadratic { value: coefficients[0], gradient: [0.0; D], hessian: [[0.0; D]; D] };
    let mut next = 1 + D;
    for i in 0..D {
        quadratic.gradient[i] = coefficients[1 + i];
        for j in i..D {
            let entry = if i == j { 2.0 * coefficients[next] } else { coefficients[next] };
            quadratic.hessian[i][j] = entry;
            quadratic.hessian[j][i] = entry;
            next += 1;
        }
    }
    quadratic
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_in_three_variables_comes_back() {
        let gradient = [0.3, -1.0, 0.7];
        let hessian = [[-1.0, 0.2, 0.5], [0.2, -2.0, 0.1], [0.5, 0.1, 0.4]];
        let f = |u: &[f64; 3]| {
            let mut value = 0.9;
            for i in 0..3 {
                value += gradient[i] * u[i];
                for j in 0..3 {
                    value += 0.5 * hessian[i][j] * u[i] * u[j];
                }
            }
            value
        };
        let mut equations = NormalEquations::<3>::new();
        for k in 0..27 {
            let u = [f64::from(k % 3) - 1.0, f64::from(k / 3 % 3) - 0.9, f64::from(k / 9) - 1.2];
            equations.add(&u, 1.0 / (1.0 + f64::from(k)), f(&u));
        }
        let fit = equations.solve().unwrap();
        // Roundoff times the condition of the normal matrix, about 1e3.
        assert!((fit.value - 0.9).abs() < 1e-12);
        for i in 0..3 {
            assert!((fit.gradient[i] - gradient[i]).abs() < 1e-12);
            for j in 0..3 {
                assert!((fit.hessian[i][j] - hessian[i][j]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn points_on_a_line_do_not_determine_a_plane_quadratic() {
        let mut equations = NormalEquations::<2>::new();
        for k in 0..9 {
            let s = f64::from(k) - 4.0;
            equations.add(&[s, 2.0 * s], 1.0, s);
        }
        assert!(equations.solve().unwrap_err() < SMALLEST_PIVOT);
    }
}
