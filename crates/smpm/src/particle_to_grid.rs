//! Particle to grid (P2G): nodal mass, momentum and force.
//!
//! $$ m_i = \sum_p m_p N_i(x_p), \qquad (m v)_i = \sum_p m_p (v_p + C_p (x_i - x_p)) N_i(x_p), \qquad
//!    f_i = \sum_p m_p N_i(x_p) b - V_p \sigma_p \nabla N_i(x_p) $$
//!
//! Chen et al. 2019, eq 3 and 6 with their errata; `C_p` is APIC's matrix, zero with FLIP. `N_i(x_p)` is a product of values
//! along the axes: at the nodes of a row, those along the first axis vary, the others are in `n`, and `grad n`.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::body::Body;
use crate::jet_to_grid::JetToGrid;
use crate::node::Node;
use crate::number::{Number, one_by_one};
use crate::particle_terms::{Given, ParticleToGrid, Run, Terms};
use crate::shape::{Axis, Shape, nodes_along, nodes_spanned, outer};
use crate::tile_size::block_edge;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// The blocks of a tile.
#[derive(Debug)]
struct Block<'a, S, const D: usize> {
    /// The number of the first node.
    first: usize,
    nodes: &'a mut [Node<S, D>],
    masses: &'a mut [S],
}

/// What the nodes of a row have in common.
#[derive(Debug)]
struct RowTerms<S, const D: usize> {
    /// Momentum, of which a node has the part by the value along the row; force, by the slope there.
    along: Node<S, D>,
    /// Force, of which a node has the part by the value.
    across: [S; D],
    /// By how much the momentum grows from node to node.
    growth: [S; D],
}

impl<S: Number, const D: usize> RowTerms<S, D> {
    #[inline(always)]
    fn zero() -> Self {
        let zero = [S::constant(0.0); D];
        Self { along: Node::zero(), across: zero, growth: zero }
    }
}

impl<const D: usize> ParticleToGrid<D> {
    /// The particles of a body in a tile, each alone, to the tile's blocks from node number `first` on.
    pub(crate) fn one_by_one<S: Number>(
        &self,
        body: &Body<S, D>,
        slot: usize,
        (first, nodes, masses): (usize, &mut [Node<S, D>], &mut [S]),
    ) {
        let block = &mut Block { first, nodes, masses };
        match self.shape.n_nodes() {
            2 => self.tile::<S, 2>(body, slot, block),
            3 => self.tile::<S, 3>(body, slot, block),
            _ => self.tile::<S, 4>(body, slot, block),
        }
    }

    /// The particles of a body in a tile, one by one. Those of `f64` are in lanes, but where a body has fewer than a register
    /// holds. Numbers that show their derivatives have plain weights ([`JetToGrid`]), but not with GIMP, where the length of a
    /// particle has derivatives too. There, and for a number of a user, every weight is such a number.
    fn tile<S: Number, const NODES: usize>(
        &self,
        body: &Body<S, D>,
        slot: usize,
        block: &mut Block<'_, S, D>,
    ) {
        if const { S::ORDER > 0 } && (NODES != Shape::Gimp.n_nodes() || self.shape != Shape::Gimp) {
            let (transfer, first) = (*self, block.first);
            let (nodes, masses) = (&mut *block.nodes, &mut *block.masses);
            JetToGrid::<_, D, NODES> { transfer, body, slot, first, nodes, masses }.add_all();
            return;
        }
        one_by_one::<S>(
            #[inline(always)]
            || self.particles::<S, NODES>(body, slot, block),
        );
    }

