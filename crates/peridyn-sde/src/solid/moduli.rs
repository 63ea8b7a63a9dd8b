//! Moduli of the linear peridynamic solid.

use crate::error::{Error, between, positive};
use crate::material::elasticity::Condition;

/// Moduli of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moduli {
    /// `Lambda - G` (stress).
    pub(crate) a: f64,
    /// `D (D + 2) G` (stress).
    pub(crate) b: f64,
}

impl Moduli {
    /// # Errors
    /// [`Error::Parameter`] for Young's modulus or Poisson's ratio.
    pub(crate) fn new(
        young_modulus: f64,
        poisson_ratio: f64,
        condition: Condition,
    ) -> Result<Self, Error> {
        positive("Young's modulus", young_modulus)?;
        between("Poisson's ratio", poisson_ratio, -1.0, 0.5)?;
        let (nu, dimension) = (poisson_ratio, condition.dimension() as f64);
        let g = young_modulus / (2.0 * (1.0 + nu));
        let lame = match condition {
            Condition::Bar { .. } => 2.0 * g * nu,
            Condition::PlaneStress { .. } => 2.0 * g * nu / (1.0 - nu),
            Condition::PlaneStrain { .. } | Condition::Solid => 2.0 * g * nu / (1.0 - 2.0 * nu),
        };
        Ok(Self { a: lame - g, b: dimension * (dimension + 2.0) * g })
    }
}
