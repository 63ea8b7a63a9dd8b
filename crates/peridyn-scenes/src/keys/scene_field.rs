//! Spatial variation in a crack scene.

use peridyn_sde::{BondValue, StrengthElement, WeibullByVolume};
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
    /// Independent Weibull strengths that scale with volume: the strength of a body follows from its volume, not from the mesh.
    ///
    /// The value of the material is the scale of bodies of the reference volume: 63.2 % of them are weaker.
    WeibullByVolume(WeibullByVolumeScene),
}

impl VariationScene {
    pub(crate) const COLUMN: Self =
        Self::Column(ColumnScene { between_nodes: BetweenScene::Minimum });

    pub(crate) const BY_VOLUME: Self = Self::WeibullByVolume(WeibullByVolumeScene::EXAMPLE);

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

/// Weibull strengths by volume.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(example = Self::EXAMPLE)]
pub struct WeibullByVolumeScene {
    /// Weibull modulus (no unit).
    pub modulus: f64,
    /// Reference volume (m^3).
    pub reference_volume: f64,
    /// What has a strength of its own.
    #[serde(default)]
    pub element: ElementScene,
}

impl WeibullByVolumeScene {
    const EXAMPLE: Self = Self {
        modulus: 10.0,
        reference_volume: 1e-6,
        element: ElementScene::Block { size: 0.004 },
    };

    /// The law with a scale.
    #[must_use]
    pub fn of(self, scale: f64) -> WeibullByVolume {
        let Self { modulus, reference_volume, element } = self;
        let element = match element {
            ElementScene::Bond => StrengthElement::Bond,
            ElementScene::Node => StrengthElement::Node,
            ElementScene::Block { size } => StrengthElement::Block { size },
        };
        WeibullByVolume { scale, modulus, reference_volume, element }
    }
}

/// What has a strength of its own.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ElementScene {
    /// Each bond, with its share of the volumes of its nodes.
    Bond,
    /// Each node. A bond is as strong as its weaker node. With a finer mesh, nodes are stronger and cracks stop more easily.
    #[default]
    Node,
    /// Each box of a square grid, the same on every mesh: for bodies in which cracks grow.
    Block {
        /// Edge of a box (m).
        size: f64,
    },
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
    pub(crate) const SHORT: Self = Self { function: FunctionScene::Matern32, length: 0.003 };
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