    #[inline(always)]
    fn particles<S: Number, const NODES: usize>(
        &self,
        body: &Body<S, D>,
        slot: usize,
        block: &mut Block<'_, S, D>,
    ) {
        let conditions = body.points.conditions();
        let mut terms = Terms::zero();
        for run in body.binning.runs_of(slot) {
            let of = Run::of(body, &conditions, run);
            for p in 0..of.node.len() {
                let place = (&of.position[p], of.half_length.get(p));
                let axes = self.lattice.axes::<S, NODES>(self.shape, place, &of.base[p]);
                self.find_terms(&of, p, &mut terms);
                let node = of.node[p] - block.first;
                let end = node + nodes_spanned::<NODES, D>();
                self.add::<S, NODES>((&terms, &axes), &mut block.nodes[node..end]);
                if self.given != Given::Momentum {
                    add_mass::<S, NODES, D>(terms.mass, &axes, &mut block.masses[node..end]);
                }
            }
        }
    }

    /// Momentum and force of a particle at every node that it sees.
    #[inline(always)]
    fn add<S: Number, const NODES: usize>(
        &self,
        (terms, axes): (&Terms<S, D>, &[Axis<S>; D]),
        nodes: &mut [Node<S, D>],
    ) {
        let edge = block_edge(D);
        for k in 0..nodes_along::<NODES, D>(2) {
            for j in 0..nodes_along::<NODES, D>(1) {
                let (n, grad_n) = outer(axes, (j, k));
                let mut common = RowTerms::zero();
                self.find_row_terms(terms, (j, k), (n, &grad_n), &mut common);
                let start = (k * edge + j) * edge;
                let row = &mut nodes[start..start + NODES];
                for i in 0..NODES {
                    let RowTerms { along, across, growth } = &common;
                    let (value, slope) = (axes[0].value[i], axes[0].slope[i]);
                    let node = &mut row[i];
                    for c in 0..D {
                        let mut momentum = along.momentum()[c];
                        if self.affine {
                            momentum = momentum + growth[c] * i as f64;
                        }
                        node.momentum_mut()[c] = node.momentum()[c] + momentum * value;
                    }
                    if self.with_force() {
                        for c in 0..D {
                            let part = along.force()[c] * slope + across[c] * value;
                            node.force_mut()[c] = node.force()[c] + part;
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn find_row_terms<S: Number>(
        &self,
        terms: &Terms<S, D>,
        (j, k): (usize, usize),
        (n, grad_n): (S, &[S; D]),
        row: &mut RowTerms<S, D>,
    ) {
        for c in 0..D {
            let mut momentum = terms.along.momentum()[c];
            if self.affine {
                if D > 1 {
                    momentum = momentum + terms.growth[D.min(2) - 1][c] * j as f64;
                }
                if D > 2 {
                    momentum = momentum + terms.growth[D - 1][c] * k as f64;
                }
                row.growth[c] = terms.growth[0][c] * n;
            }
            row.along.momentum_mut()[c] = momentum * n;
            if self.with_force() {
                row.along.force_mut()[c] = terms.along.force()[c] * n;
                let across = &mut row.across[c];
                *across = terms.across.force()[c] * grad_n[D.min(2) - 1];
                if D > 2 {
                    *across = *across + terms.force_z[c] * grad_n[D - 1];
                }
                if self.body_force {
                    *across = *across + terms.body_force[c] * n;
                }
            }
        }
    }

    #[inline(always)]
    fn with_force(&self) -> bool {
        self.given == Given::MassMomentumAndForce
    }
}

/// The mass of a particle at every node that it sees.
#[inline(always)]
fn add_mass<S: Number, const NODES: usize, const D: usize>(
    mass: S,
    axes: &[Axis<S>; D],
    masses: &mut [S],
) {
    let edge = block_edge(D);
    for k in 0..nodes_along::<NODES, D>(2) {
        for j in 0..nodes_along::<NODES, D>(1) {
            let mass_n = mass * outer(axes, (j, k)).0;
            let start = (k * edge + j) * edge;
            let row = &mut masses[start..start + NODES];
            for i in 0..NODES {
                row[i] = row[i] + mass_n * axes[0].value[i];
            }
        }
    }
}
