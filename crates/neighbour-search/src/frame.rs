//! Error bounds of distances in single precision.

use crate::domain::{Domain, square};

/// Largest width in units of the reach for which single precision is used at all.
const WIDEST: f64 = 1_048_576.0;

/// Largest fraction of a radius that single precision may leave undecided before a local frame is used.
const UNDECIDED: f64 = 1e-3;

/// A box and the largest radius in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds<const D: usize> {
    pub(crate) low: [f64; D],
    pub(crate) high: [f64; D],
    pub(crate) radius: f64,
}

/// Origin and unit of the coordinates.
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

/// Origin and unit of the coordinates, and the resulting accuracy of distances in single precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame<const D: usize> {
    pub(crate) origin: [f64; D],
    pub(crate) scale: f64,
    /// A distance `ρ` is accurate to `fixed + RELATIVE ρ`, with `fixed` infinite if it is unknown...
    pub(crate) fixed: f64,
    /// ... where the squared distance of one of the two points from the origin is below this.
    covered: f32,
}

impl<const D: usize> Default for Frame<D> {
    /// The frame of an empty cloud.
    fn default() -> Self {
        Self { origin: [0.0; D], scale: 1.0, fixed: 0.0, covered: 0.0 }
    }
}

impl<const D: usize> Frame<D> {
    /// Relative error of a distance.
    const RELATIVE: f64 = (D as f64 + 4.0) / 8_388_608.0;

    /// The frame of a box that contains one point of every compared pair, in units of `reach`.
    ///
    /// Images along periodic axes are displaced by `displaced` of a period.
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

    /// Whether points of a box, in units of the frame, have the stated accuracy.
    #[inline(always)]
    pub(crate) fn covers(&self, (low, high, _): &([f32; D], [f32; D], f64)) -> bool {
        let mut sum = 0.0;
        for axis in 0..D {
            sum += (low[axis] * low[axis]).max(high[axis] * high[axis]);
        }
        sum <= self.covered && self.fixed.is_finite()
    }

    /// Whether only a small fraction of a radius is left undecided.
    pub(crate) fn resolves(&self, radius: f64) -> bool {
        self.fixed <= UNDECIDED * radius * self.scale
    }

    /// Computed distance from a box beyond which no point is within `radius` of a point in it.
    #[inline(always)]
    pub(crate) fn reach(&self, radius: f64) -> f32 {
        let [_, upper] = self.bounds(radius);
        // Once for the distance, and once for that of the box.
        upper + (upper - self.bounds(radius)[0])
    }

    /// Origin and scale of each axis, with all points displaced by `shift`.
    #[inline(always)]
    pub(crate) fn places(&self, shift: &[f64; D]) -> [Place; D] {
        core::array::from_fn(|axis| Place {
            shift: shift[axis],
            origin: self.origin[axis],
            scale: self.scale,
        })
    }

    /// Bounds on the computed distance.
    ///
    /// Below the first bound a point is certainly within `radius`; at or above the second it certainly is not.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "one rounding more, covered by the bounds")]
    pub(crate) fn bounds(&self, radius: f64) -> [f32; 2] {
        let radius = radius * self.scale;
        let a = self.fixed + Self::RELATIVE * radius;
        [(radius - a).max(0.0) as f32, (radius + a) as f32]
    }
}
