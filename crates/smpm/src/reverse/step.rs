//! One step, reversed from the state at its begin.

use perturbation_moments::Jet;
use simd_lanes::dispatch;

use super::adjoint::BodyAdjoint;
use super::local::LocalUpdate;
use super::node_box::NodeBox;
use super::saved::{Layout, Saved, SavedBody};
use super::solution::{NodeAdjoint, NodeSums, Solution};
use super::transfer::{Particle, Transfers};
use super::weights::Weights;
use crate::boundary::Plane;
use crate::config::{Config, Geometry, Transfer, UpdateOrder};
use crate::error::Error;
use crate::lattice::Lattice;
use crate::material_points::Strain;
use crate::parallel::for_each_chunk;
use crate::particle_motion::GridToParticle;
use crate::pass::Pass;
use crate::simulation::Simulation;

/// What all steps have in common.
#[derive(Debug)]
pub(super) struct Scheme<const D: usize> {
    pub(super) config: Config<D>,
    pub(super) planes: Vec<Plane>,
    pub(super) smallest_mass: f64,
    pub(super) layouts: Vec<Layout>,
}

/// The particles of a body at the begin of a step, in the order of memory.
#[derive(Debug)]
struct Particles<'a, const D: usize> {
    saved: &'a SavedBody,
    all: Vec<Particle<D>>,
    /// The same with the velocities and matrices that the step gives them.
    updated: Vec<Particle<D>>,
    bases: Vec<[i32; D]>,
    n_slots: usize,
    /// Velocity gradients of the step.
    gradients: Vec<[[f64; 3]; 3]>,
}

/// A step with what its nodes and particles were.
#[derive(Debug)]
struct Taken<'a, const D: usize> {
    scheme: &'a Scheme<D>,
    transfers: Transfers<D>,
    nodes: NodeBox<D>,
    bodies: Vec<Particles<'a, D>>,
    first: Solution<D>,
    /// With modified update stress last, the velocities that give the strain.
    second: Option<Solution<D>>,
}

impl Layout {
    /// The particles of a row, but for constants that transfers do not read.
    fn particle<const D: usize>(&self, row: &[f64], with_affine: bool) -> Particle<D> {
        let condition = &row[self.condition()..];
        let entry = |k: usize, l: usize| if with_affine { row[2 * D + k * D + l] } else { 0.0 };
        Particle {
            position: std::array::from_fn(|k| row[k]),
            velocity: std::array::from_fn(|k| row[D + k]),
            affine: std::array::from_fn(|k| std::array::from_fn(|l| entry(k, l))),
            mass: row[self.condition() - 2],
            reference_volume: row[self.condition() - 1],
            stress: std::array::from_fn(|k| condition[k]),
            viscosity: condition[6],
            volume: condition[7],
        }
    }
}

impl<const D: usize> Scheme<D> {
    fn transfers(&self, dt: f64) -> Transfers<D> {
        let Config { transfer, gravity, geometry, .. } = self.config;
        let lattice = Lattice::of(&self.config);
        Transfers {
            dt,
            shares: transfer.shares(dt),
            affine: transfer == Transfer::Apic,
            inverse_inertia: GridToParticle::of(lattice, &self.config, Pass::Whole, dt)
                .inverse_inertia,
            gravity,
            axisymmetric: geometry == Geometry::Axisymmetric,
        }
    }

    /// Takes a step from a saved state.
    fn take<'a>(&'a self, saved: &'a Saved, dt: f64) -> Taken<'a, D> {
        let (lattice, transfers) = (Lattice::of(&self.config), self.transfers(dt));
        let with_affine = transfers.affine;
        let body = |(saved, layout): (&'a SavedBody, &Layout)| {
            let rows = saved.rows.chunks_exact(layout.len);
            let all: Vec<Particle<D>> = rows.map(|row| layout.particle(row, with_affine)).collect();
            let positions: Vec<[f64; D]> = all.iter().map(|of| of.position).collect();
            let mut bases = vec![[0; D]; all.len()];
            lattice.find_lowest_nodes(self.config.shape, (&positions, &[]), &mut bases);
            let (updated, gradients) = (vec![], vec![]);
            Particles { saved, all, updated, bases, n_slots: layout.n_slots(), gradients }
        };
        let mut bodies: Vec<_> = saved.bodies.iter().zip(&self.layouts).map(body).collect();
        let bases = bodies.iter().flat_map(|body| &body.bases);
        let nodes = NodeBox::of(bases, &self.planes);
        let of = (&nodes, &self.planes[..]);
        let cell = self.config.cell;
        let mut weights = Weights::new(lattice, self.config.shape);
        let mut sums = NodeSums::zero(nodes.n_nodes);
        for body in &bodies {
            for (particle, base) in body.all.iter().zip(&body.bases) {
                let seen = weights.at(&nodes, &particle.position, base);
                transfers.give(particle, seen, true, &mut sums);
            }
        }
        let first = Solution::of(sums, of, (dt, cell), (self.smallest_mass, None));
        let mut sums = NodeSums::zero(nodes.n_nodes);
        let is_modified = self.config.update_order == UpdateOrder::ModifiedStressLast;
        for body in bodies.iter_mut().filter(|_| is_modified) {
            for (particle, base) in body.all.iter().zip(&body.bases) {
                let seen = weights.at(&nodes, &particle.position, base);
                let (velocity, affine) = transfers.receive(particle, seen, &first);
                let updated = Particle { velocity, affine, ..*particle };
                transfers.give(&updated, seen, false, &mut sums);
                body.updated.push(updated);
            }
        }
        let second = is_modified
            .then(|| Solution::of(sums, of, (0.0, cell), (self.smallest_mass, Some(&first.mass))));
        let velocities = &second.as_ref().unwrap_or(&first).velocity;
        for body in &mut bodies {
            let Particles { all, bases, gradients, .. } = body;
            let gradient = |(particle, base): (&Particle<D>, &[i32; D])| {
                let seen = weights.at(&nodes, &particle.position, base);
                transfers.gradient(particle, seen, velocities)
            };
            *gradients = all.iter().zip(&*bases).map(gradient).collect();
        }
        Taken { scheme: self, transfers, nodes, bodies, first, second }
    }

