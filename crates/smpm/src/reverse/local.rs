//! Local derivatives by jets: of the material update of a particle, and of what gauges read. No material has an adjoint of its own.

use std::ops::Range;

use perturbation_moments::{Jet, LANES};

use super::adjoint::BodyAdjoint;
use super::eight::Eight;
use super::saved::{Kind, Layout, SavedBody};
use crate::body::Body;
use crate::error::Fault;
use crate::material_points::Strain;
use crate::observation::Quantity;
use crate::particles::BATCH;
use crate::velocity_gradients::VelocityGradients;

/// Slots of the condition that a step overwrites: six stresses and the viscosity.
const OVERWRITTEN: usize = 7;

/// What the update of a particle depends on.
#[derive(Debug, Clone, Copy)]
enum Input {
    /// An entry of the velocity gradient.
    Gradient(usize, usize),
    /// The entry out of the plane where axisymmetric.
    Hoop,
    /// A number of the material.
    Slot(usize),
}

/// The material updates of a body: inputs in groups of eight.
#[derive(Debug)]
pub(super) struct LocalUpdate<'a> {
    layout: &'a Layout,
    inputs: Vec<Input>,
    /// By the lanes of an input, its derivatives of each group of responses, particle by particle of a batch.
    sums: Vec<Eight>,
    /// The number behind the condition's begin to its slot.
    slots: Vec<Option<usize>>,
}

/// A number of this value with a derivative of one in a lane, if it has one.
fn seeded(value: f64, lane: Option<usize>) -> Jet {
    Jet::variable(value, lane.unwrap_or(LANES))
}

impl<'a> LocalUpdate<'a> {
    pub(super) fn new(layout: &'a Layout, dimension: usize, axisymmetric: bool) -> Self {
        let entries = (0..dimension).flat_map(|k| (0..dimension).map(move |m| (k, m)));
        let mut inputs: Vec<Input> = entries.map(|(k, m)| Input::Gradient(k, m)).collect();
        if axisymmetric {
            inputs.push(Input::Hoop);
        }
        inputs.extend((OVERWRITTEN..layout.n_slots()).map(Input::Slot));
        let slot_of = |number| match layout.kind(layout.condition() + number) {
            Kind::Material(slot) => Some(slot),
            _ => None,
        };
        let slots = (0..layout.len - layout.condition()).map(slot_of).collect();
        Self { layout, inputs, sums: vec![], slots }
    }

    /// Reverses the update of all particles of a body over a step, by their state before it and velocity gradients in the order of
    /// memory.
    ///
    /// # Errors
    /// The fault of a particle, by its number.
    pub(super) fn reverse<const D: usize>(
        &mut self,
        body: &mut Body<Jet, D>,
        (saved, gradients): (&SavedBody, &[[[f64; 3]; 3]]),
        strain: Strain,
        groups: &mut [&mut BodyAdjoint<D>],
    ) -> Result<(), (u32, Fault)> {
        let (n, n_inputs) = (saved.number.len(), self.inputs.len());
        self.sums.resize(BATCH * n_inputs * groups.len(), Eight::ZERO);
        let mut of_batch = VelocityGradients::zero();
        for begin in (0..n).step_by(BATCH) {
            let batch = begin..n.min(begin + BATCH);
            self.sums.fill(Eight::ZERO);
            for first in (0..n_inputs).step_by(LANES) {
                let lanes = first..n_inputs.min(first + LANES);
                self.seed(body, (saved, gradients), &batch, lanes.clone(), &mut of_batch);
                let mut fault = None;
                body.points.pass(&mut |points| {
                    let numbers = &saved.number[batch.clone()];
                    fault = points.update(batch.clone(), strain, &of_batch, numbers);
                });
                if let Some(fault) = fault {
                    return Err(fault);
                }
                self.sum(body, saved, &batch, lanes, groups);
            }
            self.put(saved, &batch, groups);
        }
        Ok(())
    }

    /// The lane of a slot among the inputs of a group.
    fn lane_of(&self, slot: usize, lanes: &Range<usize>) -> Option<usize> {
        let first_slot = self.inputs.len() - (self.layout.n_slots() - OVERWRITTEN);
        let input = first_slot + slot.checked_sub(OVERWRITTEN)?;
        lanes.contains(&input).then(|| input - lanes.start)
    }

