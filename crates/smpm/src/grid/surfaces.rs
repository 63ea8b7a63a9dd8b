//! Volume fractions of the bodies at the nodes, and their gradients: the input of the gap test and of the normals of contact.

use crate::config::{Config, Geometry};
use crate::grid::background::Grid;
use crate::grid::binning::Binning;
use crate::grid::contact::Surface;
use crate::grid::tile_size::block_edge;
use crate::number::CarriedNumber;
use crate::points::body::Body;
use crate::points::particles::Particles;
use crate::transfer::shape::Shape;
use crate::transfer::shape::{Axis, outer};

/// Sums volumes and their gradients, `V_p N_i` and `V_p grad N_i` per cell over the volume of a cell, at the nodes of all
/// blocks. Where axisymmetric the volumes are those of the cross-section.
pub(crate) fn sum_surfaces<S: CarriedNumber, const D: usize>(
    grid: &mut Grid<S, D>,
    bodies: &[Body<S, D>],
    config: &Config<D>,
) {
    let lattice = grid.lattice;
    let per_cell = (0..D).fold(1.0, |product, _| product * lattice.per_cell);
    let axisymmetric = config.geometry == Geometry::Axisymmetric;
    grid.sum_surfaces_in_blocks(|slot, first, blocks| {
        for body in bodies {
            let Particles { position, reference_volume, .. } = &body.particles;
            let conditions = body.points.conditions();
            let Binning { bases, nodes, .. } = &body.binning;
            for p in body.binning.runs_of(slot).flatten() {
                let axes = match config.shape {
                    Shape::QuadraticBSpline => lattice.axes::<S, 3>(&position[p], &bases[p]),
                    Shape::CubicBSpline => lattice.axes::<S, 4>(&position[p], &bases[p]),
                };
                let mut volume = conditions.volume[p] * (reference_volume[p] * per_cell);
                if axisymmetric {
                    volume = volume / position[p][0];
                }
                add(&axes, config.shape.n_nodes(), volume, &mut blocks[nodes[p] - first..]);
            }
        }
    });
}

/// A particle at every node that it sees: `n_nodes` along each axis.
fn add<S: CarriedNumber, const D: usize>(
    axes: &[Axis<S>; D],
    n_nodes: usize,
    volume: S,
    nodes: &mut [Surface<S, D>],
) {
    let edge = block_edge(D);
    for k in 0..if D > 2 { n_nodes } else { 1 } {
        for j in 0..if D > 1 { n_nodes } else { 1 } {
            let (n, grad_n) = outer(axes, (j, k));
            for (i, node) in nodes[(k * edge + j) * edge..][..n_nodes].iter_mut().enumerate() {
                let part = volume * axes[0].value[i];
                node.fill = node.fill + part * n;
                node.outward[0] = node.outward[0] + volume * n * axes[0].slope[i];
                for c in 1..D {
                    node.outward[c] = node.outward[c] + part * grad_n[c];
                }
            }
        }
    }
}
