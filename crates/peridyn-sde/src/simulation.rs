//! A body in time: `L` realisations of it, step by step.

use sde_integrators::{Noise, SimdLevel};

use crate::body::{AtStrength, Body, BrokenBond};
use crate::crossing::Crossing;
use crate::error::{Error, finite, node_number, positive, same_length};
use crate::loading::Loading;
use crate::real::Real;
use crate::repelled::Repelled;
use crate::report::{BrokenAt, StepReport};
use crate::resistance::Resistance;
use crate::scheme::{Dynamics, Scheme, not_negative};
use crate::stiffest::stiffest;
use crate::update::{Kicks, Unknowns};

/// When bonds are looked after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Breaking {
    /// At the ends of steps: what a path did in between is not seen, an error of the order `sqrt(h)` in the rate of breaking.
    AtEnds,
    /// In between as well, by the test of a bridge: see [`Crossing`]. Not with Leimkuhler and Matthews' method, whose steps are
    /// not those of the path, and not for inertial dynamics, whose paths are smooth.
    Bridge,
}

/// What is needed to step a body.
#[derive(Debug, Clone)]
pub struct SimulationConfig {
    /// What moves the nodes.
    pub dynamics: Dynamics,
    /// The step `h` (time).
    pub dt: f64,
    /// When bonds are looked after.
    pub breaking: Breaking,
    /// `epsilon` of the confining energy `epsilon u^2/2` of each free component (force over length), zero for none: it holds
    /// nodes that have lost all bonds, and multiplies the variance of a mode by `lambda/(lambda + epsilon)`.
    pub confinement: f64,
    /// The noise of all.
    pub noise: Noise,
}

/// A body in time, `L` realisations side by side.
#[derive(Debug)]
pub struct Simulation<T: Real, B, const D: usize, const L: usize> {
    pub(crate) body: B,
    pub(crate) loading: Loading<D>,
    pub(crate) config: SimulationConfig,
    pub(crate) resistance: Resistance<T>,
    pub(crate) unknowns: Unknowns<T>,
    pub(crate) kicks: Kicks<L>,
    crossing: Option<Crossing<L>>,
    pub(crate) repulsion: Option<Box<Repelled<T, D, L>>>,
    pub(crate) realisations: [u64; L],
    pub(crate) level: SimdLevel,
    pub(crate) time: f64,
    pub(crate) step: u64,
    /// The largest `z`, or the square of `omega h`.
    relative_step: f64,
}

impl<T: Real, B: Body<T, D, L>, const D: usize, const L: usize> Simulation<T, B, D, L> {
    /// A body at rest at time 0, whose realisations have these numbers.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the step, [`Error::OutOfRange`] for a negative temperature, friction or confinement;
    /// [`Error::Length`] for a loading or a mobility of another body; [`Error::Unstable`] for a step beyond the stable range of
    /// the scheme; [`Error::NoPathBetween`] for a bridge where there can be none.
    pub fn new(
        body: B,
        loading: Loading<D>,
        config: SimulationConfig,
        realisations: [u64; L],
    ) -> Result<Self, Error> {
        let SimulationConfig { ref dynamics, dt, breaking, confinement, noise } = config;
        positive("step", dt)?;
        finite("confinement", confinement)?;
        not_negative("confinement", confinement)?;
        dynamics.check()?;
        same_length("nodes of the loading", loading.n_nodes(), body.nodes().positions().len())?;
        let resistance = Resistance::new(&body, &loading, dynamics)?;
        let crossing = match breaking {
            Breaking::AtEnds => None,
            Breaking::Bridge => {
                let rates = resistance.rates_of_bonds(&body, dynamics)?;
                Some(Crossing::new(noise, realisations, rates))
            }
        };
        let unknowns = Unknowns::new(body.nodes().positions().len() * D * L);
        let kicks = Kicks::new(noise, realisations, resistance.n_motions(D));
        let mut simulation = Self {
            body,
            loading,
            resistance,
            unknowns,
            kicks,
            crossing,
            repulsion: None,
            realisations,
            level: SimdLevel::best(),
            time: 0.0,
            step: 0,
            relative_step: 0.0,
            config,
        };
        simulation.require_stable()?;
        simulation.start()?;
        Ok(simulation)
    }

