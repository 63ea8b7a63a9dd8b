//! Weighted least squares of a polynomial around a point, in any dimension, several fits side by side.

use super::aligned::Aligned;
use super::fit_points::Points;
use super::moment_sums::Sums;
use super::monomials::{MOST_UNKNOWNS, Monomials};
use super::normal_equations::{Determined, LANES, NormalEquations, OfUnknowns};

/// The normal equations of
///
/// $$ \min_c \sum_j w_j \Big( \sum_a c_a u_j^a - f_j \Big)^2 $$
///
/// over the monomials `u^a` of degree at most `p`, for a fit in each lane. The matrix holds the moments
/// `sum_j w_j u_j^(a+b)`, of which there are far fewer than entries: 84 for 210 with a cubic in three variables. Only the
/// moments are summed.
#[derive(Debug, Clone)]
pub(crate) struct LeastSquares {
    tables: &'static Monomials,
    /// Moments of each fit, by lane.
    moments: Aligned,
    right_sides: OfUnknowns,
    coefficients: OfUnknowns,
    equations: NormalEquations,
    sums: Sums,
}

/// What fits need besides the cloud, reused from one to the next.
#[derive(Debug, Clone)]
pub(crate) struct Scratch {
    pub(crate) points: Points,
    pub(crate) equations: LeastSquares,
}

impl Scratch {
    pub(crate) fn new<const D: usize>(tables: &'static Monomials) -> Self {
        Self { points: Points::new(D), equations: LeastSquares::new(tables) }
    }
}

impl LeastSquares {
    pub(crate) fn new(tables: &'static Monomials) -> Self {
        let mut fits = Self {
            tables,
            moments: Aligned::default(),
            right_sides: OfUnknowns::ZERO,
            coefficients: OfUnknowns::ZERO,
            equations: NormalEquations::new(),
            sums: Sums::default(),
        };
        fits.clear(tables);
        fits
    }

    /// Forgets all points and fits the monomials of the given tables from now on.
    pub(crate) fn clear(&mut self, tables: &'static Monomials) {
        self.tables = tables;
        self.moments.resize(LANES * tables.n_moments);
        self.moments.fill(0.0);
        self.right_sides.0[..tables.n_unknowns].fill([0.0; LANES]);
    }

    /// Sums the points of the fit in a lane, which must have none yet.
    pub(crate) fn sum(&mut self, lane: usize, points: &Points) {
        let Self { tables, sums, moments, right_sides, .. } = self;
        sums.compute(tables, points);
        for (moments, sum) in moments.chunks_exact_mut(LANES).zip(&*sums.moments) {
            moments[lane] = *sum;
        }
        for (right_side, sum) in right_sides.0.iter_mut().zip(&*sums.right_sides) {
            right_side[lane] = *sum;
        }
    }

    /// Sums the points of one fit, which all lanes have then: for several right sides.
    pub(crate) fn sum_in_all(&mut self, points: &Points) {
        self.sum(0, points);
        for moments in self.moments.chunks_exact_mut(LANES) {
            moments.fill(moments[0]);
        }
    }

    /// The factor of every fit.
    pub(crate) fn factorise(&mut self) -> [Determined; LANES] {
        self.equations.factorise(self.tables, &self.moments)
    }

    /// Solves every fit. A monomial that the points do not distinguish from those before it gets the coefficient zero.
    pub(crate) fn solve(&mut self) -> [Determined; LANES] {
        let determined = self.factorise();
        let n = self.tables.n_unknowns;
        self.coefficients.0[..n].copy_from_slice(&self.right_sides.0[..n]);
        self.equations.substitute(&mut self.coefficients);
        determined
    }

