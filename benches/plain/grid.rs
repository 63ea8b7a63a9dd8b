//! Background grid of a hand-written material point step: one array of nodes over a box that the body does not leave.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

/// A node. During P2G it holds mass, momentum, force; during G2P mass, velocity, velocity change over the step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    pub(crate) mass: f64,
    pub(crate) motion: [f64; 2],
    pub(crate) change: [f64; 2],
}

pub(crate) const EMPTY: Node = Node { mass: 0.0, motion: [0.0; 2], change: [0.0; 2] };

/// Nodes beyond the body on each side: the range of its motion.
const MARGIN: f64 = 12.0;

#[derive(Debug)]
pub(crate) struct Grid {
    pub(crate) cell: f64,
    per_cell: f64,
    low: [f64; 2],
    pub(crate) width: usize,
    pub(crate) nodes: Vec<Node>,
}

/// Quadratic B-splines around a particle.
///
/// Values and slopes (per cell) along both axes, and the first node of the lowest row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights {
    pub(crate) value: [[f64; 3]; 2],
    pub(crate) slope: [[f64; 3]; 2],
    pub(crate) first: usize,
}

impl Grid {
    /// A grid over the unit square and the range of the body's motion beyond it.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few hundred nodes along an axis"
    )]
    pub(crate) fn around_unit_square(cell: f64) -> Self {
        let width = (1.0 / cell + 2.0 * MARGIN).ceil() as usize;
        let low = [-MARGIN * cell; 2];
        Self { cell, per_cell: 1.0 / cell, low, width, nodes: vec![EMPTY; width * width] }
    }

    #[inline(always)]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a place outside the box is found by the bounds of the array"
    )]
    pub(crate) fn weights(&self, x: [f64; 2]) -> Weights {
        let (mut value, mut slope, mut base) = ([[0.0; 3]; 2], [[0.0; 3]; 2], [0; 2]);
        for k in 0..2 {
            let place = (x[k] - self.low[k]) * self.per_cell;
            // Positive inside the box, so truncation equals the floor.
            let node = (place - 0.5) as i32;
            base[k] = node as usize;
            let f = place - f64::from(node);
            let (left, centre, right) = (1.5 - f, f - 1.0, f - 0.5);
            value[k] = [0.5 * left * left, 0.75 - centre * centre, 0.5 * right * right];
            slope[k] = [-left, -2.0 * centre, right];
        }
        Weights { value, slope, first: base[1] * self.width + base[0] }
    }

    /// Converts momenta and forces to velocities and their change; a node with negligible mass has zero velocity.
    #[inline(always)]
    pub(crate) fn solve(&mut self, dt: f64, least_mass: f64) {
        for node in &mut self.nodes {
            if node.mass <= least_mass {
                *node = EMPTY;
                continue;
            }
            let inverse = 1.0 / node.mass;
            for k in 0..2 {
                node.change[k] *= inverse * dt;
                node.motion[k] = node.motion[k] * inverse + node.change[k];
            }
        }
    }
}
