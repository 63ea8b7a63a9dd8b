//! A density scene as it stands in its JSON file.

use fpk_sph::systems::{LinearOscillator, ViscousDamper};
use fpk_sph::{Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, StepRule};
use sde_integrators::{GaussianComponent, GaussianMixture};
use serde::{Deserialize, Serialize};

use super::density::Demand;
use super::lattice_scene::{LatticeScene, check_counts, scaled_counts};
use super::paths::Paths;
use super::scene_system::{SceneSystem, Visitor};
use super::system_scene::{SystemError, SystemScene, list, square};
use crate::scene::{Objection, Scene};

/// What is modelled, what is asked, and with which method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FpkScene {
    /// Always `fpk-sph`.
    pub solver: String,
    /// One line for the reader.
    pub title: String,
    /// The system.
    pub system: SystemScene,
    /// The law of the state at `t = 0`.
    pub initial: LawScene,
    /// How it is solved.
    pub method: MethodScene,
    /// When it is observed.
    pub times: Times,
    /// Raw moments `E[x_1^a_1 .. x_D^a_D]`, as `[a_1, .., a_D]`.
    pub moments: Vec<Vec<u32>>,
    /// What exceeds the thresholds; the first state where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub demand: Option<DemandScene>,
    /// Thresholds `T` of `P(|y| > T)`, in the unit of the demand `y`.
    pub thresholds: Vec<f64>,
    /// Planes on which the density is drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planes: Option<PlanesScene>,
    /// The particles as files for ParaView.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cloud: Option<CloudScene>,
}

/// What exceeds the thresholds in magnitude.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DemandScene {
    /// A state, by its name.
    State(String),
    /// A weighted sum of the states, e.g. the drift of an upper storey.
    Combination {
        /// Its name.
        name: String,
        /// A weight for each state.
        weights: Vec<f64>,
    },
}

/// Marginal densities of pairs of states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanesScene {
    /// Pairs of states, by their names: across and up.
    pub states: Vec<[String; 2]>,
    /// When; each must be a time of observation (s).
    pub times: Vec<f64>,
}

/// Files of the particles over time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CloudScene {
    /// One file for each so many observations.
    pub every_observations: usize,
}

/// The initial law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LawScene {
    /// Independent Gaussian states.
    Gaussian {
        /// Means of the states.
        mean: Vec<f64>,
        /// Standard deviations of the states.
        standard_deviation: Vec<f64>,
    },
    /// A structure of independent Gaussian states behind a filter in its stationary law.
    StationaryFilter {
        /// Means of the structure's states.
        mean: Vec<f64>,
        /// Standard deviations of the structure's states.
        standard_deviation: Vec<f64>,
    },
    /// A mixture of Gaussians.
    Mixture(Vec<ComponentScene>),
}

/// One Gaussian of a mixture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComponentScene {
    /// Its weight; the weights sum to 1.
    pub weight: f64,
    /// Its mean.
    pub mean: Vec<f64>,
    /// Its covariance, row by row.
    pub covariance: Vec<Vec<f64>>,
}

/// The method, by its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MethodScene {
    /// Whitened log-density fit, Runge-Kutta 4.
    LogDensityFit(LatticeScene),
    /// Flow-map fit over the lattice of the start, Runge-Kutta 4.
    FlowMapFit(LatticeScene),
    /// The paper's method.
    #[serde(rename = "canor_denoel_2013")]
    CanorDenoel2013 {
        /// Particles along each axis.
        count: Vec<usize>,
        /// Half the edges of the lattice, in the units of the state.
        half_width: Vec<f64>,
        /// Courant number.
        courant: f64,
        /// `support_radius / spacing` at the start.
        support_over_spacing: f64,
    },
    /// The rival: sampled paths.
    MonteCarlo {
        /// Number of paths.
        paths: u64,
        /// Longest step (s).
        step: f64,
        /// How a path is stepped.
        integrator: IntegratorScene,
        /// Seed.
        seed: u64,
    },
}

/// How a path is stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum IntegratorScene {
    /// Forward Euler, the paper's.
    EulerMaruyama,
    /// Semi-implicit Euler.
    SemiImplicitEuler,
    /// Strang splitting with exact rotation and damper flow.
    StrangOscillator,
    /// The same for the hysteretic oscillator.
    StrangBoucWen,
    /// Two drifts, strong order 1.5, for any system with additive noise.
    Shark,
}

