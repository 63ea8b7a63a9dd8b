//! Scenes drawn at random whose answers are known, and how often the truth lies within the errors that runs state.
//!
//! A [`Family`] draws a scene with its true answers. [`hunt`] runs the scenes of all families and returns a [`Tally`]: by method
//! and by kind of quantity, the share of numbers whose truth lies within 1, 2, 5 and 10 stated errors. Settings are sensible or
//! hostile; a hostile one is valid and chosen badly, such as a lattice that ends within the distribution.

mod draw;
mod families;
mod family;
mod hunt;
mod normal;
mod page;
mod tally;
mod verdict;

pub use draw::Draw;
pub use families::ALL;
pub use family::{Family, Judge};
pub use hunt::{Hunt, Outcome, hunt, judged, known};
pub use page::page;
pub use tally::{Row, Tally};
pub use verdict::Verdict;

use serde_json::Value;

/// A scene with its true answers.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Its family.
    pub family: &'static Family,
    /// The scene.
    pub scene: Value,
    /// Name of its method.
    pub method: &'static str,
    /// Whether its settings are valid and chosen badly.
    pub is_hostile: bool,
    /// What is known of its answers.
    pub truths: Vec<Truth>,
}

/// The true value of an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Id of the answer.
    pub id: String,
    /// Time that it is of; none for an answer without times.
    pub time: Option<f64>,
    /// The value.
    pub value: f64,
    /// Values that far from it are equal to it: its own error.
    pub error: f64,
}
