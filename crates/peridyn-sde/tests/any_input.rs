//! Whatever numbers come in, bodies, simulations and their first steps end in a result or a typed error: no panic, no hang, no memory
//! beyond [`MOST_BYTES`]. `PROPTEST_CASES` says how many are tried.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

#[path = "../../simd-lanes/tests/shared/number.rs"]
mod any_number;

use std::alloc::System;

use cap::Cap;
use peridyn_sde::law::CriticalStretch;
use peridyn_sde::{
    BondConfig, BondList, Bonds, Breaking, Condition, Dynamics, Horizon, Influence, Loading,
    Mobility, Network, Nodes, Program, Real, SavedState, Scheme, Simulation, SimulationConfig,
    Strain, VolumeCorrection,
};
use proptest::prelude::*;
use proptest::sample::Index;
use sde_integrators::Noise;

/// An allocation beyond it ends the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// Lattices up to this are laid; larger ones take what they need, up to [`TOO_MANY`].
const MOST_NODES: f64 = 300.0;
/// Lattices beyond this must be refused.
const TOO_MANY: f64 = 5e9;

/// Any double.
fn number() -> impl Strategy<Value = f64> {
    any_number::number(0.0..2.0, 6)
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Body {
    spacing: f64,
    edge: f64,
    thickness: f64,
    shells: u32,
    young_modulus: f64,
    influence: Influence,
}

fn body() -> impl Strategy<Value = Body> {
    let shells = prop_oneof![8 => 0_u32..4, 1 => any::<u32>()];
    let edge = prop_oneof![4 => 2.0..8.0, 1 => number()];
    let spacing = prop_oneof![4 => 0.5..1.5, 1 => number()];
    let influence = prop::sample::select(Influence::ALL.to_vec());
    (spacing, edge, number(), shells, number(), influence)
        .prop_map(|(spacing, edge, thickness, shells, young_modulus, influence)| Body {
            spacing,
            edge,
            thickness,
            shells,
            young_modulus,
            influence,
        })
        .prop_filter("a lattice that is laid, and only slow", |body| {
            !(MOST_NODES..TOO_MANY).contains(&(body.edge / body.spacing).abs().powi(2))
        })
}

impl Body {
    fn build(self) -> Result<(Nodes<2>, Bonds), peridyn_sde::Error> {
        let condition = Condition::PlaneStress { thickness: self.thickness };
        let nodes = Nodes::lattice(self.spacing, ([0.0; 2], [self.edge; 2]), condition, |_| true)?;
        let config = BondConfig {
            influence: self.influence,
            volume_correction: VolumeCorrection::Ramp,
            ..BondConfig::uncorrected(
                Horizon::of_shells(self.shells, self.spacing)?,
                self.young_modulus,
            )
        };
        let bonds = Bonds::new(&nodes, &config)?;
        Ok((nodes, bonds))
    }
}

fn scheme() -> impl Strategy<Value = Scheme> {
    prop_oneof![
        Just(Scheme::EulerMaruyama),
        Just(Scheme::LeimkuhlerMatthews),
        Just(Scheme::Heun),
        number().prop_map(Scheme::Theta),
    ]
}

/// A plate and how it is run.
#[derive(Debug)]
pub(crate) struct Plate {
    body: Body,
    /// Inertial without one.
    scheme: Option<Scheme>,
    /// Mobility or density.
    value: f64,
    temperature: f64,
    friction: f64,
    dt: f64,
    strength: f64,
    confinement: f64,
    rate: f64,
    breaking: Breaking,
    seed: u64,
}

pub(crate) fn plate() -> impl Strategy<Value = Plate> {
    let breaking = prop::sample::select(vec![Breaking::AtEnds, Breaking::Bridge]);
    let parts = (
        body(),
        prop::option::of(scheme()),
        prop::array::uniform7(number()),
        (breaking, any::<u64>()),
    );
    parts.prop_map(|(body, scheme, numbers, (breaking, seed))| {
        let [value, temperature, friction, dt, strength, confinement, rate] = numbers;
        Plate {
            body,
            scheme,
            value,
            temperature,
            friction,
            dt,
            strength,
            confinement,
            rate,
            breaking,
            seed,
        }
    })
}

#[allow(clippy::needless_pass_by_value, reason = "every check takes what is drawn")]
pub(crate) fn starts(plate: Plate) -> Result<(), TestCaseError> {
    let Plate { value, temperature, friction, dt, strength, confinement, breaking, .. } = plate;
    let Ok((nodes, bonds)) = plate.body.build() else { return Ok(()) };
    let n = nodes.positions().len();
    let free: Vec<bool> = (0..n).map(|node| node > 0).collect();
    let dynamics = match plate.scheme {
        Some(scheme) => match Mobility::identity(&free, value) {
            Ok(mobility) => Dynamics::Overdamped { mobility, temperature, scheme },
            Err(_) => return Ok(()),
        },
        None => Dynamics::Inertial { density: value, friction, temperature },
    };
    let noise = Noise::new(plate.seed);
    let config = SimulationConfig { dynamics, dt, breaking, confinement, noise };
    let program = Program::Linear { rate: plate.rate };
    let loading = Loading::new(n).displace(&[0], [true; 2], [1.0, 0.0], program);
    let Ok(loading) = loading else { return Ok(()) };
    let strengths = vec![strength; bonds.len()];
    if let Ok(network) =
        Network::new(nodes.clone(), bonds.clone(), CriticalStretch, strengths.clone())
        && let Ok(mut run) = Simulation::new(network, loading.clone(), config.clone(), [0])
    {
        // An error is an answer.
        let _ = run.step();
    }
    let list = BondList::<f32, 2, 16>::new(nodes, bonds, Strain::Finite, &strengths);
    let ids = std::array::from_fn(|lane| lane as u64);
    if let Ok(list) = list
        && let Ok(mut run) = Simulation::new(list, loading, config, ids)
    {
        let _ = run.step();
        let is_number = run.displacements(0).iter().flatten().all(|u| !u.is_nan());
        prop_assert!(is_number || run.step().is_err());
    }
    Ok(())
}

/// A plate of 25 nodes whose edges are held, in `L` lanes.
fn held<T: Real, const L: usize>(is_inertial: bool) -> Simulation<T, 2, L> {
    let body = Body {
        spacing: 1.0,
        edge: 5.0,
        thickness: 1.0,
        shells: 2,
        young_modulus: 1.0,
        influence: Influence::Constant,
    };
    let (nodes, bonds) = body.build().unwrap();
    let n = nodes.positions().len();
    let held: Vec<usize> = (0..n).filter(|node| node % 5 == 0).collect();
    let free: Vec<bool> = (0..n).map(|node| node % 5 != 0).collect();
    let program = Program::Linear { rate: 0.1 };
    let loading = Loading::new(n).displace(&held, [true; 2], [1.0, 0.0], program).unwrap();
    let dynamics = if is_inertial {
        Dynamics::Inertial { density: 1.0, friction: 1.0, temperature: 1e-4 }
    } else {
        let mobility = Mobility::identity(&free, 1.0).unwrap();
        Dynamics::Overdamped { mobility, temperature: 1e-4, scheme: Scheme::LeimkuhlerMatthews }
    };
    let noise = Noise::new(3);
    let breaking = Breaking::AtEnds;
    let config = SimulationConfig { dynamics, dt: 1e-3, breaking, confinement: 0.0, noise };
    let strengths = vec![0.1; bonds.len()];
    let list = BondList::<T, 2, L>::new(nodes, bonds, Strain::Finite, &strengths).unwrap();
    Simulation::new(list, loading, config, std::array::from_fn(|lane| lane as u64)).unwrap()
}

/// What was saved, with other numbers.
#[derive(Debug, Clone)]
pub(crate) struct Forged {
    is_inertial: bool,
    step: u64,
    /// Of displacements and velocities: index and value.
    numbers: [Vec<(Index, f64)>; 2],
    whole: Vec<(Index, u16)>,
    /// How long the columns are, of what they should be.
    lengths: [Option<Index>; 3],
}

pub(crate) fn forged() -> impl Strategy<Value = Forged> {
    let step = prop_oneof![4 => 0_u64..1000, 1 => any::<u64>(), 1 => Just(u64::MAX)];
    let changes = || prop::collection::vec((any::<Index>(), number()), 0..4);
    let whole = prop_oneof![4 => 0_u16..2, 1 => any::<u16>()];
    let whole = prop::collection::vec((any::<Index>(), whole), 0..4);
    let lengths = prop::array::uniform3(prop::option::weighted(0.05, any::<Index>()));
    (any::<bool>(), step, [changes(), changes()], whole, lengths).prop_map(
        |(is_inertial, step, numbers, whole, lengths)| Forged {
            is_inertial,
            step,
            numbers,
            whole,
            lengths,
        },
    )
}

fn goes_on_in<T: Real, const L: usize>(forged: &Forged) -> Result<(), TestCaseError> {
    let mut run = held::<T, L>(forged.is_inertial);
    let _ = run.step().unwrap();
    let before = run.save().unwrap();
    let mut saved = SavedState { step: forged.step, ..before.clone() };
    let columns = [&mut saved.displacements, &mut saved.velocities];
    for ((column, changes), length) in columns.into_iter().zip(&forged.numbers).zip(&forged.lengths)
    {
        for (at, value) in changes {
            let at = at.index(column.len());
            column[at] = *value;
        }
        column.truncate(length.map_or(column.len(), |length| length.index(column.len())));
    }
    let n = saved.whole.len();
    for (at, whole) in &forged.whole {
        saved.whole[at.index(n)] = *whole;
    }
    saved.whole.truncate(forged.lengths[2].map_or(n, |length| length.index(n)));
    if run.restore(&saved).is_err() {
        prop_assert_eq!(run.save().unwrap(), before);
        return Ok(());
    }
    prop_assert_eq!(run.steps(), forged.step);
    if run.step().is_ok() {
        prop_assert!(run.time().is_finite());
        let lanes = (0..L).flat_map(|lane| run.displacements(lane));
        prop_assert!(lanes.flatten().all(f64::is_finite));
    }
    Ok(())
}

#[allow(clippy::needless_pass_by_value, reason = "every check takes what is drawn")]
pub(crate) fn goes_on_or_is_refused(forged: Forged) -> Result<(), TestCaseError> {
    goes_on_in::<f64, 1>(&forged)?;
    goes_on_in::<f32, 16>(&forged)
}

proptest! {
    #[test]
    fn a_plate_starts_or_says_why_not(plate in plate()) {
        starts(plate)?;
    }

    #[test]
    fn a_forged_state_goes_on_or_is_refused(forged in forged()) {
        goes_on_or_is_refused(forged)?;
    }
}
