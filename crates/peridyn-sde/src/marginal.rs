//! The law of a strength or a stiffness at one place.

use std::f64::consts::FRAC_1_SQRT_2;

use lanes::{exp, power};

use crate::error::{Error, between, finite, positive};

/// How probable a negative value of a normal field may be: mean at 7.9 standard deviations.
const MOST_BELOW_ZERO: f64 = 1e-15;
/// Exponents of Weibull's law, from a scatter of 1e5 of the mean to one of a thousandth.
const WEIBULL_SHAPES: (f64, f64) = (0.2, 1000.0);

/// The law of something positive at one place, as a function of a standard normal `z`.
///
/// | law | value at `z` |
/// |---|---|
/// | lognormal | $m e^{s z - s^2/2}$ with $s^2 = \ln(1 + v^2)$, mean `m`, coefficient of variation `v` |
/// | Weibull | $b (-\ln(1 - \Phi(z)))^{1/k}$ with $b = m/\Gamma(1 + 1/k)$, mean `m`, shape `k` |
/// | normal | $m + s z$ |
///
/// A normal law reaches below zero. It is refused where that is more probable than 1e-15 at one place: the mean must be 7.9
/// standard deviations or more.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Marginal {
    /// The logarithm is normal.
    Lognormal {
        /// The mean of the value itself.
        mean: f64,
        /// Standard deviation over mean.
        coefficient_of_variation: f64,
    },
    /// The law of the weakest of many.
    Weibull {
        /// The mean of the value itself.
        mean: f64,
        /// Weibull's modulus, from 0.2 to 1000.
        shape: f64,
    },
    /// Normal, with its mean far from zero.
    Normal {
        /// The mean.
        mean: f64,
        /// The standard deviation.
        standard_deviation: f64,
    },
}

