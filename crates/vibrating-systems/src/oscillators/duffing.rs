//! The oscillator with a cubic spring.

use sde_integrators::SecondOrder;

use crate::error::{Error, not_negative};
use crate::oscillators::first_order::first_order;
use crate::stationary::StationaryOscillator;
use crate::{LinearOscillator, LinearOscillatorParameters};

/// An oscillator with a cubic spring.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "schema", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "schema", serde(deny_unknown_fields), schemars(rename = "DuffingScene"))]
pub struct DuffingParameters {
    /// The oscillator without its cubic spring.
    pub structure: LinearOscillatorParameters,
    /// `epsilon >= 0`, the cubic part of the spring (1/m^2).
    pub cubic_stiffness: f64,
}

/// Duffing's oscillator,
///
/// $$ \ddot q + 2\xi\omega_0\dot q + \omega_0^2 (q + \epsilon q^3) = a(t) W(t), \qquad
///    E[W(t) W(t+\tau)] = 2 S_0 \delta(\tau) . $$
///
/// State `(q, q')`; `D_22 = S_0 a^2`, all other entries zero. With `a = 1` and damping its stationary density is exact
/// ([`stationary`](Self::stationary)).
///
/// Source: Caughey 1963, Derivation and application of the Fokker-Planck equation to discrete nonlinear dynamic systems.
#[derive(Debug, Clone, PartialEq)]
pub struct Duffing {
    structure: LinearOscillator,
    cubic_stiffness: f64,
}

impl Duffing {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::Negative`] for the cubic stiffness, [`Error::NotFinite`], and those of [`LinearOscillator::new`].
    pub fn new(parameters: DuffingParameters) -> Result<Self, Error> {
        let DuffingParameters { structure, cubic_stiffness } = parameters;
        let structure = LinearOscillator::new(structure)?;
        not_negative("cubic_stiffness", cubic_stiffness)?;
        Ok(Self { structure, cubic_stiffness })
    }

    /// The oscillator without its cubic spring.
    pub fn structure(&self) -> &LinearOscillator {
        &self.structure
    }

    /// `2 pi / omega_0`, the natural period of small oscillations (time).
    pub fn period(&self) -> f64 {
        self.structure.period()
    }

    /// The stationary law for `a = 1`, whatever the window:
    ///
    /// $$ \psi(q, v) = \frac1Z \exp\left(-\frac{2\xi\omega_0}{S_0}
    ///    \left(\frac{v^2}{2} + \omega_0^2 \left(\frac{q^2}{2} + \epsilon\frac{q^4}{4}\right)\right)\right) . $$
    ///
    /// # Errors
    /// [`Error::NotPositive`] without damping or noise.
    pub fn stationary(&self) -> Result<StationaryOscillator, Error> {
        let LinearOscillatorParameters {
            natural_frequency: w, damping_ratio, noise_intensity, ..
        } = *self.structure.parameters();
        let (damping, epsilon) = (2.0 * damping_ratio * w, self.cubic_stiffness);
        StationaryOscillator::of_energy(
            (w, damping, noise_intensity),
            move |q| w * w * q * q * (0.5 + 0.25 * epsilon * q * q),
            move |energy| damping * energy,
        )
    }
}

first_order!(Duffing);

impl SecondOrder<1, 1> for Duffing {
    #[inline]
    fn natural_frequency(&self) -> [f64; 1] {
        SecondOrder::natural_frequency(&self.structure)
    }

    #[inline]
    fn linear_damping(&self) -> [f64; 1] {
        self.structure.linear_damping()
    }

    #[inline]
    fn remaining_acceleration(&self, _: f64, &[q]: &[f64; 1], _: &[f64; 1]) -> [f64; 1] {
        let w = self.structure.parameters().natural_frequency;
        [-w * w * self.cubic_stiffness * q * q * q]
    }

    #[inline]
    fn remaining_flow(&self, t: f64, dt: f64, q: &[f64; 1], v: &mut [f64; 1]) {
        let [force] = self.remaining_acceleration(t, q, v);
        v[0] += dt * force;
    }

    #[inline]
    fn noise_intensity(&self, t: f64) -> [[f64; 1]; 1] {
        SecondOrder::noise_intensity(&self.structure, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Window;
    use crate::stationary::satisfies_the_stationary_equation;

    fn duffing() -> Duffing {
        let structure = LinearOscillatorParameters {
            natural_frequency: 1.0,
            damping_ratio: 0.05,
            noise_intensity: 0.1,
            window: Window::Stationary,
        };
        Duffing::new(DuffingParameters { structure, cubic_stiffness: 0.5 }).unwrap()
    }

    #[test]
    fn the_stationary_moments_and_tails_are_those_of_the_reference() {
        // bistable_and_duffing.json; beyond 3 by adaptive quadrature with 40 digits, because the file's last two, made
        // with an absolute tolerance, are off by 1.2 and 0.14 %.
        let law = duffing().stationary().unwrap();
        assert!((law.moment([2, 0]) / 0.5792047726384801 - 1.0).abs() < 1e-12);
        assert!((law.moment([0, 2]) - 1.0).abs() < 1e-12);
        for (threshold, expected) in [
            (1.0, 0.20208507251999028),
            (2.0, 0.0024952506656542315),
            (3.0, 2.4440846754502774e-08),
            (4.0, 1.1020979231018582e-19),
            (5.0, 6.131251502660934e-42),
        ] {
            let p = law.exceedance(threshold).unwrap();
            assert!((p / expected - 1.0).abs() < 1e-11, "{threshold}: {p:e}");
        }
    }

    #[test]
    fn the_stationary_density_satisfies_its_equation() {
        let system = duffing();
        let law = system.stationary().unwrap();
        satisfies_the_stationary_equation(&system, |x| law.density(x));
    }

    #[test]
    fn without_damping_there_is_no_stationary_law() {
        let structure = LinearOscillatorParameters {
            damping_ratio: 0.0,
            ..duffing().structure().parameters().clone()
        };
        let system = Duffing::new(DuffingParameters { structure, cubic_stiffness: 0.5 }).unwrap();
        assert!(matches!(system.stationary(), Err(Error::NotPositive { name: "damping", .. })));
    }
}
