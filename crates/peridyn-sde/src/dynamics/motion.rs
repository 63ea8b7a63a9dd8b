//! Displacements and velocities of `L` realisations, and what moves them: forces, mobility, noise.

use sde_integrators::SimdLevel;

use crate::bodies::body::{AtStrength, Body};
use crate::breaking::crossing::Crossing;
use crate::breaking::failure::Failures;
use crate::dynamics::config::{Breaking, SimulationConfig};
use crate::dynamics::kicks::{Kicks, Which};
use crate::dynamics::loading::Loading;
use crate::dynamics::report::StepReport;
use crate::dynamics::resistance::Resistance;
use crate::dynamics::scheme::Dynamics;
use crate::dynamics::stiffest::stiffest;
use crate::dynamics::swing::{Evaluation, Swing};
use crate::error::{Error, node_number, same_length};
use crate::real::Real;

/// State of a body in time and all that a scheme reads. The body itself comes as an argument, behind `dyn`: what is here is
/// compiled once for all kinds of bodies, and a virtual call goes through all bonds.
#[derive(Debug)]
pub(crate) struct Motion<T, const D: usize, const L: usize> {
    pub(crate) loading: Loading<D>,
    pub(crate) config: SimulationConfig,
    pub(crate) resistance: Resistance<T>,
    pub(crate) kicks: Kicks<L>,
    pub(crate) level: SimdLevel,
    /// Displacements.
    pub(crate) u: Vec<T>,
    /// Velocities.
    pub(crate) v: Vec<T>,
    /// Forces of the bonds at the last evaluation.
    pub(crate) bond_forces: Vec<T>,
    /// All forces, then `M f`.
    pub(crate) drift: Vec<T>,
    pub(crate) time: f64,
    pub(crate) step: u64,
    /// `u` where the step began; used where bonds are taken over whole steps.
    start: Vec<T>,
    crossing: Option<Crossing<L>>,
    failures: Failures,
    swing: Swing<T>,
    /// The largest stable `z`, in inertial dynamics its square.
    limit: f64,
    realisations: [u64; L],
}

impl<T: Real, const D: usize, const L: usize> Motion<T, D, L> {
    /// At rest at time 0. The configuration is checked.
    pub(crate) fn new(
        body: &mut dyn Body<T, D, L>,
        loading: Loading<D>,
        config: SimulationConfig,
        realisations: [u64; L],
    ) -> Result<Self, Error> {
        let n_nodes = body.nodes().positions().len();
        same_length("nodes of the loading", loading.n_nodes(), n_nodes)?;
        let SimulationConfig { ref dynamics, breaking, noise, .. } = config;
        let resistance = Resistance::new(body, &loading, dynamics)?;
        let crossing = match breaking {
            Breaking::AtEnds => None,
            Breaking::Bridge => {
                let rates = resistance.rates_of_bonds(body, dynamics)?;
                Some(Crossing::new(noise, realisations, rates))
            }
        };
        let limit = match &config.dynamics {
            Dynamics::Overdamped { scheme, .. } => scheme.stability_limit(),
            Dynamics::Inertial { .. } => 4.0,
        };
        let zeros = || vec![T::ZERO; n_nodes * D * L];
        Ok(Self {
            kicks: Kicks::new(noise, realisations, resistance.n_motions(D)),
            loading,
            config,
            resistance,
            level: SimdLevel::best(),
            u: zeros(),
            v: zeros(),
            bond_forces: zeros(),
            drift: zeros(),
            time: 0.0,
            step: 0,
            start: zeros(),
            crossing,
            failures: Failures::default(),
            swing: Swing::default(),
            limit,
            realisations,
        })
    }

    /// `z` of the stiffest mode of the body, in inertial dynamics `(h omega)^2`; an error where that is not stable.
    pub(crate) fn stable_step(&mut self, body: &mut dyn Body<T, D, L>) -> Result<f64, Error> {
        let SimulationConfig { dt, confinement, .. } = self.config;
        let rate = stiffest(body, &self.resistance, &mut self.kicks, confinement)?;
        let (value, limit) = (self.step_power() * rate, self.limit);
        if value < limit { Ok(value) } else { Err(Error::Unstable { dt, value, limit }) }
    }

    /// Cuts bonds in all lanes.
    pub(crate) fn cut(
        &mut self,
        body: &mut dyn Body<T, D, L>,
        bonds: &[usize],
    ) -> Result<(), Error> {
        self.failures.cut(body, bonds)?;
        self.swing.leave_out(u16::MAX);
        self.evaluate_intact(body)
    }

