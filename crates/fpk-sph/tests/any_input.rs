//! Whatever numbers come in, `new` and a first step end in a simulation or a typed error: no panic, no hang, no memory beyond
//! [`MOST_BYTES`]. `PROPTEST_CASES` says how many are tried.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

use std::alloc::System;

use cap::Cap;
use fpk_sph::systems::{
    BoucWen, BoucWenParameters, LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters,
    Window,
};
use fpk_sph::{Config, InitialLattice, Method, Simulation};
use proptest::prelude::*;
use sde_integrators::{GaussianMixture, Sde};

/// An allocation beyond it ends the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// Lattices up to this are laid; larger ones take what they need, up to [`TOO_MANY`].
const MOST_PARTICLES: f64 = 3e3;
/// Lattices beyond this must be refused.
const TOO_MANY: f64 = 5e9;

/// Any double: ordinary ones, those at the ends of the range, infinities and NaN.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        24 => 0.1..1.0,
        2 => -10.0..10.0,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![
            0.0, -0.0, 1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE,
            5e-324, 1e-300, 1e300, -1e300,
        ]),
    ]
}

fn count() -> impl Strategy<Value = usize> {
    prop_oneof![24 => 7_usize..14, 3 => 0_usize..7, 1 => any::<usize>(), 1 => Just(usize::MAX)]
}

fn lattice<const D: usize>() -> impl Strategy<Value = InitialLattice<D>> {
    let counts = || prop::array::uniform::<_, D>(count());
    prop_oneof![
        (number(), counts())
            .prop_map(|(reach, count)| InitialLattice::Box { reach: 4.0 * reach, count }),
        (number(), number())
            .prop_map(|(reach, spacing)| InitialLattice::Ball { reach: 4.0 * reach, spacing }),
        (prop::array::uniform::<_, D>(number()), counts())
            .prop_map(|(half_width, count)| InitialLattice::Rectangle { half_width, count }),
    ]
}

/// Whether a lattice is small, or so large that it must be refused; between, it is laid, and only slow.
fn small_or_refused<const D: usize>(lattice: &InitialLattice<D>) -> bool {
    let places = match lattice {
        InitialLattice::Box { count, .. } | InitialLattice::Rectangle { count, .. } => {
            count.iter().map(|&n| n as f64).product()
        }
        InitialLattice::Ball { reach, spacing } => {
            (2.0 * reach / spacing).abs().max(1.0).powi(i32::try_from(D).unwrap())
        }
    };
    !(MOST_PARTICLES..TOO_MANY).contains(&places)
}

fn config<const D: usize>() -> impl Strategy<Value = Config<D>> {
    let method = prop::sample::select(vec![
        Method::CanorDenoel2013,
        Method::LogDensityFit,
        Method::FlowMapFit,
    ]);
    let parts = (method, lattice(), number(), any::<u64>());
    parts
        .prop_map(|(method, lattice, reference_period, most_steps)| Config {
            method,
            lattice,
            reference_period,
            most_steps,
        })
        .prop_filter("a lattice that is laid, and only slow", |c| small_or_refused(&c.lattice))
}

fn window() -> impl Strategy<Value = Window> {
    let decay = (number(), number(), number(), number());
    prop_oneof![
        Just(Window::Stationary),
        decay.prop_map(|(rise_exponent, rise_end, decay_rate, decay_start)| {
            Window::RisePlateauDecay { rise_exponent, rise_end, decay_rate, decay_start }
        }),
        (number(), number()).prop_map(|(peak, peak_time)| Window::SinglePeak { peak, peak_time }),
    ]
}

fn structure() -> impl Strategy<Value = LinearOscillatorParameters> {
    (number(), number(), number(), window()).prop_map(
        |(natural_frequency, damping_ratio, noise_intensity, window)| LinearOscillatorParameters {
            natural_frequency,
            damping_ratio,
            noise_intensity,
            window,
        },
    )
}

/// A start, and a step where there was one.
fn start<S: Sde<D, 1>, const D: usize>(
    system: S,
    (mean, deviation): ([f64; D], [f64; D]),
    config: &Config<D>,
) {
    let Ok(law) = GaussianMixture::independent(mean, deviation) else { return };
    if let Ok(mut simulation) = Simulation::new(system, &law, config) {
        // An error is an answer.
        let _ = simulation.step();
        let moment = simulation.expectation(|x| x[0]);
        // A mass or a state that is too large for the product is no mistake of the sum.
        let largest = simulation.total_mass().max(mean[0].abs()).max(deviation[0]);
        assert!(moment.is_finite() || largest > 1e100, "{moment}");
    }
}

proptest! {
    #[test]
    fn a_damped_oscillator_starts_or_says_why_not(
        structure in structure(),
        (coefficient, exponent) in (number(), number()),
        law in (prop::array::uniform2(number()), prop::array::uniform2(number())),
        config in config::<2>(),
    ) {
        let parameters = ViscousDamperParameters {
            structure,
            damper_coefficient: coefficient,
            damper_exponent: exponent,
        };
        if let Ok(system) = ViscousDamper::new(parameters) {
            start(system, law, &config);
        }
    }

    #[test]
    fn a_hysteretic_oscillator_starts_or_says_why_not(
        numbers in prop::array::uniform8(number()),
        window in window(),
        law in (prop::array::uniform3(number()), prop::array::uniform3(number())),
        config in config::<3>(),
    ) {
        let [natural_frequency, damping_ratio, hardening, initial_slope, beta, gamma, exponent, s] =
            numbers;
        let parameters = BoucWenParameters {
            natural_frequency,
            damping_ratio,
            hardening,
            initial_slope,
            beta,
            gamma,
            exponent,
            noise_intensity: s,
            window,
        };
        if let Ok(system) = BoucWen::new(parameters) {
            start(system, law, &config);
        }
    }

    #[test]
    fn a_snapshot_of_any_bytes_is_refused_and_one_with_a_bit_turned_too(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        (place, bit) in (any::<prop::sample::Index>(), 0_u32..8),
    ) {
        let mut simulation = damper();
        prop_assert!(simulation.restore(bytes.as_slice()).is_err());
        let mut snapshot = Vec::new();
        simulation.snapshot(&mut snapshot).unwrap();
        let place = place.index(snapshot.len());
        snapshot[place] ^= 1_u8 << bit;
        prop_assert!(simulation.restore(snapshot.as_slice()).is_err());
    }
}

fn damper() -> Simulation<ViscousDamper, 2, 1> {
    let structure = LinearOscillatorParameters {
        natural_frequency: 3.0,
        damping_ratio: 0.05,
        noise_intensity: 0.2,
        window: Window::Stationary,
    };
    let parameters =
        ViscousDamperParameters { structure, damper_coefficient: 0.25, damper_exponent: 0.35 };
    let law = GaussianMixture::independent([0.0; 2], [0.15, 0.1]).unwrap();
    let config = Config {
        method: Method::FlowMapFit,
        lattice: InitialLattice::Box { reach: 4.0, count: [7, 7] },
        reference_period: 2.0,
        most_steps: 100,
    };
    Simulation::new(ViscousDamper::new(parameters).unwrap(), &law, &config).unwrap()
}
