//! Grid to particle for groups of particles in lanes, with the operations of `grid_to_jet.rs` in the same order: results are
//! bitwise identical to those one by one. The numbers of a node are read once for up to four particles.
//!
//! All shape functions, transfers and dimensions take this path; a chunk of fewer than four particles does not.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched work is not compiled for its registers"
)]

use simd_lanes::{Lanes, Registers, SimdLevel, Work};

use crate::grid::background::Grid;
use crate::grid::lattice::Lattice;
use crate::grid::node::Node;
use crate::grid::tile_size::{MOST_NODES, block_edge};
use crate::points::particles::Chunk;
use crate::transfer::group::{
    Group, GroupAxis, LANES, PAIR, components, group_outer, hoop_weights, lanes_of, of_groups,
    parts,
};
use crate::transfer::particle_motion::{GridToParticle, Pass};
use crate::transfer::shape::{Shape, nodes_along};
use crate::transfer::velocity_gradients::VelocityGradients;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Sums over nodes of the particles in lanes.
#[derive(Debug, Clone, Copy)]
struct GroupSums<V, const D: usize> {
    velocity: [V; D],
    change: [V; D],
    gradient: [[V; D]; D],
    moment: [[V; D]; D],
    /// `sum_i v_r (N_i + c N_i'')`.
    around: V,
}

/// Which of the sums a pass needs.
#[derive(Debug, Clone, Copy)]
struct Wanted {
    change: bool,
    slopes: Slopes,
    moment: bool,
}

/// Which slopes of the velocity a pass needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slopes {
    None,
    /// The gradient.
    Gradient,
    /// The gradient and the hoop.
    WithHoop,
}

/// A chunk of particles, at least [`LANES`] of them.
struct ChunkInLanes<'a, 'c, const D: usize, const NODES: usize> {
    transfer: &'a GridToParticle<D>,
    grid: &'a Grid<f64, D>,
    chunk: &'a mut Chunk<'c, f64, D>,
    gradients: &'a mut VelocityGradients<f64>,
}

