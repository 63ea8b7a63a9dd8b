//! A material with the states of its particles, several particles at once in the lanes of registers.
//!
//! Each lane has the bits of its particle alone: what does not fill a register goes one by one, and so does a register in which a
//! particle fails, so that the fault is that of the particle.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::Range;

use perturbation_moments::InLanes;
use simd_lanes::{Registers, SimdLevel, Work, dispatch_narrow};

use crate::grid::binning::permute_by;
use crate::points::conditions::{Columns, ColumnsMut, Condition, Conditions};
use crate::points::material_points::{
    Halves, MaterialPoints, MaterialUpdate, Next, Strain, keep_lowest, next,
};
use crate::points::summary::Sums;
use crate::transfer::velocity_gradients::VelocityGradients;
use constitutive_models::Fault;
use constitutive_models::tensor::in_plane;
use constitutive_models::{LocalResponse, LocalState, Material, MaterialFamily, Observed};

#[cfg(test)]
mod tests;

/// Particles of a block: of each number of their states, those of a block are adjacent in memory.
const BLOCK: usize = 8;

/// A material with what it keeps of all particles of a body, for those whose text serves several particles at once.
pub(crate) struct PointsInLanes<M: MaterialFamily<f64>> {
    material: M,
    density: f64,
    /// Whether the motion is known to stay in the plane of the first two axes.
    plane: bool,
    level: SimdLevel,
    states: Vec<f64>,
    layout: Layout<M::State>,
    conditions: Conditions<f64>,
}

/// How the states of particles are in memory: block by block, number by number, particle by particle.
#[derive(Debug, Clone, Copy)]
struct Layout<T> {
    /// Numbers of a block.
    stride: usize,
    /// Any state, to be overwritten.
    blank: T,
}

impl<T: Copy> Layout<T> {
    /// Where the first number of a particle is.
    #[inline(always)]
    fn place(&self, particle: usize) -> usize {
        particle / BLOCK * self.stride + particle % BLOCK
    }

    /// Behind the block of a particle.
    #[inline(always)]
    fn end(&self, particle: usize) -> usize {
        (particle / BLOCK + 1) * self.stride
    }

    /// The state of one particle.
    #[inline(always)]
    fn load<M: Material<f64, State = T>>(
        &self,
        material: &M,
        states: &[f64],
        particle: usize,
    ) -> T {
        let (mut state, mut place) = (self.blank, self.place(particle));
        let states = &states[..self.end(particle)];
        material.visit_numbers(
            &mut state,
            #[inline(always)]
            |number| {
                // All are there; without a panic, a number that nobody reads is not loaded.
                *number = states.get(place).copied().unwrap_or(f64::NAN);
                place += BLOCK;
            },
        );
        state
    }

    #[inline(always)]
    fn store<M: Material<f64, State = T>>(
        &self,
        material: &M,
        states: &mut [f64],
        (particle, mut state): (usize, T),
    ) {
        let mut place = self.place(particle);
        material.visit_numbers(
            &mut state,
            #[inline(always)]
            |number| {
                states[place] = *number;
                place += BLOCK;
            },
        );
    }
}

impl<M: MaterialFamily<f64>> PointsInLanes<M> {
    /// All particles as they start, at their places.
    pub(crate) fn at_start(material: M, plane: bool, places: &[[f64; 3]]) -> Self {
        let starts: Vec<M::State> = places.iter().map(|&place| material.start(place)).collect();
        Self::of_states(material, plane, &starts)
    }

    /// Particles in these states; at least one.
    #[inline(never)]
    pub(crate) fn of_states(material: M, plane: bool, starts: &[M::State]) -> Self {
        let mut blank = starts[0];
        let mut n_numbers = 0;
        material.visit_numbers(&mut blank, |_| n_numbers += 1);
        let layout = Layout { stride: n_numbers * BLOCK, blank };
        let mut states = vec![0.0; starts.len().div_ceil(BLOCK) * layout.stride];
        let conditions = Conditions::of(starts.iter().enumerate().map(|(particle, state)| {
            layout.store(&material, &mut states, (particle, *state));
            Condition::at_start(&material, state)
        }));
        let (density, level) = (material.density(), SimdLevel::best());
        Self { material, density, plane, level, states, layout, conditions }
    }

    fn state(&self, particle: usize) -> M::State {
        self.layout.load(&self.material, &self.states, particle)
    }
}

/// A material with what it keeps of a run of particles that begins with a block.
struct Portion<'a, M: MaterialFamily<f64>> {
    material: &'a M,
    density: f64,
    plane: bool,
    level: SimdLevel,
    states: &'a mut [f64],
    layout: Layout<M::State>,
    conditions: ColumnsMut<'a, f64>,
}

