//! Whatever numbers come in, bodies, simulations and their first steps end in a result or a typed error: no panic, no hang, no memory
//! beyond [`MOST_BYTES`]. `PROPTEST_CASES` says how many are tried.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

#[path = "../../simd-lanes/tests/shared/number.rs"]
mod any_number;

use std::alloc::System;

use cap::Cap;
use particle_store::{Attribute, ParticleStore};
use proptest::prelude::*;
use proptest::sample::Index;
use smpm::material::{JohnsonCook, MieGruneisen, Solid, Units, library};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Contact, Error, Fill, Geometry, Shape,
    Side, Simulation, Transfer,
};
use twox_hash::XxHash64;

/// An allocation beyond it ends the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// Lattices up to this are laid; larger ones take what they need, up to [`TOO_MANY`].
const MOST_PARTICLES: f64 = 1e3;
/// Lattices beyond this must be refused.
const TOO_MANY: f64 = 5e9;

/// Any double.
fn number() -> impl Strategy<Value = f64> {
    any_number::number(0.1..2.0, 8)
}

/// One as a rule, now and then any.
fn factor() -> impl Strategy<Value = f64> {
    prop_oneof![12 => Just(1.0), 1 => number()]
}

fn config() -> impl Strategy<Value = Config<2>> {
    let kind = prop_oneof![
        Just(BoundaryKind::Symmetry),
        Just(BoundaryKind::Clamped),
        number().prop_map(|friction| BoundaryKind::Rigid { friction }),
        (number(), number())
            .prop_map(|(longitudinal, shear)| BoundaryKind::Absorbing { longitudinal, shear }),
    ];
    let side = prop::sample::select(vec![Side::Above, Side::Below]);
    let boundary = (0_usize..3, number(), side, kind)
        .prop_map(|(axis, position, side, kind)| Boundary { axis, position, side, kind });
    let scheme = (
        prop::sample::select(vec![Shape::QuadraticBSpline, Shape::CubicBSpline]),
        prop::sample::select(vec![Transfer::Flip, Transfer::Apic]),
        prop::sample::select(vec![Geometry::Cartesian, Geometry::Axisymmetric]),
        prop_oneof![
            Just(Contact::Bonded),
            number().prop_map(|coefficient| Contact::Friction { coefficient }),
        ],
    );
    let numbers = (prop::array::uniform8(factor()), factor(), any::<u64>());
    (scheme, numbers, prop::collection::vec(boundary, 0..3)).prop_map(
        |((shape, transfer, geometry, contact), numbers, boundaries)| {
            let ([cell, x, y, quadratic, linear, courant, gx, gy], growth, most_steps) = numbers;
            Config {
                cell,
                origin: [x - 1.0, y - 1.0],
                shape,
                transfer,
                geometry,
                viscosity: BulkViscosity { quadratic, linear },
                courant_number: 0.4 * courant,
                damping: 0.5 * gx,
                gravity: [gx - 1.0, gy - 1.0],
                gravity_history: vec![[0.0, gx], [courant, gy]],
                contact,
                boundaries,
                most_energy_growth: 10.0 * growth,
                most_steps,
            }
        },
    )
}

fn fill() -> impl Strategy<Value = ([f64; 2], [f64; 2], [f64; 2])> {
    (
        prop::array::uniform2(factor()),
        prop::array::uniform2(number()),
        prop::array::uniform2(number()),
    )
        .prop_map(|(spacing, low, size)| {
            (spacing.map(|s| 0.5 * s), low, [low[0] + 3.0 * size[0], low[1] + 3.0 * size[1]])
        })
        .prop_filter("a lattice that is laid, and only slow", |(spacing, low, high)| {
            let along = |k: usize| ((high[k] - low[k]) / spacing[k]).abs().max(1.0);
            !(MOST_PARTICLES..TOO_MANY).contains(&(along(0) * along(1)))
        })
}

type Steel = Solid<MieGruneisen<f64>, JohnsonCook<f64>>;

/// Steel, each constant of it times a factor.
fn steel() -> impl Strategy<Value = Result<Steel, Error>> {
    prop::collection::vec(factor(), 32).prop_map(|factors| {
        let mut factors = factors.into_iter().cycle();
        let mut times = |value: f64| value * factors.next().unwrap_or(1.0);
        let equation = library::steel_equation(Units::CM_G_US).map(|_, value| times(value));
        let strength = library::steel_strength(Units::CM_G_US).map(|_, value| times(value));
        Ok(Solid { equation: MieGruneisen::new(equation)?, strength: JohnsonCook::new(strength)? })
    })
}

/// A body's material, its places, its velocity.
type Part = (Result<Steel, Error>, ([f64; 2], [f64; 2], [f64; 2]), [f64; 2]);

