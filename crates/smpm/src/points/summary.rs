//! What a pass over the particles sees of them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::config::{BulkViscosity, Config};
use crate::number::CarriedNumber;
use crate::points::conditions::Columns;
use crate::points::particles::{BATCH, Chunk};
use constitutive_models::Fault;

/// What a pass has seen, of values.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Summary<const D: usize> {
    /// The fault of the particle with the lowest number.
    pub(crate) fault: Option<(u32, Fault)>,
    /// The greatest speed at which a signal crosses the grid, and the lowest number of a particle that has it.
    pub(crate) fastest: (f64, u32),
    /// For the work of gravity and of a rigid body; zero along axes for which neither asks.
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

/// Lanes of a sum, whatever the registers of the machine.
const LANES: usize = 8;

/// A sum over particles by their places in a batch: place `i` is added in lane `i` modulo [`LANES`], so registers apply.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sums([f64; LANES]);

impl Sums {
    pub(crate) fn none() -> Self {
        Self([0.0; LANES])
    }

    /// Adds a term for each of `n` places.
    #[inline(always)]
    pub(crate) fn add(&mut self, n: usize, term: impl Fn(usize) -> f64) {
        let mut begin = 0;
        while begin + LANES <= n {
            let mut terms = [0.0; LANES];
            for lane in 0..LANES {
                terms[lane] = term(begin + lane);
            }
            for lane in 0..LANES {
                self.0[lane] += terms[lane];
            }
            begin += LANES;
        }
        for i in begin..n {
            self.0[i - begin] += term(i);
        }
    }

    #[inline(always)]
    pub(crate) fn total(&self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (b + f)) + ((c + g) + (d + h))
    }
}

/// The speed at which a signal crosses the grid: `abs v + Q + sqrt(Q^2 + c^2)`, by the wave speed `c` and the rate `tr L`.
#[inline(always)]
pub(crate) fn signal_speed<S: CarriedNumber, const D: usize>(
    velocity: &[S; D],
    (c, rate): (f64, f64),
    config: &Config<D>,
) -> f64 {
    let mut square = 0.0;
    for k in 0..D {
        square += velocity[k].value() * velocity[k].value();
    }
    // Both cases, without a branch.
    let (speed, BulkViscosity { quadratic, linear }) = (square.sqrt(), config.viscosity);
    let q = linear * c - quadratic * config.cell * rate;
    let compressed = speed + q + (q * q + c * c).sqrt();
    if rate >= 0.0 { speed + c } else { compressed }
}

/// Adds a batch of particles to what is seen.
#[inline(always)]
pub(crate) fn look<S: CarriedNumber, const D: usize>(
    chunk: &Chunk<'_, S, D>,
    conditions: &Columns<'_, S>,
    (config, has_momentum): (&Config<D>, [bool; D]),
    summary: &mut Summary<D>,
) {
    let n = chunk.len().min(BATCH);
    let (velocities, masses, numbers) =
        (&chunk.velocity[..n], &chunk.mass[..n], &chunk.number[..n]);
    let (wave_speeds, rates) = (&conditions.wave_speed[..n], &conditions.rate[..n]);
    let mut speeds = [0.0; BATCH];
    for i in 0..n {
        let condition = (wave_speeds[i].value(), rates[i]);
        speeds[i] = signal_speed(&velocities[i], condition, config);
    }
    keep_fastest(&speeds, numbers, summary);
    let mut kinetic = Sums::none();
    kinetic.add(
        n,
        #[inline(always)]
        |i| {
            let mut square = 0.0;
            for k in 0..D {
                square += velocities[i][k].value() * velocities[i][k].value();
            }
            0.5 * masses[i].value() * square
        },
    );
    summary.kinetic += kinetic.total();
    for k in 0..D {
        if has_momentum[k] {
            let mut momentum = Sums::none();
            momentum.add(
                n,
                #[inline(always)]
                |i| masses[i].value() * velocities[i][k].value(),
            );
            summary.momentum[k] += momentum.total();
        }
    }
}

/// Keeps the greatest of the speeds, and the lowest number of a particle that has it. The speeds beyond the numbers are zero.
#[inline(always)]
fn keep_fastest<const D: usize>(speeds: &[f64; BATCH], numbers: &[u32], summary: &mut Summary<D>) {
    let mut greatest = [0.0; LANES];
    for begin in (0..BATCH).step_by(LANES) {
        for lane in 0..LANES {
            let speed = speeds[begin + lane];
            greatest[lane] = if speed > greatest[lane] { speed } else { greatest[lane] };
        }
    }
    // As for most batches.
    if greatest.iter().all(|&speed| speed < summary.fastest.0) {
        return;
    }
    for (&speed, &number) in speeds.iter().zip(numbers) {
        if speed >= summary.fastest.0 {
            let tied = speed <= summary.fastest.0;
            let number = if tied { number.min(summary.fastest.1) } else { number };
            summary.fastest = (speed, number);
        }
    }
}
