//! Weighted least squares of a polynomial around a point, in any dimension, without allocation.

use super::monomials::{MOST_MOMENTS, MOST_UNKNOWNS, Monomials};

/// Points that are taken together: one register of 512 bits, two of 256.
pub(crate) const LANES: usize = 8;

/// A pivot of the equilibrated normal matrix below which its monomial counts as a combination of those before it: the
/// relative error of what is solved is about `f64::EPSILON / 1e-11`, 2e-5 of the largest term.
pub(crate) const SMALLEST_PIVOT: f64 = 1e-11;

/// The normal equations of
///
/// $$ \min_c \sum_j w_j \Big( \sum_a c_a u_j^a - f_j \Big)^2 $$
///
/// over the monomials `u^a` of degree at most `p`. The matrix holds the moments `sum_j w_j u_j^(a+b)`, of which there are
/// far fewer than entries: 84 for 210 with a cubic in three variables. Only the moments are summed.
#[derive(Debug, Clone)]
pub(crate) struct LeastSquares<const D: usize> {
    tables: &'static Monomials<D>,
    moments: [[f64; LANES]; MOST_MOMENTS],
    right_sides: [[f64; LANES]; MOST_UNKNOWNS],
    monomials: [[f64; LANES]; MOST_MOMENTS],
    /// Lower triangle by rows; the factor once solved.
    factor: [f64; MOST_UNKNOWNS * (MOST_UNKNOWNS + 1) / 2],
    coefficients: [f64; MOST_UNKNOWNS],
    scale: [f64; MOST_UNKNOWNS],
}

