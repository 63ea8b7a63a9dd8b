//! Ladders: a scene by every method that solves it, at any size.
//!
//! `advise`, `run --tolerance` and the charts of scenes use them.
//!
//! A scene kind defines how its methods are written into a scene; what they answer is compared by id. This module knows no
//! solver.

mod built_in;
mod trial;

use serde::Serialize;
use serde_json::{Map, Value};

pub use self::built_in::{BuiltIn, BuiltInError};
pub use self::trial::{Limits, Outcome, Trial, climb, is_next_beyond, try_scene};

/// A scene and the methods that solve it.
pub struct Ladder {
    /// The scene's own method comes first.
    pub methods: Vec<Method>,
    /// Errors that the trials do not include, in one sentence.
    pub left_out: &'static str,
}

/// A method at any size.
pub struct Method {
    /// Its name in tables and legends.
    pub name: String,
    /// Growth of error and cost with its size.
    pub growth: Growth,
    /// Whether its results can refute those of others.
    pub standing: Standing,
    /// Smallest useful size.
    pub first: f64,
    /// The rung of that size or the next existing one; none if the method has no such size.
    pub rung: Box<dyn Fn(f64) -> Option<Rung> + Send + Sync>,
}

/// A method at one size.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// Its size.
    pub size: f64,
    /// Label of the size, e.g. `29 x 29`; empty for a method with one size.
    pub label: String,
    /// The whole scene, solved by the method at this size.
    pub scene: Map<String, Value>,
    /// The scene for trials, without output keys.
    pub trial: Map<String, Value>,
    /// Keys of the scene that set the method and its size.
    pub choice: Map<String, Value>,
}

/// Expected growth of error and cost with the size, before measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Growth {
    /// The size is the number of intervals along a length of a lattice; errors decrease with its square.
    Lattice {
        /// Dimensions of the lattice.
        dimensions: usize,
    },
    /// The size is the number of samples; errors decrease with its square root.
    Samples,
    /// The method has one size.
    Fixed,
}

/// Whether a method's results can refute those of others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// A sampling method with negligible bias: results that it contradicts are wrong.
    Judge,
    /// A method compared with others and with itself.
    Judged,
}

/// A scene as its top-level keys.
///
/// # Errors
/// Those of its `Serialize` implementation.
pub fn keys(scene: &impl Serialize) -> Result<Map<String, Value>, serde_json::Error> {
    match serde_json::to_value(scene)? {
        Value::Object(keys) => Ok(keys),
        other => Err(serde::de::Error::custom(format!("a scene is an object, not {other}"))),
    }
}

/// Rounds to two digits, as a user would write a size.
#[must_use]
pub fn two_digits(value: f64) -> f64 {
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    // Through text, so that 0.7 is exactly 0.7.
    format!("{:.6}", (value / unit).round() * unit).parse().unwrap_or(value)
}

/// A size that is a count, rounded to the nearest integer.
#[must_use]
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "positive, and saturates"
)]
pub fn whole(size: f64) -> u64 {
    size.round().max(1.0) as u64
}

/// Approximate cost of a rung over that of the one below.
const COST_FACTOR: f64 = 3.0;

impl Growth {
    /// `p` in error `~ size^-p`; no method here has a higher order.
    #[must_use]
    pub const fn order(self) -> f64 {
        match self {
            Self::Lattice { .. } => 2.0,
            Self::Samples => 0.5,
            Self::Fixed => 0.0,
        }
    }

    /// `q` in cost `~ size^q`.
    #[must_use]
    pub fn cost_exponent(self) -> f64 {
        match self {
            Self::Lattice { dimensions } => dimensions as f64,
            Self::Samples | Self::Fixed => 1.0,
        }
    }

    /// Ratio of the sizes of successive rungs.
    #[must_use]
    pub fn factor(self) -> f64 {
        COST_FACTOR.powf(1.0 / self.cost_exponent())
    }
}

impl Method {
    /// Its name with the label of a size.
    #[must_use]
    pub fn at(&self, label: &str) -> String {
        if label.is_empty() { self.name.clone() } else { format!("{}, {label}", self.name) }
    }
}

impl Rung {
    /// A rung from the full scene, the scene for trials, and the names of the keys that set the method.
    ///
    /// `None` if one of them is not JSON.
    pub fn new(
        (size, label): (f64, String),
        scene: &impl Serialize,
        trial: &impl Serialize,
        choice: &[&str],
    ) -> Option<Self> {
        let (scene, trial) = (keys(scene).ok()?, keys(trial).ok()?);
        let key = |name: &&str| Some(((*name).to_owned(), scene.get(*name)?.clone()));
        let choice = choice.iter().map(key).collect::<Option<_>>()?;
        Some(Self { size, label, scene, trial, choice })
    }
}

impl std::fmt::Debug for Method {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, growth, first, .. } = self;
        let mut fields = formatter.debug_struct("Method");
        fields.field("name", name).field("growth", growth).field("first", first);
        fields.finish_non_exhaustive()
    }
}

impl std::fmt::Debug for Ladder {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Ladder").field("methods", &self.methods).finish_non_exhaustive()
    }
}
