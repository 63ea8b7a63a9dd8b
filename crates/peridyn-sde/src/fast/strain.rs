//! How strains are measured.

/// How the stretch of a bond follows from displacements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Strain {
    /// `(|xi + eta| - |xi|)/|xi|`: of the bond as it stands, at any rotation.
    #[default]
    Finite,
    /// `xi eta/|xi|^2`: linear in the displacements, so that an unbroken body is a linear system.
    Linear,
}

impl Strain {
    /// The growth `w` of a bond at a stretch: `(1 + s)^2 - 1`, with linear strains `2 s`.
    pub(crate) fn growth(self, stretch: f64) -> f64 {
        match self {
            Self::Finite => stretch * (2.0 + stretch),
            Self::Linear => 2.0 * stretch,
        }
    }

    /// Its slope.
    pub(crate) fn slope(self, stretch: f64) -> f64 {
        match self {
            Self::Finite => 2.0 * (1.0 + stretch),
            Self::Linear => 2.0,
        }
    }

    /// And back.
    pub(crate) fn stretch(self, growth: f64) -> f64 {
        match self {
            Self::Finite => growth / (1.0 + (1.0 + growth).sqrt()),
            Self::Linear => 0.5 * growth,
        }
    }
}
