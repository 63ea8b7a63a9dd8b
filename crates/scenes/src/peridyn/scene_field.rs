//! What varies from place to place in a scene of cracks.

use peridyn_sde::{BondValue, Correlation, CorrelationFunction, Marginal};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::named::named;

/// How the critical stretch or the stiffness varies.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VariationScene {
    /// Not at all.
    #[default]
    Uniform,
    /// As a random field with the value of the material as mean, another one in each realisation.
    Field(FieldScene),
    /// As the file of the points says, the same in each realisation: the value of the material times the column `strength_factor`,
    /// or `stiffness_factor`.
    Column(ColumnScene),
}

impl VariationScene {
    pub(super) const COLUMN: Self =
        Self::Column(ColumnScene { between_nodes: BetweenScene::Minimum });

    /// Whether nothing varies.
    #[must_use]
    pub const fn is_uniform(&self) -> bool {
        matches!(self, Self::Uniform)
    }
}

/// Factors from the file of the points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColumnScene {
    /// How bonds have them from their nodes.
    #[serde(default)]
    pub between_nodes: BetweenScene,
}

/// A random field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldScene {
    /// The law at one place.
    pub marginal: MarginalScene,
    /// Correlation of the normal field behind it.
    pub correlation: CorrelationScene,
    /// How bonds have it from their nodes.
    #[serde(default)]
    pub between_nodes: BetweenScene,
}

/// The law of a strength or a stiffness at one place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Weibull { shape: 10.0 })]
#[schemars(example = Self::Normal { coefficient_of_variation: 0.1 })]
pub enum MarginalScene {
    /// The logarithm is normal.
    Lognormal {
        /// Standard deviation over mean (no unit).
        coefficient_of_variation: f64,
    },
    /// Weibull's law, that of the weakest of many.
    Weibull {
        /// Weibull's modulus (no unit).
        shape: f64,
    },
    /// Normal; its deviation is at most 1/7.9 of the mean.
    Normal {
        /// Standard deviation over mean (no unit).
        coefficient_of_variation: f64,
    },
}

impl MarginalScene {
    /// The law of a mean.
    #[must_use]
    pub fn of(self, mean: f64) -> Marginal {
        match self {
            Self::Lognormal { coefficient_of_variation } => {
                Marginal::Lognormal { mean, coefficient_of_variation }
            }
            Self::Weibull { shape } => Marginal::Weibull { mean, shape },
            Self::Normal { coefficient_of_variation } => {
                let standard_deviation = coefficient_of_variation * mean;
                Marginal::Normal { mean, standard_deviation }
            }
        }
    }

    /// Its key and that of its parameter.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Lognormal { .. } => "lognormal.coefficient_of_variation",
            Self::Weibull { .. } => "weibull.shape",
            Self::Normal { .. } => "normal.coefficient_of_variation",
        }
    }
}

/// A correlation with its length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrelationScene {
    /// How it falls with the distance `r`.
    #[serde(default)]
    pub function: FunctionScene,
    /// The integral scale (m).
    pub length: f64,
}

impl CorrelationScene {
    pub(super) const SHORT: Self = Self { function: FunctionScene::Matern32, length: 0.003 };
}

impl From<CorrelationScene> for Correlation {
    fn from(scene: CorrelationScene) -> Self {
        Self { function: scene.function.into(), length: scene.length }
    }
}

named! {
    /// Correlation functions of the distance `r`, with the length `l`.
    FunctionScene => CorrelationFunction {
        /// `exp(-r/l)`.
        Exponential,
        /// `exp(-pi r^2/(4 l^2))`.
        Gaussian,
        /// `(1 + 2 r/l) exp(-2 r/l)`.
        #[default]
        Matern32,
        /// Zero beyond three lengths.
        WendlandC2,
    }
}

named! {
    /// The value of a bond from those of its nodes.
    BetweenScene => BondValue {
        /// The smaller one.
        Minimum,
        /// Half of both.
        #[default]
        Mean,
    }
}