fn part() -> impl Strategy<Value = Part> {
    (steel(), fill(), prop::array::uniform2(number()))
}

pub(crate) fn bodies() -> impl Strategy<Value = (Config<2>, [Part; 2])> {
    (config(), prop::array::uniform2(part()))
}

pub(crate) fn bodies_start((config, parts): (Config<2>, [Part; 2])) -> Result<(), TestCaseError> {
    let [first, second] = parts.map(|(steel, (spacing, low, high), velocity)| {
        Body::new(steel?, &Fill::of(spacing, (low, high), |_| true)?, velocity)
    });
    let (Ok(first), Ok(second)) = (first, second) else { return Ok(()) };
    if let Ok(mut run) = Simulation::new(config, vec![first, second]) {
        // An error is an answer.
        let _ = run.step();
        let _ = run.step();
        prop_assert!(!run.time().is_nan());
    }
    Ok(())
}

/// A plate of steel that flies against a wall.
fn plate() -> Simulation<f64, 2> {
    let equation = MieGruneisen::new(library::steel_equation(Units::CM_G_US)).unwrap();
    let strength = JohnsonCook::new(library::steel_strength(Units::CM_G_US)).unwrap();
    let fill = Fill::of([0.5; 2], ([0.0; 2], [2.0; 2]), |_| true).unwrap();
    let body = Body::new(Solid { equation, strength }, &fill, [-0.1, 0.0]).unwrap();
    let config = Config {
        cell: 1.0,
        origin: [0.0; 2],
        shape: Shape::QuadraticBSpline,
        transfer: Transfer::Apic,
        geometry: Geometry::Cartesian,
        viscosity: BulkViscosity { quadratic: 1.0, linear: 0.1 },
        courant_number: 0.4,
        damping: 0.0,
        gravity: [0.0; 2],
        gravity_history: vec![],
        contact: Contact::Bonded,
        boundaries: vec![Boundary {
            axis: 0,
            position: 0.0,
            side: Side::Above,
            kind: BoundaryKind::Symmetry,
        }],
        most_energy_growth: 10.0,
        most_steps: 1000,
    };
    Simulation::new(config, vec![body]).unwrap()
}

/// What a snapshot holds before its hash.
pub(crate) fn snapshot() -> Vec<u8> {
    let mut bytes = Vec::new();
    plate().snapshot(&mut bytes).unwrap();
    bytes.truncate(bytes.len() - 8);
    bytes
}

/// These bytes, and with the hash that belongs to them.
pub(crate) fn goes_on_or_is_refused(bytes: &[u8]) -> Result<(), TestCaseError> {
    let mut run = plate();
    prop_assert!(run.restore(bytes).is_err());
    let hashed = [bytes, &XxHash64::oneshot(0, bytes).to_le_bytes()].concat();
    if run.restore(hashed.as_slice()).is_ok() && run.step().is_ok() {
        prop_assert!(run.time().is_finite());
        let bodies = run.bodies();
        prop_assert!(
            bodies.iter().flat_map(|body| body.positions().iter()).flatten().all(|x| x.is_finite())
        );
    }
    Ok(())
}

/// A snapshot with another value of an attribute, by one who knows its form.
fn with(name: &str, value: Attribute) -> Vec<u8> {
    let mut bytes = Vec::new();
    plate().snapshot(&mut bytes).unwrap();
    let mut store = ParticleStore::<2>::restore(bytes.as_slice()).unwrap();
    store.set_attribute(name, value);
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    bytes
}

#[test]
fn a_snapshot_of_no_time_is_refused() {
    for name in ["time", "supplied"] {
        let bytes = with(name, Attribute::Real(f64::NAN));
        let error = plate().restore(bytes.as_slice()).unwrap_err();
        let is_named = matches!(error, Error::SnapshotNumber { quantity, .. } if quantity == name);
        assert!(is_named, "{error}");
    }
}

#[test]
fn a_snapshot_after_more_steps_than_can_be_counted_on_is_at_its_limit() {
    let mut run = plate();
    run.restore(with("n_steps", Attribute::Count(u64::MAX)).as_slice()).unwrap();
    assert!(matches!(run.step(), Err(Error::WorkLimit { .. })));
}

#[test]
fn a_step_without_end_is_refused() {
    let mut run = plate();
    run.restore(with("longest step", Attribute::Real(f64::INFINITY)).as_slice()).unwrap();
    assert!(matches!(run.step(), Err(Error::Courant { .. })));
}

proptest! {
    #[test]
    fn two_bodies_start_or_say_why_not(bodies in bodies()) {
        bodies_start(bodies)?;
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
