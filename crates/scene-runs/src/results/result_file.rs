//! `result.json`: the keys common to all kinds of scene, followed by those of a kind.

use result_figures::finite::{self, JsonError};
use serde::Serialize;
use serde_json::Value;

use crate::machine::{Machine, commit};

/// Name of the file.
pub(crate) const NAME: &str = "result.json";

/// The text of `result.json`, and what of it the page shows.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultFile {
    pub(crate) text: String,
    /// Words on a number that is not finite: `null` in the text.
    pub(crate) not_finite: Option<String>,
    /// The scene with its defaults.
    pub(crate) scene: Value,
    pub(crate) machine: Machine,
    pub(crate) commit: Option<String>,
}

/// Common keys of every result, followed by those of its schema.
#[derive(Serialize)]
struct Keys<'a, S, C> {
    schema: &'static str,
    version: &'static str,
    commit: Option<&'a str>,
    machine: &'a Machine,
    /// The parsed scene.
    scene: &'a S,
    #[serde(flatten)]
    content: &'a C,
}

/// Version of the crate, in every result.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

impl ResultFile {
    /// The result of a scene on this machine.
    ///
    /// A number that is not finite is written as `null`, and a warning of the run names it: one number does not cost the others.
    ///
    /// # Errors
    /// [`JsonError::Shape`].
    pub fn new(
        schema: &'static str,
        scene: &impl Serialize,
        content: &impl Serialize,
    ) -> Result<Self, JsonError> {
        let (machine, commit) = (Machine::read(), commit());
        let (version, of_machine) = (VERSION, &machine);
        let commit_of = commit.as_deref();
        let keys = Keys { schema, version, commit: commit_of, machine: of_machine, scene, content };
        let (text, not_finite) = finite::to_json_with_null(&keys)?;
        let not_finite = not_finite.map(|number| number.to_string());
        let scene = serde_json::to_value(scene)?;
        Ok(Self { text, not_finite, scene, machine, commit })
    }
}
