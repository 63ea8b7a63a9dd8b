//! Grid to particle (G2P), particle by particle: velocity and velocity gradient.
//!
//! $$ v_p \leftarrow v_p + \sum_i \Delta v_i N_i(x_p) \;\text{(FLIP)} \quad\text{or}\quad \sum_i v_i N_i(x_p) \;\text{(APIC)},
//!    \qquad L_p = \sum_i v_i \nabla N_i(x_p), \qquad x_p \leftarrow x_p + \Delta t \sum_i v_i N_i(x_p) $$
//!
//! For jets and gradients, and for `f64` where a chunk has fewer particles than a register. Shape functions are plain weights:
//! [`crate::transfer::taylor_weights`].
//!
//! The nodes' numbers are summed with the shape function and its derivatives as plain weights, each order as far as the
//! particle needs it. What it is to have, a velocity or a slope of the velocity, follows once from these sums and from the
//! derivatives of its place.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use simd_lanes::{Lanes, Registers, SimdLevel, Work};

use crate::grid::background::Grid;
use crate::grid::node::Node;
use crate::number::CarriedNumber;
use crate::points::particles::Chunk;
use crate::transfer::particle_motion::{GridToParticle, Pass, Sums};
use crate::transfer::shape::{Shape, nodes_spanned};
use crate::transfer::taylor_weights::{
    Derivatives, MOST_TERMS, Shift, TaylorWeights, load, registers_of_directions, store,
};
use crate::transfer::velocity_gradients::VelocityGradients;

// Loops, not closures: those are not always inlined, and then not compiled for the widest registers.

/// A pass over a chunk of particles.
#[derive(Debug)]
struct GridToJet<'a, 'b, S, const D: usize, const NODES: usize> {
    transfer: GridToParticle<D>,
    grid: &'a Grid<S, D>,
    chunk: &'a mut Chunk<'b, S, D>,
    gradients: &'a mut VelocityGradients<S>,
}

impl<const D: usize> GridToParticle<D> {
    /// What the pass asks of all particles of a chunk, one by one; velocity gradients go into `gradients`.
    pub(crate) fn one_by_one<S: CarriedNumber>(
        self,
        grid: &Grid<S, D>,
        chunk: &mut Chunk<'_, S, D>,
        gradients: &mut VelocityGradients<S>,
    ) {
        let transfer = self;
        match self.shape {
            Shape::QuadraticBSpline => {
                GridToJet::<S, D, 3> { transfer, grid, chunk, gradients }.find_all();
            }
            Shape::CubicBSpline => {
                GridToJet::<S, D, 4> { transfer, grid, chunk, gradients }.find_all();
            }
        }
    }
}

/// Sums `sum_i u_i N_i^(t)` of a component of a vector at the nodes, by derivative `t`.
#[derive(Debug)]
struct Moments<V> {
    value: [f64; MOST_TERMS],
    first: [V; MOST_TERMS],
    second: [V; MOST_TERMS],
}

impl<V: Lanes<Number = f64>> Moments<V> {
    /// `sum_i u_i N_i^(t)` at the place of the particle, with its derivatives.
    #[inline(always)]
    fn write<S: CarriedNumber, R: Registers<f64, Vector = V>, const D: usize>(
        &self,
        registers: R,
        (t, to): (usize, &mut S),
        shift: &Shift<V, D>,
        at: usize,
    ) {
        let next = &Derivatives::<D>::NEXT;
        *to.value_mut() = self.value[t];
        if S::ORDER == 0 {
            return;
        }
        let mut first = self.first[t];
        for l in 0..D {
            first = first + shift.first[l] * registers.splat(self.value[next[t][l]]);
        }
        store(registers, first, (to, 1), at);
        let mut second = self.second[t];
        for l in 0..D {
            let slope = self.first[next[t][l]];
            second = second + shift.first[l] * (slope + slope);
            second = second + shift.second[l] * registers.splat(self.value[next[t][l]]);
            let mut along = shift.first[l] * registers.splat(self.value[next[next[t][l]][l]]);
            for m in 0..l {
                let mixed = self.value[next[next[t][l]][m]];
                along = along + shift.first[m] * registers.splat(mixed + mixed);
            }
            second = second + shift.first[l] * along;
        }
        store(registers, second, (to, 2), at);
    }
}

/// Which component of which vector of a node.
#[derive(Debug, Clone, Copy)]
enum Entry {
    Velocity(usize),
    Change(usize),
}

impl Entry {
    #[inline(always)]
    fn of<S: CarriedNumber, const D: usize>(self, node: &Node<S, D>) -> &S {
        match self {
            Self::Velocity(c) => &node.velocity()[c],
            Self::Change(c) => &node.velocity_change()[c],
        }
    }
}

