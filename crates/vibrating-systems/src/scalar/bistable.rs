//! A particle in a double well.

use sde_integrators::{Additive, Sde};

use crate::error::{Error, finite, positive};
use crate::stationary::half_line;

/// Parameters of a [`Bistable`] system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BistableParameters {
    /// `a`, growth at the origin (1 per unit of time); for `a > 0` there are two wells.
    pub growth: f64,
    /// `b > 0`, cubic restoring force (1 per unit of time and state squared).
    pub cubic: f64,
    /// `D > 0`, the diffusion (state squared per unit of time); the noise is `sqrt(2 D) dB`.
    pub diffusion: f64,
}

/// Overdamped motion in the potential `-a x^2/2 + b x^4/4`, with wells at `+- sqrt(a/b)`:
///
/// $$ dX = (a X - b X^3) dt + \sqrt{2 D} dB . $$
///
/// One state. Source: Risken 1996, The Fokker-Planck equation, section 5.7.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bistable {
    parameters: BistableParameters,
    /// The integral of `exp(-(potential)/D)` over half the line.
    half_normalisation: f64,
}

impl Bistable {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`], naming the parameter.
    pub fn new(parameters: BistableParameters) -> Result<Self, Error> {
        let BistableParameters { growth, cubic, diffusion } = parameters;
        finite("growth", growth)?;
        positive("cubic", cubic)?;
        positive("diffusion", diffusion)?;
        let mut system = Self { parameters, half_normalisation: 1.0 };
        let width = (growth.abs() / cubic).sqrt() + (diffusion / cubic).powf(0.25);
        system.half_normalisation = half_line(0.0, width, |x| system.shape(x));
        Ok(system)
    }

    /// The parameters.
    pub fn parameters(&self) -> &BistableParameters {
        &self.parameters
    }

    /// `1/(2 |a|)`, the time in which the motion inside a well relaxes, or for `a = 0` that of the quartic well,
    /// `1/sqrt(b D)`.
    pub fn relaxation_time(&self) -> f64 {
        let BistableParameters { growth, cubic, diffusion } = self.parameters;
        if growth == 0.0 { 1.0 / (cubic * diffusion).sqrt() } else { 0.5 / growth.abs() }
    }

    /// The stationary density, `exp((a x^2/2 - b x^4/4)/D)/Z`.
    pub fn stationary_density(&self, x: f64) -> f64 {
        0.5 * self.shape(x) / self.half_normalisation
    }

    fn shape(&self, x: f64) -> f64 {
        let BistableParameters { growth, cubic, diffusion } = self.parameters;
        (x * x * (0.5 * growth - 0.25 * cubic * x * x) / diffusion).exp()
    }
}

impl Sde<1, 1> for Bistable {
    type Noise = Additive;

    #[inline]
    fn drift(&self, _: f64, &[x]: &[f64; 1]) -> [f64; 1] {
        let BistableParameters { growth, cubic, .. } = self.parameters;
        [growth * x - cubic * x * x * x]
    }

    #[inline]
    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[(2.0 * self.parameters.diffusion).sqrt()]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stationary_density_has_the_published_normalisation() {
        // bistable_and_duffing.json: Z = 5.365160237834795 for dX = (X - X^3) dt + sqrt(0.5) dB.
        let parameters = BistableParameters { growth: 1.0, cubic: 1.0, diffusion: 0.25 };
        let system = Bistable::new(parameters).unwrap();
        assert!((system.stationary_density(0.0) * 5.365160237834795 - 1.0).abs() < 1e-12);
        // No flux: (a x - b x^3) psi = D psi'.
        let (x, step) = (0.7, 1e-5);
        let slope = (system.stationary_density(x + step) - system.stationary_density(x - step))
            / (2.0 * step);
        let flux = system.drift(0.0, &[x])[0] * system.stationary_density(x) - 0.25 * slope;
        assert!(flux.abs() < 1e-9, "{flux:e}");
        assert!((system.diffusion(0.0, &[x])[0][0] - 0.25).abs() < 1e-16);
    }

    #[test]
    fn parameters_outside_their_range_are_refused_by_name() {
        let parameters = BistableParameters { growth: 1.0, cubic: 0.0, diffusion: 0.25 };
        assert!(matches!(Bistable::new(parameters), Err(Error::NotPositive { name: "cubic", .. })));
    }
}
