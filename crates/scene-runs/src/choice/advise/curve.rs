//! Error and cost of a method over its size, extrapolated to the size that a tolerance requires.

use result_figures::settled;

use crate::ladder::Growth;

/// Error and cost over size.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Expected orders of error and cost.
    pub growth: Growth,
    /// Trials, by increasing size.
    pub points: Vec<Point>,
}

/// One trial. Its error is `own + excess`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// The size.
    pub size: f64,
    /// CPU time (s).
    pub cost: f64,
    /// Error estimate of the run, over the scale of the quantity.
    pub own: f64,
    /// Deviation from other trials beyond that estimate, over the scale of the quantity.
    pub excess: f64,
}

/// Size that a tolerance requires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needed {
    /// The size.
    pub size: f64,
    /// Expected CPU time (s).
    pub cost: f64,
    /// Ratio to the largest size tried; above 1 the size is extrapolated.
    pub beyond: f64,
}

/// Why the trials of a method do not reach a tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unreached {
    /// No trial has a result.
    NoAnswer,
    /// The error does not decrease.
    NotFalling {
        /// The error at the largest size, over the scale of the quantity.
        error: f64,
    },
    /// The error decreases, but the required size is too far from the trials.
    TooFar {
        /// The error at the largest size, over the scale of the quantity.
        error: f64,
    },
}

/// Observed order below which an error does not count as decreasing.
const LEAST_ORDER: f64 = 0.5;
/// Largest extrapolation of a lattice, as a ratio along a length.
///
/// An order observed over a factor of two or three supports an extrapolation by about the same factor.
const FARTHEST_LATTICE: f64 = 4.0;
/// The same for samples, whose error decreases with the square root.
const FARTHEST_SAMPLES: f64 = 1e6;
/// CPU time below which clock resolution and start-up dominate (s).
const TIMED: f64 = 0.02;

impl Point {
    /// Total error over the scale of the quantity.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.own + self.excess
    }
}

impl Curve {
    /// Smallest size, and its cost, at which the error is within a tolerance.
    ///
    /// # Errors
    /// [`Unreached`].
    pub fn needed(&self, tolerance: f64) -> Result<Needed, Unreached> {
        let last = *self.points.last().ok_or(Unreached::NoAnswer)?;
        let is_within = |point: &Point| point.error() <= tolerance;
        let size = match settled(&self.points, |point| point.size, is_within) {
            Some(point) => self.between(*point, tolerance),
            None => self.beyond(last, tolerance)?,
        };
        Ok(Needed { size, cost: self.cost(size), beyond: size / last.size })
    }

    /// Interpolates between the last insufficient size and the first sufficient one.
    fn between(&self, enough: Point, tolerance: f64) -> f64 {
        let below = self.points.iter().rev().find(|point| point.size < enough.size);
        let Some(below) = below else { return enough.size };
        let (from, to) = (below.error(), enough.error());
        if to <= 0.0 || from <= tolerance {
            return enough.size;
        }
        // Linear interpolation on two logarithmic axes.
        let part = (from / tolerance).ln() / (from / to).ln();
        below.size * (enough.size / below.size).powf(part)
    }

    fn beyond(&self, last: Point, tolerance: f64) -> Result<f64, Unreached> {
        let error = last.error();
        let (factor, farthest) = match self.growth {
            Growth::Samples => {
                // More samples reduce only the random error.
                let left = tolerance - last.excess;
                if left <= 0.0 {
                    return Err(Unreached::NotFalling { error });
                }
                ((last.own / left).powf(1.0 / self.growth.order()), FARTHEST_SAMPLES)
            }
            Growth::Fixed => return Err(Unreached::NotFalling { error }),
            Growth::Lattice { .. } => {
                let order = self.order();
                if order < LEAST_ORDER {
                    return Err(Unreached::NotFalling { error });
                }
                ((error / tolerance).powf(1.0 / order), FARTHEST_LATTICE)
            }
        };
        if factor > farthest { Err(Unreached::TooFar { error }) } else { Ok(last.size * factor) }
    }

    /// Order over the last three trials, at most the order of the method.
    fn order(&self) -> f64 {
        let highest = self.growth.order();
        let recent = &self.points[self.points.len().saturating_sub(3)..];
        let [first, .., last] = recent else { return highest };
        let order = (first.error() / last.error()).ln() / (last.size / first.size).ln();
        if order.is_finite() { order.min(highest) } else { highest }
    }

    /// Power law through the two nearest trials, where their measured times differ.
    fn cost(&self, size: f64) -> f64 {
        let above = self.points.iter().position(|point| point.size >= size);
        let k = above.unwrap_or(self.points.len() - 1);
        let near = self.points[k];
        let measured = k
            .checked_sub(1)
            .map(|before| self.points[before])
            .map(|before| (near.cost / before.cost).ln() / (near.size / before.size).ln());
        let expected = self.growth.cost_exponent();
        let is_timed = k > 0 && self.points[k - 1].cost > TIMED;
        let exponent = match measured {
            // One order more for the time steps, which a finer lattice may also require.
            Some(measured) if is_timed => measured.clamp(0.5 * expected, expected + 1.0),
            _ => expected,
        };
        near.cost * (size / near.size).powf(exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(growth: Growth, points: &[(f64, f64, f64, f64)]) -> Curve {
        let point = |&(size, cost, own, excess)| Point { size, cost, own, excess };
        Curve { growth, points: points.iter().map(point).collect() }
    }

    const LATTICE: Growth = Growth::Lattice { dimensions: 2 };

    #[test]
    fn a_lattice_is_carried_on_by_the_order_and_the_cost_that_were_seen() {
        let seen = curve(LATTICE, &[(10.0, 1.0, 0.16, 0.0), (20.0, 6.0, 0.04, 0.0)]);
        let needed = seen.needed(0.01).unwrap();
        assert!((needed.size - 40.0).abs() < 1e-9 && (needed.cost - 36.0).abs() < 1e-9);
        assert!((needed.beyond - 2.0).abs() < 1e-12);
        let between = seen.needed(0.08).unwrap();
        assert!((between.size - 200f64.sqrt()).abs() < 1e-9);
        assert!((between.cost - 6f64.sqrt()).abs() < 1e-9);
        assert!(seen.needed(0.5).is_ok_and(|needed| (needed.size - 10.0).abs() < 1e-12));
        assert!(matches!(seen.needed(1e-4), Err(Unreached::TooFar { .. })));
    }

    #[test]
    fn an_error_that_does_not_fall_is_said_so() {
        let seen = curve(LATTICE, &[(10.0, 1.0, 0.05, 0.0), (20.0, 4.0, 0.01, 0.038)]);
        assert!(matches!(seen.needed(0.01), Err(Unreached::NotFalling { .. })));
        let biased = curve(Growth::Samples, &[(1e4, 1.0, 0.02, 0.03)]);
        assert!(matches!(biased.needed(0.01), Err(Unreached::NotFalling { .. })));
        assert!(biased.needed(0.04).is_ok());
        assert_eq!(curve(LATTICE, &[]).needed(0.1), Err(Unreached::NoAnswer));
    }

    #[test]
    fn samples_fall_with_their_root_and_cost_by_number() {
        let seen = curve(Growth::Samples, &[(1e3, 0.1, 0.06, 0.0), (3e3, 0.3, 0.04, 0.0)]);
        let needed = seen.needed(0.004).unwrap();
        assert!((needed.size - 3e5).abs() < 1e-3 && (needed.cost - 30.0).abs() < 1e-6);
    }
}
