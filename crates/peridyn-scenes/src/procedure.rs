//! How the load of a crack scene is applied: the dynamics with their step, or equilibria.

use peridyn_sde::{
    Body, BondList, Bonds, Dynamics, EquilibriumConfig, Error, Loading, Simulation,
    SimulationConfig, Stiffness, between_nodes,
};
use scene_runs::scene::Objection;
use sde_integrators::Noise;

use super::positive::positive;
use super::scene::CrackScene;
use super::scene_dynamics::{DynamicsScene, StepScene, TimeScene};
use super::scene_plate::{Plate, PlateLaw, at};

/// A step (s) at which every body is stable, used only to convert it to units of the stiffest mode.
const PROBE: f64 = 1e-60;

/// How the load of a scene is applied.
#[derive(Debug)]
pub(super) enum SceneProcedure {
    /// The plate moves in steps of time.
    Dynamic(Motion),
    /// The plate passes from equilibrium to equilibrium.
    QuasiStatic {
        config: EquilibriumConfig,
        /// The seed of the random fields.
        noise: Noise,
    },
}

/// Motion of a plate.
#[derive(Debug)]
pub(super) struct Motion {
    pub(super) simulation: SimulationConfig,
    pub(super) n_steps: u64,
    /// The step in units of the stiffest mode.
    pub(super) z: f64,
    /// `kT` at which the standard deviation of the stretch equals the critical stretch (J).
    pub(super) of_ratio_one: f64,
}

impl Motion {
    /// Length of a run (s).
    pub(super) fn duration(&self) -> f64 {
        self.simulation.dt * self.n_steps as f64
    }
}

impl SceneProcedure {
    /// That of a scene. `still` is its loading without motion.
    pub(super) fn of(
        scene: &CrackScene,
        plate: &Plate,
        still: Loading<2>,
        stiffness: Stiffness<'_>,
    ) -> Result<Self, Objection> {
        if let DynamicsScene::QuasiStatic { batch, tolerance } = scene.dynamics {
            positive("dynamics.quasi_static.tolerance", "the tolerance", tolerance)?;
            if !(0.0..1.0).contains(&batch) {
                let message = format!("the batch of bonds is {batch}");
                return Err(Objection::new("dynamics.quasi_static.batch", message)
                    .with_help("0 for one bond at a time, and less than 1; 0.02 is usual"));
            }
            let config =
                EquilibriumConfig { batch, tolerance, ..EquilibriumConfig::EVENT_BY_EVENT };
            return Ok(Self::QuasiStatic { config, noise: Noise::new(scene.ensemble.seed) });
        }
        motion(plate, scene, still, stiffness).map(Self::Dynamic)
    }

    /// The motion, if there is one.
    pub(super) const fn motion(&self) -> Option<&Motion> {
        match self {
            Self::Dynamic(motion) => Some(motion),
            Self::QuasiStatic { .. } => None,
        }
    }
}

/// The dynamics with the given step.
///
/// The stiffest mode comes from a probe simulation that is not run; random stiffness counts with its mean.
fn motion(
    plate: &Plate,
    scene: &CrackScene,
    still: Loading<2>,
    stiffness: Stiffness<'_>,
) -> Result<Motion, Objection> {
    let free: Vec<bool> = still.prescribed().iter().map(|given| *given == [false; 2]).collect();
    let of_ratio_one = of_ratio_one(&plate.bonds, &still, plate.stretch);
    let temperature = scene.dynamics.joule(of_ratio_one)?;
    let density = scene.material.density;
    let dynamics = scene.dynamics.build(&plate.nodes, &free, temperature, density)?;
    // The check of the scene comes first.
    let (Some(time), Some(dynamics)) = (&scene.time, dynamics) else {
        return Err(Objection::new("dynamics", "dynamics in time need the key `time`"));
    };
    let mut simulation = SimulationConfig {
        dynamics,
        dt: PROBE,
        breaking: time.breaking.into(),
        confinement: time.confinement,
        noise: Noise::new(scene.ensemble.seed),
    };
    let body = probe(plate, stiffness).map_err(at("bonds"))?;
    let probe = Simulation::of_any(body, still, simulation.clone(), [0])
        .map_err(|error| of_simulation(&error))?;
    let (dt, z) = step(time, &simulation.dynamics, probe.relative_step())?;
    simulation.dt = dt;
    Ok(Motion { simulation, n_steps: time.steps, z, of_ratio_one })
}

