//! What is sampled, and one step of Metropolis's algorithm on it.

use sde_integrators::Stream;
use simd_lanes::exp;

use crate::error::Error;
use crate::factor::Factor;
use crate::parameter_space::ParameterSpace;

/// The log-likelihood as a function of the parameters.
pub(crate) type LogLikelihood<'a> = &'a (dyn Fn(&[f64]) -> Result<f64, Error> + Sync);

/// Prior and likelihood.
#[derive(Clone, Copy)]
pub(crate) struct Target<'a> {
    pub(crate) space: &'a ParameterSpace,
    pub(crate) log_likelihood: LogLikelihood<'a>,
}

impl Target<'_> {
    /// The log-likelihood at a place in units; minus infinity where the data cannot be.
    pub(crate) fn at(&self, units: &[f64]) -> Result<f64, Error> {
        let value = (self.log_likelihood)(&self.space.values(units))?;
        if value.is_nan() || value >= f64::INFINITY {
            return Err(Error::NotFinite { name: "the log-likelihood", value });
        }
        Ok(value)
    }
}

/// A place in units with its densities.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Walker {
    pub(crate) units: Vec<f64>,
    pub(crate) log_prior: f64,
    pub(crate) log_likelihood: f64,
}

/// Proposals `x + L z`, with normals `z`.
pub(crate) struct Proposal {
    factor: Factor,
}

impl Proposal {
    /// With `2.38^2/d` times a covariance (Gelman, Roberts and Gilks 1996, Efficient Metropolis jumping rules).
    pub(crate) fn new(dimension: usize, covariance: &[f64]) -> Result<Self, Error> {
        let scale = 2.38 * 2.38 / dimension as f64;
        let scaled: Vec<f64> = covariance.iter().map(|c| scale * c).collect();
        Ok(Self { factor: Factor::new(dimension, &scaled)? })
    }
}

impl Walker {
    pub(crate) fn new(target: &Target<'_>, units: Vec<f64>) -> Result<Self, Error> {
        let (log_prior, log_likelihood) = (target.space.log_prior(&units), target.at(&units)?);
        Ok(Self { units, log_prior, log_likelihood })
    }

    /// One step of random-walk Metropolis on prior times likelihood to the power `beta`; whether it moved. Each takes as many
    /// words of the stream as any other.
    pub(crate) fn step(
        &mut self,
        target: &Target<'_>,
        beta: f64,
        proposal: &Proposal,
        stream: &mut Stream,
    ) -> Result<bool, Error> {
        let dimension = self.units.len();
        let (mut normals, mut units) = (vec![0.0; dimension], vec![0.0; dimension]);
        stream.fill_normal(&mut normals);
        let uniform = stream.next_uniform();
        proposal.factor.apply(&normals, &mut units);
        for (new, old) in units.iter_mut().zip(&self.units) {
            *new += old;
        }
        if units.iter().any(|unit| unit.abs() > 1.0) {
            return Ok(false);
        }
        let new = Self::new(target, units)?;
        let rise =
            beta * (new.log_likelihood - self.log_likelihood) + new.log_prior - self.log_prior;
        let is_accepted = uniform < exp(rise.min(0.0));
        if is_accepted {
            *self = new;
        }
        Ok(is_accepted)
    }
}
