//! Residual velocity over impact velocity.

use serde::Serialize;

/// A fit of residual velocities.
///
/// $$ v_r = a \, (v^p - v_l^p)^{1/p} $$
///
/// for the impact velocity $v$ above the ballistic limit $v_l$, by least squares.
///
/// Source: Recht and Ipson 1963, Ballistic perforation dynamics (`p = 2`); Lambert and Jonas 1976 (any `p`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct ResidualVelocity {
    /// Ballistic limit $v_l$ (velocity).
    pub(super) limit: f64,
    /// $a$ (no unit).
    pub(super) factor: f64,
    /// $p$ (no unit).
    pub(super) exponent: f64,
    /// Root mean square of what the fit leaves of the residual velocities (velocity).
    pub(super) deviation: f64,
}

/// Fewest points of three constants and a deviation.
const FEWEST_POINTS: usize = 5;
/// Points along each constant of a search, and how often it is narrowed.
const POINTS: usize = 24;
const NARROWINGS: usize = 12;
/// Range of the exponent.
const EXPONENTS: [f64; 2] = [1.0, 8.0];

impl ResidualVelocity {
    /// The fit of points (impact velocity, residual velocity), both positive; `None` for fewer than five, and where they do not
    /// determine it: an exponent at an end of its range, or residual velocities that outgrow the impact's.
    pub(super) fn fit(points: &[(f64, f64)]) -> Option<Self> {
        if points.len() < FEWEST_POINTS {
            return None;
        }
        let slowest = points.iter().map(|&(v, _)| v).fold(f64::INFINITY, f64::min);
        let (mut limits, mut exponents) = ([0.5 * slowest, slowest], EXPONENTS);
        let mut best: Option<Self> = None;
        for _ in 0..NARROWINGS {
            let along = |[low, high]: [f64; 2], k: usize| {
                low + (high - low) * k as f64 / (POINTS - 1) as f64
            };
            for k in 0..POINTS * POINTS {
                let (limit, exponent) = (along(limits, k % POINTS), along(exponents, k / POINTS));
                let fit = Self::of(points, limit, exponent);
                if best.is_none_or(|best| fit.deviation < best.deviation) {
                    best = Some(fit);
                }
            }
            let near = |[low, high]: [f64; 2], at: f64| {
                let half = 0.25 * (high - low);
                let from = (at - half).clamp(low, high - 2.0 * half);
                [from, from + 2.0 * half]
            };
            let found = best?;
            (limits, exponents) = (near(limits, found.limit), near(exponents, found.exponent));
        }
        let is_inside = |p: f64| p > 1.01 * EXPONENTS[0] && p < 0.99 * EXPONENTS[1];
        best.filter(|fit| is_inside(fit.exponent) && fit.factor <= 1.0)
    }

    /// The fit with a limit and an exponent.
    fn of(points: &[(f64, f64)], limit: f64, exponent: f64) -> Self {
        let one = Self { limit, factor: 1.0, exponent, deviation: 0.0 };
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            points.iter().map(|&(v, residual)| of(one.at(v), residual)).sum()
        };
        let factor = sum(&|g, residual| g * residual) / sum(&|g, _| g * g).max(f64::MIN_POSITIVE);
        let squares = sum(&|g, residual| (residual - factor * g).powi(2));
        Self { factor, deviation: (squares / points.len() as f64).sqrt(), ..one }
    }

    /// The residual velocity at an impact velocity; zero below the limit.
    pub(super) fn at(&self, v: f64) -> f64 {
        let Self { limit, factor, exponent: p, .. } = *self;
        factor * (v.powf(p) - limit.powf(p)).max(0.0).powf(1.0 / p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_of_a_curve_are_found_from_its_points() {
        let curve = ResidualVelocity { limit: 184.5, factor: 0.79, exponent: 2.4, deviation: 0.0 };
        let points: Vec<(f64, f64)> =
            [190.0, 200.0, 225.0, 250.0, 285.0, 304.0, 399.0].map(|v| (v, curve.at(v))).into();
        let fit = ResidualVelocity::fit(&points).unwrap();
        assert!((fit.limit - 184.5).abs() < 0.2, "{fit:?}");
        assert!((fit.factor - 0.79).abs() < 0.01 && (fit.exponent - 2.4).abs() < 0.05, "{fit:?}");
        assert!(ResidualVelocity::fit(&points[..4]).is_none());
        // A line through the limit is no such curve.
        let line: Vec<(f64, f64)> = points.iter().map(|&(v, _)| (v, v - 180.0)).collect();
        assert!(ResidualVelocity::fit(&line).is_none());
    }
}
