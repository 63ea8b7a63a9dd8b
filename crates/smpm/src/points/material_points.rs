//! A material with the states of its particles: what a step does to them, as far as the transfer knows it.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::Range;

use perturbation_moments::{Real, when};
use simd_lanes::{Mask, dispatch_narrow};

use crate::config::BulkViscosity;
use crate::grid::binning::permute;
use crate::number::CarriedNumber;
use crate::points::conditions::{Columns, ColumnsMut, Condition, Conditions};
use crate::transfer::velocity_gradients::VelocityGradients;
use constitutive_models::Fault;
use constitutive_models::tensor::{Symmetric, in_plane, volume_change};
use constitutive_models::{LocalResponse, LocalState, Material, Now, Observed};

/// What a step does to the material of every particle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strain {
    pub(crate) dt: f64,
    /// At the end of the step.
    pub(crate) time: f64,
    pub(crate) cell: f64,
    pub(crate) viscosity: BulkViscosity,
}

/// The material of particles that are adjacent in memory, as the transfer uses it. A call is for many particles.
pub(crate) trait MaterialUpdate<S>: Send {
    /// Both parts, the first of so many particles, for work on both at once.
    fn split(&mut self, middle: usize, work: &mut Halves<'_, S>);

    /// Brings volume, stress and state of a range of particles to the end of a step; of several faults, that of the particle with
    /// the lowest number.
    fn update(
        &mut self,
        range: Range<usize>,
        strain: Strain,
        velocity_gradients: &VelocityGradients<S>,
        numbers: &[u32],
    ) -> Option<(u32, Fault)>;

    fn conditions(&self) -> Columns<'_, S>;

    /// Adds the internal energies of a range of particles to a sum.
    fn add_energies(&self, range: Range<usize>, reference_volumes: &[f64], sum: &mut f64);
}

/// Work on the materials of two runs of particles.
pub(crate) type Halves<'a, S> =
    dyn FnMut(&mut dyn MaterialUpdate<S>, &mut dyn MaterialUpdate<S>) + 'a;

/// A material with the states of all particles of a body, whatever its type.
pub(crate) trait MaterialPoints<S>: std::fmt::Debug + Send + Sync {
    /// All of them, for a pass.
    fn pass(&mut self, work: &mut dyn FnMut(&mut dyn MaterialUpdate<S>));
    fn conditions(&self) -> Columns<'_, S>;
    fn observe(&self, place: usize) -> Observed<S>;
    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>>;
    fn permute(&mut self, order: &[u32], done: &mut Vec<bool>);
    /// Calls with a copy of every number of a particle's state and condition; whether that is all of it.
    fn show_numbers(&self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool;
    /// The same with the numbers themselves, to be written.
    fn visit_numbers(&mut self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool;
}

/// A material with what it keeps of all particles of a body, one by one: for a material that looks at values.
pub(crate) struct Points<M: Material<S>, S: CarriedNumber> {
    material: M,
    density: S,
    /// Whether the motion is known to stay in the plane of the first two axes.
    plane: bool,
    states: Vec<M::State>,
    conditions: Conditions<S>,
}

impl<M: Material<S>, S: CarriedNumber> Points<M, S> {
    /// All particles as they start, at their places.
    pub(crate) fn at_start(material: M, plane: bool, places: &[[f64; 3]]) -> Self {
        let states: Vec<M::State> = places.iter().map(|&place| material.start(place)).collect();
        Self::of_states(material, plane, &states)
    }

    /// Particles in these states.
    #[inline(never)]
    pub(crate) fn of_states(material: M, plane: bool, states: &[M::State]) -> Self {
        let at_start = |state| Condition::at_start(&material, state);
        let conditions = Conditions::of(states.iter().map(at_start));
        let states = states.to_vec();
        Self { density: material.density(), material, plane, states, conditions }
    }
}

impl<S: CarriedNumber> Condition<S> {
    pub(crate) fn at_start<M: Material<S>>(material: &M, state: &M::State) -> Self {
        let one = S::constant(1.0);
        Self {
            stress: material.start_stress(state),
            viscosity: S::constant(0.0),
            volume: one,
            wave_speed: material.wave_speed(one, state),
            rate: 0.0,
        }
    }
}

/// Of several faults, that of the particle with the lowest number.
pub(crate) fn keep_lowest(first: &mut Option<(u32, Fault)>, found: (u32, Fault)) {
    if first.is_none_or(|(lowest, _)| found.0 < lowest) {
        *first = Some(found);
    }
}

/// What a step makes of a particle, or of several in lanes: its new condition.
#[derive(Clone, Copy)]
pub(crate) struct Next<S> {
    pub(crate) stress: Symmetric<S>,
    pub(crate) viscosity: S,
    pub(crate) volume: S,
    pub(crate) wave_speed: S,
    /// `tr L`.
    pub(crate) rate: S,
}

impl<S: Real> Next<S> {
    /// Some condition, to be overwritten.
    #[inline(always)]
    pub(crate) fn blank(number: S) -> Self {
        let stress = Symmetric([number; 6]);
        Self { stress, viscosity: number, volume: number, wave_speed: number, rate: number }
    }
}

/// One particle over a step, or several in lanes, by `V/V_0` and wave speed before. What it makes of them goes to `after`: in a result
/// it would share memory with a fault, and the compiler would take registers apart for that.
#[inline(always)]
pub(crate) fn next<M: Material<S>, S: Real>(
    (material, density): (&M, S),
    Strain { dt, time, cell, viscosity, .. }: Strain,
    l: &[[S; 3]; 3],
    (volume_before, wave_speed): (S, S),
    (state, after): (&mut M::State, &mut Next<S>),
) -> Result<(), Fault> {
    let zero = volume_before.splat(0.0);
    let volume = volume_before * volume_change(l, dt);
    let holds = zero.less(volume).and(volume.is_finite());
    Fault::unless(holds, volume, "V/V_0", "above 0 and finite")?;
    let rate = l[0][0] + l[1][1] + l[2][2];
    let slope = rate * (viscosity.quadratic * cell) - wave_speed * viscosity.linear;
    let density = material.density_of(state, density);
    let q = when!(rate.less(zero), density / volume * slope * rate * cell, zero);
    let velocity_gradient = *l;
    let now = Now { velocity_gradient, dt, time, volume_before, volume, viscosity: q, cell };
    let stress = material.update(&now, state)?;
    // A sum is not finite if a term is not; then one is to be found, or the sum itself is too large.
    let mut sum = q.primal();
    for k in 0..6 {
        sum = sum + stress.0[k].primal();
    }
    if !sum.is_finite().all() {
        for entry in stress.0 {
            Fault::unless(entry.is_finite(), entry, "stress", "finite")?;
        }
        Fault::unless(sum.is_finite(), sum, "stress", "finite")?;
    }
    let wave_speed = material.wave_speed(volume, state);
    let holds = wave_speed.at_least(zero).and(wave_speed.is_finite());
    Fault::unless(holds, wave_speed, "wave speed", "0 or above and finite")?;
    *after = Next { stress, viscosity: q, volume, wave_speed, rate };
    Ok(())
}

impl<S: CarriedNumber> From<Next<S>> for Condition<S> {
    #[inline(always)]
    fn from(next: Next<S>) -> Self {
        let Next { stress, viscosity, volume, wave_speed, rate } = next;
        Self { stress, viscosity, volume, wave_speed, rate: rate.value() }
    }
}

/// A material with what it keeps of a run of particles.
struct Portion<'a, M: Material<S>, S: CarriedNumber> {
    material: &'a M,
    density: S,
    plane: bool,
    states: &'a mut [M::State],
    conditions: ColumnsMut<'a, S>,
}

impl<M: Material<S>, S: CarriedNumber> MaterialUpdate<S> for Portion<'_, M, S> {
    fn split(&mut self, middle: usize, work: &mut Halves<'_, S>) {
        let Self { material, density, plane, .. } = *self;
        let (states, further_states) = self.states.split_at_mut(middle);
        let (conditions, further) = self.conditions.halves(middle);
        let mut low = Portion { material, density, plane, states, conditions };
        let (states, conditions) = (further_states, further);
        let mut high = Portion { material, density, plane, states, conditions };
        work(&mut low, &mut high);
    }

