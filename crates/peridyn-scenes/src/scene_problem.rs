//! Conversion of a crack scene to the inputs of the solver.

use peridyn_sde::{
    BondOrder, Bonds, CrackStudy, Error, Loading, Nodes, Notch, PathConfig, Precision, Procedure,
    Strain,
};
use scene_runs::scene::{NamedFile, Objection};
use serde::Serialize;

use super::constraints::{Constraints, LoadEnd, rate};
use super::points::Cloud;
use super::procedure::{Motion, SceneProcedure};
use super::scene::{CrackScene, PrecisionScene};
use super::scene_plate::{Plate, PlateLaw, Variation, order};

/// All objects that a study borrows.
#[derive(Debug)]
pub struct CrackProblem {
    nodes: Nodes<2>,
    bonds: Bonds,
    law: PlateLaw,
    order: BondOrder,
    strain: Strain,
    strength: Variation,
    stiffness: Variation,
    notch: Notch,
    held: Constraints,
    loading: Loading<2>,
    procedure: SceneProcedure,
    path: PathConfig,
    /// What the load comes to at the end of a run.
    pub load_end: LoadEnd,
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
    /// How forces are computed: `lattice` along rows of nodes, `list` bond by bond, `network` for bonds that soften. Their results
    /// are the same within roundoff.
    pub forces: &'static str,
    /// Horizon (m).
    pub horizon: f64,
    /// `s0`; for a random field its mean.
    pub critical_stretch: f64,
    /// Time step (s); none under a quasi-static load.
    pub dt: Option<f64>,
    /// The step in units of the stiffest mode: `dt M lambda`, in inertial dynamics `dt omega`.
    pub z: Option<f64>,
    /// `kT` (J).
    pub temperature: f64,
    /// `s0` over the standard deviation of the stretch of a shortest bond by noise; none without noise.
    pub noise_ratio: Option<f64>,
    /// Duration of the run (s); none under a quasi-static load.
    pub duration: Option<f64>,
    /// Mean strain at the end of the run; none where a region is displaced.
    pub final_strain: Option<f64>,
    /// Displacement of the region at the end of the run (m); none where a mean strain is prescribed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_displacement: Option<f64>,
    /// The abscissa at which a crack counts as through (m): one horizon before the far edge.
    pub exit: f64,
    /// Damage from which a node belongs to a crack.
    pub crack_damage: f64,
    /// Length below which a crack is not counted (m).
    pub least_crack_length: f64,
}

impl CrackProblem {
    /// Builds bodies, notch, loading, dynamics and fields of a checked scene with its points.
    ///
    /// # Errors
    /// An [`Objection`] with the key that the solver rejects.
    pub fn new(scene: &CrackScene, cloud: Option<Cloud>) -> Result<Self, Objection> {
        let plate = Plate::new(scene, cloud)?;
        let (strength, stiffness) = (plate.strength(scene)?, plate.stiffness(scene)?);
        let held = Constraints::of(scene, &plate.nodes)?;
        // The choice of these nodes does not depend on the rate.
        let still = held.loading(&plate.nodes, 0.0).map_err(of_loading(scene))?;
        let procedure = SceneProcedure::of(scene, &plate, still, stiffness.stiffness())?;
        let motion = procedure.motion();
        let duration = motion.map(Motion::duration);
        // A quasi-static load grows to its end with a factor of one.
        let (rate, load_end) = rate(scene, plate.stretch, duration.unwrap_or(1.0))?;
        let loading = held.loading(&plate.nodes, rate).map_err(of_loading(scene))?;
        let path = PathConfig::of_horizon(plate.horizon);
        let notch = Notch { mouth: scene.notch.mouth, tip: scene.notch.tip };
        let temperature = motion.map_or(0.0, |it| it.simulation.dynamics.temperature());
        let of_ratio_one = motion.filter(|_| temperature > 0.0).map(|it| it.of_ratio_one);
        let order = order(scene, &plate, temperature, (&strength, &stiffness, &held.protected));
        let resolved = Resolved {
            nodes: plate.nodes.positions().len(),
            bonds: plate.bonds.len(),
            cut_bonds: plate.cut_bonds,
            forces: match (&plate.law, order) {
                (PlateLaw::Softening(_), _) => "network",
                (_, BondOrder::Lattice) => "lattice",
                (_, BondOrder::List) => "list",
            },
            horizon: plate.horizon,
            critical_stretch: plate.stretch,
            dt: motion.map(|it| it.simulation.dt),
            z: motion.map(|it| it.z),
            temperature,
            noise_ratio: of_ratio_one.map(|of_one| (of_one / temperature).sqrt()),
            duration,
            final_strain: load_end.strain(),
            final_displacement: load_end.displacement(),
            exit: exit(&notch, scene.body.size[0], plate.horizon)?,
            crack_damage: path.damage,
            least_crack_length: path.least_length,
        };
        let Plate { nodes, bonds, law, strain, cloud, .. } = plate;
        Ok(Self {
            nodes,
            bonds,
            law,
            order,
            strain,
            strength,
            stiffness,
            notch,
            held,
            loading,
            procedure,
            path,
            load_end,
            resolved,
            files: cloud.iter().map(|cloud| cloud.file().clone()).collect(),
        })
    }

    /// The nodes.
    #[must_use]
    pub const fn nodes(&self) -> &Nodes<2> {
        &self.nodes
    }

    /// Realisations that run side by side.
    #[must_use]
    pub const fn n_side_by_side(&self, scene: &CrackScene) -> u64 {
        match self.order {
            BondOrder::Lattice => 1,
            BondOrder::List => scene.n_side_by_side(),
        }
    }

    /// The study of a scene.
    #[must_use]
    pub fn study(&self, scene: &CrackScene) -> CrackStudy<'_> {
        CrackStudy {
            nodes: &self.nodes,
            bonds: &self.bonds,
            law: self.law.of_study(),
            order: self.order,
            precision: match scene.ensemble.precision {
                PrecisionScene::F64 => Precision::Double,
                PrecisionScene::F32 => Precision::Single,
            },
            strain: self.strain,
            strength: self.strength.strength(self.resolved.critical_stretch),
            stiffness: self.stiffness.stiffness(),
            no_fail: &self.held.protected,
            notch: self.notch,
            loading: &self.loading,
            procedure: match &self.procedure {
                SceneProcedure::Dynamic(motion) => {
                    let (simulation, n_steps) = (&motion.simulation, motion.n_steps);
                    Procedure::Dynamic { simulation, n_steps }
                }
                SceneProcedure::QuasiStatic { config, noise } => Procedure::QuasiStatic {
                    config: *config,
                    until: 1.0,
                    n_steps: scene.n_steps(),
                    noise: *noise,
                },
            },
            load: (&self.held.load.0, self.held.load.1),
            n_windows: scene.output.windows,
            path: self.path,
            border: self.resolved.exit,
            damage_threshold: scene.output.damage_threshold,
        }
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

/// The objection for a loading that cannot be.
fn of_loading(scene: &CrackScene) -> impl Fn(Error) -> Objection {
    let path = if scene.grips.is_some() { "grips" } else { "supports" };
    move |error| {
        let objection = Objection::new(path, error.to_string());
        match error {
            Error::PrescribedTwice { .. } => objection.with_help(
                "regions of supports and of the load overlap: hold each node once in a direction",
            ),
            _ => objection,
        }
    }
}
