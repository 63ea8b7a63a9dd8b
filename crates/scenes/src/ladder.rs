//! A scene by every method that solves it, each at any size: what `advise`, `run --tolerance` and the charts of scenes run.
//!
//! A kind of scene says how its methods are written into a scene and what a result holds; nothing here knows a solver.

mod built_in;
mod trial;

use serde::Serialize;
use serde_json::{Map, Value};

pub use self::built_in::{BuiltIn, BuiltInError};
pub use self::trial::{
    LadderError, Outcome, Trial, climb, is_next_beyond, read_answer, repeated_costs, try_rung,
    try_scene,
};

/// A scene and the methods that solve it.
pub struct Ladder {
    /// The scene's own method comes first.
    pub methods: Vec<Method>,
    /// What no figure of the trials has in it, one sentence.
    pub left_out: &'static str,
}

/// A method at any size.
pub struct Method {
    /// Its name in tables and legends.
    pub name: String,
    /// How error and cost go with its size.
    pub growth: Growth,
    /// Whether it may contradict others.
    pub standing: Standing,
    /// The smallest size that is worth a run.
    pub first: f64,
    /// The rung of that size or the next that exists; none where the method has none so large.
    pub rung: Box<dyn Fn(f64) -> Option<Rung> + Send + Sync>,
}

/// A method at one size.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// Its size.
    pub size: f64,
    /// The size in words, e.g. `29 x 29`; empty where there is one size.
    pub label: String,
    /// The whole scene, solved by the method at this size.
    pub scene: Map<String, Value>,
    /// The scene that trials run: without what only looks at the result.
    pub trial: Map<String, Value>,
    /// The keys of the scene that set the method and its size.
    pub choice: Map<String, Value>,
}

/// How error and cost of a method go with its size, before anything was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Growth {
    /// The size counts intervals along a length of a lattice in so many dimensions; errors fall with its square.
    Lattice {
        /// Dimensions of the lattice.
        dimensions: usize,
    },
    /// The size counts samples; errors fall with its root.
    Samples,
    /// There is one size.
    Fixed,
}

/// Whether what a method says is held against others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// It samples, and what is left beside its standard error is small: what it contradicts is wrong.
    Judge,
    /// It is judged by others and by itself.
    Judged,
}

/// A number that a result holds, at the last time.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// e.g. `moment/2-0`.
    pub id: String,
    /// In the words of the field, e.g. `E[q^2]`.
    pub words: String,
    /// The value.
    pub value: f64,
    /// How far off it may be as the run itself tells: two standard errors of what was sampled.
    pub error: Option<f64>,
    /// What errors of it are related to: its size, or that of the terms which cancel in it.
    pub scale: f64,
}

/// What came of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// CPU time of all threads (s).
    pub cpu_seconds: f64,
    /// The numbers.
    pub quantities: Vec<Quantity>,
}

/// A scene as the keys at its top.
///
/// # Errors
/// Those of its `Serialize`.
pub fn keys(scene: &impl Serialize) -> Result<Map<String, Value>, serde_json::Error> {
    match serde_json::to_value(scene)? {
        Value::Object(keys) => Ok(keys),
        other => Err(serde::de::Error::custom(format!("a scene is an object, not {other}"))),
    }
}

/// Rounded to two digits, as one would write a size.
#[must_use]
pub fn two_digits(value: f64) -> f64 {
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    // Through text, so that 0.7 is 0.7.
    format!("{:.6}", (value / unit).round() * unit).parse().unwrap_or(value)
}

/// A size that counts, to the nearest whole number.
#[must_use]
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "positive, and saturates"
)]
pub fn whole(size: f64) -> u64 {
    size.round().max(1.0) as u64
}

/// One rung costs about so many times the one below.
const COST_FACTOR: f64 = 3.0;

impl Growth {
    /// `p` in error `~ size^-p`; no method here does better.
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

    /// The size of a rung over that of the one below.
    #[must_use]
    pub fn factor(self) -> f64 {
        COST_FACTOR.powf(1.0 / self.cost_exponent())
    }
}

impl Method {
    /// Its name with a size in words.
    #[must_use]
    pub fn at(&self, label: &str) -> String {
        if label.is_empty() { self.name.clone() } else { format!("{}, {label}", self.name) }
    }
}

impl Rung {
    /// A rung from the scene at this size, the scene that trials run, and the part that sets the method; `None` where one is not JSON.
    pub fn new(
        (size, label): (f64, String),
        scene: &impl Serialize,
        trial: &impl Serialize,
        choice: &impl Serialize,
    ) -> Option<Self> {
        let (scene, trial) = (keys(scene).ok()?, keys(trial).ok()?);
        Some(Self { size, label, scene, trial, choice: keys(choice).ok()? })
    }
}

impl Answer {
    /// The quantity with this id.
    #[must_use]
    pub fn get(&self, id: &str) -> Option<&Quantity> {
        self.quantities.iter().find(|quantity| quantity.id == id)
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
