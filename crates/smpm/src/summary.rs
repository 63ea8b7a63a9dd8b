//! What a pass over the particles sees of them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::config::{BulkViscosity, Config};
use crate::error::Fault;
use crate::material_points::Condition;
use crate::number::Number;
use crate::particles::{BATCH, Chunk};

/// What a pass has seen, of values.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Summary<const D: usize> {
    /// The fault of the particle with the lowest number.
    pub(crate) fault: Option<(u32, Fault)>,
    /// The greatest speed at which a signal crosses the grid, and the lowest number of a particle that has it.
    pub(crate) fastest: (f64, u32),
    pub(crate) momentum: [f64; D],
    pub(crate) kinetic: f64,
    pub(crate) internal: f64,
}

impl<const D: usize> Summary<D> {
    pub(crate) fn none() -> Self {
        let fastest = (0.0, u32::MAX);
        Self { fault: None, fastest, momentum: [0.0; D], kinetic: 0.0, internal: 0.0 }
    }

    pub(crate) fn and(self, other: Self) -> Self {
        let fault = match (self.fault, other.fault) {
            (Some(one), Some(two)) => Some(if one.0 <= two.0 { one } else { two }),
            (one, two) => one.or(two),
        };
        let (one, two) = (self.fastest, other.fastest);
        let first = one.0 > two.0 || (one.0 >= two.0 && one.1 <= two.1);
        Self {
            fault,
            fastest: if first { one } else { two },
            momentum: std::array::from_fn(|k| self.momentum[k] + other.momentum[k]),
            kinetic: self.kinetic + other.kinetic,
            internal: self.internal + other.internal,
        }
    }

    pub(crate) fn fail(&mut self, number: u32, fault: Fault) {
        if self.fault.is_none_or(|(lowest, _)| number < lowest) {
            self.fault = Some((number, fault));
        }
    }
}

/// The speed at which a signal crosses the grid: `abs v + Q + sqrt(Q^2 + c^2)`.
#[inline(always)]
pub(crate) fn signal_speed<S: Number, const D: usize>(
    velocity: &[S; D],
    condition: &Condition<S>,
    config: &Config<D>,
) -> f64 {
    let (mut square, c) = (0.0, condition.wave_speed.value());
    for k in 0..D {
        square += velocity[k].value() * velocity[k].value();
    }
    if condition.rate >= 0.0 {
        return square.sqrt() + c;
    }
    let BulkViscosity { quadratic, linear } = config.viscosity;
    let q = linear * c - quadratic * config.cell * condition.rate;
    square.sqrt() + q + (q * q + c * c).sqrt()
}

/// Adds a batch of particles to what is seen.
#[inline(always)]
pub(crate) fn look<S: Number, const D: usize>(
    chunk: &Chunk<'_, S, D>,
    conditions: &[Condition<S>],
    config: &Config<D>,
    summary: &mut Summary<D>,
) {
    let n = conditions.len().min(BATCH);
    let (velocities, conditions) = (&chunk.velocity[..n], &conditions[..n]);
    let (masses, numbers) = (&chunk.mass[..n], &chunk.number[..n]);
    let mut speeds = [0.0; BATCH];
    for i in 0..n {
        speeds[i] = signal_speed(&velocities[i], &conditions[i], config);
    }
    for i in 0..n {
        if speeds[i] >= summary.fastest.0 {
            let tied = speeds[i] <= summary.fastest.0;
            let number = if tied { numbers[i].min(summary.fastest.1) } else { numbers[i] };
            summary.fastest = (speeds[i], number);
        }
    }
    let Summary { mut kinetic, mut momentum, .. } = *summary;
    for i in 0..n {
        let mass = masses[i].value();
        for k in 0..D {
            let v = velocities[i][k].value();
            kinetic += 0.5 * mass * v * v;
            momentum[k] += mass * v;
        }
    }
    (summary.kinetic, summary.momentum) = (kinetic, momentum);
}
