//! A simulation as a value: checked once, stepped, observed.

use std::io::{Read, Write};

use crate::config::{Config, Geometry, Transfer};
use crate::error::Error;
use crate::grid::background::{Grid, Solve};
use crate::grid::boundary::{Plane, Side};
use crate::grid::surfaces::sum_surfaces;
use crate::grid::tile_size::MOST_NODES;
use crate::number::{CarriedNumber, is_plain};
use crate::parallel::in_pool;
use crate::points::body::Body;
use crate::points::particle_pass::ParticlePass;
use crate::points::particles::Particles;
use crate::points::summary::{Summary, signal_speed};
use crate::record::external::External;
use crate::record::snapshot::{Clock, read, write};
use crate::transfer::particle_motion::Pass;
use crate::transfer::particle_terms::Given;
use crate::transfer::transfers::particle_to_grid;

/// A node lighter than this part of the lightest particle does not move.
const SMALLEST_MASS: f64 = 1e-12;

/// Bodies on a background grid (Sulsky, Chen & Schreyer 1994; Chen et al. 2019, section 2), in `D` dimensions, with numbers
/// `S`: `f64`, or a jet, with which every particle and every node carries the derivatives of its history.
///
/// The length of a step depends on values alone, so a run with jets takes the steps of the run with `f64` that it
/// differentiates.
#[derive(Debug)]
pub struct Simulation<S, const D: usize> {
    config: Config<D>,
    bodies: Vec<Body<S, D>>,
    grid: Grid<S, D>,
    time: f64,
    n_steps: u64,
    smallest_mass: f64,
    /// Of the present state.
    limit: Limit,
    /// A buffer of the sort.
    done: Vec<bool>,
    /// Energy at the start, and what gravity, loads and a rigid body have put in since.
    supplied: f64,
    external: External<D>,
    /// Of all bodies.
    mass: f64,
    failed: Option<Error>,
}

/// One step, in numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct StepReport {
    /// Number of this step, from 1.
    pub step: u64,
    /// Time after the step.
    pub time: f64,
    /// The step taken.
    pub dt: f64,
    /// Tiles of the grid that exist.
    pub n_tiles: usize,
}

/// What a simulation holds in all.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Ledger<const D: usize> {
    /// Mass.
    pub mass: f64,
    /// Momentum.
    pub momentum: [f64; D],
    /// Kinetic energy of the particles.
    pub kinetic: f64,
    /// Internal energy of the materials: zero of a material that observes none.
    pub internal: f64,
    /// Mass of the particles that have failed: damage 1.
    pub failed: f64,
}

impl<const D: usize> Ledger<D> {
    const fn none() -> Self {
        Self { mass: 0.0, momentum: [0.0; D], kinetic: 0.0, internal: 0.0, failed: 0.0 }
    }

    /// Of several bodies.
    fn sum(of: impl IntoIterator<Item = Self>) -> Self {
        of.into_iter().fold(Self::none(), |sum, one| Self {
            mass: sum.mass + one.mass,
            momentum: std::array::from_fn(|k| sum.momentum[k] + one.momentum[k]),
            kinetic: sum.kinetic + one.kinetic,
            internal: sum.internal + one.internal,
            failed: sum.failed + one.failed,
        })
    }
}

/// The longest step and who asks for it.
#[derive(Debug, Clone, Copy)]
struct Limit {
    dt: f64,
    body: usize,
    particle: usize,
}

