//! Time integration scheme of a scene, and the systems to which it applies.

use fpk_sph::Scheme;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::law_scene::LawScene;
use super::paths::Paths;
use super::system::{System, Visitor};
use crate::scene::Objection;

/// Time integration scheme, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SchemeScene {
    /// One stage, order 1.
    ForwardEuler,
    /// Two steps, one stage, order 2; for systems without noise and damping.
    LeapFrog,
    /// Two stages, order 2.
    Heun,
    /// Four stages, order 4.
    #[serde(rename = "runge_kutta_4")]
    RungeKutta4,
    /// Four stages, order 4; the linear part of the drift is solved exactly.
    #[serde(rename = "lawson_runge_kutta_4")]
    LawsonRungeKutta4,
    /// Two steps, one stage, order 2; the linear part of the drift is solved exactly.
    #[serde(rename = "lawson_adams_bashforth_2")]
    LawsonAdamsBashforth2,
    /// As many stages as the diffusion needs, 2 to 20, order 2; for fine lattices.
    RungeKuttaChebyshev,
}

impl SchemeScene {
    /// The scheme of the solver.
    #[must_use]
    pub fn scheme(self) -> Scheme {
        match self {
            Self::ForwardEuler => Scheme::ForwardEuler,
            Self::LeapFrog => Scheme::LeapFrog,
            Self::Heun => Scheme::Heun,
            Self::RungeKutta4 => Scheme::RungeKutta4,
            Self::LawsonRungeKutta4 => Scheme::LawsonRungeKutta4,
            Self::LawsonAdamsBashforth2 => Scheme::LawsonAdamsBashforth2,
            Self::RungeKuttaChebyshev => Scheme::RungeKuttaChebyshev,
        }
    }

    /// Rejects a scheme in Lawson's form for a system without a declared linear part, and leap-frog where noise or damping
    /// make its parasitic solution grow; `path` is that of the key.
    pub(super) fn check(
        self,
        path: &str,
        system: &System,
        initial: &LawScene,
        times: &[f64],
    ) -> Result<(), Objection> {
        if self.scheme().needs_linear_part() && !system.visit(HasLinearPart) {
            let message = "the scheme solves the linear part of the drift exactly, and this system declares none";
            return Err(Objection::new(path, message).with_help(
                "available: forward_euler, heun, runge_kutta_4, runge_kutta_chebyshev",
            ));
        }
        if self != Self::LeapFrog {
            return Ok(());
        }
        let filter = system.filter_covariance();
        let Some(found) = system.visit(Damping { initial, filter: filter.as_deref(), times })
        else {
            return Ok(());
        };
        let message = format!("leap_frog does not serve this system, which has {found}");
        Err(Objection::new(path, message).with_help(
            "with noise or damping leap_frog is stable at no step; available: forward_euler, heun, runge_kutta_4, lawson_runge_kutta_4, \
             lawson_adams_bashforth_2, runge_kutta_chebyshev",
        ))
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

/// Damping or noise of a system, evaluated at the mean of the initial distribution and one standard deviation from it.
struct Damping<'a> {
    initial: &'a LawScene,
    filter: Option<&'a [Vec<f64>]>,
    times: &'a [f64],
}

impl Visitor for Damping<'_> {
    type Output = Option<&'static str>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Self::Output {
        // An invalid distribution has been rejected before.
        let law = self.initial.build::<D>(self.filter).ok()?;
        let (mean, covariance) = (law.mean(), law.covariance());
        let deviation: [f64; D] = std::array::from_fn(|k| covariance[k][k].sqrt());
        let beside: [f64; D] = std::array::from_fn(|k| mean[k] + deviation[k]);
        let places = || {
            let times = std::iter::once(&0.0).chain(self.times);
            times.flat_map(|&t| [(t, mean), (t, beside)])
        };
        let noisy = |(t, x)| system.noise(t, &x).iter().flatten().any(|&g| g != 0.0);
        let damped = |(t, x)| {
            let (divergence, scale) = divergence(system, t, &x, &deviation);
            // Roundoff of a difference over this step is 1e-12 of the scale.
            divergence.abs() > 1e-9 * scale
        };
        if places().any(noisy) { Some("noise") } else { places().any(damped).then_some("damping") }
    }
}

/// Step of the differences, in standard deviations.
const STEP: f64 = 1e-3;

/// `div f` by central differences, and the magnitude of its terms.
///
/// The magnitude of `f` over the deviations bounds the roundoff.
fn divergence<S: Paths<D, M>, const D: usize, const M: usize>(
    system: &S,
    t: f64,
    x: &[f64; D],
    deviation: &[f64; D],
) -> (f64, f64) {
    let (mut sum, mut scale) = (0.0, f64::MIN_POSITIVE);
    for k in 0..D {
        let step = STEP * deviation[k];
        let at = |sign: f64| {
            let mut moved = *x;
            moved[k] += sign * step;
            system.drift(t, &moved)[k]
        };
        let (above, below) = (at(1.0), at(-1.0));
        sum += (above - below) / (2.0 * step);
        scale += (above.abs() + below.abs()) / deviation[k];
    }
    (sum, scale)
}
