//! Simulations whose nodes repel each other.

use crate::body::Body;
use crate::compiled::motions;
use crate::error::Error;
use crate::real::Real;
use crate::repulsion::Repulsion;
use crate::simulation::Simulation;

impl<T: Real, B: Body<T, D, L>, const D: usize, const L: usize> Simulation<T, B, D, L> {
    /// Lets nodes that come near each other push each other away, in every scheme, as loads do: see [`Repulsion`].
    ///
    /// Each lane has a list of the pairs that may touch, made anew when a node has moved by 0.045 spacings; on a lattice near
    /// rest it is empty. Sums go by the numbers of the nodes, so that a restored run is bitwise identical,
    /// whatever the other lanes. [`SavedState`](crate::SavedState) excludes the repulsion: pass it again on restoring.
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
        self.relative_step_of_repulsion =
            (motions().repel)(&mut self.motion, &mut self.body, repulsion)?;
        Ok(self)
    }

    /// `z = h (M_i + M_j) k` of one touching pair, the stiffest; in inertial dynamics `(h omega)^2`. Zero without a repulsion.
    #[must_use]
    pub fn relative_step_of_repulsion(&self) -> f64 {
        self.relative_step_of_repulsion
    }

    /// The energy of the repulsion in a lane (energy); zero without one.
    ///
    /// # Errors
    /// [`Error::Coincident`] for two nodes at one place.
    pub fn repulsion_energy(&self, lane: usize) -> Result<f64, Error> {
        Ok(self.motion.repulsion(&self.body, lane)?.0)
    }

    /// What the repulsion pushes the nodes of a lane with, at their present displacements (force); zero without one.
    ///
    /// # Errors
    /// [`Error::Coincident`] for two nodes at one place.
    pub fn repulsion_forces(&self, lane: usize) -> Result<Vec<[f64; D]>, Error> {
        Ok(self.motion.repulsion(&self.body, lane)?.1)
    }
}