/// Equal intervals of observation, from `every` to `until`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Times {
    /// The last time (s).
    pub until: f64,
    /// The interval (s).
    pub every: f64,
}

/// One of the two oscillators of section 4.1 of the paper, checked.
#[derive(Debug, Clone, PartialEq)]
pub enum System {
    /// The linear oscillator.
    Linear(LinearOscillator),
    /// The viscous damper.
    Damper(ViscousDamper),
}

/// Most output times of a scene: beyond it a result file is no longer read by anyone.
const MOST_TIMES: f64 = 10_000.0;

impl Times {
    /// The times themselves.
    #[must_use]
    pub fn list(&self) -> Vec<f64> {
        // The slack takes in an end that roundoff put just below a multiple.
        let n = (self.until / self.every + 1e-9).floor().min(MOST_TIMES);
        (1..=10_000_u32)
            .take_while(|&k| f64::from(k) <= n)
            .map(|k| f64::from(k) * self.every)
            .collect()
    }

    fn check(&self) -> Result<(), Objection> {
        must("times.until", self.until, self.until > 0.0, "greater than 0")?;
        must(
            "times.every",
            self.every,
            self.every > 0.0 && self.every <= self.until,
            "greater than 0 and at most `until`",
        )?;
        let n = self.until / self.every;
        must("times.every", self.every, n <= MOST_TIMES, "such that there are at most 10000 times")
    }
}

impl System {
    /// The natural period (s).
    #[must_use]
    pub fn period(&self) -> f64 {
        match self {
            Self::Linear(system) => system.period(),
            Self::Damper(system) => system.period(),
        }
    }
}

impl LawScene {
    /// The law, checked; `filter` is the stationary covariance of a filter's states, which come last.
    ///
    /// # Errors
    /// [`SystemError`] for a list of another length; [`fpk_sph::Error`] for what the law refuses.
    pub fn build<const D: usize>(
        &self,
        filter: Option<&[Vec<f64>]>,
    ) -> Result<GaussianMixture<D>, SystemError> {
        let law = match self {
            Self::Gaussian { mean, standard_deviation } => GaussianMixture::independent(
                list("mean", mean)?,
                list("standard_deviation", standard_deviation)?,
            ),
            Self::StationaryFilter { mean, standard_deviation } => {
                let filter = filter.unwrap_or_default();
                let structure = D.saturating_sub(filter.len());
                let wanted = || format!("the structure has {structure} states");
                for (key, values) in [("mean", mean), ("standard_deviation", standard_deviation)] {
                    if values.len() != structure {
                        let count = values.len();
                        return Err(SystemError::Shape { key, count, wanted: wanted() });
                    }
                }
                let (mut means, mut covariance) = ([0.0; D], [[0.0; D]; D]);
                means[..structure].copy_from_slice(mean);
                for (k, deviation) in standard_deviation.iter().enumerate() {
                    covariance[k][k] = deviation * deviation;
                }
                for (row, values) in covariance[structure..].iter_mut().zip(filter) {
                    row[structure..].copy_from_slice(values);
                }
                GaussianMixture::gaussian(means, covariance)
            }
            Self::Mixture(components) => {
                let component = |component: &ComponentScene| -> Result<_, SystemError> {
                    let ComponentScene { weight, mean, covariance } = component;
                    Ok(GaussianComponent {
                        weight: *weight,
                        mean: list("mean", mean)?,
                        covariance: square("covariance", covariance)?,
                    })
                };
                let components: Vec<_> =
                    components.iter().map(component).collect::<Result<_, _>>()?;
                GaussianMixture::mixture(&components)
            }
        };
        Ok(law.map_err(fpk_sph::Error::from)?)
    }