/// Where row `i` of a lower triangle starts.
const fn row(i: usize) -> usize {
    i * (i + 1) / 2
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

impl<const D: usize> LeastSquares<D> {
    pub(crate) fn new(tables: &'static Monomials<D>) -> Self {
        Self {
            tables,
            moments: [[0.0; LANES]; MOST_MOMENTS],
            right_sides: [[0.0; LANES]; MOST_UNKNOWNS],
            monomials: [[0.0; LANES]; MOST_MOMENTS],
            factor: [0.0; MOST_UNKNOWNS * (MOST_UNKNOWNS + 1) / 2],
            coefficients: [0.0; MOST_UNKNOWNS],
            scale: [0.0; MOST_UNKNOWNS],
        }
    }

    /// Forgets all points and fits the monomials of the given tables from now on.
    pub(crate) fn clear(&mut self, tables: &'static Monomials<D>) {
        self.tables = tables;
        self.moments[..tables.n_moments].fill([0.0; LANES]);
        self.right_sides[..tables.n_unknowns].fill([0.0; LANES]);
    }

    /// Adds the values `f` at the offsets `u` with the weights `w`, one point per lane; a weight of zero fills a lane.
    #[inline]
    pub(crate) fn add(&mut self, u: &[[f64; LANES]; D], w: &[f64; LANES], f: &[f64; LANES]) {
        let Monomials { n_unknowns, n_moments, parent, axis, .. } = self.tables;
        let monomials = &mut self.monomials[..*n_moments];
        monomials[0] = *w;
        add_to(&mut self.moments[0], w);
        for m in 1..*n_moments {
            let (from, along) = (monomials[parent[m] as usize], &u[axis[m] as usize]);
            let value: [f64; LANES] = std::array::from_fn(|lane| from[lane] * along[lane]);
            monomials[m] = value;
            add_to(&mut self.moments[m], &value);
        }
        for (sum, monomial) in self.right_sides[..*n_unknowns].iter_mut().zip(monomials) {
            for lane in 0..LANES {
                sum[lane] += monomial[lane] * f[lane];
            }
        }
    }

    /// Adds the offset `u` with the weight `w`, without a value: as [`Self::add`] with all other lanes zero, bitwise.
    pub(crate) fn add_offset(&mut self, u: &[f64; D], w: f64) {
        let Monomials { n_moments, parent, axis, .. } = self.tables;
        self.monomials[0][0] = w;
        self.moments[0][0] += w;
        for m in 1..*n_moments {
            let value = self.monomials[usize::from(parent[m])][0] * u[usize::from(axis[m])];
            self.monomials[m][0] = value;
            self.moments[m][0] += value;
        }
    }

    /// Solves by Cholesky factorisation of the equilibrated matrix. A monomial that the points do not distinguish
    /// from those before it gets the coefficient zero: on a surface the fit omits the normal direction and keeps the rest.
    #[inline]
    pub(crate) fn solve(&mut self) -> Determined {
        let determined = self.factorise();
        let mut b = [0.0; MOST_UNKNOWNS];
        for (value, lanes) in b.iter_mut().zip(&self.right_sides[..self.tables.n_unknowns]) {
            *value = lanes.iter().sum();
        }
        self.substitute(&mut b);
        self.coefficients = b;
        determined
    }

    /// The factor of the equilibrated matrix; its diagonal holds the reciprocal of the pivot's root, or zero where the
    /// monomial is left out.
    pub(crate) fn factorise(&mut self) -> Determined {
        let n = self.tables.n_unknowns;
        let (a, scale) = (&mut self.factor, &mut self.scale);
        for (entry, &moment) in a[..row(n)].iter_mut().zip(&self.tables.product) {
            *entry = self.moments[usize::from(moment)].iter().sum();
        }
        for i in 0..n {
            let diagonal = a[row(i) + i];
            scale[i] = if diagonal > 0.0 { 1.0 / diagonal.sqrt() } else { 0.0 };
        }
        let mut determined = Determined { smallest_pivot: 1.0, n_left_out: 0 };
        // Row by row: row i of the factor needs the rows before it only.
        for i in 0..n {
            let (head, tail) = a.split_at_mut(row(i));
            let row_i = &mut tail[..=i];
            let mut pivot = if scale[i] > 0.0 { 1.0 } else { 0.0 };
            for j in 0..i {
                let row_j = &head[row(j)..=row(j) + j];
                let mut entry = row_i[j] * scale[i] * scale[j];
                for k in 0..j {
                    entry -= row_i[k] * row_j[k];
                }
                row_i[j] = entry * row_j[j];
                pivot -= row_i[j] * row_i[j];
            }
            if pivot > SMALLEST_PIVOT {
                determined.smallest_pivot = determined.smallest_pivot.min(pivot);
                row_i[i] = 1.0 / pivot.sqrt();
            } else {
                determined.n_left_out += 1;
                row_i[i] = 0.0;
            }
        }
        determined
    }

    /// Solves for another right side by the factor at hand.
    pub(crate) fn substitute(&self, b: &mut [f64; MOST_UNKNOWNS]) {
        let (n, a, scale) = (self.tables.n_unknowns, &self.factor, &self.scale);
        for i in 0..n {
            b[i] *= scale[i];
            for j in 0..i {
                b[i] -= a[row(i) + j] * b[j];
            }
            b[i] *= a[row(i) + i];
        }
        for i in (0..n).rev() {
            b[i] *= a[row(i) + i];
            for k in 0..i {
                b[k] -= a[row(i) + k] * b[i];
            }
        }
        for i in 0..n {
            b[i] *= scale[i];
        }
    }

    /// `weights[m][p] = w_p (N^-1 e_m . b(u_p))` for offsets `u_p` with weights `w_p`, the normal matrix `N` of which the factor
    /// is at hand, and the monomials `b`: what a value at `u_p` adds to coefficient `m`, for the first `count` coefficients.
    pub(crate) fn weights(&self, points: &[([f64; D], f64)], count: usize) -> Vec<Vec<f64>> {
        let Monomials { n_unknowns, parent, axis, .. } = self.tables;
        // The column `a` of the inverse's first rows.
        let mut columns = vec![vec![0.0; count]; *n_unknowns];
        for m in 0..count.min(*n_unknowns) {
            let mut solved = [0.0; MOST_UNKNOWNS];
            solved[m] = 1.0;
            self.substitute(&mut solved);
            for (column, value) in columns.iter_mut().zip(solved) {
                column[m] = value;
            }
        }
        let mut weights = vec![vec![0.0; points.len()]; count];
        let (mut monomials, mut sums) = ([1.0; MOST_UNKNOWNS], vec![0.0; count]);
        for (p, (u, w)) in points.iter().enumerate() {
            sums.copy_from_slice(&columns[0]);
            for a in 1..*n_unknowns {
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

    /// The polynomial with the given coefficients at `u`.
    pub(crate) fn polynomial(&self, coefficients: &[f64; MOST_UNKNOWNS], u: &[f64; D]) -> f64 {
        let Monomials { n_unknowns, parent, axis, .. } = self.tables;
        let mut monomials = [1.0; MOST_UNKNOWNS];
        let mut sum = coefficients[0];
        for m in 1..*n_unknowns {
            monomials[m] = monomials[usize::from(parent[m])] * u[usize::from(axis[m])];
            sum += coefficients[m] * monomials[m];
        }
        sum
    }

    /// Unknowns of the polynomial.
    pub(crate) fn n_unknowns(&self) -> usize {
        self.tables.n_unknowns
    }

    /// The gradient at the origin.
    pub(crate) fn gradient(&self) -> [f64; D] {
        std::array::from_fn(|k| self.coefficients[1 + k])
    }

    /// The second derivatives at the origin.
    pub(crate) fn hessian(&self) -> [[f64; D]; D] {
        let mut hessian = [[0.0; D]; D];
        let mut next = 1 + D;
        for i in 0..D {
            for j in i..D {
                let coefficient = self.coefficients[next];
                hessian[i][j] = if i == j { 2.0 * coefficient } else { coefficient };
                hessian[j][i] = hessian[i][j];
                next += 1;
            }
        }
        hessian
    }
}

#[inline]
fn add_to(sum: &mut [f64; LANES], value: &[f64; LANES]) {
    for lane in 0..LANES {
        sum[lane] += value[lane];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds points one by one, a lane each.
    fn add_points<const D: usize>(fit: &mut LeastSquares<D>, points: &[([f64; D], f64, f64)]) {
        for block in points.chunks(LANES) {
            let (mut u, mut w, mut f) = ([[0.0; LANES]; D], [0.0; LANES], [0.0; LANES]);
            for (lane, (point, weight, value)) in block.iter().enumerate() {
                for k in 0..D {
                    u[k][lane] = point[k];
                }
                (w[lane], f[lane]) = (*weight, *value);
            }
            fit.add(&u, &w, &f);
        }
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
        let mut fit = LeastSquares::<3>::new(Monomials::of_degree(3).unwrap());
        fit.clear(Monomials::of_degree(3).unwrap());
        let points: Vec<_> = (0..125)
            .map(|k| {
                let u = [k % 5, k / 5 % 5, k / 25].map(|i| 0.5 * f64::from(i) - 0.9);
                (u, 1.0 / (1.0 + f64::from(k)), f(&u))
            })
            .collect();
        add_points(&mut fit, &points);
        let determined = fit.solve();
        assert!(determined.n_left_out == 0 && determined.smallest_pivot > 1e-4, "{determined:?}");
        // Roundoff times the condition of the normal matrix, below 1e4.
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-11, "{a} against {b}");
        for (found, expected) in fit.gradient().into_iter().zip([0.3, -1.0, 0.7]) {
            near(found, expected);
        }
        let hessian = [[-1.0, 0.2, 0.5], [0.2, -2.0, 0.1], [0.5, 0.1, 0.4]];
        for (found, expected) in fit.hessian().as_flattened().iter().zip(hessian.as_flattened()) {
            near(*found, *expected);
        }
    }

    #[test]
    fn the_weights_of_offsets_give_the_coefficients_of_their_values() {
        let tables = Monomials::<2>::of_degree(2).unwrap();
        let (mut fit, mut by_weights) = (LeastSquares::new(tables), LeastSquares::new(tables));
        let points: Vec<_> = (0..16)
            .map(|k| ([f64::from(k % 4) - 1.3, f64::from(k / 4) - 1.6], 1.0 + 0.1 * f64::from(k)))
            .collect();
        let value = |[x, y]: [f64; 2]| (0.3 * x).exp() + (0.7 * x - y).sin();
        for (u, w) in &points {
            let lane = |value: f64| {
                let mut lanes = [0.0; LANES];
                lanes[0] = value;
                lanes
            };
            fit.add(&u.map(lane), &lane(*w), &lane(value(*u)));
            by_weights.add_offset(u, *w);
        }
        let (one, other) = (fit.solve(), by_weights.factorise());
        assert_eq!((one, fit.factor), (other, by_weights.factor));
        for (m, weights) in by_weights.weights(&points, 6).iter().enumerate() {
            let found: f64 = weights.iter().zip(&points).map(|(w, (u, _))| w * value(*u)).sum();
            assert!((found - fit.coefficients[m]).abs() < 1e-13, "{m}: {found}");
        }
        assert_eq!(by_weights.weights(&points, 8)[7], vec![0.0; 16]);
    }

    #[test]
    fn on_a_line_only_what_leads_off_it_is_left_out() {
        let tables = Monomials::<2>::of_degree(2).unwrap();
        let mut fit = LeastSquares::new(tables);
        fit.clear(tables);
        let points: Vec<_> = (0..9)
            .map(|k| {
                let s = f64::from(k) - 4.0;
                ([s, 2.0 * s], 1.0, 3.0 + 0.5 * s - 0.25 * s * s)
            })
            .collect();
        add_points(&mut fit, &points);
        let determined = fit.solve();
        assert_eq!(
            determined.n_left_out, 3,
            "of 1, x, y, x^2, xy, y^2 a line carries 1, x and x^2"
        );
        let [g_x, g_y] = fit.gradient();
        assert!((g_x + 2.0 * g_y - 0.5).abs() < 1e-12, "the slope along the line: {g_x} {g_y}");
    }
}
