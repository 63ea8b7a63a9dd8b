//! Particle to grid (P2G), particle by particle: nodal mass, momentum and force.
//!
//! $$ m_i = \sum_p m_p N_i(x_p), \qquad (m v)_i = \sum_p m_p (v_p + C_p (x_i - x_p)) N_i(x_p), \qquad
//!    f_i = \sum_p m_p N_i(x_p) b - V_p \sigma_p \nabla N_i(x_p) $$
//!
//! Chen et al. 2019, eq 3 and 6 with their errata; `C_p` is APIC's matrix, zero with FLIP. For jets and gradients, and for `f64`
//! where a body has fewer particles than a register. Shape functions are plain weights: [`crate::transfer::taylor_weights`].
//!
//! What a particle gives is a product of a number and a shape function, both with derivatives. Values are summed as those of
//! `f64` are; derivatives of an order are polynomials in the derivatives of the shape function, with coefficients that are
//! found once for the particle, of as many directions as a register takes.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use simd_lanes::{Lanes, Registers, SimdLevel, Work};

use crate::grid::node::Node;
use crate::grid::tile_size::block_edge;
use crate::number::CarriedNumber;
use crate::points::body::Body;
use crate::transfer::particle_terms::{ENTRY, Given, ParticleToGrid, Run};
use crate::transfer::shape::{Shape, nodes_along, nodes_spanned};
use crate::transfer::taylor_weights::{
    Derivatives, MOST_TERMS, Shift, TaylorWeights, add, load, registers_of_directions,
};

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// The particles of a body in a tile, and the blocks of this tile.
#[derive(Debug)]
struct JetToGrid<'a, S, const D: usize, const NODES: usize> {
    transfer: ParticleToGrid<D>,
    body: &'a Body<S, D>,
    slot: usize,
    /// The number of the first node.
    first: usize,
    nodes: &'a mut [Node<S, D>],
    masses: &'a mut [S],
}

impl<const D: usize> ParticleToGrid<D> {
    /// Adds the particles of a body in a tile, one by one, to the tile's blocks from node number `first` on.
    pub(crate) fn one_by_one<S: CarriedNumber>(
        self,
        body: &Body<S, D>,
        slot: usize,
        (first, nodes, masses): (usize, &mut [Node<S, D>], &mut [S]),
    ) {
        let transfer = self;
        match self.shape {
            Shape::QuadraticBSpline => {
                JetToGrid::<S, D, 3> { transfer, body, slot, first, nodes, masses }.add_all();
            }
            Shape::CubicBSpline => {
                JetToGrid::<S, D, 4> { transfer, body, slot, first, nodes, masses }.add_all();
            }
        }
    }
}

/// A number with its derivatives in a register of directions.
#[derive(Debug, Clone, Copy)]
struct Part<V> {
    value: f64,
    first: V,
    /// Not used for numbers with first derivatives alone.
    second: V,
}

impl<V: Lanes<Number = f64>> Part<V> {
    #[inline(always)]
    fn load<S: CarriedNumber, R: Registers<f64, Vector = V>>(
        registers: R,
        number: &S,
        at: usize,
    ) -> Self {
        let (first, second) = (load(registers, number, 1, at), load(registers, number, 2, at));
        Self { value: number.value(), first, second }
    }

    #[inline(always)]
    fn minus(self, other: &Self) -> Self {
        Self {
            value: self.value - other.value,
            first: self.first - other.first,
            second: self.second - other.second,
        }
    }

    #[inline(always)]
    fn times(self, other: &Self) -> Self {
        let (a, b) = (self.first.splat(self.value), self.first.splat(other.value));
        let cross = self.first * other.first;
        Self {
            value: self.value * other.value,
            first: a * other.first + self.first * b,
            second: (a * other.second + self.second * b) + (cross + cross),
        }
    }

    #[inline(always)]
    fn scaled(self, factor: f64) -> Self {
        let by = self.first.splat(factor);
        Self { value: self.value * factor, first: self.first * by, second: self.second * by }
    }
}

