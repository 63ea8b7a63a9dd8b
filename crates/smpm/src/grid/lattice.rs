//! Where nodes are, and how particles are seen by the nodes around them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use simd_lanes::dispatch_narrow;

use crate::config::Config;
use crate::number::CarriedNumber;
use crate::parallel::for_each_chunk;
use crate::transfer::shape::{Axis, Shape, lowest_node};

/// Particles whose lowest nodes are found together.
const SHARE: usize = 1024;

/// The nodes of the grid: node `n` is at `origin + n cell`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lattice<const D: usize> {
    pub(crate) origin: [f64; D],
    pub(crate) cell: f64,
    pub(crate) per_cell: f64,
}

impl<const D: usize> Lattice<D> {
    pub(crate) fn of(config: &Config<D>) -> Self {
        Self { origin: config.origin, cell: config.cell, per_cell: 1.0 / config.cell }
    }

    /// The shape function of a particle along all axes, from the lowest node that it sees.
    #[inline(always)]
    pub(crate) fn axes<S: CarriedNumber, const NODES: usize>(
        &self,
        position: &[S; D],
        lowest: &[i32; D],
    ) -> [Axis<S>; D] {
        let mut axes = [Axis::empty(); D];
        for k in 0..D {
            let s = (position[k] - self.origin[k]) * self.per_cell;
            axes[k].set_b_spline::<NODES>(s, lowest[k]);
        }
        axes
    }

    /// The lowest node that each particle sees.
    pub(crate) fn find_lowest_nodes<S: CarriedNumber>(
        &self,
        shape: Shape,
        positions: &[[S; D]],
        lowest: &mut [[i32; D]],
    ) {
        for_each_chunk(lowest, SHARE, &|chunk, lowest| {
            let share = chunk * SHARE..chunk * SHARE + lowest.len();
            let positions = &positions[share];
            dispatch_narrow(
                #[inline(always)]
                || {
                    let reach = shape.reach();
                    for p in 0..lowest.len() {
                        for k in 0..D {
                            let s = (positions[p][k].value() - self.origin[k]) * self.per_cell;
                            lowest[p][k] = lowest_node(s, reach);
                        }
                    }
                },
            );
        });
    }
}
