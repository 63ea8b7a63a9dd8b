//! Correlation functions of the distance, with a physical length.

use smoothing_kernels::{Kernel, WendlandC2};

use crate::correlations::matern::{integral_scale, matern};
use crate::error::{Error, between, positive};

/// Smoothness of Matérn's function.
const SMOOTHNESS: (f64, f64) = (0.05, 20.0);

/// The shape of a correlation function, with the correlation length `l` as unit.
///
/// | function | correlation at the distance `r` | derivatives of a realisation |
/// |---|---|---|
/// | exponential | $e^{-r/l}$ | none: continuous |
/// | Matern 3/2 | $(1 + 2r/l) e^{-2r/l}$ | one |
/// | Matern 5/2 | $(1 + x + x^2/3) e^{-x}$ with $x = 8r/(3l)$ | two |
/// | Matern $\nu$ | $2^{1-\nu} x^\nu K_\nu(x)/\Gamma(\nu)$ with $x = \sqrt\pi \Gamma(\nu + 1/2)/\Gamma(\nu) \cdot r/l$ | the largest integer below $\nu$ |
/// | Wendland C2 | $(1 - x)^4 (1 + 4x)$ with $x = r/(3l)$, zero beyond $3l$ | one |
/// | Gaussian (squared exponential) | $e^{-\pi r^2/(4 l^2)}$ | all |
///
/// All are positive definite in one to three dimensions: any set of different points has a positive definite matrix.
/// That of the Gaussian is so only just: beyond about three spacings per length its smallest eigenvalues are roundoff.
///
/// The Bessel function of Matérn's function is computed here, within 1e-13, by the trapezoidal rule for an integral that it has:
/// some 60 exponentials a value. Half-integers have closed forms.
///
/// Sources: Matern 1960, Spatial variation; Rasmussen and Williams 2006, eq 4.9, 4.14, 4.17 and 4.18; Wendland 1995, with the
/// exponent of three dimensions, which serves in fewer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum CorrelationFunction {
    /// That of an Ornstein-Uhlenbeck path.
    Exponential,
    /// The squared exponential.
    Gaussian,
    /// Matérn's function of smoothness 3/2.
    Matern32,
    /// Matérn's function of smoothness 5/2.
    Matern52,
    /// Matérn's function of any smoothness.
    Matern {
        /// `nu`, from 0.05 to 20 (no unit).
        smoothness: f64,
    },
    /// Wendland's function C2: zero beyond three lengths.
    WendlandC2,
}

impl CorrelationFunction {
    /// All functions, Matérn's general one at smoothness 0.8, for tests and tables.
    pub const ALL: [Self; 6] = [
        Self::Exponential,
        Self::Gaussian,
        Self::Matern32,
        Self::Matern52,
        Self::Matern { smoothness: 0.8 },
        Self::WendlandC2,
    ];

    /// The correlation at `q = r/l >= 0`.
    pub(crate) fn at(self, q: f64) -> f64 {
        match self {
            Self::Exponential => simd_lanes::exp(-q),
            Self::Gaussian => simd_lanes::exp(-std::f64::consts::FRAC_PI_4 * q * q),
            Self::Matern32 => (1.0 + 2.0 * q) * simd_lanes::exp(-2.0 * q),
            Self::Matern52 => {
                let x = 8.0 / 3.0 * q;
                (1.0 + x + x * x / 3.0) * simd_lanes::exp(-x)
            }
            Self::Matern { smoothness } => matern(smoothness, integral_scale(smoothness) * q),
            // The kernel ends at two smoothing lengths, the correlation at three of its own.
            Self::WendlandC2 => Kernel::<3>::shape(&WendlandC2, q / 1.5),
        }
    }

    pub(crate) fn check(self) -> Result<(), Error> {
        match self {
            Self::Matern { smoothness } => {
                between("smoothness of the correlation", smoothness, SMOOTHNESS.0, SMOOTHNESS.1)
            }
            _ => Ok(()),
        }
    }
}

