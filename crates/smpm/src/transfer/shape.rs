//! Shape functions: how a particle is seen by the nodes around it.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::Scalar;

use crate::grid::tile_size::{MOST_NODES, block_edge};

/// Which shape function carries values between particles and nodes.
///
/// | name | nodes per axis | smooth | note |
/// |---|---|---|---|
/// | `QuadraticBSpline` | 3 | once | Steffen, Kirby & Berzins 2008 |
/// | `CubicBSpline` | 4 | twice | second derivatives of a run stay smooth where particles cross cells |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Quadratic B-spline.
    QuadraticBSpline,
    /// Cubic B-spline.
    CubicBSpline,
}

/// Values and slopes (per cell) of a shape function along one axis, from the lowest node that a particle sees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis<S> {
    pub(crate) value: [S; MOST_NODES],
    pub(crate) slope: [S; MOST_NODES],
}

impl Shape {
    /// Nodes that a particle sees along an axis. What loops over nodes takes it as a constant, so that the loops unroll.
    pub(crate) const fn n_nodes(self) -> usize {
        match self {
            Self::QuadraticBSpline => 3,
            Self::CubicBSpline => 4,
        }
    }

    /// The multiple `c` of the second derivative, in squares of a cell, in the shape function `N + c N''` of the hoop, for particles
    /// that start a distance `spacing` (in cells) apart along the radius.
    ///
    /// A pressure that is the same everywhere acts on a node with $\sum_p A_p (r N)'(r_p)$, the midpoint rule for the integral of
    /// a derivative. Inside a body it is exact. At the axis, and at any plane of symmetry normal to the radius, the rule lacks
    /// the part of `N` beyond the plane, and the nodes beside it have a force: the pressure beside the axis is 4 % low. With
    /// `s^2/8` for the quadratic and `s^2/12` for the cubic B-spline the sum is exact, and so is the hoop strain of a velocity
    /// that is linear in `r`. The quadratic B-spline with an odd number of particles along a cell needs none: its knots then
    /// are at particles.
    pub(crate) fn hoop_curvature(self, spacing: f64) -> f64 {
        let is_odd = (1.0 / spacing).round() % 2.0 > 0.5;
        match self {
            Self::QuadraticBSpline if is_odd => 0.0,
            Self::QuadraticBSpline => spacing * spacing / 8.0,
            Self::CubicBSpline => spacing * spacing / 12.0,
        }
    }

    /// How far below its place, in cells, a particle looks for its lowest node, and how many nodes below the one there that is.
    #[inline(always)]
    pub(crate) fn reach(self) -> (f64, i32) {
        match self {
            Self::QuadraticBSpline => (0.5, 0),
            Self::CubicBSpline => (0.0, 1),
        }
    }
}

/// The lowest node that a particle at `s` (in cells) sees.
#[inline(always)]
pub(crate) fn lowest_node(s: f64, (reach, further): (f64, i32)) -> i32 {
    // Round the end of the type it is as far away, and refused.
    floor(s - reach).wrapping_sub(further)
}

/// The largest whole number not above `s`, or the end of the type; as `as i32`, but for many at once.
#[inline(always)]
#[allow(clippy::cast_possible_truncation, reason = "the lowest bits are the whole number")]
fn floor(s: f64) -> i32 {
    // 1.5 times 2^52: a whole number is in the lowest bits of the sum.
    const SHIFT: f64 = 6755399441055744.0;
    let whole = s.floor();
    let whole = if whole > -2147483648.0 { whole } else { -2147483648.0 };
    let whole = if whole < 2147483647.0 { whole } else { 2147483647.0 };
    (whole + SHIFT).to_bits() as i32
}

impl<S: Scalar> Axis<S> {
    #[inline(always)]
    pub(crate) fn empty() -> Self {
        let zeros = [S::constant(0.0); MOST_NODES];
        Self { value: zeros, slope: zeros }
    }

    /// The B-spline over `NODES` nodes of a particle at the place `s` (in cells), which sees `lowest`
    /// as its lowest node. Only what belongs to these nodes is written.
    #[inline(always)]
    pub(crate) fn set_b_spline<const NODES: usize>(&mut self, s: S, lowest: i32) {
        match NODES {
            3 => self.set_quadratic(s - f64::from(lowest)),
            _ => self.set_cubic(s - f64::from(lowest + 1)),
        }
    }

    /// At `f` from 1/2 to 3/2 behind the lowest node.
    #[inline(always)]
    fn set_quadratic(&mut self, f: S) {
        let (left, centre, right) = (-f + 1.5, f - 1.0, f - 0.5);
        self.value[0] = left.squared() * 0.5;
        self.value[1] = -centre.squared() + 0.75;
        self.value[2] = right.squared() * 0.5;
        (self.slope[0], self.slope[1], self.slope[2]) = (f - 1.5, centre * -2.0, right);
    }

