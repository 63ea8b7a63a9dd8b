//! Filters that make ground motion of white noise.

use crate::error::{Error, finite, positive};
use crate::linear_law::Transition;
use crate::matrix::Matrix;

/// A linear filter with `F` states, driven by white noise with `E[W(t) W(t + tau)] = delta(tau)`:
///
/// $$ \dot y = A y + b W, \qquad u = c \cdot y . $$
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter<const F: usize> {
    pub(crate) matrix: Matrix<F>,
    pub(crate) noise: [f64; F],
    pub(crate) output: [f64; F],
    period: f64,
    stationary_covariance: Matrix<F>,
}

/// Soil as a damped oscillator: parameters of [`Filter::kanai_tajimi`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KanaiTajimiParameters {
    /// `omega_g > 0`, circular frequency of the soil (rad per unit of time); 15.6 rad/s for firm soil (Kanai 1957).
    pub ground_frequency: f64,
    /// `zeta_g > 0`, its damping ratio; 0.6 for firm soil.
    pub ground_damping: f64,
}

/// Soil and a high-pass filter behind it: parameters of [`Filter::clough_penzien`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloughPenzienParameters {
    /// The soil.
    pub soil: KanaiTajimiParameters,
    /// `omega_f > 0`, circular frequency below which the ground does not shake (rad per unit of time).
    pub low_cut_frequency: f64,
    /// `zeta_f > 0`, the damping ratio of that.
    pub low_cut_damping: f64,
}

impl<const F: usize> Filter<F> {
    /// `A`.
    #[must_use]
    pub const fn matrix(&self) -> &Matrix<F> {
        &self.matrix
    }

    /// `b`.
    #[must_use]
    pub const fn noise(&self) -> &[f64; F] {
        &self.noise
    }

    /// `c`.
    #[must_use]
    pub const fn output(&self) -> &[f64; F] {
        &self.output
    }

    /// A filter from `A`, `b`, `c` and the shortest period of its modes (time), by which steps are measured.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`]; [`Error::NoStationaryLaw`] for a filter without a stationary state.
    pub fn new(
        matrix: [[f64; F]; F],
        noise: [f64; F],
        output: [f64; F],
        period: f64,
    ) -> Result<Self, Error> {
        for (name, values) in [
            ("matrix of the filter", matrix.as_flattened()),
            ("noise of the filter", &noise),
            ("output of the filter", &output),
        ] {
            for &value in values {
                finite(name, value)?;
            }
        }
        positive("period of the filter", period)?;
        let squares = noise.map(|b_i| noise.map(|b_j| b_i * b_j));
        let stationary_covariance = Transition::stationary("the filter", &matrix, &squares)?;
        Ok(Self { matrix, noise, output, period, stationary_covariance })
    }

    /// The shortest period of its modes (time).
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The covariance of its states under stationary white noise.
    pub fn stationary_covariance(&self) -> &[[f64; F]; F] {
        &self.stationary_covariance
    }

    /// The variance of its output under stationary white noise.
    pub fn output_variance(&self) -> f64 {
        let p = &self.stationary_covariance;
        let row = |i: usize| -> f64 { (0..F).map(|j| p[i][j] * self.output[j]).sum() };
        (0..F).map(|i| self.output[i] * row(i)).sum()
    }
}

impl Filter<2> {
    /// The Kanai-Tajimi filter: states `(x_g, x_g')`,
    ///
    /// $$ \ddot x_g + 2\zeta_g\omega_g\dot x_g + \omega_g^2 x_g = W, \qquad
    ///    u = 2\zeta_g\omega_g\dot x_g + \omega_g^2 x_g . $$
    ///
    /// At low frequencies `u` is the white noise itself. Stationary: `E[x_g^2] = 1/(4 zeta_g omega_g^3)`,
    /// `E[x_g'^2] = 1/(4 zeta_g omega_g)`, uncorrelated.
    ///
    /// Sources: Kanai 1957, Semi-empirical formula for the seismic characteristics of the ground; Tajimi 1960, A
    /// statistical method of determining the maximum response of a building structure during an earthquake.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`], naming the parameter.
    pub fn kanai_tajimi(parameters: KanaiTajimiParameters) -> Result<Self, Error> {
        let (stiffness, damping) = parameters.coefficients()?;
        Self::new(
            [[0.0, 1.0], [-stiffness, -damping]],
            [0.0, 1.0],
            [stiffness, damping],
            std::f64::consts::TAU / parameters.ground_frequency,
        )
    }
}

impl Filter<4> {
    /// The Clough-Penzien filter: states `(x_g, x_g', x_f, x_f')`, the soil of [`Filter::kanai_tajimi`] and behind it
    ///
    /// $$ \ddot x_f + 2\zeta_f\omega_f\dot x_f + \omega_f^2 x_f = 2\zeta_g\omega_g\dot x_g + \omega_g^2 x_g, \qquad
    ///    u = \ddot x_f, $$
    ///
    /// which takes away the low frequencies, at which the ground of Kanai and Tajimi would drift without end.
    ///
    /// Source: Clough and Penzien 1975, Dynamics of structures, section on stochastic modelling of strong ground motion.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`], naming the parameter.
    pub fn clough_penzien(parameters: CloughPenzienParameters) -> Result<Self, Error> {
        let CloughPenzienParameters { soil, low_cut_frequency, low_cut_damping } = parameters;
        let (k, c) = soil.coefficients()?;
        positive("low_cut_frequency", low_cut_frequency)?;
        positive("low_cut_damping", low_cut_damping)?;
        let k_f = low_cut_frequency * low_cut_frequency;
        let c_f = 2.0 * low_cut_damping * low_cut_frequency;
        let output = [k, c, -k_f, -c_f];
        Self::new(
            [[0.0, 1.0, 0.0, 0.0], [-k, -c, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], output],
            [0.0, 1.0, 0.0, 0.0],
            output,
            std::f64::consts::TAU / soil.ground_frequency.max(low_cut_frequency),
        )
    }
}

