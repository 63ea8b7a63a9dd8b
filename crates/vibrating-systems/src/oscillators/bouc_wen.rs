//! The hysteretic oscillator of Bouc and Wen.

use sde_integrators::{
    Additive, Increment, Integrator, LinearFlows, Sde, SecondOrder, StepError, StrangOscillator,
};
use simd_lanes::power;

use crate::Window;
use crate::error::{Error, finite, not_negative, positive, within};

/// A hysteretic oscillator.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "schema", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "schema", serde(deny_unknown_fields), schemars(rename = "BoucWenScene"))]
pub struct BoucWenParameters {
    /// `omega_0 > 0`, the natural circular frequency before yielding (rad/s).
    pub natural_frequency: f64,
    /// `xi >= 0`, the damping over the critical one (no unit).
    pub damping_ratio: f64,
    /// `alpha`, the share of the linear stiffness, from 0 to 1 (no unit).
    pub hardening: f64,
    /// `A > 0`, the slope of `z` over `q` at `z = 0` (no unit).
    pub initial_slope: f64,
    /// `beta >= 0`, which widens the loop (1/m^n).
    pub beta: f64,
    /// `gamma > -beta`, which shapes the loop (1/m^n).
    pub gamma: f64,
    /// `n > 0`, the sharpness of yielding (no unit).
    pub exponent: f64,
    /// `S_0 >= 0`, intensity of the white noise, `E[W(t) W(t + tau)] = 2 S_0 delta(tau)` (m^2/s^3): `pi` times a two-sided spectral
    /// density per rad/s, a quarter of a one-sided one per Hz.
    pub noise_intensity: f64,
    /// `a(t)`, the modulating function of the noise.
    pub window: Window,
}

impl BoucWenParameters {
    /// The oscillator of Canor & Denoël 2013, section 4.2.
    pub const CANOR_DENOEL_2013: Self = Self {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.05,
        hardening: 0.5,
        initial_slope: 1.0,
        beta: 0.5,
        gamma: 0.5,
        exponent: 1.0,
        noise_intensity: 1.0,
        window: Window::CANOR_DENOEL_2013_HYSTERETIC,
    };
}

/// The Bouc-Wen oscillator (Canor & Denoël 2013, eq 28):
///
/// $$ \ddot q + 2\xi\omega_0\dot q + \omega_0^2(\alpha q + (1 - \alpha) z) = a(t) W(t), $$
/// $$ \dot z = \dot q \left(A - (\beta \mathrm{sign}(\dot q z) + \gamma) |z|^n\right) . $$
///
/// State `(q, q', z)`; `D_22 = S_0 a^2`, all other entries zero. For `beta >= 0` and `beta + gamma > 0` no path that
/// starts within `|z| <=` [`z_limit`](Self::z_limit) leaves it; the paper's limit `A` is that of its own parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct BoucWen {
    parameters: BoucWenParameters,
}

impl BoucWen {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the frequency, the initial slope and the exponent; [`Error::Negative`] for damping, `beta` and
    /// noise; [`Error::OutOfRange`] for the hardening; [`Error::OutOfOrder`] where `gamma` does not exceed `-beta`;
    /// [`Error::NotFinite`], and those of [`Window::check`].
    pub fn new(parameters: BoucWenParameters) -> Result<Self, Error> {
        let p = &parameters;
        positive("natural_frequency", p.natural_frequency)?;
        not_negative("damping_ratio", p.damping_ratio)?;
        within("hardening", p.hardening, 0.0, 1.0)?;
        positive("initial_slope", p.initial_slope)?;
        not_negative("beta", p.beta)?;
        finite("gamma", p.gamma)?;
        if p.gamma <= -p.beta {
            let (name, other) = ("gamma", "-beta");
            return Err(Error::OutOfOrder { name, value: p.gamma, other, limit: -p.beta });
        }
        positive("exponent", p.exponent)?;
        not_negative("noise_intensity", p.noise_intensity)?;
        p.window.check()?;
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> &BoucWenParameters {
        &self.parameters
    }

    /// `2 pi / omega_0`, the natural period before yielding, for `A = 1` (time).
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.parameters.natural_frequency
    }

    /// `(A / (beta + gamma))^(1/n)`, where the loop is level: `|z|` stays below.
    pub fn z_limit(&self) -> f64 {
        let BoucWenParameters { initial_slope, beta, gamma, exponent, .. } = self.parameters;
        (initial_slope / (beta + gamma)).powf(1.0 / exponent)
    }

    /// `dz/dq` on the branch of the loop on which `q'` has the sign of `v`.
    #[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
    #[inline(always)]
    fn slope(&self, v: f64, z: f64) -> f64 {
        let BoucWenParameters { initial_slope, beta, gamma, exponent, .. } = self.parameters;
        // Most loops have n = 1: no power for it.
        let bend = if exponent.to_bits() == 1.0_f64.to_bits() {
            z.abs()
        } else {
            power(z.abs(), exponent)
        };
        initial_slope - (beta.copysign(v * z) + gamma) * bend
    }
}

