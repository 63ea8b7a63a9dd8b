//! Where the surface of a body looks: what contact takes its normals from.

use crate::binning::Binning;
use crate::body::Body;
use crate::config::Config;
use crate::grid::Grid;
use crate::number::Number;
use crate::particles::Particles;
use crate::shape::{Axis, outer};
use crate::tile_size::block_edge;

/// Sums the gradient of the mass, `sum_p m_p grad N_i` per cell, at the nodes of all blocks: there it points out of the body.
pub(crate) fn sum_outward<S: Number, const D: usize>(
    grid: &mut Grid<S, D>,
    bodies: &[Body<S, D>],
    config: &Config<D>,
) {
    let lattice = grid.lattice;
    grid.sum_outward_in_blocks(|slot, first, blocks| {
        let mut axes = [Axis::<S, 1>::empty(); D];
        for body in bodies {
            let Particles { position, half_length, mass, .. } = &body.particles;
            let Binning { bases, nodes, .. } = &body.binning;
            for p in body.binning.runs_of(slot).flatten() {
                let (x, half, base) = (&position[p..=p], half_length.get(p..=p), &bases[p..=p]);
                let half = half.unwrap_or_default();
                match config.shape.n_nodes() {
                    2 => lattice.find_axes::<S, 2, 1>(config.shape, x, half, base, &mut axes),
                    3 => lattice.find_axes::<S, 3, 1>(config.shape, x, half, base, &mut axes),
                    _ => lattice.find_axes::<S, 4, 1>(config.shape, x, half, base, &mut axes),
                }
                add(&axes, config.shape.n_nodes(), mass[p], &mut blocks[nodes[p] - first..]);
            }
        }
    });
}

/// A particle at every node that it sees: `n_nodes` along each axis.
fn add<S: Number, const D: usize>(
    axes: &[Axis<S, 1>; D],
    n_nodes: usize,
    mass: S,
    nodes: &mut [[S; D]],
) {
    let edge = block_edge(D);
    for k in 0..if D > 2 { n_nodes } else { 1 } {
        for j in 0..if D > 1 { n_nodes } else { 1 } {
            let (n, grad_n) = outer(axes, 0, (j, k));
            for (i, node) in nodes[(k * edge + j) * edge..][..n_nodes].iter_mut().enumerate() {
                node[0] = node[0] + mass * n * axes[0].slope[i][0];
                for c in 1..D {
                    node[c] = node[c] + mass * grad_n[c] * axes[0].value[i][0];
                }
            }
        }
    }
}
