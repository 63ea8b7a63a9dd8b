//! What a pass over the particles does with each of them.

/// What a pass over the particles does. The last one of a step moves them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Velocities from the nodes.
    Velocity,
    /// The same, and moves.
    VelocityAndMove,
    /// Velocity gradients from the nodes, and the stress from them.
    Stress,
    /// The same, and moves.
    StressAndMove,
    /// All.
    Whole,
}

impl Pass {
    pub(crate) fn updates_velocity(self) -> bool {
        matches!(self, Self::Velocity | Self::VelocityAndMove | Self::Whole)
    }

    pub(crate) fn updates_stress(self) -> bool {
        matches!(self, Self::Stress | Self::StressAndMove | Self::Whole)
    }

    pub(crate) fn moves(self) -> bool {
        matches!(self, Self::VelocityAndMove | Self::StressAndMove | Self::Whole)
    }
}
