//! The self-excited oscillator of van der Pol and Rayleigh.

use sde_integrators::SecondOrder;

use crate::Window;
use crate::error::{Error, finite, not_negative, positive};
use crate::oscillators::first_order::first_order;
use crate::stationary::StationaryOscillator;

/// Parameters of a [`VanDerPolRayleigh`] oscillator.
#[derive(Debug, Clone, PartialEq)]
pub struct VanDerPolRayleighParameters {
    /// `omega_0 > 0`, natural circular frequency (rad per unit of time).
    pub natural_frequency: f64,
    /// `a`, negative damping at rest (1 per unit of time). For `a > 0` the oscillator excites itself.
    pub self_excitation: f64,
    /// `b > 0`, damping that grows with the energy (time per displacement squared).
    pub energy_damping: f64,
    /// `S_0 >= 0`, intensity of the white noise, `E[W(t) W(t + tau)] = 2 S_0 delta(tau)` (m^2/s^3): `pi` times a two-sided spectral
    /// density per rad/s, a quarter of a one-sided one per Hz.
    pub noise_intensity: f64,
    /// The modulating function (window).
    pub window: Window,
}

/// The van der Pol-Rayleigh oscillator, whose damping depends on its energy,
///
/// $$ \ddot q + \left(-a + b (\omega_0^2 q^2 + \dot q^2)\right) \dot q + \omega_0^2 q = w(t) W(t), \qquad
///    E[W(t) W(t+\tau)] = 2 S_0 \delta(\tau) . $$
///
/// State `(q, q')`; `D_22 = S_0 w^2`, all other entries zero. Without noise and with `a > 0` it ends on the limit cycle
/// `omega_0^2 q^2 + q'^2 = a/b`. With `w = 1` its stationary density is exact ([`stationary`](Self::stationary)).
///
/// Source: Caughey and Payne 1967, On the response of a class of self-excited oscillators to stochastic excitation.
#[derive(Debug, Clone, PartialEq)]
pub struct VanDerPolRayleigh {
    parameters: VanDerPolRayleighParameters,
}

impl VanDerPolRayleigh {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`], [`Error::Negative`], [`Error::OutOfOrder`], naming the parameter.
    pub fn new(parameters: VanDerPolRayleighParameters) -> Result<Self, Error> {
        positive("natural_frequency", parameters.natural_frequency)?;
        finite("self_excitation", parameters.self_excitation)?;
        positive("energy_damping", parameters.energy_damping)?;
        not_negative("noise_intensity", parameters.noise_intensity)?;
        parameters.window.check()?;
        Ok(Self { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> &VanDerPolRayleighParameters {
        &self.parameters
    }

    /// `2 pi / omega_0`, the natural period (time).
    pub fn period(&self) -> f64 {
        std::f64::consts::TAU / self.parameters.natural_frequency
    }

    /// The stationary law for `w = 1`, whatever the window: with the energy `H = (q'^2 + omega_0^2 q^2)/2`,
    ///
    /// $$ \psi(q, v) = \frac1Z \exp\left(\frac{a H - b H^2}{S_0}\right) . $$
    ///
    /// # Errors
    /// [`Error::NotPositive`] without noise.
    pub fn stationary(&self) -> Result<StationaryOscillator, Error> {
        let VanDerPolRayleighParameters {
            natural_frequency: w,
            self_excitation: a,
            energy_damping: b,
            noise_intensity,
            ..
        } = self.parameters;
        // Of the size of the damping where the density lives: on the limit cycle, or where b H is what noise feeds.
        let scale = a.abs() + (b * noise_intensity).sqrt();
        StationaryOscillator::of_energy(
            (w, scale, noise_intensity),
            move |q| 0.5 * w * w * q * q,
            move |energy| (b * energy - a) * energy,
        )
    }
}

first_order!(VanDerPolRayleigh);

impl SecondOrder<1, 1> for VanDerPolRayleigh {
    #[inline]
    fn natural_frequency(&self) -> [f64; 1] {
        [self.parameters.natural_frequency]
    }

