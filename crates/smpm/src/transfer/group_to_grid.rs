//! Particle to grid for groups of particles in lanes, with the formulas of `jet_to_grid.rs`.
//!
//! Contributions are summed over a group in registers, so a node is read and written once for up to four particles. Against the sums
//! one by one this changes the order of summation: results agree within roundoff. All shape functions, transfers and dimensions
//! take this path; bodies of fewer than four particles do not.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched work is not compiled for its registers"
)]

use simd_lanes::{Lanes, Registers, SimdLevel, Work};

use crate::grid::node::Node;
use crate::grid::tile_size::{MOST_NODES, block_edge};
use crate::points::body::Body;
use crate::points::conditions::Columns;
use crate::transfer::group::{
    Group, GroupAxis, LANES, PAIR, components, group_outer, hoop_weights, lanes_of, numbers,
    of_groups, parts,
};
use crate::transfer::particle_terms::{ENTRY, Given, ParticleToGrid};
use crate::transfer::shape::{Shape, nodes_along};

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// The terms of the particles of a group, as in `particle_terms.rs`; zero in the lanes of others.
#[derive(Debug, Clone, Copy)]
struct GroupTerms<V, const D: usize> {
    mass: V,
    momentum: [V; D],
    growth: [[V; D]; D],
    force: [[V; D]; D],
    body_force: [V; D],
    /// The force of the hoop, along the radius, and the weights of the nodes along it.
    hoop: V,
    around: [V; MOST_NODES],
}

/// Factors common to a row of nodes.
#[derive(Debug, Clone, Copy)]
struct GroupRow<V, const D: usize> {
    mass: V,
    momentum: [V; D],
    growth: [V; D],
    /// Force, to be multiplied by the slope along the row.
    along: [V; D],
    /// Force, to be multiplied by the value along the row.
    across: [V; D],
    /// Force, to be multiplied by the weight of the hoop along the row.
    hoop: V,
}

/// The particles of a body in a tile, and the blocks of the tile from node number `first` on.
struct TileInLanes<'a, const D: usize, const NODES: usize> {
    transfer: &'a ParticleToGrid<D>,
    body: &'a Body<f64, D>,
    slot: usize,
    first: usize,
    nodes: &'a mut [Node<f64, D>],
    masses: &'a mut [f64],
}

/// Adds the particles of a body in a tile to the nodes. The body has at least [`LANES`] particles.
pub(crate) fn groups_to_grid<const D: usize>(
    level: SimdLevel,
    transfer: &ParticleToGrid<D>,
    (body, slot): (&Body<f64, D>, usize),
    (first, nodes, masses): (usize, &mut [Node<f64, D>], &mut [f64]),
) {
    match transfer.shape {
        Shape::QuadraticBSpline => {
            level.run(TileInLanes::<D, 3> { transfer, body, slot, first, nodes, masses });
        }
        Shape::CubicBSpline => {
            level.run(TileInLanes::<D, 4> { transfer, body, slot, first, nodes, masses });
        }
    }
}

impl<const D: usize, const NODES: usize> Work<f64> for TileInLanes<'_, D, NODES> {
    type Output = ();

    /// The usual cases are compiled separately, without a test at each node.
    #[inline(always)]
    fn run<R: Registers<f64>>(mut self, registers: R) {
        let transfer = self.transfer.of_body(self.body);
        let flip =
            ParticleToGrid { affine: false, axisymmetric: false, body_force: false, ..transfer };
        match (transfer.given, transfer.affine || transfer.body_force || transfer.axisymmetric) {
            (Given::MassMomentumAndForce, false) => {
                let all = ParticleToGrid { given: Given::MassMomentumAndForce, ..flip };
                self.groups(registers, &all);
            }
            (Given::Momentum, _) if !transfer.affine => {
                let momentum = ParticleToGrid { given: Given::Momentum, ..flip };
                self.groups(registers, &momentum);
            }
            _ => self.groups(registers, &transfer),
        }
    }
}

