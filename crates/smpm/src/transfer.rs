//! From particles to nodes and back.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::in_widest_registers;

use crate::binning::Binning;
use crate::body::{Body, Chunk, Condition, Particles};
use crate::config::{Config, Geometry, Transfer};
use crate::grid::{Grid, Node, block_edge, block_len};
use crate::number::Number;
use crate::parallel::for_each_chunk;
use crate::shape::{
    Axis, CubicBSpline, Gimp, Linear, QuadraticBSpline, Shape, ShapeFunction, nodes_along, outer,
};

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// Entry `kl` of a symmetric tensor.
const ENTRY: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Particles whose lowest nodes are found together.
const SHARE: usize = 1024;

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

/// What a pass over the particles does with each of them.
#[derive(Debug)]
pub(crate) struct Sweep<'a, S, const D: usize> {
    pub(crate) grid: &'a Grid<S, D>,
    pub(crate) config: &'a Config<D>,
    pub(crate) carrier: &'a dyn Carrier<S, D>,
    pub(crate) dt: f64,
    /// At the end of the step.
    pub(crate) time: f64,
    pub(crate) pass: Pass,
    /// The field of nodes of the body.
    pub(crate) field: usize,
}

/// What a pass over the particles does. The last one of a step moves them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Takes the velocity from the nodes.
    Motion,
    /// The same, and moves.
    MotionAndMove,
    /// Takes the velocity gradient and brings the stress up to date.
    Stress,
    /// The same, and moves.
    StressAndMove,
    /// All.
    Whole,
}

impl Pass {
    pub(crate) fn takes_motion(self) -> bool {
        matches!(self, Self::Motion | Self::MotionAndMove | Self::Whole)
    }

    pub(crate) fn updates_stress(self) -> bool {
        matches!(self, Self::Stress | Self::StressAndMove | Self::Whole)
    }

    pub(crate) fn moves(self) -> bool {
        matches!(self, Self::MotionAndMove | Self::StressAndMove | Self::Whole)
    }
}

/// The ways between particles and nodes by a shape function.
pub(crate) trait Carrier<S: Number, const D: usize>: std::fmt::Debug + Send + Sync {
    /// Notes the lowest node that each particle of a body sees.
    fn find_bases(&self, places: &Places<D>, body: &mut Body<S, D>);

    /// Particles give mass, momentum `m (v + C (x_i - x_p))` and the force
    ///
    /// $$ f_i = \sum_p m_p N_i b - V_p \sigma_p \nabla N_i $$
    ///
    /// to the nodes (Chen et al. 2019, eq 3-6 with their errata).
    fn give(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>], config: &Config<D>, given: Given);

    /// Particles give the gradient of their mass, `sum_p m_p grad N_i` per cell: at a node it points out of the body.
    fn give_outward(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>]);

    /// Particles take what the sweep asks for from the nodes; velocity gradients go into `gradients`.
    fn take(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut [[[S; 3]; 3]],
        sweep: &Sweep<'_, S, D>,
    );
}

/// The carrier of a shape function.
pub(crate) fn carrier<S: Number, const D: usize>(shape: Shape) -> &'static dyn Carrier<S, D> {
    match shape {
        Shape::Linear => &Linear,
        Shape::Gimp => &Gimp,
        Shape::QuadraticBSpline => &QuadraticBSpline,
        Shape::CubicBSpline => &CubicBSpline,
    }
}

/// What places and nodes have to do with each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Places<const D: usize> {
    pub(crate) origin: [f64; D],
    pub(crate) cell: f64,
    per_cell: f64,
}

impl<const D: usize> Places<D> {
    pub(crate) fn of<S>(grid: &Grid<S, D>) -> Self {
        Self { origin: grid.origin, cell: grid.cell, per_cell: 1.0 / grid.cell }
    }

