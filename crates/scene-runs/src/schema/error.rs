//! Errors of schema generation.

use std::io;
use std::path::PathBuf;

use result_figures::finite::JsonError;

use crate::output::OutputError;
use crate::scene::SceneError;

/// Error of the schema generator.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum SchemaError {
    /// The page cannot represent a form of a schema.
    #[error("the schema of {solver} has a form at `{place}` that the page cannot show: {schema}")]
    Form {
        /// Scene kind.
        solver: &'static str,
        /// Type and key.
        place: String,
        /// The form.
        schema: String,
    },
    /// Descriptions of numbers lack units.
    #[error("{solver}: {} without a unit in the description: {}", .keys.len(), .keys.join(", "))]
    #[diagnostic(help("write it in parentheses into the doc comment: `(m)`, `(no unit)`"))]
    NoUnit {
        /// Scene kind.
        solver: &'static str,
        /// Types and paths of the keys.
        keys: Vec<String>,
    },
    /// Neither a scene nor a type has an example of a key.
    #[error("{solver}: {} without an example: {}", .keys.len(), .keys.join(", "))]
    #[diagnostic(help("give a scene that has them, or `#[schemars(example = ...)]` to the type"))]
    NoExample {
        /// Scene kind.
        solver: &'static str,
        /// Types and paths of the keys.
        keys: Vec<String>,
    },
    /// A scene or an example violates its schema.
    #[error("{source_of_it} does not fit the schema at `{place}`: {value}")]
    Misfit {
        /// The scene, or the type of the example.
        source_of_it: String,
        /// Type and key.
        place: String,
        /// The value.
        value: String,
    },
    /// A built-in scene cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The folder of scenes cannot be read.
    #[error("cannot list the scenes in {}", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Error of the file system.
        source: io::Error,
    },
    /// A schema contains a number that is not finite.
    #[error(transparent)]
    Json(#[from] JsonError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The paths of the written files could not be printed.
    #[error("cannot print")]
    Print(#[source] io::Error),
}
