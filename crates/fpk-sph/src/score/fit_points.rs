//! The points of a local polynomial fit, in columns.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Registers, SimdLevel, Work};

use super::aligned::Aligned;
use super::normal_equations::LANES;

/// Points around the one that a polynomial is fitted at, in columns of whole registers: offsets `u_j` by axis, weights
/// `w_j`, values `f_j`. Entries beyond the last point have the weight zero.
#[derive(Debug, Clone)]
pub(crate) struct Points {
    n: usize,
    /// By axis.
    pub(super) offsets: Vec<Aligned>,
    /// Of the lengths of the offsets.
    squares: Aligned,
    pub(super) weights: Aligned,
    pub(super) values: Aligned,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_have_the_same_bits_at_every_level() {
        let place = |k: u32| {
            let t = f64::from(k);
            ([(0.7 * t).sin(), (1.3 * t).cos(), 0.1 * t - 2.0], 1.0 / (1.0 + t))
        };
        // A part of a register at the end.
        let places: Vec<_> = (0..75).map(place).collect();
        for y in [None, Some(&[0.3, -0.2, 1.0][..])] {
            let at = |level: SimdLevel| {
                let mut points = Points::of(&places);
                level.run(Measure { points: &mut points, y, scale: 0.37 });
                let all = [&points.offsets[0], &points.offsets[2], &points.squares, &points.values];
                all.map(|column| column.to_vec())
            };
            let expected = at(SimdLevel::PORTABLE);
            for level in SimdLevel::available() {
                assert_eq!(at(level), expected, "{}", level.name());
            }
            let ([u, v, w], _) = places[74];
            assert!((expected[2][74] - (u * u + v * v + w * w)).abs() < 1e-14);
            let along = y.map_or(0.0, |y| y[0] * u + y[1] * v + y[2] * w + 0.5 * expected[2][74]);
            assert!((expected[3][74] - along).abs() < 1e-14 && expected[3][75].abs() < 1e-300);
        }
    }
}