impl<M: MaterialFamily<f64>> MaterialUpdate<f64> for Portion<'_, M> {
    fn split(&mut self, middle: usize, work: &mut Halves<'_, f64>) {
        let Self { material, density, plane, level, layout, .. } = *self;
        let (states, further_states) = self.states.split_at_mut(middle / BLOCK * layout.stride);
        let (conditions, further) = self.conditions.halves(middle);
        let mut low = Portion { material, density, plane, level, states, layout, conditions };
        let (states, conditions) = (further_states, further);
        let mut high = Portion { material, density, plane, level, states, layout, conditions };
        work(&mut low, &mut high);
    }

    fn update(
        &mut self,
        range: Range<usize>,
        strain: Strain,
        velocity_gradients: &VelocityGradients<f64>,
        numbers: &[u32],
    ) -> Option<(u32, Fault)> {
        let blocks = range.start / BLOCK..range.end.div_ceil(BLOCK);
        let stride = self.layout.stride;
        self.level.run(Batch {
            material: self.material,
            density: self.density,
            plane: self.plane,
            states: &mut self.states[blocks.start * stride..blocks.end * stride],
            layout: self.layout,
            conditions: self.conditions.part(range),
            strain,
            velocity_gradients,
            numbers,
        })
    }

    fn conditions(&self) -> Columns<'_, f64> {
        self.conditions.columns()
    }

    fn add_energies(&self, range: Range<usize>, reference_volumes: &[f64], sum: &mut f64) {
        *sum += dispatch_narrow(
            #[inline(always)]
            || {
                let mut energies = Sums::none();
                energies.add(
                    reference_volumes.len(),
                    #[inline(always)]
                    |i| {
                        let state = self.layout.load(self.material, self.states, range.start + i);
                        self.material.energy(&state) * reference_volumes[i]
                    },
                );
                energies.total()
            },
        );
    }
}

/// Particles over a step, from the first of a block on.
struct Batch<'a, M: MaterialFamily<f64>> {
    material: &'a M,
    density: f64,
    plane: bool,
    states: &'a mut [f64],
    layout: Layout<M::State>,
    conditions: ColumnsMut<'a, f64>,
    strain: Strain,
    velocity_gradients: &'a VelocityGradients<f64>,
    numbers: &'a [u32],
}

/// A material and its density, in the lanes of registers.
type InRegisters<M, R> = (<M as MaterialFamily<f64>>::In<InLanes<Vector<R>>>, InLanes<Vector<R>>);

type Vector<R> = <R as Registers<f64>>::Vector;

impl<M: MaterialFamily<f64>> Work<f64> for Batch<'_, M> {
    type Output = Option<(u32, Fault)>;

    #[inline(always)]
    fn run<R: Registers<f64>>(mut self, registers: R) -> Option<(u32, Fault)> {
        let material = self.material.in_numbers(
            #[inline(always)]
            |number| InLanes(registers.splat(number)),
        );
        let material = (material, InLanes(registers.splat(self.density)));
        let (n, mut at, mut first) = (self.numbers.len(), 0, None);
        while at + R::N <= n {
            if !self.register(registers, &material, at) {
                self.one_by_one(at..at + R::N, &mut first);
            }
            at += R::N;
        }
        if at < n {
            self.one_by_one(at..n, &mut first);
        }
        first
    }
}

