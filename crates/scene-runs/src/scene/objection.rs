//! Objections of a check to a value of a scene.

/// An invalid value and its location.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message} (at `{path}`)")]
pub struct Objection {
    /// The key, e.g. `system.viscous_damper.intensity` or `times[3]`.
    pub path: String,
    /// Description, e.g. `the intensity is -0.2 m^2/s^3 and must not be negative`.
    pub message: String,
    /// Remedy, if known.
    pub help: Option<String>,
}

impl Objection {
    /// An objection to the value at `path`.
    #[must_use]
    pub fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self { path: path.into(), message: message.into(), help: None }
    }

    /// Adds a hint, e.g. `did you mean ...?`.
    #[must_use]
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}