    /// Keeps where a step begins, if that is needed at its end.
    pub(crate) fn begin_step(&mut self, body: &dyn Body<T, D, L>) {
        if !self.breaks_in_forces(body) {
            self.start.copy_from_slice(&self.u);
        }
    }

    /// Takes bonds over a step that is done, and counts it.
    pub(crate) fn end_step(&mut self, body: &mut dyn Body<T, D, L>) -> Result<StepReport, Error> {
        let dt = self.config.dt;
        if let Some(crossing) = &mut self.crossing {
            crossing.begin(self.step, dt);
        }
        if !self.breaks_in_forces(body) {
            let over = (&self.start[..], &self.u[..]);
            self.failures.advance(body, over, dt, self.crossing.as_mut())?;
        }
        self.step += 1;
        self.time = self.step as f64 * dt;
        Ok(self.report())
    }

    fn breaks_in_forces(&self, body: &dyn Body<T, D, L>) -> bool {
        !body.has_memory() && self.crossing.is_none()
    }

    fn report(&mut self) -> StepReport {
        self.swing.leave_out(self.failures.lanes());
        StepReport { step: self.step, time: self.time, broken: self.failures.take() }
    }

    /// Forces at the displacements of a finished step: bonds at their strength break.
    pub(crate) fn evaluate(&mut self, body: &mut dyn Body<T, D, L>) -> Result<(), Error> {
        if self.breaks_in_forces(body) {
            self.failures.forces(body, &self.u, &mut self.bond_forces)?;
        } else {
            self.evaluate_intact(body)?;
        }
        if self.swing.is_due(self.step) { self.watch(body) } else { Ok(()) }
    }

    /// Whether the step has become too long for the body.
    fn watch(&mut self, body: &dyn Body<T, D, L>) -> Result<(), Error> {
        let Resistance::Diagonal { values, .. } = &self.resistance else { return Ok(()) };
        if body.has_memory() || self.limit.is_infinite() {
            return Ok(());
        }
        // Forces are those where a step begins, in inertial dynamics those at its end.
        let to = match &self.config.dynamics {
            Dynamics::Overdamped { .. } => self.time,
            Dynamics::Inertial { .. } => self.time_after(),
        };
        let from = to - self.config.dt;
        let driven = |node: usize, k: usize| {
            self.loading.field(node, to)[k] - self.loading.field(node, from)[k]
        };
        let still = |_: usize, _: usize| 0.0;
        let at = Evaluation {
            step: self.step + 1,
            time: self.time_after(),
            realisations: &self.realisations,
            step_power: self.step_power(),
            dt: self.config.dt,
            limit: self.limit,
            spacing: body.nodes().spacing(),
            driven: if self.loading.is_driven() { &driven } else { &still },
        };
        let evaluated = (&self.u[..], &self.bond_forces[..]);
        self.swing.check::<D, L>(evaluated, values, self.failures.lanes(), &at)
    }

    /// `h`, in inertial dynamics its square.
    fn step_power(&self) -> f64 {
        let dt = self.config.dt;
        match &self.config.dynamics {
            Dynamics::Overdamped { .. } => dt,
            Dynamics::Inertial { .. } => dt * dt,
        }
    }

    /// Forces at displacements at which no bond breaks.
    pub(crate) fn evaluate_intact(&mut self, body: &mut dyn Body<T, D, L>) -> Result<(), Error> {
        body.forces(&self.u, &mut self.bond_forces, AtStrength::Hold)
    }

    /// Draws the kick of this step and returns its amplitude; nothing is drawn at `kT = 0`.
    pub(crate) fn draw(&mut self, kick: &mut Vec<T>) -> Result<f64, Error> {
        let temperature = self.config.dynamics.temperature();
        if temperature > 0.0 {
            self.kicks.kick(&self.resistance, Which::Step(self.step), kick)?;
        }
        Ok((2.0 * temperature * self.config.dt).sqrt())
    }

    /// `M (F + loads - epsilon u)` at a time, into `drift`.
    pub(crate) fn drift_at(&mut self, time: f64) -> Result<(), Error> {
        self.total_forces(time);
        let drift = &mut self.drift;
        match &self.resistance {
            Resistance::Diagonal { values, .. } => {
                self.level.call(
                    #[inline(always)]
                    || {
                        for (drift, &value) in drift.as_chunks_mut::<L>().0.iter_mut().zip(values) {
                            for drift in drift {
                                *drift = *drift * value;
                            }
                        }
                    },
                );
                Ok(())
            }
            coupled @ Resistance::Coupled { .. } => {
                self.kicks.back(coupled, drift)?;
                self.kicks.forth(coupled, drift)
            }
        }
    }