/// An isotropic correlation `rho(r)` with its length.
///
/// The correlation length is the integral scale, for every function the same:
///
/// $$ l = \int_0^\infty \rho(r) dr , $$
///
/// half of Vanmarcke's scale of fluctuation. Other parameters are converted: $e^{-r^2/a^2}$ is the Gaussian with
/// $l = a \sqrt{\pi}/2$; $(1 + \sqrt3 r/a) e^{-\sqrt3 r/a}$ is Matérn's with $l = 2a/\sqrt3$.
///
/// Source: Vanmarcke 1983, Random fields, section 5.1.
///
/// ```
/// use random_fields::{Correlation, CorrelationFunction};
///
/// // At 2 mm, with a length of 1 mm: exp(-2).
/// let correlation = Correlation { function: CorrelationFunction::Exponential, length: 1e-3 };
/// assert!((correlation.at(2e-3) - 0.1353352832366127).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correlation {
    /// Its shape.
    pub function: CorrelationFunction,
    /// The integral scale `l` (length).
    pub length: f64,
}

impl Correlation {
    /// The correlation at a distance `r >= 0` (length): one at 0.
    #[must_use]
    pub fn at(&self, distance: f64) -> f64 {
        self.function.at(distance / self.length)
    }

    /// The correlation of two points (lengths).
    #[must_use]
    pub fn between<const D: usize>(&self, a: &[f64; D], b: &[f64; D]) -> f64 {
        const { assert!(D >= 1 && D <= 3, "not all of the functions are positive definite beyond") };
        self.at(distance(a, b))
    }

    /// Checks the length and the smoothness.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the length, [`Error::OutOfRange`] for the smoothness.
    pub fn check(&self) -> Result<(), Error> {
        self.function.check()?;
        positive("correlation length", self.length)
    }
}

pub(crate) fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;
    use crate::pivoted_cholesky::{Enough, pivoted_cholesky};

    #[test]
    fn length_is_the_integral_of_every_function() {
        for function in CorrelationFunction::ALL {
            let correlation = Correlation { function, length: 0.7 };
            // Simpson's rule up to 40 lengths, where exp(-40) = 4e-18 is left; the error of the rule is about h^4/180, of
            // Matern's function of smoothness 0.8, whose derivative is infinite at 0, about h^2.6.
            let limit =
                if matches!(function, CorrelationFunction::Matern { .. }) { 1e-7 } else { 1e-12 };
            let n = 40_000;
            let h = 40.0 * 0.7 / f64::from(n);
            let weight = |k: i32| if k == 0 || k == n { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
            let sum: f64 = (0..=n).map(|k| weight(k) * correlation.at(h * f64::from(k))).sum();
            assert!((sum * h / 3.0 - 0.7).abs() < limit, "{function:?}: {}", sum * h / 3.0);
        }
    }

    #[test]
    fn function_is_one_at_zero_and_falls() {
        for function in CorrelationFunction::ALL {
            let correlation = Correlation { function, length: 2.0 };
            assert!((correlation.at(0.0) - 1.0).abs() < 1e-15, "{function:?}");
            let values: Vec<f64> = (0..50).map(|k| correlation.at(0.1 * f64::from(k))).collect();
            assert!(values.windows(2).all(|pair| pair[1] < pair[0]), "{function:?}");
        }
    }

    fn matrix_is_positive_definite<const D: usize>(correlation: Correlation, per_axis: usize) {
        let n = per_axis.pow(u32::try_from(D).unwrap());
        let place = |i: usize| -> [f64; D] {
            let mut rest = i;
            std::array::from_fn(|_| {
                let along = rest % per_axis;
                rest /= per_axis;
                along as f64
            })
        };
        let entry = |i, j| correlation.between(&place(i), &place(j));
        let found = pivoted_cholesky(n, entry, Enough::Trace(0.0)).unwrap();
        assert_eq!(found.pivots.len(), n, "{correlation:?} in {D} dimensions");
    }

    #[test]
    fn matrix_of_a_lattice_is_positive_definite_in_one_to_three_dimensions() {
        for function in CorrelationFunction::ALL {
            let correlation = Correlation { function, length: 1.5 };
            matrix_is_positive_definite::<1>(correlation, 100);
            matrix_is_positive_definite::<2>(correlation, 12);
            matrix_is_positive_definite::<3>(correlation, 6);
        }
    }
}
