//! Time integration scheme of a scene, and the systems to which it applies.

use fpk_sph::Scheme;
use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::paths::Paths;
use crate::system::{System, Visitor};

/// Time integration scheme, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SchemeScene {
    /// Four stages, order 4.
    #[serde(rename = "runge_kutta_4")]
    RungeKutta4,
    /// Two steps, one stage, order 2; the linear part of the drift is solved exactly.
    #[serde(rename = "lawson_adams_bashforth_2")]
    LawsonAdamsBashforth2,
}

impl SchemeScene {
    /// The scheme of the solver.
    #[must_use]
    pub const fn scheme(self) -> Scheme {
        match self {
            Self::RungeKutta4 => Scheme::RungeKutta4,
            Self::LawsonAdamsBashforth2 => Scheme::LawsonAdamsBashforth2,
        }
    }

    /// Rejects a scheme in Lawson's form for a system without a declared linear part; `path` is that of the key.
    pub(crate) fn check(self, path: &str, system: &System) -> Result<(), Objection> {
        if !self.scheme().needs_linear_part() || system.visit(HasLinearPart) {
            return Ok(());
        }
        let message =
            "the scheme solves the linear part of the drift exactly, and this system declares none";
        Err(Objection::new(path, message).with_help("use runge_kutta_4"))
    }
}

/// Whether a system declares the linear part of its drift.
struct HasLinearPart;

impl Visitor for HasLinearPart {
    type Output = bool;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> bool {
        system.linear_part().is_some()
    }
}
