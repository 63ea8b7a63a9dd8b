//! Oscillators with known distributions.

use sde_integrators::{Additive, Sde};

/// `q'' + 2 xi w q' + w^2 q + c q^3 = W`, with `E[W W] = 2 S_0 delta`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Oscillator {
    pub(crate) frequency: f64,
    pub(crate) damping: f64,
    pub(crate) intensity: f64,
    pub(crate) cubic: f64,
}

impl Sde<2, 1> for Oscillator {
    type Noise = Additive;

    fn drift(&self, _: f64, &[q, v]: &[f64; 2]) -> [f64; 2] {
        let Self { frequency: w, damping: xi, cubic, .. } = *self;
        [v, -2.0 * xi * w * v - w * w * q - cubic * q * q * q]
    }

    fn noise(&self, _: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0], [(2.0 * self.intensity).sqrt()]]
    }
}

impl Oscillator {
    /// `exp(A t)` without the cubic term.
    pub(crate) fn transition(&self, t: f64) -> [[f64; 2]; 2] {
        let Self { frequency: w, damping: xi, .. } = *self;
        let damped = w * (1.0 - xi * xi).sqrt();
        let (decay, (sin, cos)) = ((-xi * w * t).exp(), (damped * t).sin_cos());
        let mixed = xi * w / damped * sin;
        [
            [decay * (cos + mixed), decay * sin / damped],
            [-decay * w * w / damped * sin, decay * (cos - mixed)],
        ]
    }

    /// The covariance at a time without the cubic term: `Phi (P_0 - P) Phi^T + P` with the stationary `P`.
    pub(crate) fn covariance(&self, start: [[f64; 2]; 2], t: f64) -> [[f64; 2]; 2] {
        let Self { frequency: w, damping: xi, intensity, .. } = *self;
        let of_v = intensity / (2.0 * xi * w);
        let (stationary, phi) = ([[of_v / (w * w), 0.0], [0.0, of_v]], self.transition(t));
        let mut covariance = stationary;
        for i in 0..2 {
            for j in 0..2 {
                for k in 0..2 {
                    for l in 0..2 {
                        covariance[i][j] +=
                            phi[i][k] * (start[k][l] - stationary[k][l]) * phi[j][l];
                    }
                }
            }
        }
        covariance
    }
}