impl Sde<3, 1> for BoucWen {
    type Noise = Additive;

    #[inline]
    fn drift(&self, t: f64, &[q, v, z]: &[f64; 3]) -> [f64; 3] {
        let [acceleration] = FrozenLoop { system: self, z }.acceleration(t, &[q], &[v]);
        [v, acceleration, v * self.slope(v, z)]
    }

    #[inline]
    fn noise(&self, t: f64, _: &[f64; 3]) -> [[f64; 1]; 3] {
        let BoucWenParameters { noise_intensity, window, .. } = &self.parameters;
        [[0.0], [window.noise_amplitude(t, *noise_intensity)], [0.0]]
    }

    /// That of the loop at `z = 0`: the structure with the stiffness before yielding.
    #[inline]
    fn linear_part(&self) -> Option<[[f64; 3]; 3]> {
        let BoucWenParameters {
            natural_frequency: w, damping_ratio, hardening, initial_slope, ..
        } = self.parameters;
        let stiffness = w * w;
        Some([
            [0.0, 1.0, 0.0],
            [-stiffness * hardening, -2.0 * damping_ratio * w, -stiffness * (1.0 - hardening)],
            [0.0, initial_slope, 0.0],
        ])
    }
}

/// The oscillator at a constant `z`: a linear one under a constant force.
struct FrozenLoop<'a> {
    system: &'a BoucWen,
    z: f64,
}

impl SecondOrder<1, 1> for FrozenLoop<'_> {
    #[inline]
    fn natural_frequency(&self) -> [f64; 1] {
        let BoucWenParameters { natural_frequency, hardening, .. } = self.system.parameters;
        [natural_frequency * hardening.sqrt()]
    }

    #[inline]
    fn linear_damping(&self) -> [f64; 1] {
        let BoucWenParameters { natural_frequency, damping_ratio, .. } = self.system.parameters;
        [2.0 * damping_ratio * natural_frequency]
    }

    #[inline]
    fn remaining_acceleration(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) -> [f64; 1] {
        let BoucWenParameters { natural_frequency, hardening, .. } = self.system.parameters;
        [-natural_frequency * natural_frequency * (1.0 - hardening) * self.z]
    }

    #[inline]
    fn remaining_flow(&self, t: f64, dt: f64, q: &[f64; 1], v: &mut [f64; 1]) {
        let [force] = self.remaining_acceleration(t, q, v);
        v[0] += dt * force;
    }

    #[inline]
    fn noise_intensity(&self, t: f64) -> [[f64; 1]; 1] {
        [self.system.noise(t, &[0.0; 3])[1]]
    }
}

/// A symmetric splitting of [`BoucWen`] for Monte Carlo: with `h` = `dt`, one step is
///
/// 1. `Z(h/2)`: `dz/dt` at frozen `q'`, by one step of the classical Runge-Kutta method,
/// 2. one step `h` of [`StrangOscillator`] for `(q, q')` at frozen `z`, which is then linear: its flows are exact,
/// 3. `Z(h/2)`.
///
/// Order (additive noise): weak 2 where the loop is smooth; where `q' z` changes sign its slope jumps. `z` keeps below its
/// limit for `h |q'| (beta + gamma) n |z|^(n-1) < 5`, far beyond any step that resolves the oscillator. Stable for
/// `h omega_0 sqrt((1 - alpha) A) < 2`, the hysteretic spring being outside the rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StrangBoucWen;

impl Integrator<BoucWen, 3, 1> for StrangBoucWen {
    type Memory = LinearFlows<1>;

    #[inline]
    fn step(
        &self,
        system: &BoucWen,
        t: f64,
        dt: f64,
        dw: &Increment<1>,
        x: &mut [f64; 3],
        memory: &mut LinearFlows<1>,
    ) -> Result<(), StepError> {
        let [q, v, z] = *x;
        let z = flow_of_loop(system, v, z, 0.5 * dt);
        let mut motion = [q, v];
        let frozen = FrozenLoop { system, z };
        StrangOscillator.step(&frozen, t, dt, dw, &mut motion, memory)?;
        let [q, v] = motion;
        *x = [q, v, flow_of_loop(system, v, z, 0.5 * dt)];
        Ok(())
    }
}

/// `z` after `dt` at frozen `q' = v`.
#[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
#[inline(always)]
fn flow_of_loop(system: &BoucWen, v: f64, z: f64, dt: f64) -> f64 {
    let path = v * dt;
    let k_1 = system.slope(v, z);
    let k_2 = system.slope(v, z + 0.5 * path * k_1);
    let k_3 = system.slope(v, z + 0.5 * path * k_2);
    let k_4 = system.slope(v, z + path * k_3);
    z + path / 6.0 * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4)
}

#[cfg(test)]
mod tests {
    use sde_integrators::{EnsembleConfig, GaussianMixture, Observable, simulate};

    use super::*;

