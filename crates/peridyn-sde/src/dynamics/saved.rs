//! Saved states.

use crate::bodies::body::Body;
use crate::dynamics::motion::Motion;
use crate::dynamics::simulation::Simulation;
use crate::error::{Error, node_number, same_length};
use crate::real::Real;
use crate::steps::Stepper;

/// Beyond it a double no longer counts steps one by one.
const MOST_STEPS: u64 = 1 << 53;

/// What a simulation needs to continue bitwise identically, with the body it was made of, its loading and its configuration.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedState {
    /// Steps taken.
    pub step: u64,
    /// Displacements, as the body lays them out (length).
    pub displacements: Vec<f64>,
    /// Velocities (length over time).
    pub velocities: Vec<f64>,
    /// For each bond the lanes in which it is intact, a bit for each.
    pub whole: Vec<u16>,
}

impl<T: Real, const D: usize, const L: usize> Simulation<T, D, L> {
    /// The state in `f64`; numbers of `f32` are exact in it.
    ///
    /// # Errors
    /// [`Error::NotSaved`] for a body whose bonds remember more than whether they are intact.
    pub fn save(&self) -> Result<SavedState, Error> {
        self.motion.save(&*self.body)
    }

    /// Continues from a saved state of the same body, loading and configuration.
    ///
    /// # Errors
    /// Which leave the simulation as it was:
    /// [`Error::Length`] for the state of another body, [`Error::SavedStep`] for a step that is beyond counting,
    /// [`Error::SavedBond`] for a lane that does not exist, [`Error::Node`] for a number that is not finite in the precision of
    /// the body. Then those of the forces, after which it is not to be used.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), Error> {
        self.motion.restore(&mut *self.body, saved)?;
        // Leimkuhler and Matthews' method draws the kick of the step before again.
        self.stepper = Stepper::new(&self.motion.config.dynamics, self.motion.u.len());
        self.motion.evaluate_intact(&mut *self.body)
    }
}

impl<T: Real, const D: usize, const L: usize> Motion<T, D, L> {
    fn save(&self, body: &dyn Body<T, D, L>) -> Result<SavedState, Error> {
        if body.has_memory() {
            return Err(Error::NotSaved);
        }
        let plain = |values: &[T]| values.iter().map(|value| value.to_f64()).collect();
        Ok(SavedState {
            step: self.step,
            displacements: plain(&self.u),
            velocities: plain(&self.v),
            whole: (0..body.bonds().len()).map(|bond| body.intact(bond)).collect(),
        })
    }

    fn restore(&mut self, body: &mut dyn Body<T, D, L>, saved: &SavedState) -> Result<(), Error> {
        if saved.step > MOST_STEPS {
            return Err(Error::SavedStep { value: saved.step, limit: MOST_STEPS });
        }
        let u = self.numbers("displacements", "a saved displacement", &saved.displacements)?;
        let v = self.numbers("velocities", "a saved velocity", &saved.velocities)?;
        let beyond = |lanes: &u16| u32::from(*lanes) >> L != 0;
        if let Some(bond) = saved.whole.iter().position(beyond) {
            return Err(Error::SavedBond { bond, value: saved.whole[bond], lanes: L });
        }
        if body.has_memory() {
            return Err(Error::NotSaved);
        }
        same_length("saved bonds", saved.whole.len(), body.bonds().len())?;
        for (bond, &lanes) in saved.whole.iter().enumerate() {
            body.set_intact(bond, lanes);
        }
        self.step = saved.step;
        self.time = saved.step as f64 * self.config.dt;
        (self.u, self.v) = (u, v);
        Ok(())
    }

    /// A saved column in the precision of the body.
    fn numbers(
        &self,
        column: &'static str,
        name: &'static str,
        saved: &[f64],
    ) -> Result<Vec<T>, Error> {
        same_length(column, saved.len(), self.u.len())?;
        saved
            .iter()
            .enumerate()
            .map(|(at, &value)| node_number(name, at / (D * L), value))
            .collect()
    }
}
