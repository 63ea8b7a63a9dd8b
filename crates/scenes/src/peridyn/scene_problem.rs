//! Conversion of a crack scene to the inputs of the solver.

use std::ops::Range;

use peridyn_sde::{
    BondList, Bonds, CrackRun, CrackStudy, Dynamics, Error, Loading, Nodes, Notch, PathConfig,
    Program, Simulation, SimulationConfig, Stiffness, Strain, between_nodes,
};
use sde_integrators::Noise;
use serde::Serialize;

use super::points::Cloud;
use super::positive::positive;
use super::scene::{CrackScene, LoadingScene, PrecisionScene, StrainScene};
use super::scene_dynamics::StepScene;
use super::scene_plate::{Plate, Variation, at};
use crate::scene::{NamedFile, Objection};

/// A step (s) at which every body is stable, used only to convert it to units of the stiffest mode.
const PROBE: f64 = 1e-60;

/// All objects that a study borrows.
#[derive(Debug)]
pub struct CrackProblem {
    nodes: Nodes<2>,
    bonds: Bonds,
    strain: Strain,
    strength: Variation,
    stiffness: Variation,
    protected: Vec<usize>,
    notch: Notch,
    loading: Loading<2>,
    simulation: SimulationConfig,
    upper_grip: Vec<usize>,
    path: PathConfig,
    /// Derived values.
    pub resolved: Resolved,
    /// Files that the scene names.
    pub files: Vec<NamedFile>,
}

/// Values derived from a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Resolved {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of bonds, including those cut by the notch.
    pub bonds: usize,
    /// Number of bonds that the notch cuts.
    pub cut_bonds: usize,
    /// Horizon (m).
    pub horizon: f64,
    /// `s0`; for a random field its mean.
    pub critical_stretch: f64,
    /// Time step (s).
    pub dt: f64,
    /// The step in units of the stiffest mode: `dt M lambda`, in inertial dynamics `dt omega`.
    pub z: f64,
    /// `kT` (J).
    pub temperature: f64,
    /// `s0` over the standard deviation of the stretch of a shortest bond by noise; none without noise.
    pub noise_ratio: Option<f64>,
    /// Duration of the run (s).
    pub duration: f64,
    /// Mean strain at the end of the run.
    pub final_strain: f64,
    /// The abscissa at which a crack counts as through (m): one horizon before the far edge.
    pub exit: f64,
    /// Damage from which a node belongs to a crack.
    pub crack_damage: f64,
    /// Length below which a crack is not counted (m).
    pub least_crack_length: f64,
}

/// Motion of a plate.
struct Motion {
    simulation: SimulationConfig,
    z: f64,
    /// `kT` at which the standard deviation of the stretch equals the critical stretch (J).
    of_ratio_one: f64,
}

/// Nodes of the lower and of the upper edge region.
struct Grips {
    lower: Vec<usize>,
    upper: Vec<usize>,
}

impl CrackProblem {
    /// Builds bodies, notch, loading, dynamics and fields of a checked scene with its points.
    ///
    /// # Errors
    /// An [`Objection`] with the key that the solver rejects.
    pub fn new(scene: &CrackScene, cloud: Option<Cloud>) -> Result<Self, Objection> {
        let plate = Plate::new(scene, cloud)?;
        let (strength, stiffness) = (plate.strength(scene)?, plate.stiffness(scene)?);
        let grips = Grips::of(scene, &plate.nodes)?;
        // The choice of these nodes does not depend on the speed.
        let still = grips.loading(scene, &plate.nodes, 0.0).map_err(at("grips"))?;
        let motion = motion(&plate, scene, still, stiffness.stiffness())?;
        let duration = motion.simulation.dt * scene.time.steps as f64;
        let (rate, final_strain) = rate(scene, plate.stretch, duration)?;
        let loading = grips.loading(scene, &plate.nodes, rate).map_err(at("loading"))?;
        let within = within_edges(scene, &plate.nodes, scene.grips.protected);
        let path = PathConfig::of_horizon(plate.horizon);
        let notch = Notch { mouth: scene.notch.mouth, tip: scene.notch.tip };
        let temperature = motion.simulation.dynamics.temperature();
        let resolved = Resolved {
            nodes: plate.nodes.positions().len(),
            bonds: plate.bonds.len(),
            cut_bonds: plate.cut_bonds,
            horizon: plate.horizon,
            critical_stretch: plate.stretch,
            dt: motion.simulation.dt,
            z: motion.z,
            temperature,
            noise_ratio: (temperature > 0.0).then(|| (motion.of_ratio_one / temperature).sqrt()),
            duration,
            final_strain,
            exit: exit(&notch, scene.body.size[0], plate.horizon)?,
            crack_damage: path.damage,
            least_crack_length: path.least_length,
        };
        let Plate { nodes, bonds, strain, cloud, .. } = plate;
        let (simulation, upper_grip) = (motion.simulation, grips.upper);
        Ok(Self {
            nodes,
            bonds,
            strain,
            strength,
            stiffness,
            protected: within.concat(),
            notch,
            loading,
            simulation,
            upper_grip,
            path,
            resolved,
            files: cloud.iter().map(|cloud| cloud.file().clone()).collect(),
        })
    }

