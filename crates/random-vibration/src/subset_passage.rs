//! First passage by subset simulation, for a system of any number of states.

use sde_integrators::{
    DrivenLanes, Error, Estimate, LaneSde, Noise, Response, SubsetConfig, subset_simulation,
};

use crate::tail::TailError;

/// `P(max y > T)` of the largest of some responses, for paths from rest to a time in a number of steps.
///
/// Subset simulation of the largest response as a function of the normals of all steps; the standard error is that of
/// [`subset_simulation`]. Paths take [`WongZakai`](sde_integrators::WongZakai) steps, one by one.
///
/// Source: Au and Beck 2001, Estimation of small failure probabilities in high dimensions by subset simulation, section 6.
///
/// # Errors
/// [`TailError::Sampling`]: those of [`subset_simulation`]; [`Error::TooFew`] without a response or a step;
/// [`Error::NoSuchComponent`]; [`Error::NotANumber`] for a response with a Brownian bridge, whose maximum is no function of the
/// normals.
pub fn subset_passage<S: LaneSde>(
    system: &S,
    responses: &[Response<'_>],
    threshold: f64,
    (time, n_steps): (f64, usize),
    (config, seed): (&SubsetConfig, u64),
) -> Result<Estimate, TailError> {
    for (quantity, value) in [("responses", responses.len()), ("steps", n_steps)] {
        if value == 0 {
            return Err(Error::TooFew { quantity, value: 0, limit: 1 }.into());
        }
    }
    let limit = system.n_states();
    if let Some(response) = responses.iter().find(|response| response.component >= limit) {
        return Err(Error::NoSuchComponent { component: response.component, limit }.into());
    }
    let dt = time / n_steps as f64;
    let (driven, start) = (DrivenLanes { system, dt }, vec![0.0; limit]);
    let largest = |normals: &[f64]| {
        let mut largest = f64::NEG_INFINITY;
        driven.run(&start, normals, |before, after| {
            for response in responses {
                let in_step = response.largest_in_step(dt, before, after).unwrap_or(f64::NAN);
                largest = if in_step > largest || in_step.is_nan() { in_step } else { largest };
            }
        })?;
        Ok(largest)
    };
    Ok(subset_simulation(&largest, n_steps, threshold, &Noise::new(seed), config)?)
}
