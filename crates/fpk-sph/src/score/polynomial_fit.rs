//! Weighted least squares of a polynomial around a point, in any dimension: weights that turn values into coefficients.

use super::monomials::{MOST_MOMENTS, MOST_UNKNOWNS, Monomials};

/// The normal equations of
///
/// $$ \min_c \sum_j w_j \Big( \sum_a c_a u_j^a - f_j \Big)^2 $$
///
/// over the monomials `u^a` of degree at most `p`, as their equilibrated Cholesky factor. The matrix holds the moments
/// `sum_j w_j u_j^(a+b)`, of which there are far fewer than entries: 84 for 210 with a cubic in three variables. Only the
/// moments are summed.
#[derive(Debug, Clone)]
pub(crate) struct LeastSquares {
    tables: &'static Monomials,
    /// Lower triangle of the factor by rows. Its diagonal holds the reciprocal of the pivot's root, or zero where the monomial
    /// is left out.
    factor: Vec<f64>,
    /// By which each unknown is equilibrated.
    scale: [f64; MOST_UNKNOWNS],
}

/// How well the points determined the polynomial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Determined {
    /// Smallest pivot that was kept, in `(0, 1]`: the square of the sine of the angle between a monomial and those before
    /// it.
    pub(crate) smallest_pivot: f64,
    /// Omitted monomials: the points do not distinguish them from those of lower degree.
    pub(crate) n_left_out: usize,
}

/// A pivot of the equilibrated normal matrix below which its monomial counts as a combination of those before it: the
/// relative error of what is solved is about `f64::EPSILON / 1e-11`, 2e-5 of the largest term.
const SMALLEST_PIVOT: f64 = 1e-11;

/// Partial sums of a moment, each over every eighth point.
const LANES: usize = 8;

/// Where row `i` of a lower triangle starts.
const fn row(i: usize) -> usize {
    i * (i + 1) / 2
}

impl LeastSquares {
    /// Factorises the equilibrated normal matrix of points `u_p` with their weights `w_p`. A monomial that the points do not
    /// distinguish from those before it is left out: on a surface the fit omits the normal direction and keeps the rest.
    pub(crate) fn new<const D: usize>(
        tables: &'static Monomials,
        points: &[([f64; D], f64)],
    ) -> (Self, Determined) {
        let (n, moments) = (tables.n_unknowns, moments(tables, points));
        let products = tables.product[..row(n)].iter();
        let mut a: Vec<f64> = products.map(|&m| moments[usize::from(m)]).collect();
        let mut scale = [0.0; MOST_UNKNOWNS];
        for i in 0..n {
            let diagonal = a[row(i) + i];
            scale[i] = if diagonal > 0.0 { 1.0 / diagonal.sqrt() } else { 0.0 };
        }
        let mut determined = Determined { smallest_pivot: 1.0, n_left_out: 0 };
        for i in 0..n {
            let mut pivot = if scale[i] > 0.0 { 1.0 } else { 0.0 };
            for j in 0..i {
                let mut entry = a[row(i) + j] * scale[i] * scale[j];
                for k in 0..j {
                    entry -= a[row(i) + k] * a[row(j) + k];
                }
                entry *= a[row(j) + j];
                pivot -= entry * entry;
                a[row(i) + j] = entry;
            }
            if pivot > SMALLEST_PIVOT {
                a[row(i) + i] = 1.0 / pivot.sqrt();
                determined.smallest_pivot = determined.smallest_pivot.min(pivot);
            } else {
                a[row(i) + i] = 0.0;
                determined.n_left_out += 1;
            }
        }
        (Self { tables, factor: a, scale }, determined)
    }

    /// Solves for a right side; a monomial that is left out gets zero.
    fn substitute(&self, b: &mut [f64; MOST_UNKNOWNS]) {
        let (n, a, scale) = (self.tables.n_unknowns, &self.factor, &self.scale);
        for i in 0..n {
            let mut value = b[i] * scale[i];
            for j in 0..i {
                value -= a[row(i) + j] * b[j];
            }
            b[i] = value * a[row(i) + i];
        }
        for i in (0..n).rev() {
            let mut value = b[i];
            for k in i + 1..n {
                value -= a[row(k) + i] * b[k];
            }
            b[i] = value * a[row(i) + i];
        }
        for i in 0..n {
            b[i] *= scale[i];
        }
    }

    /// `weights[m][p] = w_p (N^-1 e_m . b(u_p))` for the points of the fit, with the normal matrix `N` and the monomials `b`:
    /// what a value at `u_p` adds to coefficient `m`, for the first `count` coefficients.
    pub(crate) fn weights<const D: usize>(
        &self,
        points: &[([f64; D], f64)],
        count: usize,
    ) -> Vec<Vec<f64>> {
        let &Monomials { n_unknowns, ref parent, ref axis, .. } = self.tables;
        // Column `a` of the inverse's first rows.
        let mut columns = vec![vec![0.0; count]; n_unknowns];
        for first in 0..count.min(n_unknowns) {
            let mut b = [0.0; MOST_UNKNOWNS];
            b[first] = 1.0;
            self.substitute(&mut b);
            for (column, solved) in columns.iter_mut().zip(&b) {
                column[first] = *solved;
            }
        }
        let mut weights = vec![vec![0.0; points.len()]; count];
        let (mut monomials, mut sums) = ([1.0; MOST_UNKNOWNS], vec![0.0; count]);
        for (p, (u, w)) in points.iter().enumerate() {
            sums.copy_from_slice(&columns[0]);
            for a in 1..n_unknowns {
                let monomial = monomials[usize::from(parent[a])] * u[usize::from(axis[a])];
                monomials[a] = monomial;
                for (sum, coefficient) in sums.iter_mut().zip(&columns[a]) {
                    *sum += coefficient * monomial;
                }
            }
            for (weights, sum) in weights.iter_mut().zip(&sums) {
                weights[p] = w * sum;
            }
        }
        weights
    }
}