impl Marginal {
    /// Whether its parameters can be.
    ///
    /// # Errors
    /// [`Error::NotPositive`], [`Error::OutOfRange`] for a shape, [`Error::NegativeField`] for a normal law too near to zero.
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            Self::Lognormal { mean, coefficient_of_variation } => {
                positive("mean of the field", mean)?;
                positive("coefficient of variation of the field", coefficient_of_variation)
            }
            Self::Weibull { mean, shape } => {
                positive("mean of the field", mean)?;
                let (from, to) = WEIBULL_SHAPES;
                between("shape of the Weibull law", shape, from, to)
            }
            Self::Normal { mean, standard_deviation } => {
                finite("mean of the field", mean)?;
                positive("standard deviation of the field", standard_deviation)?;
                let (probability, limit) = (below(-mean / standard_deviation), MOST_BELOW_ZERO);
                if probability > limit {
                    return Err(Error::NegativeField {
                        mean,
                        standard_deviation,
                        probability,
                        limit,
                    });
                }
                Ok(())
            }
        }
    }

    /// Its mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        match *self {
            Self::Lognormal { mean, .. }
            | Self::Weibull { mean, .. }
            | Self::Normal { mean, .. } => mean,
        }
    }

    /// Its standard deviation.
    #[must_use]
    pub fn standard_deviation(&self) -> f64 {
        match *self {
            Self::Lognormal { mean, coefficient_of_variation } => mean * coefficient_of_variation,
            Self::Weibull { mean, shape } => {
                let logarithm =
                    libm::lgamma(1.0 + 2.0 / shape) - 2.0 * libm::lgamma(1.0 + 1.0 / shape);
                mean * libm::expm1(logarithm).sqrt()
            }
            Self::Normal { standard_deviation, .. } => standard_deviation,
        }
    }

    /// The value whose probability to lie below is that of a standard normal `z`.
    #[must_use]
    pub fn at(&self, z: f64) -> f64 {
        match *self {
            Self::Lognormal { mean, coefficient_of_variation: v } => {
                let square = libm::log1p(v * v);
                mean * exp(square.sqrt() * z - 0.5 * square)
            }
            Self::Weibull { mean, shape } => {
                let scale = mean / libm::tgamma(1.0 + 1.0 / shape);
                scale * power(exceedance_exponent(z), 1.0 / shape)
            }
            Self::Normal { mean, standard_deviation } => mean + standard_deviation * z,
        }
    }

    /// The correlation of two values whose `z` have the correlation `rho`, from -1 to 1.
    ///
    /// It is below that of `z`: for a lognormal law
    ///
    /// $$ \frac{e^{s^2 \rho} - 1}{e^{s^2} - 1} , $$
    ///
    /// for a normal law the same, and for Weibull's by the series in Hermite polynomials
    /// $\sum_k a_k^2 \rho^k / \sum_k a_k^2$ with $a_k = \int x He_k \phi dz / \sqrt{k!}$, to an error of about 1e-6 for shapes from 1
    /// on. Between -0.3 and 1, and for a scatter up to 30 %, all three laws differ from `rho` by less than 0.02.
    ///
    /// Source: Grigoriu 1995, Applied non-Gaussian processes, section 3.1; Liu and Der Kiureghian 1986, table 5 and 6.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for the correlation; those of [`Marginal::check`].
    pub fn correlation(&self, rho: f64) -> Result<f64, Error> {
        self.check()?;
        if !(-1.0..=1.0).contains(&rho) {
            let name = "correlation of two normals";
            return Err(Error::OutOfRange { name, value: rho, from: -1.0, to: 1.0 });
        }
        Ok(match *self {
            Self::Lognormal { coefficient_of_variation: v, .. } => {
                libm::expm1(libm::log1p(v * v) * rho) / (v * v)
            }
            Self::Weibull { .. } => {
                let coefficients = self.hermite_coefficients();
                let series =
                    |rho: f64| coefficients.iter().rev().fold(0.0, |sum, a| (sum + a * a) * rho);
                series(rho) / series(1.0)
            }
            Self::Normal { .. } => rho,
        })
    }

    /// `E[x(z) He_k(z)] / sqrt(k!)` for `k` from 1 on, by the trapezoidal rule.
    fn hermite_coefficients(&self) -> [f64; 40] {
        const STEP: f64 = 1.0 / 32.0;
        let mut coefficients = [0.0; 40];
        for point in -320..=320 {
            let z = STEP * f64::from(point);
            let density = exp(-0.5 * z * z) / (2.0 * std::f64::consts::PI).sqrt();
            let weight = STEP * density * self.at(z);
            let (mut before, mut polynomial) = (1.0, z);
            for (coefficient, k) in coefficients.iter_mut().zip(1..) {
                *coefficient += weight * polynomial;
                let k = f64::from(k);
                let next = (z * polynomial - f64::sqrt(k) * before) / f64::sqrt(k + 1.0);
                (before, polynomial) = (polynomial, next);
            }
        }
        coefficients
    }
}

