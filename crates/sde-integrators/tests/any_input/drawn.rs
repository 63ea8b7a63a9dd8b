//! Numbers of any kind, a system with any constants, and what every answer must be.

#[path = "../../../simd-lanes/tests/shared/number.rs"]
mod any_number;

use proptest::prelude::*;
use sde_integrators::{Additive, DiagonalSde, Estimate, Sde, SecondOrder, Uncertainty};

/// Any double.
pub(crate) fn number() -> impl Strategy<Value = f64> {
    any_number::number(0.1..1.0, 8)
}

pub(crate) fn count() -> impl Strategy<Value = usize> {
    prop_oneof![8 => 0_usize..5, 1 => any::<usize>(), 1 => Just(1 << 32), 1 => Just(usize::MAX)]
}

pub(crate) fn numbers() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(number(), 0..10)
}

/// A cubic oscillator with any constants.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cubic {
    rates: [f64; 2],
    hardening: f64,
    force: f64,
    noise: [f64; 2],
}

impl Cubic {
    fn slope(&self, [x, v]: [f64; 2]) -> [f64; 2] {
        [v, self.force - self.rates[0] * x - self.rates[1] * v - self.hardening * x * x * x]
    }
}

impl Sde<2, 1> for Cubic {
    type Noise = Additive;

    fn drift(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        self.slope(*x)
    }

    fn noise(&self, _t: f64, _x: &[f64; 2]) -> [[f64; 1]; 2] {
        self.noise.map(|s| [s])
    }
}

impl DiagonalSde<2> for Cubic {
    fn drift(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        self.slope(*x)
    }

    fn intensity(&self, _t: f64, x: &[f64; 2]) -> [f64; 2] {
        [self.noise[0] * x[0], self.noise[1] * x[1]]
    }

    fn intensity_derivative(&self, _t: f64, _x: &[f64; 2]) -> [f64; 2] {
        self.noise
    }
}

impl SecondOrder<1, 1> for Cubic {
    fn natural_frequency(&self) -> [f64; 1] {
        [self.rates[0]]
    }

    fn linear_damping(&self) -> [f64; 1] {
        [self.rates[1]]
    }

    fn remaining_acceleration(&self, _t: f64, q: &[f64; 1], _v: &[f64; 1]) -> [f64; 1] {
        [self.force - self.hardening * q[0] * q[0] * q[0]]
    }

    fn remaining_flow(&self, t: f64, dt: f64, q: &[f64; 1], v: &mut [f64; 1]) {
        v[0] += dt * self.remaining_acceleration(t, q, v)[0];
    }

    fn noise_intensity(&self, _t: f64) -> [[f64; 1]; 1] {
        [[self.noise[0]]]
    }
}

pub(crate) fn cubic() -> impl Strategy<Value = Cubic> {
    let pair = || prop::array::uniform2(number());
    (pair(), number(), number(), pair()).prop_map(|(rates, hardening, force, noise)| Cubic {
        rates,
        hardening,
        force,
        noise,
    })
}

/// A result is a number, and so is its error.
pub(crate) fn is_told(estimate: &Estimate) -> bool {
    let error = match estimate.uncertainty {
        Uncertainty::StandardError(error) | Uncertainty::Bound(error) => error,
        Uncertainty::Unknown => 0.0,
    };
    estimate.value.is_finite() && error.is_finite()
}
