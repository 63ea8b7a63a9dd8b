//! A body at rest under a load: displacements in equilibrium, and what its bonds are there.

use super::config::EquilibriumConfig;
use super::solver::{Solver, Stop, dot, norm};
use super::two_level::TwoLevel;
use crate::bodies::body::Body;
use crate::bodies::surface::direction;
use crate::dynamics::loading::Loading;
use crate::error::{Error, same_length};

/// Linear systems after which a solution is given up: rounding of the residual makes a second one necessary.
const MOST_SYSTEMS: usize = 40;

/// The least reaction that a residual is compared with, over the largest that a load had.
const LEAST_REACTION: f64 = 1e-3;

/// Work of finding one equilibrium.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Solved {
    /// Iterations of conjugate gradients: an evaluation of all forces each.
    pub iterations: usize,
    /// The residual over the reaction.
    pub residual: f64,
}

/// All that an equilibrium needs beside the body.
#[derive(Debug)]
pub(super) struct Statics<const D: usize> {
    pub(super) loading: Loading<D>,
    pub(super) config: EquilibriumConfig,
    /// Displacements, and the forces of the bonds there.
    pub(super) u: Vec<f64>,
    pub(super) bond_forces: Vec<f64>,
    /// The stiffness of each bond (force over length): what is left of it.
    pub(super) weights: Vec<f64>,
    /// `1/(r^2 s)` with the stretch `s` at which a bond next changes; zero for never.
    critical: Vec<f64>,
    free: Vec<bool>,
    preconditioner: TwoLevel<D>,
    stiffest: f64,
    solver: Solver,
    /// Iterations that are a reason to make the coarse matrix anew.
    expected: Option<usize>,
    renewed: bool,
    /// Forces that loads put on nodes.
    outer: Vec<f64>,
    largest_reaction: f64,
}

impl<const D: usize> Statics<D> {
    pub(super) fn new(
        body: &dyn Body<f64, D, 1>,
        loading: Loading<D>,
        config: EquilibriumConfig,
    ) -> Result<Self, Error> {
        config.check()?;
        let (nodes, bonds) = (body.nodes(), body.bonds());
        let n = nodes.positions().len();
        same_length("nodes of the loading", loading.n_nodes(), n)?;
        if !body.is_piecewise_linear() {
            return Err(Error::NotPiecewiseLinear);
        }
        if !loading.is_proportional() {
            return Err(Error::NotProportional);
        }
        let free: Vec<[bool; D]> =
            loading.prescribed().iter().map(|prescribed| prescribed.map(|held| !held)).collect();
        if !free.iter().flatten().any(|&free| free) {
            return Err(Error::NoFreeNode { n_nodes: n });
        }
        let all = bonds.all().iter().enumerate();
        let weights: Vec<f64> =
            all.map(|(bond, of)| of.stiffness * body.secant(bond, 0) / of.length).collect();
        let preconditioner = TwoLevel::new(nodes, bonds, &weights, free.clone())?;
        let mut sums = vec![0.0; n];
        for ((i, j), weight) in bonds.pairs().zip(&weights) {
            sums[i] += 2.0 * weight;
            sums[j] += 2.0 * weight;
        }
        let mut made = Self {
            loading,
            config,
            u: vec![0.0; n * D],
            bond_forces: vec![0.0; n * D],
            critical: vec![0.0; weights.len()],
            weights,
            free: free.into_flattened(),
            preconditioner,
            stiffest: sums.into_iter().fold(0.0, f64::max),
            solver: Solver::default(),
            expected: None,
            renewed: true,
            outer: vec![0.0; n * D],
            largest_reaction: 0.0,
        };
        for bond in 0..made.weights.len() {
            made.critical[bond] = made.critical_of(body, bond);
        }
        Ok(made)
    }

    fn critical_of(&self, body: &dyn Body<f64, D, 1>, bond: usize) -> f64 {
        let trigger = self.trigger(body, bond);
        let length = body.bonds().all()[bond].length;
        if trigger.is_finite() && self.weights[bond] > 0.0 {
            1.0 / (length * length * trigger)
        } else {
            0.0
        }
    }

    /// The stretch at which a bond is next taken past: of a damaged one the tip of its tooth.
    fn trigger(&self, body: &dyn Body<f64, D, 1>, bond: usize) -> f64 {
        let is_damaged = body.bond_damage(bond, 0) > 0.0;
        let above = if is_damaged { 1.0 + self.config.tooth } else { 1.0 };
        above * body.next_stretch(bond, 0)
    }

    /// Prescribes the displacements of a unit load, and takes its forces.
    pub(super) fn impose_unit_load(&mut self) {
        for node in 0..self.loading.n_nodes() {
            let place = self.loading.field(node, 1.0);
            for k in (0..D).filter(|k| !self.free[node * D + k]) {
                self.u[node * D + k] = place[k];
            }
        }
        self.outer.fill(0.0);
        let outer = &mut self.outer;
        self.loading.for_each_force(1.0, |node, force| {
            for k in 0..D {
                outer[node * D + k] += force[k];
            }
        });
    }

    /// Bond forces at the displacements, linear in them by the secant of each bond, into `bond_forces`.
    pub(super) fn evaluate(&mut self, body: &mut dyn Body<f64, D, 1>) -> Result<(), Error> {
        body.secant_forces(&self.u, &mut self.bond_forces)
    }

    /// Work of the bond forces on the displacements, `u^T K u`, and that of the loads.
    pub(super) fn works(&self) -> [f64; 2] {
        [-dot(&self.u, &self.bond_forces), dot(&self.u, &self.outer)]
    }

