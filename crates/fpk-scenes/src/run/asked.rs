//! Requested results and initial distribution of a density scene, in the dimension of its system.

use scene_runs::kind::RunError;
use sde_integrators::GaussianMixture;

use crate::density::Asked;
use crate::scene::FpkScene;
use crate::system::System;

/// Requested results of the scene, in the dimension of its system or in that of a structure whose filter is conditioned out.
///
/// The scene has been checked: its lists have as many entries as the system has states, and nothing is asked of states
/// that are conditioned out.
pub(super) fn asked<const D: usize>(
    scene: &FpkScene,
    system: &System,
    cells: bool,
) -> Result<Asked<D>, RunError> {
    let powers = |powers: &Vec<u32>| {
        let of_states = powers.get(..D).and_then(|powers| powers.try_into().ok());
        of_states.ok_or_else(|| RunError::solver(OtherDimension { states: D }))
    };
    Ok(Asked {
        times: scene.times.list(),
        powers: scene.moments.iter().map(powers).collect::<Result<_, _>>()?,
        demand: scene
            .demand(system.states())
            .map_err(|_| RunError::solver(OtherDimension { states: D }))?,
        thresholds: scene.thresholds.clone(),
        cells,
    })
}

/// The scene was not checked.
#[derive(Debug, thiserror::Error)]
#[error("the scene is of another dimension than its system, which has {states} states")]
pub(super) struct OtherDimension {
    pub(super) states: usize,
}

/// Initial distribution of the scene in the dimension of its system.
pub(super) fn law<const D: usize>(
    scene: &FpkScene,
    system: &System,
) -> Result<GaussianMixture<D>, RunError> {
    scene.initial.build(system.filter_covariance().as_deref()).map_err(RunError::solver)
}
