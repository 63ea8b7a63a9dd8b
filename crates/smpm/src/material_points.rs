//! A material with the states of its particles: what a step does to them, as far as the transfer knows it.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::Range;

use lanes::dispatch;

use crate::binning::permute;
use crate::config::BulkViscosity;
use crate::error::Fault;
use crate::material::{LocalResponse, LocalState, Material, Now, Observed};
use crate::number::{Number, is_finite};
use crate::tensor::{Symmetric, in_plane, volume_change};

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
        velocity_gradients: &[[[S; 3]; 3]],
        numbers: &[u32],
    ) -> Option<(u32, Fault)>;

    fn conditions(&self) -> &[Condition<S>];

    /// Adds the internal energies of a range of particles to a sum, one by one.
    fn add_energies(&self, range: Range<usize>, reference_volumes: &[f64], sum: &mut f64);
}

/// Work on the materials of two runs of particles.
pub(crate) type Halves<'a, S> =
    dyn FnMut(&mut dyn MaterialUpdate<S>, &mut dyn MaterialUpdate<S>) + 'a;

/// A material with the states of all particles of a body, whatever its type.
pub(crate) trait MaterialPoints<S>: std::fmt::Debug + Send + Sync {
    /// All of them, for a pass.
    fn pass(&mut self, work: &mut dyn FnMut(&mut dyn MaterialUpdate<S>));
    fn conditions(&self) -> &[Condition<S>];
    fn observe(&self, place: usize) -> Observed<S>;
    fn at_local_state(&self, state: &LocalState) -> Option<LocalResponse<S>>;
    fn permute(&mut self, order: &[u32], done: &mut Vec<bool>);
    /// Calls with a copy of every number of a particle's state and condition; whether that is all of it.
    fn show_numbers(&self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool;
    /// The same with the numbers themselves, to be written.
    fn visit_numbers(&mut self, place: usize, visit: &mut dyn FnMut(&mut S)) -> bool;
}

/// The materials of a batch over a step; of several faults, that of the particle with the lowest number. Without the
/// dimension: this is most of the code of a material, and there is one of it for each kind of number; for `f64` another
/// for motion that is known to stay in the plane of the first two axes (`PLANE`).
pub(crate) struct UpdateBatch<M: Material<S>, S: Number, const PLANE: bool>(Update<M, S>);

type Update<M, S> =
    fn((&M, S), Strain, &[[[S; 3]; 3]], Kept<'_, M, S>, &[u32]) -> Option<(u32, Fault)>;

/// What is kept of a batch: states and conditions.
type Kept<'a, M, S> = (&'a mut [<M as Material<S>>::State], &'a mut [Condition<S>]);

/// A material with what it keeps of all particles of a body. `PLANE` says that the motion is known to stay in the plane of the first
/// two axes; it matters for `f64` only.
pub(crate) struct Points<M: Material<S>, S: Number, const PLANE: bool> {
    material: M,
    update: UpdateBatch<M, S, PLANE>,
    density: S,
    states: Vec<M::State>,
    conditions: Vec<Condition<S>>,
}

impl<M: Material<S>, S: Number, const PLANE: bool> Points<M, S, PLANE> {
    /// All particles as they start, at their places.
    #[inline(never)]
    pub(crate) fn at_start(
        material: M,
        update: UpdateBatch<M, S, PLANE>,
        places: &[[f64; 3]],
    ) -> Self {
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
        Self { density: material.density(), material, update, states, conditions }
    }
}

impl<M: Material<S>, S: Number, const PLANE: bool> UpdateBatch<M, S, PLANE> {
    pub(crate) const HERE: Self = Self(update_batch::<M, S, PLANE>);
}

#[inline(never)]
fn update_batch<M: Material<S>, S: Number, const PLANE: bool>(
    of: (&M, S),
    strain: Strain,
    velocity_gradients: &[[[S; 3]; 3]],
    (states, conditions): Kept<'_, M, S>,
    numbers: &[u32],
) -> Option<(u32, Fault)> {
    dispatch(
        #[inline(always)]
        || {
            let mut first: Option<(u32, Fault)> = None;
            let n = velocity_gradients.len();
            let (states, conditions) = (&mut states[..n], &mut conditions[..n]);
            for i in 0..n {
                let (state, condition) = (&mut states[i], &mut conditions[i]);
                let l = &velocity_gradients[i];
                let l = if PLANE { in_plane(l) } else { *l };
                if let Err(fault) = next(of, strain, &l, state, condition)
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
    Strain { dt, time, cell, viscosity, .. }: Strain,
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

/// A material with what it keeps of a run of particles.
struct Portion<'a, M: Material<S>, S: Number, const PLANE: bool> {
    material: &'a M,
    update: UpdateBatch<M, S, PLANE>,
    density: S,
    states: &'a mut [M::State],
    conditions: &'a mut [Condition<S>],
}

impl<M: Material<S>, S: Number, const PLANE: bool> MaterialUpdate<S> for Portion<'_, M, S, PLANE> {
    fn split(&mut self, middle: usize, work: &mut Halves<'_, S>) {
        let (material, update, density) = (self.material, self.update, self.density);
        let (states, further_states) = self.states.split_at_mut(middle);
        let (conditions, further) = self.conditions.split_at_mut(middle);
        let mut low = Portion { material, update, density, states, conditions };
        let mut high =
            Portion { material, update, density, states: further_states, conditions: further };
        work(&mut low, &mut high);
    }

    fn update(
        &mut self,
        range: Range<usize>,
        strain: Strain,
        velocity_gradients: &[[[S; 3]; 3]],
        numbers: &[u32],
    ) -> Option<(u32, Fault)> {
        let of = (self.material, self.density);
        let kept = (&mut self.states[range.clone()], &mut self.conditions[range]);
        (self.update.0)(of, strain, velocity_gradients, kept, numbers)
    }

    fn conditions(&self) -> &[Condition<S>] {
        self.conditions
    }

    fn add_energies(&self, range: Range<usize>, reference_volumes: &[f64], sum: &mut f64) {
        for (state, volume) in self.states[range].iter().zip(reference_volumes) {
            *sum += self.material.energy(state).value() * volume;
        }
    }
}

impl<M: Material<S> + 'static, S: Number, const PLANE: bool> MaterialPoints<S>
    for Points<M, S, PLANE>
where
    M::State: 'static,
{
    fn pass(&mut self, work: &mut dyn FnMut(&mut dyn MaterialUpdate<S>)) {
        let Self { material, update, density, states, conditions } = self;
        let (update, density) = (*update, *density);
        work(&mut Portion { material, update, density, states, conditions });
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

impl<M: Material<S>, S: Number, const PLANE: bool> Clone for UpdateBatch<M, S, PLANE> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Material<S>, S: Number, const PLANE: bool> Copy for UpdateBatch<M, S, PLANE> {}

impl<M: Material<S>, S: Number, const PLANE: bool> std::fmt::Debug for Points<M, S, PLANE> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { material, density, states, conditions, .. } = self;
        let mut fields = formatter.debug_struct("Points");
        fields.field("material", material).field("density", density);
        fields.field("states", states).field("conditions", conditions).finish()
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
