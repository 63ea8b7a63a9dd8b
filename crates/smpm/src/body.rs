//! A body: particles of one material.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::sync::OnceLock;

use perturbation_moments::in_widest_registers;

use crate::binning::{Binning, permute};
use crate::config::{Config, Geometry, Transfer, UpdateOrder};
use crate::error::{Error, Fault, finite, positive};
use crate::material::{LocalResponse, LocalState, Material, Now, Observed};
use crate::number::Number;
use crate::parallel::join;
use crate::shape::Shape;
use crate::tensor::{Symmetric, volume_change};
use crate::transfer::Sweep;

/// A body: particles of one material, in `D` dimensions, with numbers `S`.
///
/// A particle has the number that its place has in [`Fill::positions`], for good: what the body gives out, and errors, are by
/// this number. In memory particles move, so that those of a cell stand together.
#[derive(Debug)]
pub struct Body<S, const D: usize> {
    pub(crate) particles: Particles<S, D>,
    pub(crate) constitution: Box<dyn Constitution<S, D>>,
    pub(crate) binning: Binning<D>,
    /// The edges of the box that each particle stood for at the start (length).
    spacing: [f64; D],
    /// Where each particle is in memory; empty while all are at their numbers.
    places: Vec<u32>,
    views: Views<S, D>,
}

/// Columns by the numbers of particles, made when asked for.
#[derive(Debug)]
struct Views<S, const D: usize> {
    positions: OnceLock<Vec<[S; D]>>,
    velocities: OnceLock<Vec<[S; D]>>,
    masses: OnceLock<Vec<S>>,
}

impl<S, const D: usize> Views<S, D> {
    fn none() -> Self {
        let (positions, velocities) = (OnceLock::new(), OnceLock::new());
        Self { positions, velocities, masses: OnceLock::new() }
    }

    fn forget(&mut self) {
        *self = Self::none();
    }
}

/// Where the particles of a body start.
#[derive(Debug, Clone, PartialEq)]
pub struct Fill<const D: usize> {
    /// Their places (length).
    pub positions: Vec<[f64; D]>,
    /// The distance between them along each axis (length); each stands for a box of that size.
    pub spacing: [f64; D],
}

impl<const D: usize> Fill<D> {
    /// Places at the centres of the boxes of a lattice from `low` to `high` that lie inside a shape.
    ///
    /// ```
    /// use smpm::Fill;
    ///
    /// let disk = Fill::of([0.5, 0.5], ([-1.0, -1.0], [1.0, 1.0]), |[x, y]| x * x + y * y < 1.0);
    /// assert_eq!(disk.positions.len(), 12); // of 16, the four corners lie outside
    /// ```
    #[must_use]
    pub fn of(
        spacing: [f64; D],
        (low, high): ([f64; D], [f64; D]),
        inside: impl Fn(&[f64; D]) -> bool,
    ) -> Self {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of boxes; what is not finite gives none"
        )]
        let count: [usize; D] =
            std::array::from_fn(|k| ((high[k] - low[k]) / spacing[k]).round().max(0.0) as usize);
        let total: usize = count.iter().product();
        let positions = (0..total)
            .map(|index| {
                let mut rest = index;
                std::array::from_fn(|k| {
                    let along = rest % count[k];
                    rest /= count[k];
                    low[k] + (along as f64 + 0.5) * spacing[k]
                })
            })
            .filter(|place| inside(place))
            .collect();
        Self { positions, spacing }
    }
}

/// What every particle carries besides the state of its material, in the order of memory. A column that no step of the
/// configuration needs is empty.
#[derive(Debug)]
pub(crate) struct Particles<S, const D: usize> {
    pub(crate) position: Vec<[S; D]>,
    pub(crate) velocity: Vec<[S; D]>,
    /// By how much the step moves it, where it does not move at once.
    pub(crate) displacement: Vec<[S; D]>,
    /// APIC's matrix.
    pub(crate) affine: Vec<[[S; D]; D]>,
    /// Half its length along each axis (length), with GIMP.
    pub(crate) half_length: Vec<[S; D]>,
    /// The same at the end of the step.
    pub(crate) stretched: Vec<[S; D]>,
    pub(crate) mass: Vec<S>,
    /// Its volume in the reference state; per radian where axisymmetric.
    pub(crate) reference_volume: Vec<f64>,
    /// Its number.
    pub(crate) number: Vec<u32>,
}

