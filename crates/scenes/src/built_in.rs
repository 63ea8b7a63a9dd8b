//! Scene kinds of this build.

use scene_runs::SceneKind;

/// Every scene kind, according to the features of the build.
pub static ALL: &[SceneKind] = &[
    #[cfg(feature = "fpk")]
    fpk_scenes::run::KIND,
    #[cfg(feature = "fpk")]
    fpk_scenes::building::run::KIND,
    #[cfg(feature = "smpm")]
    smpm_scenes::run::KIND,
    #[cfg(feature = "peridyn")]
    peridyn_scenes::run::KIND,
    #[cfg(feature = "peridyn")]
    peridyn_scenes::crack_inference::run::KIND,
];
