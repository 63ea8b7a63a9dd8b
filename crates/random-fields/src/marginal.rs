//! Distributions of a field at one point, and the correlation that their translation keeps.

use sde_integrators::normal_probability;
use simd_lanes::{exp, power};

use crate::error::{Error, between, finite, positive};

/// Largest probability of a negative value of a normal field of a positive quantity: mean at 7.9 standard deviations.
const MOST_BELOW_ZERO: f64 = 1e-15;
/// Largest size of the normal of a measured value.
const FARTHEST: f64 = 8.0;
/// Exponents of Weibull's distribution, from a scatter of 16 times the mean to one of a thousandth.
const WEIBULL_SHAPES: (f64, f64) = (0.2, 1000.0);

/// The distribution of a field at one point, as an increasing function of a standard normal `z`: a translation.
///
/// $$ x = F^{-1}(\Phi(z)) $$
///
/// | distribution | value at `z` |
/// |---|---|
/// | lognormal | $m e^{s z - s^2/2}$ with $s^2 = \ln(1 + v^2)$, mean `m`, coefficient of variation `v` |
/// | Weibull | $b (-\ln(1 - \Phi(z)))^{1/k}$ with $b = m/\Gamma(1 + 1/k)$, mean `m`, shape `k` |
/// | normal | $m + s z$ |
/// | uniform | $a + (b - a) \Phi(z)$ |
///
/// Source: Grigoriu 1984, Crossings of non-Gaussian translation processes; Grigoriu 1995, section 3.1.
///
/// ```
/// use random_fields::Marginal;
///
/// let strength = Marginal::Lognormal { mean: 23.0, coefficient_of_variation: 0.3 };
/// // Two points whose normals have the correlation 0.5: (exp(s^2/2) - 1)/(exp(s^2) - 1) = 0.4892, and back.
/// let translated = strength.translated_correlation(0.5)?;
/// assert!((translated - 0.489229).abs() < 1e-6);
/// assert!((strength.normal_correlation(translated)? - 0.5).abs() < 1e-14);
/// # Ok::<(), random_fields::Error>(())
/// ```
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
    /// The distribution of the weakest of many.
    Weibull {
        /// The mean of the value itself.
        mean: f64,
        /// Weibull's modulus, from 0.2 to 1000.
        shape: f64,
    },
    /// Normal.
    Normal {
        /// The mean.
        mean: f64,
        /// The standard deviation.
        standard_deviation: f64,
    },
    /// Uniform.
    Uniform {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
}

