//! How the nodes of a scene of cracks move.

use peridyn_sde::{
    Breaking, CompactMobility, CorrelatedMobility, Dynamics, Error, Mobility, Nodes, Scheme,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::positive::positive;
use super::scene_field::CorrelationScene;
use crate::scene::Objection;

/// Dynamics.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DynamicsScene {
    /// `du = -M grad V dt + sqrt(2 kT) L dB`, `M = L L^T`.
    Overdamped {
        /// `M`, the mobility of the nodes.
        mobility: MobilityScene,
        /// `kT`, the intensity of the noise.
        temperature: TemperatureScene,
        /// By which steps.
        scheme: SchemeScene,
    },
    /// Newton's equations with friction and noise; the material needs a density.
    Inertial {
        /// Rate at which velocities decay (1/s). Near the lowest frequency of the body, `pi/H sqrt(E/rho)`, it finds rest soonest.
        friction: f64,
        /// `kT`, the intensity of the noise.
        temperature: TemperatureScene,
    },
}

/// The intensity of noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Joule(1e-9))]
pub enum TemperatureScene {
    /// No noise.
    Zero,
    /// `kT` itself (J).
    Joule(f64),
    /// The critical stretch over the standard deviation that noise gives the stretch of a shortest bond; 8 and more leave the
    /// body whole (no unit).
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

/// Schemes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Theta(0.5))]
pub enum SchemeScene {
    /// One evaluation, biased at large steps.
    EulerMaruyama,
    /// One evaluation; equilibrium without bias, no bridges.
    LeimkuhlerMatthews,
    /// Two evaluations.
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

/// Mobilities. `value` (m/(N s)) is the unit of time alone where the step is given by `z` and the load by a strain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Dense { value: 1.0, correlation: CorrelationScene::SHORT, nugget: 0.1 })]
#[schemars(example = Self::LowRank { value: 1.0, correlation: CorrelationScene::SHORT, nugget: 0.1, tolerance: 0.01 })]
#[schemars(example = Self::Compact { value: 1.0, length: 0.003, nugget: 0.1 })]
pub enum MobilityScene {
    /// Every node for itself.
    Identity {
        /// Of a node (m/(N s)).
        value: f64,
    },
    /// Correlated, by a full factor: some thousand nodes at most.
    Dense {
        /// Of a node (m/(N s)).
        value: f64,
        /// Correlation between nodes.
        correlation: CorrelationScene,
        /// What each node has of its own, as a part of what it shares (no unit).
        nugget: f64,
    },
    /// Correlated over many spacings, by a factor of few columns.
    LowRank {
        /// Of a node (m/(N s)).
        value: f64,
        /// Correlation between nodes.
        correlation: CorrelationScene,
        /// What each node has of its own, as a part of what it shares, greater than zero (no unit).
        nugget: f64,
        /// Part of the trace that is left out (no unit).
        tolerance: f64,
    },
    /// Correlated over a few spacings, by an average of noise.
    Compact {
        /// Of a node (m/(N s)).
        value: f64,
        /// The integral scale of the correlation, which is Gaussian (m).
        length: f64,
        /// What each node has of its own, as a part of what it shares, greater than zero (no unit).
        nugget: f64,
    },
}

/// Steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeScene {
    /// How long one is.
    pub step: StepScene,
    /// How many (no unit).
    pub steps: u64,
    /// When bonds are looked after.
    #[serde(default)]
    #[schemars(example = BreakingScene::Bridge)]
    pub breaking: BreakingScene,
    /// Stiffness of a spring that holds each free node where it was (N/m).
    #[serde(default)]
    #[schemars(example = 1e3)]
    pub confinement: f64,
}

/// The length of a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(example = Self::Dt(1e-7))]
pub enum StepScene {
    /// By the stiffest mode of the body: `dt M lambda`, in inertial dynamics `dt omega` (no unit). Explicit schemes are stable below 2.
    Z(f64),
    /// The time itself (s).
    Dt(f64),
}

/// When bonds are looked after.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BreakingScene {
    /// At the ends of steps.
    #[default]
    AtEnds,
    /// Between them as well.
    Bridge,
}

impl From<BreakingScene> for Breaking {
    fn from(scene: BreakingScene) -> Self {
        match scene {
            BreakingScene::AtEnds => Self::AtEnds,
            BreakingScene::Bridge => Self::Bridge,
        }
    }
}

impl DynamicsScene {
    /// Where the kind of dynamics stands.
    #[must_use]
    pub const fn path(&self) -> &'static str {
        match self {
            Self::Overdamped { .. } => "dynamics.overdamped",
            Self::Inertial { .. } => "dynamics.inertial",
        }
    }

    /// Its temperature as it was given.
    #[must_use]
    pub const fn temperature(&self) -> TemperatureScene {
        match self {
            Self::Overdamped { temperature, .. } | Self::Inertial { temperature, .. } => {
                *temperature
            }
        }
    }

    /// `kT` (J), with that of a ratio of one.
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

    /// The dynamics of nodes of which some are free.
    ///
    /// # Errors
    /// An [`Objection`] to a mobility that is not positive definite, and to inertia without density.
    pub fn build(
        &self,
        nodes: &Nodes<2>,
        free: &[bool],
        temperature: f64,
        density: Option<f64>,
    ) -> Result<Dynamics, Objection> {
        match self {
            Self::Overdamped { mobility, scheme, .. } => {
                let mobility = mobility.build(nodes, free)?;
                Ok(Dynamics::Overdamped { mobility, temperature, scheme: (*scheme).into() })
            }
            Self::Inertial { friction, .. } => {
                let Some(density) = density else {
                    let message = "inertial dynamics need the density of the material";
                    return Err(Objection::new("material", message));
                };
                positive("material.density", "the density", density)?;
                if !(friction.is_finite() && *friction >= 0.0) {
                    let message = format!("the friction is {friction}/s; it must not be negative");
                    return Err(Objection::new("dynamics.inertial.friction", message));
                }
                Ok(Dynamics::Inertial { density, friction: *friction, temperature })
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
            Self::Compact { value, length, nugget } => {
                let support = 2.0 * length;
                let config = CompactMobility { mobility: value, length, support, nugget };
                ("compact", Mobility::compact(positions, free, &config))
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
                Error::NotPositive { name: "nugget", .. }
                | Error::OutOfRange { name: "nugget", .. } => {
                    Objection::new(format!("{at}.nugget"), error.to_string())
                }
                Error::NotPositive { name: "mobility", .. } => {
                    Objection::new(format!("{at}.value"), error.to_string())
                }
                _ => Objection::new(at, error.to_string()),
            }
        })
    }
}
