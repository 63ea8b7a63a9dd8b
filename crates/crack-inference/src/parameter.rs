//! A parameter, where it may lie and what is believed of it before.

use std::f64::consts::PI;

use sde_integrators::{normal_probability, normal_quantile};

use crate::error::{Error, between, positive};

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
    pub(crate) fn check(&self) -> Result<(), Error> {
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

    pub(crate) fn on_scale(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => simd_lanes::ln(value),
        }
    }

    /// Middle and half width on the scale.
    pub(crate) fn span(&self) -> (f64, f64) {
        let (low, high) = (self.on_scale(self.low), self.on_scale(self.high));
        (0.5 * (low + high), 0.5 * (high - low))
    }

    pub(crate) fn value(&self, unit: f64) -> f64 {
        let (middle, half) = self.span();
        let on_scale = middle + half * unit;
        match self.scale {
            Scale::Linear => on_scale,
            Scale::Logarithmic => simd_lanes::exp(on_scale),
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
    pub(crate) fn log_prior(&self, unit: f64) -> f64 {
        let square = |(mean, deviation): (f64, f64)| ((unit - mean) / deviation).powi(2);
        self.normal().map_or(0.0, |normal| -0.5 * square(normal))
    }

    /// A place in units drawn from the prior by a uniform number.
    pub(crate) fn draw(&self, uniform: f64) -> f64 {
        match self.normal() {
            None => 2.0 * uniform - 1.0,
            Some((mean, deviation)) => {
                let [from, to] =
                    [-1.0, 1.0].map(|end| normal_probability((end - mean) / deviation));
                // Only roundoff of Phi leads beyond the ends.
                let p = from + uniform * (to - from);
                (mean + deviation * normal_quantile(p)).clamp(-1.0, 1.0)
            }
        }
    }

    /// The variance of the prior in units.
    pub(crate) fn prior_variance(&self) -> f64 {
        let Some((mean, deviation)) = self.normal() else {
            return 1.0 / 3.0;
        };
        // Johnson, Kotz and Balakrishnan 1994, Continuous univariate distributions 1, section 13.10.
        let density = |z: f64| simd_lanes::exp(-0.5 * z * z) / (2.0 * PI).sqrt();
        let (a, b) = ((-1.0 - mean) / deviation, (1.0 - mean) / deviation);
        let mass = normal_probability(b) - normal_probability(a);
        let shift = (density(a) - density(b)) / mass;
        let square = 1.0 + (a * density(a) - b * density(b)) / mass - shift * shift;
        deviation * deviation * square
    }
}
