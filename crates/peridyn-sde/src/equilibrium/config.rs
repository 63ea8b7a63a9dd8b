//! How equilibrium is found, and how bonds break in it.

use crate::error::{Error, Requirement, at_least, positive};

/// What is needed to find equilibrium.
///
/// Displacements are found by conjugate gradients with a two-level preconditioner: the blocks of the nodes, and a coarse system of
/// the rigid motions of boxes one and a half bonds wide (Nicolaides 1987).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquilibriumConfig {
    /// The residual force over the reaction, both as the root of the sum of squares, at which equilibrium counts as reached.
    pub tolerance: f64,
    /// Iterations of conjugate gradients after which a solution is given up.
    pub most_iterations: usize,
    /// Bonds that break together: those within this part of the stretch over strength of the most critical one. 0 for one at a
    /// time.
    pub batch: f64,
    /// `p` of a bond that softens: a damaged bond is taken along its secant until its stretch is `(1 + p)` times the largest before,
    /// and continues from `(1 + p)` times that, so that the teeth lie about the curve of its law (Rots et al. 2008). No matter where
    /// bonds break at once.
    pub tooth: f64,
}

impl EquilibriumConfig {
    /// One bond at a time, to a residual of 1e-8, with teeth of 5 %.
    pub const EVENT_BY_EVENT: Self =
        Self { tolerance: 1e-8, most_iterations: 100_000, batch: 0.0, tooth: 0.05 };

    pub(super) fn check(&self) -> Result<(), Error> {
        positive("tolerance of an equilibrium", self.tolerance)?;
        at_least("iterations of an equilibrium", self.most_iterations, 1)?;
        positive("tooth of a softening bond", self.tooth)?;
        let must = Requirement::Between { from: 0.0, to: 1.0 };
        must.check("batch of bonds", self.batch, self.batch >= 0.0 && self.batch < 1.0)
    }
}
