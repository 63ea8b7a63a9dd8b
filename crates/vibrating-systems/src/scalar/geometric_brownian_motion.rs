//! Geometric Brownian motion.

use sde_integrators::{General, Sde};

use crate::error::{Error, finite, positive};

/// Geometric Brownian motion,
///
/// $$ dX = \mu X dt + \sigma X dB . $$
///
/// One state; `D = sigma^2 x^2/2` depends on it, `div D = sigma^2 x`. `X(t)/X(0)` is lognormal.
///
/// Source: Øksendal 1992, Stochastic differential equations, example 5.1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeometricBrownianMotion {
    growth: f64,
    volatility: f64,
}

impl GeometricBrownianMotion {
    /// With `mu` (1 per unit of time) and `sigma > 0` (1 per square root of time).
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`], naming the parameter.
    pub fn new(growth: f64, volatility: f64) -> Result<Self, Error> {
        finite("growth", growth)?;
        positive("volatility", volatility)?;
        Ok(Self { growth, volatility })
    }

    /// The density of `X(t)` at `x`, from `X(0) = start > 0`: lognormal; zero for `x <= 0`.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for `t` or `start`.
    pub fn transition_density(&self, start: f64, t: f64, x: f64) -> Result<f64, Error> {
        positive("start", start)?;
        positive("time", t)?;
        if x <= 0.0 {
            return Ok(0.0);
        }
        let deviation = self.volatility * t.sqrt();
        let mean = (self.growth - 0.5 * self.volatility * self.volatility) * t;
        let z = ((x / start).ln() - mean) / deviation;
        Ok((-0.5 * z * z).exp() / (x * deviation * std::f64::consts::TAU.sqrt()))
    }
}

impl Sde<1, 1> for GeometricBrownianMotion {
    type Noise = General;

    #[inline]
    fn drift(&self, _: f64, &[x]: &[f64; 1]) -> [f64; 1] {
        [self.growth * x]
    }

    #[inline]
    fn noise(&self, _: f64, &[x]: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.volatility * x]]
    }

    #[inline]
    fn diffusion_divergence(&self, _: f64, &[x]: &[f64; 1]) -> [f64; 1] {
        [self.volatility * self.volatility * x]
    }

    #[inline]
    fn linear_part(&self) -> Option<[[f64; 1]; 1]> {
        Some([[self.growth]])
    }
}

#[cfg(test)]
mod tests {
    use sde_integrators::check_diffusion_divergence;

    use super::*;
    use crate::stationary::half_line;

    #[test]
    fn the_closed_divergence_is_that_of_the_noise() {
        let system = GeometricBrownianMotion::new(0.1, 0.4).unwrap();
        // Central differences of a square, exact but for roundoff.
        assert!(check_diffusion_divergence(&system, 0.0, &[[0.3], [2.0], [-1.0]]) < 1e-9);
    }

    #[test]
    fn the_transition_density_has_the_moments_of_the_equation() {
        let (mu, sigma, start, t) = (0.1_f64, 0.4_f64, 1.5, 2.0);
        let system = GeometricBrownianMotion::new(mu, sigma).unwrap();
        let moment = |a: i32| {
            half_line(0.0, 1.0, |x| x.powi(a) * system.transition_density(start, t, x).unwrap())
        };
        // E[X^a] = start^a exp(a mu t + a (a - 1) sigma^2 t/2), from d E[X^a]/dt.
        for a in 0..3 {
            let k = f64::from(a);
            let expected =
                start.powi(a) * (k * mu * t + 0.5 * k * (k - 1.0) * sigma * sigma * t).exp();
            assert!((moment(a) / expected - 1.0).abs() < 1e-9, "moment {a}");
        }
    }

    #[test]
    fn a_start_at_zero_and_no_noise_are_refused() {
        assert!(GeometricBrownianMotion::new(0.1, 0.0).is_err());
        let system = GeometricBrownianMotion::new(0.1, 0.4).unwrap();
        assert!(system.transition_density(0.0, 1.0, 1.0).is_err());
    }
}
