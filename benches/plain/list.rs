//! Micro-elastic bonds in a list, three dimensions, velocity Verlet, one thread: unbreakable, no noise, no friction.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use peridyn_sde::{Bonds, Nodes};
use simd_lanes::dispatch;

use crate::bonded::{DENSITY, Start};
use crate::case::{Failure, Run, State};

/// Constant data of a bond to a node with a higher number.
#[derive(Debug, Clone, Copy)]
struct Bond {
    /// Reference length.
    length: f64,
    /// Stiffness over reference length.
    stiffness: f64,
    partner: u32,
}

/// The body over time.
#[derive(Debug)]
pub(crate) struct List {
    rest: Vec<[f64; 3]>,
    /// Positions of the nodes.
    y: Vec<[f64; 3]>,
    v: Vec<[f64; 3]>,
    forces: Vec<[f64; 3]>,
    /// Start of the bonds of each node, plus the end.
    starts: Vec<usize>,
    bonds: Vec<Bond>,
    inverse_mass: f64,
    dt: f64,
}

impl List {
    pub(crate) fn new(nodes: &Nodes<3>, bonds: &Bonds, start: &Start<3>) -> Result<Self, Failure> {
        let rest = nodes.positions().to_vec();
        let (mut starts, mut own) = (vec![0; rest.len() + 1], Vec::new());
        for ((i, j), bond) in bonds.pairs().zip(bonds.all()) {
            starts[i + 1] += 1;
            let (length, stiffness) = (bond.length, bond.stiffness / bond.length);
            own.push(Bond { length, stiffness, partner: u32::try_from(j)? });
        }
        for i in 0..rest.len() {
            starts[i + 1] += starts[i];
        }
        let mut list = Self {
            y: rest.clone(),
            rest,
            v: start.velocities.clone(),
            forces: vec![],
            starts,
            bonds: own,
            inverse_mass: 1.0 / (DENSITY * nodes.volumes()[0]),
            dt: start.dt,
        };
        list.forces.resize(list.rest.len(), [0.0; 3]);
        list.pull();
        Ok(list)
    }

    #[inline(always)]
    fn pull(&mut self) {
        self.forces.fill([0.0; 3]);
        for i in 0..self.y.len() {
            let (y_i, mut sum) = (self.y[i], [0.0; 3]);
            for bond in &self.bonds[self.starts[i]..self.starts[i + 1]] {
                let (mut along, mut square) = ([0.0; 3], 0.0);
                let j = bond.partner as usize;
                for k in 0..3 {
                    along[k] = self.y[j][k] - y_i[k];
                    square += along[k] * along[k];
                }
                let length = square.sqrt();
                let tension = bond.stiffness * (length - bond.length) / length;
                let force = &mut self.forces[j];
                for k in 0..3 {
                    sum[k] += tension * along[k];
                    force[k] -= tension * along[k];
                }
            }
            for k in 0..3 {
                self.forces[i][k] += sum[k];
            }
        }
    }

    #[inline(always)]
    fn verlet(&mut self) -> f64 {
        let half = 0.5 * self.dt * self.inverse_mass;
        for i in 0..self.y.len() {
            for k in 0..3 {
                self.v[i][k] += half * self.forces[i][k];
                self.y[i][k] += self.dt * self.v[i][k];
            }
        }
        self.pull();
        // A NaN anywhere makes the sum NaN.
        let mut probe = 0.0;
        for i in 0..self.y.len() {
            for k in 0..3 {
                self.v[i][k] += half * self.forces[i][k];
                probe += 0.0 * self.v[i][k];
            }
        }
        probe
    }
}

impl Run for List {
    fn step(&mut self) -> Result<(), Failure> {
        let probe = dispatch(
            #[inline(always)]
            || self.verlet(),
        );
        if probe == 0.0 { Ok(()) } else { Err("a velocity is no longer finite".into()) }
    }

    fn state(&self) -> State {
        let along = |k: usize| self.y.iter().zip(&self.rest).map(|(y, x)| y[k] - x[k]).collect();
        vec![
            ("displacement x", along(0)),
            ("displacement y", along(1)),
            ("displacement z", along(2)),
        ]
    }

    fn n_elements(&self) -> usize {
        self.bonds.len()
    }
}