    /// The shape function of particle `p` along all axes, from the lowest node that it sees.
    #[inline(always)]
    fn find_axes<F: ShapeFunction, S: Number>(
        &self,
        (x, half_lengths): (&[S; D], &[[S; D]]),
        (p, base): (usize, &[i32; D]),
        axes: &mut [Axis<S>; D],
    ) {
        let zero = S::constant(0.0);
        for k in 0..D {
            let half = if F::SIZED { half_lengths[p][k] * self.per_cell } else { zero };
            let place = (x[k] - self.origin[k]) * self.per_cell;
            F::along(place, half, base[k], &mut axes[k]);
        }
    }
}

impl<F: ShapeFunction, S: Number, const D: usize> Carrier<S, D> for F {
    fn find_bases(&self, places: &Places<D>, body: &mut Body<S, D>) {
        let Particles { position, half_length, .. } = &body.particles;
        for_each_chunk(&mut body.binning.bases, SHARE, |chunk, bases| {
            let start = chunk * SHARE;
            in_widest_registers(
                #[inline(always)]
                || {
                    for p in 0..bases.len() {
                        let x = &position[start + p];
                        for k in 0..D {
                            let half =
                                if F::SIZED { half_length[start + p][k].value() } else { 0.0 };
                            let place = (x[k].value() - places.origin[k]) * places.per_cell;
                            bases[p][k] = F::base(place, half * places.per_cell);
                        }
                    }
                },
            );
        });
    }

    fn give(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>], config: &Config<D>, given: Given) {
        let places = Places::of(grid);
        let last_field = grid.field(bodies.len() - 1);
        grid.collect(|slot, corner, blocks| {
            for (field, body) in bodies.iter().enumerate() {
                let block = &mut blocks[field.min(last_field) * block_len(D)..][..block_len(D)];
                let members = body.binning.members(slot);
                let (particles, conditions) = (&body.particles, body.constitution.conditions());
                let bases = &body.binning.bases;
                in_widest_registers(
                    #[inline(always)]
                    || {
                        let mut axes = [Axis::empty(); D];
                        for &p in members {
                            let p = p as usize;
                            let base = &bases[p];
                            let sized = (&particles.position[p], &particles.half_length[..]);
                            places.find_axes::<F, S>(sized, (p, base), &mut axes);
                            let nodes = &mut block[Binning::offset(base, &corner)..];
                            let of = Giver { places, particles, p, base, config };
                            of.give::<F>(&axes, &conditions[p], given, nodes);
                        }
                    },
                );
            }
        });
    }

    fn give_outward(&self, grid: &mut Grid<S, D>, bodies: &[Body<S, D>]) {
        let places = Places::of(grid);
        grid.collect_outward(|slot, corner, blocks| {
            for (field, body) in bodies.iter().enumerate() {
                let Particles { position, half_length, mass, .. } = &body.particles;
                let block = &mut blocks[field * block_len(D)..][..block_len(D)];
                let mut axes = [Axis::empty(); D];
                for &p in body.binning.members(slot) {
                    let p = p as usize;
                    let base = &body.binning.bases[p];
                    places.find_axes::<F, S>((&position[p], half_length), (p, base), &mut axes);
                    let nodes = &mut block[Binning::offset(base, &corner)..];
                    give_outward::<F, S, D>(&axes, mass[p], nodes);
                }
            }
        });
    }

    fn take(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut [[[S; 3]; 3]],
        sweep: &Sweep<'_, S, D>,
    ) {
        let taker = Taker::of(sweep);
        in_widest_registers(
            #[inline(always)]
            || {
                let mut axes = [Axis::empty(); D];
                for p in 0..gradients.len() {
                    taker.take::<F, S>(chunk, p, (&mut axes, &mut gradients[p]), sweep.grid);
                }
            },
        );
    }
}

/// The gradient of a particle's mass.
fn give_outward<F: ShapeFunction, S: Number, const D: usize>(
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
struct Giver<'a, S, const D: usize> {
    places: Places<D>,
    particles: &'a Particles<S, D>,
    p: usize,
    /// The lowest node that it sees.
    base: &'a [i32; D],
    config: &'a Config<D>,
}

