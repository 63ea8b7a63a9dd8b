//! The two oscillators of section 4.1 of Canor & Denoël 2013.

use fpk_scenes::system::System;
use vibrating_systems::{LinearOscillator, ViscousDamper};

/// One of the two, checked.
#[derive(Debug, Clone, PartialEq)]
pub enum Oscillator {
    /// The linear oscillator.
    Linear(LinearOscillator),
    /// The viscous damper.
    Damper(ViscousDamper),
}

impl Oscillator {
    /// The system of a scene, where it is one of the two.
    #[must_use]
    pub fn of(system: System) -> Option<Self> {
        match system {
            System::LinearOscillator(system) => Some(Self::Linear(system)),
            System::ViscousDamper(system) => Some(Self::Damper(system)),
            _ => None,
        }
    }

    /// The natural period (s).
    #[must_use]
    pub fn period(&self) -> f64 {
        match self {
            Self::Linear(system) => system.period(),
            Self::Damper(system) => system.period(),
        }
    }
}
