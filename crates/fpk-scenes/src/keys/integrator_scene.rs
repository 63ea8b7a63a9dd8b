//! Path integrators: one for each system.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Integrator of a path. Each system has one, the best that was measured on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum IntegratorScene {
    /// Forward Euler, for noise that depends on the state.
    EulerMaruyama,
    /// Strang splitting with exact rotation and exact damper flow.
    StrangOscillator,
    /// The same for the hysteretic oscillator.
    StrangBoucWen,
    /// Two drift evaluations, strong order 1.5, for any system with additive noise.
    Shark,
}

impl IntegratorScene {
    /// Name for output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::EulerMaruyama => "forward Euler",
            Self::StrangOscillator => "Strang",
            Self::StrangBoucWen => "Strang with hysteresis",
            Self::Shark => "ShARK",
        }
    }
}
