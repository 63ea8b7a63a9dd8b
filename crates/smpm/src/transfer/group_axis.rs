//! Shape functions of particles in lanes, with the operations of `shape.rs`: bitwise identical to them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched work is not compiled for its registers"
)]

use simd_lanes::Lanes;

use crate::grid::tile_size::MOST_NODES;

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

    /// For particles at `s` (in cells) with the lowest node `lowest`, a whole number.
    #[inline(always)]
    pub(crate) fn of<const NODES: usize>(s: V, lowest: V) -> Self {
        match NODES {
            3 => Self::quadratic(s - lowest),
            _ => Self::cubic(s - (lowest + s.splat(1.0))),
        }
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
}
