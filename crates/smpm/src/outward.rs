//! Where the surface of a body looks: what contact takes its normals from.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::binning::Binning;
use crate::body::Body;
use crate::config::Config;
use crate::grid::Grid;
use crate::lattice::Lattice;
use crate::number::Number;
use crate::particles::Particles;
use crate::shape::{Axis, nodes_along, outer};
use crate::tile_size::block_edge;

/// Sums the gradient of the mass, `sum_p m_p grad N_i` per cell, at the nodes of all blocks: there it points out of the body.
pub(crate) fn sum_outward<S: Number, const D: usize>(
    grid: &mut Grid<S, D>,
    bodies: &[Body<S, D>],
    config: &Config<D>,
) {
    let add = match config.shape.n_nodes() {
        2 => add_tile::<S, 2, D>,
        3 => add_tile::<S, 3, D>,
        _ => add_tile::<S, 4, D>,
    };
    let lattice = grid.lattice;
    grid.sum_outward_in_blocks(&|slot, first, blocks| {
        for body in bodies {
            add(&lattice, config, (body, slot), (first, blocks));
        }
    });
}

fn add_tile<S: Number, const NODES: usize, const D: usize>(
    lattice: &Lattice<D>,
    config: &Config<D>,
    (body, slot): (&Body<S, D>, usize),
    (first, blocks): (usize, &mut [[S; D]]),
) {
    let Particles { position, half_length, mass, .. } = &body.particles;
    let Binning { bases, nodes, .. } = &body.binning;
    let mut axes = [Axis::<S, 1>::empty(); D];
    for p in body.binning.runs_of(slot).flatten() {
        let half_length = half_length.get(p..=p).unwrap_or_default();
        let seen = (&position[p..=p], half_length, &bases[p..=p]);
        lattice.find_axes::<S, NODES, 1>(config.shape, seen, &mut axes);
        add_particle::<S, NODES, D>(&axes, mass[p], &mut blocks[nodes[p] - first..]);
    }
}

#[inline(always)]
fn add_particle<S: Number, const NODES: usize, const D: usize>(
    axes: &[Axis<S, 1>; D],
    mass: S,
    nodes: &mut [[S; D]],
) {
    let edge = block_edge(D);
    for k in 0..nodes_along::<NODES, D>(2) {
        for j in 0..nodes_along::<NODES, D>(1) {
            let (n, grad_n) = outer(axes, 0, (j, k));
            for (i, node) in nodes[(k * edge + j) * edge..][..NODES].iter_mut().enumerate() {
                node[0] = node[0] + mass * n * axes[0].slope[i][0];
                for c in 1..D {
                    node[c] = node[c] + mass * grad_n[c] * axes[0].value[i][0];
                }
            }
        }
    }
}
