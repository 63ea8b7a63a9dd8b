//! From particles to nodes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::Range;

use crate::body::Body;
use crate::config::{Config, Geometry, Transfer};
use crate::constitution::Condition;
use crate::grid::Node;
use crate::number::{Number, is_plain};
use crate::shape::{Axis, ShapeFunction, nodes_along, nodes_spanned, outer};
use crate::tiles::block_edge;
use crate::transfer::Places;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Entry `kl` of a symmetric tensor.
const ENTRY: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Particles whose gifts stand in memory together: few enough for the nearest cache.
const BATCH: usize = 12;

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
#[inline(always)]
pub(crate) fn give_outward<F: ShapeFunction, S: Number, const D: usize>(
    axes: &[Axis<S, 1>; D],
    mass: S,
    nodes: &mut [[S; D]],
) {
    let edge = block_edge(D);
    for k in 0..nodes_along::<F, D>(2) {
        for j in 0..nodes_along::<F, D>(1) {
            let (weight, slope) = outer(axes, 0, (j, k));
            for (i, node) in nodes[(k * edge + j) * edge..][..F::NODES].iter_mut().enumerate() {
                node[0] = node[0] + mass * weight * axes[0].slope[i][0];
                for c in 1..D {
                    node[c] = node[c] + mass * slope[c] * axes[0].value[i][0];
                }
            }
        }
    }
}

/// The mass of a particle.
#[inline(always)]
fn give_mass<F: ShapeFunction, S: Number, const D: usize, const N: usize>(
    mass: S,
    (axes, p): (&[Axis<S, N>; D], usize),
    masses: &mut [S],
) {
    let edge = block_edge(D);
    for k in 0..nodes_along::<F, D>(2) {
        for j in 0..nodes_along::<F, D>(1) {
            let by_value = mass * outer(axes, p, (j, k)).0;
            let start = (k * edge + j) * edge;
            let row = &mut masses[start..start + F::NODES];
            for i in 0..F::NODES {
                row[i] = row[i] + by_value * axes[0].value[i][p];
            }
        }
    }
}

/// What is given, and how.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Giver<const D: usize> {
    places: Places<D>,
    given: Given,
    /// Whether with APIC's matrix.
    affine: bool,
    gravity: [f64; D],
    axisymmetric: bool,
    /// Whether anything acts on all nodes of a particle alike: gravity, the hoop.
    everywhere: bool,
}

/// The blocks of a tile.
#[derive(Debug)]
pub(crate) struct Block<'a, S, const D: usize> {
    /// The number of the first node.
    pub(crate) first: usize,
    pub(crate) nodes: &'a mut [Node<S, D>],
    pub(crate) masses: &'a mut [S],
}

/// A run of particles that give. Columns that the configuration leaves out are empty.
#[derive(Debug, Clone, Copy)]
struct Givers<'a, S, const D: usize> {
    position: &'a [[S; D]],
    velocity: &'a [[S; D]],
    affine: &'a [[[S; D]; D]],
    half_length: &'a [[S; D]],
    mass: &'a [S],
    reference_volume: &'a [f64],
    conditions: &'a [Condition<S>],
    base: &'a [[i32; D]],
    node: &'a [usize],
}

impl<'a, S: Number, const D: usize> Givers<'a, S, D> {
    #[inline(always)]
    fn of(body: &'a Body<S, D>, conditions: &'a [Condition<S>], run: Range<usize>) -> Self {
        let (particles, binning) = (&body.particles, &body.binning);
        Self {
            position: &particles.position[run.clone()],
            velocity: &particles.velocity[run.clone()],
            affine: particles.affine.get(run.clone()).unwrap_or_default(),
            half_length: particles.half_length.get(run.clone()).unwrap_or_default(),
            mass: &particles.mass[run.clone()],
            reference_volume: &particles.reference_volume[run.clone()],
            conditions: &conditions[run.clone()],
            base: &binning.bases[run.clone()],
            node: &binning.nodes[run],
        }
    }
}

impl<const D: usize> Giver<D> {
    pub(crate) fn of(config: &Config<D>, places: Places<D>, given: Given) -> Self {
        let axisymmetric = config.geometry == Geometry::Axisymmetric;
        let falls = config.gravity.iter().any(|&along| along != 0.0);
        Self {
            places,
            given,
            affine: config.transfer == Transfer::Apic,
            gravity: config.gravity,
            axisymmetric,
            everywhere: falls || axisymmetric,
        }
    }

