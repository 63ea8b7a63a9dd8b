//! Weighted least squares of a polynomial around a point, in any dimension, several fits side by side.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use lanes::{Registers, SimdLevel, Work};

use super::aligned::Aligned;
use super::monomials::{MOST_UNKNOWNS, Monomials};
use super::normal_equations::{Determined, LANES, NormalEquations, OfUnknowns};

/// Points that are taken together: the monomials of a quadratic in three variables fill a third of the first-level cache,
/// those of a cubic all of it.
const TOGETHER: usize = 8 * LANES;

/// Points around the one that a polynomial is fitted at, in columns of whole registers: offsets `u_j` by axis, weights
/// `w_j`, values `f_j`. Entries beyond the last point have the weight zero.
#[derive(Debug, Clone)]
pub(crate) struct Points {
    n: usize,
    /// By axis.
    offsets: Vec<Aligned>,
    /// Of the lengths of the offsets.
    squares: Aligned,
    weights: Aligned,
    values: Aligned,
}

impl Points {
    pub(crate) fn new(dimension: usize) -> Self {
        let (squares, weights, values) = Default::default();
        let offsets = (0..dimension).map(|_| Aligned::default()).collect();
        Self { n: 0, offsets, squares, weights, values }
    }

    /// Makes room for `n` points; entries beyond the last are zero.
    pub(crate) fn reset(&mut self, n: usize) {
        self.n = n;
        let Self { offsets, squares, weights, values, .. } = self;
        for column in offsets.iter_mut().chain([squares, weights, values]) {
            column.resize(n.next_multiple_of(LANES));
            column[n..].fill(0.0);
        }
    }

    /// The offsets by axis and the values, a number for each point.
    pub(crate) fn columns<const D: usize>(&mut self) -> ([&mut [f64]; D], &mut [f64]) {
        let mut axes = self.offsets.iter_mut().map(|column| &mut **column);
        (std::array::from_fn(|_| axes.next().unwrap_or_default()), &mut self.values)
    }

    /// The squares of the lengths of the offsets, as [`Self::measure`] found them, and the weights: whole registers, those
    /// beyond the last point with the given square.
    pub(crate) fn squares_and_weights(&mut self, beyond: f64) -> (&[f64], &mut [f64]) {
        self.squares[self.n..].fill(beyond);
        (&self.squares, &mut self.weights)
    }

    /// Measures the offsets and then multiplies them by `scale`. Around a place `y` the values change by that of
    /// `|y|^2 / 2`, which is `y . u + |u|^2 / 2`.
    pub(crate) fn measure(&mut self, y: Option<&[f64]>, scale: f64) {
        SimdLevel::best().run(Measure { points: self, y, scale });
    }

    /// The given offsets and weights with the values zero, for weights of a fit.
    pub(crate) fn of<const D: usize>(points: &[([f64; D], f64)]) -> Self {
        let mut columns = Self::new(D);
        columns.reset(points.len());
        columns.values.fill(0.0);
        for (j, (u, w)) in points.iter().enumerate() {
            for (column, component) in columns.offsets.iter_mut().zip(u) {
                column[j] = *component;
            }
            columns.weights[j] = *w;
        }
        columns
    }
}

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

/// Sums of one fit over its points: [`LANES`] numbers for an entry, which are added last.
#[derive(Debug, Clone, Default)]
struct Sums {
    moments: Aligned,
    right_sides: Aligned,
    /// `w_j u_j^a` of the points that are taken together, [`TOGETHER`] numbers for each monomial that is the parent of another.
    monomials: Aligned,
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
        SimdLevel::best().run(Sum { tables, sums, points });
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

/// [`Points::measure`].
struct Measure<'a> {
    points: &'a mut Points,
    y: Option<&'a [f64]>,
    scale: f64,
}

impl Work<f64> for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let Points { offsets, squares, values, .. } = self.points;
        let (scale, half) = (registers.splat(self.scale), registers.splat(0.5));
        for at in (0..squares.len()).step_by(R::N) {
            let (mut square, mut along) = (registers.splat(0.0), registers.splat(0.0));
            for (k, column) in offsets.iter_mut().enumerate() {
                let u = registers.load_at(column, at);
                square = square + u * u;
                if let Some(y) = self.y {
                    along = along + registers.splat(y[k]) * u;
                }
                registers.store_at(u * scale, column, at);
            }
            registers.store_at(square, squares, at);
            if self.y.is_some() {
                let value = registers.load_at(values, at) + (along + half * square);
                registers.store_at(value, values, at);
            }
        }
    }
}

/// [`LeastSquares::sum`]: the sums over all points, lanes added, in the first numbers of [`Sums`].
struct Sum<'a> {
    tables: &'static Monomials,
    sums: &'a mut Sums,
    points: &'a Points,
}