/// What a particle gives to its nodes, in a register of directions.
#[derive(Debug)]
struct Parts<V, const D: usize> {
    momentum: [Part<V>; D],
    mass: Part<V>,
    /// By the axis of the slope.
    force: [[Part<V>; D]; D],
    body_force: [Part<V>; D],
    /// Of the hoop, along the radius.
    hoop: Part<V>,
    growth: [[Part<V>; D]; D],
}

/// Coefficients of the derivatives of the shape function, by order of the derivatives of the number.
#[derive(Debug, Clone, Copy)]
struct Coefficients<V> {
    first: [V; MOST_TERMS],
    second: [V; MOST_TERMS],
}

impl<V: Lanes<Number = f64>> Coefficients<V> {
    /// None, so that sums begin with the first term.
    #[inline(always)]
    fn none(nothing: V) -> Self {
        Self { first: [nothing; MOST_TERMS], second: [nothing; MOST_TERMS] }
    }

    /// Adds those of a number times derivative `t` of the shape function.
    #[inline(always)]
    fn add<const D: usize>(&mut self, (number, t): (&Part<V>, usize), shift: &Shift<V, D>) {
        let next = &Derivatives::<D>::NEXT;
        let (value, first) = (number.first.splat(number.value), number.first);
        self.first[t] = self.first[t] + first;
        for l in 0..D {
            let by = &mut self.first[next[t][l]];
            *by = *by + value * shift.first[l];
        }
        self.second[t] = self.second[t] + number.second;
        let twice = first + first;
        for l in 0..D {
            let by = &mut self.second[next[t][l]];
            *by = *by + (value * shift.second[l] + twice * shift.first[l]);
            let along = value * shift.first[l];
            let square = &mut self.second[next[next[t][l]][l]];
            *square = *square + along * shift.first[l];
            for m in 0..l {
                let mixed = &mut self.second[next[next[t][l]][m]];
                *mixed = *mixed + (along + along) * shift.first[m];
            }
        }
    }
}