impl<S: Number, const D: usize> Giver<'_, S, D> {
    #[inline(always)]
    fn give<F: ShapeFunction>(
        &self,
        axes: &[Axis<S>; D],
        condition: &Condition<S>,
        given: Given,
        nodes: &mut [Node<S, D>],
    ) {
        let Self { places, particles, p, base, config } = *self;
        let edge = block_edge(D);
        let zero = S::constant(0.0);
        // Momentum at the lowest node, and by how much it grows from node to node along each axis.
        let mass = particles.mass[p];
        let mut momentum = particles.velocity[p];
        let mut growth = [[zero; D]; D];
        let affine = config.transfer == Transfer::Apic;
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

/// What is taken, and how.
#[derive(Debug, Clone, Copy)]
struct Taker<const D: usize> {
    places: Places<D>,
    dt: f64,
    pass: Pass,
    field: usize,
    sized: bool,
    axisymmetric: bool,
    affine: bool,
    /// The share of FLIP, and that of PIC.
    shares: (f64, f64),
    /// `1/d` of `D_p = d I` where the shape function has such (B-splines); none where the gradient serves.
    inverse_inertia: Option<f64>,
}

/// Sums over nodes.
#[derive(Debug, Clone, Copy)]
struct Sums<S, const D: usize> {
    velocity: [S; D],
    change: [S; D],
    /// `sum_i v_k dN_i/dx_l`, per cell.
    gradient: [[S; D]; D],
    /// `sum_i v_k n_il N_i`, `n_il` the number of the node along axis `l` from the lowest.
    moment: [[S; D]; D],
}

impl<const D: usize> Taker<D> {
    fn of<S>(sweep: &Sweep<'_, S, D>) -> Self {
        let (grid, config) = (sweep.grid, sweep.config);
        let shares = match config.transfer {
            Transfer::Flip { damping_time } => {
                let share = (-sweep.dt / damping_time).exp();
                (share, 1.0 - share)
            }
            Transfer::Apic => (0.0, 1.0),
        };
        let square = config.cell * config.cell;
        Self {
            places: Places::of(grid),
            dt: sweep.dt,
            pass: sweep.pass,
            field: sweep.field,
            sized: config.shape == Shape::Gimp,
            axisymmetric: config.geometry == Geometry::Axisymmetric,
            affine: config.transfer == Transfer::Apic,
            shares,
            inverse_inertia: match config.shape {
                Shape::QuadraticBSpline => Some(4.0 / square),
                Shape::CubicBSpline => Some(3.0 / square),
                Shape::Linear | Shape::Gimp => None,
            },
        }
    }

    #[inline(always)]
    fn take<F: ShapeFunction, S: Number>(
        &self,
        chunk: &mut Chunk<'_, S, D>,
        p: usize,
        (axes, l): (&mut [Axis<S>; D], &mut [[S; 3]; 3]),
        grid: &Grid<S, D>,
    ) {
        let (base, slot) = (&chunk.base[p], chunk.slot[p] as usize);
        let sized = (&chunk.position[p], &*chunk.half_length);
        self.places.find_axes::<F, S>(sized, (p, base), axes);
        let offset = Binning::offset(base, &grid.corner(slot));
        let sums = self.sums::<F, S>(axes, &grid.block(slot, self.field)[offset..]);
        if self.pass.updates_stress() {
            for k in 0..D {
                for m in 0..D {
                    l[k][m] = sums.gradient[k][m] * self.places.per_cell;
                }
            }
            if self.axisymmetric {
                l[2][2] = sums.velocity[0] / chunk.position[p][0];
            }
            if self.sized {
                for k in 0..D {
                    let length = chunk.half_length[p][k];
                    chunk.stretched[p][k] = length + length * l[k][k] * self.dt;
                }
            }
        }
        if !self.pass.takes_motion() {
            return;
        }
        let (flip, picked) = self.shares;
        let velocity = &mut chunk.velocity[p];
        for k in 0..D {
            let new = sums.velocity[k];
            if flip == 0.0 {
                velocity[k] = new;
            } else if picked == 0.0 {
                velocity[k] = velocity[k] + sums.change[k];
            } else {
                velocity[k] = (velocity[k] + sums.change[k]) * flip + new * picked;
            }
        }
        if self.affine {
            chunk.affine[p] = self.matrix(&sums, base, &chunk.position[p]);
        }
        // Where the stress is still to come from the same place, the particle stays until then.
        for k in 0..D {
            let by = sums.velocity[k] * self.dt;
            if self.pass.moves() {
                chunk.position[p][k] = chunk.position[p][k] + by;
            } else {
                chunk.displacement[p][k] = by;
            }
        }
    }

    /// APIC's matrix `C = sum_i v_i (x_i - x_p)^T N_i D_p^-1` (Jiang et al. 2015, eq 8); for shape functions of the hat
    /// `sum_i v_i grad N_i^T`, to which it comes down there.
    #[inline(always)]
    fn matrix<S: Number>(&self, sums: &Sums<S, D>, base: &[i32; D], x: &[S; D]) -> [[S; D]; D] {
        let cell = self.places.cell;
        let mut matrix = sums.gradient;
        for l in 0..D {
            let arm = -(x[l] - self.places.origin[l]) + f64::from(base[l]) * cell;
            for k in 0..D {
                matrix[k][l] = match self.inverse_inertia {
                    None => sums.gradient[k][l] * self.places.per_cell,
                    Some(inverse) => (sums.velocity[k] * arm + sums.moment[k][l] * cell) * inverse,
                };
            }
        }
        matrix
    }

    #[inline(always)]
    fn sums<F: ShapeFunction, S: Number>(
        &self,
        axes: &[Axis<S>; D],
        nodes: &[Node<S, D>],
    ) -> Sums<S, D> {
        let (zero, edge) = (S::constant(0.0), block_edge(D));
        let mut sums = Sums {
            velocity: [zero; D],
            change: [zero; D],
            gradient: [[zero; D]; D],
            moment: [[zero; D]; D],
        };
        let with_change = self.pass.takes_motion() && self.shares.0 != 0.0;
        let with_matrix = self.pass.takes_motion() && self.affine;
        let with_gradient =
            self.pass.updates_stress() || (with_matrix && self.inverse_inertia.is_none());
        let with_moment = with_matrix && self.inverse_inertia.is_some();
        let (value, along) = (&axes[0].value, &axes[0].slope);
        for k in 0..nodes_along::<F, D>(2) {
            for j in 0..nodes_along::<F, D>(1) {
                let (weight, slope) = outer(axes, (j, k));
                let start = (k * edge + j) * edge;
                let row = &nodes[start..start + F::NODES];
                let (mut velocity, mut change) = ([zero; D], [zero; D]);
                for i in 0..F::NODES {
                    for c in 0..D {
                        velocity[c] = velocity[c] + row[i].motion[c] * value[i];
                    }
                    if with_change {
                        for c in 0..D {
                            change[c] = change[c] + row[i].change[c] * value[i];
                        }
                    }
                }
                for c in 0..D {
                    let here = velocity[c] * weight;
                    sums.velocity[c] = sums.velocity[c] + here;
                    if with_change {
                        sums.change[c] = sums.change[c] + change[c] * weight;
                    }
                    if with_moment {
                        if D > 1 {
                            let l = D.min(2) - 1;
                            sums.moment[c][l] = sums.moment[c][l] + here * j as f64;
                        }
                        if D > 2 {
                            sums.moment[c][D - 1] = sums.moment[c][D - 1] + here * k as f64;
                        }
                    }
                }
                if with_gradient {
                    let mut steep = [zero; D];
                    for i in 0..F::NODES {
                        for c in 0..D {
                            steep[c] = steep[c] + row[i].motion[c] * along[i];
                        }
                    }
                    for c in 0..D {
                        sums.gradient[c][0] = sums.gradient[c][0] + steep[c] * weight;
                        for l in 1..D {
                            sums.gradient[c][l] = sums.gradient[c][l] + velocity[c] * slope[l];
                        }
                    }
                }
                if with_moment {
                    let mut moment = [zero; D];
                    for i in 1..F::NODES {
                        for c in 0..D {
                            moment[c] = moment[c] + row[i].motion[c] * (value[i] * i as f64);
                        }
                    }
                    for c in 0..D {
                        sums.moment[c][0] = sums.moment[c][0] + moment[c] * weight;
                    }
                }
            }
        }
        sums
    }
}