    /// Of plain numbers, in the usual cases, what is given is known to the compiler, which then asks at no node; beside the
    /// arithmetic of a jet a question costs nothing, and its code is long.
    #[inline(always)]
    pub(crate) fn give_all<F: ShapeFunction, S: Number>(
        &self,
        body: &Body<S, D>,
        slot: usize,
        block: &mut Block<'_, S, D>,
    ) {
        if const { !is_plain::<S>() } {
            self.give_each::<F, S, 1>(body, slot, block);
            return;
        }
        let plain = Self { affine: false, axisymmetric: false, everywhere: false, ..*self };
        match (self.given, self.affine || self.everywhere) {
            (Given::MotionAndForce, false) => {
                let force = Self { given: Given::MotionAndForce, ..plain };
                force.give_each::<F, S, BATCH>(body, slot, block);
            }
            (Given::MotionAgain, _) if !self.affine => {
                let motion = Self { given: Given::MotionAgain, ..plain };
                motion.give_each::<F, S, BATCH>(body, slot, block);
            }
            _ => self.give_each::<F, S, BATCH>(body, slot, block),
        }
    }

    /// The particles of a body in a tile, `N` at a time: what each has to give first stands in memory, whence registers take
    /// several numbers at once.
    #[inline(always)]
    fn give_each<F: ShapeFunction, S: Number, const N: usize>(
        &self,
        body: &Body<S, D>,
        slot: usize,
        block: &mut Block<'_, S, D>,
    ) {
        let conditions = body.constitution.conditions();
        let mut axes = [Axis::<S, N>::empty(); D];
        let mut gifts = [Gift::nothing(); N];
        for run in body.binning.runs_of(slot) {
            let mut begin = run.start;
            while begin < run.end {
                let end = run.end.min(begin + N);
                let givers = Givers::of(body, conditions, begin..end);
                let gifts = &mut gifts[..end - begin];
                let Givers { position, half_length, base, .. } = givers;
                self.places.find_axes::<F, S, N>(position, half_length, base, &mut axes);
                for p in 0..gifts.len() {
                    self.find_gift(&givers, p, &mut gifts[p]);
                }
                for p in 0..gifts.len() {
                    let node = givers.node[p] - block.first;
                    let end = node + nodes_spanned::<F, D>();
                    self.give::<F, S, N>((&gifts[p], &axes, p), &mut block.nodes[node..end]);
                    if self.given != Given::MotionAgain {
                        let masses = &mut block.masses[node..end];
                        give_mass::<F, S, D, N>(gifts[p].mass, (&axes, p), masses);
                    }
                }
                begin = end;
            }
        }
    }

    #[inline(always)]
    fn find_gift<S: Number>(&self, of: &Givers<'_, S, D>, p: usize, gift: &mut Gift<S, D>) {
        let places = &self.places;
        gift.mass = of.mass[p];
        let mut momentum = of.velocity[p];
        if self.affine {
            let (matrix, x) = (&of.affine[p], &of.position[p]);
            for l in 0..D {
                let arm = -(x[l] - places.origin[l]) + f64::from(of.base[p][l]) * places.cell;
                for k in 0..D {
                    momentum[k] = momentum[k] + matrix[k][l] * arm;
                    gift.growth[l][k] = matrix[k][l] * gift.mass * places.cell;
                }
            }
        }
        for k in 0..D {
            gift.along.motion[k] = momentum[k] * gift.mass;
        }
        if self.given == Given::MotionAndForce {
            let force = self.force(of, p);
            for c in 0..D {
                gift.along.change[c] = force[0][c];
                if D > 1 {
                    gift.across.change[c] = force[D.min(2) - 1][c];
                }
                if D > 2 {
                    gift.further[c] = force[D - 1][c];
                }
            }
            if self.everywhere {
                gift.everywhere = self.force_everywhere(of, p);
            }
        }
    }

