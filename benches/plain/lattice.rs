//! A hand-written step of the micro-elastic bonds of a rectangular lattice.
//!
//! Two dimensions, velocity Verlet, one thread: unbreakable bonds, no noise, no friction.
//!
//! Bonds of one vector are computed side by side, each once.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::collections::BTreeMap;

use peridyn_sde::{Bonds, Nodes};
use simd_lanes::dispatch;

use crate::bonded::{DENSITY, Start};
use crate::case::{Failure, Run, State};

/// A bond vector, `across` rows up or along the row.
#[derive(Debug, Clone, Copy)]
struct Vector {
    along: isize,
    across: usize,
    xi: [f64; 2],
    length: f64,
    /// Stiffness over length.
    stiffness: f64,
}

/// The body over time: numbers by component, row by row.
#[derive(Debug)]
pub(crate) struct Lattice {
    edge: usize,
    u: [Vec<f64>; 2],
    v: [Vec<f64>; 2],
    forces: [Vec<f64>; 2],
    vectors: Vec<Vector>,
    n_bonds: usize,
    inverse_mass: f64,
    dt: f64,
}

impl Lattice {
    /// A body of nodes in row order, `edge` per row.
    pub(crate) fn new(
        (nodes, edge): (&Nodes<2>, usize),
        bonds: &Bonds,
        start: &Start<2>,
    ) -> Result<Self, Failure> {
        let mut vectors = BTreeMap::new();
        let x = nodes.positions();
        for ((i, j), bond) in bonds.pairs().zip(bonds.all()) {
            let along = isize::try_from(j % edge)? - isize::try_from(i % edge)?;
            let across = j / edge - i / edge;
            let xi = [x[j][0] - x[i][0], x[j][1] - x[i][1]];
            let (length, stiffness) = (bond.length, bond.stiffness / bond.length);
            let vector = Vector { along, across, xi, length, stiffness };
            vectors.entry((across, along)).or_insert(vector);
        }
        let none = || [0, 1].map(|_| vec![0.0; x.len()]);
        let mut lattice = Self {
            edge,
            u: none(),
            v: [0, 1].map(|k| start.velocities.iter().map(|v| v[k]).collect()),
            forces: none(),
            vectors: vectors.into_values().collect(),
            n_bonds: bonds.len(),
            inverse_mass: 1.0 / (DENSITY * nodes.volumes()[0]),
            dt: start.dt,
        };
        lattice.pull();
        Ok(lattice)
    }

    #[inline(always)]
    fn pull(&mut self) {
        let Self { edge, u, forces: [fx, fy], vectors, .. } = self;
        let edge = *edge;
        fx.fill(0.0);
        fy.fill(0.0);
        for row in 0..edge {
            for vector in &*vectors {
                let other = row + vector.across;
                if other >= edge {
                    continue;
                }
                let first = vector.along.min(0).unsigned_abs();
                let n = edge - vector.along.unsigned_abs();
                let (at, to) =
                    (row * edge + first, other * edge + first.wrapping_add_signed(vector.along));
                let ends =
                    [&u[0][at..at + n], &u[1][at..at + n], &u[0][to..to + n], &u[1][to..to + n]];
                if vector.across == 0 {
                    both_ends(vector, ends, &mut fx[at..to + n], &mut fy[at..to + n]);
                } else {
                    let middle = other * edge;
                    let (fx, fx_up) = fx.split_at_mut(middle);
                    let (fy, fy_up) = fy.split_at_mut(middle);
                    let here = [&mut fx[at..at + n], &mut fy[at..at + n]];
                    let there = [&mut fx_up[to - middle..][..n], &mut fy_up[to - middle..][..n]];
                    apart(vector, ends, here, there);
                }
            }
        }
    }

    #[inline(always)]
    fn verlet(&mut self) -> f64 {
        let half = 0.5 * self.dt * self.inverse_mass;
        for k in 0..2 {
            let (u, v, f) = (&mut self.u[k][..], &mut self.v[k][..], &self.forces[k][..]);
            for ((u, v), f) in u.iter_mut().zip(v).zip(f) {
                *v += half * f;
                *u += self.dt * *v;
            }
        }
        self.pull();
        // A NaN anywhere makes the sum NaN.
        let mut probe = 0.0;
        for k in 0..2 {
            for (v, f) in self.v[k].iter_mut().zip(&self.forces[k]) {
                *v += half * f;
            }
            probe += 0.0 * sum(&self.v[k]);
        }
        probe
    }
}

/// In four parts, each of which fits in a register.
#[inline(always)]
fn sum(values: &[f64]) -> f64 {
    let (fours, rest) = values.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for four in fours {
        for k in 0..4 {
            sums[k] += four[k];
        }
    }
    sums.iter().sum::<f64>() + rest.iter().sum::<f64>()
}

/// Force of a bond with a relative displacement of its ends.
#[inline(always)]
fn force(vector: &Vector, eta: [f64; 2]) -> [f64; 2] {
    let (x, y) = (vector.xi[0] + eta[0], vector.xi[1] + eta[1]);
    let length = (x * x + y * y).sqrt();
    let tension = vector.stiffness * (length - vector.length) / length;
    [tension * x, tension * y]
}

/// Forces of bonds between two rows.
#[inline(always)]
fn apart(
    vector: &Vector,
    [ux, uy, wx, wy]: [&[f64]; 4],
    [fx, fy]: [&mut [f64]; 2],
    [gx, gy]: [&mut [f64]; 2],
) {
    let n = ux.len();
    let (uy, wx, wy) = (&uy[..n], &wx[..n], &wy[..n]);
    let (fx, fy, gx, gy) = (&mut fx[..n], &mut fy[..n], &mut gx[..n], &mut gy[..n]);
    for i in 0..n {
        let [x, y] = force(vector, [wx[i] - ux[i], wy[i] - uy[i]]);
        fx[i] += x;
        fy[i] += y;
        gx[i] -= x;
        gy[i] -= y;
    }
}

/// Forces of bonds along a row: first from one end and then from the other, since they share nodes.
#[inline(always)]
fn both_ends(vector: &Vector, [ux, uy, wx, wy]: [&[f64]; 4], fx: &mut [f64], fy: &mut [f64]) {
    let (n, shift) = (ux.len(), fx.len() - ux.len());
    let (uy, wx, wy) = (&uy[..n], &wx[..n], &wy[..n]);
    for (sign, from) in [(1.0, 0), (-1.0, shift)] {
        let (fx, fy) = (&mut fx[from..from + n], &mut fy[from..from + n]);
        for i in 0..n {
            let [x, y] = force(vector, [wx[i] - ux[i], wy[i] - uy[i]]);
            fx[i] += sign * x;
            fy[i] += sign * y;
        }
    }
}

impl Run for Lattice {
    fn step(&mut self) -> Result<(), Failure> {
        let probe = dispatch(
            #[inline(always)]
            || self.verlet(),
        );
        if probe == 0.0 { Ok(()) } else { Err("a velocity is no longer finite".into()) }
    }

    fn state(&self) -> State {
        let [x, y] = &self.u;
        vec![("displacement x", x.clone()), ("displacement y", y.clone())]
    }

    fn n_elements(&self) -> usize {
        self.n_bonds
    }
}