impl<const D: usize, const NODES: usize> TileInLanes<'_, D, NODES> {
    #[inline(always)]
    fn groups<R: Registers<f64>>(&mut self, registers: R, transfer: &ParticleToGrid<D>) {
        let (body, zero) = (self.body, registers.splat(0.0));
        let (particles, binning) = (&body.particles, &body.binning);
        let of = Source { body, conditions: body.points.conditions() };
        let mut axes = [[GroupAxis::none(zero); D]; PAIR];
        let mut terms = [GroupTerms::none(zero); PAIR];
        let (mut runs, mut run) = (binning.runs_of(self.slot), 0..0);
        loop {
            let (mut pair, mut n_groups) = ([Group::none(); PAIR], 0);
            while n_groups < PAIR {
                if run.is_empty() {
                    match runs.next() {
                        Some(next) => run = next,
                        None => break,
                    }
                }
                let group = Group::at(&binning.nodes, run.start, run.end);
                run.start += group.len;
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
                let x = components(registers, &particles.position, groups);
                axes[part] = transfer.lattice.group_axes::<R, NODES>(
                    registers,
                    &x,
                    (groups, &binning.bases),
                );
                terms[part] = transfer.group_terms(registers, &of, &x, groups);
                if D == 2 && transfer.axisymmetric {
                    let place =
                        transfer.lattice.group_radii(registers, x[0], (groups, &binning.bases));
                    terms[part].around =
                        hoop_weights::<_, NODES>(&axes[part][0], place, transfer.hoop_curvature);
                }
            }
            let mut first = [0; PAIR];
            for (first, group) in first.iter_mut().zip(&pair) {
                *first = binning.nodes[group.particle()] - self.first;
            }
            self.add::<R>(registers, transfer, (&terms, &axes), (&pair, first));
        }
    }

    /// Adds a pair of groups to the nodes, row by row, one group after the other. In the plane the masses of the first group are
    /// added before and those of the second after all momenta: their rows overlap, and a load that overlaps a recent store waits
    /// for it.
    #[inline(always)]
    fn add<R: Registers<f64>>(
        &mut self,
        registers: R,
        transfer: &ParticleToGrid<D>,
        (terms, axes): PairTerms<'_, R::Vector, D>,
        (pair, first): (&[Group; PAIR], [usize; PAIR]),
    ) {
        let edge = block_edge(D);
        let with_masses = D == 2 && transfer.given != Given::Momentum;
        let mut masses = [[registers.splat(0.0); MOST_NODES]; PAIR];
        if with_masses {
            for part in 0..parts::<R>() {
                masses[part] = mass_sums::<R, NODES, D>(registers, &terms[part], &axes[part]);
            }
            self.add_masses(registers, &masses[0], (first[0], 0));
        }
        for k in 0..nodes_along::<NODES, D>(2) {
            for j in 0..nodes_along::<NODES, D>(1) {
                let start = (k * edge + j) * edge;
                for part in 0..parts::<R>() {
                    if pair[R::N / LANES * part].len == 0 {
                        continue;
                    }
                    let (terms, axes) = (&terms[part], &axes[part]);
                    let sums = transfer.row_sums::<R, NODES>(registers, terms, axes, (j, k));
                    for b in 0..R::N / LANES {
                        let number = R::N / LANES * part + b;
                        if pair[number].len > 0 {
                            let from = first[number] + start;
                            let nodes = &mut self.nodes[from..from + NODES];
                            let masses = &mut self.masses[from..from + NODES];
                            transfer.add_row(registers, (&sums, b), (nodes, masses));
                        }
                    }
                }
            }
        }
        if with_masses && pair[1].len > 0 {
            let block = R::N / LANES - 1;
            self.add_masses(registers, &masses[parts::<R>() - 1], (first[1], block));
        }
    }

    /// Adds the masses of a group in the plane, four nodes at a time.
    #[inline(always)]
    fn add_masses<R: Registers<f64>>(
        &mut self,
        registers: R,
        sums: &[R::Vector; MOST_NODES],
        (first, block): (usize, usize),
    ) {
        for j in 0..NODES {
            let from = first + j * block_edge(D);
            if let Some(four) = self.masses[from..from + LANES].first_chunk_mut() {
                registers.add_four(sums[j], block, four);
            }
        }
    }
}

/// The masses of groups at the nodes of every row, in the plane.
#[inline(always)]
fn mass_sums<R: Registers<f64>, const NODES: usize, const D: usize>(
    registers: R,
    terms: &GroupTerms<R::Vector, D>,
    axes: &[GroupAxis<R::Vector>; D],
) -> [R::Vector; MOST_NODES] {
    let mut rows = [registers.splat(0.0); MOST_NODES];
    for j in 0..NODES {
        let mass = terms.mass * axes[D - 1].value[j];
        let mut masses = [registers.splat(0.0); MOST_NODES];
        for i in 0..NODES {
            masses[i] = mass * axes[0].value[i];
        }
        rows[j] = registers.sum_fours(masses);
    }
    rows
}

/// The terms and axes of a pair of groups, by register.
type PairTerms<'a, V, const D: usize> =
    (&'a [GroupTerms<V, D>; PAIR], &'a [[GroupAxis<V>; D]; PAIR]);

/// Columns of a body.
#[derive(Debug, Clone, Copy)]
struct Source<'a, const D: usize> {
    body: &'a Body<f64, D>,
    conditions: Columns<'a, f64>,
}

