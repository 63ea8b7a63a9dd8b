//! How strains are measured.

use crate::bodies::nodes::Nodes;
use crate::real::Real;

/// How the stretch of a bond follows from displacements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Strain {
    /// `(|xi + eta| - |xi|)/|xi|`: of the bond as deformed, at any rotation.
    #[default]
    Finite,
    /// `xi eta/|xi|^2`: linear in the displacements, so that an unbroken body is a linear system.
    Linear,
}

impl Strain {
    /// The relative squared elongation `w` of a bond at a stretch: `(1 + s)^2 - 1`, with linear strains `2 s`.
    pub(crate) fn squared_elongation(self, stretch: f64) -> f64 {
        match self {
            Self::Finite => stretch * (2.0 + stretch),
            Self::Linear => 2.0 * stretch,
        }
    }

    /// `dw/ds` at a stretch.
    pub(crate) fn slope(self, stretch: f64) -> f64 {
        match self {
            Self::Finite => 2.0 * (1.0 + stretch),
            Self::Linear => 2.0,
        }
    }

    /// The stretch of a bond from its relative squared elongation.
    pub(crate) fn stretch(self, squared_elongation: f64) -> f64 {
        match self {
            Self::Finite => squared_elongation / (1.0 + (1.0 + squared_elongation).sqrt()),
            Self::Linear => 0.5 * squared_elongation,
        }
    }

    /// The relative squared elongation `w` of a bond of some length in a lane, from the displacements of its ends.
    pub(crate) fn squared_elongation_of<T: Real, const D: usize, const L: usize>(
        self,
        nodes: &Nodes<D>,
        ((i, j), length): ((usize, usize), f64),
        u: &[T],
        lane: usize,
    ) -> f64 {
        let x = nodes.positions();
        let mut square = 0.0;
        for k in 0..D {
            let xi = x[j][k] - x[i][k];
            let eta = (u[(j * D + k) * L + lane] - u[(i * D + k) * L + lane]).to_f64();
            square += match self {
                Self::Finite => eta * (2.0 * xi + eta),
                Self::Linear => 2.0 * eta * xi,
            };
        }
        square / (length * length)
    }
}