/// A filter of any number of states, none by default: then white noise is the ground acceleration itself.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GroundMotion {
    /// Row by row.
    matrix: Vec<Vec<f64>>,
    pub(crate) noise: Vec<f64>,
    pub(crate) output: Vec<f64>,
    pub(crate) period: f64,
}

impl Default for GroundMotion {
    fn default() -> Self {
        let (matrix, noise, output) = (Vec::new(), Vec::new(), Vec::new());
        Self { matrix, noise, output, period: f64::INFINITY }
    }
}

impl GroundMotion {
    pub(crate) fn of<const F: usize>(filter: &Filter<F>) -> Self {
        let &Filter { matrix, noise, output, period, .. } = filter;
        let matrix = matrix.iter().map(|row| row.to_vec()).collect();
        Self { matrix, noise: noise.to_vec(), output: output.to_vec(), period }
    }

    pub(crate) fn n_states(&self) -> usize {
        self.noise.len()
    }

    /// The entries of its matrix: row, column, value.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let row = |(i, row): (usize, &Vec<f64>)| -> Vec<(usize, usize, f64)> {
            row.iter().enumerate().map(|(j, value)| (i, j, *value)).collect()
        };
        self.matrix.iter().enumerate().flat_map(row)
    }

    /// Writes the rates of its states for `L` paths.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    pub(crate) fn drift<const L: usize>(&self, y: &[[f64; L]], drift: &mut [[f64; L]]) {
        for (rates, row) in drift.iter_mut().zip(&self.matrix) {
            *rates = dot(row, y);
        }
    }

    /// Its output for `L` paths, zero without a filter.
    #[allow(clippy::inline_always, reason = "used in a dispatched function")]
    #[inline(always)]
    pub(crate) fn output<const L: usize>(&self, y: &[[f64; L]]) -> [f64; L] {
        dot(&self.output, y)
    }
}

/// The weighted sum of the states of `L` paths.
#[allow(clippy::inline_always, reason = "used in a dispatched function")]
#[inline(always)]
fn dot<const L: usize>(row: &[f64], y: &[[f64; L]]) -> [f64; L] {
    let mut sum = [0.0; L];
    for (coefficient, y) in row.iter().zip(y) {
        for lane in 0..L {
            sum[lane] += coefficient * y[lane];
        }
    }
    sum
}

impl KanaiTajimiParameters {
    /// `omega_g^2` and `2 zeta_g omega_g`.
    fn coefficients(&self) -> Result<(f64, f64), Error> {
        let Self { ground_frequency, ground_damping } = *self;
        positive("ground_frequency", ground_frequency)?;
        positive("ground_damping", ground_damping)?;
        Ok((ground_frequency * ground_frequency, 2.0 * ground_damping * ground_frequency))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOIL: KanaiTajimiParameters =
        KanaiTajimiParameters { ground_frequency: 15.6, ground_damping: 0.6 };

    #[test]
    fn the_stationary_law_of_kanai_and_tajimi_is_that_of_their_oscillator() {
        let filter = Filter::kanai_tajimi(SOIL).unwrap();
        let p = filter.stationary_covariance();
        let (w, zeta) = (15.6_f64, 0.6);
        assert!((p[0][0] * 4.0 * zeta * w.powi(3) - 1.0).abs() < 1e-12);
        assert!((p[1][1] * 4.0 * zeta * w - 1.0).abs() < 1e-12);
        assert!(p[0][1].abs() < 1e-15);
        // E[u^2] = omega_g (1 + 4 zeta_g^2)/(4 zeta_g), from the two variances.
        let expected = w * (1.0 + 4.0 * zeta * zeta) / (4.0 * zeta);
        assert!((filter.output_variance() / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_spectrum_of_clough_and_penzien_integrates_to_its_variance() {
        // E[u^2] = integral of |H_g H_f|^2 dw/(2 pi), both factors in closed form; midpoint rule to w = 2000,
        // beyond which the integrand falls as (2 zeta_g w_g/w)^2: the rest is (2 zeta_g w_g)^2/(2000 pi).
        let parameters =
            CloughPenzienParameters { soil: SOIL, low_cut_frequency: 1.56, low_cut_damping: 0.6 };
        let filter = Filter::clough_penzien(parameters).unwrap();
        let part = |w: f64, w_0: f64, zeta: f64| {
            let (r, d) = (w_0 * w_0, 2.0 * zeta * w_0 * w);
            (r, d, (r - w * w).powi(2) + d * d)
        };
        let spectrum = |w: f64| {
            let (r, d, below) = part(w, 15.6, 0.6);
            let (_, _, below_f) = part(w, 1.56, 0.6);
            (r * r + d * d) / below * w.powi(4) / below_f
        };
        let (n, end) = (400_000, 2_000.0);
        let step = end / f64::from(n);
        let sum: f64 = (0..n).map(|k| spectrum((f64::from(k) + 0.5) * step)).sum();
        let rest = (2.0_f64 * 0.6 * 15.6).powi(2) / (end * std::f64::consts::PI);
        let expected = sum * step / std::f64::consts::PI + rest;
        let error = (filter.output_variance() / expected - 1.0).abs();
        assert!(error < 1e-5, "{error:e}");
    }

    #[test]
    fn soil_without_damping_is_refused() {
        let soil = KanaiTajimiParameters { ground_damping: 0.0, ..SOIL };
        let message = Filter::kanai_tajimi(soil).unwrap_err().to_string();
        assert_eq!(message, "ground_damping is 0; it must be greater than 0");
    }
}
