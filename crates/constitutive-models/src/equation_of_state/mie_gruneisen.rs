//! The equation of state of Mie and Grueneisen.

use perturbation_moments::{Real, Scalar, when};
use simd_lanes::Mask;

use super::{EquationOfState, Line, Start};
use crate::EquationFamily;
use crate::error::{Error, Fault, finite, not_negative, positive};

parameters! {
    /// What a [`MieGruneisen`] is made of.
    MieGruneisenParameters {
        /// `rho_0 > 0` (mass per volume).
        density,
        /// `C > 0`, the speed of sound in the bulk (length per time).
        sound_speed,
        /// `S1`, the slope of the shock velocity by the particle velocity (no unit).
        s1,
        /// `S2`, its quadratic term (no unit).
        s2,
        /// `S3`, its cubic term (no unit).
        s3,
        /// `gamma_0 >= 0`, the Grueneisen coefficient of the reference state (no unit).
        gruneisen,
        /// `a`, its first-order correction by the compression (no unit).
        gruneisen_slope,
    }
}

/// A solid or liquid by its shock Hugoniot.
///
/// $$ p = p_H + (\gamma_0 + a \mu) (e - e_H), \quad
///    p_H = \rho_0 C^2 \frac{x}{(1 - S_1 x - S_2 x^2 - S_3 x^3)^2}, \quad e_H = \tfrac12 p_H x, \qquad \mu > 0 $$
///
/// $$ p = \rho_0 C^2 \mu + (\gamma_0 + a \mu) e, \qquad \mu \le 0 $$
///
/// Symbols: $x = 1 - J$, $\mu = 1/J - 1$, `e` = energy per reference volume (stress). Written in `x` it is the paper's
/// equation; its Hugoniot is exactly $U_s = C + S_1 u_p$ for $S_2 = S_3 = 0$. Value and slope are continuous at $\mu = 0$, the
/// second derivative is not.
///
/// Domain: the denominator stays above zero; it vanishes at the largest compression that a shock reaches.
///
/// Source: Chen et al. 2019, eq 10; Steinberg 1996 for the terms `S2`, `S3` and `a`.
///
/// ```
/// use constitutive_models::{EquationOfState, MieGruneisen, Units, library};
///
/// let steel = MieGruneisen::new(library::steel_equation(Units::CM_G_US))?;
/// // On the Hugoniot e = p x/2, so that p = a/(1 - b x/2): with u_p = 0.1 cm/us, p = rho_0 (C + S1 u_p) u_p.
/// let shock_velocity = 0.4569 + 1.49 * 0.1;
/// let x = 0.1 / shock_velocity;
/// let line = steel.line(1.0 - x);
/// let pressure: f64 = line.a / (1.0 - 0.5 * x * line.b);
/// assert!((pressure - 7.83 * shock_velocity * 0.1).abs() < 1e-13);
/// # Ok::<(), constitutive_models::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MieGruneisen<S> {
    parameters: MieGruneisenParameters<S>,
    /// `rho_0 C^2`.
    modulus: S,
}

impl<S: Scalar> MieGruneisen<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for density and sound speed, [`Error::Negative`] for `gamma_0`, [`Error::NotFinite`] for the
    /// others.
    pub fn new(parameters: MieGruneisenParameters<S>) -> Result<Self, Error> {
        let p = &parameters;
        positive("density", p.density.value())?;
        positive("sound speed", p.sound_speed.value())?;
        finite("s1", p.s1.value())?;
        finite("s2", p.s2.value())?;
        finite("s3", p.s3.value())?;
        not_negative("gruneisen", p.gruneisen.value())?;
        finite("gruneisen slope", p.gruneisen_slope.value())?;
        Ok(Self { parameters, modulus: p.density * p.sound_speed.squared() })
    }
}

impl<S: Real> MieGruneisen<S> {
    /// `1 - S1 x - S2 x^2 - S3 x^3`.
    #[inline(always)]
    fn denominator(&self, x: S) -> S {
        let p = &self.parameters;
        (((p.s3 * x + p.s2) * x + p.s1) * x) * -1.0 + 1.0
    }

    /// The pressure at no energy, under compression.
    #[inline(always)]
    fn hugoniot(&self, volume: S, gruneisen: S) -> S {
        let x = volume * -1.0 + 1.0;
        let hugoniot = self.modulus * x / self.denominator(x).squared();
        hugoniot * (gruneisen * x * -0.5 + 1.0)
    }

    /// `gamma_0 + a mu`.
    #[inline(always)]
    fn gruneisen(&self, mu: S) -> S {
        self.parameters.gruneisen_slope * mu + self.parameters.gruneisen
    }
}

impl<S: Real> EquationOfState<S> for MieGruneisen<S> {
    type State = ();

    #[inline(always)]
    fn density(&self) -> S {
        self.parameters.density
    }

    fn start(&self, _position: [f64; 3]) -> Start<S, ()>
    where
        S: Scalar,
    {
        Start { state: (), energy: S::constant(0.0), pressure: S::constant(0.0) }
    }

    #[inline(always)]
    fn line(&self, volume: S) -> Line<S> {
        let mu = volume.recip() - 1.0;
        let gruneisen = self.gruneisen(mu);
        let a = when!(mu.splat(0.0).less(mu), self.hugoniot(volume, gruneisen), self.modulus * mu);
        Line { a, b: gruneisen }
    }

