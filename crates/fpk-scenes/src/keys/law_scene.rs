//! The initial distribution of a scene.

use scene_runs::scene::Objection;
use schemars::JsonSchema;
use sde_integrators::{GaussianComponent, GaussianMixture};
use serde::{Deserialize, Serialize};

use super::checks::must;
use super::system_scene::{SystemError, list, square};
use crate::paths::Paths;
use crate::system::{System, Visitor};

/// The initial distribution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(example = Self::mixture())]
pub enum LawScene {
    /// Independent Gaussian states.
    Gaussian {
        /// Mean of each state (unit of each state).
        mean: Vec<f64>,
        /// Standard deviation of each state; 0 starts at the mean, for `monte_carlo` and `subset_simulation` (unit of each state).
        standard_deviation: Vec<f64>,
    },
    /// A structure with independent Gaussian states, behind a filter in its stationary distribution.
    StationaryFilter {
        /// Mean of each state of the structure (unit of each state).
        mean: Vec<f64>,
        /// Standard deviation of each state of the structure; 0 as for `gaussian` (unit of each state).
        standard_deviation: Vec<f64>,
    },
    /// A mixture of Gaussians.
    Mixture(Vec<ComponentScene>),
}

/// One Gaussian of a mixture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComponentScene {
    /// Its weight; the weights sum to 1 (no unit).
    pub weight: f64,
    /// Its mean (unit of each state).
    pub mean: Vec<f64>,
    /// Its covariance, row by row (product of the units of both states).
    pub covariance: Vec<Vec<f64>>,
}

impl LawScene {
    /// An example for the schema; no built-in scene shows it.
    fn mixture() -> Self {
        let component = |weight, place| ComponentScene {
            weight,
            mean: vec![place, 0.0],
            covariance: vec![vec![0.04, 0.0], vec![0.0, 0.01]],
        };
        Self::Mixture(vec![component(0.25, -1.0), component(0.75, 1.0)])
    }

    /// Builds and checks the distribution.
    ///
    /// `filter` is the stationary covariance of the filter's states, which come last.
    ///
    /// # Errors
    /// [`SystemError`] for a list of another length; [`vibrating_systems::Error`] for an invalid distribution.
    pub fn build<const D: usize>(
        &self,
        filter: Option<&[Vec<f64>]>,
    ) -> Result<GaussianMixture<D>, SystemError> {
        let law = match self {
            Self::Gaussian { mean, standard_deviation } => {
                let deviations = list("standard_deviation", standard_deviation)?.map(not_zero);
                GaussianMixture::independent(list("mean", mean)?, deviations)
            }
            Self::StationaryFilter { mean, standard_deviation } => {
                let filter = filter.unwrap_or_default();
                let structure = D.saturating_sub(filter.len());
                let wanted = || format!("the structure has {structure} states");
                for (key, values) in [("mean", mean), ("standard_deviation", standard_deviation)] {
                    if values.len() != structure {
                        let count = values.len();
                        return Err(SystemError::Shape { key, count, wanted: wanted() });
                    }
                }
                let (mut means, mut covariance) = ([0.0; D], [[0.0; D]; D]);
                means[..structure].copy_from_slice(mean);
                for (k, &deviation) in standard_deviation.iter().enumerate() {
                    covariance[k][k] = not_zero(deviation).powi(2);
                }
                for (row, values) in covariance[structure..].iter_mut().zip(filter) {
                    row[structure..].copy_from_slice(values);
                }
                GaussianMixture::gaussian(means, covariance)
            }
            Self::Mixture(components) => {
                let component = |component: &ComponentScene| -> Result<_, SystemError> {
                    let ComponentScene { weight, mean, covariance } = component;
                    Ok(GaussianComponent {
                        weight: *weight,
                        mean: list("mean", mean)?,
                        covariance: square("covariance", covariance)?,
                    })
                };
                let components: Vec<_> =
                    components.iter().map(component).collect::<Result<_, _>>()?;
                GaussianMixture::mixture(&components)
            }
        };
        Ok(law.map_err(vibrating_systems::Error::from)?)
    }

    /// Refuses lists of another length, negative deviations, and a deviation of zero unless the method starts at points.
    pub(crate) fn check(&self, system: &System, starts_at_points: bool) -> Result<(), Objection> {
        let name = match self {
            Self::Gaussian { .. } => "gaussian",
            Self::StationaryFilter { .. } => "stationary_filter",
            Self::Mixture(_) => "mixture",
        };
        let filter = system.filter_covariance();
        if filter.is_none() && matches!(self, Self::StationaryFilter { .. }) {
            let message = "the system has no filter";
            return Err(Objection::new("initial.stationary_filter", message)
                .with_help("use `gaussian` with a mean and a standard deviation for each state"));
        }
        if let Self::Gaussian { standard_deviation, .. }
        | Self::StationaryFilter { standard_deviation, .. } = self
        {
            for (k, &deviation) in standard_deviation.iter().enumerate() {
                let path = format!("initial.{name}.standard_deviation[{k}]");
                if starts_at_points {
                    must(&path, deviation, deviation >= 0.0, "at least 0")?;
                } else {
                    must(&path, deviation, deviation > 0.0, "greater than 0")
                        .map_err(|objection| objection.with_help(NO_DENSITY))?;
                }
            }
        }
        system.visit(Build(self, filter.as_deref())).map_err(|error| {
            let states = format!("the states are {}", system.states().join(", "));
            match &error {
                SystemError::Shape { key, .. } if name != "mixture" => {
                    Objection::new(format!("initial.{name}.{key}"), error.to_string())
                        .with_help(states)
                }
                SystemError::Shape { .. } => {
                    Objection::new("initial.mixture", error.to_string()).with_help(states)
                }
                _ => Objection::new("initial", error.to_string()),
            }
        })
    }
}

/// What to write for a start from rest.
const NO_DENSITY: &str = "a density and its covariance need a deviation: monte_carlo and subset_simulation start at a point too";

/// The deviation of a state that starts at a point: its square is a number, and no state of another size is changed by it.
const POINT: f64 = 1e-150;

fn not_zero(deviation: f64) -> f64 {
    if deviation.abs() > 0.0 || deviation.is_nan() { deviation } else { POINT }
}

/// Builds a distribution in the dimension of the system.
struct Build<'a>(&'a LawScene, Option<&'a [Vec<f64>]>);

impl Visitor for Build<'_> {
    type Output = Result<(), SystemError>;
    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, _: &S) -> Self::Output {
        self.0.build::<D>(self.1).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_that_the_schema_shows_can_be_built() {
        assert!(LawScene::mixture().build::<2>(None).is_ok());
    }
}
