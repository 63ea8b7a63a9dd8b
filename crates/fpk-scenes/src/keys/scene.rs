//! A density scene as written in its JSON file.

use result_figures::number::{exact, tidy};
use scene_runs::RunError;
use scene_runs::scene::{Objection, Retired, Scene, SceneError, SceneFile, WrongKey, read_keys};
use schemars::JsonSchema;
use sde_integrators::GaussianMixture;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::checks::{check_length, must};
use super::law_scene::LawScene;
use super::method_scene::MethodScene;
use super::system_scene::SystemScene;
use crate::density::{Demand, Requested};
use crate::retired::RETIRED;
use crate::system::System;

/// The probability density of a system under noise over time: system, requested quantities and method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FpkScene {
    /// Always `fpk-sph`.
    pub solver: String,
    /// Title, one line.
    pub title: String,
    /// The system.
    pub system: SystemScene,
    /// Distribution of the state at `t = 0`.
    pub initial: LawScene,
    /// Method of solution.
    pub method: MethodScene,
    /// Times of observation, at equal intervals.
    pub times: Times,
    /// Raw moments `E[x_1^a_1 .. x_D^a_D]`, each as its powers `[a_1, .., a_D]`, one for each state (no unit).
    pub moments: Vec<Vec<u32>>,
    /// Demand compared with the thresholds; the first state without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub demand: Option<DemandScene>,
    /// Thresholds `T` of `P(|y| > T)`, increasing (unit of the demand `y`).
    pub thresholds: Vec<f64>,
    /// Planes on which the density is drawn; none without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planes: Option<PlanesScene>,
    /// Particle files for ParaView; none without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cloud: Option<CloudScene>,
}

/// Demand whose magnitude is compared with the thresholds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DemandScene {
    /// A state, by its name.
    State(String),
    /// A weighted sum of the states, e.g. the drift of an upper storey.
    Combination {
        /// Its name.
        name: String,
        /// Weight of each state (unit of the demand over that of the state).
        weights: Vec<f64>,
    },
}

/// Marginal densities of pairs of states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanesScene {
    /// Pairs of states by name: horizontal and vertical axis.
    pub states: Vec<[String; 2]>,
    /// Times, among the times of observation (s).
    pub times: Vec<f64>,
}

/// Particle files over time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CloudScene {
    /// Number of observations per file (no unit).
    pub every_observations: usize,
}

/// Times of observation at equal intervals, from `every` to `until`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Times {
    /// The last time, a multiple of `every` (s).
    pub until: f64,
    /// The interval (s).
    pub every: f64,
}

/// Largest number of output times of a scene; larger result files are impractical.
const MOST_TIMES: f64 = 10_000.0;

/// Longest reference time of the steps over the length of a run.
const MOST_PERIOD: f64 = 10.0;

/// How far a multiple of an interval may be from a whole number of intervals, relatively: decimals in binary.
const ROUNDOFF: f64 = 1e-9;

impl Times {
    /// Times of observation.
    #[must_use]
    pub fn list(&self) -> Vec<f64> {
        let n = (self.until / self.every).round().min(MOST_TIMES);
        (1..=10_000_u32)
            .take_while(|&k| f64::from(k) <= n)
            .map(|k| f64::from(k) * self.every)
            .collect()
    }