    fn check(&self, system: &SceneSystem) -> Result<(), Objection> {
        let name = match self {
            Self::Gaussian { .. } => "gaussian",
            Self::StationaryFilter { .. } => "stationary_filter",
            Self::Mixture(_) => "mixture",
        };
        let filter = system.filter_covariance();
        if filter.is_none() && matches!(self, Self::StationaryFilter { .. }) {
            let message = "the system has no filter";
            return Err(Objection::new("initial.stationary_filter", message)
                .with_help("use `gaussian` with a mean and a standard deviation for each state"));
        }
        if let Self::Gaussian { standard_deviation, .. }
        | Self::StationaryFilter { standard_deviation, .. } = self
        {
            for (k, &deviation) in standard_deviation.iter().enumerate() {
                let path = format!("initial.{name}.standard_deviation[{k}]");
                must(&path, deviation, deviation > 0.0, "greater than 0")?;
            }
        }
        system.visit(Build(self, filter.as_deref())).map_err(|error| {
            let states = format!("the states are {}", system.states().join(", "));
            match &error {
                SystemError::Shape { key, .. } if name != "mixture" => {
                    Objection::new(format!("initial.{name}.{key}"), error.to_string())
                        .with_help(states)
                }
                SystemError::Shape { .. } => {
                    Objection::new("initial.mixture", error.to_string()).with_help(states)
                }
                _ => Objection::new("initial", error.to_string()),
            }
        })
    }
}

/// Builds a law in the dimension of the system.
struct Build<'a>(&'a LawScene, Option<&'a [Vec<f64>]>);

impl Visitor for Build<'_> {
    type Output = Result<(), SystemError>;
    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, _: &S) -> Self::Output {
        self.0.build::<D>(self.1).map(|_| ())
    }
}

impl DemandScene {
    /// The demand on a system with these states.
    fn build(&self, states: &[&str]) -> Result<Demand, Objection> {
        match self {
            Self::State(name) => {
                let k = state(name, states, "demand.state")?;
                Ok(Demand::of_state(k, name, states.len()))
            }
            Self::Combination { name, weights } => {
                if weights.len() != states.len() {
                    let message = format!(
                        "`weights` has {} entries; the system has {} states",
                        weights.len(),
                        states.len()
                    );
                    return Err(Objection::new("demand.combination.weights", message)
                        .with_help(format!("the states are {}", states.join(", "))));
                }
                Ok(Demand { name: name.clone(), weights: weights.clone() })
            }
        }
    }
}

/// The place of a state among those of the system.
fn state(name: &str, states: &[&str], path: &str) -> Result<usize, Objection> {
    states.iter().position(|state| *state == name).ok_or_else(|| {
        Objection::new(path, format!("the system has no state `{name}`"))
            .with_help(format!("the states are {}", states.join(", ")))
    })
}

impl FpkScene {
    /// The configuration of the density solver, where the method is one; `scale` multiplies the particles per axis.
    /// `None` too where the lattice is of another dimension, which [`Scene::check`] refuses.
    #[must_use]
    pub fn density_config<const D: usize>(&self, period: f64, scale: f64) -> Option<Config<D>> {
        let (method, lattice) = match &self.method {
            MethodScene::LogDensityFit(lattice) => {
                (lattice.method::<D>(Method::LogDensityFit), lattice.build(scale)?)
            }
            MethodScene::FlowMapFit(lattice) => {
                (lattice.method::<D>(Method::FlowMapFit), lattice.build(scale)?)
            }
            MethodScene::CanorDenoel2013 { count, half_width, courant, support_over_spacing } => {
                let combination = Combination {
                    step: StepRule::Courant { number: *courant },
                    support_over_spacing: *support_over_spacing,
                    ..Method::CanorDenoel2013.combination()
                };
                let half_width = half_width.as_slice().try_into().ok()?;
                let lattice =
                    InitialLattice::Rectangle { half_width, count: scaled_counts(count, scale)? };
                (Method::Custom(combination), lattice)
            }
            MethodScene::MonteCarlo { .. } => return None,
        };
        Some(Config { method, lattice, reference_period: period, most_steps: DEFAULT_MOST_STEPS })
    }

    /// What exceeds the thresholds, on a system with these states.
    ///
    /// # Errors
    /// [`Objection`] for a state that is none, or another number of weights.
    pub fn demand(&self, states: &[&str]) -> Result<Demand, Objection> {
        self.demand.as_ref().map_or_else(
            || Ok(Demand::of_state(0, states[0], states.len())),
            |demand| demand.build(states),
        )
    }

    /// The planes that are drawn, by the places of their states.
    ///
    /// # Errors
    /// [`Objection`] for a state that is none.
    pub fn plane_states(&self, states: &[&str]) -> Result<Vec<[usize; 2]>, Objection> {
        let Some(planes) = &self.planes else { return Ok(Vec::new()) };
        let place = |(k, [across, up]): (usize, &[String; 2])| {
            let path = |axis| format!("planes.states[{k}][{axis}]");
            Ok([state(across, states, &path(0))?, state(up, states, &path(1))?])
        };
        planes.states.iter().enumerate().map(place).collect()
    }
}

