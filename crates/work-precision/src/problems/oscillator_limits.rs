//! The largest stable step of a linear oscillator, by formula and by the spectral radius of one step.

use sde_integrators::{
    EulerMaruyama, Heun, Integrator, SemiImplicitEuler, Shark, StateSpace, StepError,
};

use reference_problems::context::CaseError;
use reference_problems::sde::linear::probe;
use reference_problems::sde::problems::Oscillator;

/// A method with a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limited {
    /// Forward Euler.
    EulerMaruyama,
    /// Semi-implicit Euler.
    SemiImplicitEuler,
    /// Heun.
    Heun,
    /// ShARK.
    Shark,
}

/// All of them, with their names.
pub const METHODS: &[(&str, Limited)] = &[
    ("Euler-Maruyama", Limited::EulerMaruyama),
    ("semi-implicit Euler", Limited::SemiImplicitEuler),
    ("Heun", Limited::Heun),
    ("ShARK", Limited::Shark),
];

/// The limit of `h omega` by formula, for `xi < 1`.
#[must_use]
pub fn formula(method: Limited, xi: f64) -> f64 {
    match method {
        Limited::EulerMaruyama => 2.0 * xi,
        Limited::SemiImplicitEuler => 2.0 * (f64::hypot(1.0, xi) - xi),
        Limited::Heun | Limited::Shark => explicit_second_order(xi),
    }
}

/// The limit of the code.
///
/// # Errors
/// The first step that fails, or a method without a limit.
pub fn measured(method: Limited, xi: f64) -> Result<f64, CaseError> {
    match method {
        Limited::EulerMaruyama => edge(xi, &EulerMaruyama),
        Limited::SemiImplicitEuler => edge(xi, &SemiImplicitEuler),
        Limited::Heun => edge(xi, &Heun),
        Limited::Shark => edge(xi, &Shark),
    }
}

/// The first angle at which the spectral radius exceeds 1, sought in factors of 1.02 and bisected.
fn edge<I>(xi: f64, method: &I) -> Result<f64, CaseError>
where
    I: Integrator<StateSpace<Oscillator>, 2, 1>,
{
    let radius = |angle: f64| -> Result<f64, StepError> {
        let system = Oscillator { frequency: 2.0, damping_ratio: xi, intensity: 0.7 };
        let nothing = |_: &[f64; 2], _: &I::Memory| [0.0; 0];
        let (map, _) = probe(&StateSpace(system), method, angle / system.frequency, nothing)?;
        Ok(map.spectral_radius())
    };
    let mut above = 1e-3;
    while radius(above)? <= 1.0 {
        above *= 1.02;
        if above > 1e3 {
            return Err("no limit of stability below h omega = 1000".into());
        }
    }
    let mut below = above / 1.02;
    for _ in 0..40 {
        let middle = 0.5 * (below + above);
        if radius(middle)? <= 1.0 { below = middle } else { above = middle }
    }
    Ok(below)
}

/// `|1 + z + z^2/2| = 1` at the eigenvalue `z = h omega (-xi + i sqrt(1 - xi^2))` of the oscillator, by bisection.
fn explicit_second_order(xi: f64) -> f64 {
    let amplification = |angle: f64| {
        let (x, y) = (-xi * angle, (1.0 - xi * xi).max(0.0).sqrt() * angle);
        f64::hypot(1.0 + x + 0.5 * (x * x - y * y), y + x * y)
    };
    let mut above = 1e-3;
    while amplification(above) <= 1.0 {
        above *= 1.02;
    }
    let mut below = above / 1.02;
    for _ in 0..60 {
        let middle = 0.5 * (below + above);
        if amplification(middle) <= 1.0 { below = middle } else { above = middle }
    }
    below
}