/// A run of particles; columns that are empty are so in every chunk.
#[derive(Debug)]
pub(crate) struct Chunk<'a, S, const D: usize> {
    pub(crate) position: &'a mut [[S; D]],
    pub(crate) velocity: &'a mut [[S; D]],
    pub(crate) displacement: &'a mut [[S; D]],
    pub(crate) affine: &'a mut [[[S; D]; D]],
    pub(crate) half_length: &'a mut [[S; D]],
    pub(crate) stretched: &'a mut [[S; D]],
    pub(crate) mass: &'a [S],
    pub(crate) reference_volume: &'a [f64],
    pub(crate) number: &'a [u32],
    /// The lowest node that it sees.
    pub(crate) base: &'a [[i32; D]],
    pub(crate) slot: &'a [u32],
}

/// Both parts of a column, of one that may be empty too.
fn halves<T>(column: &mut [T], middle: usize) -> (&mut [T], &mut [T]) {
    column.split_at_mut(middle.min(column.len()))
}

impl<S, const D: usize> Chunk<'_, S, D> {
    pub(crate) fn len(&self) -> usize {
        self.position.len()
    }

    fn split(&mut self, middle: usize) -> (Chunk<'_, S, D>, Chunk<'_, S, D>) {
        let (position, positions) = halves(self.position, middle);
        let (velocity, velocities) = halves(self.velocity, middle);
        let (displacement, displacements) = halves(self.displacement, middle);
        let (affine, affines) = halves(self.affine, middle);
        let (half_length, half_lengths) = halves(self.half_length, middle);
        let (stretched, stretcheds) = halves(self.stretched, middle);
        let (mass, masses) = self.mass.split_at(middle);
        let (reference_volume, reference_volumes) = self.reference_volume.split_at(middle);
        let (number, numbers) = self.number.split_at(middle);
        let (base, bases) = self.base.split_at(middle);
        let (slot, slots) = self.slot.split_at(middle);
        (
            Chunk {
                position,
                velocity,
                displacement,
                affine,
                half_length,
                stretched,
                mass,
                reference_volume,
                number,
                base,
                slot,
            },
            Chunk {
                position: positions,
                velocity: velocities,
                displacement: displacements,
                affine: affines,
                half_length: half_lengths,
                stretched: stretcheds,
                mass: masses,
                reference_volume: reference_volumes,
                number: numbers,
                base: bases,
                slot: slots,
            },
        )
    }
}

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

