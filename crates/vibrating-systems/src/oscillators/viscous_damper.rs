//! The oscillator with a nonlinear viscous damper.

use sde_integrators::SecondOrder;
use simd_lanes::{exp, power};

use crate::error::{Error, not_negative, positive};
use crate::oscillators::first_order::first_order;
use crate::{LinearOscillator, LinearOscillatorParameters};

/// A structure with a nonlinear viscous damper.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "schema", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "schema", serde(deny_unknown_fields), schemars(rename = "DamperScene"))]
pub struct ViscousDamperParameters {
    /// The structure without the damper.
    pub structure: LinearOscillatorParameters,
    /// `eta >= 0`, the force of the damper over the mass (m/s^2 per (m/s)^alpha).
    pub damper_coefficient: f64,
    /// `alpha > 0`, the power of the velocity in that force (no unit).
    pub damper_exponent: f64,
}

/// A structure in its first mode with a nonlinear viscous damper (Canor & Denoël 2013, eq 26):
///
/// $$ \ddot q + 2 \xi \omega_0 \dot q + \eta  \mathrm{sign}(\dot q) |\dot q|^\alpha + \omega_0^2 q = a(t) W(t). $$
///
/// State `(q, q')`; `D_22 = S_0 a^2`, all other entries zero. For `alpha < 1` the drift is not Lipschitz at `q' = 0`.
#[derive(Debug, Clone, PartialEq)]
pub struct ViscousDamper {
    structure: LinearOscillator,
    damper_coefficient: f64,
    damper_exponent: f64,
}

impl ViscousDamper {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::Negative`] for the coefficient, [`Error::NotPositive`] for the exponent, [`Error::NotFinite`], and those of
    /// [`LinearOscillator::new`].
    pub fn new(parameters: ViscousDamperParameters) -> Result<Self, Error> {
        let ViscousDamperParameters { structure, damper_coefficient, damper_exponent } = parameters;
        let structure = LinearOscillator::new(structure)?;
        not_negative("damper_coefficient", damper_coefficient)?;
        positive("damper_exponent", damper_exponent)?;
        Ok(Self { structure, damper_coefficient, damper_exponent })
    }

    /// The structure without its damper.
    pub fn structure(&self) -> &LinearOscillator {
        &self.structure
    }

    /// `2 pi / omega_0`, the natural period (time).
    pub fn period(&self) -> f64 {
        self.structure.period()
    }
}

first_order!(ViscousDamper);

impl SecondOrder<1, 1> for ViscousDamper {
    #[inline]
    fn natural_frequency(&self) -> [f64; 1] {
        SecondOrder::natural_frequency(&self.structure)
    }

    #[inline]
    fn linear_damping(&self) -> [f64; 1] {
        self.structure.linear_damping()
    }

    #[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
    #[inline(always)]
    fn remaining_acceleration(&self, _: f64, _: &[f64; 1], &[v]: &[f64; 1]) -> [f64; 1] {
        [-damper_force(self.damper_coefficient, self.damper_exponent, v)]
    }

    /// `|v|^(1 - alpha)` falls at the constant rate `eta (1 - alpha)` until it is zero, and stays there; at
    /// `alpha = 1` the flow is `v exp(-eta dt)`.
    #[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
    #[inline(always)]
    fn remaining_flow(&self, _: f64, dt: f64, _: &[f64; 1], [v]: &mut [f64; 1]) {
        let (eta, beta) = (self.damper_coefficient, 1.0 - self.damper_exponent);
        if beta.abs() < 1e-12 {
            *v *= exp(-eta * dt);
            return;
        }
        let left = power(v.abs(), beta) - eta * beta * dt;
        // For alpha < 1 the damper brings the mass to rest in finite time. What is not a number stays that.
        let left = if left < 0.0 { 0.0 } else { left };
        *v = power(left, 1.0 / beta).copysign(*v);
    }

    #[inline]
    fn noise_intensity(&self, t: f64) -> [[f64; 1]; 1] {
        SecondOrder::noise_intensity(&self.structure, t)
    }
}

/// `eta sign(v) |v|^alpha`.
#[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
#[inline(always)]
pub(crate) fn damper_force(coefficient: f64, exponent: f64, v: f64) -> f64 {
    coefficient * power(v.abs(), exponent).copysign(v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Window;
    use sde_integrators::Sde;

    fn damper(damper_exponent: f64) -> ViscousDamper {
        let structure = LinearOscillatorParameters {
            natural_frequency: std::f64::consts::PI,
            damping_ratio: 0.01,
            noise_intensity: 0.2,
            window: Window::CANOR_DENOEL_2013,
        };
        ViscousDamper::new(ViscousDamperParameters {
            structure,
            damper_coefficient: 0.25,
            damper_exponent,
        })
        .unwrap()
    }

    #[test]
    fn the_flow_of_the_damper_solves_its_equation() {
        for exponent in [0.35, 0.7, 1.0, 1.8] {
            let system = damper(exponent);
            let flow = |v: f64, dt: f64| {
                let mut v = [v];
                system.remaining_flow(0.0, dt, &[0.0], &mut v);
                v[0]
            };
            for v in [-0.9, 0.4] {
                // Central difference of the flow at dt = 0, error O(eps^2) with third derivatives of order 10.
                let eps = 1e-5;
                let rate = (flow(v, eps) - flow(v, -eps)) / (2.0 * eps);
                let [expected] = system.remaining_acceleration(0.0, &[0.0], &[v]);
                assert!(
                    (rate - expected).abs() < 1e-8,
                    "exponent {exponent}, v {v}: {rate} against {expected}"
                );
                assert!(
                    (flow(flow(v, 0.1), 0.2) - flow(v, 0.3)).abs() < 1e-14,
                    "the flow is a semigroup"
                );
            }
        }
    }

    #[test]
    fn a_damper_below_one_stops_the_mass_in_finite_time() {
        let mut v = [0.01];
        damper(0.35).remaining_flow(0.0, 1.0, &[0.0], &mut v);
        assert!(v[0].abs() < f64::MIN_POSITIVE, "left with {}", v[0]);
    }

    #[test]
    fn the_diffusion_is_the_intensity_times_the_window_squared() {
        let d = damper(0.35).diffusion(1.0, &[0.0, 0.0]);
        assert!((d[1][1] - 0.2 * 0.25).abs() < 1e-16 && d[0][0].abs() + d[0][1].abs() < 1e-300);
    }
}