    /// Forces of bonds, loads and confinement, into `drift`.
    pub(crate) fn total_forces(&mut self, time: f64) {
        let epsilon = T::of(self.config.confinement);
        self.drift.clone_from(&self.bond_forces);
        if self.config.confinement > 0.0 {
            for (drift, &u) in self.drift.iter_mut().zip(&self.u) {
                *drift -= epsilon * u;
            }
        }
        let drift = &mut self.drift;
        self.loading.for_each_force(time, |node, force| {
            for k in 0..D {
                for drift in &mut drift[(node * D + k) * L..(node * D + k + 1) * L] {
                    *drift += T::of(force[k]);
                }
            }
        });
    }

    pub(crate) fn time_after(&self) -> f64 {
        (self.step + 1) as f64 * self.config.dt
    }

    /// Imposes prescribed displacements at the end of the step, moves free nodes along, and checks that all is finite.
    pub(crate) fn finish(&mut self) -> Result<(), Error> {
        self.follow();
        let u = &self.u;
        let probe = self.level.call(
            #[inline(always)]
            || u.iter().fold(T::ZERO, |sum, &u| sum + u * T::ZERO),
        );
        if probe.is_finite() { Ok(()) } else { Err(self.lost()) }
    }

    /// Moves free nodes along with the fields of the drives over a step, and imposes prescribed displacements at its end.
    pub(crate) fn follow(&mut self) {
        if !self.loading.is_driven() {
            return;
        }
        let (from, to) = (self.time, self.time_after());
        let nodes = self.u.as_chunks_mut::<L>().0.as_chunks_mut::<D>().0;
        for (node, (u, prescribed)) in nodes.iter_mut().zip(self.loading.prescribed()).enumerate() {
            let (before, after) = (self.loading.field(node, from), self.loading.field(node, to));
            for k in 0..D {
                let (place, change) = (T::of(after[k]), T::of(after[k] - before[k]));
                for u in &mut u[k] {
                    *u = if prescribed[k] { place } else { *u + change };
                }
            }
        }
    }

    /// Imposes the prescribed displacements at the present time.
    pub(crate) fn impose_displacements(&mut self) {
        let nodes = self.u.as_chunks_mut::<L>().0.as_chunks_mut::<D>().0;
        for (node, (u, prescribed)) in nodes.iter_mut().zip(self.loading.prescribed()).enumerate() {
            let place = self.loading.field(node, self.time);
            for k in 0..D {
                if prescribed[k] {
                    u[k] = [T::of(place[k]); L];
                }
            }
        }
    }

    /// The free components of a lane's nodes from a column of displacements or velocities.
    pub(crate) fn set_lane(
        &mut self,
        column: Column,
        lane: usize,
        values: &[[f64; D]],
    ) -> Result<(), Error> {
        same_length("nodes", values.len(), self.loading.n_nodes())?;
        let (name, numbers) = match column {
            Column::Displacements => ("a displacement", &mut self.u),
            Column::Velocities => ("a velocity", &mut self.v),
        };
        for (node, value) in values.iter().enumerate() {
            for k in 0..D {
                let number = node_number(name, node, value[k])?;
                if !self.loading.prescribed()[node][k] {
                    numbers[(node * D + k) * L + lane] = number;
                }
            }
        }
        Ok(())
    }

    /// Error for a non-finite displacement.
    fn lost(&self) -> Error {
        let u = &self.u;
        let at = u.iter().position(|u| !u.is_finite()).unwrap_or(0);
        Error::Lost {
            step: self.step + 1,
            time: self.time_after(),
            node: at / (D * L),
            realisation: self.realisations[at % L],
            value: u[at].to_f64(),
        }
    }
}

/// A column that a user may set.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Column {
    Displacements,
    Velocities,
}

/// A column of one lane.
pub(crate) fn of_lane<T: Real, const D: usize, const L: usize>(
    values: &[T],
    lane: usize,
) -> Vec<[f64; D]> {
    let (nodes, _) = values.as_chunks::<L>();
    let (nodes, _) = nodes.as_chunks::<D>();
    nodes.iter().map(|node| node.map(|lanes| lanes[lane].to_f64())).collect()
}
