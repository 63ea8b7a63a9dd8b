//! Stationary densities in closed form, with their moments and tails by quadrature.

use crate::error::{Error, finite, positive};

/// The stationary law of an oscillator `q'' + h(H) q' + U'(q) = W` with the energy `H = q'^2/2 + U(q)` and an even `U`:
///
/// $$ \psi(q, v) = \frac1Z \exp\left(-\frac{1}{S_0} \int_0^H h(e) de\right) . $$
///
/// Source: Caughey 1971, Nonlinear theory of random vibrations, section on exact solutions.
pub struct StationaryOscillator {
    log_shape: Box<dyn Fn(f64, f64) -> f64 + Send + Sync>,
    scale: [f64; 2],
    normalisation: f64,
}

impl std::fmt::Debug for StationaryOscillator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StationaryOscillator")
            .field("scale", &self.scale)
            .field("normalisation", &self.normalisation)
            .finish_non_exhaustive()
    }
}

impl StationaryOscillator {
    /// From `(omega, damping, S_0)`, which set the scales of the quadrature, the potential `U(q)` and the integral of
    /// `h` up to an energy.
    pub(crate) fn of_energy(
        (frequency, damping, noise_intensity): (f64, f64, f64),
        potential: impl Fn(f64) -> f64 + Send + Sync + 'static,
        dissipation: impl Fn(f64) -> f64 + Send + Sync + 'static,
    ) -> Result<Self, Error> {
        positive("damping", damping)?;
        positive("noise_intensity", noise_intensity)?;
        let deviation = (noise_intensity / damping).sqrt();
        let log_shape =
            move |q: f64, v: f64| -dissipation(0.5 * v * v + potential(q)) / noise_intensity;
        let mut law = Self {
            log_shape: Box::new(log_shape),
            scale: [deviation / frequency, deviation],
            normalisation: 1.0,
        };
        law.normalisation = law.quadrant(0.0, |_, _| 1.0);
        Ok(law)
    }

    /// `psi(q, v)`.
    pub fn density(&self, &[q, v]: &[f64; 2]) -> f64 {
        // Each quadrant holds a quarter.
        0.25 * (self.log_shape)(q, v).exp() / self.normalisation
    }

    /// `E[q^a v^b]`.
    pub fn moment(&self, [a, b]: [u32; 2]) -> f64 {
        if a % 2 == 1 || b % 2 == 1 {
            return 0.0;
        }
        let power = |x: f64, a: u32| x.powi(i32::try_from(a).unwrap_or(i32::MAX));
        self.quadrant(0.0, |q, v| power(q, a) * power(v, b)) / self.normalisation
    }

    /// `P(|q| > T)`, to full relative precision however small.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the threshold.
    pub fn exceedance(&self, threshold: f64) -> Result<f64, Error> {
        finite("threshold", threshold)?;
        if threshold <= 0.0 {
            return Ok(1.0);
        }
        Ok(self.quadrant(threshold, |_, _| 1.0) / self.normalisation)
    }

    /// The integral of `f exp(log_shape)` over `q > from`, `v > 0`.
    fn quadrant(&self, from: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
        let [q_scale, v_scale] = self.scale;
        half_line(from, q_scale, |q| {
            half_line(0.0, v_scale, |v| match (self.log_shape)(q, v).exp() {
                // A power may overflow where the density is long zero.
                0.0 => 0.0,
                shape => f(q, v) * shape,
            })
        })
    }
}

/// The integral of `f` from `from` to infinity, for a smooth `f` that decays within some times `scale`: the trapezoidal
/// rule in `u` with `x = from + scale exp(pi/2 sinh u)`, whose error falls exponentially with the number of points.
///
/// Source: Takahasi and Mori 1974, Double exponential formulas for numerical integration.
pub(crate) fn half_line(from: f64, scale: f64, f: impl Fn(f64) -> f64) -> f64 {
    const STEP: f64 = 1.0 / 64.0;
    let term = |k: i32| {
        let u = f64::from(k) * STEP;
        let offset = scale * (std::f64::consts::FRAC_PI_2 * u.sinh()).exp();
        let weight = std::f64::consts::FRAC_PI_2 * u.cosh() * offset;
        let value = f(from + offset);
        if value == 0.0 { 0.0 } else { value * weight }
    };
    // The integrand has vanished at both ends: offset/scale from 1e-18 to 1e10.
    STEP * (-256..=220).map(term).sum::<f64>()
}

/// Whether a density satisfies `div(f psi) = div(D grad psi)` at some points, by central differences.
#[cfg(test)]
pub(crate) fn satisfies_the_stationary_equation<S: sde_integrators::Sde<2, 1>>(
    system: &S,
    density: impl Fn(&[f64; 2]) -> f64,
) {
    let step = 1e-4;
    for x in [[0.3, 0.4], [-0.8, 0.2], [0.5, -1.1]] {
        let moved = |k: usize, by: f64| {
            let mut y = x;
            y[k] += by;
            y
        };
        let flux = |k: usize, y: &[f64; 2]| system.drift(0.0, y)[k] * density(y);
        let (mut transport, mut size) = (0.0, 0.0_f64);
        for k in 0..2 {
            let part = (flux(k, &moved(k, step)) - flux(k, &moved(k, -step))) / (2.0 * step);
            transport += part;
            size = size.max(part.abs());
        }
        let [below, centre, above] = [-step, 0.0, step].map(|by| density(&moved(1, by)));
        let diffusion =
            system.diffusion(0.0, &x)[1][1] * (below - 2.0 * centre + above) / (step * step);
        // Differences of order step^2 in terms of some unit size.
        let error = (transport - diffusion).abs();
        assert!(error < 1e-6 * size.max(diffusion.abs()).max(1e-3), "{x:?}: {error:e} of {size:e}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_integrates_half_a_normal_law_and_its_far_tail() {
        let normal = |x: f64| (-0.5 * x * x).exp();
        let whole = (0.5 * std::f64::consts::PI).sqrt();
        for scale in [0.2, 1.0, 5.0] {
            assert!((half_line(0.0, scale, normal) / whole - 1.0).abs() < 1e-13, "{scale}");
        }
        // Q(10) = 7.619853024160525e-24, times sqrt(2 pi).
        let tail = 7.619853024160525e-24 * std::f64::consts::TAU.sqrt();
        assert!((half_line(10.0, 1.0, normal) / tail - 1.0).abs() < 1e-12);
    }
}
