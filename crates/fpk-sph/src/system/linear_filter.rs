//! A linear filter of any number of states, and the moments of these states given those of the structure.

use crate::cloud::metric::Whitening;
use crate::error::Error;
use vibrating_systems::matrix::Matrix;
use vibrating_systems::{Filter, Window};

/// States of a filter at most: a state has six, of which the structure has one at least.
pub(crate) const MOST_FILTER_STATES: usize = 5;

/// A square matrix of the filter's states; entries beyond their number are zero.
pub(crate) type FilterMatrix = Matrix<MOST_FILTER_STATES>;

/// A vector of the filter's states; entries beyond their number are zero.
pub(crate) type FilterVector = [f64; MOST_FILTER_STATES];

/// `dY = A Y dt + b w(t) dB`, `u = c . Y`, whatever the number of states.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LinearFilter {
    pub(crate) n_states: usize,
    matrix: FilterMatrix,
    noise: FilterVector,
    output: FilterVector,
    window: Window,
    /// A bound of the rates of the filter (1 per unit of time): the norm of Frobenius of `A` in coordinates in which the
    /// stationary covariance is the unit matrix.
    pub(crate) fastest: f64,
}

/// Moments of the filter's states: means given the structure's states at every particle, and the covariance of all.
#[derive(Debug, PartialEq)]
pub(crate) struct FilterMoments {
    /// `m_i`, particle by particle.
    pub(crate) means: Vec<f64>,
    /// `P`.
    pub(crate) covariance: FilterMatrix,
}

/// Roundoff of a difference of two covariances, over the greater.
const ROUNDOFF: f64 = 1e-12;

impl LinearFilter {
    /// A filter behind which white noise has the window `w`.
    ///
    /// # Errors
    /// [`Error::SingularCovariance`] for a filter with a state that its noise does not reach.
    pub(crate) fn new<const F: usize>(filter: &Filter<F>, window: &Window) -> Result<Self, Error> {
        let (mut matrix, mut noise, mut output) =
            (FilterMatrix::default(), FilterVector::default(), FilterVector::default());
        for k in 0..F {
            matrix[k][..F].copy_from_slice(&filter.matrix()[k]);
            (noise[k], output[k]) = (filter.noise()[k], filter.output()[k]);
        }
        let factor = Whitening::of_covariance([0.0; F], filter.stationary_covariance(), (0, 0.0))?;
        let column = |l: usize| {
            let along = factor.unwhiten(&std::array::from_fn(|k| f64::from(u8::from(k == l))));
            let moved = filter.matrix().map(|row| row.iter().zip(&along).map(|(a, y)| a * y).sum());
            factor.whiten_vector(&moved)
        };
        let squares = (0..F).flat_map(column).map(|value| value * value);
        let fastest = squares.sum::<f64>().sqrt();
        Ok(Self { n_states: F, matrix, noise, output, window: window.clone(), fastest })
    }

    /// `u` of some states of the filter.
    #[inline]
    pub(crate) fn output(&self, states: &[f64]) -> f64 {
        states.iter().zip(&self.output).map(|(y, c)| c * y).sum()
    }

    /// `c P c`, the variance of the output.
    pub(crate) fn variance(&self, moments: &FilterMoments) -> f64 {
        let n = self.n_states;
        (0..n).map(|k| self.output[k] * self.output(&moments.covariance[k][..n])).sum()
    }

    /// `c Cov(m) c`: what the states of the structure explain of the variance of the output.
    pub(crate) fn explained_variance(&self, means: &[f64], masses: &[f64]) -> f64 {
        let outputs = || means.chunks_exact(self.n_states).map(|m| self.output(m));
        let total: f64 = masses.iter().sum();
        let mean: f64 = outputs().zip(masses).map(|(u, mu)| mu / total * u).sum();
        outputs().zip(masses).map(|(u, mu)| mu / total * (u - mean).powi(2)).sum()
    }

