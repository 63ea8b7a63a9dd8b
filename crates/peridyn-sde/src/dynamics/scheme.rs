//! How displacements follow from forces, and by which steps.

use crate::error::{Error, from_to, not_negative, positive};
use crate::mobility::Mobility;

/// What moves the nodes.
#[derive(Debug, Clone)]
pub enum Dynamics {
    /// Overdamped Langevin dynamics with the mobility `M` (length over time and force), constant in `u`, on free nodes:
    ///
    /// $$ du = -M \nabla V dt + \sqrt{2 kT} L dB, \qquad M = L L^T . $$
    ///
    /// Its stationary law, where there is one, is `exp(-V/kT)` for any positive definite `M`. At `kT = 0` it is the gradient
    /// flow.
    Overdamped {
        /// `M`.
        mobility: Mobility,
        /// `kT` (energy).
        temperature: f64,
        /// By which steps.
        scheme: Scheme,
    },
    /// Newton's equations with friction and noise, by the splitting BAOAB (Leimkuhler & Matthews 2013):
    ///
    /// $$ m dv = -\nabla V dt - \gamma m v dt + \sqrt{2 kT \gamma m} dB, \qquad m_i = \rho V_i . $$
    ///
    /// The friction matrix is `gamma m`, diagonal and in proportion to mass. Without friction it is velocity Verlet. Friction
    /// near the lowest frequency of the body and no noise find its equilibrium in `O(n)` steps.
    Inertial {
        /// `rho` (mass over volume).
        density: f64,
        /// `gamma` (1/time).
        friction: f64,
        /// `kT` (energy).
        temperature: f64,
    },
}

/// One step of overdamped dynamics. With `z = h M lambda`, `lambda` a stiffness of the body, the variance of its mode errs by the
/// factor stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scheme {
    /// Euler and Maruyama's: stable for `z < 2`, variance `1/(1 - z/2)`.
    EulerMaruyama,
    /// Leimkuhler and Matthews': the noise averaged over two steps. Stable for `z < 2`, variance exact for linear forces. Its steps
    /// are not those of the path, so that it must not be asked what happened between them.
    LeimkuhlerMatthews,
    /// Heun's, two force evaluations: stable for `z < 2`, variance `(2 - z)/(2 - z + z^2/2)`; second order over time.
    Heun,
    /// Linearly implicit with the stiffness `K` of the bonds at rest that are whole,
    ///
    /// $$ (1 + \theta h M K) (u_{n+1} - u_n) = h M F(u_n) + \sqrt{2 kT} L w, $$
    ///
    /// by conjugate gradients. With `theta = 1/2` the variance is exact for linear forces, and two times of a path have their law
    /// to second order in `h`; stable for any step where `theta >= 1/2`.
    Theta(f64),
}

impl Scheme {
    /// The largest stable `z`, infinite if there is none.
    #[must_use]
    pub fn stability_limit(self) -> f64 {
        match self {
            Self::Theta(theta) if theta >= 0.5 => f64::INFINITY,
            Self::Theta(theta) => 2.0 / (1.0 - 2.0 * theta),
            _ => 2.0,
        }
    }

    /// What the variance of a mode is over `kT/lambda`.
    #[must_use]
    pub fn variance_factor(self, z: f64) -> f64 {
        match self {
            Self::EulerMaruyama => 1.0 / (1.0 - 0.5 * z),
            Self::LeimkuhlerMatthews => 1.0,
            Self::Heun => (2.0 - z) / (2.0 - z + 0.5 * z * z),
            // (1 + theta z)^2 sigma^2 = (1 - (1 - theta) z)^2 sigma^2 + 2 z
            Self::Theta(theta) => 2.0 / (2.0 + (2.0 * theta - 1.0) * z),
        }
    }

    /// Its name, for tables.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::EulerMaruyama => "Euler-Maruyama".into(),
            Self::LeimkuhlerMatthews => "Leimkuhler-Matthews".into(),
            Self::Heun => "Heun".into(),
            Self::Theta(theta) => format!("theta {theta}"),
        }
    }
}

impl Dynamics {
    /// `kT` (energy).
    #[must_use]
    pub fn temperature(&self) -> f64 {
        match self {
            Self::Overdamped { temperature, .. } | Self::Inertial { temperature, .. } => {
                *temperature
            }
        }
    }

    /// Whether the ends of its steps are points of one diffusive path.
    pub(crate) fn has_path(&self) -> bool {
        match self {
            Self::Overdamped { scheme, .. } => *scheme != Scheme::LeimkuhlerMatthews,
            Self::Inertial { .. } => false,
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        not_negative("temperature", self.temperature())?;
        match self {
            Self::Overdamped { scheme: Scheme::Theta(theta), .. } => {
                from_to("theta", *theta, 0.0, 1.0)
            }
            Self::Overdamped { .. } => Ok(()),
            Self::Inertial { density, friction, .. } => {
                positive("density", *density)?;
                not_negative("friction", *friction)
            }
        }
    }
}
