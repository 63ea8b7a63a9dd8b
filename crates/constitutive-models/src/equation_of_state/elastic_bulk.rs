//! A pressure that only knows the volume.

use perturbation_moments::{Real, Scalar};

use super::{EquationOfState, Line, Start};
use crate::EquationFamily;
use crate::error::{Error, positive};

parameters! {
    /// What an [`ElasticBulk`] is made of.
    ElasticBulkParameters {
        /// `rho_0 > 0` (mass per volume).
        density,
        /// `K > 0` (stress).
        bulk_modulus,
    }
}

/// The integral of `dp = -K tr(D) dt`:
///
/// $$ p = -K \ln J $$
///
/// Its tangent modulus is `K` at every volume; the energy has no part in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticBulk<S> {
    parameters: ElasticBulkParameters<S>,
}

impl<S: Scalar> ElasticBulk<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for a density or a modulus that is not above zero.
    pub fn new(parameters: ElasticBulkParameters<S>) -> Result<Self, Error> {
        positive("density", parameters.density.value())?;
        positive("bulk modulus", parameters.bulk_modulus.value())?;
        Ok(Self { parameters })
    }
}

impl<S: Real> EquationOfState<S> for ElasticBulk<S> {
    type State = ();

    const KNOWS_ENERGY: bool = false;

    #[inline(always)]
    fn density(&self) -> S {
        self.parameters.density
    }

    fn start(&self, _position: [f64; 3]) -> Start<S, ()>
    where
        S: Scalar,
    {
        Start { state: (), energy: S::constant(0.0), pressure: S::constant(0.0) }
    }

    #[inline(always)]
    fn line(&self, volume: S) -> Line<S> {
        Line { a: self.parameters.bulk_modulus * volume.ln() * -1.0, b: volume.splat(0.0) }
    }

    #[inline(always)]
    fn slope(&self, volume: S) -> Line<S> {
        Line { a: self.parameters.bulk_modulus / volume * -1.0, b: volume.splat(0.0) }
    }

    #[inline(always)]
    fn bulk_modulus(&self, _volume: S, _energy: S) -> S {
        self.parameters.bulk_modulus
    }

    shows_constants!();
}

family_member!(EquationFamily, EquationOfState: ElasticBulk {  }, _number => ());

#[cfg(test)]
mod tests {
    use super::super::laws::slopes_and_bulk_modulus;
    use super::*;

    #[test]
    fn its_modulus_is_constant() {
        let parameters = ElasticBulkParameters { density: 1.0, bulk_modulus: 7.0 };
        let bulk = ElasticBulk::new(parameters).unwrap();
        slopes_and_bulk_modulus(&bulk, &[0.5, 1.0, 2.0], 0.3);
        for volume in [0.5, 1.0, 2.0] {
            assert!((bulk.bulk_modulus(volume, 0.3) - 7.0).abs() < 1e-14);
        }
    }
}
