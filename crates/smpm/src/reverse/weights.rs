//! Shape functions of a particle at the nodes that it sees, with their first and second derivatives by its place.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::lattice::Lattice;
use crate::shape::{Axis, Shape};
use crate::tile_size::MOST_NODES;

use super::node_box::NodeBox;

/// Most nodes that a particle sees.
const MOST: usize = MOST_NODES * MOST_NODES * MOST_NODES;

/// A node as a particle sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weight<const D: usize> {
    /// Its number in the box.
    pub(super) node: usize,
    /// `x_i - x_p` (length).
    pub(super) arm: [f64; D],
    /// `N`.
    pub(super) value: f64,
    /// `dN/dx` (per length).
    pub(super) slope: [f64; D],
    /// The second derivatives (per length squared).
    pub(super) second: [[f64; D]; D],
}

/// All nodes that a particle sees: a buffer.
#[derive(Debug)]
pub(super) struct Weights<const D: usize> {
    lattice: Lattice<D>,
    shape: Shape,
    all: [Weight<D>; MOST],
}

impl<const D: usize> Weights<D> {
    pub(super) fn new(lattice: Lattice<D>, shape: Shape) -> Self {
        let (zero, matrix) = ([0.0; D], [[0.0; D]; D]);
        let none = Weight { node: 0, arm: zero, value: 0.0, slope: zero, second: matrix };
        Self { lattice, shape, all: [none; MOST] }
    }

    /// Of a particle at a place that sees `lowest` as its lowest node.
    #[inline(always)]
    pub(super) fn at(
        &mut self,
        nodes: &NodeBox<D>,
        position: &[f64; D],
        lowest: &[i32; D],
    ) -> &[Weight<D>] {
        let Lattice { origin, cell, per_cell } = self.lattice;
        let (mut axes, mut seconds) = ([Axis::<f64>::empty(); D], [[0.0; MOST_NODES]; D]);
        for k in 0..D {
            let s = (position[k] - origin[k]) * per_cell;
            match self.shape.n_nodes() {
                2 => axes[k].set_b_spline::<2>(s, lowest[k]),
                3 => axes[k].set_b_spline::<3>(s, lowest[k]),
                _ => axes[k].set_b_spline::<4>(s, lowest[k]),
            }
            seconds[k] = second(self.shape, s, lowest[k]);
        }
        let (edge, mut n) = (self.shape.n_nodes(), 0);
        let along = |axis: usize| if axis < D { edge } else { 1 };
        let first = nodes.index(lowest);
        for k in 0..along(2) {
            for j in 0..along(1) {
                for i in 0..along(0) {
                    let at = [i, j, k];
                    let weight = &mut self.all[n];
                    n += 1;
                    weight.node = first;
                    weight.value = 1.0;
                    for l in 0..D {
                        weight.node += at[l] * nodes.strides[l];
                        weight.value *= axes[l].value[at[l]];
                        let node = f64::from(lowest[l]) + at[l] as f64;
                        weight.arm[l] = origin[l] + node * cell - position[l];
                    }
                    for l in 0..D {
                        weight.slope[l] = per_cell;
                        for q in 0..D {
                            let axis = &axes[q];
                            weight.slope[l] *=
                                if q == l { axis.slope[at[q]] } else { axis.value[at[q]] };
                        }
                        for m in 0..D {
                            let mut product = per_cell * per_cell;
                            for q in 0..D {
                                product *= match (q == l, q == m) {
                                    (true, true) => seconds[q][at[q]],
                                    (false, false) => axes[q].value[at[q]],
                                    _ => axes[q].slope[at[q]],
                                };
                            }
                            weight.second[l][m] = product;
                        }
                    }
                }
            }
        }
        &self.all[..n]
    }
}

/// Second derivatives along an axis (per cell squared) of the shape functions of [`Axis`].
#[inline(always)]
fn second(shape: Shape, s: f64, lowest: i32) -> [f64; MOST_NODES] {
    match shape.n_nodes() {
        2 => [0.0; MOST_NODES],
        3 => [1.0, -2.0, 1.0, 0.0],
        _ => {
            let f = s - f64::from(lowest + 1);
            let rest = 1.0 - f;
            [rest, 3.0 * f - 2.0, 3.0 * rest - 2.0, f]
        }
    }
}