    #[inline(always)]
    fn slope(&self, volume: S) -> Line<S> {
        let p = &self.parameters;
        let inverse = volume.recip();
        let mu_slope = inverse.squared() * -1.0;
        let by_gruneisen = p.gruneisen_slope * mu_slope;
        let is_compressed = volume.less(volume.splat(1.0));
        let mut a = self.modulus * mu_slope;
        if is_compressed.any() {
            // dx/dJ = -1.
            let x = volume * -1.0 + 1.0;
            let gruneisen = self.gruneisen(inverse - 1.0);
            let denominator = self.denominator(x);
            let square = denominator.squared().recip();
            let denominator_slope = ((p.s3 * x * 3.0 + p.s2 * 2.0) * x + p.s1) * -1.0;
            let hugoniot = self.modulus * x * square;
            let hugoniot_slope =
                self.modulus * square * (x * denominator_slope / denominator * 2.0 - 1.0);
            let compressed = hugoniot_slope * (gruneisen * x * -0.5 + 1.0)
                + hugoniot * (gruneisen - by_gruneisen * x) * 0.5;
            a = S::select(is_compressed, compressed, a);
        }
        Line { a, b: by_gruneisen }
    }

    #[inline(always)]
    fn admit(&self, volume: S) -> Result<(), Fault> {
        let p = &self.parameters;
        let x = volume.primal() * -1.0 + 1.0;
        let zero = x.splat(0.0);
        let x = S::Primal::select(zero.less(x), x, zero);
        let terms = ((p.s3.primal() * x + p.s2.primal()) * x + p.s1.primal()) * x;
        let denominator = terms * -1.0 + 1.0;
        Fault::unless(
            zero.less(denominator),
            denominator,
            "1 - S1 x - S2 x^2 - S3 x^3 of the Hugoniot, x = 1 - V/V_0,",
            "greater than 0: no shock compresses further",
        )
    }

    shows_constants!(modulus);
}

family_member!(EquationFamily, EquationOfState: MieGruneisen { modulus }, _number => ());

#[cfg(test)]
mod tests {
    use super::super::laws::{pressure, slopes_and_bulk_modulus};
    use super::*;

    const STEEL: MieGruneisenParameters<f64> = MieGruneisenParameters {
        density: 7.83,
        sound_speed: 0.4569,
        s1: 1.49,
        s2: 0.0,
        s3: 0.0,
        gruneisen: 2.17,
        gruneisen_slope: 0.46,
    };

    /// The same with all terms, so that each is seen.
    const WHOLE: MieGruneisenParameters<f64> =
        MieGruneisenParameters { s2: -0.7, s3: 0.3, ..STEEL };

    #[test]
    fn it_is_equation_10_of_the_paper() {
        let p = WHOLE;
        let equation = MieGruneisen::new(p).unwrap();
        for (volume, energy) in [(0.8, 0.03), (0.97, 0.2), (1.2, 0.1)] {
            let mu = 1.0 / volume - 1.0;
            let modulus = p.density * p.sound_speed * p.sound_speed;
            let thermal = (p.gruneisen + p.gruneisen_slope * mu) * energy;
            let printed = if mu > 0.0 {
                let numerator =
                    1.0 + (1.0 - p.gruneisen / 2.0) * mu - p.gruneisen_slope / 2.0 * mu * mu;
                let denominator = 1.0
                    - (p.s1 - 1.0) * mu
                    - p.s2 * mu * mu / (mu + 1.0)
                    - p.s3 * mu * mu * mu / ((mu + 1.0) * (mu + 1.0));
                modulus * mu * numerator / (denominator * denominator) + thermal
            } else {
                modulus * mu + thermal
            };
            assert!((pressure(&equation, volume, energy) - printed).abs() < 1e-13);
        }
    }

    #[test]
    fn its_hugoniot_is_linear_in_the_particle_velocity() {
        let p = STEEL;
        let equation = MieGruneisen::new(p).unwrap();
        for x in [0.01, 0.1, 0.3, 0.5] {
            let line = equation.line(1.0 - x);
            let pressure: f64 = line.a / (1.0 - 0.5 * x * line.b);
            let particle = (pressure * x / p.density).sqrt();
            let shock = particle / x;
            assert!((shock / (p.sound_speed + p.s1 * particle) - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn slopes_and_bulk_modulus_are_derivatives() {
        let equation = MieGruneisen::new(WHOLE).unwrap();
        slopes_and_bulk_modulus(&equation, &[0.6, 0.8, 0.99, 1.01, 1.3], 0.05);
        // At rest: rho_0 C^2.
        let rest = equation.bulk_modulus(1.0, 0.0);
        assert!((rest - 7.83 * 0.4569 * 0.4569).abs() < 1e-14);
    }

    #[test]
    fn beyond_its_pole_it_refuses() {
        let equation = MieGruneisen::new(STEEL).unwrap();
        let pole = 1.0 - 1.0 / 1.49;
        assert!(equation.admit(pole + 1e-6).is_ok());
        let fault = equation.admit(pole - 1e-6).unwrap_err();
        assert!(fault.value < 0.0 && fault.to_string().contains("greater than 0"), "{fault}");
    }

    #[test]
    fn bad_parameters_are_refused_by_name() {
        let refused = |p| MieGruneisen::new(p).unwrap_err();
        assert_eq!(
            refused(MieGruneisenParameters { density: -1.0, ..STEEL }),
            Error::NotPositive { name: "density", value: -1.0 }
        );
        assert_eq!(
            refused(MieGruneisenParameters { gruneisen: -0.1, ..STEEL }),
            Error::Negative { name: "gruneisen", value: -0.1 }
        );
        assert!(matches!(
            refused(MieGruneisenParameters { s2: f64::NAN, ..STEEL }),
            Error::NotFinite { name: "s2", .. }
        ));
    }
}