    /// The nodes.
    #[must_use]
    pub const fn nodes(&self) -> &Nodes<2> {
        &self.nodes
    }

    /// The study of a scene.
    #[must_use]
    pub fn study(&self, scene: &CrackScene) -> CrackStudy<'_> {
        CrackStudy {
            nodes: &self.nodes,
            bonds: &self.bonds,
            strain: self.strain,
            strength: self.strength.strength(self.resolved.critical_stretch),
            stiffness: self.stiffness.stiffness(),
            no_fail: &self.protected,
            notch: self.notch,
            loading: &self.loading,
            simulation: &self.simulation,
            n_steps: scene.time.steps,
            load: (&self.upper_grip, 1),
            n_windows: scene.output.windows,
            path: self.path,
            border: self.resolved.exit,
            damage_threshold: scene.output.damage_threshold,
        }
    }

    /// Runs a range of the realisations of a scene, or those after `past`.
    ///
    /// As many run at a time as threads run side by side; the results are bitwise independent of that number. `ended`
    /// observes the results so far and may stop the run.
    ///
    /// # Errors
    /// Those of [`CrackStudy::run`] and of `ended`.
    pub fn run<E: From<Error>>(
        &self,
        scene: &CrackScene,
        range: Range<u64>,
        past: Option<CrackRun>,
        mut ended: impl FnMut(&CrackRun) -> Result<(), E>,
    ) -> Result<CrackRun, E> {
        let (study, n, keep) = (self.study(scene), range.end, &scene.output.vtu);
        let precision = scene.ensemble.precision;
        let each = precision.n_lanes() * rayon::current_num_threads() as u64;
        let next = |from: u64| {
            let range = from..n.min(from + each);
            match precision {
                PrecisionScene::F64 => study.run::<f64, 8>(range, keep, &|_| ()),
                PrecisionScene::F32 => study.run::<f32, 16>(range, keep, &|_| ()),
            }
        };
        let mut run = match past {
            Some(past) => past,
            None => next(range.start)?,
        };
        loop {
            ended(&run)?;
            let from = range.start + run.records.len() as u64;
            if from >= n {
                return Ok(run);
            }
            run.append(next(from)?)?;
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
    let mut simulation = SimulationConfig {
        dynamics: scene.dynamics.build(&plate.nodes, &free, temperature, density)?,
        dt: PROBE,
        breaking: scene.time.breaking.into(),
        confinement: scene.time.confinement,
        noise: Noise::new(scene.ensemble.seed),
    };
    let body = probe(plate, stiffness).map_err(at("bonds"))?;
    let probe = Simulation::new(body, still, simulation.clone(), [0])
        .map_err(|error| of_simulation(&error))?;
    let (dt, z) = step(scene, &simulation.dynamics, probe.relative_step())?;
    simulation.dt = dt;
    Ok(Motion { simulation, z, of_ratio_one })
}

/// One realisation of the initial plate.
fn probe(plate: &Plate, stiffness: Stiffness<'_>) -> Result<BondList<f64, 2, 1>, Error> {
    let (nodes, bonds) = (plate.nodes.clone(), plate.bonds.clone());
    let strengths = vec![plate.stretch; bonds.len()];
    let body = BondList::new(nodes, bonds, plate.strain, &strengths)?;
    match stiffness {
        Stiffness::Given { values, value } => {
            body.with_stiffness_factors(&[between_nodes(&plate.bonds, values, value)?])
        }
        Stiffness::Uniform | Stiffness::Field { .. } => Ok(body),
    }
}

/// One horizon before the edge opposite to the mouth of the notch.
fn exit(notch: &Notch, width: f64, horizon: f64) -> Result<f64, Objection> {
    let tip = notch.tip[0];
    let (exit, ahead) = if tip >= notch.mouth[0] {
        (width - horizon, width - horizon - tip)
    } else {
        (horizon, tip - horizon)
    };
    if ahead > 0.0 {
        return Ok(exit);
    }
    let message = format!("the tip of the notch at x = {tip} m leaves no room for a crack");
    let help = format!("a crack counts as through at x = {exit} m, one horizon before the edge");
    Err(Objection::new("notch.tip", message).with_help(help))
}

/// Nodes within a distance of the lower and of the upper edge.
fn within_edges(scene: &CrackScene, nodes: &Nodes<2>, distance: f64) -> [Vec<usize>; 2] {
    let height = scene.body.size[1];
    let within = |inside: &dyn Fn(f64) -> bool| -> Vec<usize> {
        let heights = nodes.positions().iter().map(|x| x[1]).enumerate();
        heights.filter(|&(_, y)| inside(y)).map(|(node, _)| node).collect()
    };
    [within(&|y| y < distance), within(&|y| y > height - distance)]
}

impl Grips {
    fn of(scene: &CrackScene, nodes: &Nodes<2>) -> Result<Self, Objection> {
        let height = scene.grips.height;
        let [lower, upper] = within_edges(scene, nodes, height);
        for (nodes, edge) in [(&lower, "lower"), (&upper, "upper")] {
            if nodes.is_empty() {
                let message = format!("no node lies within {height} m of the {edge} edge");
                return Err(Objection::new("grips.height", message));
            }
        }
        Ok(Self { lower, upper })
    }

    /// Prescribed displacement with a rate of the mean strain (1/s), or of each edge (m/s).
    fn loading(
        &self,
        scene: &CrackScene,
        nodes: &Nodes<2>,
        rate: f64,
    ) -> Result<Loading<2>, Error> {
        let directions = scene.grips.hold.directions();
        let loading = Loading::new(nodes.positions().len());
        match scene.loading {
            LoadingScene::Stretch { .. } => {
                let both = [self.lower.as_slice(), &self.upper].concat();
                let gradient = [[0.0, 0.0], [0.0, 1.0]];
                loading.stretch(nodes, &both, directions, gradient, Program::Linear { rate })
            }
            LoadingScene::Velocity { .. } => loading
                .velocity(&self.lower, directions, [0.0, -rate])?
                .velocity(&self.upper, directions, [0.0, rate]),
        }
    }
}

/// Rate of the loading, and mean strain at the end.
fn rate(scene: &CrackScene, stretch: f64, duration: f64) -> Result<(f64, f64), Objection> {
    match scene.loading {
        LoadingScene::Stretch { strain } => {
            let (key, value) = match strain {
                StrainScene::Value(value) => ("value", value),
                StrainScene::OverCriticalStretch(ratio) => {
                    ("over_critical_stretch", ratio * stretch)
                }
            };
            let path = format!("loading.stretch.strain.{key}");
            positive(&path, "the mean strain", value)?;
            Ok((value / duration, value))
        }
        LoadingScene::Velocity { speed } => {
            positive("loading.velocity.speed", "the speed of the edges", speed)?;
            Ok((speed, 2.0 * speed * duration / scene.body.size[1]))
        }
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
fn step(scene: &CrackScene, dynamics: &Dynamics, of_probe: f64) -> Result<(f64, f64), Objection> {
    let (unit, limit) = match dynamics {
        Dynamics::Overdamped { scheme, .. } => (of_probe / PROBE, scheme.stability_limit()),
        Dynamics::Inertial { .. } => (of_probe.sqrt() / PROBE, 2.0),
    };
    let (key, dt, z) = match scene.time.step {
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
        Error::OutOfRange { name: "theta", .. } => "dynamics.overdamped.scheme.theta",
        Error::OutOfRange { name: "confinement", .. }
        | Error::NotFinite { name: "confinement", .. } => "time.confinement",
        _ => "dynamics",
    };
    Objection::new(path, error.to_string())
}
