//! A simulation put away, and taken up again.

use crate::body::{AtStrength, Body};
use crate::error::{Error, node_number, same_length};
use crate::real::Real;
use crate::simulation::Simulation;

/// Beyond it a double no longer counts steps one by one, and times are no longer told apart.
const MOST_STEPS: u64 = 1 << 53;

/// What a simulation needs to go on to the same bits: with the body it was made of, its loading and its configuration.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedState {
    /// Steps taken.
    pub step: u64,
    /// Displacements, as the body lays them out (length).
    pub displacements: Vec<f64>,
    /// Velocities (length over time).
    pub velocities: Vec<f64>,
    /// For each bond the lanes in which it is whole, a bit for each.
    pub whole: Vec<u16>,
}

impl<T: Real, B: Body<T, D, L>, const D: usize, const L: usize> Simulation<T, B, D, L> {
    /// The state as plain numbers; those of `f32` are exact in `f64`.
    ///
    /// # Errors
    /// [`Error::NotSaved`] for a body whose bonds remember more than whether they are whole.
    pub fn save(&self) -> Result<SavedState, Error> {
        let plain = |values: &[T]| values.iter().map(|value| value.to_f64()).collect();
        Ok(SavedState {
            step: self.step,
            displacements: plain(&self.unknowns.u),
            velocities: plain(&self.unknowns.v),
            whole: self.body.whole().ok_or(Error::NotSaved)?,
        })
    }

    /// Goes on from a saved state of the same body, loading and configuration.
    ///
    /// # Errors
    /// Which leave the simulation as it was:
    /// [`Error::Length`] for the state of another body, [`Error::SavedStep`] for a step that is beyond counting,
    /// [`Error::SavedBond`] for a lane that there is not, [`Error::Node`] for a number that is not finite in the precision of
    /// the body. Then those of the forces, after which it is not to be used.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), Error> {
        if saved.step > MOST_STEPS {
            return Err(Error::SavedStep { value: saved.step, limit: MOST_STEPS });
        }
        let u = self.numbers("displacements", "a saved displacement", &saved.displacements)?;
        let v = self.numbers("velocities", "a saved velocity", &saved.velocities)?;
        let beyond = |whole: &u16| u32::from(*whole) >> L != 0;
        if let Some(bond) = saved.whole.iter().position(beyond) {
            return Err(Error::SavedBond { bond, value: saved.whole[bond], lanes: L });
        }
        self.body.set_whole(&saved.whole)?;
        self.step = saved.step;
        self.time = saved.step as f64 * self.config.dt;
        (self.unknowns.u, self.unknowns.v) = (u, v);
        // What Leimkuhler and Matthews' method keeps of the step before is drawn again.
        self.unknowns.work = std::array::from_fn(|_| Vec::new());
        self.evaluate(AtStrength::Hold)
    }

    /// A saved column in the precision of the body.
    fn numbers(
        &self,
        column: &'static str,
        name: &'static str,
        saved: &[f64],
    ) -> Result<Vec<T>, Error> {
        same_length(column, saved.len(), self.unknowns.u.len())?;
        saved
            .iter()
            .enumerate()
            .map(|(at, &value)| node_number(name, at / (D * L), value))
            .collect()
    }

    /// Gives a lane velocities (length over time), in inertial dynamics; what is gripped stays.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::Node`] for one that is not finite.
    pub fn set_velocities(&mut self, lane: usize, v: &[[f64; D]]) -> Result<(), Error> {
        self.set(lane, "a velocity", v, |unknowns| &mut unknowns.v)
    }
}
