//! Shape functions: how a particle is seen by the nodes around it.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::Scalar;

use crate::tiles::block_edge;

/// Which shape function carries values between particles and nodes.
///
/// | name | nodes per axis | smooth | note |
/// |---|---|---|---|
/// | `Linear` | 2 | continuous | the paper's; its gradient jumps where a particle crosses a cell |
/// | `Gimp` | 4 | once | the particle has a size, which the flow stretches (Bardenhagen & Kober 2004; Chen et al. 2019, eq 8) |
/// | `QuadraticBSpline` | 3 | once | Steffen, Kirby & Berzins 2008 |
/// | `CubicBSpline` | 4 | twice | second derivatives of a run stay smooth where particles cross cells |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// The hat.
    Linear,
    /// The hat averaged over the particle's length along each axis.
    Gimp,
    /// Quadratic B-spline.
    QuadraticBSpline,
    /// Cubic B-spline.
    CubicBSpline,
}

/// Most nodes that a particle sees along an axis.
pub(crate) const MOST_NODES: usize = 4;

/// Values and slopes (per cell) of a shape function along one axis, from the lowest node that a particle sees; of `N` particles, by
/// nodes, so that a register takes several particles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis<S, const N: usize> {
    pub(crate) value: [[S; N]; MOST_NODES],
    pub(crate) slope: [[S; N]; MOST_NODES],
}

/// A shape function as a type, so that loops over its nodes unroll.
pub(crate) trait ShapeFunction: std::fmt::Debug + Send + Sync + 'static {
    /// Nodes along an axis.
    const NODES: usize;
    /// Whether the size of the particle matters.
    const SIZED: bool = false;

    /// At the place `s` (in cells) of a particle, given by its number among the `N`, which reaches `half` cells to either side and sees `base` as its lowest node.
    /// Only what belongs to [`Self::NODES`] nodes is written.
    fn along<S: Scalar, const N: usize>(s: S, half: S, base: i32, of: (&mut Axis<S, N>, usize));

    /// The lowest node that a particle at `s` sees.
    fn base(s: f64, half: f64) -> i32;
}

#[derive(Debug)]
pub(crate) struct Linear;
#[derive(Debug)]
pub(crate) struct Gimp;
#[derive(Debug)]
pub(crate) struct QuadraticBSpline;
#[derive(Debug)]
pub(crate) struct CubicBSpline;

/// The largest whole number not above `s`.
#[inline(always)]
#[allow(
    clippy::cast_possible_truncation,
    reason = "the grid refuses places beyond the range of its node numbers"
)]
fn floor(s: f64) -> i32 {
    s.floor() as i32
}

impl<S: Scalar, const N: usize> Axis<S, N> {
    #[inline(always)]
    pub(crate) fn empty() -> Self {
        let zeros = [[S::constant(0.0); N]; MOST_NODES];
        Self { value: zeros, slope: zeros }
    }
}

impl ShapeFunction for Linear {
    const NODES: usize = 2;

    #[inline(always)]
    fn base(s: f64, _: f64) -> i32 {
        floor(s)
    }

    #[inline(always)]
    fn along<S: Scalar, const N: usize>(
        s: S,
        _: S,
        base: i32,
        (axis, p): (&mut Axis<S, N>, usize),
    ) {
        let f = s - f64::from(base);
        (axis.value[0][p], axis.value[1][p]) = (-f + 1.0, f);
        (axis.slope[0][p], axis.slope[1][p]) = (S::constant(-1.0), S::constant(1.0));
    }
}

impl ShapeFunction for QuadraticBSpline {
    const NODES: usize = 3;

    #[inline(always)]
    fn base(s: f64, _: f64) -> i32 {
        floor(s - 0.5)
    }

    #[inline(always)]
    fn along<S: Scalar, const N: usize>(
        s: S,
        _: S,
        base: i32,
        (axis, p): (&mut Axis<S, N>, usize),
    ) {
        // From 1/2 to 3/2.
        let f = s - f64::from(base);
        let (left, centre, right) = (-f + 1.5, f - 1.0, f - 0.5);
        axis.value[0][p] = left.squared() * 0.5;
        axis.value[1][p] = -centre.squared() + 0.75;
        axis.value[2][p] = right.squared() * 0.5;
        (axis.slope[0][p], axis.slope[1][p], axis.slope[2][p]) = (f - 1.5, centre * -2.0, right);
    }
}

impl ShapeFunction for CubicBSpline {
    const NODES: usize = 4;

    #[inline(always)]
    fn base(s: f64, _: f64) -> i32 {
        // Round the end of the type it is as far away, and refused.
        floor(s).wrapping_sub(1)
    }

    #[inline(always)]
    fn along<S: Scalar, const N: usize>(
        s: S,
        _: S,
        base: i32,
        (axis, p): (&mut Axis<S, N>, usize),
    ) {
        let f = s - f64::from(base + 1);
        let rest = -f + 1.0;
        let (f2, r2) = (f.squared(), rest.squared());
        let sixth = 1.0 / 6.0;
        axis.value[0][p] = r2 * rest * sixth;
        axis.value[1][p] = (f2 * f * 3.0 - f2 * 6.0 + 4.0) * sixth;
        axis.value[2][p] = (r2 * rest * 3.0 - r2 * 6.0 + 4.0) * sixth;
        axis.value[3][p] = f2 * f * sixth;
        axis.slope[0][p] = r2 * -0.5;
        axis.slope[1][p] = f2 * 1.5 - f * 2.0;
        axis.slope[2][p] = -(r2 * 1.5 - rest * 2.0);
        axis.slope[3][p] = f2 * 0.5;
    }
}

