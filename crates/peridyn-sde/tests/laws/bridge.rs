//! Bonds that reach their strength between the ends of a step.

use std::collections::BTreeSet;

use peridyn_sde::{
    Body, BondList, Breaking, Cause, LatticeBody, Loading, Real, Scheme, Simulation,
    SimulationConfig, Strain,
};

use crate::dynamics::plate;
use crate::fixtures::{in_time, overdamped};

const N_STEPS: usize = 20;
const STRENGTH: f64 = 0.08;

/// Which bond broke in which step and realisation, and whether it did so within the step.
type Broken = BTreeSet<(u64, u64, usize, bool)>;

fn broken<T: Real, const L: usize>(
    body: impl Body<T, 2, L> + 'static,
    breaking: Breaking,
    realisations: [u64; L],
) -> Broken {
    let n = body.nodes().positions().len();
    let dynamics = overdamped(&vec![true; n], Scheme::EulerMaruyama, 2e-3);
    let config = SimulationConfig { breaking, ..in_time(dynamics, 0.05, 3) };
    let mut run = Simulation::new(body, Loading::new(n), config, realisations).unwrap();
    let mut found = Broken::new();
    for _ in 0..N_STEPS {
        let report = run.step().unwrap();
        for event in report.broken {
            let lanes = (0..L).filter(|lane| event.lanes & 1 << lane != 0);
            let within = event.cause == Cause::Crossing;
            found.extend(lanes.map(|lane| (realisations[lane], report.step, event.bond, within)));
        }
    }
    found
}

fn list<T: Real, const L: usize>(strain: Strain, ids: [u64; L], breaking: Breaking) -> Broken {
    let (nodes, bonds) = plate(7.0);
    let strengths = vec![STRENGTH; bonds.len()];
    let body = BondList::<T, 2, L>::new(nodes, bonds, strain, &strengths).unwrap();
    broken(body, breaking, ids)
}

fn lattice(strain: Strain, id: u64) -> Broken {
    let (nodes, bonds) = plate(7.0);
    let body = LatticeBody::<f64, 2>::new(nodes, bonds, strain, STRENGTH).unwrap();
    broken(body, Breaking::Bridge, [id])
}

/// Draws are a function of seed, realisation, step and bond: other lanes do not change them.
#[test]
fn bonds_cross_alike_in_lanes_alone_and_on_a_lattice() {
    let ids: [u64; 8] = std::array::from_fn(|k| 5 + k as u64);
    for strain in [Strain::Finite, Strain::Linear] {
        let in_lanes = list::<f64, 8>(strain, ids, Breaking::Bridge);
        let alone = ids.map(|id| list::<f64, 1>(strain, [id], Breaking::Bridge));
        let on_lattice = ids.map(|id| lattice(strain, id));
        let crossed = in_lanes.iter().filter(|event| event.3).count();
        assert!(crossed > 20 && crossed < in_lanes.len(), "{crossed} of {}", in_lanes.len());
        assert_eq!(in_lanes, alone.into_iter().flatten().collect(), "{strain:?}");
        assert_eq!(in_lanes, on_lattice.into_iter().flatten().collect(), "{strain:?}");
    }
}

/// What is looked for between the ends is found earlier, and more of it.
#[test]
fn a_bridge_breaks_more_than_is_seen_at_the_ends() {
    let ids: [u64; 16] = std::array::from_fn(|k| k as u64);
    let bridged = list::<f32, 16>(Strain::Finite, ids, Breaking::Bridge);
    let at_ends = list::<f32, 16>(Strain::Finite, ids, Breaking::AtEnds);
    assert!(at_ends.iter().all(|event| !event.3));
    let of = |events: &Broken| -> BTreeSet<(u64, usize)> {
        events.iter().map(|&(realisation, _, bond, _)| (realisation, bond)).collect()
    };
    let (bridged, at_ends) = (of(&bridged), of(&at_ends));
    assert!(bridged.len() > at_ends.len(), "{} {}", bridged.len(), at_ends.len());
}
