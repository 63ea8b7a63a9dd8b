//! From particles to nodes and back.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::in_widest_registers;

use crate::binning::Binning;
use crate::body::Body;
use crate::config::{Config, Transfer};
use crate::constitution::Condition;
use crate::giving::{Given, Giver, give_outward};
use crate::grid::{Grid, Node};
use crate::number::Number;
use crate::parallel::for_each_chunk;
use crate::particles::{Chunk, Particles};
use crate::shape::{Axis, CubicBSpline, Gimp, Linear, QuadraticBSpline, Shape, ShapeFunction};
use crate::taking::Taker;
use crate::tiles::block_len;

/// Particles whose lowest nodes are found together.
const SHARE: usize = 1024;

/// What a pass over the particles does with each of them.
#[derive(Debug)]
pub(crate) struct Sweep<'a, S, const D: usize> {
    pub(crate) grid: &'a Grid<S, D>,
    pub(crate) config: &'a Config<D>,
    pub(crate) carrier: &'a dyn Carrier<S, D>,
    pub(crate) dt: f64,
    /// At the end of the step.
    pub(crate) time: f64,
    pub(crate) pass: Pass,
    /// The field of nodes of the body.
    pub(crate) field: usize,
}

/// What a pass over the particles does. The last one of a step moves them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Takes the velocity from the nodes.
    Motion,
    /// The same, and moves.
    MotionAndMove,
    /// Takes the velocity gradient and brings the stress up to date.
    Stress,
    /// The same, and moves.
    StressAndMove,
    /// All.
    Whole,
}

impl Pass {
    pub(crate) fn takes_motion(self) -> bool {
        matches!(self, Self::Motion | Self::MotionAndMove | Self::Whole)
    }

    pub(crate) fn updates_stress(self) -> bool {
        matches!(self, Self::Stress | Self::StressAndMove | Self::Whole)
    }

    pub(crate) fn moves(self) -> bool {
        matches!(self, Self::MotionAndMove | Self::StressAndMove | Self::Whole)
    }
}

/// The ways between particles and nodes by a shape function.
pub(crate) trait Carrier<S: Number, const D: usize>: std::fmt::Debug + Send + Sync {
    /// Notes the lowest node that each particle of a body sees.
    fn find_bases(&self, places: &Places<D>, body: &mut Body<S, D>);

    /// Particles give mass, momentum `m (v + C (x_i - x_p))` and the force
    ///
    /// $$ f_i = \sum_p m_p N_i b - V_p \sigma_p \nabla N_i $$
    ///
    /// to the nodes (Chen et al. 2019, eq 3-6 with their errata).
    fn give(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>], config: &Config<D>, given: Given);

    /// Particles give the gradient of their mass, `sum_p m_p grad N_i` per cell: at a node it points out of the body.
    fn give_outward(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>]);

    /// Particles take what the sweep asks for from the nodes; velocity gradients go into `gradients`.
    fn take(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut [[[S; 3]; 3]],
        sweep: &Sweep<'_, S, D>,
    );
}

/// The carrier of a shape function.
pub(crate) fn carrier<S: Number, const D: usize>(shape: Shape) -> &'static dyn Carrier<S, D> {
    match shape {
        Shape::Linear => &Linear,
        Shape::Gimp => &Gimp,
        Shape::QuadraticBSpline => &QuadraticBSpline,
        Shape::CubicBSpline => &CubicBSpline,
    }
}

/// What places and nodes have to do with each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Places<const D: usize> {
    pub(crate) origin: [f64; D],
    pub(crate) cell: f64,
    pub(crate) per_cell: f64,
}

impl<const D: usize> Places<D> {
    pub(crate) fn of<S>(grid: &Grid<S, D>) -> Self {
        Self { origin: grid.origin, cell: grid.cell, per_cell: 1.0 / grid.cell }
    }

    /// The shape function of particle `p` along all axes, from the lowest node that it sees.
    #[inline(always)]
    pub(crate) fn find_axes<F: ShapeFunction, S: Number>(
        &self,
        (x, half_lengths): (&[S; D], &[[S; D]]),
        (p, base): (usize, &[i32; D]),
        axes: &mut [Axis<S>; D],
    ) {
        let zero = S::constant(0.0);
        for k in 0..D {
            let half = if F::SIZED { half_lengths[p][k] * self.per_cell } else { zero };
            let place = (x[k] - self.origin[k]) * self.per_cell;
            F::along(place, half, base[k], &mut axes[k]);
        }
    }
}

