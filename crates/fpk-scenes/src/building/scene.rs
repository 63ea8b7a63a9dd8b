//! A scene of a building as written in its JSON file.

use scene_runs::scene::{Objection, Scene, WrongKey, read_keys};
use schemars::JsonSchema;
use sde_integrators::{Between, Response, Side};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use vibrating_systems::ShearBuilding;

use super::building_scene::{BuildingScene, GroundScene};
use super::method_scene::BuildingMethod;
use crate::checks::must;
use crate::scene::Times;

/// First passages of a shear building under ground motion, from rest: building, ground, questions and method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PassageScene {
    /// Always `random-vibration`.
    pub solver: String,
    /// Title, one line.
    pub title: String,
    /// The building.
    pub building: BuildingScene,
    /// The ground acceleration.
    pub ground: GroundScene,
    /// The response.
    pub response: ResponseScene,
    /// Thresholds `T` of `P(max |u| > T)`, increasing (m).
    pub thresholds: Vec<f64>,
    /// Times up to which first passages count, at equal intervals.
    pub times: Times,
    /// Method of solution.
    pub method: BuildingMethod,
}

/// The response whose magnitude is compared with the thresholds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResponseScene {
    /// The storey whose drift counts, from 1; the largest drift of all storeys without this key (no unit).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = 1)]
    pub storey: Option<usize>,
    /// The drift between the ends of a step.
    #[serde(default)]
    #[schemars(example = BetweenScene::Endpoints)]
    pub between: BetweenScene,
}

/// The drift between the ends of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BetweenScene {
    /// A cubic through the drifts and their rates at both ends.
    #[default]
    Cubic,
    /// The ends alone, as in benchmarks that count at grid times.
    Endpoints,
}

/// `h omega` up to which a step of Runge-Kutta 4 of an oscillation is stable: `2 sqrt(2)`.
const STABLE: f64 = 2.8;
/// Largest number of steps of a path.
const MOST_STEPS: f64 = 1e5;
/// Largest number of thresholds: each has guides of its own.
const MOST_THRESHOLDS: usize = 64;
/// Largest number of storeys: their covariance is integrated in time.
const MOST_STOREYS: usize = 100;

impl PassageScene {
    /// The drifts that count.
    pub(super) fn responses(&self, building: &ShearBuilding) -> Vec<Response<'static>> {
        let n = building.n_storeys();
        let storeys = self.response.storey.map_or(0..n, |storey| storey - 1..storey);
        let response = |i: usize| Response {
            component: i,
            side: Side::Magnitude,
            between: match self.response.between {
                BetweenScene::Cubic => Between::CubicHermite { velocity: n + i },
                BetweenScene::Endpoints => Between::Endpoints,
            },
        };
        storeys.map(response).collect()
    }

    /// Steps from one of the times to the next; the tolerance prevents roundoff from adding one.
    pub(super) fn steps_per_time(&self) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked: at most 1e5"
        )]
        let steps = (self.times.every / self.method.step() - 1e-9).ceil().max(1.0) as usize;
        steps
    }
}

impl Scene for PassageScene {
    type Built = ShearBuilding;

    fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
        read_keys(keys)
    }

    fn check(&self) -> Result<ShearBuilding, Objection> {
        let n = self.building.mass.len();
        let fits = (1..=MOST_STOREYS).contains(&n);
        must("building.mass", n as f64, fits, "the masses of 1 to 100 storeys")?;
        let building = self.building.build(&self.ground)?;
        self.times.check()?;
        if let Some(storey) = self.response.storey {
            let limit = format!("from 1 to {n}");
            must("response.storey", storey as f64, (1..=n).contains(&storey), &limit)?;
        }
        let stable = STABLE / std::f64::consts::TAU * building.shortest_period();
        self.method.check(stable)?;
        let steps = self.times.until / self.method.step();
        let key = format!("method.{}.step", self.method.key());
        let limit = "such that a path has at most 100000 steps";
        must(&key, self.method.step(), steps <= MOST_STEPS, limit)?;
        let count = self.thresholds.len();
        let few = (1..=MOST_THRESHOLDS).contains(&count);
        must("thresholds", count as f64, few, "a list of 1 to 64 thresholds")?;
        for (k, &threshold) in self.thresholds.iter().enumerate() {
            must(&format!("thresholds[{k}]"), threshold, threshold > 0.0, "greater than 0")?;
            let sorted = k == 0 || threshold > self.thresholds[k - 1];
            must(&format!("thresholds[{k}]"), threshold, sorted, "greater than the one before it")?;
        }
        Ok(building)
    }

    fn seed(&mut self) -> Option<&mut u64> {
        Some(self.method.seed())
    }
}
