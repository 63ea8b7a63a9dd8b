//! Step and run statistics.

use crate::method::remapping::Remapped;
use crate::score::{Fits, Unresolved};

/// One step, in numbers. Lengths are in the coordinates of the metric.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct StepReport {
    /// Number of this step, from 1.
    pub step: u64,
    /// Time after the step.
    pub time: f64,
    /// The step taken.
    pub dt: f64,
    /// The largest step by the diffusion limit, `C R_i^2 / D_y` at its smallest; infinite without diffusion.
    pub diffusion_limit: f64,
    /// `min_i h_i / |v_i|`: the step at Courant number 1.
    pub courant_limit: f64,
    /// Fewest neighbours of a particle, itself included.
    pub neighbours_min: usize,
    /// Mean number of neighbours, the particle itself included.
    pub neighbours_mean: f64,
    /// Smallest smoothing length.
    pub h_min: f64,
    /// Largest smoothing length.
    pub h_max: f64,
    /// Particles that the estimator could not resolve at the first stage.
    pub unresolved: Unresolved,
    /// How well the neighbours determined the local fits of the first stage.
    pub fits: Fits,
    /// The remeshing before the step, if there was one.
    pub remapped: Option<Remapped>,
}

/// Work done so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// Steps.
    pub steps: u64,
    /// Evaluations of the velocity of the whole cloud.
    pub evaluations: u64,
    /// Pairs visited: neighbours of all particles, summed over evaluations.
    pub neighbour_visits: u64,
}
