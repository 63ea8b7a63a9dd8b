//! Distributions of the initial state.

use std::f64::consts::TAU;

use crate::error::Error;
use crate::noise::cholesky::{SmallPivot, small_cholesky};
use crate::noise::streams::{Noise, Purpose};

/// Distribution of the initial state. Implement it for further distributions; a point `[f64; D]` is one too.
pub trait InitialDistribution<const D: usize>: Sync {
    /// The initial state of a realisation: a pure function of noise and realisation.
    ///
    /// It is drawn from [`Purpose::InitialDistribution`].
    fn sample(&self, noise: &Noise, realisation: u64) -> [f64; D];
}

/// Deterministic start at this point.
impl<const D: usize> InitialDistribution<D> for [f64; D] {
    fn sample(&self, _noise: &Noise, _realisation: u64) -> [f64; D] {
        *self
    }
}

/// One component of a [`GaussianMixture`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussianComponent<const D: usize> {
    /// Its probability, above 0.
    pub weight: f64,
    /// The mean.
    pub mean: [f64; D],
    /// The covariance, symmetric and positive definite.
    pub covariance: [[f64; D]; D],
}

/// A mixture of normal distributions,
///
/// $$ p(x) = \sum_k w_k  \mathcal N(x; \mu_k, C_k), \qquad w_k > 0, \quad \sum_k w_k = 1 . $$
///
/// ```
/// use sde_integrators::GaussianMixture;
///
/// let law = GaussianMixture::independent([0.0, 0.0], [0.1, 0.5])?;
/// let peak = 1.0 / (std::f64::consts::TAU * 0.1 * 0.5);
/// assert!((law.density(&[0.0, 0.0]) - peak).abs() < 1e-14 * peak);
/// # Ok::<(), sde_integrators::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct GaussianMixture<const D: usize> {
    components: Vec<Factored<D>>,
}

/// A validated component.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Factored<const D: usize> {
    component: GaussianComponent<D>,
    /// `L` with `C = L L^T`.
    factor: [[f64; D]; D],
    /// `ln w - sum ln L_ii - D/2 ln 2 pi`, the logarithm of the weighted density at the mean.
    log_peak: f64,
}

impl<const D: usize> GaussianMixture<D> {
    /// Largest admissible deviation of the sum of weights from 1.
    pub const WEIGHT_TOLERANCE: f64 = 1e-12;
    /// Largest admissible difference of `C_ij` and `C_ji`, in units of `sqrt(C_ii C_jj)`.
    pub const SYMMETRY_TOLERANCE: f64 = 1e-12;

    /// A single normal distribution.
    ///
    /// # Errors
    /// Those of [`mixture`](Self::mixture).
    pub fn gaussian(mean: [f64; D], covariance: [[f64; D]; D]) -> Result<Self, Error> {
        Self::mixture(&[GaussianComponent { weight: 1.0, mean, covariance }])
    }

    /// Independent normal components.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for a standard deviation that is not; otherwise as [`mixture`](Self::mixture).
    pub fn independent(mean: [f64; D], standard_deviation: [f64; D]) -> Result<Self, Error> {
        let mut covariance = [[0.0; D]; D];
        for (i, &value) in standard_deviation.iter().enumerate() {
            require_positive("standard deviation", value)?;
            covariance[i][i] = value * value;
        }
        Self::gaussian(mean, covariance)
    }

    /// A mixture of normal distributions.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no components; [`Error::NotPositive`] for a weight; [`Error::NotFinite`] for an entry of
    /// a mean or covariance; [`Error::WeightSum`] if the weights differ from 1 by more than
    /// [`WEIGHT_TOLERANCE`](Self::WEIGHT_TOLERANCE); [`Error::NotSymmetric`] and [`Error::NotPositiveDefinite`] for a
    /// covariance, with the entry or pivot and its limit.
    pub fn mixture(components: &[GaussianComponent<D>]) -> Result<Self, Error> {
        if components.is_empty() {
            return Err(Error::TooFew { quantity: "components of a mixture", value: 0, limit: 1 });
        }
        let components = components
            .iter()
            .enumerate()
            .map(|(index, component)| Factored::new(index, component))
            .collect::<Result<Vec<_>, _>>()?;
        let sum: f64 = components.iter().map(|k| k.component.weight).sum();
        if (sum - 1.0).abs() > Self::WEIGHT_TOLERANCE {
            return Err(Error::WeightSum { sum, tolerance: Self::WEIGHT_TOLERANCE });
        }
        Ok(Self { components })
    }

    /// Components of the mixture.
    pub fn components(&self) -> impl ExactSizeIterator<Item = &GaussianComponent<D>> {
        self.components.iter().map(|k| &k.component)
    }

    /// `p(x)`; relative error about `eps (1 + |ln p|)`.
    #[must_use]
    pub fn density(&self, x: &[f64; D]) -> f64 {
        self.log_density(x).exp()
    }

