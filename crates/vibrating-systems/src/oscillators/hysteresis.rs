//! Hysteresis of a storey.

#![allow(clippy::inline_always, reason = "used in dispatched functions")]

use simd_lanes::power;

use crate::error::{Error, positive, within};

/// Hysteresis of a storey with the restoring force `k (alpha u + (1 - alpha) z)` at the drift `u`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hysteresis {
    /// A linear spring.
    None,
    /// The loop of Bouc and Wen, with `|z|` below the yield drift `x_y`:
    ///
    /// $$ \dot z = \dot u \left(1 - (\beta \mathrm{sign}(\dot u z) + 1 - \beta) |z/x_y|^n\right) . $$
    ///
    /// Source: Wen 1976, Method for random vibration of hysteretic systems.
    BoucWen {
        /// `alpha` from 0 to 1, stiffness after yielding over that before.
        post_yield_ratio: f64,
        /// `x_y > 0`, the yield drift.
        yield_drift: f64,
        /// `beta` from 0 to 1, which makes the loop wide; 0 has no hysteresis.
        beta: f64,
        /// `n > 0`, how sharply it yields.
        exponent: f64,
    },
    /// Elastic and perfectly plastic in parallel with a spring: `z' = u'` unless `|z| = x_y` and `u' z > 0`.
    Bilinear {
        /// `alpha` from 0 to 1, stiffness after yielding over that before.
        post_yield_ratio: f64,
        /// `x_y > 0`, the yield drift.
        yield_drift: f64,
    },
}

impl Hysteresis {
    pub(crate) fn check(&self) -> Result<(), Error> {
        if let Self::BoucWen { beta, exponent, .. } = *self {
            within("beta", beta, 0.0, 1.0)?;
            positive("exponent", exponent)?;
        }
        match *self {
            Self::None => Ok(()),
            Self::BoucWen { post_yield_ratio, yield_drift, .. }
            | Self::Bilinear { post_yield_ratio, yield_drift } => {
                within("post_yield_ratio", post_yield_ratio, 0.0, 1.0)?;
                positive("yield_drift", yield_drift)
            }
        }
    }

    /// `alpha`; 1 without hysteresis.
    #[inline(always)]
    pub(crate) fn post_yield_ratio(&self) -> f64 {
        match *self {
            Self::None => 1.0,
            Self::BoucWen { post_yield_ratio, .. } | Self::Bilinear { post_yield_ratio, .. } => {
                post_yield_ratio
            }
        }
    }

    /// Writes `z'` of `L` paths.
    #[inline(always)]
    pub(crate) fn rate<const L: usize>(&self, v: &[f64; L], z: &[f64; L], rate: &mut [f64; L]) {
        match *self {
            Self::None => *rate = *v,
            Self::BoucWen { yield_drift, beta, exponent, .. } => {
                let (inverse, gamma) = (1.0 / yield_drift, 1.0 - beta);
                let mut bend = z.map(|z| z.abs() * inverse);
                // Most loops have n = 1: no power for it, and the branch outside the loop over lanes.
                if exponent.to_bits() != 1.0_f64.to_bits() {
                    for bend in &mut bend {
                        *bend = power(*bend, exponent);
                    }
                }
                for lane in 0..L {
                    let sign = beta.copysign(v[lane] * z[lane]);
                    rate[lane] = v[lane] * (1.0 - (sign + gamma) * bend[lane]);
                }
            }
            Self::Bilinear { yield_drift, .. } => {
                for lane in 0..L {
                    let yields = z[lane].abs() >= yield_drift && v[lane] * z[lane] > 0.0;
                    rate[lane] = if yields { 0.0 } else { v[lane] };
                }
            }
        }
    }

    /// Returns `z` of `L` paths to the yield surface where a step has passed it.
    #[inline(always)]
    pub(crate) fn return_to_yield_surface<const L: usize>(&self, z: &mut [f64; L]) {
        if let Self::Bilinear { yield_drift, .. } = *self {
            for z in z {
                *z = if *z > yield_drift { yield_drift } else { *z };
                *z = if *z < -yield_drift { -yield_drift } else { *z };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_loops_are_elastic_at_first_and_level_at_the_yield_drift() {
        let bouc_wen = Hysteresis::BoucWen {
            post_yield_ratio: 0.1,
            yield_drift: 0.02,
            beta: 0.7,
            exponent: 2.0,
        };
        let bilinear = Hysteresis::Bilinear { post_yield_ratio: 0.1, yield_drift: 0.02 };
        for hysteresis in [bouc_wen, bilinear] {
            let mut rate = [0.0; 3];
            // At rest, loading at the yield drift, unloading there: 1 - (1 - 2 beta) = 2 beta for Bouc-Wen.
            hysteresis.rate(&[0.3, 0.3, -0.3], &[0.0, 0.02, 0.02], &mut rate);
            let unloading = if hysteresis == bouc_wen { -0.3 * 1.4 } else { -0.3 };
            for (found, expected) in rate.iter().zip([0.3, 0.0, unloading]) {
                assert!((found - expected).abs() < 1e-15, "{hysteresis:?}: {rate:?}");
            }
        }
        let mut z = [0.03, -0.025, 0.01];
        bilinear.return_to_yield_surface(&mut z);
        assert_eq!(z.map(f64::to_bits), [0.02_f64, -0.02, 0.01].map(f64::to_bits));
    }
}