    fn seed<const D: usize>(
        &self,
        body: &mut Body<Jet, D>,
        (saved, gradients): (&SavedBody, &[[[f64; 3]; 3]]),
        batch: &Range<usize>,
        lanes: Range<usize>,
        of_batch: &mut VelocityGradients<Jet>,
    ) {
        let (len, condition) = (self.layout.len, self.layout.condition());
        let lane_of = |slot: &Option<usize>| slot.and_then(|slot| self.lane_of(slot, &lanes));
        let slot_lanes: Vec<Option<usize>> = self.slots.iter().map(lane_of).collect();
        for place in batch.clone() {
            let mut numbers =
                saved.rows[place * len + condition..(place + 1) * len].iter().zip(&slot_lanes);
            let _ = body.points.visit_numbers(place, &mut |number: &mut Jet| {
                if let Some((&value, &lane)) = numbers.next() {
                    *number = seeded(value, lane);
                }
            });
            let mut l = gradients[place].map(|row| row.map(|entry| seeded(entry, None)));
            for (lane, input) in self.inputs[lanes.clone()].iter().enumerate() {
                match *input {
                    Input::Gradient(k, m) => l[k][m] = seeded(l[k][m].value, Some(lane)),
                    Input::Hoop => l[2][2] = seeded(l[2][2].value, Some(lane)),
                    Input::Slot(_) => {}
                }
            }
            of_batch.set(place - batch.start, &l);
        }
    }

    /// Adds the products of the update's derivatives and those of the responses by what comes out of it.
    fn sum<const D: usize>(
        &mut self,
        body: &Body<Jet, D>,
        saved: &SavedBody,
        batch: &Range<usize>,
        lanes: Range<usize>,
        groups: &[&mut BodyAdjoint<D>],
    ) {
        let Self { layout, inputs, sums, slots } = self;
        let (n_slots, n_inputs) = (layout.n_slots(), inputs.len());
        let changing = n_slots - layout.constants.len();
        for place in batch.clone() {
            let particle = saved.number[place] as usize;
            let mut slot_of = slots.iter();
            let _ = body.points.show_numbers(place, &mut |number: &mut Jet| {
                // Constants go on as they are.
                let Some(&Some(slot)) = slot_of.next() else { return };
                if slot >= changing {
                    return;
                }
                for (g, group) in groups.iter().enumerate() {
                    let by = &group.material[particle * n_slots + slot];
                    let from = ((place - batch.start) * groups.len() + g) * n_inputs;
                    let sums = &mut sums[from + lanes.start..from + lanes.end];
                    for (sum, &derivative) in sums.iter_mut().zip(&number.first) {
                        sum.add(derivative, by);
                    }
                }
            });
        }
    }

    /// Derivatives by what goes into the update replace those by what came out.
    fn put<const D: usize>(
        &self,
        saved: &SavedBody,
        batch: &Range<usize>,
        groups: &mut [&mut BodyAdjoint<D>],
    ) {
        let (n_slots, n_inputs) = (self.layout.n_slots(), self.inputs.len());
        let (changing, n_groups) = (n_slots - self.layout.constants.len(), groups.len());
        for place in batch.clone() {
            let particle = saved.number[place] as usize;
            for (g, group) in groups.iter_mut().enumerate() {
                let material = &mut group.material[particle * n_slots..(particle + 1) * n_slots];
                material[..changing].fill(Eight::ZERO);
                let from = ((place - batch.start) * n_groups + g) * n_inputs;
                for (input, sum) in self.inputs.iter().zip(&self.sums[from..from + n_inputs]) {
                    match *input {
                        Input::Gradient(k, m) => group.gradient[particle][k][m] = *sum,
                        Input::Hoop => group.hoop[particle] = *sum,
                        Input::Slot(slot) => material[slot].add(1.0, sum),
                    }
                }
            }
        }
    }
}

/// Derivatives of a quantity of a particle by the numbers of its row, which are shown with their kinds.
pub(super) fn quantity<const D: usize>(
    body: &mut Body<Jet, D>,
    layout: &Layout,
    row: &[f64],
    quantity: Quantity,
    mut see: impl FnMut(Kind, f64),
) {
    let kinds: Vec<(usize, Kind)> =
        (0..layout.len).map(|n| (n, layout.kind(n))).filter(|it| it.1 != Kind::None).collect();
    for group in kinds.chunks(LANES) {
        let mut n = 0;
        let _ = body.visit_numbers(0, &mut |number: &mut Jet| {
            let lane = group.iter().position(|(of, _)| *of == n);
            *number = seeded(row[n], lane);
            n += 1;
        });
        let read = quantity.read(body, 0);
        for ((_, kind), &derivative) in group.iter().zip(&read.first) {
            if derivative != 0.0 {
                see(*kind, derivative);
            }
        }
    }
}