    fn update(
        &mut self,
        range: Range<usize>,
        strain: Strain,
        velocity_gradients: &VelocityGradients<S>,
        numbers: &[u32],
    ) -> Option<(u32, Fault)> {
        let (of, plane) = ((self.material, self.density), self.plane);
        let (states, mut conditions) =
            (&mut self.states[range.clone()], self.conditions.part(range));
        dispatch_narrow(
            #[inline(always)]
            || {
                let mut first = None;
                for (i, state) in states.iter_mut().enumerate() {
                    let l = velocity_gradients.get(i);
                    let l = if plane { in_plane(&l) } else { l };
                    let before = (conditions.volume[i], conditions.wave_speed[i]);
                    let mut after = Next::blank(before.0);
                    match next(of, strain, &l, before, (state, &mut after)) {
                        Ok(()) => conditions.set(i, after.into()),
                        Err(fault) => keep_lowest(&mut first, (numbers[i], fault)),
                    }
                }
                first
            },
        )
    }

    fn conditions(&self) -> Columns<'_, S> {
        self.conditions.columns()
    }

    fn add_energies(&self, range: Range<usize>, reference_volumes: &[f64], sum: &mut f64) {
        for (state, volume) in self.states[range].iter().zip(reference_volumes) {
            *sum += self.material.energy(state).value() * volume;
        }
    }
}

impl<M: Material<S> + 'static, S: CarriedNumber> MaterialPoints<S> for Points<M, S>
where
    M::State: 'static,
{
    fn pass(&mut self, work: &mut dyn FnMut(&mut dyn MaterialUpdate<S>)) {
        let Self { material, density, plane, states, conditions } = self;
        let (density, plane, conditions) = (*density, *plane, conditions.columns_mut());
        work(&mut Portion { material, density, plane, states, conditions });
    }

    fn conditions(&self) -> Columns<'_, S> {
        self.conditions.columns()
    }

    fn observe(&self, place: usize) -> Observed<S> {
        self.material.observe(&self.states[place])
    }

    fn permute(&mut self, order: &[u32], done: &mut Vec<bool>) {
        permute(&mut self.states, order, done);
        self.conditions.permute(order, done);
    }

    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>> {
        self.material.at_local_state(state)
    }

    fn show_numbers(&self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool {
        let (mut condition, mut state) = (self.conditions.columns().get(place), self.states[place]);
        condition.visit_numbers(visit);
        self.material.visit_numbers(&mut state, |number: &mut S| visit(number))
    }

    fn visit_numbers(&mut self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool {
        let mut conditions = self.conditions.columns_mut();
        let mut condition = conditions.get(place);
        condition.visit_numbers(visit);
        conditions.set(place, condition);
        self.material.visit_numbers(&mut self.states[place], visit)
    }
}

impl<M: Material<S>, S: CarriedNumber> std::fmt::Debug for Points<M, S> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { material, density, states, conditions, .. } = self;
        let mut fields = formatter.debug_struct("Points");
        fields.field("material", material).field("density", density);
        fields.field("states", states).field("conditions", conditions).finish()
    }
}