impl<S: CarriedNumber, const D: usize> Simulation<S, D> {
    /// Checks everything once.
    ///
    /// # Errors
    /// A parameter outside its range, by name; [`Error::NoBody`]; [`Error::NotOnGrid`], [`Error::BoundariesContradict`],
    /// [`Error::AxisIsNoBoundary`], [`Error::BoundariesTooClose`]; [`Error::RigidAlone`], [`Error::RigidLoaded`];
    /// [`Error::BeyondBoundary`] for a particle that starts there.
    pub fn new(config: Config<D>, bodies: Vec<Body<S, D>>) -> Result<Self, Error> {
        config.check()?;
        let config = config.with_axis()?;
        if bodies.is_empty() {
            return Err(Error::NoBody);
        }
        let planes: Vec<Plane> = config
            .boundaries
            .iter()
            .map(|boundary| boundary.plane(D, &config.origin, config.cell))
            .collect::<Result<_, _>>()?;
        check_agreement(&config, &planes)?;
        check_room(&planes)?;
        let mut bodies = bodies;
        for (number, body) in bodies.iter_mut().enumerate() {
            check_places(&config, number, body)?;
            if config.geometry == Geometry::Axisymmetric {
                let Particles { position, mass, reference_volume, .. } = &mut body.particles;
                for ((x, mass), volume) in position.iter().zip(mass).zip(reference_volume) {
                    *mass = *mass * x[0].value();
                    *volume *= x[0].value();
                }
                body.make_loads_axisymmetric();
            }
            body.particles.prepare(&config);
        }
        let masses = bodies.iter().flat_map(|body| body.masses().iter().map(|m| m.value()));
        let smallest_mass = SMALLEST_MASS * masses.fold(f64::INFINITY, f64::min);
        let n_planes = planes.len();
        let grid = Grid::new(&config, planes, &bodies)?;
        let rigid = grid.rigid().map(|(body, _)| body);
        let limit = Limit::of(&config, &bodies);
        let mut simulation = Self {
            config,
            bodies,
            grid,
            limit,
            done: vec![],
            time: 0.0,
            n_steps: 0,
            smallest_mass,
            supplied: 0.0,
            external: External::none(n_planes, [0.0; D]),
            mass: 0.0,
            failed: None,
        };
        let ledgers = simulation.ledgers();
        simulation.supplied = ledgers.iter().map(|it| it.kinetic + it.internal).sum();
        let others = Ledger::sum(
            ledgers.into_iter().enumerate().filter(|it| rigid != Some(it.0)).map(|it| it.1),
        );
        simulation.mass = others.mass;
        simulation.external = External::none(n_planes, others.momentum);
        Ok(simulation)
    }

    /// Time of the state.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Steps taken.
    #[must_use]
    pub fn n_steps(&self) -> u64 {
        self.n_steps
    }

    /// The bodies.
    #[must_use]
    pub fn bodies(&self) -> &[Body<S, D>] {
        &self.bodies
    }

    /// What it was made with.
    #[must_use]
    pub fn config(&self) -> &Config<D> {
        &self.config
    }

    /// The longest step that the Courant number allows in the present state (time).
    #[must_use]
    pub fn longest_step(&self) -> f64 {
        self.limit.dt
    }

    /// What gravity, loads, the planes and a rigid body have given to the others since the start.
    pub const fn external(&self) -> &External<D> {
        &self.external
    }

    /// What it holds besides its particles.
    pub(crate) fn clock(&self) -> Clock {
        let Limit { dt, body, particle } = self.limit;
        let Self { time, n_steps, supplied, .. } = *self;
        let mut sums = vec![];
        self.external.clone().visit_numbers(&mut |number| sums.push(*number));
        Clock { time, n_steps, supplied, limit: (dt, body, particle), sums }
    }

    /// Brings it to another state, with the particles of that state.
    pub(crate) fn set_clock(&mut self, clock: Clock) {
        let Clock { time, n_steps, supplied, limit: (dt, body, particle), sums } = clock;
        self.limit = Limit { dt, body, particle };
        (self.time, self.n_steps, self.supplied) = (time, n_steps, supplied);
        let mut sums = sums.iter();
        self.external.visit_numbers(&mut |number| number.clone_from(sums.next().unwrap_or(&0.0)));
        self.failed = None;
    }

    /// One step of the length that the Courant number allows.
    ///
    /// # Errors
    /// See [`Self::step_of`].
    pub fn step(&mut self) -> Result<StepReport, Error> {
        self.step_of(self.limit.dt)
    }

    /// Steps until `time`; the last one is cut so that it lands there.
    ///
    /// # Errors
    /// See [`Self::step_of`].
    pub fn advance_to(&mut self, time: f64) -> Result<(), Error> {
        while self.time < time {
            let (dt, last) = self.step_towards(time);
            let _ = self.step_of(dt)?;
            if last {
                self.time = time;
            }
        }
        Ok(())
    }

    /// The next step on the way to a later time, and whether it lands there. No sliver: the last two steps are equal.
    pub(crate) fn step_towards(&self, time: f64) -> (f64, bool) {
        let (limit, rest) = (self.limit.dt, time - self.time);
        if rest <= limit {
            (rest, true)
        } else if rest < 2.0 * limit {
            (0.5 * rest, false)
        } else {
            (limit, false)
        }
    }

