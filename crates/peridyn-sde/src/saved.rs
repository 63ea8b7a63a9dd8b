//! A simulation put away, and taken up again.

use crate::body::{AtStrength, Body};
use crate::error::{Error, same_length};
use crate::real::Real;
use crate::simulation::Simulation;

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
    /// [`Error::Length`] for the state of another body, [`Error::Node`] for a number that is not finite.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), Error> {
        for (name, values) in
            [("displacements", &saved.displacements), ("velocities", &saved.velocities)]
        {
            same_length(name, values.len(), self.unknowns.u.len())?;
            if let Some(at) = values.iter().position(|value| !value.is_finite()) {
                let (node, value) = (at / (D * L), values[at]);
                return Err(Error::Node { name: "a saved number", node, value, must: "finite" });
            }
        }
        self.body.set_whole(&saved.whole)?;
        self.step = saved.step;
        self.time = saved.step as f64 * self.config.dt;
        self.unknowns.u = saved.displacements.iter().map(|&u| T::of(u)).collect();
        self.unknowns.v = saved.velocities.iter().map(|&v| T::of(v)).collect();
        // What Leimkuhler and Matthews' method keeps of the step before is drawn again.
        self.unknowns.work = std::array::from_fn(|_| Vec::new());
        self.evaluate(AtStrength::Hold)
    }

    /// Gives a lane velocities (length over time), in inertial dynamics; what is gripped stays.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::Node`] for one that is not finite.
    pub fn set_velocities(&mut self, lane: usize, v: &[[f64; D]]) -> Result<(), Error> {
        self.set(lane, "a velocity", v, |unknowns| &mut unknowns.v)
    }
}
