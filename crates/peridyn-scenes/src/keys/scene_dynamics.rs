//! Dynamics of the nodes of a crack scene.

use peridyn_sde::{Breaking, CorrelatedMobility, Dynamics, Error, Mobility, Nodes, Scheme};
use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::named::named;
use super::positive::positive;
use super::scene_field::CorrelationScene;

/// The equations of motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DynamicsScene {
    /// `du = -M grad V dt + sqrt(2 kT) L dB`, `M = L L^T`.
    Overdamped {
        /// `M`, the mobility of the nodes.
        mobility: MobilityScene,
        /// `kT`, the intensity of the noise.
        temperature: TemperatureScene,
        /// Time integration scheme.
        scheme: SchemeScene,
    },
    /// Newton's equations with friction and noise; they require a density of the material.
    Inertial {
        /// Decay rate of velocities (1/s).
        ///
        /// Near the lowest frequency of the body, `pi/H sqrt(E/rho)`, it reaches equilibrium fastest.
        friction: f64,
        /// `kT`, the intensity of the noise.
        temperature: TemperatureScene,
    },
    /// Equilibrium after equilibrium while the load grows slowly, as in a laboratory; small strains, no noise.
    ///
    /// Bonds fail one after the other, each at the load at which it is at its strength. Loads are those of a test that prescribes
    /// the displacement.
    QuasiStatic {
        /// Bonds that fail together: those within this part of the stretch over strength of the most critical one; 0 for one at a
        /// time (no unit).
        #[serde(default)]
        #[schemars(example = 0.02)]
        batch: f64,
        /// Residual force over reaction at which an equilibrium counts as reached (no unit).
        #[serde(default = "tolerance")]
        #[schemars(example = 1e-8)]
        tolerance: f64,
    },
}

/// Default tolerance of an equilibrium.
const fn tolerance() -> f64 {
    1e-6
}

/// The intensity of noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Joule(1e-9))]
pub enum TemperatureScene {
    /// No noise.
    Zero,
    /// `kT` in joule (J).
    Joule(f64),
    /// Ratio of the critical stretch to the standard deviation of the bond stretch by noise (no unit).
    ///
    /// The deviation is that of a shortest bond. For 8 and more no bond breaks by noise.
    Ratio(f64),
}

impl TemperatureScene {
    const fn key(self) -> &'static str {
        match self {
            Self::Zero => "temperature",
            Self::Joule(_) => "temperature.joule",
            Self::Ratio(_) => "temperature.ratio",
        }
    }
}

/// Time integration schemes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Theta(0.5))]
pub enum SchemeScene {
    /// One force evaluation, biased at large steps.
    EulerMaruyama,
    /// One force evaluation; unbiased equilibrium, no bridge check.
    LeimkuhlerMatthews,
    /// Two force evaluations.
    Heun,
    /// Linearly implicit, with this theta (no unit).
    Theta(f64),
}

impl From<SchemeScene> for Scheme {
    fn from(scene: SchemeScene) -> Self {
        match scene {
            SchemeScene::EulerMaruyama => Self::EulerMaruyama,
            SchemeScene::LeimkuhlerMatthews => Self::LeimkuhlerMatthews,
            SchemeScene::Heun => Self::Heun,
            SchemeScene::Theta(theta) => Self::Theta(theta),
        }
    }
}

/// Mobilities. Where the step is given by `z` and the load by a strain, `value` (m/(N s)) sets only the unit of time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Dense { value: 1.0, correlation: CorrelationScene::SHORT, nugget: 0.1 })]
#[schemars(example = Self::LowRank { value: 1.0, correlation: CorrelationScene::SHORT, nugget: 0.1, tolerance: 0.01 })]
pub enum MobilityScene {
    /// Independent nodes.
    Identity {
        /// Mobility of a node (m/(N s)).
        value: f64,
    },
    /// Correlated, by a full factor: at most some thousand nodes.
    Dense {
        /// Mobility of a node (m/(N s)).
        value: f64,
        /// Correlation between nodes.
        correlation: CorrelationScene,
        /// Independent part of each node, as a fraction of the correlated part (no unit).
        nugget: f64,
    },
    /// Correlated, by a factor with few columns.
    LowRank {
        /// Mobility of a node (m/(N s)).
        value: f64,
        /// Correlation between nodes.
        correlation: CorrelationScene,
        /// Independent part of each node, as a fraction of the correlated part, greater than zero (no unit).
        nugget: f64,
        /// Fraction of the trace that is omitted (no unit).
        tolerance: f64,
    },
}

/// Time steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeScene {
    /// Length of a step.
    pub step: StepScene,
    /// Number of steps (no unit).
    pub steps: u64,
    /// When bond failure is checked.
    #[serde(default)]
    #[schemars(example = BreakingScene::Bridge)]
    pub breaking: BreakingScene,
    /// Stiffness of a spring that ties each free node to its initial position (N/m).
    #[serde(default)]
    #[schemars(example = 1e3)]
    pub confinement: f64,
}