    /// Reverses a step of length `dt`, number `step` from 1, from the state at its begin: derivatives by that state replace those by
    /// the state at its end, for every group of responses.
    ///
    /// # Errors
    /// [`Error::Material`].
    pub(super) fn reverse(
        &self,
        (saved, dt, step): (&Saved, f64, u64),
        machine: &mut Simulation<Jet, D>,
        groups: &mut [Vec<BodyAdjoint<D>>],
    ) -> Result<(), Error> {
        let taken = self.take(saved, dt);
        let Config { cell, viscosity, .. } = self.config;
        let time = saved.clock.time + dt;
        let strain = Strain { dt, time, cell, viscosity };
        let axisymmetric = taken.transfers.axisymmetric;
        for (number, body) in taken.bodies.iter().enumerate() {
            let mut of_body: Vec<&mut BodyAdjoint<D>> =
                groups.iter_mut().map(|group| &mut group[number]).collect();
            for adjoint in &mut of_body {
                adjoint.moved.copy_from_slice(&adjoint.position);
            }
            let (saved, machine) = (body.saved, &mut machine.bodies_mut()[number]);
            LocalUpdate::new(&self.layouts[number], D, axisymmetric)
                .reverse(machine, (saved, &body.gradients), strain, &mut of_body)
                .map_err(|(particle, fault)| {
                    let particle = particle as usize;
                    Error::Material { step, time, body: number, particle, fault }
                })?;
        }
        for_each_chunk(groups, 1, &|_, group| {
            if let [bodies] = group {
                taken.reverse(bodies);
            }
        });
        Ok(())
    }
}

/// A pass over all particles in one of the adjoint transfers.
#[derive(Debug, Clone, Copy)]
enum Adjoint {
    Gradient,
    Momentum,
    Receive,
    Give,
}

impl<const D: usize> Taken<'_, D> {
    /// What is left of the reversal once the materials are reversed.
    fn reverse(&self, bodies: &mut [BodyAdjoint<D>]) {
        let Self { nodes, first, second, .. } = self;
        let mut by_nodes = NodeAdjoint::zero(nodes.n_nodes);
        self.pass(Adjoint::Gradient, bodies, &mut by_nodes);
        if let Some(second) = second {
            second.reverse(nodes, &mut by_nodes);
            self.pass(Adjoint::Momentum, bodies, &mut by_nodes);
            let NodeAdjoint { mass, .. } = by_nodes;
            by_nodes = NodeAdjoint { mass, ..NodeAdjoint::zero(nodes.n_nodes) };
        }
        self.pass(Adjoint::Receive, bodies, &mut by_nodes);
        first.reverse(nodes, &mut by_nodes);
        self.pass(Adjoint::Give, bodies, &mut by_nodes);
    }

    #[inline(never)]
    fn pass(&self, pass: Adjoint, bodies: &mut [BodyAdjoint<D>], by_nodes: &mut NodeAdjoint<D>) {
        let Self { scheme, transfers, nodes, first, second, .. } = self;
        let config = &scheme.config;
        let mut weights = Weights::new(Lattice::of(config), config.shape);
        let velocities = &second.as_ref().unwrap_or(first).velocity;
        for (adjoint, body) in bodies.iter_mut().zip(&self.bodies) {
            dispatch(
                #[inline(always)]
                || {
                    for (p, particle) in body.all.iter().enumerate() {
                        let seen = weights.at(nodes, &particle.position, &body.bases[p]);
                        let (number, n_slots) = (body.saved.number[p] as usize, body.n_slots);
                        let both = (&mut *adjoint, &mut *by_nodes);
                        match pass {
                            Adjoint::Gradient => {
                                let of = (particle, number);
                                transfers.reverse_gradient(of, seen, velocities, both);
                            }
                            Adjoint::Momentum => {
                                let of = (&body.updated[p], number, n_slots);
                                transfers.reverse_give(of, seen, false, (both.0, both.1));
                            }
                            Adjoint::Receive => {
                                transfers.reverse_receive(number, seen, first, both);
                            }
                            Adjoint::Give => {
                                let of = (particle, number, n_slots);
                                transfers.reverse_give(of, seen, true, (both.0, both.1));
                            }
                        }
                    }
                },
            );
        }
    }
}
