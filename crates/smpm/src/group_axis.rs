//! Shape functions of particles in lanes, with the operations of `shape.rs`: bitwise identical to them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched work is not compiled for its registers"
)]

use simd_lanes::Lanes;

use crate::shape::Shape;
use crate::tile_size::MOST_NODES;

/// Values and slopes (per cell) of a shape function along one axis, from the lowest node of the particles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroupAxis<V> {
    pub(crate) value: [V; MOST_NODES],
    pub(crate) slope: [V; MOST_NODES],
}

impl<V: Lanes<Number = f64>> GroupAxis<V> {
    /// Zeros, in as many lanes as a register has.
    #[inline(always)]
    pub(crate) fn none(register: V) -> Self {
        let zeros = [register.splat(0.0); MOST_NODES];
        Self { value: zeros, slope: zeros }
    }

    /// For particles at `s` with half lengths `half` (both in cells; only GIMP uses the second) and lowest node `lowest`, a whole
    /// number.
    #[inline(always)]
    pub(crate) fn of<const NODES: usize>(shape: Shape, (s, half): (V, V), lowest: V) -> Self {
        match NODES {
            2 => Self::hat(s - lowest),
            3 => Self::quadratic(s - lowest),
            _ if shape == Shape::Gimp => Self::gimp((s, half), lowest),
            _ => Self::cubic(s - (lowest + s.splat(1.0))),
        }
    }

    /// At `f` from 0 to 1 behind the lowest node.
    #[inline(always)]
    fn hat(f: V) -> Self {
        let (zero, one) = (f.splat(0.0), f.splat(1.0));
        Self { value: [one - f, f, zero, zero], slope: [f.splat(-1.0), one, zero, zero] }
    }

    /// At `f` from 1/2 to 3/2 behind the lowest node.
    #[inline(always)]
    fn quadratic(f: V) -> Self {
        let (zero, half, middle) = (f.splat(0.0), f.splat(0.5), f.splat(0.75));
        let (left, centre, right) = (f.splat(1.5) - f, f - f.splat(1.0), f - half);
        Self {
            value: [left * left * half, middle - centre * centre, right * right * half, zero],
            slope: [f - f.splat(1.5), centre * f.splat(-2.0), right, zero],
        }
    }

    /// At `f` from 0 to 1 behind the second node.
    #[inline(always)]
    fn cubic(f: V) -> Self {
        let (one, half, sixth) = (f.splat(1.0), f.splat(0.5), f.splat(1.0 / 6.0));
        let (two, three, four, six) = (f.splat(2.0), f.splat(3.0), f.splat(4.0), f.splat(6.0));
        let middle = f.splat(1.5);
        let rest = one - f;
        let (f2, r2) = (f * f, rest * rest);
        Self {
            value: [
                r2 * rest * sixth,
                (f2 * f * three - f2 * six + four) * sixth,
                (r2 * rest * three - r2 * six + four) * sixth,
                f2 * f * sixth,
            ],
            slope: [
                r2 * f.splat(-0.5),
                f2 * middle - f * two,
                f.splat(0.0) - (r2 * middle - rest * two),
                f2 * half,
            ],
        }
    }

    /// The hat averaged over the length of the particles.
    #[inline(always)]
    fn gimp((s, half): (V, V), lowest: V) -> Self {
        let (zero, one) = (s.splat(0.0), s.splat(1.0));
        let inverse = one / half * s.splat(0.5);
        let mut axis = Self { value: [zero; MOST_NODES], slope: [zero; MOST_NODES] };
        for k in 0..MOST_NODES {
            let d = s - (lowest + s.splat(k as f64));
            let (low, high) = (d - half, d + half);
            axis.value[k] = (hat_integral(high) - hat_integral(low)) * inverse;
            axis.slope[k] = (hat(high) - hat(low)) * inverse;
        }
        axis
    }
}

#[inline(always)]
fn hat<V: Lanes<Number = f64>>(u: V) -> V {
    (u.splat(1.0) - u.abs()).max(u.splat(0.0))
}

#[inline(always)]
fn hat_integral<V: Lanes<Number = f64>>(u: V) -> V {
    let rest = hat(u);
    let below = rest * rest * u.splat(0.5);
    V::select(u.less(u.splat(0.0)), below, u.splat(1.0) - below)
}