/// Coefficients of the bulk viscosity,
///
/// $$ q = \rho h (q_0 h (\mathrm{tr} L)^2 - q_1 c \mathrm{tr} L), \quad \mathrm{tr} L < 0, $$
///
/// with the cell `h` and the wave speed `c` (von Neumann & Richtmyer 1950; Landshoff 1955). Zero under expansion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BulkViscosity {
    /// `q_0 >= 0`, quadratic: spreads strong shocks over a few cells.
    pub quadratic: f64,
    /// `q_1 >= 0`, linear: damps the ripple behind them.
    pub linear: f64,
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
struct Particular<M: Material<S>, S: Number> {
    material: M,
    density: S,
    states: Vec<M::State>,
    conditions: Vec<Condition<S>>,
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
/// dimension: this is most of the code of a material, and there is one of it for each kind of number.
#[inline(never)]
fn update_batch<M: Material<S>, S: Number>(
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
            for i in 0..gradients.len() {
                let (state, condition) = (&mut states[i], &mut conditions[i]);
                if let Err(fault) = next(of, motion, &gradients[i], state, condition)
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
    if !(volume.value() > 0.0 && volume.value().is_finite()) {
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
    // A sum is finite if all its terms are; else one is to be found, or the sum itself is too large.
    let mut sum = q.value();
    for k in 0..6 {
        sum += stress.0[k].value().abs();
    }
    if !sum.is_finite() {
        let value = stress.values().into_iter().find(|value| !value.is_finite()).unwrap_or(sum);
        return Err(Fault { quantity: "stress", value, must: "finite" });
    }
    let wave_speed = material.wave_speed(volume, state);
    let c = wave_speed.value();
    if !(c >= 0.0 && c.is_finite()) {
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
    fn split(&mut self, middle: usize) -> (Portion<'_, M, S, D>, Portion<'_, M, S, D>) {
        let (material, density) = (self.material, self.density);
        let (low, high) = self.chunk.split(middle);
        let (states, further_states) = self.states.split_at_mut(middle);
        let (conditions, further) = self.conditions.split_at_mut(middle);
        (
            Portion { material, density, chunk: low, states, conditions },
            Portion { material, density, chunk: high, states: further_states, conditions: further },
        )
    }

    /// In halves down to a share: the sums have a shape that the number of particles alone decides.
    fn sweep(&mut self, sweep: &Sweep<'_, S, D>) -> Summary<D> {
        let n = self.chunk.len();
        if n > SHARE {
            let (mut low, mut high) = self.split((n / 2).next_multiple_of(BATCH));
            let (one, two) = join(|| low.sweep(sweep), || high.sweep(sweep));
            return one.and(two);
        }
        let mut summary = Summary::none();
        let mut gradients = [[[S::constant(0.0); 3]; 3]; BATCH];
        let mut start = 0;
        while start < n {
            let (_, mut rest) = self.split(start);
            let (mut batch, _) = rest.split(BATCH.min(n - start));
            batch.sweep_batch(sweep, &mut gradients, &mut summary);
            start += BATCH;
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
            let fault = update_batch(of, motion, &gradients[..n], kept, chunk.number);
            if let Some((number, fault)) = fault {
                summary.fail(number, fault);
            }
        }
        in_widest_registers(
            #[inline(always)]
            || {
                if sweep.pass.moves() {
                    for i in 0..n {
                        if let Err(fault) = chunk.move_one(i, sweep) {
                            summary.fail(chunk.number[i], fault);
                        }
                        let velocity = &chunk.velocity[i];
                        let speed = signal_speed(velocity, &conditions[i], sweep.config);
                        let number = chunk.number[i];
                        if speed > summary.fastest.0
                            || (speed >= summary.fastest.0 && number < summary.fastest.1)
                        {
                            summary.fastest = (speed, number);
                        }
                        let mass = chunk.mass[i].value();
                        for k in 0..D {
                            let v = velocity[k].value();
                            summary.momentum[k] += mass * v;
                            summary.kinetic += 0.5 * mass * v * v;
                        }
                        let energy = material.energy(&states[i]).value();
                        summary.internal += energy * chunk.reference_volume[i];
                    }
                }
            },
        );
    }
}

impl<S: Number, const D: usize> Chunk<'_, S, D> {
    /// What is left to do at the end of a step: `x += dt sum_i v_i N_i`; with GIMP the particle's lengths follow the strain
    /// (Chen et al. 2019, eq 8).
    #[inline(always)]
    fn move_one(&mut self, i: usize, sweep: &Sweep<'_, S, D>) -> Result<(), Fault> {
        let x = &mut self.position[i];
        for k in 0..D {
            if !sweep.pass.takes_motion() {
                x[k] = x[k] + self.displacement[i][k];
            }
            let value = x[k].value();
            if !value.is_finite() {
                return Err(Fault { quantity: "position", value, must: "finite" });
            }
        }
        if sweep.config.geometry == Geometry::Axisymmetric && x[0].value() <= 0.0 {
            return Err(Fault { quantity: "radius", value: x[0].value(), must: "above 0" });
        }
        if sweep.config.shape == Shape::Gimp {
            for k in 0..D {
                let length = self.stretched[i][k];
                self.half_length[i][k] = length;
                let value = length.value() / sweep.config.cell;
                if !(value > 0.0 && value <= 1.0) {
                    let must = "above 0 and at most 1: the grid is too fine for the stretch";
                    return Err(Fault { quantity: "half length in cells", value, must });
                }
            }
        }
        Ok(())
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

/// What snapshots hold of a particle besides its material; columns that the configuration leaves out are `None`.
struct Row<S, const D: usize> {
    position: [S; D],
    velocity: [S; D],
    affine: Option<[[S; D]; D]>,
    half_length: Option<[S; D]>,
    mass: S,
    reference_volume: f64,
}

impl<S: Number, const D: usize> Row<S, D> {
    fn of(particles: &Particles<S, D>, place: usize) -> Self {
        Self {
            position: particles.position[place],
            velocity: particles.velocity[place],
            affine: particles.affine.get(place).copied(),
            half_length: particles.half_length.get(place).copied(),
            mass: particles.mass[place],
            reference_volume: particles.reference_volume[place],
        }
    }

    fn put(self, particles: &mut Particles<S, D>, place: usize) {
        particles.position[place] = self.position;
        particles.velocity[place] = self.velocity;
        if let Some(matrix) = self.affine {
            particles.affine[place] = matrix;
        }
        if let Some(lengths) = self.half_length {
            particles.half_length[place] = lengths;
        }
        particles.mass[place] = self.mass;
        particles.reference_volume[place] = self.reference_volume;
    }

    fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut S)) {
        let mut volume = S::constant(self.reference_volume);
        let affine = self.affine.iter_mut().flat_map(|matrix| matrix.as_flattened_mut());
        let points = self.position.iter_mut().chain(&mut self.velocity).chain(affine);
        let lengths = self.half_length.iter_mut().flatten();
        points.chain(lengths).chain([&mut self.mass, &mut volume]).for_each(visit);
        self.reference_volume = volume.value();
    }
}

impl<S: Number, const D: usize> Body<S, D> {
    /// Particles of a material, all with one velocity.
    ///
    /// # Errors
    /// [`Error::EmptyBody`]; [`Error::NotPositive`] for a spacing or the density, [`Error::NotFinite`] for a place or a
    /// velocity.
    pub fn new<M: Material<S> + 'static>(
        material: M,
        fill: &Fill<D>,
        velocity: [f64; D],
    ) -> Result<Self, Error>
    where
        M::State: 'static,
    {
        for (k, &spacing) in fill.spacing.iter().enumerate() {
            positive("spacing of particles", spacing)?;
            finite("velocity", velocity[k])?;
        }
        let n = fill.positions.len();
        if n == 0 {
            return Err(Error::EmptyBody { spacing: fill.spacing[0] });
        }
        for place in &fill.positions {
            place.iter().try_for_each(|&value| finite("position of a particle", value))?;
        }
        let density = material.density();
        positive("density", density.value())?;
        let (zero, volume) = (S::constant(0.0), fill.spacing.iter().product());
        let start = |place: &[f64; D]| {
            material.start(std::array::from_fn(|k| if k < D { place[k] } else { 0.0 }))
        };
        let states: Vec<_> = fill.positions.iter().map(start).collect();
        let one = S::constant(1.0);
        let conditions = states
            .iter()
            .map(|state| Condition {
                stress: material.start_stress(state),
                viscosity: zero,
                volume: one,
                wave_speed: material.wave_speed(one, state),
                rate: 0.0,
            })
            .collect();
        let particles = Particles {
            position: fill.positions.iter().map(|place| place.map(S::constant)).collect(),
            velocity: vec![velocity.map(S::constant); n],
            displacement: vec![],
            affine: vec![],
            half_length: vec![fill.spacing.map(|length| S::constant(0.5 * length)); n],
            stretched: vec![],
            mass: vec![density * volume; n],
            reference_volume: vec![volume; n],
            number: (0_u32..).take(n).collect(),
        };
        Ok(Self {
            particles,
            constitution: Box::new(Particular { material, density, states, conditions }),
            binning: Binning::of(n),
            spacing: fill.spacing,
            places: vec![],
            views: Views::none(),
        })
    }

    /// Makes the columns that steps of a configuration need, and leaves out those that they do not.
    pub(crate) fn prepare(&mut self, config: &Config<D>) {
        let (n, zero) = (self.n_particles(), S::constant(0.0));
        let Particles { displacement, affine, half_length, stretched, .. } = &mut self.particles;
        if config.update_order == UpdateOrder::ModifiedStressLast {
            displacement.resize(n, [zero; D]);
        }
        if config.transfer == Transfer::Apic {
            affine.resize(n, [[zero; D]; D]);
        }
        if config.shape == Shape::Gimp {
            stretched.clone_from(half_length);
        } else {
            *half_length = vec![];
        }
    }

    /// Does with every particle what the sweep asks for.
    pub(crate) fn sweep(&mut self, sweep: &Sweep<'_, S, D>) -> Summary<D> {
        let Particles {
            position,
            velocity,
            displacement,
            affine,
            half_length,
            stretched,
            mass,
            reference_volume,
            number,
        } = &mut self.particles;
        let Binning { bases: base, slot, .. } = &self.binning;
        let chunk = Chunk {
            position,
            velocity,
            displacement,
            affine,
            half_length,
            stretched,
            mass,
            reference_volume,
            number,
            base,
            slot,
        };
        self.views.forget();
        self.constitution.sweep(chunk, sweep)
    }

    /// Puts the particles into the order of their cells. They are to be binned anew.
    pub(crate) fn sort(&mut self, done: &mut Vec<bool>) {
        let order = self.binning.by_cell();
        let Particles {
            position,
            velocity,
            displacement,
            affine,
            half_length,
            stretched,
            mass,
            reference_volume,
            number,
        } = &mut self.particles;
        permute(position, order, done);
        permute(velocity, order, done);
        permute(displacement, order, done);
        permute(affine, order, done);
        permute(half_length, order, done);
        permute(stretched, order, done);
        permute(mass, order, done);
        permute(reference_volume, order, done);
        permute(number, order, done);
        self.constitution.permute(order, done);
        self.renumbered();
    }

    /// Calls with a copy of every number of a particle, by its place in memory; whether that is all of it.
    pub(crate) fn show_numbers(&self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool {
        Row::of(&self.particles, place).visit_numbers(visit);
        self.constitution.show_numbers(place, visit)
    }

    /// The same with the numbers themselves, to be written.
    pub(crate) fn visit_numbers(&mut self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool {
        let mut row = Row::of(&self.particles, place);
        row.visit_numbers(visit);
        row.put(&mut self.particles, place);
        self.constitution.visit_numbers(place, visit)
    }

    /// To be called when the numbers of the particles have changed places.
    pub(crate) fn renumbered(&mut self) {
        self.find_places();
        self.views.forget();
    }

    /// Notes where each number is in memory.
    fn find_places(&mut self) {
        let number = &self.particles.number;
        self.places.resize(number.len(), 0);
        for (place, &number) in (0_u32..).zip(number) {
            self.places[number as usize] = place;
        }
    }

    /// Where a particle is in memory.
    fn place(&self, particle: usize) -> usize {
        self.places.get(particle).map_or(particle, |&place| place as usize)
    }

    /// A column by the numbers of particles.
    fn by_number<'a, T: Copy>(&self, column: &'a [T], view: &'a OnceLock<Vec<T>>) -> &'a [T] {
        if self.places.is_empty() {
            return column;
        }
        view.get_or_init(|| self.places.iter().map(|&place| column[place as usize]).collect())
    }

    /// Gives every particle the velocity at its place.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a velocity.
    pub fn set_velocities(
        &mut self,
        velocity: impl Fn(&[f64; D]) -> [f64; D],
    ) -> Result<(), Error> {
        let Particles { position, velocity: kept, .. } = &mut self.particles;
        for (place, kept) in position.iter().zip(kept) {
            let value = velocity(&place.map(perturbation_moments::Scalar::value));
            value.iter().try_for_each(|&component| finite("velocity", component))?;
            *kept = value.map(S::constant);
        }
        Ok(())
    }

    /// How many particles it has.
    #[must_use]
    pub fn n_particles(&self) -> usize {
        self.particles.position.len()
    }

    /// Places (length), by the numbers of particles. The first call after a step gathers all; [`Self::position`] is for few.
    #[must_use]
    pub fn positions(&self) -> &[[S; D]] {
        self.by_number(&self.particles.position, &self.views.positions)
    }

    /// The place of a particle (length).
    #[must_use]
    pub fn position(&self, particle: usize) -> [S; D] {
        self.particles.position[self.place(particle)]
    }

    /// Velocities (length per time), by the numbers of particles; gathered as the positions are.
    #[must_use]
    pub fn velocities(&self) -> &[[S; D]] {
        self.by_number(&self.particles.velocity, &self.views.velocities)
    }

    /// The velocity of a particle (length per time).
    #[must_use]
    pub fn velocity(&self, particle: usize) -> [S; D] {
        self.particles.velocity[self.place(particle)]
    }

    /// Masses, by the numbers of particles; per radian where axisymmetric.
    #[must_use]
    pub fn masses(&self) -> &[S] {
        self.by_number(&self.particles.mass, &self.views.masses)
    }

    /// The stress of a particle, without the bulk viscosity.
    #[must_use]
    pub fn stress(&self, particle: usize) -> Symmetric<S> {
        self.constitution.conditions()[self.place(particle)].stress
    }

    /// The pressure of a particle, `-tr(sigma)/3`, without the bulk viscosity.
    #[must_use]
    pub fn pressure(&self, particle: usize) -> S {
        self.stress(particle).trace() * (-1.0 / 3.0)
    }

    /// `V/V_0` of a particle.
    #[must_use]
    pub fn volume_ratio(&self, particle: usize) -> S {
        self.constitution.conditions()[self.place(particle)].volume
    }

    /// The density of a particle (mass per volume).
    #[must_use]
    pub fn density(&self, particle: usize) -> S {
        let (Particles { mass, .. }, place) = (&self.particles, self.place(particle));
        mass[place] / (self.volume_ratio(particle) * self.reference_volume(particle))
    }

    /// The volume of a particle in the reference state; per radian where axisymmetric.
    pub(crate) fn reference_volume(&self, particle: usize) -> f64 {
        self.particles.reference_volume[self.place(particle)]
    }

    /// Half the diagonal of the box that a particle stands for at the start (length).
    pub(crate) fn half_diagonal(&self) -> f64 {
        0.5 * self.spacing.iter().map(|edge| edge * edge).sum::<f64>().sqrt()
    }

    /// What the material shows of a particle besides its stress.
    #[must_use]
    pub fn observe(&self, particle: usize) -> Observed<S> {
        self.constitution.observe(self.place(particle))
    }

    /// Pressure and flow stress by the formulas of its material at a state that is taken for certain; `None` where the
    /// material has none.
    #[must_use]
    pub fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>> {
        self.constitution.at_local_state(state)
    }
}

impl<const D: usize> Body<f64, D> {
    /// The state of a particle without its history.
    #[must_use]
    pub fn local_state(&self, particle: usize) -> LocalState {
        LocalState {
            volume: self.volume_ratio(particle),
            pressure: self.pressure(particle),
            observed: self.observe(particle),
        }
    }
}
