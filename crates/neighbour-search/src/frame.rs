//! What single precision knows of a distance.

use crate::domain::{Domain, square};

/// Widest that anything may be in units of the reach, to be compared in single precision at all.
const WIDEST: f64 = 1_048_576.0;

/// Largest part of a radius that single precision may leave undecided before it is worth counting from a nearer place.
const UNDECIDED: f64 = 1e-3;

/// A box and the largest radius in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds<const D: usize> {
    pub(crate) low: [f64; D],
    pub(crate) high: [f64; D],
    pub(crate) radius: f64,
}

/// Where coordinates are counted from and in which unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) shift: f64,
    pub(crate) origin: f64,
    pub(crate) scale: f64,
}

impl Place {
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "single precision is what is asked for")]
    pub(crate) fn of(self, value: f64) -> f32 {
        (((value + self.shift) - self.origin) * self.scale) as f32
    }
}

/// Where coordinates are counted from, in which unit, and how well single precision knows a distance then.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame<const D: usize> {
    pub(crate) origin: [f64; D],
    pub(crate) scale: f64,
    /// A distance `ρ` is known to `fixed + RELATIVE ρ`, infinite if it is not known at all...
    pub(crate) fixed: f64,
    /// ... where the square of the distance of one of both points from the origin is below this.
    covered: f32,
}

impl<const D: usize> Default for Frame<D> {
    /// That of no points.
    fn default() -> Self {
        Self { origin: [0.0; D], scale: 1.0, fixed: 0.0, covered: 0.0 }
    }
}

impl<const D: usize> Frame<D> {
    /// Part of a distance that is not known, whatever the distance.
    const RELATIVE: f64 = (D as f64 + 4.0) / 8_388_608.0;

    /// The frame of a box that contains one of any two points that are compared, in units of `reach`; of a period it knows
    /// the part `displaced`.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a square that overflows covers everything"
    )]
    pub(crate) fn new(bounds: &Bounds<D>, reach: f64, domain: &Domain<D>, displaced: f64) -> Self {
        let scale = 1.0 / reach;
        let origin = core::array::from_fn(|axis| 0.5 * bounds.low[axis] + 0.5 * bounds.high[axis]);
        let half: [f64; D] = core::array::from_fn(|axis| {
            (bounds.high[axis] - origin[axis]).max(origin[axis] - bounds.low[axis]) * scale
        });
        let widest = square(&half).sqrt();
        let periods: f64 = domain.periods().iter().flatten().map(|period| period * scale).sum();
        let fixed = 2.0_f64.powi(-22) * (widest + 2.0) + displaced * periods + 2.0_f64.powi(-60);
        let fixed = if widest <= WIDEST { fixed } else { f64::INFINITY };
        Self { origin, scale, fixed, covered: ((widest + 1.0) * (widest + 1.0)) as f32 }
    }

    /// Whether points of a box, in units of the frame, are known as well as it says.
    #[inline(always)]
    pub(crate) fn covers(&self, (low, high, _): &([f32; D], [f32; D], f64)) -> bool {
        let mut sum = 0.0;
        for axis in 0..D {
            sum += (low[axis] * low[axis]).max(high[axis] * high[axis]);
        }
        sum <= self.covered && self.fixed.is_finite()
    }

    /// Whether little of a radius is left undecided.
    pub(crate) fn resolves(&self, radius: f64) -> bool {
        self.fixed <= UNDECIDED * radius * self.scale
    }

    /// Beyond this computed distance from a box nothing is within `radius` of a point in it.
    #[inline(always)]
    pub(crate) fn reach(&self, radius: f64) -> f32 {
        let [_, upper] = self.bounds(radius);
        // Once for the distance, and once more for that of the box.
        upper + (upper - self.bounds(radius)[0])
    }

    /// How each axis is placed, everything being displaced by `shift`.
    #[inline(always)]
    pub(crate) fn places(&self, shift: &[f64; D]) -> [Place; D] {
        core::array::from_fn(|axis| Place {
            shift: shift[axis],
            origin: self.origin[axis],
            scale: self.scale,
        })
    }

    /// Bounds on the computed distance: below the first, a point is surely within `radius`; not below the second, surely
    /// not.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "one rounding more, covered by the bounds")]
    pub(crate) fn bounds(&self, radius: f64) -> [f32; 2] {
        let radius = radius * self.scale;
        let a = self.fixed + Self::RELATIVE * radius;
        [(radius - a).max(0.0) as f32, (radius + a) as f32]
    }
}