/// Length of a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Dt(1e-7))]
pub enum StepScene {
    /// In units of the stiffest mode of the body: `dt M lambda`, in inertial dynamics `dt omega` (no unit).
    ///
    /// Explicit schemes are stable below 2.
    Z(f64),
    /// Length in seconds (s).
    Dt(f64),
}

named! {
    /// When bond failure is checked.
    BreakingScene => Breaking {
        /// At the ends of steps.
        #[default]
        AtEnds,
        /// At the ends of steps and between them.
        Bridge,
    }
}

impl DynamicsScene {
    /// The key of the kind of dynamics.
    #[must_use]
    pub const fn path(&self) -> &'static str {
        match self {
            Self::Overdamped { .. } => "dynamics.overdamped",
            Self::Inertial { .. } => "dynamics.inertial",
            Self::QuasiStatic { .. } => "dynamics.quasi_static",
        }
    }

    /// The temperature as given in the scene.
    #[must_use]
    pub const fn temperature(&self) -> TemperatureScene {
        match self {
            Self::Overdamped { temperature, .. } | Self::Inertial { temperature, .. } => {
                *temperature
            }
            Self::QuasiStatic { .. } => TemperatureScene::Zero,
        }
    }

    /// `kT` (J); `of_ratio_one` is that of a ratio of one.
    ///
    /// # Errors
    /// An [`Objection`] to a temperature that is negative or a ratio that is not positive.
    pub fn joule(&self, of_ratio_one: f64) -> Result<f64, Objection> {
        let given = self.temperature();
        let path = format!("{}.{}", self.path(), given.key());
        match given {
            TemperatureScene::Zero => Ok(0.0),
            TemperatureScene::Joule(value) if value >= 0.0 => Ok(value),
            TemperatureScene::Joule(value) => {
                let message = format!("kT is {value} J; it must not be negative");
                Err(Objection::new(path, message))
            }
            TemperatureScene::Ratio(ratio) => {
                positive(&path, "the ratio of critical stretch to noise", ratio)?;
                Ok(of_ratio_one / (ratio * ratio))
            }
        }
    }

    /// The dynamics of nodes, some of which are free; none under a quasi-static load.
    ///
    /// # Errors
    /// An [`Objection`] to a mobility that is not positive definite, and to inertia without a density.
    pub fn build(
        &self,
        nodes: &Nodes<2>,
        free: &[bool],
        temperature: f64,
        density: Option<f64>,
    ) -> Result<Option<Dynamics>, Objection> {
        match self {
            Self::QuasiStatic { .. } => Ok(None),
            Self::Overdamped { mobility, scheme, .. } => {
                let mobility = mobility.build(nodes, free)?;
                Ok(Some(Dynamics::Overdamped { mobility, temperature, scheme: (*scheme).into() }))
            }
            Self::Inertial { friction, .. } => {
                let Some(density) = density else {
                    let message = "inertial dynamics require the density of the material";
                    return Err(Objection::new("material", message));
                };
                positive("material.density", "the density", density)?;
                if !(friction.is_finite() && *friction >= 0.0) {
                    let message = format!("the friction is {friction}/s; it must not be negative");
                    return Err(Objection::new("dynamics.inertial.friction", message));
                }
                Ok(Some(Dynamics::Inertial { density, friction: *friction, temperature }))
            }
        }
    }
}

impl MobilityScene {
    fn build(self, nodes: &Nodes<2>, free: &[bool]) -> Result<Mobility, Objection> {
        let positions = nodes.positions();
        let correlated = |mobility, correlation: CorrelationScene, nugget| CorrelatedMobility {
            mobility,
            correlation: correlation.into(),
            nugget,
        };
        let (kind, made) = match self {
            Self::Identity { value } => ("identity", Mobility::identity(free, value)),
            Self::Dense { value, correlation, nugget } => {
                let config = correlated(value, correlation, nugget);
                ("dense", Mobility::dense(positions, free, &config))
            }
            Self::LowRank { value, correlation, nugget, tolerance } => {
                let config = correlated(value, correlation, nugget);
                ("low_rank", Mobility::low_rank(positions, free, &config, tolerance))
            }
        };
        made.map_err(|error| {
            let at = format!("dynamics.overdamped.mobility.{kind}");
            match error {
                Error::NotPositiveDefinite { .. } => {
                    let message = format!("the mobility is not positive definite: {error}");
                    Objection::new(format!("{at}.nugget"), message).with_help(
                        "a smooth correlation needs a nugget: 0.1 is usual, 0.01 the least",
                    )
                }
                Error::Parameter { name: "nugget", .. } => {
                    Objection::new(format!("{at}.nugget"), error.to_string())
                }
                Error::Parameter { name: "mobility", .. } => {
                    Objection::new(format!("{at}.value"), error.to_string())
                }
                _ => Objection::new(at, error.to_string()),
            }
        })
    }
}
