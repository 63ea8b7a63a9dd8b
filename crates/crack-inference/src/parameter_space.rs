//! Parameters together, and points that fill their space.

use crate::error::{Error, at_least, same_count};
use crate::parameter::Parameter;

/// Parameters together, independent of each other before data are seen. A point is a slice of values in their order.
///
/// Inside, each lies between -1 and 1: from bound to bound on its scale.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterSpace {
    parameters: Vec<Parameter>,
}

impl ParameterSpace {
    /// # Errors
    /// [`Error::TooFew`] for no parameter; [`Error::Bounds`]; [`Error::NotPositive`], [`Error::OutOfRange`] and
    /// [`Error::OutOfBounds`] for a prior.
    pub fn new(parameters: Vec<Parameter>) -> Result<Self, Error> {
        at_least("parameters", parameters.len(), 1)?;
        parameters.iter().try_for_each(Parameter::check)?;
        Ok(Self { parameters })
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Points that fill the space evenly on its scales, for the ensembles of an emulator: Halton's sequence (Halton 1960, On the
    /// efficiency of certain quasi-random sequences of points), from its point 1 on. The first points of a longer design are those
    /// of a shorter one.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for more than six parameters, in which the sequence is not even.
    pub fn design(&self, n_points: usize) -> Result<Vec<Vec<f64>>, Error> {
        const BASES: [u64; 6] = [2, 3, 5, 7, 11, 13];
        let dimension = self.parameters.len();
        if dimension > BASES.len() {
            let value = dimension as f64;
            let name = "number of parameters of a design";
            return Err(Error::OutOfRange { name, value, from: 0.0, to: 7.0 });
        }
        let point = |n: u64| -> Vec<f64> {
            let unit = |base: u64| 2.0 * radical_inverse(n, base) - 1.0;
            self.parameters.iter().zip(BASES).map(|(p, base)| p.value(unit(base))).collect()
        };
        Ok((1..=n_points as u64).map(point).collect())
    }

    /// The place of a point in units.
    pub(crate) fn units(&self, at: &[f64]) -> Result<Vec<f64>, Error> {
        same_count("a point of the parameters", at.len(), self.parameters.len())?;
        let unit = |(parameter, &value): (&Parameter, &f64)| {
            let (middle, half) = parameter.span();
            let unit = (parameter.on_scale(value) - middle) / half;
            // Roundoff of a way there and back.
            if unit.abs() <= 1.0 + 1e-9 {
                return Ok(unit);
            }
            let (low, high) = (parameter.low, parameter.high);
            Err(Error::OutOfBounds { name: parameter.name.clone(), value, low, high })
        };
        self.parameters.iter().zip(at).map(unit).collect()
    }

    pub(crate) fn values(&self, units: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(units).map(|(p, &unit)| p.value(unit)).collect()
    }

    pub(crate) fn log_prior(&self, units: &[f64]) -> f64 {
        self.parameters.iter().zip(units).map(|(p, &unit)| p.log_prior(unit)).sum()
    }

    pub(crate) fn draw(&self, mut uniform: impl FnMut() -> f64) -> Vec<f64> {
        self.parameters.iter().map(|p| p.draw(uniform())).collect()
    }

    /// The variance of the prior of a parameter, on its scale.
    pub(crate) fn prior_variance(&self, parameter: usize) -> f64 {
        let half = self.parameters[parameter].span().1;
        half * half * self.parameters[parameter].prior_variance()
    }
}

/// The digits of `n` in a base, mirrored at the point.
fn radical_inverse(mut n: u64, base: u64) -> f64 {
    let (mut value, mut place) = (0.0, 1.0);
    while n > 0 {
        place /= base as f64;
        value += place * (n % base) as f64;
        n /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use sde_integrators::{Accumulator, Noise, Purpose};

    use super::*;
    use crate::parameter::{Prior, Scale};

    fn parameter(scale: Scale, low: f64, high: f64, prior: Prior) -> Parameter {
        Parameter { name: "strength".into(), scale, low, high, prior }
    }

    #[test]
    fn design_is_haltons_sequence_on_the_scales() {
        let strength = parameter(Scale::Logarithmic, 1.0, 100.0, Prior::Uniform);
        let length = parameter(Scale::Linear, 0.0, 9.0, Prior::Uniform);
        let space = ParameterSpace::new(vec![strength, length]).unwrap();
        let design = space.design(3).unwrap();
        // Base 2: 1/2, 1/4, 3/4; base 3: 1/3, 2/3, 1/9.
        for (point, expected) in
            design.iter().zip([[10.0, 3.0], [10_f64.sqrt(), 6.0], [1000_f64.sqrt(), 1.0]])
        {
            for i in 0..2 {
                assert!((point[i] / expected[i] - 1.0).abs() < 1e-14, "{point:?}");
            }
        }
        assert_eq!(space.design(2).unwrap(), design[..2]);
    }

    #[test]
    fn draws_have_the_variance_of_the_prior_and_stay_between_the_bounds() {
        let normal = Prior::Normal { mean: 1.5, standard_deviation: 0.8 };
        for prior in [Prior::Uniform, normal] {
            let space = ParameterSpace::new(vec![parameter(Scale::Linear, -1.0, 2.0, prior)]);
            let space = space.unwrap();
            let mut stream = Noise::new(3).stream(Purpose::InitialDistribution, 0);
            let (mut first, mut square) = (Accumulator::default(), Accumulator::default());
            for _ in 0..20_000 {
                let unit = space.draw(|| stream.next_uniform());
                let value = space.values(&unit)[0];
                assert!((-1.0..=2.0).contains(&value));
                first.push(value);
            }
            let mut stream = Noise::new(3).stream(Purpose::InitialDistribution, 0);
            for _ in 0..20_000 {
                let value = space.values(&space.draw(|| stream.next_uniform()))[0];
                square.push((value - first.mean()).powi(2));
            }
            let variance = square.estimate().unwrap();
            let error = (variance.value - space.prior_variance(0)).abs();
            assert!(error < 4.0 * variance.standard_error().unwrap(), "{variance} {prior:?}");
        }
    }

    #[test]
    fn bounds_and_priors_that_cannot_be_are_refused() {
        let of =
            |scale, low, high, prior| ParameterSpace::new(vec![parameter(scale, low, high, prior)]);
        let crossed = of(Scale::Linear, 2.0, 1.0, Prior::Uniform).unwrap_err().to_string();
        assert_eq!(
            crossed,
            "the bounds of strength are 2 and 1; they must be finite, the first below the second"
        );
        let bounds = [(1.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)];
        for (low, high) in bounds {
            let refused = of(Scale::Linear, low, high, Prior::Uniform);
            assert!(matches!(refused, Err(Error::Bounds { .. })), "{low} {high}");
        }
        let zero = of(Scale::Logarithmic, 0.0, 1.0, Prior::Uniform);
        assert!(matches!(zero, Err(Error::Bounds { .. })));
        let far = Prior::Normal { mean: 3.0, standard_deviation: 1.0 };
        assert!(matches!(of(Scale::Linear, 0.0, 2.0, far), Err(Error::OutOfBounds { .. })));
        let flat = Prior::Normal { mean: 1.0, standard_deviation: 0.0 };
        assert!(matches!(of(Scale::Linear, 0.0, 2.0, flat), Err(Error::NotPositive { .. })));
        assert!(matches!(ParameterSpace::new(vec![]), Err(Error::TooFew { .. })));
        let space = of(Scale::Linear, 0.0, 2.0, Prior::Uniform).unwrap();
        assert!(matches!(space.units(&[2.1]), Err(Error::OutOfBounds { .. })));
        assert!(matches!(space.units(&[1.0, 1.0]), Err(Error::Count { .. })));
    }
}
