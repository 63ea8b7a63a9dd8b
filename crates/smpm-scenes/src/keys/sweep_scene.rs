//! A sweep over one number of a scene, as written in its JSON file.

use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::quantity_name::QuantityName;

/// A sweep over one number: the value at which an event begins, or the probability of the event over that number.
///
/// With `deterministic` the value is bracketed at the centre of the parameters. With `monte_carlo` every run has its own random
/// parameters, and `samples` is the largest number of runs; values near the limit are chosen as runs come in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepScene {
    /// The number, by its path as in messages, e.g. `bodies[0].velocity[1]`.
    pub number: String,
    /// A value at which the event does not occur at the centre of the parameters (unit of the number).
    pub from: f64,
    /// A value at which it does, above or below `from` (unit of the number).
    pub to: f64,
    /// The event.
    pub event: EventScene,
    /// Width to which the limit at the centre is bracketed (unit of the number); a fiftieth of the range without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = 0.002)]
    pub within: Option<f64>,
    /// Half width of the 95 % interval of the probability at which runs end early (no unit).
    #[serde(default = "usual_band")]
    #[schemars(example = 0.05)]
    pub band: f64,
    /// Values at which the probability is given (unit of the number); eleven over the range without this key.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = vec![0.18, 0.19, 0.2])]
    pub at: Vec<f64>,
}

/// An event that occurs or does not occur in a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EventScene {
    /// Its name, a past participle, e.g. `perforated`.
    pub name: String,
    /// The gauge whose quantity decides, at the last time.
    pub gauge: String,
    /// The quantity that decides, one of those of the scene.
    #[schemars(with = "QuantityName")]
    pub quantity: String,
    /// The event occurs above this value (unit of the quantity). Either this or `below`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above: Option<f64>,
    /// The event occurs below this value (unit of the quantity). Either this or `above`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = -0.01)]
    pub below: Option<f64>,
}

const fn usual_band() -> f64 {
    0.1
}

impl SweepScene {
    /// An example: the velocity at which a plate is perforated.
    pub(super) fn of_velocity() -> Self {
        Self {
            number: "bodies[0].velocity[1]".to_owned(),
            from: 0.15,
            to: 0.3,
            event: EventScene {
                name: "perforated".to_owned(),
                gauge: "projectile".to_owned(),
                quantity: "velocity_2".to_owned(),
                above: Some(0.005),
                below: None,
            },
            within: None,
            band: usual_band(),
            at: Vec::new(),
        }
    }

    /// Values at which the probability is given.
    pub(crate) fn values(&self) -> Vec<f64> {
        if self.at.is_empty() {
            (0..=10).map(|k| self.from + (self.to - self.from) * f64::from(k) / 10.0).collect()
        } else {
            self.at.clone()
        }
    }

    /// Width of the bracket at the centre.
    pub(crate) fn bracket(&self) -> f64 {
        self.within.unwrap_or_else(|| 0.02 * (self.to - self.from).abs())
    }

    /// Rejects ranges, widths and events that cannot be.
    pub(crate) fn check(&self) -> Result<(), Objection> {
        let wrong =
            |key: &str, message: String| Err(Objection::new(format!("sweep.{key}"), message));
        let (from, to, range) = (self.from, self.to, (self.to - self.from).abs());
        if range == 0.0 {
            return wrong("to", format!("the range is from {from} to {to}; it needs two values"));
        }
        if self.within.is_some_and(|within| !(within > 0.0 && within < range)) {
            let width = self.bracket();
            return wrong(
                "within",
                format!("the width is {width}; it must be above 0 and below {range}"),
            );
        }
        if !(self.band > 0.0 && self.band < 0.5) {
            return wrong(
                "band",
                format!("the half width is {}; it must be above 0 and below 0.5", self.band),
            );
        }
        if self.event.above.is_some() == self.event.below.is_some() {
            return wrong("event", "an event needs one of `above` and `below`".to_owned());
        }
        Ok(())
    }
}

impl EventScene {
    /// Whether a value of the quantity is the event.
    pub(crate) fn occurs(&self, value: f64) -> bool {
        self.above.is_some_and(|limit| value > limit)
            || self.below.is_some_and(|limit| value < limit)
    }
}
