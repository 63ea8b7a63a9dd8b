//! Material constants that vary in space, as written in a scene.

use random_fields::{
    Correlation, CorrelationFunction, Error, Marginal, SpatialCorrelation, Truncation,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Material constants that vary in space by one random field: each is its value in the scene times the field, whose mean is 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomFieldScene {
    /// The constants, `material.part.name`, e.g. `steel.strength.a`; all of one material.
    pub parameters: Vec<String>,
    /// Distribution at one point.
    pub marginal: MarginalScene,
    /// Correlation of the underlying normal field.
    pub correlation: FieldCorrelationScene,
    /// Number of terms of its expansion.
    pub terms: TermsScene,
}

impl RandomFieldScene {
    pub(crate) fn of_yield_stress() -> Self {
        Self {
            parameters: vec!["steel.strength.a".to_owned()],
            marginal: MarginalScene::Lognormal { coefficient_of_variation: 0.15 },
            correlation: FieldCorrelationScene {
                function: FunctionScene::Matern32,
                lengths: vec![1.0, 2.0],
                separable: false,
            },
            terms: TermsScene::Number(100),
        }
    }
}

/// Distribution of a field at one point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::Weibull { coefficient_of_variation: 0.2 })]
#[schemars(example = Self::Normal { coefficient_of_variation: 0.05 })]
pub enum MarginalScene {
    /// Normal; its deviation is at most 1/7.9 of the mean.
    Normal {
        /// Coefficient of variation (no unit).
        coefficient_of_variation: f64,
    },
    /// Lognormal.
    Lognormal {
        /// Coefficient of variation (no unit).
        coefficient_of_variation: f64,
    },
    /// Weibull distribution, that of the weakest of many.
    Weibull {
        /// Coefficient of variation (no unit).
        coefficient_of_variation: f64,
    },
}

impl MarginalScene {
    /// The distribution of the factor, whose mean is 1, and the key of its coefficient of variation.
    pub(crate) fn factor(self) -> (Result<Marginal, Error>, &'static str) {
        let (marginal, key) = match self {
            Self::Normal { coefficient_of_variation: standard_deviation } => {
                (Ok(Marginal::Normal { mean: 1.0, standard_deviation }), "normal")
            }
            Self::Lognormal { coefficient_of_variation } => {
                (Ok(Marginal::Lognormal { mean: 1.0, coefficient_of_variation }), "lognormal")
            }
            Self::Weibull { coefficient_of_variation } => {
                (Marginal::weibull(1.0, coefficient_of_variation), "weibull")
            }
        };
        (marginal.and_then(|it| it.check_positive().map(|()| it)), key)
    }
}

/// A correlation with a length along each axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldCorrelationScene {
    /// Correlation function of the distance `r` in units of the lengths, or of that along each axis with `separable`.
    #[serde(default)]
    #[schemars(example = FunctionScene::Exponential)]
    pub function: FunctionScene,
    /// The integral scale along each axis (length of `units`).
    pub lengths: Vec<f64>,
    /// Whether it is the product of the function over the axes; without this key it is the function of the distance.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub separable: bool,
}

impl FieldCorrelationScene {
    /// The correlation in space.
    pub(crate) fn between<const D: usize>(&self, lengths: [f64; D]) -> SpatialCorrelation<D> {
        let function = self.function.function();
        if self.separable {
            SpatialCorrelation::separable(lengths.map(|length| Correlation { function, length }))
        } else {
            SpatialCorrelation::elliptic(function, lengths)
        }
    }
}

/// Correlation functions of the distance `r` in units of the lengths.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FunctionScene {
    /// `exp(-r)`.
    Exponential,
    /// `exp(-pi r^2/4)`.
    Gaussian,
    /// `(1 + 2 r) exp(-2 r)`.
    #[default]
    Matern32,
    /// `(1 + x + x^2/3) exp(-x)` with `x = 8 r/3`.
    Matern52,
}

impl FunctionScene {
    /// The function.
    #[must_use]
    pub const fn function(self) -> CorrelationFunction {
        match self {
            Self::Exponential => CorrelationFunction::Exponential,
            Self::Gaussian => CorrelationFunction::Gaussian,
            Self::Matern32 => CorrelationFunction::Matern32,
            Self::Matern52 => CorrelationFunction::Matern52,
        }
    }
}

/// Number of terms of the expansion of a field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::ShareOfVariance(0.95))]
pub enum TermsScene {
    /// So many terms (no unit).
    Number(usize),
    /// As many terms as hold this share of the mean variance of the normal field, below 1 (no unit).
    ShareOfVariance(f64),
}

impl TermsScene {
    /// The truncation, and its key.
    pub(crate) const fn truncation(self) -> (Truncation, &'static str) {
        match self {
            Self::Number(terms) => (Truncation::Terms(terms), "number"),
            Self::ShareOfVariance(share) => (Truncation::Share(share), "share_of_variance"),
        }
    }
}