    /// The stiffest mode of the body against the step.
    fn require_stable(&mut self) -> Result<(), Error> {
        let dt = self.config.dt;
        let (confinement, dynamics) = (self.config.confinement, self.config.dynamics.clone());
        let rate = stiffest(&mut self.body, &self.resistance, &mut self.kicks, confinement)?;
        let (value, limit) = match dynamics {
            Dynamics::Overdamped { scheme, .. } => (dt * rate, scheme.stability_limit()),
            Dynamics::Inertial { .. } => (dt * dt * rate, 4.0),
        };
        self.relative_step = value;
        if value < limit { Ok(()) } else { Err(Error::Unstable { dt, value, limit }) }
    }

    /// What is given at time 0, and the first forces.
    fn start(&mut self) -> Result<(), Error> {
        self.grip();
        self.body.take_broken();
        self.evaluate(AtStrength::Hold)
    }

    /// `z = h M lambda` of the stiffest mode at rest; in inertial dynamics `(h omega)^2`.
    #[must_use]
    pub fn relative_step(&self) -> f64 {
        self.relative_step
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &B {
        &self.body
    }

    /// The time.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Steps taken.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Displacements of a lane (length).
    #[must_use]
    pub fn displacements(&self, lane: usize) -> Vec<[f64; D]> {
        of_lane::<T, D, L>(&self.unknowns.u, lane)
    }

    /// Velocities of a lane (length over time); zero in overdamped dynamics.
    #[must_use]
    pub fn velocities(&self, lane: usize) -> Vec<[f64; D]> {
        of_lane::<T, D, L>(&self.unknowns.v, lane)
    }

    /// Forces of the bonds on the nodes of a lane, of the last evaluation (force): at the start of the last step, in inertial
    /// dynamics at its end.
    #[must_use]
    pub fn forces(&self, lane: usize) -> Vec<[f64; D]> {
        of_lane::<T, D, L>(&self.unknowns.forces, lane)
    }

    /// What the bonds pull some nodes with, in a lane (force): the reaction of a grip is its opposite.
    #[must_use]
    pub fn pull_on(&self, nodes: &[usize], lane: usize) -> [f64; D] {
        let mut sum = [0.0; D];
        for &node in nodes {
            for k in 0..D {
                sum[k] += self.unknowns.forces[(node * D + k) * L + lane].to_f64();
            }
        }
        sum
    }

    /// The energy of the bonds of a lane (energy).
    #[must_use]
    pub fn energy(&self, lane: usize) -> f64 {
        self.body.energy(&self.unknowns.u, lane)
    }

    /// The damage of each node in a lane: the part of its bonds that is lost, each weighed by its stiffness.
    #[must_use]
    pub fn damage(&self, lane: usize) -> Vec<f64> {
        let bonds = self.body.bonds();
        let n = bonds.n_nodes();
        let (mut lost, mut all) = (vec![0.0; n], vec![0.0; n]);
        for (bond, ((i, j), of)) in bonds.pairs().zip(bonds.all()).enumerate() {
            let part = of.stiffness * self.body.lost(bond, lane);
            for node in [i, j] {
                lost[node] += part;
                all[node] += of.stiffness;
            }
        }
        lost.iter().zip(&all).map(|(lost, all)| lost / all).collect()
    }

    /// Puts a lane at given displacements (length); what is gripped stays.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::Node`] for one that is not finite.
    pub fn set_displacements(&mut self, lane: usize, u: &[[f64; D]]) -> Result<(), Error> {
        self.set(lane, "a displacement", u, |unknowns| &mut unknowns.u)?;
        self.evaluate(AtStrength::Hold)
    }

    pub(crate) fn set(
        &mut self,
        lane: usize,
        name: &'static str,
        values: &[[f64; D]],
        column: impl Fn(&mut Unknowns<T>) -> &mut Vec<T>,
    ) -> Result<(), Error> {
        same_length("nodes", values.len(), self.body.nodes().positions().len())?;
        for (node, value) in values.iter().enumerate() {
            for k in 0..D {
                let number = node_number(name, node, value[k])?;
                if !self.loading.gripped()[node][k] {
                    column(&mut self.unknowns)[(node * D + k) * L + lane] = number;
                }
            }
        }
        Ok(())
    }

    /// Cuts bonds in all lanes, as a notch does.
    ///
    /// # Errors
    /// [`Error::Length`] for a number that no bond has.
    pub fn cut(&mut self, bonds: &[usize]) -> Result<(), Error> {
        self.body.cut(bonds)?;
        self.evaluate(AtStrength::Hold)
    }

    /// One step of the length `dt`. After an error the state is not to be used.
    ///
    /// # Errors
    /// [`Error::Lost`] where a displacement is no longer finite, with step, time, node and realisation; those of the body.
    pub fn step(&mut self) -> Result<StepReport, Error> {
        let dt = self.config.dt;
        let keeps_start = self.crossing.is_some() || !self.breaks_in_forces();
        if keeps_start {
            self.unknowns.before.copy_from_slice(&self.unknowns.u);
        }
        match self.config.dynamics {
            Dynamics::Overdamped { scheme: Scheme::Heun, .. } => self.heun_step()?,
            Dynamics::Overdamped { scheme: Scheme::Theta(theta), .. } => self.theta_step(theta)?,
            Dynamics::Overdamped { scheme, .. } => self.euler_step(scheme)?,
            Dynamics::Inertial { .. } => self.baoab_step()?,
        }
        if let Some(crossing) = &mut self.crossing {
            crossing.begin(self.step, dt);
        }
        if keeps_start {
            let Unknowns { before, u, .. } = &self.unknowns;
            self.body.advance(before, u, dt, self.crossing.as_mut())?;
        }
        self.step += 1;
        self.time = self.step as f64 * dt;
        Ok(self.report())
    }

    fn breaks_in_forces(&self) -> bool {
        self.body.breaks_in_forces() && self.crossing.is_none()
    }

    /// Forces at the displacements of a finished step.
    pub(crate) fn evaluate(&mut self, at: AtStrength) -> Result<(), Error> {
        let Unknowns { u, forces, .. } = &mut self.unknowns;
        let at = if self.body.breaks_in_forces() && self.crossing.is_none() {
            at
        } else {
            AtStrength::Hold
        };
        self.body.forces(u, forces, at)?;
        self.find_touching()
    }

    fn report(&mut self) -> StepReport {
        let broken = self.body.take_broken();
        let (step, time) = (self.step, self.time);
        let broken = broken.into_iter().map(|BrokenBond { bond, lanes, cause }| BrokenAt {
            bond,
            lanes,
            cause,
            step,
            time,
        });
        StepReport { step, time, broken: broken.collect() }
    }

    /// What a non-finite displacement is told as.
    pub(crate) fn lost(&self) -> Error {
        let u = &self.unknowns.u;
        let at = u.iter().position(|u| !u.is_finite()).unwrap_or(0);
        Error::Lost {
            step: self.step + 1,
            time: (self.step + 1) as f64 * self.config.dt,
            node: at / (D * L),
            realisation: self.realisations[at % L],
            value: u[at].to_f64(),
        }
    }
}

fn of_lane<T: Real, const D: usize, const L: usize>(values: &[T], lane: usize) -> Vec<[f64; D]> {
    let (nodes, _) = values.as_chunks::<L>();
    let (nodes, _) = nodes.as_chunks::<D>();
    nodes.iter().map(|node| node.map(|lanes| lanes[lane].to_f64())).collect()
}