/// `sum_j w_j u_j^a` for all monomials of twice the degree, in [`LANES`] partial sums, which are added last.
fn moments<const D: usize>(tables: &Monomials, points: &[([f64; D], f64)]) -> Vec<f64> {
    let n = tables.n_moments;
    let mut sums = vec![[0.0; LANES]; n];
    simd_lanes::dispatch(
        #[inline(always)]
        || {
            let mut monomials = [[0.0; LANES]; MOST_MOMENTS];
            for points in points.chunks(LANES) {
                // Beyond the last point all weights are zero.
                let (mut offsets, mut weights) = ([[0.0; LANES]; D], [0.0; LANES]);
                for (s, (u, w)) in points.iter().enumerate() {
                    weights[s] = *w;
                    for k in 0..D {
                        offsets[k][s] = u[k];
                    }
                }
                monomials[0] = weights;
                for m in 1..n {
                    let along = &offsets[usize::from(tables.axis[m])];
                    let parent = monomials[usize::from(tables.parent[m])];
                    for s in 0..LANES {
                        monomials[m][s] = along[s] * parent[s];
                    }
                }
                for m in 0..n {
                    for s in 0..LANES {
                        sums[m][s] += monomials[m][s];
                    }
                }
            }
        },
    );
    sums.iter().map(|&[a, b, c, d, e, f, g, h]| ((a + b) + (c + d)) + ((e + f) + (g + h))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of the fit to values at points.
    fn fitted<const D: usize>(
        degree: usize,
        points: &[([f64; D], f64)],
        value: impl Fn(&[f64; D]) -> f64,
    ) -> (Vec<f64>, Determined) {
        let tables = Monomials::of_degree::<D>(degree).unwrap();
        let (fit, determined) = LeastSquares::new(tables, points);
        let sum =
            |weights: Vec<f64>| weights.iter().zip(points).map(|(w, (u, _))| w * value(u)).sum();
        (fit.weights(points, tables.n_unknowns).into_iter().map(sum).collect(), determined)
    }

    #[test]
    fn a_cubic_in_three_variables_comes_back() {
        let f = |&[x, y, z]: &[f64; 3]| {
            0.9 + 0.3 * x - y + 0.7 * z - 0.5 * x * x + 0.2 * x * y + 0.5 * x * z - y * y
                + 0.1 * y * z
                + 0.2 * z * z
                + 0.4 * x * x * z
                - 0.6 * y * z * z
                + 0.3 * x * y * z
        };
        let place = |k: i32| {
            let u = [k % 5, k / 5 % 5, k / 25].map(|i| 0.5 * f64::from(i) - 0.9);
            (u, 1.0 / (1.0 + f64::from(k)))
        };
        let points: Vec<_> = (0..125).map(place).collect();
        let (found, determined) = fitted(3, &points, f);
        assert!(determined.n_left_out == 0 && determined.smallest_pivot > 1e-4, "{determined:?}");
        // 1; x, y, z; x^2, xy, xz, y^2, yz, z^2.
        let expected = [0.9, 0.3, -1.0, 0.7, -0.5, 0.2, 0.5, -1.0, 0.1, 0.2];
        for (found, expected) in found.into_iter().zip(expected) {
            // Roundoff times the condition of the normal matrix, below 1e4.
            assert!((found - expected).abs() < 1e-11, "{found} against {expected}");
        }
    }

    #[test]
    fn on_a_line_only_what_leads_off_it_is_left_out() {
        let along = |k: i32| f64::from(k) - 4.0;
        let points: Vec<_> = (0..9).map(|k| ([along(k), 2.0 * along(k)], 1.0)).collect();
        let (found, determined) = fitted(2, &points, |[s, _]| 3.0 + 0.5 * s - 0.25 * s * s);
        assert_eq!(
            determined.n_left_out, 3,
            "of 1, x, y, x^2, xy, y^2 a line carries 1, x and x^2"
        );
        let [g_x, g_y] = [found[1], found[2]];
        assert!((g_x + 2.0 * g_y - 0.5).abs() < 1e-12, "the slope along the line: {g_x} {g_y}");
    }

    #[test]
    fn coefficients_beyond_the_degree_have_no_weights() {
        let points: Vec<_> = (0..16).map(|k| ([f64::from(k % 4), f64::from(k / 4)], 1.0)).collect();
        let (fit, _) = LeastSquares::new(Monomials::of_degree::<2>(2).unwrap(), &points);
        assert_eq!(fit.weights(&points, 8)[7], vec![0.0; 16]);
    }
}
