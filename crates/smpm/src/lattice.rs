//! Where nodes are, and how particles are seen by the nodes around them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use simd_lanes::dispatch;

use crate::config::Config;
use crate::number::Number;
use crate::parallel::for_each_chunk;
use crate::shape::{Axis, Shape, lowest_node};

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

    /// The shape function of a particle along all axes, from the lowest node that it sees. `half` is half of its length, with GIMP.
    #[inline(always)]
    pub(crate) fn axes<S: Number, const NODES: usize>(
        &self,
        shape: Shape,
        (position, half): (&[S; D], Option<&[S; D]>),
        lowest: &[i32; D],
    ) -> [Axis<S>; D] {
        let mut axes = [Axis::empty(); D];
        for k in 0..D {
            let s = (position[k] - self.origin[k]) * self.per_cell;
            match half {
                Some(half) if NODES == Shape::Gimp.n_nodes() && shape == Shape::Gimp => {
                    axes[k].set_gimp((s, half[k] * self.per_cell), lowest[k]);
                }
                _ => axes[k].set_b_spline::<NODES>(s, lowest[k]),
            }
        }
        axes
    }

    /// The lowest node that each particle sees.
    pub(crate) fn find_lowest_nodes<S: Number>(
        &self,
        shape: Shape,
        (positions, half_lengths): (&[[S; D]], &[[S; D]]),
        lowest: &mut [[i32; D]],
    ) {
        for_each_chunk(lowest, SHARE, &|chunk, lowest| {
            let share = chunk * SHARE..chunk * SHARE + lowest.len();
            let positions = &positions[share.clone()];
            let half_lengths = half_lengths.get(share).unwrap_or_default();
            dispatch(
                #[inline(always)]
                || {
                    if shape == Shape::Gimp {
                        for p in 0..lowest.len() {
                            for k in 0..D {
                                let half = half_lengths[p][k].value() * self.per_cell;
                                let s = (positions[p][k].value() - self.origin[k]) * self.per_cell;
                                lowest[p][k] = lowest_node(s, shape.reach(half));
                            }
                        }
                        return;
                    }
                    let reach = shape.reach(0.0);
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
