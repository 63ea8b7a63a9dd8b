//! Shear without yield.

use perturbation_moments::{Real, Scalar};

use super::{Strength, Trial};
use crate::error::{Error, Fault, positive};
use crate::tensor::Symmetric;
use crate::{Now, Observed, StrengthFamily};

parameters! {
    /// What an [`ElasticShear`] is made of.
    ElasticShearParameters {
        /// `G > 0` (stress).
        shear_modulus,
    }
}

/// A deviator that follows the rate of deformation and turns with the spin.
///
/// $$ \mathring{S} = 2 G \operatorname{dev} D $$
///
/// The rate is that of Jaumann, taken over a step by the rotation of Hughes and Winget (1980): rigid rotation leaves every
/// invariant as it was, for any `dt`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticShear<S> {
    parameters: ElasticShearParameters<S>,
}

impl<S: Scalar> ElasticShear<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for a modulus that is not above zero.
    pub fn new(parameters: ElasticShearParameters<S>) -> Result<Self, Error> {
        positive("shear modulus", parameters.shear_modulus.value())?;
        Ok(Self { parameters })
    }
}

impl<S: Real> Strength<S> for ElasticShear<S> {
    type State = Symmetric<S>;

    fn start(&self) -> Symmetric<S>
    where
        S: Scalar,
    {
        Symmetric::zero()
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, state: &mut Symmetric<S>) -> Result<S, Fault> {
        let trial = Trial::new(now, state, self.parameters.shear_modulus);
        let work = trial.work(now, state, &trial.deviator);
        *state = trial.deviator;
        Ok(work)
    }

    #[inline(always)]
    fn deviator(&self, state: &Symmetric<S>) -> Option<Symmetric<S>> {
        Some(*state)
    }

    #[inline(always)]
    fn shear_modulus(&self, _state: &Symmetric<S>) -> Option<S> {
        Some(self.parameters.shear_modulus)
    }

    #[inline(always)]
    fn observe(&self, _state: &Symmetric<S>) -> Observed<S>
    where
        S: Scalar,
    {
        Observed::of_energy(S::constant(0.0))
    }

    #[inline(always)]
    fn visit_numbers(&self, state: &mut Symmetric<S>, mut visit: impl FnMut(&mut S)) -> bool {
        for k in 0..6 {
            visit(&mut state.0[k]);
        }
        true
    }

    shows_constants!();
}

family_member!(StrengthFamily, Strength: ElasticShear { }, number => Symmetric([number; 6]));

#[cfg(test)]
mod tests {
    use super::super::laws::stretching;
    use super::*;

    #[test]
    fn it_stores_what_was_put_in() {
        let shear = ElasticShear::new(ElasticShearParameters { shear_modulus: 3.0 }).unwrap();
        let mut state = shear.start();
        let mut work = 0.0;
        for _ in 0..10 {
            work += shear.update(&stretching(0.1, 0.01), &mut state).unwrap();
        }
        // Strain 0.01 along x: S_xx = 2 G 0.01, and S:S/(4G).
        assert!((state.0[0] - 0.06).abs() < 1e-15);
        assert!((work - state.contract(&state) / 12.0).abs() < 1e-17);
    }
}
