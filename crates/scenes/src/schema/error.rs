//! Why there is no page of scenes.

use std::io;
use std::path::PathBuf;

use figures::finite::JsonError;

use crate::output::OutputError;
use crate::scene::SceneError;

/// What the generator of schemas refuses.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum SchemaError {
    /// A schema has a form that the page cannot show.
    #[error("the schema of {solver} has a form at `{place}` that the page cannot show: {schema}")]
    Form {
        /// Which kind of scene.
        solver: &'static str,
        /// Which type and key.
        place: String,
        /// What stands there.
        schema: String,
    },
    /// Numbers whose description states no unit.
    #[error("{solver}: {} without a unit in the description: {}", .keys.len(), .keys.join(", "))]
    #[diagnostic(help("write it in parentheses into the doc comment: `(m)`, `(no unit)`"))]
    NoUnit {
        /// Which kind of scene.
        solver: &'static str,
        /// Their types and paths in them.
        keys: Vec<String>,
    },
    /// Keys that neither a scene nor a type shows.
    #[error("{solver}: {} without an example: {}", .keys.len(), .keys.join(", "))]
    #[diagnostic(help("give a scene that has them, or `#[schemars(example = ...)]` to the type"))]
    NoExample {
        /// Which kind of scene.
        solver: &'static str,
        /// Their types and paths in them.
        keys: Vec<String>,
    },
    /// A scene, or an example of a type, that does not fit its schema.
    #[error("{source_of_it} does not fit the schema at `{place}`: {value}")]
    Misfit {
        /// The scene, or the type of the example.
        source_of_it: String,
        /// Which type and key.
        place: String,
        /// What stands there.
        value: String,
    },
    /// A built-in scene cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The folder of scenes cannot be read.
    #[error("cannot list the scenes in {}", .path.display())]
    Folder {
        /// Which folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A schema holds a number that is not finite.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// What was written could not be told.
    #[error("cannot print")]
    Print(#[source] io::Error),
}
