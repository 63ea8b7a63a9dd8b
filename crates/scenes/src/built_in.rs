//! Scene kinds of this build.

use crate::kind::SceneKind;

/// Every scene kind, according to the features of the build.
///
/// It is a static because constants are compiled again with each program. It is empty in unit tests, which name their
/// kind; otherwise all solvers would be compiled with them.
pub static ALL: &[SceneKind] = if cfg!(test) {
    &[]
} else {
    &[
        #[cfg(feature = "fpk")]
        crate::fpk::run::KIND,
        #[cfg(feature = "fpk")]
        crate::building::run::KIND,
        #[cfg(feature = "smpm")]
        crate::smpm::run::KIND,
        #[cfg(feature = "peridyn")]
        crate::peridyn::run::KIND,
        #[cfg(feature = "peridyn")]
        crate::crack_inference::run::KIND,
    ]
};