impl<F: ShapeFunction, S: Number, const D: usize> Carrier<S, D> for F {
    fn find_bases(&self, places: &Places<D>, body: &mut Body<S, D>) {
        let Particles { position, half_length, .. } = &body.particles;
        for_each_chunk(&mut body.binning.bases, SHARE, |chunk, bases| {
            let start = chunk * SHARE;
            in_widest_registers(
                #[inline(always)]
                || {
                    for p in 0..bases.len() {
                        let x = &position[start + p];
                        for k in 0..D {
                            let half =
                                if F::SIZED { half_length[start + p][k].value() } else { 0.0 };
                            let place = (x[k].value() - places.origin[k]) * places.per_cell;
                            bases[p][k] = F::base(place, half * places.per_cell);
                        }
                    }
                },
            );
        });
    }

    fn give(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>], config: &Config<D>, given: Given) {
        let places = Places::of(grid);
        let last_field = grid.field(bodies.len() - 1);
        let affine = config.transfer == Transfer::Apic;
        grid.collect(|slot, corner, blocks| {
            for (field, body) in bodies.iter().enumerate() {
                let block = &mut blocks[field.min(last_field) * block_len(D)..][..block_len(D)];
                let givers = Givers {
                    places,
                    body,
                    members: body.binning.members(slot),
                    conditions: body.constitution.conditions(),
                    corner,
                    config,
                };
                in_widest_registers(
                    #[inline(always)]
                    || {
                        if const { size_of::<S>() > size_of::<f64>() } {
                            // Beside the arithmetic of a jet a question costs nothing, and its code is long.
                            givers.give::<F>(given, affine, block);
                            return;
                        }
                        // The same with the usual cases known to the compiler, which then asks at no node what is given.
                        match (given, affine) {
                            (Given::MotionAndForce, false) => {
                                givers.give::<F>(Given::MotionAndForce, false, block);
                            }
                            (Given::MotionAgain, false) => {
                                givers.give::<F>(Given::MotionAgain, false, block);
                            }
                            _ => givers.give::<F>(given, affine, block),
                        }
                    },
                );
            }
        });
    }

    fn give_outward(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>]) {
        let places = Places::of(grid);
        grid.collect_outward(|slot, corner, blocks| {
            for (field, body) in bodies.iter().enumerate() {
                let Particles { position, half_length, mass, .. } = &body.particles;
                let block = &mut blocks[field * block_len(D)..][..block_len(D)];
                let mut axes = [Axis::empty(); D];
                for &p in body.binning.members(slot) {
                    let p = p as usize;
                    let base = &body.binning.bases[p];
                    places.find_axes::<F, S>((&position[p], half_length), (p, base), &mut axes);
                    let nodes = &mut block[Binning::offset(base, &corner)..];
                    give_outward::<F, S, D>(&axes, mass[p], nodes);
                }
            }
        });
    }

    fn take(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut [[[S; 3]; 3]],
        sweep: &Sweep<'_, S, D>,
    ) {
        let taker = Taker::of(sweep);
        in_widest_registers(
            #[inline(always)]
            || taker.take_all::<F, S>(chunk, gradients, sweep.grid),
        );
    }
}

/// The particles of a body in a tile.
struct Givers<'a, S, const D: usize> {
    places: Places<D>,
    body: &'a Body<S, D>,
    members: &'a [u32],
    conditions: &'a [Condition<S>],
    /// The lowest node of the block.
    corner: [i32; D],
    config: &'a Config<D>,
}

impl<S: Number, const D: usize> Givers<'_, S, D> {
    #[inline(always)]
    fn give<F: ShapeFunction>(&self, given: Given, affine: bool, block: &mut [Node<S, D>]) {
        let Self { places, body, members, conditions, corner, config } = *self;
        let (particles, bases) = (&body.particles, &body.binning.bases);
        let mut axes = [Axis::empty(); D];
        for &p in members {
            let p = p as usize;
            let base = &bases[p];
            let sized = (&particles.position[p], &particles.half_length[..]);
            places.find_axes::<F, S>(sized, (p, base), &mut axes);
            let nodes = &mut block[Binning::offset(base, &corner)..];
            let of = Giver { places, particles, p, base, config, affine };
            of.give::<F>(&axes, &conditions[p], given, nodes);
        }
    }
}
