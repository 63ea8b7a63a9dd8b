//! Parameters, where they may lie and what is believed of them before.

use std::f64::consts::PI;

use super::normal_quantile::normal_quantile;
use super::summaries::same_count;
use crate::error::{Error, at_least, between, positive};
use crate::marginal::below;

/// A normal prior flatter than this is a uniform one, less the digits that its cut-off costs.
const FLATTEST: f64 = 100.0;
const FLATNESS: &str = "standard deviation of a prior over the distance of its bounds";

/// The scale on which a parameter is seen: priors are uniform or normal, and emulators polynomials, on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// The value itself.
    Linear,
    /// Its natural logarithm.
    Logarithmic,
}

/// What is believed of a parameter before data are seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// Uniform on its scale, between the bounds.
    Uniform,
    /// Normal on its scale, cut off at the bounds.
    Normal {
        /// The mean on the scale (of the natural logarithm for a logarithmic one), between the bounds.
        mean: f64,
        /// The standard deviation on the scale.
        standard_deviation: f64,
    },
}

/// One parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// The scale on which it is seen.
    pub scale: Scale,
    /// The lowest value: there is no simulation, and no belief, below it.
    pub low: f64,
    /// The highest value.
    pub high: f64,
    /// What is believed of it.
    pub prior: Prior,
}

impl Parameter {
    fn check(&self) -> Result<(), Error> {
        let Self { low, high, .. } = *self;
        let is_scale = self.scale == Scale::Linear || low > 0.0;
        if !(low < high && low.is_finite() && high.is_finite() && is_scale) {
            let must = match self.scale {
                Scale::Linear => "they must be finite, the first below the second",
                Scale::Logarithmic => "they must be finite and above 0, the first below the second",
            };
            return Err(Error::Bounds { name: self.name.clone(), low, high, must });
        }
        if let Prior::Normal { mean, standard_deviation } = self.prior {
            positive("standard deviation of a prior", standard_deviation)?;
            let (low, high) = (self.on_scale(low), self.on_scale(high));
            let over_width = standard_deviation / (high - low);
            between(FLATNESS, over_width, 0.0, FLATTEST)?;
            if !(low..=high).contains(&mean) {
                let name = format!("the mean of the prior of {}", self.name);
                return Err(Error::OutOfBounds { name, value: mean, low, high });
            }
        }
        Ok(())
    }

    pub(super) fn on_scale(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => sde_integrators::ln(value),
        }
    }

    /// Middle and half width on the scale.
    fn span(&self) -> (f64, f64) {
        let (low, high) = (self.on_scale(self.low), self.on_scale(self.high));
        (0.5 * (low + high), 0.5 * (high - low))
    }

    fn value(&self, unit: f64) -> f64 {
        let (middle, half) = self.span();
        let on_scale = middle + half * unit;
        match self.scale {
            Scale::Linear => on_scale,
            Scale::Logarithmic => sde_integrators::exp(on_scale),
        }
    }

    /// Mean and deviation of a normal prior in units.
    fn normal(&self) -> Option<(f64, f64)> {
        let (middle, half) = self.span();
        match self.prior {
            Prior::Uniform => None,
            Prior::Normal { mean, standard_deviation } => {
                Some(((mean - middle) / half, standard_deviation / half))
            }
        }
    }

    /// The log-density of the prior at a place in units, but for a constant.
    fn log_prior(&self, unit: f64) -> f64 {
        let square = |(mean, deviation): (f64, f64)| ((unit - mean) / deviation).powi(2);
        self.normal().map_or(0.0, |normal| -0.5 * square(normal))
    }

    /// A place in units drawn from the prior by a uniform number.
    fn draw(&self, uniform: f64) -> f64 {
        match self.normal() {
            None => 2.0 * uniform - 1.0,
            Some((mean, deviation)) => {
                let [from, to] = [-1.0, 1.0].map(|end| below((end - mean) / deviation));
                // Only roundoff of Phi leads beyond the ends.
                let p = from + uniform * (to - from);
                (mean + deviation * normal_quantile(p)).clamp(-1.0, 1.0)
            }
        }
    }

    /// The variance of the prior in units.
    fn prior_variance(&self) -> f64 {
        let Some((mean, deviation)) = self.normal() else {
            return 1.0 / 3.0;
        };
        // Johnson, Kotz and Balakrishnan 1994, Continuous univariate distributions 1, section 13.10.
        let density = |z: f64| sde_integrators::exp(-0.5 * z * z) / (2.0 * PI).sqrt();
        let (a, b) = ((-1.0 - mean) / deviation, (1.0 - mean) / deviation);
        let mass = below(b) - below(a);
        let shift = (density(a) - density(b)) / mass;
        let square = 1.0 + (a * density(a) - b * density(b)) / mass - shift * shift;
        deviation * deviation * square
    }
}

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
    pub(super) fn units(&self, at: &[f64]) -> Result<Vec<f64>, Error> {
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

    pub(super) fn values(&self, units: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(units).map(|(p, &unit)| p.value(unit)).collect()
    }

    pub(super) fn log_prior(&self, units: &[f64]) -> f64 {
        self.parameters.iter().zip(units).map(|(p, &unit)| p.log_prior(unit)).sum()
    }

    pub(super) fn draw(&self, mut uniform: impl FnMut() -> f64) -> Vec<f64> {
        self.parameters.iter().map(|p| p.draw(uniform())).collect()
    }

    /// The variance of the prior of a parameter, on its scale.
    pub(super) fn prior_variance(&self, parameter: usize) -> f64 {
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
            let mut stream = Noise::new(3).stream(Purpose::InitialLaw, 0);
            let (mut first, mut square) = (Accumulator::default(), Accumulator::default());
            for _ in 0..20_000 {
                let unit = space.draw(|| stream.next_uniform());
                let value = space.values(&unit)[0];
                assert!((-1.0..=2.0).contains(&value));
                first.push(value);
            }
            let mut stream = Noise::new(3).stream(Purpose::InitialLaw, 0);
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