impl Marginal {
    /// Weibull's distribution of a mean and a coefficient of variation. Its shape is the root of
    ///
    /// $$ 1 + v^2 = \Gamma(1 + 2/k)/\Gamma(1 + 1/k)^2 , $$
    ///
    /// found by bisection to the last bits.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the mean, [`Error::OutOfRange`] for a coefficient of variation outside 0.001284 to 15.84,
    /// those of the shapes 1000 and 0.2.
    pub fn weibull(mean: f64, coefficient_of_variation: f64) -> Result<Self, Error> {
        positive("mean of the field", mean)?;
        let variation = |shape: f64| Self::Weibull { mean: 1.0, shape }.standard_deviation();
        let (mut low, mut high) = WEIBULL_SHAPES;
        let name = "coefficient of variation of a Weibull field";
        between(name, coefficient_of_variation, variation(high), variation(low))?;
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if variation(middle) > coefficient_of_variation {
                low = middle;
            } else {
                high = middle;
            }
        }
        Ok(Self::Weibull { mean, shape: 0.5 * (low + high) })
    }

    /// Checks its parameters.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`], [`Error::OutOfRange`] for a shape, [`Error::EmptyInterval`].
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            Self::Lognormal { mean, coefficient_of_variation } => {
                positive("mean of the field", mean)?;
                positive("coefficient of variation of the field", coefficient_of_variation)
            }
            Self::Weibull { mean, shape } => {
                positive("mean of the field", mean)?;
                let (from, to) = WEIBULL_SHAPES;
                between("shape of the Weibull distribution", shape, from, to)
            }
            Self::Normal { mean, standard_deviation } => {
                finite("mean of the field", mean)?;
                positive("standard deviation of the field", standard_deviation)
            }
            Self::Uniform { low, high } => {
                finite("lower end of the field", low)?;
                finite("upper end of the field", high)?;
                if low < high {
                    return Ok(());
                }
                Err(Error::EmptyInterval {
                    name: "the uniform distribution of the field",
                    low,
                    high,
                })
            }
        }
    }

    /// Checks it as that of a positive quantity, such as a stiffness or a strength: a normal one may lie below zero with a
    /// probability of at most 1e-15 at one point, so its mean must be 7.9 standard deviations or more.
    ///
    /// # Errors
    /// Those of [`Marginal::check`]; [`Error::NegativeField`], [`Error::UniformBelowZero`].
    pub fn check_positive(&self) -> Result<(), Error> {
        self.check()?;
        match *self {
            Self::Normal { mean, standard_deviation } => {
                let (probability, limit) =
                    (normal_probability(-mean / standard_deviation), MOST_BELOW_ZERO);
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
            Self::Uniform { low, .. } if low <= 0.0 => Err(Error::UniformBelowZero { low }),
            _ => Ok(()),
        }
    }

    /// Its mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        match *self {
            Self::Lognormal { mean, .. }
            | Self::Weibull { mean, .. }
            | Self::Normal { mean, .. } => mean,
            Self::Uniform { low, high } => 0.5 * (low + high),
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
            Self::Uniform { low, high } => (high - low) / 12.0_f64.sqrt(),
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
            Self::Uniform { low, high } => low + (high - low) * normal_probability(z),
        }
    }

    /// The standard normal `z` of a value `x`: the inverse of [`Marginal::at`], for measured values. In closed form for a normal and
    /// a lognormal distribution, else by bisection to the last bits of `x`.
    ///
    /// # Errors
    /// Those of [`Marginal::check`]; [`Error::OutOfRange`] for a value that the distribution does not have between -8 and 8
    /// standard deviations of `z`.
    pub fn normal_score(&self, x: f64) -> Result<f64, Error> {
        self.check()?;
        let (mut low, mut high) = (-FARTHEST, FARTHEST);
        let name = "the value of a measurement";
        between(name, x, self.at(low), self.at(high))?;
        match *self {
            Self::Normal { mean, standard_deviation } => return Ok((x - mean) / standard_deviation),
            Self::Lognormal { mean, coefficient_of_variation: v } => {
                let square = libm::log1p(v * v);
                return Ok((libm::log(x / mean) + 0.5 * square) / square.sqrt());
            }
            Self::Weibull { .. } | Self::Uniform { .. } => {}
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.at(middle) < x {
                low = middle;
            } else {
                high = middle;
            }
        }
        Ok(0.5 * (low + high))
    }

    /// The derivative of [`Marginal::at`] at `z`: with the modes of a field it gives the gradient of a value with respect to
    /// all coefficients.
    #[must_use]
    pub fn derivative(&self, z: f64) -> f64 {
        match *self {
            Self::Lognormal { coefficient_of_variation: v, .. } => {
                libm::log1p(v * v).sqrt() * self.at(z)
            }
            Self::Weibull { shape, .. } => {
                // d/dz of -ln(1 - Phi) is phi/(1 - Phi).
                let exponent = exceedance_exponent(z);
                self.at(z) * density(z) / (shape * exponent * normal_probability(-z))
            }
            Self::Normal { standard_deviation, .. } => standard_deviation,
            Self::Uniform { low, high } => (high - low) * density(z),
        }
    }

    /// The correlation of two values whose `z` have the correlation `rho`, from -1 to 1.
    ///
    /// Its size is at most that of `z`. Closed forms:
    ///
    /// $$ \frac{e^{s^2 \rho} - 1}{e^{s^2} - 1} \quad \text{(lognormal)}, \qquad \rho \quad \text{(normal)}, \qquad
    /// \frac{6}{\pi} \arcsin \frac{\rho}{2} \quad \text{(uniform)} . $$
    ///
    /// Weibull's by Mehler's series in Hermite polynomials
    /// $\sum_k a_k^2 \rho^k / \sum_k a_k^2$ with $a_k = \int x He_k \phi dz / \sqrt{k!}$, of 40 terms, within 1e-12 for
    /// all shapes. Between -0.3 and 1, and for a scatter up to 30 %, lognormal and Weibull differ from `rho` by less than 0.02.
    ///
    /// Source: Grigoriu 1995, Applied non-Gaussian processes, section 3.1; Liu and Der Kiureghian 1986, tables 5 and 6.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for the correlation; those of [`Marginal::check`].
    pub fn translated_correlation(&self, rho: f64) -> Result<f64, Error> {
        self.check()?;
        within_one("correlation of two normals", rho)?;
        Ok(self.translated(&self.series(), rho))
    }

    /// The correlation of the normals for a correlation `rho` of the values: the inverse of
    /// [`Marginal::translated_correlation`], for Weibull's distribution by bisection to the last bits.
    ///
    /// # Errors
    /// [`Error::CorrelationBelowLeast`] for a correlation that no normals give: for a lognormal distribution $-1/(1 + v^2)$ is
    /// the least; [`Error::OutOfRange`] for one outside -1 to 1; those of [`Marginal::check`].
    pub fn normal_correlation(&self, rho: f64) -> Result<f64, Error> {
        self.check()?;
        within_one("correlation of two values", rho)?;
        let series = self.series();
        let limit = self.translated(&series, -1.0);
        // The least itself is possible; it may be off by roundoff.
        if rho < limit - 1e-12 {
            return Err(Error::CorrelationBelowLeast { value: rho, limit });
        }
        let rho = rho.max(limit);
        Ok(match *self {
            Self::Lognormal { coefficient_of_variation: v, .. } => {
                libm::log1p(rho * v * v) / libm::log1p(v * v)
            }
            Self::Normal { .. } => rho,
            Self::Uniform { .. } => 2.0 * libm::sin(std::f64::consts::FRAC_PI_6 * rho),
            Self::Weibull { .. } => {
                let (mut low, mut high) = (-1.0, 1.0);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if self.translated(&series, middle) < rho {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                0.5 * (low + high)
            }
        })
    }

    /// `a_k^2` of Mehler's series; empty where the correlation has a closed form.
    fn series(&self) -> Vec<f64> {
        match self {
            Self::Weibull { .. } => self.hermite_coefficients().iter().map(|a| a * a).collect(),
            _ => vec![],
        }
    }

    fn translated(&self, series: &[f64], rho: f64) -> f64 {
        match *self {
            Self::Lognormal { coefficient_of_variation: v, .. } => {
                libm::expm1(libm::log1p(v * v) * rho) / (v * v)
            }
            Self::Weibull { .. } => {
                let sum =
                    |rho: f64| series.iter().rev().fold(0.0, |sum, square| (sum + square) * rho);
                sum(rho) / sum(1.0)
            }
            Self::Normal { .. } => rho,
            Self::Uniform { .. } => 6.0 / std::f64::consts::PI * libm::asin(0.5 * rho),
        }
    }

    /// `E[x(z) He_k(z)] / sqrt(k!)` for `k` from 1 on, by the trapezoidal rule.
    fn hermite_coefficients(&self) -> [f64; 40] {
        const STEP: f64 = 1.0 / 32.0;
        let mut coefficients = [0.0; 40];
        for point in -320..=320 {
            let z = STEP * f64::from(point);
            let weight = STEP * density(z) * self.at(z);
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

fn within_one(name: &'static str, value: f64) -> Result<(), Error> {
    if (-1.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(Error::OutOfRange { name, value, from: -1.0, to: 1.0 })
    }
}

/// `phi(z)`.
fn density(z: f64) -> f64 {
    exp(-0.5 * z * z) / (2.0 * std::f64::consts::PI).sqrt()
}

/// `-ln(1 - Phi(z))`, without loss in either tail.
fn exceedance_exponent(z: f64) -> f64 {
    if z < 0.0 { -libm::log1p(-normal_probability(z)) } else { -libm::log(normal_probability(-z)) }
}
