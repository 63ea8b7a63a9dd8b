//! Whatever numbers come in, `new` and a first step end in a simulation or a typed error: no panic, no hang, no memory beyond
//! [`MOST_BYTES`]. `PROPTEST_CASES` says how many are tried.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

#[path = "../../simd-lanes/tests/shared/number.rs"]
mod any_number;

use std::alloc::System;

use cap::Cap;
use fpk_sph::{Combination, Config, Error, InitialLattice, Method, Scheme, Simulation};
use particle_store::{Attribute, ParticleStore};
use proptest::prelude::*;
use proptest::sample::Index;
use sde_integrators::{GaussianMixture, Sde};
use twox_hash::XxHash64;
use vibrating_systems::{
    BoucWen, BoucWenParameters, LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters,
    Window,
};

/// An allocation beyond it ends the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// Lattices up to this are laid; larger ones take what they need, up to [`TOO_MANY`].
const MOST_PARTICLES: f64 = 3e3;
/// Lattices beyond this must be refused.
const TOO_MANY: f64 = 5e9;

/// Any double.
fn number() -> impl Strategy<Value = f64> {
    any_number::number(0.1..1.0, 24)
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
    let with =
        |scheme| Method::Custom(Combination { scheme, ..Method::FlowMapFit.combination_in(D) });
    let method = prop::sample::select(vec![
        Method::CanorDenoel2013,
        Method::FlowMapFit,
        with(Scheme::LawsonAdamsBashforth2),
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
fn starts<S: Sde<D, 1>, const D: usize>(
    system: S,
    (mean, deviation): ([f64; D], [f64; D]),
    config: &Config<D>,
) -> Result<(), TestCaseError> {
    let Ok(law) = GaussianMixture::independent(mean, deviation) else { return Ok(()) };
    if let Ok(mut simulation) = Simulation::new(system, &law, config) {
        // An error is an answer.
        let _ = simulation.step();
        let moment = simulation.expectation(|x| x[0]);
        // A mass or a state that is too large for the product is no mistake of the sum.
        let largest = simulation.total_mass().max(mean[0].abs()).max(deviation[0]);
        prop_assert!(moment.is_finite() || largest > 1e100, "{moment}");
    }
    Ok(())
}

/// Any first moments of two or three states.
type Law<const D: usize> = ([f64; D], [f64; D]);

pub(crate) fn damped() -> impl Strategy<Value = (ViscousDamperParameters, Law<2>, Config<2>)> {
    let parameters = (structure(), number(), number()).prop_map(
        |(structure, damper_coefficient, damper_exponent)| ViscousDamperParameters {
            structure,
            damper_coefficient,
            damper_exponent,
        },
    );
    let law = (prop::array::uniform2(number()), prop::array::uniform2(number()));
    (parameters, law, config())
}

pub(crate) fn damped_starts(
    (parameters, law, config): (ViscousDamperParameters, Law<2>, Config<2>),
) -> Result<(), TestCaseError> {
    ViscousDamper::new(parameters).map_or(Ok(()), |system| starts(system, law, &config))
}

pub(crate) fn hysteretic() -> impl Strategy<Value = (BoucWenParameters, Law<3>, Config<3>)> {
    let parameters = (prop::array::uniform8(number()), window()).prop_map(|(numbers, window)| {
        let [natural_frequency, damping_ratio, hardening, initial_slope, beta, gamma, exponent, s] =
            numbers;
        BoucWenParameters {
            natural_frequency,
            damping_ratio,
            hardening,
            initial_slope,
            beta,
            gamma,
            exponent,
            noise_intensity: s,
            window,
        }
    });
    let law = (prop::array::uniform3(number()), prop::array::uniform3(number()));
    (parameters, law, config())
}

pub(crate) fn hysteretic_starts(
    (parameters, law, config): (BoucWenParameters, Law<3>, Config<3>),
) -> Result<(), TestCaseError> {
    BoucWen::new(parameters).map_or(Ok(()), |system| starts(system, law, &config))
}

/// What a snapshot holds before its hash.
pub(crate) fn snapshot() -> Vec<u8> {
    let mut bytes = Vec::new();
    damper().snapshot(&mut bytes).unwrap();
    bytes.truncate(bytes.len() - 8);
    bytes
}

/// These bytes, and with the hash that belongs to them.
pub(crate) fn goes_on_or_is_refused(bytes: &[u8]) -> Result<(), TestCaseError> {
    let mut simulation = damper();
    prop_assert!(simulation.restore(bytes).is_err());
    let hashed = [bytes, &XxHash64::oneshot(0, bytes).to_le_bytes()].concat();
    if simulation.restore(hashed.as_slice()).is_ok() && simulation.step().is_ok() {
        prop_assert!(simulation.time().is_finite());
        prop_assert!(simulation.positions().iter().flatten().all(|x| x.is_finite()));
        prop_assert!(simulation.masses().iter().all(|mass| mass.is_finite()));
    }
    Ok(())
}

proptest! {
    #[test]
    fn a_damped_oscillator_starts_or_says_why_not(damped in damped()) {
        damped_starts(damped)?;
    }

    #[test]
    fn a_hysteretic_oscillator_starts_or_says_why_not(hysteretic in hysteretic()) {
        hysteretic_starts(hysteretic)?;
    }

    #[test]
    fn a_snapshot_of_any_bytes_is_refused_and_one_with_a_bit_turned_too(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        (place, bit) in (any::<Index>(), 0_u32..8),
    ) {
        let mut simulation = damper();
        prop_assert!(simulation.restore(bytes.as_slice()).is_err());
        let mut snapshot = Vec::new();
        simulation.snapshot(&mut snapshot).unwrap();
        let place = place.index(snapshot.len());
        snapshot[place] ^= 1_u8 << bit;
        prop_assert!(simulation.restore(snapshot.as_slice()).is_err());
    }

    #[test]
    fn a_forged_snapshot_goes_on_or_is_refused(
        words in prop::collection::vec((any::<Index>(), any::<u64>()), 1..4),
        end in prop::option::of(any::<Index>()),
    ) {
        let mut bytes = snapshot();
        for (place, word) in words {
            let place = 8 * place.index(bytes.len() / 8);
            bytes[place..place + 8].copy_from_slice(&word.to_le_bytes());
        }
        bytes.truncate(end.map_or(bytes.len(), |end| end.index(bytes.len())));
        goes_on_or_is_refused(&bytes)?;
    }
}

/// A snapshot whose store was changed by one who knows its form.
fn changed(change: impl FnOnce(&mut ParticleStore<2>)) -> Vec<u8> {
    let mut bytes = Vec::new();
    damper().snapshot(&mut bytes).unwrap();
    let mut store = ParticleStore::restore(bytes.as_slice()).unwrap();
    change(&mut store);
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    bytes
}

#[test]
fn a_snapshot_with_a_number_that_no_simulation_has_is_refused_by_its_name() {
    let column = |name: &'static str, value: f64| {
        changed(move |store| {
            let handle = store.handle::<[f64; 2]>(name).unwrap();
            store.get_mut(handle).unwrap()[3][1] = value;
        })
    };
    let time = changed(|store| {
        store.set_attribute("time", Attribute::Real(f64::NAN));
    });
    for (bytes, name, at) in [
        (time, "time", 0),
        (column("position", f64::INFINITY), "position", 3),
        (column("place", 0.5), "place", 3),
        (column("place", 1e10), "place", 3),
    ] {
        let error = damper().restore(bytes.as_slice()).unwrap_err();
        let is_named = matches!(error, Error::SnapshotNumber { quantity, particle, .. }
            if quantity == name && particle == at);
        assert!(is_named, "{error}");
    }
}

#[test]
fn a_snapshot_without_particles_is_refused() {
    let mut store = ParticleStore::<2>::new(0);
    for name in ["position", "place"] {
        store.add(name, Vec::<[f64; 2]>::new()).unwrap();
    }
    for name in ["mass", "smoothing_length", "smoothing_ratio"] {
        store.add(name, Vec::<f64>::new()).unwrap();
    }
    store.set_attribute("time", Attribute::Real(0.0));
    // Remeshing may give any number of them.
    for (name, value) in [("n_steps", 0), ("n_remaps", 1), ("n_start", 49)] {
        store.set_attribute(name, Attribute::Count(value));
    }
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    let error = damper().restore(bytes.as_slice()).unwrap_err();
    assert!(matches!(error, Error::ForeignSnapshot { found: 0, expected: 49 }), "{error}");
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