/// Updates all particles of a chunk, at least [`LANES`] of them, as the pass requires; writes their velocity gradients.
pub(crate) fn grid_to_groups<const D: usize>(
    level: SimdLevel,
    transfer: &GridToParticle<D>,
    grid: &Grid<f64, D>,
    (chunk, gradients): (&mut Chunk<'_, f64, D>, &mut VelocityGradients<f64>),
) {
    match transfer.shape {
        Shape::QuadraticBSpline => {
            level.run_narrow(ChunkInLanes::<D, 3> { transfer, grid, chunk, gradients });
        }
        Shape::CubicBSpline => {
            level.run_narrow(ChunkInLanes::<D, 4> { transfer, grid, chunk, gradients });
        }
    }
}

impl<const D: usize, const NODES: usize> Work<f64> for ChunkInLanes<'_, '_, D, NODES> {
    type Output = ();

    /// The usual cases are compiled separately, without a test at each node.
    #[inline(always)]
    fn run<R: Registers<f64>>(mut self, registers: R) {
        let transfer = *self.transfer;
        let of = |pass, affine| GridToParticle { pass, affine, ..transfer };
        match (transfer.pass, transfer.affine) {
            (Pass::Velocity, false) => self.groups(registers, &of(Pass::Velocity, false)),
            (Pass::Velocity, true) => self.groups(registers, &of(Pass::Velocity, true)),
            (Pass::StressAndMove, _) if D == 2 && transfer.axisymmetric => {
                self.groups(registers, &of(Pass::StressAndMove, false));
            }
            (Pass::StressAndMove, _) => {
                let plain = GridToParticle { axisymmetric: false, ..transfer };
                self.groups(registers, &GridToParticle { affine: false, ..plain });
            }
        }
    }
}

impl<const D: usize, const NODES: usize> ChunkInLanes<'_, '_, D, NODES> {
    #[inline(always)]
    fn groups<R: Registers<f64>>(&mut self, registers: R, transfer: &GridToParticle<D>) {
        let Self { grid, chunk, gradients, .. } = self;
        let (mut begin, end) = (0, chunk.len());
        loop {
            let (mut pair, mut n_groups) = ([Group::none(); PAIR], 0);
            while n_groups < PAIR && begin < end {
                let group = Group::at(chunk.node, begin, end);
                begin += group.len;
                pair[n_groups] = group;
                n_groups += 1;
            }
            if n_groups == 0 {
                return;
            }
            if n_groups < PAIR {
                pair[1] = Group { len: 0, ..pair[0] };
            }
            for part in 0..parts::<R>() {
                let groups = &pair[R::N / LANES * part..];
                if groups[0].len == 0 {
                    continue;
                }
                let x = components(registers, chunk.position, groups);
                let axes =
                    transfer.lattice.group_axes::<R, NODES>(registers, &x, (groups, chunk.base));
                let mut nodes = [grid.from(chunk.node[groups[0].particle()]); PAIR];
                for b in 1..R::N / LANES {
                    nodes[b] = grid.from(chunk.node[groups[b].particle()]);
                }
                let mut around = axes[0].value;
                if transfer.wanted().slopes == Slopes::WithHoop {
                    let place = transfer.lattice.group_radii(registers, x[0], (groups, chunk.base));
                    let curvature = transfer.hoop_curvature;
                    around = hoop_weights::<_, NODES>(&axes[0], place, curvature);
                }
                let sums = transfer.sum_groups::<R, NODES>(registers, (&axes, &around), &nodes);
                transfer.apply_to_groups(registers, chunk, (groups, &x), &sums, gradients);
            }
        }
    }
}

/// Velocity and its change of a node of each group, in all lanes of the group.
#[inline(always)]
fn node_of_groups<R: Registers<f64>, const D: usize>(
    registers: R,
    nodes: [&Node<f64, D>; PAIR],
) -> ([R::Vector; D], [R::Vector; D]) {
    let zero = registers.splat(0.0);
    let (mut velocity, mut change) = ([zero; D], [zero; D]);
    let numbers = [nodes[0].numbers(), nodes[1].numbers()];
    if let (Some(one), Some(two)) = (numbers[0].first_chunk(), numbers[1].first_chunk()) {
        let spread = registers.spread_fours(&[one, two]);
        for k in 0..LANES {
            if k < D {
                velocity[k] = spread[k];
            } else if k < 2 * D {
                change[k - D] = spread[k];
            }
        }
    } else {
        velocity[0] = of_groups(registers, [numbers[0][0], numbers[1][0]]);
        change[0] = of_groups(registers, [numbers[0][1], numbers[1][1]]);
    }
    if let (3, Some(one), Some(two)) = (D, numbers[0].last_chunk(), numbers[1].last_chunk()) {
        let [_, _, y, z] = registers.spread_fours(&[one, two]);
        (change[D - 2], change[D - 1]) = (y, z);
    }
    (velocity, change)
}

/// Sums along a row of nodes.
#[derive(Debug, Clone, Copy)]
struct RowSums<V, const D: usize> {
    velocity: [V; D],
    change: [V; D],
    steep: [V; D],
    moment: [V; D],
    around: V,
}

#[inline(always)]
fn sum_row<R: Registers<f64>, const NODES: usize, const D: usize>(
    registers: R,
    (axis, around): (&GroupAxis<R::Vector>, &[R::Vector; MOST_NODES]),
    rows: [&[Node<f64, D>]; PAIR],
    wanted: Wanted,
) -> RowSums<R::Vector, D> {
    let nothing = [registers.splat(-0.0); D];
    let mut sums = RowSums {
        velocity: nothing,
        change: nothing,
        steep: nothing,
        moment: nothing,
        around: nothing[0],
    };
    for i in 0..NODES {
        let (value, slope) = (axis.value[i], axis.slope[i]);
        let (velocity, change) = node_of_groups(registers, [&rows[0][i], &rows[1][i]]);
        for c in 0..D {
            let v = velocity[c];
            sums.velocity[c] = sums.velocity[c] + v * value;
            if wanted.slopes != Slopes::None {
                sums.steep[c] = sums.steep[c] + v * slope;
            }
            if wanted.moment && i > 0 {
                let arm = value * registers.splat(i as f64);
                sums.moment[c] = sums.moment[c] + v * arm;
            }
            if wanted.change {
                sums.change[c] = sums.change[c] + change[c] * value;
            }
        }
        if wanted.slopes == Slopes::WithHoop {
            sums.around = sums.around + velocity[0] * around[i];
        }
    }
    sums
}

impl<V: Lanes<Number = f64>, const D: usize> GroupSums<V, D> {
    /// Adds row `(j, k)`; `n` and `grad_n` are the factor of the axes beyond the first in the shape function and its slopes.
    #[inline(always)]
    fn add_row(
        &mut self,
        row: &RowSums<V, D>,
        (n, grad_n): (V, &[V; D]),
        (j, k): (usize, usize),
        wanted: Wanted,
    ) {
        if wanted.slopes == Slopes::WithHoop {
            self.around = self.around + row.around * n;
        }
        for c in 0..D {
            let here = row.velocity[c] * n;
            self.velocity[c] = self.velocity[c] + here;
            if wanted.change {
                self.change[c] = self.change[c] + row.change[c] * n;
            }
            if wanted.slopes != Slopes::None {
                self.gradient[0][c] = self.gradient[0][c] + row.steep[c] * n;
                for l in 1..D {
                    self.gradient[l][c] = self.gradient[l][c] + row.velocity[c] * grad_n[l];
                }
            }
            if wanted.moment {
                let of = &mut self.moment[c];
                of[0] = of[0] + row.moment[c] * n;
                if D > 1 {
                    of[D.min(2) - 1] = of[D.min(2) - 1] + here * n.splat(j as f64);
                }
                if D > 2 {
                    of[D - 1] = of[D - 1] + here * n.splat(k as f64);
                }
            }
        }
    }
}

impl<const D: usize> GridToParticle<D> {
    #[inline(always)]
    fn wanted(&self) -> Wanted {
        let is_velocity = self.pass == Pass::Velocity;
        Wanted {
            change: is_velocity && !self.affine,
            slopes: match self.pass {
                Pass::Velocity => Slopes::None,
                Pass::StressAndMove if D == 2 && self.axisymmetric => Slopes::WithHoop,
                Pass::StressAndMove => Slopes::Gradient,
            },
            moment: is_velocity && self.affine,
        }
    }

    /// Sums over the nodes of groups, row by row; `nodes` begin with the lowest one of each group.
    #[inline(always)]
    fn sum_groups<R: Registers<f64>, const NODES: usize>(
        &self,
        registers: R,
        (axes, around): (&[GroupAxis<R::Vector>; D], &[R::Vector; MOST_NODES]),
        nodes: &[&[Node<f64, D>]; PAIR],
    ) -> GroupSums<R::Vector, D> {
        let (edge, wanted) = (block_edge(D), self.wanted());
        // Minus zero is the neutral element of addition; the compiler omits it.
        let nothing = [registers.splat(-0.0); D];
        let mut sums = GroupSums {
            velocity: nothing,
            change: nothing,
            gradient: [nothing; D],
            moment: [nothing; D],
            around: nothing[0],
        };
        for k in 0..nodes_along::<NODES, D>(2) {
            for j in 0..nodes_along::<NODES, D>(1) {
                let (n, grad_n) = group_outer(axes, (j, k));
                let start = (k * edge + j) * edge;
                let rows = [&nodes[0][start..start + NODES], &nodes[1][start..start + NODES]];
                let row = sum_row::<R, NODES, D>(registers, (&axes[0], around), rows, wanted);
                sums.add_row(&row, (n, &grad_n), (j, k), wanted);
            }
        }
        sums
    }
}

impl<const D: usize> GridToParticle<D> {
    /// Updates the particles from their sums over nodes, as `particle_motion.rs` does.
    #[inline(always)]
    fn apply_to_groups<R: Registers<f64>>(
        &self,
        registers: R,
        chunk: &mut Chunk<'_, f64, D>,
        (groups, x): (&[Group], &[R::Vector; D]),
        sums: &GroupSums<R::Vector, D>,
        velocity_gradients: &mut VelocityGradients<f64>,
    ) {
        if self.pass == Pass::StressAndMove {
            self.set_gradients(registers, (groups, x), sums, velocity_gradients);
            return;
        }
        let dt = registers.splat(self.dt);
        let before = components(registers, chunk.velocity, groups);
        let (mut velocity, mut moved) = (before, *x);
        for k in 0..D {
            let new = sums.velocity[k];
            velocity[k] = if self.affine { new } else { velocity[k] + sums.change[k] };
            moved[k] = new * dt;
        }
        if self.affine {
            self.set_matrices(registers, chunk, (groups, x), sums);
        }
        set_vectors(registers, groups, (&velocity, &before), chunk.velocity);
        let before = components(registers, chunk.displacement, groups);
        set_vectors(registers, groups, (&moved, &before), chunk.displacement);
    }

    /// `L_p = sum_i v_i grad N_i`, and the hoop `sum_i v_r (N_i + c N_i'') / r`.
    #[inline(always)]
    fn set_gradients<R: Registers<f64>>(
        &self,
        registers: R,
        (groups, x): (&[Group], &[R::Vector; D]),
        sums: &GroupSums<R::Vector, D>,
        velocity_gradients: &mut VelocityGradients<f64>,
    ) {
        let per_cell = registers.splat(self.lattice.per_cell);
        let mut l = sums.gradient;
        for k in 0..D {
            for m in 0..D {
                l[k][m] = sums.gradient[m][k] * per_cell;
            }
        }
        for k in 0..D {
            for m in 0..D {
                set_lanes(registers, groups, l[k][m], velocity_gradients.entries_mut(k, m));
            }
        }
        if self.axisymmetric {
            let hoop = sums.around / x[0];
            set_lanes(registers, groups, hoop, velocity_gradients.entries_mut(2, 2));
        }
    }

    /// APIC's matrix.
    #[inline(always)]
    fn set_matrices<R: Registers<f64>>(
        &self,
        registers: R,
        chunk: &mut Chunk<'_, f64, D>,
        (groups, x): (&[Group], &[R::Vector; D]),
        sums: &GroupSums<R::Vector, D>,
    ) {
        let Lattice { origin, cell, .. } = self.lattice;
        let lowest = [groups[0], groups[R::N / LANES - 1]].map(|group| group.particle());
        for l in 0..D {
            let corner = of_groups(
                registers,
                [
                    f64::from(chunk.base[lowest[0]][l]) * cell,
                    f64::from(chunk.base[lowest[1]][l]) * cell,
                ],
            );
            let arm = corner - (x[l] - registers.splat(origin[l]));
            for k in 0..D {
                let moment = sums.moment[k][l] * registers.splat(cell);
                let inverse = registers.splat(self.inverse_inertia);
                let matrix = (sums.velocity[k] * arm + moment) * inverse;
                let column = chunk.affine.as_flattened_mut().as_flattened_mut();
                set_numbers(registers, groups, matrix, (column, D * D, D * k + l));
            }
        }
    }
}

/// Writes one number of every particle: number `offset` of its `stride` numbers in a column. All four lanes are written, without a
/// branch; the groups of the particles in other lanes follow and overwrite them.
#[inline(always)]
fn set_numbers<R: Registers<f64>>(
    registers: R,
    groups: &[Group],
    vector: R::Vector,
    (column, stride, offset): (&mut [f64], usize, usize),
) {
    for b in 0..R::N / LANES {
        let (group, lanes) = (groups[b], registers.four(vector, b));
        if group.lane > 0 {
            // At the end of a chunk.
            for lane in group.lane..group.lane + group.len {
                column[stride * (group.first + lane) + offset] = lanes[lane];
            }
        } else if group.len > 0 {
            let column = &mut column[stride * group.first..];
            for lane in 0..LANES {
                column[stride * lane + offset] = lanes[lane];
            }
        }
    }
}

/// Writes a column of vectors. Lanes outside the groups keep the vectors `before`.
#[inline(always)]
fn set_vectors<R: Registers<f64>, const D: usize>(
    registers: R,
    groups: &[Group],
    (vectors, before): (&[R::Vector; D], &[R::Vector; D]),
    column: &mut [[f64; D]],
) {
    let (inside, flat) = (lanes_of(registers, groups), column.as_flattened_mut());
    let mut vectors = *vectors;
    for k in 0..D {
        vectors[k] = R::Vector::select(inside, vectors[k], before[k]);
    }
    if D != 2 || are_last(registers, groups) {
        for k in 0..D {
            set_numbers(registers, groups, vectors[k], (flat, D, k));
        }
        return;
    }
    let halves = registers.zip_fours(vectors[0], vectors[D - 1]);
    for b in 0..R::N / LANES {
        if groups[b].len > 0 {
            let at = D * groups[b].first;
            flat[at..at + LANES].copy_from_slice(&registers.four(halves[0], b));
            flat[at + LANES..at + 2 * LANES].copy_from_slice(&registers.four(halves[1], b));
        }
    }
}

/// Writes a number of every particle, adjacent ones together. All four lanes of a group are written, as [`set_numbers`] does; an empty
/// group has the numbers of the first one.
#[inline(always)]
fn set_lanes<R: Registers<f64>>(
    registers: R,
    groups: &[Group],
    vector: R::Vector,
    column: &mut [f64],
) {
    if are_last(registers, groups) {
        set_numbers(registers, groups, vector, (column, 1, 0));
        return;
    }
    for b in 0..R::N / LANES {
        let first = groups[b].first;
        column[first..first + LANES].copy_from_slice(&registers.four(vector, b));
    }
}

/// Whether a group does not begin in its first lane, as at the end of a chunk.
#[inline(always)]
fn are_last<R: Registers<f64>>(_: R, groups: &[Group]) -> bool {
    let mut lanes = 0;
    for b in 0..R::N / LANES {
        lanes |= groups[b].lane;
    }
    lanes != 0
}