    /// One step of a given length.
    ///
    /// # Errors
    /// [`Error::Courant`] where a wave or a particle would cross a cell, [`Error::Material`] where a material leaves its
    /// range or a volume turns over, [`Error::EnergyGrew`], [`Error::GridTooLarge`], [`Error::WorkLimit`]. After an error
    /// the state is not that of any time: every further step returns the same error.
    pub fn step_of(&mut self, dt: f64) -> Result<StepReport, Error> {
        if let Some(error) = &self.failed {
            return Err(error.clone());
        }
        #[cfg(not(test))]
        let outcome =
            if const { D <= 3 } { compiled_step(self, dt) } else { self.step_in_pool(dt) };
        // The unit tests run no step.
        #[cfg(test)]
        let outcome = self.step_in_pool(dt);
        if let Err(error) = &outcome {
            self.failed = Some(error.clone());
        }
        outcome
    }

    fn step_in_pool(&mut self, dt: f64) -> Result<StepReport, Error> {
        let n_particles = self.bodies.iter().map(Body::n_particles).sum();
        in_pool(n_particles, || self.try_step(dt))
    }

    /// What [`step_of`](Self::step_of) does while nothing has failed.
    pub(crate) fn try_step(&mut self, dt: f64) -> Result<StepReport, Error> {
        if self.n_steps >= self.config.most_steps {
            let (time, limit) = (self.time, self.config.most_steps);
            return Err(Error::WorkLimit { time, target: self.time + dt, limit });
        }
        let step = self.n_steps + 1;
        let Limit { body, particle, .. } = self.limit;
        // At the Courant number 1.
        let limit = self.limit.dt / self.config.courant_number;
        if !(dt > 0.0 && dt <= limit && dt.is_finite()) {
            return Err(Error::Courant { step, time: self.time, dt, limit, body, particle });
        }
        self.allocate()?;
        let middle = self.time + 0.5 * dt;
        self.bodies.iter_mut().for_each(|body| body.set_forces(middle));
        if self.grid.has_contact() {
            sum_surfaces(&mut self.grid, &self.bodies, &self.config);
        }
        // Modified update stress last (Sulsky, Zhou & Schreyer 1995): the stress follows from nodal velocities by a second
        // particle-to-grid, that of the accelerated particles.
        self.map_to_grid(Given::MassMomentumAndForce, dt);
        let _ = self.map_to_particles(dt, Pass::Velocity)?;
        self.map_to_grid(Given::Momentum, 0.0);
        let summary = self.map_to_particles(dt, Pass::StressAndMove)?;
        self.n_steps = step;
        self.time += dt;
        self.add_loads(dt);
        self.check_energy(dt, &summary)?;
        Ok(StepReport { step, time: self.time, dt, n_tiles: self.grid.n_tiles() })
    }

    /// Bins the particles into tiles, and reorders them where too many have left their neighbours in memory.
    fn allocate(&mut self) -> Result<(), Error> {
        self.bin()?;
        let mut is_sorted = false;
        for body in &mut self.bodies {
            let binning = &mut body.binning;
            if self.n_steps == 0
                || binning.is_disordered()
                || (is_plain::<S>() && binning.cells_are_disordered(self.n_steps))
            {
                body.sort(&mut self.done);
                is_sorted = true;
            }
        }
        if is_sorted { self.bin() } else { Ok(()) }
    }

    fn bin(&mut self) -> Result<(), Error> {
        let lattice = self.grid.lattice;
        for body in &mut self.bodies {
            let bases = &mut body.binning.bases;
            lattice.find_lowest_nodes(self.config.shape, &body.particles.position, bases);
        }
        self.grid.allocate(&mut self.bodies)
    }

    /// Particle-to-grid, and the solution at the nodes.
    fn map_to_grid(&mut self, given: Given, dt: f64) {
        let under = (&self.config, self.config.gravity_at(self.time + 0.5 * dt));
        particle_to_grid(&mut self.grid, &self.bodies, under, given);
        let with_mass = given != Given::Momentum;
        let affine = self.config.transfer == Transfer::Apic;
        let (smallest_mass, damping) = (self.smallest_mass, self.config.damping);
        let solve = Solve { dt, affine, smallest_mass, damping, with_mass };
        self.grid.solve(solve, &mut self.external.reactions);
    }

