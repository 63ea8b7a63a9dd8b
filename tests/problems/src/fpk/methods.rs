//! Methods and lattices that charts and cases use on the problems of `fpk-sph`.

use fpk_sph::{Config, DEFAULT_MOST_STEPS, InitialLattice, Method};
use random_vibration::{Linearisation, Quadrature};

/// The lattice of section 4.1 with the method of section 3.
pub fn papers_config(period: f64) -> Config<2> {
    Config {
        method: Method::CanorDenoel2013,
        lattice: InitialLattice::CANOR_DENOEL_2013,
        reference_period: period,
        most_steps: DEFAULT_MOST_STEPS,
    }
}

/// The lattice of the claims on moments.
pub const BOUC_WEN_LATTICE: InitialLattice<3> = InitialLattice::Ball { reach: 5.0, spacing: 0.4 };

/// The lattice of the building behind the filter.
pub const KANAI_TAJIMI_LATTICE: InitialLattice<4> =
    InitialLattice::Ball { reach: 5.0, spacing: 1.2 };

/// Statistical linearisation of an oscillator whose drift has a root or a kink where the velocity vanishes.
pub const OF_OSCILLATOR: Linearisation<2> =
    Linearisation { order: [(1, Quadrature::SplitAtZero), (0, Quadrature::Hermite)], step: 0.05 };

/// The same with hysteresis, which has kinks where the velocity or `z` vanishes.
pub const OF_HYSTERESIS: Linearisation<3> = Linearisation {
    order: [(1, Quadrature::SplitAtZero), (2, Quadrature::SplitAtZero), (0, Quadrature::Hermite)],
    step: 0.05,
};
