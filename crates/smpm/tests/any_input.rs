//! Whatever numbers come in, bodies, simulations and their first steps end in a result or a typed error: no panic, no hang, no memory
//! beyond [`MOST_BYTES`]. `PROPTEST_CASES` says how many are tried.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

use std::alloc::System;

use cap::Cap;
use proptest::prelude::*;
use smpm::material::{JohnsonCook, MieGruneisen, Solid, Units, library};
use smpm::{
    Body, Boundary, BoundaryKind, BulkViscosity, Config, Contact, Error, Fill, Geometry, Shape,
    Side, Simulation, Transfer, UpdateOrder,
};

/// An allocation beyond it ends the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// Lattices up to this are laid; larger ones take what they need, up to [`TOO_MANY`].
const MOST_PARTICLES: f64 = 1e3;
/// Lattices beyond this must be refused.
const TOO_MANY: f64 = 5e9;

/// Any double: ordinary ones, those at the ends of the range, infinities and NaN.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => 0.1..2.0,
        2 => -10.0..10.0,
        1 => any::<f64>(),
        1 => prop::sample::select(vec![
            0.0, -0.0, 1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE,
            5e-324, 1e-300, 1e300, -1e300,
        ]),
    ]
}

/// One as a rule, now and then any.
fn factor() -> impl Strategy<Value = f64> {
    prop_oneof![12 => Just(1.0), 1 => number()]
}

fn config() -> impl Strategy<Value = Config<2>> {
    let kind = prop_oneof![
        Just(BoundaryKind::Symmetry),
        Just(BoundaryKind::Clamped),
        Just(BoundaryKind::Rigid),
        (number(), number())
            .prop_map(|(longitudinal, shear)| BoundaryKind::Absorbing { longitudinal, shear }),
    ];
    let side = prop::sample::select(vec![Side::Above, Side::Below]);
    let boundary = (0_usize..3, number(), side, kind)
        .prop_map(|(axis, position, side, kind)| Boundary { axis, position, side, kind });
    let scheme = (
        prop::sample::select(vec![
            Shape::Linear,
            Shape::Gimp,
            Shape::QuadraticBSpline,
            Shape::CubicBSpline,
        ]),
        prop::sample::select(vec![
            UpdateOrder::StressFirst,
            UpdateOrder::StressLast,
            UpdateOrder::ModifiedStressLast,
        ]),
        prop_oneof![
            Just(Transfer::Apic),
            number().prop_map(|damping_time| Transfer::Flip { damping_time }),
        ],
        prop::sample::select(vec![Geometry::Cartesian, Geometry::Axisymmetric]),
        prop_oneof![
            Just(Contact::Bonded),
            number().prop_map(|coefficient| Contact::Friction { coefficient }),
        ],
    );
    let numbers = (prop::array::uniform8(factor()), factor(), any::<u64>());
    (scheme, numbers, prop::collection::vec(boundary, 0..3)).prop_map(
        |((shape, update_order, transfer, geometry, contact), numbers, boundaries)| {
            let ([cell, x, y, quadratic, linear, courant, gx, gy], growth, most_steps) = numbers;
            Config {
                cell,
                origin: [x - 1.0, y - 1.0],
                shape,
                update_order,
                transfer,
                geometry,
                viscosity: BulkViscosity { quadratic, linear },
                courant_number: 0.4 * courant,
                gravity: [gx - 1.0, gy - 1.0],
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

proptest! {
    #[test]
    fn two_bodies_start_or_say_why_not(
        config in config(),
        steels in (steel(), steel()),
        fills in (fill(), fill()),
        velocities in prop::array::uniform2(prop::array::uniform2(number())),
    ) {
        let body = |steel: Result<Steel, Error>, (spacing, low, high), velocity| {
            Body::new(steel?, &Fill::of(spacing, (low, high), |_| true)?, velocity)
        };
        let first = body(steels.0, fills.0, velocities[0]);
        let second = body(steels.1, fills.1, velocities[1]);
        let (Ok(first), Ok(second)) = (first, second) else { return Ok(()) };
        if let Ok(mut run) = Simulation::new(config, vec![first, second]) {
            // An error is an answer.
            let _ = run.step();
            let _ = run.step();
        }
    }
}