impl Work<f64> for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let Self { tables, sums: Sums { moments, right_sides, monomials }, points } = self;
        let &Monomials { n_unknowns, n_parents, n_moments, .. } = tables;
        moments.resize(LANES * n_moments.next_multiple_of(4));
        right_sides.resize(LANES * n_unknowns.next_multiple_of(4));
        moments[LANES * n_moments..].fill(0.0);
        right_sides[LANES * n_unknowns..].fill(0.0);
        monomials.resize(TOGETHER * n_parents.max(1));
        for first in (0..points.weights.len()).step_by(TOGETHER) {
            let here = first..points.weights.len().min(first + TOGETHER);
            let mut part = Part {
                registers,
                is_first: first == 0,
                values: &points.values[here.clone()],
                monomials,
                moments,
                right_sides,
            };
            part.add(0, &points.weights[here.clone()], None, true, true);
            for m in 1..n_moments {
                let along = &points.offsets[usize::from(tables.axis[m])][here.clone()];
                let parent = Some(usize::from(tables.parent[m]));
                if m < n_unknowns {
                    part.add(m, along, parent, true, true);
                } else if m < n_parents {
                    part.add(m, along, parent, true, false);
                } else {
                    part.add(m, along, parent, false, false);
                }
            }
        }
        add_lanes(registers, moments);
        add_lanes(registers, right_sides);
    }
}

/// Sums over some of the points.
struct Part<'a, R> {
    registers: R,
    is_first: bool,
    values: &'a [f64],
    monomials: &'a mut [f64],
    moments: &'a mut [f64],
    right_sides: &'a mut [f64],
}

impl<R: Registers<f64>> Part<'_, R> {
    /// Adds monomial `m`, its parent times `along`, or `along` itself without a parent. It is stored if it is a parent, and
    /// multiplied by the values if it is an unknown. The caller names both, so that each case is compiled by itself.
    #[inline(always)]
    fn add(
        &mut self,
        m: usize,
        along: &[f64],
        parent: Option<usize>,
        is_parent: bool,
        is_unknown: bool,
    ) {
        let registers = self.registers;
        let (before, own) = self.monomials.split_at_mut((TOGETHER * m).min(self.monomials.len()));
        let along = R::blocks(along);
        // Of one length, so that indices below it are checked once.
        let n = along.len();
        let values = &R::blocks(self.values)[..n];
        let parent = parent.map(|parent| &R::blocks(&before[TOGETHER * parent..])[..n]);
        for s in (0..LANES).step_by(R::N) {
            let (mut sum, mut right_side) = (registers.splat(0.0), registers.splat(0.0));
            if !self.is_first {
                sum = registers.load_at(self.moments, LANES * m + s);
                if is_unknown {
                    right_side = registers.load_at(self.right_sides, LANES * m + s);
                }
            }
            let mut block = s / R::N;
            while block < n {
                let mut value = registers.load(&along[block]);
                if let Some(parent) = parent {
                    value = value * registers.load(&parent[block]);
                }
                if is_parent {
                    registers.store_at(value, own, R::N * block);
                }
                sum = sum + value;
                if is_unknown {
                    right_side = right_side + value * registers.load(&values[block]);
                }
                block += LANES / R::N;
            }
            registers.store_at(sum, self.moments, LANES * m + s);
            if is_unknown {
                registers.store_at(right_side, self.right_sides, LANES * m + s);
            }
        }
    }
}

/// Puts the sums of the lanes of each entry into the first numbers, one for an entry; the number of entries is a multiple of
/// four.
#[inline(always)]
fn add_lanes<R: Registers<f64>>(registers: R, sums: &mut [f64]) {
    for m in (0..sums.len() / LANES).step_by(4) {
        let mut four = [0.0; 4];
        for s in (0..LANES).step_by(R::N) {
            let row = |k: usize| registers.load_at(sums, LANES * (m + k) + s);
            let added = registers.sum_fours([row(0), row(1), row(2), row(3)]);
            for block in 0..R::N / 4 {
                registers.add_four(added, block, &mut four);
            }
        }
        sums[m..m + 4].copy_from_slice(&four);
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

    #[test]
    fn sums_have_the_same_bits_at_every_level() {
        let point = |k: u32| {
            let t = f64::from(k);
            ([(0.7 * t).sin(), (1.3 * t).cos(), 0.1 * t - 2.0], 1.0 / (1.0 + t), (0.2 * t).exp())
        };
        // More than are taken together, and a part of a register.
        let points: Vec<_> = (0..75).map(point).collect();
        for degree in [0, 1, 2, 3] {
            let tables = Monomials::of_degree::<3>(degree).unwrap();
            let at = |level: SimdLevel| {
                let (mut points, mut sums) = (with_values(&points), Sums::default());
                level.run(Measure { points: &mut points, y: Some(&[0.3, -0.2, 1.0]), scale: 0.37 });
                level.run(Sum { tables, sums: &mut sums, points: &points });
                let n = (tables.n_moments, tables.n_unknowns);
                (sums.moments[..n.0].to_vec(), sums.right_sides[..n.1].to_vec())
            };
            let expected = at(SimdLevel::PORTABLE);
            assert!(expected.0.iter().all(|sum| sum.is_finite()));
            for level in SimdLevel::available() {
                assert_eq!(at(level), expected, "degree {degree}, {}", level.name());
            }
        }
    }
}