    /// A pass over all particles: grid-to-particle, the material update, the motion.
    fn map_to_particles(&mut self, dt: f64, pass: Pass) -> Result<Summary<D>, Error> {
        let Self { config, bodies, grid, .. } = self;
        let rigid = grid.rigid().map(|(body, _)| body);
        let (step, time) = (self.n_steps + 1, self.time + dt);
        let pass = ParticlePass::of(grid, config, pass, (dt, time));
        let (mut all, mut fastest) = (Summary::none(), 0.0);
        for (number, body) in bodies.iter_mut().enumerate() {
            let summary = pass.over(body);
            if let Some((particle, fault)) = summary.fault {
                let particle = particle as usize;
                return Err(Error::Material { step, time, body: number, particle, fault });
            }
            if summary.fastest.0 > fastest {
                fastest = summary.fastest.0;
                self.limit = Limit::at(config, summary.fastest, number);
            }
            if rigid != Some(number) {
                for k in 0..D {
                    all.momentum[k] += summary.momentum[k];
                }
            }
            all.kinetic += summary.kinetic;
            all.internal += summary.internal;
        }
        Ok(all)
    }

    /// Mass, momentum and energy of one body.
    fn ledger_of(body: &Body<S, D>) -> Ledger<D> {
        let mut ledger = Ledger::none();
        let Particles { velocity, mass, reference_volume, .. } = &body.particles;
        // In the order of memory.
        for p in 0..body.n_particles() {
            let m = mass[p].value();
            ledger.mass += m;
            for k in 0..D {
                let v = velocity[p][k].value();
                ledger.momentum[k] += m * v;
                ledger.kinetic += 0.5 * m * v * v;
            }
            let observed = body.points.observe(p);
            ledger.internal += observed.energy.value() * reference_volume[p];
            if observed.damage.value() >= 1.0 {
                ledger.failed += m;
            }
        }
        ledger
    }

    /// Mass, momentum and energy of each body.
    #[must_use]
    pub fn ledgers(&self) -> Vec<Ledger<D>> {
        self.bodies.iter().map(Self::ledger_of).collect()
    }

    /// Mass, momentum and energy of all bodies.
    pub fn ledger(&self) -> Ledger<D> {
        Ledger::sum(self.ledgers())
    }

    /// Counts what the loads have given in a step.
    fn add_loads(&mut self, dt: f64) {
        for body in self.bodies.iter().filter(|body| body.is_loaded()) {
            let (force, work) = body.force_and_work();
            self.supplied += work.max(0.0);
            self.external.add_loads(force.map(|along| along * dt), work);
        }
    }

    fn check_energy(&mut self, dt: f64, summary: &Summary<D>) -> Result<(), Error> {
        let Summary { momentum, kinetic, internal, .. } = summary;
        let gravity = self.config.gravity_at(self.time - 0.5 * dt);
        let power: f64 = (0..D).map(|k| momentum[k] * gravity[k]).sum();
        self.supplied += (power * dt).max(0.0);
        let impulse = gravity.map(|along| self.mass * along * dt);
        self.external.add_gravity(self.mass, impulse, momentum);
        if let Some((_, velocity)) = self.grid.rigid() {
            // Radial momentum is not conserved: hoop stress has a radial force.
            let is_conserved = |k: usize| k > 0 || self.config.geometry == Geometry::Cartesian;
            self.supplied += self.external.add_rigid(&velocity, is_conserved).max(0.0);
        }
        let (value, factor) = (kinetic + internal, self.config.most_energy_growth);
        let limit = factor * self.supplied.abs();
        if value.is_nan() || (value > limit && self.supplied != 0.0) {
            let (step, time) = (self.n_steps, self.time);
            return Err(Error::EnergyGrew { step, time, value, limit, factor });
        }
        Ok(())
    }
}

/// One step of a simulation with `f64` or jets in one to three dimensions: it is most of the code of a run, and compiled with this
/// crate, once for all programs.
#[cfg(not(test))]
#[inline(never)]
pub(crate) fn compiled_step(
    simulation: &mut dyn std::any::Any,
    dt: f64,
) -> Result<StepReport, Error> {
    macro_rules! step {
        ($($number:ty, $dimension:literal);+) => {
            $(
                if let Some(simulation) = simulation.downcast_mut::<Simulation<$number, $dimension>>() {
                    return simulation.step_in_pool(dt);
                }
            )+
        };
    }
    step!(f64, 1; f64, 2; f64, 3; crate::Jet, 1; crate::Jet, 2; crate::Jet, 3);
    unreachable!("a step of these numbers is compiled")
}

