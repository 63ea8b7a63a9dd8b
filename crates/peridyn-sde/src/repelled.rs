//! Simulations whose nodes repel each other.

use crate::body::{AtStrength, Body};
use crate::contact::{Contact, Now};
use crate::error::Error;
use crate::real::Real;
use crate::repulsion::Repulsion;
use crate::simulation::Simulation;

impl<T: Real, B: Body<T, D, L>, const D: usize, const L: usize> Simulation<T, B, D, L> {
    /// Lets nodes that come near each other push each other away, in every scheme, as loads do: see [`Repulsion`].
    ///
    /// Each lane has a list of the pairs that may touch, made anew when a node has moved by 0.045 spacings; on a lattice near
    /// rest it is empty. Sums go by the numbers of the nodes, so that a run that is saved and restored goes on to the same bits,
    /// whatever the lanes beside. The repulsion is no part of [`SavedState`](crate::SavedState): whoever restores gives it again.
    /// [`energy`](Self::energy), [`forces`](Self::forces) and [`pull_on`](Self::pull_on) stay those of the bonds.
    ///
    /// **Stability.** The step is held against one touching pair of nodes alone, `z = h (M_i + M_j) k` or
    /// `(h omega)^2 = h^2 (1/m_i + 1/m_j) k`, `k = c_s V_i V_j/delta`, which must be less than 2 or 4. The theta method is
    /// explicit in the repulsion: 2 there as well. This does not cover that the bonds of a node pull too, nor that it touches
    /// several others: the stiffest mode of a lattice that is compressed by 10 to 20 % all over is 2, 4 and 6 times that of a
    /// pair in one, two and three dimensions. A step for which [`relative_step`](Self::relative_step) and that multiple of
    /// [`relative_step_of_repulsion`](Self::relative_step_of_repulsion) add to less than the limit is on the safe side.
    ///
    /// In a step a pair must not pass through the range `d_ij`: nodes that move farther than a spacing in one step may.
    ///
    /// # Errors
    /// [`Error::NotPositive`], [`Error::OutOfRange`] for a repulsion that cannot be; [`Error::Unstable`] for a step beyond the
    /// stable range of a pair; [`Error::Coincident`] for two nodes that are at one place, here and in [`step`](Self::step): none
    /// of them has a direction to push the other in.
    pub fn with_repulsion(mut self, repulsion: Repulsion) -> Result<Self, Error> {
        repulsion.check()?;
        let (volumes, dt) = (self.body.nodes().volumes(), self.config.dt);
        let dynamics = &self.config.dynamics;
        let (value, limit) = repulsion.relative_step(volumes, &self.resistance, dynamics, dt)?;
        if value.is_nan() || value >= limit {
            return Err(Error::Unstable { dt, value, limit });
        }
        let contact = Contact::new(repulsion, volumes.len());
        self.repulsion = Some(Box::new(Repelled { contact, relative_step: value }));
        self.evaluate(AtStrength::Hold)?;
        Ok(self)
    }

    /// `z = h (M_i + M_j) k` of one touching pair, the stiffest; in inertial dynamics `(h omega)^2`. Zero without a repulsion.
    #[must_use]
    pub fn relative_step_of_repulsion(&self) -> f64 {
        self.repulsion.as_ref().map_or(0.0, |repelled| repelled.relative_step)
    }

    /// The energy of the repulsion in a lane (energy); zero without one.
    ///
    /// # Errors
    /// [`Error::Coincident`] for two nodes at one place.
    pub fn repulsion_energy(&self, lane: usize) -> Result<f64, Error> {
        Ok(self.repulsion_of(lane)?.0)
    }

    /// What the repulsion pushes the nodes of a lane with, at their present displacements (force); zero without one.
    ///
    /// # Errors
    /// [`Error::Coincident`] for two nodes at one place.
    pub fn repulsion_forces(&self, lane: usize) -> Result<Vec<[f64; D]>, Error> {
        Ok(self.repulsion_of(lane)?.1)
    }

    fn repulsion_of(&self, lane: usize) -> Result<(f64, Vec<[f64; D]>), Error> {
        let nodes = self.body.nodes();
        match &self.repulsion {
            Some(repelled) => repelled.contact.of_lane(nodes, &self.unknowns.u, lane, &self.now()),
            None => Ok((0.0, vec![[0.0; D]; nodes.positions().len()])),
        }
    }

    /// Finds who touches, at the displacements as they stand.
    pub(crate) fn find_touching(&mut self) -> Result<(), Error> {
        let now = self.now();
        match &mut self.repulsion {
            Some(repelled) => repelled.contact.find(self.body.nodes(), &self.unknowns.u, &now),
            None => Ok(()),
        }
    }

    fn now(&self) -> Now<L> {
        Now {
            step: self.step + 1,
            time: self.time_after(),
            realisations: self.realisations,
            level: self.level,
        }
    }
}

/// What a repulsion adds to a simulation.
#[derive(Debug)]
pub(crate) struct Repelled<T, const D: usize, const L: usize> {
    pub(crate) contact: Contact<T, D, L>,
    relative_step: f64,
}