    #[inline]
    fn linear_damping(&self) -> [f64; 1] {
        [0.0]
    }

    #[inline]
    fn remaining_acceleration(&self, _: f64, &[q]: &[f64; 1], &[v]: &[f64; 1]) -> [f64; 1] {
        let VanDerPolRayleighParameters {
            natural_frequency: w,
            self_excitation: a,
            energy_damping: b,
            ..
        } = self.parameters;
        [(a - b * (w * w * q * q + v * v)) * v]
    }

    /// With `r = a - b omega_0^2 q^2` the equation is Bernoulli's, `dv/dt = r v - b v^3`:
    /// `v e^(r dt) / sqrt(1 + b v^2 (e^(2 r dt) - 1)/r)`.
    #[inline]
    fn remaining_flow(&self, _: f64, dt: f64, &[q]: &[f64; 1], [v]: &mut [f64; 1]) {
        let VanDerPolRayleighParameters {
            natural_frequency: w,
            self_excitation: a,
            energy_damping: b,
            ..
        } = self.parameters;
        let rate = a - b * w * w * q * q;
        let exponent = 2.0 * rate * dt;
        // (e^x - 1)/x, by its series where the quotient has no digits.
        let part =
            if exponent.abs() < 1e-8 { 1.0 + 0.5 * exponent } else { exponent.exp_m1() / exponent };
        let grown = 2.0 * b * *v * *v * dt * part;
        *v *= (0.5 * exponent).exp() / (1.0 + grown).sqrt();
    }

    #[inline]
    fn noise_intensity(&self, t: f64) -> [[f64; 1]; 1] {
        let VanDerPolRayleighParameters { noise_intensity, window, .. } = &self.parameters;
        [[window.noise_amplitude(t, *noise_intensity)]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stationary::satisfies_the_stationary_equation;

    fn oscillator(self_excitation: f64) -> VanDerPolRayleigh {
        VanDerPolRayleigh::new(VanDerPolRayleighParameters {
            natural_frequency: 1.3,
            self_excitation,
            energy_damping: 0.2,
            noise_intensity: 0.1,
            window: Window::Stationary,
        })
        .unwrap()
    }

    #[test]
    fn the_flow_of_the_damping_solves_its_equation() {
        for self_excitation in [0.5, -0.3, 0.2 * 1.69 * 0.16] {
            let system = oscillator(self_excitation);
            let flow = |v: f64, dt: f64| {
                let mut v = [v];
                system.remaining_flow(0.0, dt, &[0.4], &mut v);
                v[0]
            };
            for v in [-1.7, 0.2] {
                // Central difference, error O(eps^2).
                let eps = 1e-5;
                let rate = (flow(v, eps) - flow(v, -eps)) / (2.0 * eps);
                let [expected] = system.remaining_acceleration(0.0, &[0.4], &[v]);
                assert!((rate - expected).abs() < 1e-9, "{rate} against {expected}");
                assert!((flow(flow(v, 0.3), 0.5) - flow(v, 0.8)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn the_stationary_density_satisfies_its_equation_and_shares_the_energy_equally() {
        for self_excitation in [0.5, 0.0, -0.3] {
            let system = oscillator(self_excitation);
            let law = system.stationary().unwrap();
            satisfies_the_stationary_equation(&system, |x| law.density(x));
            // H depends on omega q and v alike, so that omega^2 E[q^2] = E[v^2].
            let ratio = 1.69 * law.moment([2, 0]) / law.moment([0, 2]);
            assert!((ratio - 1.0).abs() < 1e-11, "{ratio}");
        }
    }

    #[test]
    fn without_self_excitation_the_moments_are_those_of_half_a_normal_law() {
        // a = 0: H has the density exp(-b H^2/S_0) on H > 0, so that E[H] = sqrt(S_0/(pi b)) and E[v^2] = E[H].
        let law = oscillator(0.0).stationary().unwrap();
        let expected = (0.1 / (std::f64::consts::PI * 0.2)).sqrt();
        assert!((law.moment([0, 2]) / expected - 1.0).abs() < 1e-11);
    }
}
