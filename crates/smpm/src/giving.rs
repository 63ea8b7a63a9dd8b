//! From particles to nodes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::config::{Config, Geometry};
use crate::constitution::Condition;
use crate::grid::Node;
use crate::number::Number;
use crate::particles::Particles;
use crate::shape::{Axis, ShapeFunction, nodes_along, outer};
use crate::tiles::block_edge;
use crate::transfer::Places;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Entry `kl` of a symmetric tensor.
const ENTRY: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// What particles give to the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Given {
    /// Mass and momentum.
    Motion,
    /// Momentum alone: the nodes know their masses.
    MotionAgain,
    /// Mass, momentum and force.
    MotionAndForce,
}

/// The gradient of a particle's mass.
pub(crate) fn give_outward<F: ShapeFunction, S: Number, const D: usize>(
    axes: &[Axis<S>; D],
    mass: S,
    nodes: &mut [[S; D]],
) {
    let edge = block_edge(D);
    for k in 0..nodes_along::<F, D>(2) {
        for j in 0..nodes_along::<F, D>(1) {
            let (weight, slope) = outer(axes, (j, k));
            for (i, node) in nodes[(k * edge + j) * edge..][..F::NODES].iter_mut().enumerate() {
                node[0] = node[0] + mass * weight * axes[0].slope[i];
                for c in 1..D {
                    node[c] = node[c] + mass * slope[c] * axes[0].value[i];
                }
            }
        }
    }
}

/// A particle that gives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Giver<'a, S, const D: usize> {
    pub(crate) places: Places<D>,
    pub(crate) particles: &'a Particles<S, D>,
    pub(crate) p: usize,
    /// The lowest node that it sees.
    pub(crate) base: &'a [i32; D],
    pub(crate) config: &'a Config<D>,
    /// Whether with APIC's matrix.
    pub(crate) affine: bool,
}

impl<S: Number, const D: usize> Giver<'_, S, D> {
    #[inline(always)]
    pub(crate) fn give<F: ShapeFunction>(
        &self,
        axes: &[Axis<S>; D],
        condition: &Condition<S>,
        given: Given,
        nodes: &mut [Node<S, D>],
    ) {
        let Self { places, particles, p, base, affine, .. } = *self;
        let edge = block_edge(D);
        let zero = S::constant(0.0);
        // Momentum at the lowest node, and by how much it grows from node to node along each axis.
        let mass = particles.mass[p];
        let mut momentum = particles.velocity[p];
        let mut growth = [[zero; D]; D];
        if affine {
            let (matrix, x) = (&particles.affine[p], &particles.position[p]);
            for l in 0..D {
                let arm = -(x[l] - places.origin[l]) + f64::from(base[l]) * places.cell;
                for k in 0..D {
                    momentum[k] = momentum[k] + matrix[k][l] * arm;
                    growth[l][k] = matrix[k][l] * mass * places.cell;
                }
            }
        }
        for k in 0..D {
            momentum[k] = momentum[k] * mass;
        }
        let (with_mass, with_force) = (given != Given::MotionAgain, given == Given::MotionAndForce);
        let force = if with_force { self.force(condition) } else { Force::none() };
        for k in 0..nodes_along::<F, D>(2) {
            for j in 0..nodes_along::<F, D>(1) {
                let (weight, slope) = outer(axes, (j, k));
                let start = (k * edge + j) * edge;
                let row = &mut nodes[start..start + F::NODES];
                let (value, along) = (&axes[0].value, &axes[0].slope);
                let mut carried = momentum;
                if affine {
                    for c in 0..D {
                        if D > 1 {
                            carried[c] = carried[c] + growth[D.min(2) - 1][c] * j as f64;
                        }
                        if D > 2 {
                            carried[c] = carried[c] + growth[D - 1][c] * k as f64;
                        }
                    }
                }
                // What the row's nodes get times the value, and times the slope along the row; in the order of a node's
                // components, so that a register takes several.
                let mut by_value: Node<S, D> = Node { mass: mass * weight, ..Node::zero() };
                let (mut by_slope, mut steps) = ([zero; D], [zero; D]);
                for c in 0..D {
                    by_value.motion[c] = carried[c] * weight;
                    if affine {
                        steps[c] = growth[0][c] * weight;
                    }
                    if with_force {
                        by_slope[c] = force.by_gradient[c][0] * weight;
                        for l in 1..D {
                            let part = force.by_gradient[c][l] * slope[l];
                            by_value.change[c] = by_value.change[c] + part;
                        }
                        if force.everywhere {
                            by_value.change[c] = by_value.change[c] + force.by_value[c] * weight;
                        }
                    }
                }
                for i in 0..F::NODES {
                    let node = &mut row[i];
                    if with_mass {
                        node.mass = node.mass + by_value.mass * value[i];
                    }
                    for c in 0..D {
                        let mut motion = by_value.motion[c];
                        if affine {
                            motion = motion + steps[c] * i as f64;
                        }
                        node.motion[c] = node.motion[c] + motion * value[i];
                    }
                    if with_force {
                        for c in 0..D {
                            let part = by_value.change[c] * value[i] + by_slope[c] * along[i];
                            node.change[c] = node.change[c] + part;
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn force(&self, condition: &Condition<S>) -> Force<S, D> {
        let Self { particles, p, config, .. } = *self;
        let volume = condition.volume * particles.reference_volume[p];
        let factor = volume * (-1.0 / config.cell);
        let mut stress = condition.stress.0;
        for k in 0..3 {
            stress[k] = stress[k] - condition.viscosity;
        }
        let mut force = Force::none();
        for k in 0..D {
            for l in 0..D {
                force.by_gradient[k][l] = stress[ENTRY[k][l]] * factor;
            }
            if config.gravity[k] != 0.0 {
                force.by_value[k] = particles.mass[p] * config.gravity[k];
                force.everywhere = true;
            }
        }
        if config.geometry == Geometry::Axisymmetric {
            force.by_value[0] = force.by_value[0] - volume * stress[2] / particles.position[p][0];
            force.everywhere = true;
        }
        force
    }
}

/// The force of a particle: `- V sigma` over the cell, and what acts on its nodes alike: gravity, the hoop.
#[derive(Debug, Clone, Copy)]
struct Force<S, const D: usize> {
    by_gradient: [[S; D]; D],
    by_value: [S; D],
    /// Whether there is such.
    everywhere: bool,
}

impl<S: Number, const D: usize> Force<S, D> {
    #[inline(always)]
    fn none() -> Self {
        let zero = S::constant(0.0);
        Self { by_gradient: [[zero; D]; D], by_value: [zero; D], everywhere: false }
    }
}