    #[test]
    fn the_drift_is_that_of_equation_28() {
        let parameters = BoucWenParameters {
            hardening: 0.3,
            initial_slope: 1.2,
            gamma: 0.2,
            exponent: 2.0,
            ..BoucWenParameters::CANOR_DENOEL_2013
        };
        let system = BoucWen::new(parameters).unwrap();
        for [q, v, z] in [[0.3, -0.7, 0.4], [0.1, 0.5, 0.6], [-0.2, 0.4, -0.9], [0.2, 0.0, 0.1]] {
            let w = std::f64::consts::PI;
            let acceleration = -2.0 * 0.05 * w * v - w * w * (0.3 * q + 0.7 * z);
            let sign = if v * z > 0.0 { 1.0 } else { -1.0 };
            let rate = v * (1.2 - (0.5 * sign + 0.2) * z * z);
            let drift = system.drift(0.0, &[q, v, z]);
            for (given, expected) in drift.into_iter().zip([v, acceleration, rate]) {
                assert!((given - expected).abs() < 1e-13, "{given} against {expected}");
            }
        }
        // D_22 = S_0 a^2 with a(2) = 1 at the peak of the window.
        let d = system.diffusion(2.0, &[0.0; 3]);
        assert!((d[1][1] - 1.0).abs() < 1e-15 && d[0][0].abs() + d[2][2].abs() < 1e-300);
    }

    #[test]
    fn z_ends_at_its_limit_and_does_not_pass_it() {
        for (initial_slope, beta, gamma, exponent) in
            [(1.0, 0.5, 0.5, 1.0), (1.5, 0.9, 0.3, 2.0), (2.0, 0.3, 0.7, 1.3)]
        {
            let parameters = BoucWenParameters {
                initial_slope,
                beta,
                gamma,
                exponent,
                ..BoucWenParameters::CANOR_DENOEL_2013
            };
            let system = BoucWen::new(parameters).unwrap();
            let limit = system.z_limit();
            let (mut z, mut largest) = (0.0, 0.0_f64);
            for _ in 0..2_000 {
                z = flow_of_loop(&system, 1.0, z, 0.02);
                largest = largest.max(z);
            }
            assert!((z / limit - 1.0).abs() < 1e-9, "{z} against {limit}");
            // Roundoff of the sum.
            assert!(largest <= limit * (1.0 + 1e-15), "{largest} beyond {limit}");
        }
    }

    #[test]
    fn the_flow_of_the_loop_is_the_exponential_on_its_loading_branch() {
        // n = 1, v z > 0: dz/dq = A - (beta + gamma) z, so that z(q) = 1 - exp(-q) here. The error of the step is q^5/120.
        let system = BoucWen::new(BoucWenParameters::CANOR_DENOEL_2013).unwrap();
        let z = flow_of_loop(&system, 2.0, 0.0, 0.05);
        assert!((z - (1.0 - (-0.1_f64).exp())).abs() < 1e-7, "{z}");
    }

    #[test]
    fn the_splitting_gives_the_moments_of_the_reference() {
        // bouc_wen.json at t = 2, from 6e7 paths: E[q^2] = 0.104791, E[q'^2] = 0.896908, E[z^2] = 0.0661953.
        let system = BoucWen::new(BoucWenParameters::CANOR_DENOEL_2013).unwrap();
        let law = GaussianMixture::independent([0.0; 3], [0.05; 3]).unwrap();
        let config = EnsembleConfig { seed: 5, n_paths: 40_000, dt: 0.02, times: vec![2.0] };
        let squares = [0, 1, 2].map(|k| move |_: f64, x: &[f64; 3]| x[k] * x[k]);
        let observables = squares.each_ref().map(|square| Observable::Mean(square));
        let ensemble = simulate(&system, &StrangBoucWen, &law, &config, &observables).unwrap();
        for (estimate, expected) in
            ensemble.estimates[0].iter().zip([0.104791, 0.896908, 0.0661953])
        {
            // The reference lost 2e-4 at half this step; at twice the step of an order 2 that is 8e-4.
            let tolerance = 4.0 * estimate.standard_error().unwrap() + 1e-3 * expected;
            assert!((estimate.value - expected).abs() < tolerance, "{estimate:?}, {expected}");
        }
    }

    #[test]
    fn parameters_outside_their_range_are_refused_by_name() {
        let message = |change: &dyn Fn(&mut BoucWenParameters)| {
            let mut parameters = BoucWenParameters::CANOR_DENOEL_2013;
            change(&mut parameters);
            BoucWen::new(parameters).unwrap_err().to_string()
        };
        assert_eq!(message(&|p| p.exponent = -1.0), "exponent is -1; it must be greater than 0");
        assert_eq!(message(&|p| p.hardening = 1.5), "hardening is 1.5; it must be from 0 to 1");
        assert_eq!(
            message(&|p| p.gamma = -0.5),
            "gamma is -0.5; it must be greater than -beta, which is -0.5"
        );
        assert_eq!(message(&|p| p.beta = -0.1), "beta is -0.1; it must be 0 or greater");
        assert_eq!(
            message(&|p| p.initial_slope = f64::NAN),
            "initial_slope is NaN; it must be finite"
        );
    }
}
