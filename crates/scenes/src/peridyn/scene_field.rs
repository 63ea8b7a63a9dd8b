//! Spatial variation in a crack scene.

use peridyn_sde::BondValue;
use random_fields::{Correlation, CorrelationFunction, Marginal};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::named::named;

/// Spatial variation of the critical stretch or the stiffness.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VariationScene {
    /// Uniform.
    #[default]
    Uniform,
    /// A random field whose mean is the value of the material; another field in each realisation.
    Field(FieldScene),
    /// From the file of points, the same in each realisation.
    ///
    /// The value is that of the material times the column `strength_factor`, or `stiffness_factor`.
    Column(ColumnScene),
}

impl VariationScene {
    pub(super) const COLUMN: Self =
        Self::Column(ColumnScene { between_nodes: BetweenScene::Minimum });

    /// Whether the value is uniform.
    #[must_use]
    pub const fn is_uniform(&self) -> bool {
        matches!(self, Self::Uniform)
    }
}

/// Factors from the file of points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColumnScene {
    /// Value of a bond from the values of its nodes.
    #[serde(default)]
    pub between_nodes: BetweenScene,
}

/// A random field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldScene {
    /// Marginal distribution at one point.
    pub marginal: MarginalScene,
    /// Correlation of the underlying normal field.
    pub correlation: CorrelationScene,
    /// Value of a bond from the values of its nodes.
    #[serde(default)]
    pub between_nodes: BetweenScene,
}

/// Marginal distribution of a strength or a stiffness at one point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Weibull { shape: 10.0 })]
#[schemars(example = Self::Normal { coefficient_of_variation: 0.1 })]
pub enum MarginalScene {
    /// Lognormal.
    Lognormal {
        /// Coefficient of variation (no unit).
        coefficient_of_variation: f64,
    },
    /// Weibull distribution, that of the weakest of many.
    Weibull {
        /// Weibull modulus (no unit).
        shape: f64,
    },
    /// Normal; its deviation is at most 1/7.9 of the mean.
    Normal {
        /// Coefficient of variation (no unit).
        coefficient_of_variation: f64,
    },
}

impl MarginalScene {
    /// The distribution with a mean.
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
    /// Correlation function of the distance `r`.
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
    /// Value of a bond from the values of its nodes.
    BetweenScene => BondValue {
        /// The smaller value.
        Minimum,
        /// The mean of both values.
        #[default]
        Mean,
    }
}
