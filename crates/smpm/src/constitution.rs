//! A material with the states of its particles, and the pass over them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use lanes::dispatch as in_widest_registers;

use crate::binning::permute;
use crate::config::{BulkViscosity, Config};
use crate::error::Fault;
use crate::material::{LocalResponse, LocalState, Material, Now, Observed};
use crate::number::{Number, is_finite, is_plain};
use crate::parallel::join;
use crate::particles::Chunk;
use crate::tensor::{Symmetric, in_plane, volume_change};
use crate::transfer::Sweep;

/// What the material made of a particle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Condition<S> {
    /// Cauchy stress without the bulk viscosity.
    pub(crate) stress: Symmetric<S>,
    /// The bulk viscosity, a pressure.
    pub(crate) viscosity: S,
    /// `V/V_0`.
    pub(crate) volume: S,
    /// Speed of a longitudinal wave.
    pub(crate) wave_speed: S,
    /// `tr L` of the last step.
    pub(crate) rate: f64,
}

/// A material with the states of its particles, whatever their type: the loop over particles sees one material.
pub(crate) trait Constitution<S, const D: usize>: std::fmt::Debug + Send + Sync {
    /// Does with every particle what the sweep asks for.
    fn sweep(&mut self, chunk: Chunk<'_, S, D>, sweep: &Sweep<'_, S, D>) -> Summary<D>;
    fn conditions(&self) -> &[Condition<S>];
    fn observe(&self, place: usize) -> Observed<S>;
    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>>;
    fn permute(&mut self, order: &[u32], done: &mut Vec<bool>);
    /// Calls with a copy of every number of a particle's state and condition; whether that is all of it.
    fn show_numbers(&self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool;
    /// The same with the numbers themselves, to be written.
    fn visit_numbers(&mut self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool;
}

/// What a sweep has seen, of values.
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

    fn and(self, other: Self) -> Self {
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

    fn fail(&mut self, number: u32, fault: Fault) {
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

/// Particles that go through a sweep together: what they take stays in the nearest cache.
const BATCH: usize = 32;
/// Particles of a thread's share at least, a multiple of a batch.
const SHARE: usize = 1024;

#[derive(Debug)]
pub(crate) struct Particular<M: Material<S>, S: Number> {
    material: M,
    density: S,
    states: Vec<M::State>,
    conditions: Vec<Condition<S>>,
}

impl<M: Material<S>, S: Number> Particular<M, S> {
    /// All particles as they start, at their places.
    #[inline(never)]
    pub(crate) fn at_start(material: M, places: &[[f64; 3]]) -> Self {
        let states: Vec<_> = places.iter().map(|&place| material.start(place)).collect();
        let one = S::constant(1.0);
        let condition = |state: &M::State| Condition {
            stress: material.start_stress(state),
            viscosity: S::constant(0.0),
            volume: one,
            wave_speed: material.wave_speed(one, state),
            rate: 0.0,
        };
        let conditions = states.iter().map(condition).collect();
        Self { density: material.density(), material, states, conditions }
    }
}

/// What a step does to the material of every particle.
#[derive(Debug, Clone, Copy)]
struct Motion {
    dt: f64,
    time: f64,
    cell: f64,
    viscosity: BulkViscosity,
}

/// The materials of a batch over a step; of several faults, that of the particle with the lowest number. Without the
/// dimension: this is most of the code of a material, and there is one of it for each kind of number; of plain numbers another
/// for motion that is known to stay in the plane of the first two axes.
#[inline(never)]
fn update_batch<M: Material<S>, S: Number, const PLANE: bool>(
    of: (&M, S),
    motion: Motion,
    gradients: &[[[S; 3]; 3]],
    (states, conditions): (&mut [M::State], &mut [Condition<S>]),
    numbers: &[u32],
) -> Option<(u32, Fault)> {
    in_widest_registers(
        #[inline(always)]
        || {
            let mut first: Option<(u32, Fault)> = None;
            let n = gradients.len();
            let (states, conditions) = (&mut states[..n], &mut conditions[..n]);
            for i in 0..n {
                let (state, condition) = (&mut states[i], &mut conditions[i]);
                let l = if PLANE { in_plane(&gradients[i]) } else { gradients[i] };
                if let Err(fault) = next(of, motion, &l, state, condition)
                    && first.is_none_or(|(lowest, _)| numbers[i] < lowest)
                {
                    first = Some((numbers[i], fault));
                }
            }
            first
        },
    )
}

/// One particle over a step.
#[inline(always)]
fn next<M: Material<S>, S: Number>(
    (material, density): (&M, S),
    Motion { dt, time, cell, viscosity }: Motion,
    l: &[[S; 3]; 3],
    state: &mut M::State,
    condition: &mut Condition<S>,
) -> Result<(), Fault> {
    let volume = condition.volume * volume_change(l, dt);
    if !(volume.value() > 0.0 && is_finite(volume.value())) {
        let must = "above 0 and finite";
        return Err(Fault { quantity: "V/V_0", value: volume.value(), must });
    }
    let trace = l[0][0] + l[1][1] + l[2][2];
    let q = if trace.value() < 0.0 {
        let slope = trace * (viscosity.quadratic * cell) - condition.wave_speed * viscosity.linear;
        density / volume * slope * trace * cell
    } else {
        S::constant(0.0)
    };
    let now = Now {
        velocity_gradient: *l,
        dt,
        time,
        volume_before: condition.volume,
        volume,
        viscosity: q,
        cell,
    };
    let stress = material.update(&now, state)?;
    // A sum is not finite if a term is not; then one is to be found, or the sum itself is too large.
    let mut sum = q.value();
    for k in 0..6 {
        sum += stress.0[k].value();
    }
    if !is_finite(sum) {
        let value = stress.values().into_iter().find(|value| !value.is_finite()).unwrap_or(sum);
        return Err(Fault { quantity: "stress", value, must: "finite" });
    }
    let wave_speed = material.wave_speed(volume, state);
    let c = wave_speed.value();
    if !(c >= 0.0 && is_finite(c)) {
        return Err(Fault { quantity: "wave speed", value: c, must: "0 or above and finite" });
    }
    *condition = Condition { stress, viscosity: q, volume, wave_speed, rate: trace.value() };
    Ok(())
}

/// A chunk with what the material keeps of its particles.
struct Portion<'a, M: Material<S>, S: Number, const D: usize> {
    material: &'a M,
    density: S,
    chunk: Chunk<'a, S, D>,
    states: &'a mut [M::State],
    conditions: &'a mut [Condition<S>],
}

impl<M: Material<S>, S: Number, const D: usize> Portion<'_, M, S, D> {
    #[inline]
    fn split(self, middle: usize) -> (Self, Self) {
        let Self { material, density, chunk, states, conditions } = self;
        let (low, high) = chunk.split(middle);
        let (states, further_states) = states.split_at_mut(middle);
        let (conditions, further) = conditions.split_at_mut(middle);
        (
            Self { material, density, chunk: low, states, conditions },
            Self { material, density, chunk: high, states: further_states, conditions: further },
        )
    }

    /// In halves down to a share: the sums have a shape that the number of particles alone decides.
    fn sweep(self, sweep: &Sweep<'_, S, D>) -> Summary<D> {
        let n = self.chunk.len();
        if n > SHARE {
            let (low, high) = self.split((n / 2).next_multiple_of(BATCH));
            let (one, two) = join(|| low.sweep(sweep), || high.sweep(sweep));
            return one.and(two);
        }
        let mut summary = Summary::none();
        let mut gradients = [[[S::constant(0.0); 3]; 3]; BATCH];
        let (mut batch, mut rest) = self.split(BATCH.min(n));
        loop {
            batch.sweep_batch(sweep, &mut gradients, &mut summary);
            let left = rest.chunk.len();
            if left == 0 {
                break;
            }
            (batch, rest) = rest.split(BATCH.min(left));
        }
        summary
    }

    fn sweep_batch(
        &mut self,
        sweep: &Sweep<'_, S, D>,
        gradients: &mut [[[S; 3]; 3]; BATCH],
        summary: &mut Summary<D>,
    ) {
        let n = self.chunk.len();
        sweep.carrier.take(&mut self.chunk, &mut gradients[..n], sweep);
        let Self { material, density, chunk, states, conditions } = self;
        if sweep.pass.updates_stress() {
            let Config { cell, viscosity, .. } = *sweep.config;
            let motion = Motion { dt: sweep.dt, time: sweep.time, cell, viscosity };
            let kept = (&mut **states, &mut **conditions);
            let of = (*material, *density);
            let (gradients, numbers) = (&gradients[..n], chunk.number);
            let fault = if const { D < 3 && is_plain::<S>() } {
                update_batch::<M, S, true>(of, motion, gradients, kept, numbers)
            } else {
                update_batch::<M, S, false>(of, motion, gradients, kept, numbers)
            };
            if let Some((number, fault)) = fault {
                summary.fail(number, fault);
            }
        }
        if sweep.pass.moves() {
            move_batch(chunk, conditions, sweep, summary);
            add_energies(*material, states, chunk.reference_volume, &mut summary.internal);
        }
    }
}

/// Particles of a batch to where they stand at the end of the step, and what is seen of them there. Without the material, of
/// which there are more than of dimensions.
#[inline(never)]
fn move_batch<S: Number, const D: usize>(
    chunk: &mut Chunk<'_, S, D>,
    conditions: &[Condition<S>],
    sweep: &Sweep<'_, S, D>,
    summary: &mut Summary<D>,
) {
    let is_everywhere = in_widest_registers(
        #[inline(always)]
        || {
            look(chunk, conditions, sweep.config, summary);
            chunk.advance(sweep)
        },
    );
    if !is_everywhere {
        for i in 0..chunk.len() {
            if let Err(fault) = chunk.check(i, sweep.config) {
                summary.fail(chunk.number[i], fault);
            }
        }
    }
}

/// Adds a batch to what is seen.
#[inline(always)]
fn look<S: Number, const D: usize>(
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

/// Adds the internal energies of a batch, one by one.
#[inline(never)]
fn add_energies<M: Material<S>, S: Number>(
    material: &M,
    states: &[M::State],
    volumes: &[f64],
    sum: &mut f64,
) {
    for (state, volume) in states.iter().zip(volumes) {
        *sum += material.energy(state).value() * volume;
    }
}

impl<M: Material<S> + 'static, S: Number, const D: usize> Constitution<S, D> for Particular<M, S>
where
    M::State: 'static,
{
    fn sweep(&mut self, chunk: Chunk<'_, S, D>, sweep: &Sweep<'_, S, D>) -> Summary<D> {
        let Self { material, density, states, conditions } = self;
        Portion { material, density: *density, chunk, states, conditions }.sweep(sweep)
    }

    fn conditions(&self) -> &[Condition<S>] {
        &self.conditions
    }

    fn observe(&self, place: usize) -> Observed<S> {
        self.material.observe(&self.states[place])
    }

    fn permute(&mut self, order: &[u32], done: &mut Vec<bool>) {
        permute(&mut self.states, order, done);
        permute(&mut self.conditions, order, done);
    }

    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>> {
        self.material.at_local_state(state)
    }

    fn show_numbers(&self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool {
        let (mut condition, mut state) = (self.conditions[place], self.states[place]);
        condition.visit_numbers(visit);
        self.material.visit_numbers(&mut state, visit)
    }

    fn visit_numbers(&mut self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool {
        self.conditions[place].visit_numbers(visit);
        self.material.visit_numbers(&mut self.states[place], visit)
    }
}

impl<S: Number> Condition<S> {
    fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut S)) {
        let Self { stress, viscosity, volume, wave_speed, rate } = self;
        let mut number = S::constant(*rate);
        let others = [viscosity, volume, wave_speed, &mut number];
        stress.0.iter_mut().chain(others).for_each(visit);
        *rate = number.value();
    }
}
