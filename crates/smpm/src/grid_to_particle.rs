//! Grid to particle (G2P): velocity and velocity gradient of the particles.
//!
//! $$ v_p \leftarrow v_p + \sum_i \Delta v_i N_i(x_p) \;\text{(FLIP)} \quad\text{or}\quad \sum_i v_i N_i(x_p) \;\text{(PIC, APIC)},
//!    \qquad L_p = \sum_i v_i \nabla N_i(x_p), \qquad x_p \leftarrow x_p + \Delta t \sum_i v_i N_i(x_p) $$
//!
//! With GIMP the particle's lengths follow `L_p` (Chen et al. 2019, eq 8), its density too (eq 9, in the material update). Here
//! are the sums over the nodes; what a particle makes of them is [`GridToParticle::apply`]. `N_i(x_p)` is a product of values along
//! the axes: at the nodes of a row, those along the first axis vary, the others are in `n`, and `grad n`.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use crate::grid::Grid;
use crate::grid_to_jet::GridToJet;
use crate::node::Node;
use crate::number::{Number, one_by_one};
use crate::particle_motion::{GridToParticle, Sums, nothing};
use crate::particles::Chunk;
use crate::shape::{Axis, Shape, nodes_along, nodes_spanned, outer};
use crate::tile_size::block_edge;
use crate::velocity_gradients::VelocityGradients;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

impl<const D: usize> GridToParticle<D> {
    /// What the pass asks of all particles of a chunk, each alone; velocity gradients go into `gradients`.
    pub(crate) fn one_by_one<S: Number>(
        &self,
        grid: &Grid<S, D>,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut VelocityGradients<S>,
    ) {
        match self.shape.n_nodes() {
            2 => self.in_registers::<S, 2>(grid, chunk, gradients),
            3 => self.in_registers::<S, 3>(grid, chunk, gradients),
            _ => self.in_registers::<S, 4>(grid, chunk, gradients),
        }
    }

    /// Numbers that show their derivatives have plain weights ([`GridToJet`]), but not with GIMP, where the length of a particle has
    /// derivatives too. Others go one by one.
    #[inline(never)]
    fn in_registers<S: Number, const NODES: usize>(
        &self,
        grid: &Grid<S, D>,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut VelocityGradients<S>,
    ) {
        if const { S::ORDER > 0 } && (NODES != Shape::Gimp.n_nodes() || self.shape != Shape::Gimp) {
            GridToJet::<_, D, NODES> { transfer: *self, grid, chunk, gradients }.find_all();
            return;
        }
        one_by_one::<S>(
            #[inline(always)]
            || self.particles::<S, NODES>(grid, chunk, gradients),
        );
    }

    #[inline(always)]
    fn particles<S: Number, const NODES: usize>(
        &self,
        grid: &Grid<S, D>,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut VelocityGradients<S>,
    ) {
        let mut sums = Sums::none();
        for p in 0..chunk.len() {
            let place = (&chunk.position[p], chunk.half_length.get(p));
            let axes = self.lattice.axes::<S, NODES>(self.shape, place, &chunk.base[p]);
            let nodes = &grid.from(chunk.node[p])[..nodes_spanned::<NODES, D>()];
            self.sum::<S, NODES>(&axes, nodes, &mut sums);
            let mut gradient = [[S::constant(0.0); 3]; 3];
            self.apply::<S, NODES>(chunk, p, &sums, &mut gradient);
            gradients.set(p, &gradient);
        }
    }

    /// The sums over the nodes that a particle sees, row by row.
    #[inline(always)]
    fn sum<S: Number, const NODES: usize>(
        &self,
        axes: &[Axis<S>; D],
        nodes: &[Node<S, D>],
        sums: &mut Sums<S, D>,
    ) {
        let (edge, value) = (block_edge(D), &axes[0].value);
        *sums = Sums::none();
        let with_change = self.pass.updates_velocity() && (!self.with_pic || self.shares.0 != 0.0);
        let with_matrix = self.pass.updates_velocity() && self.affine;
        let with_moment = with_matrix && self.inverse_inertia.is_some();
        let with_gradient = self.pass.updates_stress() || (with_matrix && !with_moment);
        for k in 0..nodes_along::<NODES, D>(2) {
            for j in 0..nodes_along::<NODES, D>(1) {
                let (n, grad_n) = outer(axes, (j, k));
                let start = (k * edge + j) * edge;
                let row = &nodes[start..start + NODES];
                let (mut velocity, mut change) = ([nothing::<S>(); D], [nothing::<S>(); D]);
                for i in 0..NODES {
                    for c in 0..D {
                        velocity[c] = velocity[c] + row[i].velocity()[c] * value[i];
                    }
                    if with_change {
                        for c in 0..D {
                            change[c] = change[c] + row[i].velocity_change()[c] * value[i];
                        }
                    }
                }
                for c in 0..D {
                    let here = velocity[c] * n;
                    sums.velocity[c] = sums.velocity[c] + here;
                    if with_change {
                        sums.change[c] = sums.change[c] + change[c] * n;
                    }
                    if with_moment {
                        add_moment_across(&mut sums.moment[c], here, (j, k));
                    }
                }
                if with_gradient {
                    add_gradient::<S, NODES, D>(axes, row, &velocity, (n, &grad_n), sums);
                }
                if with_moment {
                    add_moment_along::<S, NODES, D>(axes, row, n, sums);
                }
            }
        }
    }
}

/// The part of a row in `sum_i v_k dN_i/dx_l`, with `velocity` its part of `sum_i v_k N_i` but for `n`.
#[inline(always)]
fn add_gradient<S: Number, const NODES: usize, const D: usize>(
    axes: &[Axis<S>; D],
    row: &[Node<S, D>],
    velocity: &[S; D],
    (n, grad_n): (S, &[S; D]),
    sums: &mut Sums<S, D>,
) {
    let mut steep = [nothing::<S>(); D];
    for i in 0..NODES {
        for c in 0..D {
            steep[c] = steep[c] + row[i].velocity()[c] * axes[0].slope[i];
        }
    }
    for c in 0..D {
        sums.gradient[0][c] = sums.gradient[0][c] + steep[c] * n;
        for l in 1..D {
            sums.gradient[l][c] = sums.gradient[l][c] + velocity[c] * grad_n[l];
        }
    }
}

/// The part of row `(j, k)` in `sum_i v_k n_il N_i` for the axes `l` beyond the first, with `here` its part of `sum_i v_k N_i`.
#[inline(always)]
fn add_moment_across<S: Number, const D: usize>(
    moment: &mut [S; D],
    here: S,
    (j, k): (usize, usize),
) {
    if D > 1 {
        let l = D.min(2) - 1;
        moment[l] = moment[l] + here * j as f64;
    }
    if D > 2 {
        moment[D - 1] = moment[D - 1] + here * k as f64;
    }
}

/// The same along the row.
#[inline(always)]
fn add_moment_along<S: Number, const NODES: usize, const D: usize>(
    axes: &[Axis<S>; D],
    row: &[Node<S, D>],
    n: S,
    sums: &mut Sums<S, D>,
) {
    let mut moment = [nothing::<S>(); D];
    for i in 1..NODES {
        for c in 0..D {
            moment[c] = moment[c] + row[i].velocity()[c] * (axes[0].value[i] * i as f64);
        }
    }
    for c in 0..D {
        sums.moment[c][0] = sums.moment[c][0] + moment[c] * n;
    }
}
