//! Heun's step.

use crate::bodies::body::Body;
use crate::dynamics::motion::Motion;
use crate::error::Error;
use crate::real::Real;

#[derive(Debug)]
pub(crate) struct Heun<T> {
    /// `L z`.
    kick: Vec<T>,
    u_at_start: Vec<T>,
    drift_at_start: Vec<T>,
    bond_forces_at_start: Vec<T>,
}

impl<T: Real> Heun<T> {
    pub(super) fn new(n_unknowns: usize) -> Self {
        Self {
            kick: vec![T::ZERO; n_unknowns],
            u_at_start: Vec::new(),
            drift_at_start: Vec::new(),
            bond_forces_at_start: Vec::new(),
        }
    }

    /// `u* = u + h M F(u) + sqrt(2 kT h) L z`, then the same with the mean of `M F` at `u` and `u*`.
    pub(super) fn step<const D: usize, const L: usize>(
        &mut self,
        motion: &mut Motion<T, D, L>,
        body: &mut dyn Body<T, D, L>,
    ) -> Result<(), Error> {
        let h = T::of(motion.config.dt);
        motion.evaluate(body)?;
        motion.drift_at(motion.time)?;
        let amplitude = T::of(motion.draw(&mut self.kick)?);
        self.u_at_start.clone_from(&motion.u);
        self.drift_at_start.clone_from(&motion.drift);
        self.bond_forces_at_start.clone_from(&motion.bond_forces);
        for (i, u) in motion.u.iter_mut().enumerate() {
            *u += h * motion.drift[i] + amplitude * self.kick[i];
        }
        motion.follow();
        motion.evaluate_intact(body)?;
        motion.drift_at(motion.time)?;
        let half = h * T::of(0.5);
        for (i, u) in motion.u.iter_mut().enumerate() {
            let drift = self.drift_at_start[i] + motion.drift[i];
            *u = self.u_at_start[i] + (half * drift + amplitude * self.kick[i]);
        }
        std::mem::swap(&mut motion.bond_forces, &mut self.bond_forces_at_start);
        motion.finish()
    }
}