impl<S: CarriedNumber, const D: usize, const NODES: usize> JetToGrid<'_, S, D, NODES> {
    /// Adds what the particles give; wide registers hold derivatives alone.
    fn add_all(self) {
        if const { S::ORDER > 0 } {
            SimdLevel::best().run(self);
        } else {
            SimdLevel::PORTABLE.run_narrow(self);
        }
    }

    #[inline(always)]
    fn with_force(&self) -> bool {
        self.transfer.given == Given::MassMomentumAndForce
    }

    /// The terms of a particle: those that are products of a few numbers in registers, the others from arithmetic of jets.
    #[inline(always)]
    fn find_parts<R: Registers<f64>>(
        &self,
        registers: R,
        (of, p): (&Run<'_, S, D>, usize),
        at: usize,
    ) -> Parts<R::Vector, D> {
        let mass = Part::load(registers, &of.mass[p], at);
        let none = [mass; D];
        let (mut momentum, mut force) = (none, [none; D]);
        let (mut body_force, mut growth, mut hoop) = (none, [none; D], mass);
        if self.transfer.affine {
            let terms = self.transfer.affine_momentum(of, p);
            for c in 0..D {
                momentum[c] = Part::load(registers, &terms.lowest[c], at);
                for l in 0..D {
                    growth[l][c] = Part::load(registers, &terms.growth[l][c], at);
                }
            }
        } else {
            for c in 0..D {
                momentum[c] = Part::load(registers, &of.velocity[p][c], at).times(&mass);
            }
        }
        if self.with_force() {
            let viscosity = Part::load(registers, &of.conditions.viscosity[p], at);
            let factor = Part::load(registers, &of.conditions.volume[p], at)
                .scaled(of.reference_volume[p])
                .scaled(-self.transfer.lattice.per_cell);
            for l in 0..D {
                for c in 0..D {
                    let mut stress =
                        Part::load(registers, &of.conditions.stress[ENTRY[c][l]][p], at);
                    if c == l {
                        stress = stress.minus(&viscosity);
                    }
                    force[l][c] = stress.times(&factor);
                }
            }
            if self.transfer.body_force {
                for c in 0..D {
                    body_force[c] = mass.scaled(self.transfer.gravity[c]);
                    if let Some(force) = of.force.get(p) {
                        body_force[c].value += force[c];
                    }
                }
            }
            if self.transfer.axisymmetric {
                hoop = Part::load(registers, &ParticleToGrid::hoop_force(of, p), at);
            }
        }
        Parts { momentum, mass, force, body_force, hoop, growth }
    }

    /// Values of momentum and force at every node, in the order of operations of `f64`.
    #[inline(always)]
    fn add_values<V>(
        &mut self,
        parts: &Parts<V, D>,
        (weights, around): (&TaylorWeights<NODES, D>, &TaylorWeights<NODES, D>),
        node: usize,
    ) {
        let (edge, with_force) = (block_edge(D), self.with_force());
        let ParticleToGrid { affine, body_force, axisymmetric, given, .. } = self.transfer;
        for k in 0..nodes_along::<NODES, D>(2) {
            for j in 0..nodes_along::<NODES, D>(1) {
                let outer = &weights.outer[k * NODES + j];
                let start = node + (k * edge + j) * edge;
                let row = &mut self.nodes[start..start + NODES];
                for c in 0..D {
                    let mut momentum = parts.momentum[c].value;
                    let mut growth = 0.0;
                    if affine {
                        for l in 1..D {
                            momentum += parts.growth[l][c].value * [0.0, j as f64, k as f64][l];
                        }
                        growth = parts.growth[0][c].value * outer[0];
                    }
                    momentum *= outer[0];
                    let (mut along, mut across) = (0.0, 0.0);
                    if with_force {
                        along = parts.force[0][c].value * outer[0];
                        for l in 1..D {
                            across += parts.force[l][c].value * outer[l];
                        }
                        if body_force {
                            across += parts.body_force[c].value * outer[0];
                        }
                    }
                    for i in 0..NODES {
                        let (value, slope) = (weights.along[0][i], weights.along[1][i]);
                        let momentum = if affine { momentum + growth * i as f64 } else { momentum };
                        *row[i].momentum_mut()[c].value_mut() += momentum * value;
                        if with_force {
                            *row[i].force_mut()[c].value_mut() += along * slope + across * value;
                        }
                    }
                }
                if with_force && axisymmetric {
                    let hoop = parts.hoop.value * outer[0];
                    for i in 0..NODES {
                        *row[i].force_mut()[0].value_mut() += hoop * around.along[0][i];
                    }
                }
                if given != Given::Momentum {
                    let mass = parts.mass.value * outer[0];
                    let row = &mut self.masses[start..start + NODES];
                    for i in 0..NODES {
                        *row[i].value_mut() += mass * weights.along[0][i];
                    }
                }
            }
        }
    }

    /// Derivatives of momentum and force at every node.
    #[inline(always)]
    fn add_derivatives<R: Registers<f64>>(
        &mut self,
        registers: R,
        (parts, weights): (&Parts<R::Vector, D>, &TaylorWeights<NODES, D>),
        shift: &Shift<R::Vector, D>,
        (node, at): (usize, usize),
    ) {
        let none = Coefficients::none(registers.splat(-0.0));
        let with_force = self.with_force();
        let nodes = &mut self.nodes[node..node + nodes_spanned::<NODES, D>()];
        for c in 0..D {
            let mut momentum = none;
            momentum.add::<D>((&parts.momentum[c], 0), shift);
            spread(
                registers,
                (&momentum, None),
                weights,
                (0, at),
                nodes,
                #[inline(always)]
                |node| &mut node.momentum_mut()[c],
            );
            if self.transfer.affine {
                for l in 0..D {
                    let mut growth = none;
                    growth.add::<D>((&parts.growth[l][c], 0), shift);
                    spread(
                        registers,
                        (&growth, Some(l)),
                        weights,
                        (0, at),
                        nodes,
                        #[inline(always)]
                        |node| &mut node.momentum_mut()[c],
                    );
                }
            }
            if with_force {
                let mut force = none;
                for l in 0..D {
                    let slope = Derivatives::<D>::NEXT[0][l];
                    force.add::<D>((&parts.force[l][c], slope), shift);
                }
                if self.transfer.body_force {
                    force.add::<D>((&parts.body_force[c], 0), shift);
                }
                spread(
                    registers,
                    (&force, None),
                    weights,
                    (1, at),
                    nodes,
                    #[inline(always)]
                    |node| &mut node.force_mut()[c],
                );
            }
        }
    }

    /// Derivatives of the hoop's force at every node.
    #[inline(always)]
    fn add_derivatives_of_hoop<R: Registers<f64>>(
        &mut self,
        registers: R,
        (of, around): (&Part<R::Vector>, &TaylorWeights<NODES, D>),
        shift: &Shift<R::Vector, D>,
        (node, at): (usize, usize),
    ) {
        let nodes = &mut self.nodes[node..node + nodes_spanned::<NODES, D>()];
        let mut hoop = Coefficients::none(registers.splat(-0.0));
        hoop.add::<D>((of, 0), shift);
        spread(
            registers,
            (&hoop, None),
            around,
            (0, at),
            nodes,
            #[inline(always)]
            |node| &mut node.force_mut()[0],
        );
    }

    /// Derivatives of the mass at every node.
    #[inline(always)]
    fn add_derivatives_of_mass<R: Registers<f64>>(
        &mut self,
        registers: R,
        (of, weights): (&Part<R::Vector>, &TaylorWeights<NODES, D>),
        shift: &Shift<R::Vector, D>,
        (node, at): (usize, usize),
    ) {
        let masses = &mut self.masses[node..node + nodes_spanned::<NODES, D>()];
        let mut mass = Coefficients::none(registers.splat(-0.0));
        mass.add::<D>((of, 0), shift);
        spread(
            registers,
            (&mass, None),
            weights,
            (0, at),
            masses,
            #[inline(always)]
            |mass| mass,
        );
    }
}

