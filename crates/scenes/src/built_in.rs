//! The kinds of scene that this build knows.

use crate::kind::SceneKind;

/// Every kind of scene, by the features of the build. A static: what a constant names is compiled again with each program.
/// Empty in unit tests, which name the kind that they run: else all solvers would be compiled with them.
pub static ALL: &[SceneKind] = if cfg!(test) {
    &[]
} else {
    &[
        #[cfg(feature = "fpk")]
        crate::fpk::run::KIND,
        #[cfg(feature = "smpm")]
        crate::smpm::run::KIND,
        #[cfg(feature = "peridyn")]
        crate::peridyn::run::KIND,
    ]
};