impl ShapeFunction for Gimp {
    const NODES: usize = 4;
    const SIZED: bool = true;

    #[inline(always)]
    fn base(s: f64, half: f64) -> i32 {
        floor(s - half)
    }

    /// `(F(d + l) - F(d - l))/(2 l)` with `F` the integral of the hat, `d` the distance from the node and `l` the half
    /// length of the particle in cells.
    #[inline(always)]
    fn along<S: Scalar, const N: usize>(
        s: S,
        half: S,
        base: i32,
        (axis, p): (&mut Axis<S, N>, usize),
    ) {
        let inverse = half.recip() * 0.5;
        for (k, node) in (base..).take(Self::NODES).enumerate() {
            let d = s - f64::from(node);
            let (low, high) = (d - half, d + half);
            axis.value[k][p] = (hat_integral(high) - hat_integral(low)) * inverse;
            axis.slope[k][p] = (hat(high) - hat(low)) * inverse;
        }
    }
}

#[inline(always)]
fn hat<S: Scalar>(u: S) -> S {
    let value = u.value();
    if value.abs() >= 1.0 {
        S::constant(0.0)
    } else if value < 0.0 {
        u + 1.0
    } else {
        -u + 1.0
    }
}

#[inline(always)]
fn hat_integral<S: Scalar>(u: S) -> S {
    let value = u.value();
    if value <= -1.0 {
        S::constant(0.0)
    } else if value >= 1.0 {
        S::constant(1.0)
    } else if value < 0.0 {
        (u + 1.0).squared() * 0.5
    } else {
        -(-u + 1.0).squared() * 0.5 + 1.0
    }
}

/// The part of the axes beyond the first in the shape function of a particle at a row of nodes, and its slopes (per cell) along
/// these axes.
#[inline(always)]
pub(crate) fn outer<S: Scalar, const D: usize, const N: usize>(
    axes: &[Axis<S, N>; D],
    p: usize,
    (j, k): (usize, usize),
) -> (S, [S; D]) {
    let mut slope = [S::constant(0.0); D];
    if D == 1 {
        return (S::constant(1.0), slope);
    }
    let (value_y, slope_y) = (axes[1].value[j][p], axes[1].slope[j][p]);
    if D == 2 {
        slope[1] = slope_y;
        return (value_y, slope);
    }
    let (value_z, slope_z) = (axes[2].value[k][p], axes[2].slope[k][p]);
    slope[1] = slope_y * value_z;
    slope[2] = value_y * slope_z;
    (value_y * value_z, slope)
}

/// Nodes that a particle sees along an axis of `D`; one along an axis that there is not.
pub(crate) const fn nodes_along<F: ShapeFunction, const D: usize>(axis: usize) -> usize {
    if axis < D { F::NODES } else { 1 }
}

/// Nodes of a block from the first that a particle sees to the last.
pub(crate) const fn nodes_spanned<F: ShapeFunction, const D: usize>() -> usize {
    let edge = block_edge(D);
    let rows = (nodes_along::<F, D>(2) - 1) * edge + nodes_along::<F, D>(1) - 1;
    rows * edge + F::NODES
}

#[cfg(test)]
mod tests {
    use super::*;
    use perturbation_moments::Jet;

    fn axis<F: ShapeFunction, S: Scalar>(s: S, half: f64) -> (i32, Axis<S, 1>) {
        let (base, mut axis) = (F::base(s.value(), half), Axis::empty());
        F::along(s, S::constant(half), base, (&mut axis, 0));
        (base, axis)
    }

    fn laws<F: ShapeFunction>(name: &str, linear_exact: bool) {
        for step in 0..400 {
            let s = 0.01 * f64::from(step) - 1.7;
            let (half, delta) = (0.3, 1e-6);
            let (base, here) = axis::<F, f64>(s, half);
            let (mut sum, mut slopes, mut place) = (0.0, 0.0, 0.0);
            for (k, node) in (base..).take(F::NODES).enumerate() {
                sum += here.value[k][0];
                slopes += here.slope[k][0];
                place += here.value[k][0] * f64::from(node);
                assert!(here.value[k][0] > -1e-15, "{name}: negative at {s}");
            }
            assert!(
                (sum - 1.0).abs() < 1e-14 && slopes.abs() < 1e-13,
                "{name}: no partition at {s}"
            );
            if linear_exact {
                assert!(
                    (place - s).abs() < 1e-13,
                    "{name}: a linear field does not come back at {s}"
                );
            }
            let ((over, above), (under, below)) =
                (axis::<F, f64>(s + delta, half), axis::<F, f64>(s - delta, half));
            if over == base && under == base {
                for k in 0..F::NODES {
                    let slope = (above.value[k][0] - below.value[k][0]) / (2.0 * delta);
                    // The difference errs by its roundoff, 1e-10, and at a kink of the hat by delta.
                    assert!((slope - here.slope[k][0]).abs() < 1e-5, "{name}: slope {k} at {s}");
                }
            }
            let (_, jet) = axis::<F, Jet>(Jet::variable(s, 0), half);
            for k in 0..F::NODES {
                assert!(
                    (jet.value[k][0].first[0] - here.slope[k][0]).abs() < 1e-12,
                    "{name} at {s}"
                );
            }
        }
    }

    #[test]
    fn shape_functions_part_unity_reproduce_a_line_and_have_their_slopes() {
        laws::<Linear>("linear", true);
        laws::<Gimp>("GIMP", true);
        laws::<QuadraticBSpline>("quadratic B-spline", true);
        laws::<CubicBSpline>("cubic B-spline", true);
    }
}