/// Sums over groups at a row of nodes, four numbers of a node in a block of lanes: momentum, force, and where there is room, mass.
#[derive(Debug, Clone, Copy)]
struct RowSums<V> {
    numbers: [V; MOST_NODES],
    further: [V; MOST_NODES],
}

/// `x` in the lanes of a mask, zero elsewhere.
#[inline(always)]
fn only<V: Lanes<Number = f64>>(lanes: V::Mask, x: V) -> V {
    V::select(lanes, x, x.splat(0.0))
}

impl<V: Lanes<Number = f64>, const D: usize> GroupTerms<V, D> {
    #[inline(always)]
    fn none(zero: V) -> Self {
        let (vector, matrix) = ([zero; D], [[zero; D]; D]);
        Self {
            mass: zero,
            momentum: vector,
            growth: matrix,
            force: matrix,
            body_force: vector,
            hoop: zero,
            around: [zero; MOST_NODES],
        }
    }
}

impl<const D: usize> ParticleToGrid<D> {
    /// The terms of groups of particles at `x`.
    #[inline(always)]
    fn group_terms<R: Registers<f64>>(
        &self,
        registers: R,
        of: &Source<'_, D>,
        x: &[R::Vector; D],
        groups: &[Group],
    ) -> GroupTerms<R::Vector, D> {
        let (particles, lattice) = (&of.body.particles, &self.lattice);
        let inside = lanes_of(registers, groups);
        let mut terms = GroupTerms::none(registers.splat(0.0));
        terms.mass = only(inside, numbers(registers, &particles.mass, groups));
        let mut velocity = components(registers, &particles.velocity, groups);
        if self.affine {
            let bases = &of.body.binning.bases;
            let lowest = [groups[0], groups[R::N / LANES - 1]].map(|group| group.particle());
            for l in 0..D {
                let corner = of_groups(
                    registers,
                    [
                        f64::from(bases[lowest[0]][l]) * lattice.cell,
                        f64::from(bases[lowest[1]][l]) * lattice.cell,
                    ],
                );
                let arm = corner - (x[l] - registers.splat(lattice.origin[l]));
                for k in 0..D {
                    let matrix = entry(registers, &particles.affine, groups, (k, l));
                    velocity[k] = velocity[k] + matrix * arm;
                    let growth = matrix * terms.mass * registers.splat(lattice.cell);
                    terms.growth[l][k] = only(inside, growth);
                }
            }
        }
        for k in 0..D {
            terms.momentum[k] = only(inside, velocity[k] * terms.mass);
        }
        if self.given == Given::MassMomentumAndForce {
            self.find_forces(registers, of, (x, groups), &mut terms);
        }
        terms
    }

    /// `-V_p sigma_p e_l` over the cell, by the axis `l` of the gradient; gravity and loads; the hoop, which is `-V_p sigma_tt / r`.
    #[inline(always)]
    fn find_forces<R: Registers<f64>>(
        &self,
        registers: R,
        of: &Source<'_, D>,
        (x, groups): (&[R::Vector; D], &[Group]),
        terms: &mut GroupTerms<R::Vector, D>,
    ) {
        let inside = lanes_of(registers, groups);
        let Columns { stress, viscosity, volume, .. } = &of.conditions;
        let viscosity = numbers(registers, viscosity, groups);
        let volume = numbers(registers, volume, groups)
            * numbers(registers, &of.body.particles.reference_volume, groups);
        let factor = volume * registers.splat(-self.lattice.per_cell);
        for l in 0..D {
            for k in 0..=l {
                let mut entry = numbers(registers, stress[ENTRY[k][l]], groups);
                if k == l {
                    entry = entry - viscosity;
                }
                let force = only(inside, entry * factor);
                (terms.force[l][k], terms.force[k][l]) = (force, force);
            }
        }
        if self.body_force {
            for k in 0..D {
                terms.body_force[k] = terms.mass * registers.splat(self.gravity[k]);
            }
            if of.body.is_loaded() {
                let force = components(registers, &of.body.particles.force, groups);
                for k in 0..D {
                    terms.body_force[k] = terms.body_force[k] + only(inside, force[k]);
                }
            }
        }
        if self.axisymmetric {
            let around = numbers(registers, stress[2], groups) - viscosity;
            terms.hoop = registers.splat(0.0) - only(inside, volume * around / x[0]);
        }
    }

