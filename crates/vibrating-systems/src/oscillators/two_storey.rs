//! A building of two storeys.

use sde_integrators::{Additive, Sde};

use crate::Window;
use crate::error::{Error, not_negative, positive};
use crate::oscillators::viscous_damper::damper_force;

/// A building of two storeys; lists are ordered from the lower storey.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "schema", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "schema", serde(deny_unknown_fields), schemars(rename = "TwoStoreyScene"))]
pub struct TwoStoreyParameters {
    /// `m_1, m_2 > 0`, the masses of the floors (kg).
    pub mass: [f64; 2],
    /// `k_1, k_2 > 0`, the stiffness of the storeys (N/m).
    pub stiffness: [f64; 2],
    /// `c_1, c_2 >= 0`, the damping of the storeys (N s/m).
    pub damping: [f64; 2],
    /// `eta_1, eta_2 >= 0`, the dampers in the storeys, 0 for none (N per (m/s)^alpha).
    pub damper_coefficient: [f64; 2],
    /// `alpha > 0`, the power of the velocity in their force (no unit).
    pub damper_exponent: f64,
    /// `S_0 >= 0`, intensity of the white noise, `E[W(t) W(t + tau)] = 2 S_0 delta(tau)` (m^2/s^3): `pi` times a two-sided spectral
    /// density per rad/s, a quarter of a one-sided one per Hz.
    pub noise_intensity: f64,
    /// `a(t)`, the modulating function of the noise.
    pub window: Window,
}

/// A shear frame of two storeys, with the floors' displacements `q_k` relative to the ground, the drifts
/// `d_1 = q_1`, `d_2 = q_2 - q_1` and the storey forces `f_k`:
///
/// $$ f_k = k_k d_k + c_k \dot d_k + \eta_k \mathrm{sign}(\dot d_k) |\dot d_k|^\alpha, \qquad
///    m_1 \ddot q_1 + f_1 - f_2 = m_1 a(t) W(t), \qquad m_2 \ddot q_2 + f_2 = m_2 a(t) W(t) . $$
///
/// State `(q_1, q_2, q_1', q_2')`; the ground acceleration acts on both floors alike, so that the diffusion of the two
/// velocities is `S_0 a^2` in all four entries, of rank one.
///
/// Source: Chopra 2012, Dynamics of structures, section 9.1.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoStorey {
    parameters: TwoStoreyParameters,
}

impl TwoStorey {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for masses, stiffness and exponent, [`Error::Negative`] for dampers and noise,
    /// [`Error::NotFinite`], and those of [`Window::check`].
    pub fn new(parameters: TwoStoreyParameters) -> Result<Self, Error> {
        for storey in 0..2 {
            positive("mass", parameters.mass[storey])?;
            positive("stiffness", parameters.stiffness[storey])?;
            not_negative("damping", parameters.damping[storey])?;
            not_negative("damper_coefficient", parameters.damper_coefficient[storey])?;
        }
        positive("damper_exponent", parameters.damper_exponent)?;
        not_negative("noise_intensity", parameters.noise_intensity)?;
        parameters.window.check()?;
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> &TwoStoreyParameters {
        &self.parameters
    }

    /// The circular frequencies of the undamped frame, the lower one first: the roots of `det(K - omega^2 M) = 0`.
    pub fn natural_frequencies(&self) -> [f64; 2] {
        let TwoStoreyParameters { mass: [m_1, m_2], stiffness: [k_1, k_2], .. } = self.parameters;
        let half_sum = 0.5 * ((k_1 + k_2) / m_1 + k_2 / m_2);
        let product = k_1 * k_2 / (m_1 * m_2);
        let larger = half_sum + (half_sum * half_sum - product).sqrt();
        // The smaller root by the product of both: the difference would cancel.
        [(product / larger).sqrt(), larger.sqrt()]
    }
}

impl Sde<4, 1> for TwoStorey {
    type Noise = Additive;

    #[inline]
    fn drift(&self, _: f64, &[q_1, q_2, v_1, v_2]: &[f64; 4]) -> [f64; 4] {
        let TwoStoreyParameters {
            mass,
            stiffness,
            damping,
            damper_coefficient,
            damper_exponent,
            ..
        } = &self.parameters;
        let (drift, rate) = ([q_1, q_2 - q_1], [v_1, v_2 - v_1]);
        let force: [f64; 2] = std::array::from_fn(|k| {
            let damper = damper_force(damper_coefficient[k], *damper_exponent, rate[k]);
            stiffness[k] * drift[k] + damping[k] * rate[k] + damper
        });
        [v_1, v_2, (force[1] - force[0]) / mass[0], -force[1] / mass[1]]
    }