    /// `C c` and `c C c`, the covariance of the states with the output and its variance, given the structure's states:
    /// `C = P - Cov(m)`.
    ///
    /// # Errors
    /// [`Error::NoConditionalVariance`] where `c C c` is negative.
    pub(crate) fn conditional(
        &self,
        moments: &FilterMoments,
        masses: &[f64],
        time: f64,
    ) -> Result<(FilterVector, f64), Error> {
        let (n, covariance) = (self.n_states, self.conditional_covariance(moments, masses));
        let mut with_output = FilterVector::default();
        for k in 0..n {
            with_output[k] = self.output(&covariance[k][..n]);
        }
        let variance = self.output(&with_output[..n]);
        let whole = self.variance(moments);
        if variance.is_nan() || variance < -ROUNDOFF * whole {
            return Err(Error::NoConditionalVariance { time, value: variance, whole });
        }
        Ok((with_output, variance))
    }

    /// `C = P - Cov(m)`, by the law of total covariance, with the masses as probabilities.
    pub(crate) fn conditional_covariance(
        &self,
        moments: &FilterMoments,
        masses: &[f64],
    ) -> FilterMatrix {
        let (n, mut covariance) = (self.n_states, moments.covariance);
        let total: f64 = masses.iter().sum();
        let mut mean = FilterVector::default();
        for (m, mu) in moments.means.chunks_exact(n).zip(masses) {
            for k in 0..n {
                mean[k] += mu / total * m[k];
            }
        }
        let mut explained = FilterMatrix::default();
        for (m, mu) in moments.means.chunks_exact(n).zip(masses) {
            for k in 0..n {
                let weighted = mu / total * (m[k] - mean[k]);
                for l in 0..=k {
                    explained[k][l] += weighted * (m[l] - mean[l]);
                }
            }
        }
        for k in 0..n {
            for l in 0..n {
                covariance[k][l] -= explained[k.max(l)][k.min(l)];
            }
        }
        covariance
    }

    /// `A m - C c a_i` for the mean of every particle, with its `a_i = g . grad log rho`, and
    /// `dP/dt = A P + P A^T + w^2 b b^T`.
    pub(crate) fn rates(
        &self,
        t: f64,
        at: &FilterMoments,
        (with_output, along): (&FilterVector, &[f64]),
        rates: &mut FilterMoments,
    ) {
        let n = self.n_states;
        let rows = rates.means.chunks_exact_mut(n).zip(at.means.chunks_exact(n));
        for ((rate, m), along) in rows.zip(along) {
            for k in 0..n {
                let moved: f64 = self.matrix[k].iter().zip(m).map(|(a, m)| a * m).sum();
                rate[k] = moved - with_output[k] * along;
            }
        }
        let square = self.window.amplitude(t).powi(2);
        let p = &at.covariance;
        let moved =
            |k: usize, l: usize| -> f64 { (0..n).map(|m| self.matrix[k][m] * p[m][l]).sum() };
        for k in 0..n {
            for l in 0..n {
                rates.covariance[k][l] =
                    moved(k, l) + moved(l, k) + square * self.noise[k] * self.noise[l];
            }
        }
    }
}

impl Clone for FilterMoments {
    fn clone(&self) -> Self {
        Self { means: self.means.clone(), covariance: self.covariance }
    }

    /// Keeps the buffer.
    fn clone_from(&mut self, other: &Self) {
        self.means.clone_from(&other.means);
        self.covariance = other.covariance;
    }
}

impl FilterMoments {
    /// Zeros for `n` particles of a filter.
    pub(crate) fn zeros(n_particles: usize, n_states: usize) -> Self {
        Self { means: vec![0.0; n_particles * n_states], covariance: FilterMatrix::default() }
    }

    /// `self = start + sum_s c_s k_s`.
    pub(crate) fn combine<const S: usize>(&mut self, start: &Self, terms: [(f64, &Self); S]) {
        for (i, value) in self.means.iter_mut().enumerate() {
            *value = start.means[i] + terms.iter().map(|(c, k)| c * k.means[i]).sum::<f64>();
        }
        for k in 0..MOST_FILTER_STATES {
            for l in 0..MOST_FILTER_STATES {
                let sum: f64 = terms.iter().map(|(c, rate)| c * rate.covariance[k][l]).sum();
                self.covariance[k][l] = start.covariance[k][l] + sum;
            }
        }
    }
}