/// One realisation of the initial plate.
fn probe(plate: &Plate, stiffness: Stiffness<'_>) -> Result<Box<dyn Body<f64, 2, 1>>, Error> {
    let (nodes, bonds) = (plate.nodes.clone(), plate.bonds.clone());
    let strengths = vec![plate.stretch; bonds.len()];
    if let PlateLaw::LinearSolid(solid) = &plate.law {
        let body = BondList::of_solid(nodes, solid.clone(), plate.strain, &strengths)?;
        return Ok(Box::new(body));
    }
    let body = BondList::new(nodes, bonds, plate.strain, &strengths)?;
    match stiffness {
        Stiffness::Given { values, value } => {
            let factors = between_nodes(&plate.bonds, values, value)?;
            Ok(Box::new(body.with_stiffness_factors(&[factors])?))
        }
        Stiffness::Uniform | Stiffness::Field { .. } => Ok(Box::new(body)),
    }
}

/// `kT` at which the standard deviation of the stretch of a shortest bond by noise equals the critical stretch (J).
///
/// All bonds together have `kT` for each free component. A bond of stiffness `kappa` and length `l` has the energy
/// `kappa l s^2/2`. For `n` bonds as stiff as a shortest one, the variance of the stretch is then
/// `kT dof/(n kappa l)`. The value is nominal: the deviation of a shortest bond is 1.2 times as large in the interior,
/// and 1.5 times at an edge.
fn of_ratio_one(bonds: &Bonds, loading: &Loading<2>, stretch: f64) -> f64 {
    let dof = loading.prescribed().iter().flatten().filter(|&&gripped| !gripped).count();
    let shortest = bonds.all().iter().min_by(|a, b| a.length.total_cmp(&b.length));
    let stiffness = shortest.map_or(0.0, |bond| bond.stiffness * bond.length);
    stretch * stretch * bonds.len() as f64 * stiffness / dof.max(1) as f64
}

/// The step and `z`, from their ratio in the probe.
fn step(time: &TimeScene, dynamics: &Dynamics, of_probe: f64) -> Result<(f64, f64), Objection> {
    let (unit, limit) = match dynamics {
        Dynamics::Overdamped { scheme, .. } => (of_probe / PROBE, scheme.stability_limit()),
        Dynamics::Inertial { .. } => (of_probe.sqrt() / PROBE, 2.0),
    };
    let (key, dt, z) = match time.step {
        StepScene::Z(z) => ("z", z / unit, z),
        StepScene::Dt(dt) => ("dt", dt, dt * unit),
    };
    let path = format!("time.step.{key}");
    positive(&path, "the step", dt)?;
    if z >= limit {
        let message = format!("the step is {z} in units of the stiffest mode of the body");
        let largest = limit / unit;
        let help = format!("it must be less than {limit}, which is a dt of {largest:.3e} s");
        return Err(Objection::new(path, message).with_help(help));
    }
    Ok((dt, z))
}

/// The objection for a solver error in dynamics, loading or bond failure.
fn of_simulation(error: &Error) -> Objection {
    let path = match error {
        Error::NoPathBetween => "time.breaking",
        Error::MobilityOfPrescribed { .. } => "grips.hold",
        Error::Parameter { name: "theta", .. } => "dynamics.overdamped.scheme.theta",
        Error::Parameter { name: "confinement", .. } => "time.confinement",
        _ => "dynamics",
    };
    Objection::new(path, error.to_string())
}