    /// The residual at the displacements, and the reaction to compare it with.
    fn residual(&mut self, body: &mut dyn Body<f64, D, 1>) -> Result<[f64; 2], Error> {
        self.evaluate(body)?;
        let residual = &mut self.solver.residual;
        residual.clear();
        let mut reaction = 0.0;
        for ((&force, &outer), &free) in self.bond_forces.iter().zip(&self.outer).zip(&self.free) {
            residual.push(if free { force + outer } else { 0.0 });
            reaction += if free { outer * outer } else { force * force };
        }
        let least = LEAST_REACTION * self.largest_reaction;
        Ok([norm(residual), f64::max(reaction.sqrt(), least)])
    }

    /// Finds equilibrium at a unit load from the present displacements, with those that are prescribed in place; none where a part
    /// of the body carries load and is held by nothing. An error names the `load` at which bonds have changed.
    pub(super) fn equilibrate(
        &mut self,
        body: &mut dyn Body<f64, D, 1>,
        load: f64,
    ) -> Result<Option<Solved>, Error> {
        let EquilibriumConfig { tolerance: limit, most_iterations: most, .. } = self.config;
        let (mut iterations, mut n_systems) = (0, 0);
        loop {
            let [left, reaction] = self.residual(body)?;
            let residual = if left > 0.0 { left / reaction } else { 0.0 };
            if residual <= limit {
                self.largest_reaction = self.largest_reaction.max(reaction);
                self.learn(iterations, body)?;
                return Ok(Some(Solved { iterations, residual }));
            }
            if !left.is_finite() || n_systems == MOST_SYSTEMS {
                return Err(Error::NotInEquilibrium { load, residual, iterations, limit });
            }
            match self.correct(body, (0.7 * limit * reaction, most - iterations))? {
                Stop::Solved(used) => (iterations, n_systems) = (iterations + used, n_systems + 1),
                Stop::Singular => return Ok(None),
                Stop::Stalled(left) => {
                    let (residual, iterations) = (left / reaction, most);
                    return Err(Error::NotInEquilibrium { load, residual, iterations, limit });
                }
            }
        }
    }

    /// Moves the displacements by the solution of the linear system of the residual.
    fn correct(
        &mut self,
        body: &mut dyn Body<f64, D, 1>,
        goal: (f64, usize),
    ) -> Result<Stop, Error> {
        let Self { u, free, preconditioner, solver, .. } = self;
        let mut change = vec![0.0; u.len()];
        let stop = solver.solve(
            &mut change,
            goal,
            self.stiffest,
            |residual, image| preconditioner.apply(residual, image),
            |v, image| {
                body.secant_forces(v, image)?;
                for (image, &free) in image.iter_mut().zip(&*free) {
                    *image = if free { -*image } else { 0.0 };
                }
                Ok(())
            },
        )?;
        for (u, change) in u.iter_mut().zip(change) {
            *u += change;
        }
        Ok(stop)
    }

    /// Makes the coarse matrix anew where iterations have grown by half since it was made.
    fn learn(&mut self, iterations: usize, body: &dyn Body<f64, D, 1>) -> Result<(), Error> {
        if self.renewed {
            // Of the first solution from afar nothing is learnt about the next ones, which start near.
            self.expected = (iterations > 0).then_some(iterations);
            self.renewed = false;
        } else if self.expected.is_some_and(|expected| 2 * iterations > 3 * expected + 4) {
            self.preconditioner.renew(body.nodes(), body.bonds(), &self.weights)?;
            self.renewed = true;
        }
        Ok(())
    }

    /// The largest stretch of a bond over that at which it next changes, and which bond; none where no bond is stretched.
    pub(super) fn most_critical(&self, body: &dyn Body<f64, D, 1>) -> Option<(usize, f64)> {
        let mut most: Option<(usize, f64)> = None;
        self.for_each_ratio(body, |bond, ratio| {
            if ratio > most.map_or(0.0, |most| most.1) {
                most = Some((bond, ratio));
            }
        });
        most
    }

    /// Bonds whose stretch is at least so large a part of that at which they next change.
    pub(super) fn critical_from(
        &self,
        body: &dyn Body<f64, D, 1>,
        least: f64,
    ) -> Vec<(usize, f64)> {
        let mut found = Vec::new();
        self.for_each_ratio(body, |bond, ratio| {
            if ratio >= least {
                found.push((bond, ratio));
            }
        });
        found
    }

    fn for_each_ratio(&self, body: &dyn Body<f64, D, 1>, mut each: impl FnMut(usize, f64)) {
        let (x, u, bonds) = (body.nodes().positions(), self.u.as_chunks::<D>().0, body.bonds());
        for i in 0..x.len() {
            for bond in bonds.row(i) {
                let critical = self.critical[bond];
                if critical > 0.0 {
                    let j = bonds.partner(bond);
                    let mut along = 0.0;
                    for k in 0..D {
                        along += (u[j][k] - u[i][k]) * (x[j][k] - x[i][k]);
                    }
                    each(bond, along * critical);
                }
            }
        }
    }

    /// Takes a bond past where it next changes.
    pub(super) fn pass(
        &mut self,
        body: &mut dyn Body<f64, D, 1>,
        bond: usize,
    ) -> Result<(), Error> {
        let stretch = self.trigger(body, bond);
        body.pass(bond, (1.0 + self.config.tooth) * stretch);
        let of = body.bonds().all()[bond];
        let weight = of.stiffness * body.secant(bond, 0) / of.length;
        let change = weight - std::mem::replace(&mut self.weights[bond], weight);
        self.critical[bond] = self.critical_of(body, bond);
        let ends = body.bonds().ends(bond);
        self.preconditioner.change(ends, direction(body.nodes(), ends, of.length), change)
    }
}
