//! The discretisation of the density: estimator, choices of the method, lattice.

use crate::cloud::lattice::ParticleLattice;
use crate::error::Error;
use crate::method::Combination;
use crate::score::{LatticePlaces, ScoreEstimator};

/// How the density is discretised. It changes with the lattice, when the cloud is remapped, and never else.
#[derive(Debug)]
pub(crate) struct Discretisation<const D: usize> {
    pub(crate) estimator: Box<dyn ScoreEstimator<D> + Sync>,
    pub(crate) combination: Combination,
    pub(crate) lattice: ParticleLattice<D>,
}

impl<const D: usize> Discretisation<D> {
    /// Takes a lattice and prepares the estimator for it; returns the lattice before. After an error all is as it was.
    pub(crate) fn lay(
        &mut self,
        mut lattice: ParticleLattice<D>,
    ) -> Result<ParticleLattice<D>, Error> {
        let reach = self.combination.support_over_spacing;
        if self.estimator.criterion().is_none() {
            lattice.find_neighbours(reach)?;
        }
        self.estimator.start(&LatticePlaces {
            places: &lattice.places,
            neighbours: &lattice.neighbours,
            reach,
            spacing: lattice.spacing,
        })?;
        Ok(std::mem::replace(&mut self.lattice, lattice))
    }
}