    /// At `f` from 0 to 1 behind the second node.
    #[inline(always)]
    fn set_cubic(&mut self, f: S) {
        let rest = -f + 1.0;
        let (f2, r2) = (f.squared(), rest.squared());
        let sixth = 1.0 / 6.0;
        self.value[0] = r2 * rest * sixth;
        self.value[1] = (f2 * f * 3.0 - f2 * 6.0 + 4.0) * sixth;
        self.value[2] = (r2 * rest * 3.0 - r2 * 6.0 + 4.0) * sixth;
        self.value[3] = f2 * f * sixth;
        self.slope[0] = r2 * -0.5;
        self.slope[1] = f2 * 1.5 - f * 2.0;
        self.slope[2] = -(r2 * 1.5 - rest * 2.0);
        self.slope[3] = f2 * 0.5;
    }
}

/// The part of the axes beyond the first in the shape function of a particle at a row of nodes, and its slopes (per cell) along
/// these axes.
#[inline(always)]
pub(crate) fn outer<S: Scalar, const D: usize>(
    axes: &[Axis<S>; D],
    (j, k): (usize, usize),
) -> (S, [S; D]) {
    let mut slope = [S::constant(0.0); D];
    if D == 1 {
        return (S::constant(1.0), slope);
    }
    let (value_y, slope_y) = (axes[1].value[j], axes[1].slope[j]);
    if D == 2 {
        slope[1] = slope_y;
        return (value_y, slope);
    }
    let (value_z, slope_z) = (axes[2].value[k], axes[2].slope[k]);
    slope[1] = slope_y * value_z;
    slope[2] = value_y * slope_z;
    (value_y * value_z, slope)
}

/// Nodes that a particle sees along an axis of `D`; one along an axis that there is not.
pub(crate) const fn nodes_along<const NODES: usize, const D: usize>(axis: usize) -> usize {
    if axis < D { NODES } else { 1 }
}

/// Nodes of a block from the first that a particle sees to the last.
pub(crate) const fn nodes_spanned<const NODES: usize, const D: usize>() -> usize {
    let edge = block_edge(D);
    let rows = (nodes_along::<NODES, D>(2) - 1) * edge + nodes_along::<NODES, D>(1) - 1;
    rows * edge + NODES
}

#[cfg(test)]
mod tests {
    use super::*;
    use perturbation_moments::Jet;

    fn axis<S: Scalar>(shape: Shape, s: S) -> (i32, Axis<S>) {
        let (lowest, mut axis) = (lowest_node(s.value(), shape.reach()), Axis::empty());
        match shape {
            Shape::QuadraticBSpline => axis.set_b_spline::<3>(s, lowest),
            Shape::CubicBSpline => axis.set_b_spline::<4>(s, lowest),
        }
        (lowest, axis)
    }

    #[test]
    fn shape_functions_part_unity_reproduce_a_line_and_have_their_slopes() {
        for shape in [Shape::QuadraticBSpline, Shape::CubicBSpline] {
            for step in 0..400 {
                let s = 0.01 * f64::from(step) - 1.7;
                let delta = 1e-6;
                let (lowest, here) = axis(shape, s);
                let (mut sum, mut slopes, mut place) = (0.0, 0.0, 0.0);
                for (k, node) in (lowest..).take(shape.n_nodes()).enumerate() {
                    sum += here.value[k];
                    slopes += here.slope[k];
                    place += here.value[k] * f64::from(node);
                    assert!(here.value[k] > -1e-15, "{shape:?}: negative at {s}");
                }
                assert!(
                    (sum - 1.0).abs() < 1e-14 && slopes.abs() < 1e-13,
                    "{shape:?}: no partition at {s}"
                );
                assert!(
                    (place - s).abs() < 1e-13,
                    "{shape:?}: a linear field does not come back at {s}"
                );
                let ((over, above), (under, below)) =
                    (axis(shape, s + delta), axis(shape, s - delta));
                if over == lowest && under == lowest {
                    for k in 0..shape.n_nodes() {
                        let slope = (above.value[k] - below.value[k]) / (2.0 * delta);
                        // Roundoff of the difference, 1e-10, and where a second derivative jumps delta.
                        let error = (slope - here.slope[k]).abs();
                        assert!(error < 1e-5, "{shape:?}: slope {k} at {s}");
                    }
                }
                let (_, jet) = axis(shape, Jet::variable(s, 0));
                for k in 0..shape.n_nodes() {
                    let error = (jet.value[k].first[0] - here.slope[k]).abs();
                    assert!(error < 1e-12, "{shape:?} at {s}");
                }
            }
        }
    }
}