    /// The sums over groups at the nodes of row `(j, k)`.
    #[inline(always)]
    fn row_sums<R: Registers<f64>, const NODES: usize>(
        &self,
        registers: R,
        terms: &GroupTerms<R::Vector, D>,
        axes: &[GroupAxis<R::Vector>; D],
        (j, k): (usize, usize),
    ) -> RowSums<R::Vector> {
        let zero = registers.splat(0.0);
        let common = self.group_row(registers, terms, (j, k), group_outer(axes, (j, k)));
        let mut sums = RowSums { numbers: [zero; MOST_NODES], further: [zero; MOST_NODES] };
        for i in 0..NODES {
            let (value, slope) = (axes[0].value[i], axes[0].slope[i]);
            let mut parts = [zero; 2 * LANES];
            for c in 0..D {
                let mut momentum = common.momentum[c];
                if self.affine {
                    momentum = momentum + common.growth[c] * registers.splat(i as f64);
                }
                parts[c] = momentum * value;
                if self.given == Given::MassMomentumAndForce {
                    parts[D + c] = common.along[c] * slope + common.across[c] * value;
                }
            }
            if D == 2 && self.axisymmetric && self.given == Given::MassMomentumAndForce {
                parts[D] = parts[D] + common.hoop * terms.around[i];
            }
            if D != 2 && self.given != Given::Momentum {
                parts[2 * D] = common.mass * value;
            }
            let [a, b, c, d, e, f, g, h] = parts;
            sums.numbers[i] = registers.sum_fours([a, b, c, d]);
            if D > 2 && self.given != Given::Momentum {
                sums.further[i] = registers.sum_fours([e, f, g, h]);
            }
        }
        sums
    }

    /// Adds the sums over a group to a row of nodes.
    #[inline(always)]
    fn add_row<R: Registers<f64>>(
        &self,
        registers: R,
        (sums, block): (&RowSums<R::Vector>, usize),
        (nodes, masses): (&mut [Node<f64, D>], &mut [f64]),
    ) {
        for i in 0..nodes.len() {
            let numbers = nodes[i].numbers_mut();
            if let Some(four) = numbers.first_chunk_mut() {
                registers.add_four(sums.numbers[i], block, four);
            }
            if D == 1 {
                let [momentum, force, mass, _] = registers.four(sums.numbers[i], block);
                numbers[0] += momentum;
                numbers[1] += force;
                masses[i] += mass;
            }
            if D > 2 && self.given != Given::Momentum {
                let [force_y, force_z, mass, _] = registers.four(sums.further[i], block);
                numbers[LANES] += force_y;
                numbers[LANES + 1] += force_z;
                masses[i] += mass;
            }
        }
    }

    #[inline(always)]
    fn group_row<R: Registers<f64>>(
        &self,
        registers: R,
        terms: &GroupTerms<R::Vector, D>,
        (j, k): (usize, usize),
        (n, grad_n): (R::Vector, [R::Vector; D]),
    ) -> GroupRow<R::Vector, D> {
        let zeros = [registers.splat(0.0); D];
        let mut row = GroupRow {
            mass: terms.mass * n,
            momentum: zeros,
            growth: zeros,
            along: zeros,
            across: zeros,
            hoop: terms.hoop * n,
        };
        for c in 0..D {
            let mut momentum = terms.momentum[c];
            if self.affine {
                if D > 1 {
                    let growth = terms.growth[D.min(2) - 1][c];
                    momentum = momentum + growth * registers.splat(j as f64);
                }
                if D > 2 {
                    momentum = momentum + terms.growth[D - 1][c] * registers.splat(k as f64);
                }
                row.growth[c] = terms.growth[0][c] * n;
            }
            row.momentum[c] = momentum * n;
            if self.given == Given::MassMomentumAndForce {
                row.along[c] = terms.force[0][c] * n;
                if D > 1 {
                    row.across[c] = terms.force[D.min(2) - 1][c] * grad_n[D.min(2) - 1];
                }
                if D > 2 {
                    row.across[c] = row.across[c] + terms.force[D - 1][c] * grad_n[D - 1];
                }
                if self.body_force {
                    row.across[c] = row.across[c] + terms.body_force[c] * n;
                }
            }
        }
        row
    }
}

/// Entry `(k, l)` of a column of matrices, in lanes.
#[inline(always)]
fn entry<R: Registers<f64>, const D: usize>(
    registers: R,
    column: &[[[f64; D]; D]],
    groups: &[Group],
    (k, l): (usize, usize),
) -> R::Vector {
    let mut lanes = [0.0; PAIR * LANES];
    for b in 0..R::N / LANES {
        let entries = &column[groups[b].first..groups[b].first + LANES];
        for lane in 0..LANES {
            lanes[LANES * b + lane] = entries[lane][k][l];
        }
    }
    registers.load_at(&lanes, 0)
}