impl<M: MaterialFamily<f64>> Batch<'_, M> {
    /// As many particles as a register has lanes, from one on; whether none of them failed, else nothing has changed.
    #[inline(always)]
    fn register<R: Registers<f64>>(
        &mut self,
        registers: R,
        (material, density): &InRegisters<M, R>,
        at: usize,
    ) -> bool {
        let l = self.velocity_gradient(registers, at);
        let before = self.before(registers, at);
        let (mut state, first) = (self.material.filled(before.0), self.layout.place(at));
        let mut place = first;
        material.visit_numbers(
            &mut state,
            #[inline(always)]
            |number| {
                *number = InLanes(registers.load_at(self.states, place));
                place += BLOCK;
            },
        );
        let mut after = Next::blank(before.0);
        let of = (material, *density);
        if next(of, self.strain, &l, before, (&mut state, &mut after)).is_err() {
            return false;
        }
        place = first;
        material.visit_changing(
            &mut state,
            #[inline(always)]
            |number| {
                registers.store_at(number.0, self.states, place);
                place += BLOCK;
            },
        );
        self.keep(registers, at, &after);
        true
    }

    /// The velocity gradients of particles; zero out of the plane where they are known to be.
    #[inline(always)]
    fn velocity_gradient<R: Registers<f64>>(
        &self,
        registers: R,
        at: usize,
    ) -> [[InLanes<Vector<R>>; 3]; 3] {
        let mut gathered = [[InLanes(registers.splat(0.0)); 3]; 3];
        for i in 0..3 {
            for k in 0..3 {
                if !self.plane || (i == 2) == (k == 2) {
                    let entries = self.velocity_gradients.entries(i, k);
                    gathered[i][k] = InLanes(registers.load_at(entries, at));
                }
            }
        }
        gathered
    }

    /// `V/V_0` and wave speed before the step.
    #[inline(always)]
    fn before<R: Registers<f64>>(
        &self,
        registers: R,
        at: usize,
    ) -> (InLanes<Vector<R>>, InLanes<Vector<R>>) {
        let ColumnsMut { volume, wave_speed, .. } = &self.conditions;
        (InLanes(registers.load_at(volume, at)), InLanes(registers.load_at(wave_speed, at)))
    }

    /// Keeps the conditions after the step.
    #[inline(always)]
    fn keep<R: Registers<f64>>(
        &mut self,
        registers: R,
        at: usize,
        next: &Next<InLanes<Vector<R>>>,
    ) {
        let ColumnsMut { stress, viscosity, volume, wave_speed, rate } = &mut self.conditions;
        for k in 0..6 {
            registers.store_at(next.stress.0[k].0, stress[k], at);
        }
        registers.store_at(next.viscosity.0, viscosity, at);
        registers.store_at(next.volume.0, volume, at);
        registers.store_at(next.wave_speed.0, wave_speed, at);
        registers.store_at(next.rate.0, rate, at);
    }

    /// Particles that do not fill a register, or of which one fails.
    #[inline(never)]
    fn one_by_one(&mut self, range: Range<usize>, first: &mut Option<(u32, Fault)>) {
        for i in range {
            let l = self.velocity_gradients.get(i);
            let l = if self.plane { in_plane(&l) } else { l };
            let mut state = self.layout.load(self.material, self.states, i);
            let before = (self.conditions.volume[i], self.conditions.wave_speed[i]);
            let (of, mut after) = ((self.material, self.density), Next::blank(before.0));
            match next(of, self.strain, &l, before, (&mut state, &mut after)) {
                Ok(()) => {
                    self.conditions.set(i, after.into());
                    self.layout.store(self.material, self.states, (i, state));
                }
                Err(fault) => keep_lowest(first, (self.numbers[i], fault)),
            }
        }
    }
}

impl<M: MaterialFamily<f64> + 'static> MaterialPoints<f64> for PointsInLanes<M>
where
    M::State: 'static,
{
    fn pass(&mut self, work: &mut dyn FnMut(&mut dyn MaterialUpdate<f64>)) {
        let Self { material, density, plane, level, states, layout, conditions } = self;
        let (density, plane, level, layout) = (*density, *plane, *level, *layout);
        let conditions = conditions.columns_mut();
        work(&mut Portion { material, density, plane, level, states, layout, conditions });
    }

    fn conditions(&self) -> Columns<'_, f64> {
        self.conditions.columns()
    }

    fn observe(&self, place: usize) -> Observed<f64> {
        self.material.observe(&self.state(place))
    }

    fn permute(&mut self, order: &[u32], done: &mut Vec<bool>) {
        let Self { material, states, layout, .. } = self;
        let read = |states: &[f64], particle: usize| layout.load(material, states, particle);
        let write = |states: &mut [f64], particle: usize, state: M::State| {
            layout.store(material, states, (particle, state));
        };
        permute_by(states.as_mut_slice(), order, done, read, write);
        self.conditions.permute(order, done);
    }

    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<f64>> {
        self.material.at_local_state(state)
    }

    fn show_numbers(&self, place: usize, visit: &mut dyn FnMut(&mut f64)) -> bool {
        let (mut condition, mut state) = (self.conditions.columns().get(place), self.state(place));
        condition.visit_numbers(visit);
        self.material.visit_numbers(&mut state, visit)
    }

    fn visit_numbers(&mut self, place: usize, visit: &mut dyn FnMut(&mut f64)) -> bool {
        let mut conditions = self.conditions.columns_mut();
        let mut condition = conditions.get(place);
        condition.visit_numbers(visit);
        conditions.set(place, condition);
        let mut state = self.state(place);
        let is_all = self.material.visit_numbers(&mut state, visit);
        self.layout.store(&self.material, &mut self.states, (place, state));
        is_all
    }
}

impl<M: MaterialFamily<f64>> std::fmt::Debug for PointsInLanes<M> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { material, density, states, conditions, .. } = self;
        let mut fields = formatter.debug_struct("PointsInLanes");
        fields.field("material", material).field("density", density);
        fields.field("states", states).field("conditions", conditions).finish()
    }
}