    /// `weights[m][p] = w_p (N^-1 e_m . b(u_p))` for offsets `u_p` with weights `w_p`, the normal matrix `N` that all lanes
    /// have, and the monomials `b`: what a value at `u_p` adds to coefficient `m`, for the first `count` coefficients.
    pub(crate) fn weights<const D: usize>(
        &self,
        points: &[([f64; D], f64)],
        count: usize,
    ) -> Vec<Vec<f64>> {
        let &Monomials { n_unknowns, ref parent, ref axis, .. } = self.tables;
        // Column `a` of the inverse's first rows.
        let mut columns = vec![vec![0.0; count]; n_unknowns];
        let n_rows = count.min(n_unknowns);
        for first in (0..n_rows).step_by(LANES) {
            let mut b = OfUnknowns::ZERO;
            let width = LANES.min(n_rows - first);
            for lane in 0..width {
                b.0[first + lane][lane] = 1.0;
            }
            self.equations.substitute(&mut b);
            for (column, solved) in columns.iter_mut().zip(&b.0) {
                column[first..first + width].copy_from_slice(&solved[..width]);
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

    /// The sum of the weights of a fit.
    pub(crate) fn weight(&self, lane: usize) -> f64 {
        self.moments[lane]
    }

    /// The gradient of a fit at the origin.
    pub(crate) fn gradient<const D: usize>(&self, lane: usize) -> [f64; D] {
        std::array::from_fn(|k| self.coefficient(1 + k, lane))
    }

    /// The second derivatives of a fit at the origin; zero where it has none.
    pub(crate) fn hessian<const D: usize>(&self, lane: usize) -> [[f64; D]; D] {
        let mut hessian = [[0.0; D]; D];
        let mut next = 1 + D;
        for i in 0..D {
            for j in i..D {
                let coefficient = self.coefficient(next, lane);
                hessian[i][j] = if i == j { 2.0 * coefficient } else { coefficient };
                hessian[j][i] = hessian[i][j];
                next += 1;
            }
        }
        hessian
    }

    /// Zero beyond the degree of the fit.
    fn coefficient(&self, m: usize, lane: usize) -> f64 {
        if m < self.tables.n_unknowns { self.coefficients.0[m][lane] } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points with their values.
    fn with_values<const D: usize>(points: &[([f64; D], f64, f64)]) -> Points {
        let places: Vec<_> = points.iter().map(|&(u, w, _)| (u, w)).collect();
        let mut columns = Points::of(&places);
        for (value, point) in columns.values.iter_mut().zip(points) {
            *value = point.2;
        }
        columns
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
        let mut fit = LeastSquares::new(Monomials::of_degree::<3>(3).unwrap());
        let points: Vec<_> = (0..125)
            .map(|k| {
                let u = [k % 5, k / 5 % 5, k / 25].map(|i| 0.5 * f64::from(i) - 0.9);
                (u, 1.0 / (1.0 + f64::from(k)), f(&u))
            })
            .collect();
        // Beside another fit and in another lane than the first.
        fit.sum(0, &with_values(&points[..40]));
        fit.sum(5, &with_values(&points));
        let determined = fit.solve()[5];
        assert!(determined.n_left_out == 0 && determined.smallest_pivot > 1e-4, "{determined:?}");
        // Roundoff times the condition of the normal matrix, below 1e4.
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-11, "{a} against {b}");
        for (found, expected) in fit.gradient::<3>(5).into_iter().zip([0.3, -1.0, 0.7]) {
            near(found, expected);
        }
        let hessian = [[-1.0, 0.2, 0.5], [0.2, -2.0, 0.1], [0.5, 0.1, 0.4]];
        for (found, expected) in
            fit.hessian::<3>(5).as_flattened().iter().zip(hessian.as_flattened())
        {
            near(*found, *expected);
        }
    }

    #[test]
    fn the_weights_of_offsets_give_the_coefficients_of_their_values() {
        let tables = Monomials::of_degree::<2>(2).unwrap();
        let (mut fit, mut by_weights) = (LeastSquares::new(tables), LeastSquares::new(tables));
        let points: Vec<_> = (0..16)
            .map(|k| ([f64::from(k % 4) - 1.3, f64::from(k / 4) - 1.6], 1.0 + 0.1 * f64::from(k)))
            .collect();
        let value = |[x, y]: [f64; 2]| (0.3 * x).exp() + (0.7 * x - y).sin();
        let valued: Vec<_> = points.iter().map(|&(u, w)| (u, w, value(u))).collect();
        fit.sum(3, &with_values(&valued));
        by_weights.sum_in_all(&Points::of(&points));
        assert_eq!(by_weights.factorise()[7], fit.solve()[3]);
        for (m, weights) in by_weights.weights(&points, 6).iter().enumerate() {
            let found: f64 = weights.iter().zip(&points).map(|(w, (u, _))| w * value(*u)).sum();
            assert!((found - fit.coefficients.0[m][3]).abs() < 1e-13, "{m}: {found}");
        }
        assert_eq!(by_weights.weights(&points, 8)[7], vec![0.0; 16]);
    }

    #[test]
    fn on_a_line_only_what_leads_off_it_is_left_out() {
        let mut fit = LeastSquares::new(Monomials::of_degree::<2>(2).unwrap());
        let points: Vec<_> = (0..9)
            .map(|k| {
                let s = f64::from(k) - 4.0;
                ([s, 2.0 * s], 1.0, 3.0 + 0.5 * s - 0.25 * s * s)
            })
            .collect();
        fit.sum(0, &with_values(&points));
        let determined = fit.solve()[0];
        assert_eq!(
            determined.n_left_out, 3,
            "of 1, x, y, x^2, xy, y^2 a line carries 1, x and x^2"
        );
        let [g_x, g_y] = fit.gradient(0);
        assert!((g_x + 2.0 * g_y - 0.5).abs() < 1e-12, "the slope along the line: {g_x} {g_y}");
    }

    #[test]
    fn a_fit_has_the_same_bits_in_every_lane_and_beside_any_other() {
        let point = |k: u32| {
            let [x, y] = [f64::from(k % 7) / 3.0 - 1.0, f64::from(k / 7) / 2.0 - 1.0];
            ([x, y + 0.1 * x], 1.0 / (1.0 + f64::from(k)), (x - 0.3 * y).sin())
        };
        let points: Vec<_> = (0..35).map(point).collect();
        let tables = Monomials::of_degree::<2>(2).unwrap();
        let fit_in = |lane: usize, others: usize| {
            let mut fit = LeastSquares::new(tables);
            for other in (0..LANES).filter(|other| *other != lane) {
                fit.sum(other, &with_values(&points[..others]));
            }
            fit.sum(lane, &with_values(&points));
            (fit.solve()[lane], fit.gradient::<2>(lane), fit.hessian::<2>(lane))
        };
        let alone = fit_in(0, 0);
        for lane in 0..LANES {
            assert_eq!(fit_in(lane, 9 + lane), alone, "lane {lane}");
        }
    }
}