/// `Phi(z)`.
fn below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// `-ln(1 - Phi(z))`, without loss in either tail.
fn exceedance_exponent(z: f64) -> f64 {
    if z < 0.0 { -libm::log1p(-below(z)) } else { -libm::log(below(-z)) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;

    const LAWS: [Marginal; 4] = [
        Marginal::Lognormal { mean: 2.0, coefficient_of_variation: 0.3 },
        Marginal::Weibull { mean: 0.01, shape: 5.0 },
        Marginal::Weibull { mean: 3.0, shape: 1.0 },
        Marginal::Normal { mean: 1.0, standard_deviation: 0.1 },
    ];

    /// `E[g(z)]` by the trapezoidal rule, whose error for these is below 1e-10.
    fn expectation(g: impl Fn(f64) -> f64) -> f64 {
        let weight = |z: f64| f64::exp(-0.5 * z * z) / f64::sqrt(2.0 * std::f64::consts::PI);
        (-600..=600).map(|k| f64::from(k) / 64.0).map(|z| weight(z) * g(z) / 64.0).sum()
    }

    #[test]
    fn mean_and_deviation_are_those_of_the_values() {
        for law in LAWS {
            law.check().unwrap();
            let mean = expectation(|z| law.at(z));
            let variance = expectation(|z| (law.at(z) - mean).powi(2));
            assert!((mean / law.mean() - 1.0).abs() < 1e-9, "{law:?}: {mean}");
            let deviation = variance.sqrt() / law.standard_deviation();
            assert!((deviation - 1.0).abs() < 1e-9, "{law:?}: {deviation}");
        }
    }

    #[test]
    fn weibull_of_shape_one_is_exponential_in_both_tails() {
        let law = Marginal::Weibull { mean: 1.0, shape: 1.0 };
        // Phi(-6) = 9.865876450376946e-10 (Abramowitz and Stegun, table 26.1 gives 9.8659e-10), and -ln(1 - p) = p + p^2/2;
        // above, -ln Phi(-6) = 20.736768903.
        assert!((law.at(-6.0) / 9.865876455243e-10 - 1.0).abs() < 1e-11, "{:e}", law.at(-6.0));
        assert!((law.at(6.0) - 9.865876450376946e-10_f64.ln().abs()).abs() < 1e-12);
        assert!((law.at(0.0) - std::f64::consts::LN_2).abs() < 1e-15);
    }

    #[test]
    fn lognormal_median_is_the_mean_over_the_root_of_one_plus_the_square_of_the_variation() {
        let law = Marginal::Lognormal { mean: 2.0, coefficient_of_variation: 0.75 };
        assert!((law.at(0.0) - 1.6).abs() < 1e-14);
    }

    #[test]
    fn correlation_is_the_covariance_of_two_values_over_their_variance() {
        for law in LAWS {
            for rho in [-0.8, -0.3, 0.2, 0.6, 0.95_f64] {
                let across = (1.0 - rho * rho).sqrt();
                let (mean, variance) = (law.mean(), law.standard_deviation().powi(2));
                let product = |a: f64| expectation(|b| law.at(rho * a + across * b)) * law.at(a);
                let expected = (expectation(product) - mean * mean) / variance;
                let found = law.correlation(rho).unwrap();
                // The series is cut at 40 terms.
                assert!((found - expected).abs() < 1e-6, "{law:?}, {rho}: {found} {expected}");
            }
            assert!((law.correlation(1.0).unwrap() - 1.0).abs() < 1e-14, "{law:?}");
        }
    }

    #[test]
    fn correlation_keeps_near_that_of_the_normal_for_a_scatter_of_thirty_percent() {
        let laws = [LAWS[0], Marginal::Weibull { mean: 1.0, shape: 3.7 }];
        for law in laws {
            assert!((law.standard_deviation() / law.mean() - 0.3).abs() < 0.005);
            for k in -6..=20 {
                let rho = 0.05 * f64::from(k);
                assert!((law.correlation(rho).unwrap() - rho).abs() < 0.02, "{law:?}, {rho}");
            }
        }
    }

    #[test]
    fn normal_law_that_reaches_below_zero_is_refused_with_its_probability() {
        // Phi(-5) = 2.8665e-7 (Abramowitz and Stegun, table 26.2).
        let found = Marginal::Normal { mean: 1.0, standard_deviation: 0.2 }.check();
        let Err(Error::NegativeField { probability, .. }) = found else {
            unreachable!("{found:?}")
        };
        assert!((probability / 2.8665e-7 - 1.0).abs() < 1e-4);
        assert!(Marginal::Normal { mean: 7.9, standard_deviation: 1.0 }.check().is_err());
        assert!(Marginal::Normal { mean: 8.0, standard_deviation: 1.0 }.check().is_ok());
    }

    #[test]
    fn parameters_that_cannot_be_are_refused() {
        let lognormal =
            |mean, coefficient_of_variation| Marginal::Lognormal { mean, coefficient_of_variation };
        for law in [lognormal(0.0, 0.1), lognormal(1.0, -0.1), lognormal(1.0, f64::NAN)] {
            assert!(matches!(law.check(), Err(Error::NotPositive { .. })), "{law:?}");
        }
        let law = Marginal::Weibull { mean: 1.0, shape: 0.1 };
        assert!(matches!(law.check(), Err(Error::OutOfRange { .. })));
    }
}