/// Adds the derivatives of a number times the shape function, or times slopes of it (`slopes` is then 1), to `entry` of every
/// node.
#[inline(always)]
fn spread<R: Registers<f64>, S: CarriedNumber, T, const NODES: usize, const D: usize>(
    registers: R,
    (of, times): (&Coefficients<R::Vector>, Option<usize>),
    weights: &TaylorWeights<NODES, D>,
    (slopes, at): (usize, usize),
    nodes: &mut [T],
    entry: impl Fn(&mut T) -> &mut S,
) {
    weights.spread(
        (&of.first, times),
        1 + slopes,
        #[inline(always)]
        |i, part| add(registers, part, (entry(&mut nodes[i]), 1), at),
    );
    if S::ORDER > 0 {
        weights.spread(
            (&of.second, times),
            2 + slopes,
            #[inline(always)]
            |i, part| add(registers, part, (entry(&mut nodes[i]), 2), at),
        );
    }
}

impl<S: CarriedNumber, const D: usize, const NODES: usize> Work<f64>
    for JetToGrid<'_, S, D, NODES>
{
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(mut self, registers: R) {
        let mut weights = TaylorWeights::none();
        self.transfer = self.transfer.of_body(self.body);
        let (body, lattice) = (self.body, self.transfer.lattice);
        let ParticleToGrid { axisymmetric, hoop_curvature, .. } = self.transfer;
        let mut around = TaylorWeights::none();
        let conditions = body.points.conditions();
        for run in body.binning.runs_of(self.slot) {
            let of = Run::of(body, &conditions, run);
            for p in 0..of.position.len() {
                weights.find(&lattice, &of.position[p], &of.base[p]);
                if axisymmetric {
                    around = weights.with_curvature(hoop_curvature);
                }
                let node = of.node[p] - self.first;
                for at in registers_of_directions::<S, R>() {
                    let parts = self.find_parts(registers, (&of, p), at);
                    if at == 0 {
                        self.add_values(&parts, (&weights, &around), node);
                    }
                    if S::ORDER == 0 {
                        continue;
                    }
                    let shift = Shift::load(registers, &of.position[p], lattice.per_cell, at);
                    let to = (node, at);
                    self.add_derivatives(registers, (&parts, &weights), &shift, to);
                    if axisymmetric && self.with_force() {
                        let of = (&parts.hoop, &around);
                        self.add_derivatives_of_hoop(registers, of, &shift, to);
                    }
                    if self.transfer.given != Given::Momentum {
                        let of = (&parts.mass, &weights);
                        self.add_derivatives_of_mass(registers, of, &shift, to);
                    }
                }
            }
        }
    }
}