impl Scene for FpkScene {
    fn check(&self) -> Result<(), Objection> {
        let system = self.system.build().map_err(|error| self.system.objection(&error))?;
        let states = system.states();
        self.initial.check(&system)?;
        self.times.check()?;
        self.check_method(&system)?;
        self.demand(states)?;
        self.check_planes(states)?;
        if let Some(CloudScene { every_observations }) = self.cloud {
            let path = "cloud.every_observations";
            must(path, every_observations as f64, every_observations > 0, "at least 1")?;
        }
        for (k, &threshold) in self.thresholds.iter().enumerate() {
            must(&format!("thresholds[{k}]"), threshold, threshold > 0.0, "greater than 0")?;
            let sorted = k == 0 || threshold > self.thresholds[k - 1];
            must(&format!("thresholds[{k}]"), threshold, sorted, "greater than the one before it")?;
        }
        for (k, powers) in self.moments.iter().enumerate() {
            check_length(&format!("moments[{k}]"), powers.len(), states)?;
            let order = powers.iter().sum::<u32>();
            must(
                &format!("moments[{k}]"),
                f64::from(order),
                (1..=8).contains(&order),
                "of order 1 to 8",
            )?;
        }
        Ok(())
    }
}

impl FpkScene {
    fn check_planes(&self, states: &[&str]) -> Result<(), Objection> {
        self.plane_states(states)?;
        let (Some(planes), times) = (&self.planes, self.times.list()) else { return Ok(()) };
        for (k, &t) in planes.times.iter().enumerate() {
            let observed = times.iter().any(|time| (time - t).abs() < 1e-9);
            must(&format!("planes.times[{k}]"), t, observed, "a time of observation")?;
        }
        Ok(())
    }

    fn check_method(&self, system: &SceneSystem) -> Result<(), Objection> {
        let states = system.states();
        match &self.method {
            MethodScene::LogDensityFit(lattice) => lattice.check("method.log_density_fit", states),
            MethodScene::FlowMapFit(lattice) => lattice.check("method.flow_map_fit", states),
            MethodScene::CanorDenoel2013 { count, half_width, courant, support_over_spacing } => {
                let path = "method.canor_denoel_2013";
                check_counts(path, count, states)?;
                check_length(&format!("{path}.half_width"), half_width.len(), states)?;
                for (k, &width) in half_width.iter().enumerate() {
                    must(&format!("{path}.half_width[{k}]"), width, width > 0.0, "greater than 0")?;
                }
                must(&format!("{path}.courant"), *courant, *courant > 0.0, "greater than 0")?;
                let ratio = *support_over_spacing;
                must(&format!("{path}.support_over_spacing"), ratio, ratio > 0.0, "greater than 0")
            }
            MethodScene::MonteCarlo { paths, step, integrator, .. } => {
                must("method.monte_carlo.paths", *paths as f64, *paths >= 2, "at least 2")?;
                must("method.monte_carlo.step", *step, *step > 0.0, "greater than 0")?;
                let offered = system.visit(Offered);
                if offered.contains(integrator) {
                    return Ok(());
                }
                let names: Vec<_> = offered.iter().map(|integrator| integrator.name()).collect();
                let message =
                    format!("the integrator {} does not step this system", integrator.name());
                Err(Objection::new("method.monte_carlo.integrator", message)
                    .with_help(format!("there are: {}", names.join(", "))))
            }
        }
    }
}

/// The integrators of a system.
struct Offered;

impl Visitor for Offered {
    type Output = &'static [IntegratorScene];
    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, _: &S) -> Self::Output {
        S::INTEGRATORS
    }
}

pub(super) fn check_length(path: &str, count: usize, states: &[&str]) -> Result<(), Objection> {
    if count == states.len() {
        return Ok(());
    }
    let message = format!("there are {count} entries; the system has {} states", states.len());
    Err(Objection::new(path, message).with_help(format!("the states are {}", states.join(", "))))
}

/// Objects to the value at a path unless it is as it must be.
pub(super) fn must(path: &str, value: f64, holds: bool, limit: &str) -> Result<(), Objection> {
    if holds {
        Ok(())
    } else {
        Err(Objection::new(path, format!("{value} was given; it must be {limit}")))
    }
}