impl<S: CarriedNumber, const D: usize, const NODES: usize> GridToJet<'_, '_, S, D, NODES> {
    /// What the pass asks of all particles of the chunk; wide registers hold derivatives alone.
    fn find_all(self) {
        if const { S::ORDER > 0 } {
            SimdLevel::best().run(self);
        } else {
            SimdLevel::PORTABLE.run_narrow(self);
        }
    }

    /// Sums of an entry of the nodes for `N_i` itself, and for its derivatives up to the order `highest`.
    #[inline(always)]
    fn moments<R: Registers<f64>>(
        registers: R,
        (nodes, weights): (&[Node<S, D>], &TaylorWeights<NODES, D>),
        (entry, times): (Entry, Option<usize>),
        highest: usize,
        at: usize,
    ) -> Moments<R::Vector> {
        let nothing = registers.splat(-0.0);
        let value = weights.gather(
            (-0.0, times),
            highest + S::ORDER,
            #[inline(always)]
            |i| entry.of(&nodes[i]).value(),
        );
        let (mut first, mut second) = ([nothing; MOST_TERMS], [nothing; MOST_TERMS]);
        if S::ORDER > 0 {
            first = weights.gather(
                (nothing, times),
                highest + S::ORDER - 1,
                #[inline(always)]
                |i| load(registers, entry.of(&nodes[i]), 1, at),
            );
            second = weights.gather(
                (nothing, times),
                highest,
                #[inline(always)]
                |i| load(registers, entry.of(&nodes[i]), 2, at),
            );
        }
        Moments { value, first, second }
    }

    /// The sums over the nodes that a particle sees, `SLOPES` of the velocity among them or not.
    #[inline(always)]
    fn sum<R: Registers<f64>, const SLOPES: bool>(
        &self,
        registers: R,
        (nodes, weights): (&[Node<S, D>], &TaylorWeights<NODES, D>),
        position: &[S; D],
        sums: &mut Sums<S, D>,
    ) {
        let of = (nodes, weights);
        let GridToParticle { axisymmetric, hoop_curvature, .. } = self.transfer;
        let around = (SLOPES && axisymmetric).then(|| weights.with_curvature(hoop_curvature));
        let (with_change, with_moment) =
            (!SLOPES && !self.transfer.affine, !SLOPES && self.transfer.affine);
        for at in registers_of_directions::<S, R>() {
            let shift = Shift::load(registers, position, self.transfer.lattice.per_cell, at);
            if let Some(around) = &around {
                let velocity = (Entry::Velocity(0), None);
                let moments = Self::moments(registers, (nodes, around), velocity, 0, at);
                moments.write(registers, (0, &mut sums.around), &shift, at);
            }
            for c in 0..D {
                let velocity = (Entry::Velocity(c), None);
                let moments = Self::moments(registers, of, velocity, usize::from(SLOPES), at);
                moments.write(registers, (0, &mut sums.velocity[c]), &shift, at);
                if SLOPES {
                    for l in 0..D {
                        let slope = Derivatives::<D>::NEXT[0][l];
                        let to = (slope, &mut sums.gradient[l][c]);
                        moments.write(registers, to, &shift, at);
                    }
                }
                if with_change {
                    let moments = Self::moments(registers, of, (Entry::Change(c), None), 0, at);
                    moments.write(registers, (0, &mut sums.change[c]), &shift, at);
                }
                if with_moment {
                    for l in 0..D {
                        let times = (Entry::Velocity(c), Some(l));
                        let moments = Self::moments(registers, of, times, 0, at);
                        moments.write(registers, (0, &mut sums.moment[c][l]), &shift, at);
                    }
                }
            }
        }
    }
}

impl<S: CarriedNumber, const D: usize, const NODES: usize> Work<f64>
    for GridToJet<'_, '_, S, D, NODES>
{
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let (mut sums, mut weights) = (Sums::none(), TaylorWeights::none());
        let GridToParticle { pass, lattice, .. } = self.transfer;
        for p in 0..self.chunk.len() {
            let (position, base) = (self.chunk.position[p], &self.chunk.base[p]);
            weights.find(&lattice, &position, base);
            let nodes = &self.grid.from(self.chunk.node[p])[..nodes_spanned::<NODES, D>()];
            let of = (nodes, &weights);
            if pass == Pass::StressAndMove {
                self.sum::<R, true>(registers, of, &position, &mut sums);
            } else {
                self.sum::<R, false>(registers, of, &position, &mut sums);
            }
            let transfer = self.transfer;
            let mut gradient = [[S::constant(0.0); 3]; 3];
            transfer.apply(self.chunk, p, &sums, &mut gradient);
            self.gradients.set(p, &gradient);
        }
    }
}
