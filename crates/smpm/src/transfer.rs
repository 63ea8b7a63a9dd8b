//! From particles to nodes and back.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use lanes::dispatch as in_widest_registers;

use crate::binning::Binning;
use crate::body::Body;
use crate::config::Config;
use crate::giving::{Block, Given, Giver, give_outward};
use crate::grid::Grid;
use crate::number::{Number, in_registers_of};
use crate::parallel::for_each_chunk;
use crate::particles::{Chunk, Particles};
use crate::shape::{Axis, CubicBSpline, Gimp, Linear, QuadraticBSpline, Shape, ShapeFunction};
use crate::taking::Taker;

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

    /// The shape function of up to `N` particles along all axes, from the lowest node that each sees.
    #[inline(always)]
    pub(crate) fn find_axes<F: ShapeFunction, S: Number, const N: usize>(
        &self,
        positions: &[[S; D]],
        half_lengths: &[[S; D]],
        bases: &[[i32; D]],
        axes: &mut [Axis<S, N>; D],
    ) {
        let zero = S::constant(0.0);
        for p in 0..positions.len().min(N) {
            for k in 0..D {
                let half = if F::SIZED { half_lengths[p][k] * self.per_cell } else { zero };
                let place = (positions[p][k] - self.origin[k]) * self.per_cell;
                F::along(place, half, bases[p][k], (&mut axes[k], p));
            }
        }
    }
}

impl<F: ShapeFunction, S: Number, const D: usize> Carrier<S, D> for F {
    fn find_bases(&self, places: &Places<D>, body: &mut Body<S, D>) {
        let Particles { position, half_length, .. } = &body.particles;
        for_each_chunk(&mut body.binning.bases, SHARE, |chunk, bases| {
            let share = chunk * SHARE..chunk * SHARE + bases.len();
            let position = &position[share.clone()];
            let half_length = half_length.get(share).unwrap_or_default();
            in_widest_registers(
                #[inline(always)]
                || {
                    for p in 0..bases.len() {
                        for k in 0..D {
                            let half = if F::SIZED { half_length[p][k].value() } else { 0.0 };
                            let place =
                                (position[p][k].value() - places.origin[k]) * places.per_cell;
                            bases[p][k] = F::base(place, half * places.per_cell);
                        }
                    }
                },
            );
        });
    }

    fn give(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>], config: &Config<D>, given: Given) {
        let giver = Giver::of(config, Places::of(grid), given);
        grid.collect(given != Given::MotionAgain, |slot, first, nodes, masses| {
            for body in bodies {
                in_registers_of::<S, _>(
                    #[inline(always)]
                    || giver.give_all::<F, S>(body, slot, &mut Block { first, nodes, masses }),
                );
            }
        });
    }

    fn give_outward(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>]) {
        let places = Places::of(grid);
        grid.collect_outward(|slot, first, blocks| {
            for body in bodies {
                let Particles { position, half_length, mass, .. } = &body.particles;
                let Binning { bases, nodes, .. } = &body.binning;
                let mut axes = [Axis::<S, 1>::empty(); D];
                for p in body.binning.runs_of(slot).flatten() {
                    let half_length = half_length.get(p..=p).unwrap_or_default();
                    places.find_axes::<F, S, 1>(
                        &position[p..=p],
                        half_length,
                        &bases[p..=p],
                        &mut axes,
                    );
                    give_outward::<F, S, D>(&axes, mass[p], &mut blocks[nodes[p] - first..]);
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
        in_registers_of::<S, _>(
            #[inline(always)]
            || taker.take_all::<F, S>(chunk, gradients, sweep.grid),
        );
    }
}