    pub(crate) fn check(&self) -> Result<(), Objection> {
        must("times.until", self.until, self.until > 0.0, "greater than 0")?;
        must(
            "times.every",
            self.every,
            self.every > 0.0 && self.every <= self.until,
            "greater than 0 and at most `until`",
        )?;
        let n = self.until / self.every;
        must(
            "times.every",
            self.every,
            n <= MOST_TIMES,
            "such that there are at most 10000 times",
        )?;
        let [below, above] = [n.floor(), n.ceil()].map(|n| tidy(n * self.every));
        let limit = format!(
            "a multiple of `every`, {}, so that the end is observed: {below} or {above}",
            exact(self.every)
        );
        must("times.until", self.until, (n - n.round()).abs() <= ROUNDOFF * n, &limit)
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

/// Index of a state among those of the system.
fn state(name: &str, states: &[&str], path: &str) -> Result<usize, Objection> {
    states.iter().position(|state| *state == name).ok_or_else(|| {
        Objection::new(path, format!("the system has no state `{name}`"))
            .with_help(format!("the states are {}", states.join(", ")))
    })
}

impl FpkScene {
    /// The demand on a system with these states.
    ///
    /// # Errors
    /// [`Objection`] for an unknown state, or another number of weights.
    pub fn demand(&self, states: &[&str]) -> Result<Demand, Objection> {
        self.demand.as_ref().map_or_else(
            || Ok(Demand::of_state(0, states[0], states.len())),
            |demand| demand.build(states),
        )
    }

    /// The planes to draw, by the indices of their states.
    ///
    /// # Errors
    /// [`Objection`] for an unknown state.
    pub fn plane_states(&self, states: &[&str]) -> Result<Vec<[usize; 2]>, Objection> {
        let Some(planes) = &self.planes else { return Ok(Vec::new()) };
        let place = |(k, [across, up]): (usize, &[String; 2])| {
            let path = |axis| format!("planes.states[{k}][{axis}]");
            let [across, up] = [state(across, states, &path(0))?, state(up, states, &path(1))?];
            if across == up {
                let message = format!("a plane needs two states; both are `{}`", states[up]);
                return Err(Objection::new(path(1), message));
            }
            Ok([across, up])
        };
        planes.states.iter().enumerate().map(place).collect()
    }
}

impl FpkScene {
    /// Parses a text, named in messages; returns the scene and its checked system.
    ///
    /// # Errors
    /// As [`SceneFile::build`].
    pub fn read(name: &str, text: &str) -> Result<(Self, System), SceneError> {
        SceneFile::from_text(name, text.to_owned())?.build()
    }

    /// What is asked for, in the dimension of the system or in that of a structure whose filter is conditioned out.
    ///
    /// The scene has been checked: its lists have as many entries as the system has states, and nothing is asked of states
    /// that are conditioned out.
    pub(crate) fn requested<const D: usize>(
        &self,
        system: &System,
        cells: bool,
    ) -> Result<Requested<D>, RunError> {
        let powers = |powers: &Vec<u32>| {
            let of_states = powers.get(..D).and_then(|powers| powers.try_into().ok());
            of_states.ok_or_else(|| RunError::solver(OtherDimension { states: D }))
        };
        let demand = self.demand(system.states());
        Ok(Requested {
            times: self.times.list(),
            powers: self.moments.iter().map(powers).collect::<Result<_, _>>()?,
            demand: demand.map_err(|_| RunError::solver(OtherDimension { states: D }))?,
            thresholds: self.thresholds.clone(),
            kinks: Vec::new(),
            cells,
        })
    }

    /// The reference time of the steps of a density: that of the system, unless the run ends long before. A system without drift has none.
    pub(crate) fn reference_period(&self, of_system: f64) -> f64 {
        of_system.min(MOST_PERIOD * self.times.until)
    }

    /// The initial distribution, in the dimension of the system.
    pub(crate) fn initial_law<const D: usize>(
        &self,
        system: &System,
    ) -> Result<GaussianMixture<D>, RunError> {
        self.initial.build(system.filter_covariance().as_deref()).map_err(RunError::solver)
    }
}

/// The scene was not checked.
#[derive(Debug, thiserror::Error)]
#[error("the scene is of another dimension than its system, which has {states} states")]
pub(crate) struct OtherDimension {
    pub(crate) states: usize,
}

impl Scene for FpkScene {
    type Built = System;
    const RETIRED: &[Retired] = RETIRED;

    fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
        read_keys(keys)
    }

    fn check(&self) -> Result<System, Objection> {
        let system = self.system.build().map_err(|error| self.system.objection(&error))?;
        let states = system.states();
        self.initial.check(&system, self.method.starts_at_points())?;
        self.times.check()?;
        self.method.check(&system, &self.initial, &self.times.list())?;
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
            let order = powers.iter().fold(0_u32, |order, &power| order.saturating_add(power));
            must(
                &format!("moments[{k}]"),
                f64::from(order),
                (1..=8).contains(&order),
                "of order 1 to 8",
            )?;
        }
        let n_structure = system.structure_states().map_or(states.len(), <[_]>::len);
        self.check_questions(states, n_structure)?;
        Ok(system)
    }

    fn seed(&mut self) -> Option<&mut u64> {
        match &mut self.method {
            MethodScene::MonteCarlo { seed, .. }
            | MethodScene::GuidedPaths { seed, .. }
            | MethodScene::SubsetSimulation { seed, .. } => Some(seed),
            _ => None,
        }
    }
}

impl FpkScene {
    /// Rejects quantities that the method does not compute.
    fn check_questions(&self, states: &[&str], n_structure: usize) -> Result<(), Objection> {
        match &self.method {
            MethodScene::ConservativeGrid { .. } => {
                for (k, powers) in self.moments.iter().enumerate() {
                    let highest = powers.iter().copied().max().unwrap_or_default();
                    let limit = "of power 4 at most in each state on a grid";
                    must(&format!("moments[{k}]"), f64::from(highest), highest <= 4, limit)?;
                }
                if self.demand(states)? == Demand::of_state(0, states[0], states.len()) {
                    return Ok(());
                }
                let message =
                    format!("the grid knows exceedances of the state {} alone", states[0]);
                Err(Objection::new("demand", message).with_help("leave out `demand`"))
            }
            MethodScene::FlowMapFit(_) if self.method.conditions_filter() => {
                self.check_without_filter(states, n_structure)
            }
            MethodScene::GuidedPaths { .. } | MethodScene::SubsetSimulation { .. }
                if self.thresholds.is_empty() =>
            {
                let message = "the method estimates exceedance probabilities alone, and there is no threshold";
                Err(Objection::new("thresholds", message).with_help("name at least one"))
            }
            _ => Ok(()),
        }
    }

    /// Rejects questions about the states of a filter that is conditioned out, which come last.
    fn check_without_filter(&self, states: &[&str], n_structure: usize) -> Result<(), Objection> {
        let refuse = |path: String| {
            let message = format!(
                "the states {} are conditioned out: the run knows those of the structure",
                states[n_structure..].join(", ")
            );
            Err(Objection::new(path, message)
                .with_help("leave this out, or `filter` of the method"))
        };
        for (k, powers) in self.moments.iter().enumerate() {
            if powers[n_structure..].iter().any(|power| *power > 0) {
                return refuse(format!("moments[{k}]"));
            }
        }
        if self.demand(states)?.weights[n_structure..].iter().any(|weight| *weight != 0.0) {
            return refuse("demand".to_owned());
        }
        for (k, plane) in self.plane_states(states)?.iter().enumerate() {
            if plane.iter().any(|state| *state >= n_structure) {
                return refuse(format!("planes.states[{k}]"));
            }
        }
        Ok(())
    }

    fn check_planes(&self, states: &[&str]) -> Result<(), Objection> {
        self.plane_states(states)?;
        let (Some(planes), times) = (&self.planes, self.times.list()) else { return Ok(()) };
        for (k, &t) in planes.times.iter().enumerate() {
            let observed = times.iter().any(|time| (time - t).abs() < 1e-9);
            must(&format!("planes.times[{k}]"), t, observed, "a time of observation")?;
        }
        Ok(())
    }
}
