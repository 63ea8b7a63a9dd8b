//! Disorder with a physical length: strengths and stiffnesses that vary from place to place.

use random_fields::{GaussianField, Marginal};
use sde_integrators::Noise;

use crate::bodies::bonds::Bonds;
use crate::error::{Error, same_length};

/// A random field of something positive, as a critical stretch or a modulus, at the nodes of a body.
///
/// $$ x_i = F^{-1}(\Phi(z_i)) $$
///
/// with `F` the law at one place ([`Marginal`]) and `z` a standard Gaussian field ([`GaussianField`]): a translation field.
/// The law at every node is exact. The correlation that was given is that of `z`; that of `x` is
/// [`Marginal::translated_correlation`] of it, a little below.
///
/// Source: Grigoriu 1995, Applied non-Gaussian processes, section 3.1.
///
/// ```
/// use peridyn_sde::DisorderField;
/// use random_fields::{Correlation, CorrelationFunction, GaussianField, Marginal};
/// use sde_integrators::Noise;
///
/// // Nodes 1 mm apart, a length of 5 mm, a critical stretch of one per mille that scatters by a fifth.
/// let positions: Vec<[f64; 1]> = (0..100).map(|k| [1e-3 * f64::from(k)]).collect();
/// let correlation = Correlation { function: CorrelationFunction::Matern32, length: 5e-3 };
/// let gaussian = GaussianField::by_circulant_embedding(&positions, 1e-3, correlation)?;
/// let marginal = Marginal::Lognormal { mean: 1e-3, coefficient_of_variation: 0.2 };
/// let field = DisorderField::new(gaussian, marginal, 0)?;
/// let mut strengths = vec![0.0; 100];
/// field.sample(&Noise::new(7), 0, &mut strengths)?;
/// assert!(strengths.iter().all(|&s0| s0 > 2e-4 && s0 < 3e-3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct DisorderField {
    gaussian: GaussianField,
    marginal: Marginal,
    number: u32,
}

impl DisorderField {
    /// Field `number` of each realisation. Fields with other numbers are independent of it: a body whose strength and
    /// stiffness vary each for itself has two.
    ///
    /// # Errors
    /// [`Error::Field`] with that of [`Marginal::check_positive`].
    pub fn new(gaussian: GaussianField, marginal: Marginal, number: u32) -> Result<Self, Error> {
        marginal.check_positive()?;
        Ok(Self { gaussian, marginal, number })
    }

    /// How many nodes it has.
    #[must_use]
    pub fn n_nodes(&self) -> usize {
        self.gaussian.n_nodes()
    }

    /// The law at one node.
    #[must_use]
    pub fn marginal(&self) -> Marginal {
        self.marginal
    }

    /// The values of a realisation into `out`, one per node.
    ///
    /// # Errors
    /// [`Error::Field`] for a length; [`Error::Node`] for a value that is not positive and finite, as a law of extreme scatter may
    /// have.
    pub fn sample(&self, noise: &Noise, realisation: u64, out: &mut [f64]) -> Result<(), Error> {
        self.gaussian.sample(noise, realisation, self.number, out)?;
        for value in &mut *out {
            *value = self.marginal.at(*value);
        }
        check_values(out)
    }
}

/// The value of a bond from those of its two nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BondValue {
    /// The smaller one: a bond is as strong as its weaker end. Its mean is below that of the nodes where they differ, so on
    /// lengths of a horizon.
    Minimum,
    /// Half of both. Its mean is that of the nodes; its scatter is a little less.
    Mean,
}

impl BondValue {
    /// The value of a bond whose ends have these.
    #[must_use]
    pub fn between(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Minimum => a.min(b),
            Self::Mean => 0.5 * (a + b),
        }
    }
}

/// A value for every bond, in the order of [`Bonds::all`], from one for every node.
///
/// # Errors
/// [`Error::Length`]; [`Error::Node`] for a value that is not positive and finite.
pub fn between_nodes(bonds: &Bonds, values: &[f64], value: BondValue) -> Result<Vec<f64>, Error> {
    same_length("the field", values.len(), bonds.n_nodes())?;
    check_values(values)?;
    Ok(bonds.pairs().map(|(i, j)| value.between(values[i], values[j])).collect())
}

fn check_values(values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|&value| !(value > 0.0 && value.is_finite())) {
        Some(node) => {
            let must = "greater than 0 and finite";
            Err(Error::Node { name: "the field", node, value: values[node], must })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;
    use crate::{BondConfig, Condition, Horizon, Nodes};

    fn chain() -> Bonds {
        let bar = Condition::Bar { area: 1.0 };
        let nodes = Nodes::lattice(1.0, ([0.0], [3.0]), bar, |_| true).unwrap();
        let config = BondConfig::uncorrected(Horizon::of_shells(1, 1.0).unwrap(), 1.0);
        Bonds::new(&nodes, &config).unwrap()
    }

    #[test]
    fn bond_takes_the_smaller_or_the_mean_of_its_ends() {
        let values = [1.0, 3.0, 2.0];
        let of = |value| between_nodes(&chain(), &values, value).unwrap();
        assert_eq!(of(BondValue::Minimum), [1.0, 2.0]);
        assert_eq!(of(BondValue::Mean), [2.0, 2.5]);
    }

    #[test]
    fn values_that_are_not_of_the_body_or_not_positive_are_refused() {
        let short = between_nodes(&chain(), &[1.0], BondValue::Mean);
        assert!(matches!(short, Err(Error::Length { value: 1, expected: 3, .. })));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let refused = between_nodes(&chain(), &[1.0, 1.0, bad], BondValue::Mean);
            assert!(matches!(refused, Err(Error::Node { node: 2, .. })), "{bad}");
        }
    }
}
