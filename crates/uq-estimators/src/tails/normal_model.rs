//! Responses of independent standard normals, and what their runs cost.

use std::ops::AddAssign;

use crate::error::Error;
use crate::ladder::Failure;
use crate::parallel::map_in_order;

/// A response of independent standard normals, such as the coefficients of a random field.
///
/// ```
/// use uq_estimators::{Failure, NormalModel};
///
/// struct Sum;
/// impl NormalModel for Sum {
///     fn n_normals(&self) -> usize {
///         100
///     }
///     fn value(&self, normals: &[f64]) -> Result<f64, Failure> {
///         Ok(normals.iter().sum())
///     }
/// }
/// assert_eq!(Sum.value(&[0.5; 100])?, 50.0);
/// # Ok::<(), Failure>(())
/// ```
pub trait NormalModel: Sync {
    /// Number of normals.
    fn n_normals(&self) -> usize;

    /// The response; infinite for an input beyond what the model accepts, if that counts as the event.
    ///
    /// # Errors
    /// Those of the model.
    fn value(&self, normals: &[f64]) -> Result<f64, Failure>;

    /// The response, with its derivative with respect to each normal; `None`, the default, if the model has no gradient: then
    /// forward differences are taken, one run for each normal.
    ///
    /// # Errors
    /// Those of the model.
    fn value_and_gradient(
        &self,
        normals: &[f64],
        gradient: &mut [f64],
    ) -> Result<Option<f64>, Failure> {
        let _ = (normals, gradient);
        Ok(None)
    }
}

/// Cost of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ModelRuns {
    /// Number of responses without a gradient, those of differences included.
    pub values: u64,
    /// Number of responses with a gradient.
    pub gradients: u64,
}

impl AddAssign for ModelRuns {
    fn add_assign(&mut self, other: Self) {
        self.values += other.values;
        self.gradients += other.gradients;
    }
}

/// Step of forward differences, in standard deviations.
const DIFFERENCE: f64 = 1e-4;

/// The response, which may be infinite; `sample` is its number in an error.
pub(crate) fn value_at(
    model: &dyn NormalModel,
    (task, sample): (&str, u64),
    normals: &[f64],
) -> Result<f64, Error> {
    let value = model.value(normals).map_err(|failure| failed(task, sample, &failure))?;
    if value.is_nan() { Err(not_finite(task, sample, value)) } else { Ok(value) }
}

/// The response with its gradient, both finite, and what they cost.
pub(crate) fn gradient_at(
    model: &dyn NormalModel,
    (task, sample): (&str, u64),
    normals: &[f64],
    gradient: &mut [f64],
) -> Result<(f64, ModelRuns), Error> {
    let found = model.value_and_gradient(normals, gradient);
    let finite = |value: f64| {
        if value.is_finite() { Ok(value) } else { Err(not_finite(task, sample, value)) }
    };
    if let Some(value) = found.map_err(|failure| failed(task, sample, &failure))? {
        gradient.iter().try_for_each(|slope| finite(*slope).map(drop))?;
        return Ok((finite(value)?, ModelRuns { values: 0, gradients: 1 }));
    }
    let value = finite(value_at(model, (task, sample), normals)?)?;
    let inputs: Vec<usize> = (0..normals.len()).collect();
    let slopes = map_in_order(&inputs, |&k| {
        let mut shifted = normals.to_vec();
        shifted[k] += DIFFERENCE;
        finite((value_at(model, (task, sample), &shifted)? - value) / DIFFERENCE)
    });
    for (slope, found) in gradient.iter_mut().zip(slopes) {
        *slope = found?;
    }
    Ok((value, ModelRuns { values: 1 + normals.len() as u64, gradients: 0 }))
}

pub(crate) fn failed(task: &str, realisation: u64, failure: &dyn std::fmt::Display) -> Error {
    Error::SampleFailed { model: task.into(), realisation, message: failure.to_string() }
}

fn not_finite(task: &str, realisation: u64, value: f64) -> Error {
    Error::NonFiniteSample { model: task.into(), realisation, response: 0, value }
}
