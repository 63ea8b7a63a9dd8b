//! Unbreakable elastic bodies under waves: peridyn-sde and hand-written steps.
//!
//! One body is a block with a list of bonds, the other a plate of a lattice.

use peridyn_sde::{
    Body, BondConfig, Bonds, Breaking, Condition, Dynamics, Horizon, Loading, Nodes, Simulation,
    SimulationConfig,
};
use sde_integrators::Noise;

use crate::case::{Failure, Run, State};

pub(crate) const DENSITY: f64 = 1.0;
const YOUNG_MODULUS: f64 = 1.0;
/// Step, a fraction of the stable one: waves of unit speed cross part of a spacing.
const STEP: f64 = 0.2;
/// Initial speed of the nodes over the wave speed: the order of the strains.
const SPEED: f64 = 1e-3;
/// A critical stretch far above every stretch.
pub(crate) const STRENGTH: f64 = 1.0;

/// Initial motion of the nodes of a lattice of unit spacing, and the step.
#[derive(Debug)]
pub(crate) struct Start<const D: usize> {
    pub(crate) velocities: Vec<[f64; D]>,
    pub(crate) dt: f64,
}

impl<const D: usize> Start<D> {
    pub(crate) fn of(nodes: &Nodes<D>) -> Self {
        let velocity = |x: &[f64; D]| {
            std::array::from_fn(|k| SPEED * (0.3 * x[(k + 1) % D] + 0.2 * x[k]).sin())
        };
        Self { velocities: nodes.positions().iter().map(velocity).collect(), dt: STEP }
    }
}

/// A cube of nodes with its bonds.
pub(crate) fn body<const D: usize>(
    edge: u32,
    condition: Condition,
) -> Result<(Nodes<D>, Bonds), Failure> {
    let nodes = Nodes::lattice(1.0, ([0.0; D], [f64::from(edge); D]), condition, |_| true)?;
    let config = BondConfig::uncorrected(Horizon::of_shells(3, 1.0)?, YOUNG_MODULUS);
    let bonds = Bonds::new(&nodes, &config)?;
    Ok((nodes, bonds))
}

/// The library's step.
struct Ours<const D: usize>(Simulation<f64, D, 1>);

/// The library's run of a body.
pub(crate) fn ours<B: Body<f64, D, 1> + 'static, const D: usize>(
    body: B,
) -> Result<Box<dyn Run>, Failure> {
    let Start { velocities, dt } = Start::of(body.nodes());
    let n_nodes = body.nodes().positions().len();
    let config = SimulationConfig {
        dynamics: Dynamics::Inertial { density: DENSITY, friction: 0.0, temperature: 0.0 },
        dt,
        breaking: Breaking::AtEnds,
        confinement: 0.0,
        noise: Noise::new(1),
    };
    let mut run = Simulation::new(body, Loading::new(n_nodes), config, [0])?;
    run.set_velocities(0, &velocities)?;
    Ok(Box::new(Ours(run)))
}

impl<const D: usize> Run for Ours<D> {
    fn step(&mut self) -> Result<(), Failure> {
        let report = self.0.step()?;
        if report.broken.is_empty() { Ok(()) } else { Err("a bond broke".into()) }
    }

    fn state(&self) -> State {
        let u = self.0.displacements(0);
        let names = ["displacement x", "displacement y", "displacement z"];
        (0..D).map(|k| (names[k], u.iter().map(|u| u[k]).collect())).collect()
    }

    fn n_elements(&self) -> usize {
        self.0.body().bonds().len()
    }
}