    #[inline]
    fn noise(&self, t: f64, _: &[f64; 4]) -> [[f64; 1]; 4] {
        let TwoStoreyParameters { noise_intensity, window, .. } = &self.parameters;
        let amplitude = window.noise_amplitude(t, *noise_intensity);
        [[0.0], [0.0], [amplitude], [amplitude]]
    }

    /// That of the frame without its dampers.
    #[inline]
    fn linear_part(&self) -> Option<[[f64; 4]; 4]> {
        let TwoStoreyParameters { mass: [m_1, m_2], stiffness: k, damping: c, .. } =
            self.parameters;
        Some([
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-(k[0] + k[1]) / m_1, k[1] / m_1, -(c[0] + c[1]) / m_1, c[1] / m_1],
            [k[1] / m_2, -k[1] / m_2, c[1] / m_2, -c[1] / m_2],
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> TwoStoreyParameters {
        TwoStoreyParameters {
            mass: [1.0, 1.0],
            stiffness: [10.0, 10.0],
            damping: [0.0, 0.0],
            damper_coefficient: [0.0, 0.0],
            damper_exponent: 1.0,
            noise_intensity: 0.2,
            window: Window::Stationary,
        }
    }

    #[test]
    fn the_frequencies_of_equal_storeys_are_those_of_the_textbook() {
        // omega^2 m/k = (3 -+ sqrt 5)/2.
        let [low, high] = TwoStorey::new(frame()).unwrap().natural_frequencies();
        let root = 5.0_f64.sqrt();
        assert!((low * low - 5.0 * (3.0 - root)).abs() < 1e-13, "{low}");
        assert!((high * high - 5.0 * (3.0 + root)).abs() < 1e-13, "{high}");
    }

    #[test]
    fn a_mode_swings_alone() {
        // In the first mode q_2/q_1 = (1 + sqrt 5)/2 and both accelerations are -omega^2 q.
        let parameters =
            TwoStoreyParameters { mass: [2.0, 2.0], stiffness: [30.0, 30.0], ..frame() };
        let system = TwoStorey::new(parameters).unwrap();
        let (golden, [w, _]) = (0.5 * (1.0 + 5.0_f64.sqrt()), system.natural_frequencies());
        let [_, _, a_1, a_2] = system.drift(0.0, &[0.1, 0.1 * golden, 0.0, 0.0]);
        assert!((a_1 + w * w * 0.1).abs() < 1e-13 && (a_2 + w * w * 0.1 * golden).abs() < 1e-13);
    }

    #[test]
    fn forces_within_the_frame_cancel_and_dampers_take_energy() {
        let parameters = TwoStoreyParameters {
            mass: [1.5, 0.8],
            stiffness: [10.0, 6.0],
            damping: [0.3, 0.2],
            damper_coefficient: [0.4, 0.7],
            damper_exponent: 0.35,
            ..frame()
        };
        let system = TwoStorey::new(parameters).unwrap();
        // Momentum changes by the lowest storey's force alone.
        let x = [0.02, 0.05, 0.3, -0.4];
        let [_, _, a_1, a_2] = system.drift(0.0, &x);
        let base = 10.0 * 0.02 + 0.3 * 0.3 + 0.4 * 0.3_f64.powf(0.35);
        assert!((1.5 * a_1 + 0.8 * a_2 + base).abs() < 1e-13);
        // Power at zero displacement: the dissipation of the storeys.
        let [_, _, a_1, a_2] = system.drift(0.0, &[0.0, 0.0, 0.3, -0.4]);
        let power = 1.5 * a_1 * 0.3 - 0.8 * a_2 * 0.4;
        let loss = 0.3 * 0.09 + 0.2 * 0.49 + 0.4 * 0.3_f64.powf(1.35) + 0.7 * 0.7_f64.powf(1.35);
        assert!((power + loss).abs() < 1e-13);
    }

    #[test]
    fn the_diffusion_has_rank_one() {
        let d = TwoStorey::new(frame()).unwrap().diffusion(0.0, &[0.0; 4]);
        for (i, j) in [(2, 2), (2, 3), (3, 2), (3, 3)] {
            assert!((d[i][j] - 0.2).abs() < 1e-15);
        }
    }

    #[test]
    fn a_storey_without_stiffness_is_refused() {
        let parameters = TwoStoreyParameters { stiffness: [10.0, 0.0], ..frame() };
        assert!(matches!(
            TwoStorey::new(parameters),
            Err(Error::NotPositive { name: "stiffness", .. })
        ));
    }
}