impl Limit {
    /// Of a speed at which a signal crosses the grid, and the particle that has it.
    fn at<const D: usize>(config: &Config<D>, (speed, particle): (f64, u32), body: usize) -> Self {
        let dt = config.courant_number * config.cell / speed;
        Self { dt, body, particle: particle as usize }
    }

    /// Of a state before the first step.
    fn of<S: CarriedNumber, const D: usize>(config: &Config<D>, bodies: &[Body<S, D>]) -> Self {
        let mut limit = Self { dt: f64::INFINITY, body: 0, particle: 0 };
        for (number, body) in bodies.iter().enumerate() {
            let conditions = body.points.conditions();
            for (p, (v, &particle)) in
                body.particles.velocity.iter().zip(&body.particles.number).enumerate()
            {
                let (wave_speed, rate) = (conditions.wave_speed[p].value(), conditions.rate[p]);
                let speed = signal_speed(v, (wave_speed, rate), config);
                let one = Self::at(config, (speed, particle), number);
                if one.dt < limit.dt {
                    limit = one;
                }
            }
        }
        limit
    }
}

impl<S: CarriedNumber, const D: usize> Simulation<S, D> {
    /// Writes the state, bit for bit: the columns of every body in the order of memory, with the numbers of the particles.
    ///
    /// # Errors
    /// [`Error::MaterialNotStored`], [`Error::Snapshot`]; the error that has ended the run, if one has.
    pub fn snapshot(&self, writer: impl Write) -> Result<(), Error> {
        if let Some(error) = &self.failed {
            return Err(error.clone());
        }
        write(&self.bodies, &self.clock(), writer)
    }

    /// Takes the state from a snapshot of a simulation with the same configuration and bodies; the run goes on bit for bit.
    ///
    /// # Errors
    /// [`Error::ForeignSnapshot`], [`Error::MaterialNotStored`], [`Error::SnapshotNumber`], [`Error::Snapshot`]; the state is then
    /// as it was.
    pub fn restore(&mut self, reader: impl Read) -> Result<(), Error> {
        let n_sums = self.clock().sums.len();
        let clock = read(&mut self.bodies, n_sums, reader)?;
        self.set_clock(clock);
        Ok(())
    }
}

/// A plane does one thing to the bodies of one side.
fn check_agreement<const D: usize>(config: &Config<D>, planes: &[Plane]) -> Result<(), Error> {
    let place = |plane: &Plane| (plane.axis, plane.node, plane.side);
    for (i, one) in planes.iter().enumerate() {
        if planes[..i].iter().any(|other| place(other) == place(one) && other.kind != one.kind) {
            let value = config.boundaries[i].position;
            return Err(Error::BoundariesContradict { axis: one.axis, value });
        }
    }
    Ok(())
}

/// Mirrors that face each other must not see each other's images.
fn check_room(planes: &[Plane]) -> Result<(), Error> {
    let limit = i32::try_from(MOST_NODES).unwrap_or(i32::MAX);
    for above in planes.iter().filter(|plane| plane.side == Side::Above) {
        for below in planes.iter().filter(|plane| plane.side == Side::Below) {
            let cells = below.node - above.node;
            if above.axis == below.axis && cells < limit {
                return Err(Error::BoundariesTooClose { axis: above.axis, cells, limit });
            }
        }
    }
    Ok(())
}

fn check_places<S: CarriedNumber, const D: usize>(
    config: &Config<D>,
    body: usize,
    of: &Body<S, D>,
) -> Result<(), Error> {
    for (particle, place) in of.positions().iter().enumerate() {
        for boundary in &config.boundaries {
            let (axis, limit) = (boundary.axis, boundary.position);
            let value = place[axis].value();
            let inside = match boundary.side {
                Side::Above => value > limit,
                Side::Below => value < limit,
            };
            if !inside {
                return Err(Error::BeyondBoundary { body, particle, axis, value, limit });
            }
        }
        if config.geometry == Geometry::Axisymmetric && place[0].value() <= 0.0 {
            let (axis, value) = (0, place[0].value());
            return Err(Error::BeyondBoundary { body, particle, axis, value, limit: 0.0 });
        }
    }
    Ok(())
}