    #[inline(always)]
    fn give<F: ShapeFunction, S: Number, const N: usize>(
        &self,
        (gift, axes, p): (&Gift<S, D>, &[Axis<S, N>; D], usize),
        nodes: &mut [Node<S, D>],
    ) {
        let Self { given, affine, everywhere, .. } = *self;
        let (zero, edge) = (S::constant(0.0), block_edge(D));
        let (with_force, growth) = (given == Given::MotionAndForce, &gift.growth);
        let (value, slopes) = (&axes[0].value, &axes[0].slope);
        for k in 0..nodes_along::<F, D>(2) {
            for j in 0..nodes_along::<F, D>(1) {
                let (weight, slope) = outer(axes, p, (j, k));
                let start = (k * edge + j) * edge;
                // What of the row's nodes is by the values across the rows, and by the slopes there.
                let mut along: Node<S, D> = Node::zero();
                let mut across: Node<S, D> = Node::zero();
                let mut steps = [zero; D];
                for c in 0..D {
                    let mut motion = gift.along.motion[c];
                    if affine {
                        if D > 1 {
                            motion = motion + growth[D.min(2) - 1][c] * j as f64;
                        }
                        if D > 2 {
                            motion = motion + growth[D - 1][c] * k as f64;
                        }
                        steps[c] = growth[0][c] * weight;
                    }
                    along.motion[c] = motion * weight;
                    if with_force {
                        along.change[c] = gift.along.change[c] * weight;
                        if const { is_plain::<S>() } {
                            across.motion[c] = gift.across.motion[c] * slope[D.min(2) - 1];
                        }
                        across.change[c] = gift.across.change[c] * slope[D.min(2) - 1];
                        if D > 2 {
                            across.change[c] = across.change[c] + gift.further[c] * slope[D - 1];
                        }
                        if everywhere {
                            across.change[c] = across.change[c] + gift.everywhere[c] * weight;
                        }
                    }
                }
                let row = &mut nodes[start..start + F::NODES];
                for i in 0..F::NODES {
                    let (node, value, slope) = (&mut row[i], &value[i][p], &slopes[i][p]);
                    for c in 0..D {
                        let mut motion = along.motion[c];
                        if affine {
                            motion = motion + steps[c] * i as f64;
                        }
                        let mut part = motion * *value;
                        // Of plain numbers a zero, so that a register takes motion and force alike.
                        if with_force && const { is_plain::<S>() } {
                            part = part + across.motion[c] * *slope;
                        }
                        node.motion[c] = node.motion[c] + part;
                    }
                    if with_force {
                        for c in 0..D {
                            let part = along.change[c] * *slope + across.change[c] * *value;
                            node.change[c] = node.change[c] + part;
                        }
                    }
                }
            }
        }
    }

    /// `- V sigma` over the cell, by the axis of the gradient.
    #[inline(always)]
    fn force<S: Number>(&self, of: &Givers<'_, S, D>, p: usize) -> [[S; D]; D] {
        let condition = &of.conditions[p];
        let factor = condition.volume * of.reference_volume[p] * -self.places.per_cell;
        let mut stress = condition.stress.0;
        for k in 0..3 {
            stress[k] = stress[k] - condition.viscosity;
        }
        let mut force = [[factor; D]; D];
        for l in 0..D {
            for k in 0..D {
                force[l][k] = stress[ENTRY[k][l]] * factor;
            }
        }
        force
    }

    /// What acts on all nodes of a particle alike: gravity, the hoop.
    #[inline(always)]
    fn force_everywhere<S: Number>(&self, of: &Givers<'_, S, D>, p: usize) -> [S; D] {
        let mut force = [of.mass[p]; D];
        for k in 0..D {
            force[k] = of.mass[p] * self.gravity[k];
        }
        if self.axisymmetric {
            let condition = &of.conditions[p];
            let volume = condition.volume * of.reference_volume[p];
            let hoop = condition.stress.0[2] - condition.viscosity;
            force[0] = force[0] - volume * hoop / of.position[p][0];
        }
        force
    }
}

/// What a particle gives, in the order in which registers take it. What the configuration leaves out is not written.
#[derive(Debug, Clone, Copy)]
struct Gift<S, const D: usize> {
    /// Momentum at the lowest node, by the value; the force along the rows, by the slope there.
    along: Node<S, D>,
    mass: S,
    /// No momentum; the force along the second axis.
    across: Node<S, D>,
    /// Force along the third axis.
    further: [S; D],
    /// Force on all nodes alike.
    everywhere: [S; D],
    /// By how much the momentum grows from node to node along each axis.
    growth: [[S; D]; D],
}

impl<S: Number, const D: usize> Gift<S, D> {
    #[inline(always)]
    fn nothing() -> Self {
        let zero = S::constant(0.0);
        Self {
            along: Node::zero(),
            across: Node::zero(),
            further: [zero; D],
            everywhere: [zero; D],
            growth: [[zero; D]; D],
            mass: zero,
        }
    }
}