    /// `ln p(x)`, finite unless the squared distance to the means, in standard deviations, overflows.
    #[must_use]
    pub fn log_density(&self, x: &[f64; D]) -> f64 {
        let largest =
            self.components.iter().map(|k| k.log_density(x)).fold(f64::NEG_INFINITY, f64::max);
        if largest.is_infinite() {
            // Infinitely far from every mean, or NaN.
            return self.components.iter().map(|k| k.log_density(x)).sum();
        }
        let sum: f64 = self.components.iter().map(|k| (k.log_density(x) - largest).exp()).sum();
        largest + sum.ln()
    }

    /// Mean of the mixture.
    #[must_use]
    pub fn mean(&self) -> [f64; D] {
        let mut mean = [0.0; D];
        for GaussianComponent { weight, mean: part, .. } in self.components() {
            for (value, part) in mean.iter_mut().zip(part) {
                *value += weight * part;
            }
        }
        mean
    }

    /// Covariance of the mixture: within the components and between their means.
    #[must_use]
    pub fn covariance(&self) -> [[f64; D]; D] {
        let centre = self.mean();
        let mut covariance = [[0.0; D]; D];
        for GaussianComponent { weight, mean, covariance: within } in self.components() {
            for i in 0..D {
                for j in 0..D {
                    let between = (mean[i] - centre[i]) * (mean[j] - centre[j]);
                    covariance[i][j] += weight * (within[i][j] + between);
                }
            }
        }
        covariance
    }

    /// The initial state of a realisation. It takes `2 + 4 ceil(D/2)` words, whichever component is drawn.
    #[must_use]
    pub fn sample(&self, noise: &Noise, realisation: u64) -> [f64; D] {
        let mut stream = noise.stream(Purpose::InitialDistribution, realisation);
        let mut uniform = stream.next_uniform();
        let last = self.components.len() - 1;
        let mut chosen = 0;
        while chosen < last && uniform >= self.components[chosen].component.weight {
            uniform -= self.components[chosen].component.weight;
            chosen += 1;
        }
        let Factored { component, factor, .. } = &self.components[chosen];
        let mut normals = [0.0; D];
        stream.fill_normal(&mut normals);
        let mut x = component.mean;
        for (value, row) in x.iter_mut().zip(factor) {
            *value += row.iter().zip(&normals).map(|(l, z)| l * z).sum::<f64>();
        }
        x
    }
}

impl<const D: usize> InitialDistribution<D> for GaussianMixture<D> {
    fn sample(&self, noise: &Noise, realisation: u64) -> [f64; D] {
        self.sample(noise, realisation)
    }
}

impl<const D: usize> Factored<D> {
    fn new(index: usize, component: &GaussianComponent<D>) -> Result<Self, Error> {
        let GaussianComponent { weight, mean, covariance } = component;
        require_positive("weight of a component", *weight)?;
        for (quantity, values) in std::iter::once(("mean of component", mean))
            .chain(covariance.iter().map(|row| ("covariance of component", row)))
        {
            if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
                return Err(Error::NotFinite { quantity, index, value });
            }
        }
        require_symmetric(index, covariance)?;
        let least = D as f64 * f64::EPSILON;
        let factor = small_cholesky(covariance, least).map_err(|small| {
            let SmallPivot { row, value: pivot, limit } = small;
            Error::NotPositiveDefinite { component: index, row, pivot, limit }
        })?;
        let log_determinant: f64 = (0..D).map(|i| factor[i][i].ln()).sum();
        let log_peak = weight.ln() - log_determinant - 0.5 * D as f64 * TAU.ln();
        Ok(Self { component: *component, factor, log_peak })
    }

    fn log_density(&self, x: &[f64; D]) -> f64 {
        let mut difference = *x;
        for (value, mean) in difference.iter_mut().zip(&self.component.mean) {
            *value -= mean;
        }
        // L^-1 (x - mean)
        let (l, mut whitened) = (&self.factor, difference);
        for row in 0..D {
            let known: f64 = (0..row).map(|k| l[row][k] * whitened[k]).sum();
            whitened[row] = (difference[row] - known) / l[row][row];
        }
        self.log_peak - 0.5 * whitened.iter().map(|y| y * y).sum::<f64>()
    }
}

fn require_positive(quantity: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::NotPositive { quantity, value })
    }
}

fn require_symmetric<const D: usize>(component: usize, a: &[[f64; D]; D]) -> Result<(), Error> {
    for row in 0..D {
        for column in 0..row {
            let difference = (a[row][column] - a[column][row]).abs();
            let scale = a[row][row].abs().sqrt() * a[column][column].abs().sqrt();
            let limit = GaussianMixture::<D>::SYMMETRY_TOLERANCE * scale;
            if difference > limit {
                return Err(Error::NotSymmetric { component, row, column, difference, limit });
            }
        }
    }
    Ok(())
}
