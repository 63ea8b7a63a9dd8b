//! Fast paths to the last bit: at every width of registers, with any number of threads, and in what they break.

use std::collections::BTreeSet;

use peridyn_sde::{
    AtStrength, Body, BondConfig, BondList, Bonds, Condition, Horizon, Influence, LatticeBody,
    Nodes, Real, Strain, SurfaceCorrection, VolumeCorrection,
};
use rayon::ThreadPoolBuilder;
use sde_integrators::{Noise, Purpose, SimdLevel};

const STRENGTH: f64 = 0.05;

/// Normal strains: within the range of the series, across its border, and so large that bonds break.
const STRAINS: [f64; 3] = [2e-3, 1.5e-2, 0.1];

fn body<const D: usize>(condition: Condition, side: f64) -> (Nodes<D>, Bonds) {
    let inside = |x: &[f64; D]| x[0] + 0.3 * x[D - 1] < side;
    let nodes = Nodes::lattice(0.5, ([0.0; D], [side; D]), condition, inside).unwrap();
    let config = BondConfig {
        horizon: Horizon::of_shells(3, 0.5).unwrap(),
        young_modulus: 7.0,
        influence: Influence::Conical,
        volume_correction: VolumeCorrection::Ramp,
        surface_correction: SurfaceCorrection::None,
    };
    let bonds = Bonds::new(&nodes, &config).unwrap();
    (nodes, bonds)
}

/// Displacements, other in each lane.
fn displacements<T: Real>(count: usize, strain: f64) -> Vec<T> {
    let mut normals = vec![0.0; count];
    Noise::new(5).stream(Purpose::Field, 0).fill_normal(&mut normals);
    normals.iter().map(|z| T::of(0.35 * strain * z)).collect()
}

fn lattice<T: Real, const D: usize>(of: &(Nodes<D>, Bonds), strain: Strain) -> LatticeBody<T, D> {
    LatticeBody::new(of.0.clone(), of.1.clone(), strain, STRENGTH).unwrap()
}

fn list<T: Real, const D: usize, const L: usize>(
    of: &(Nodes<D>, Bonds),
    strain: Strain,
) -> BondList<T, D, L> {
    BondList::new(of.0.clone(), of.1.clone(), strain, &vec![STRENGTH; of.1.len()]).unwrap()
}

/// What an evaluation leaves: the forces in bits, and which bonds broke in which lane.
#[derive(Debug, PartialEq)]
struct Outcome {
    forces: Vec<u64>,
    broken: BTreeSet<(usize, usize)>,
}

/// Of two evaluations, the second without the bonds that the first has found at their strength.
fn outcome<T: Real, const D: usize, const L: usize>(
    mut body: impl Body<T, D, L>,
    strain: f64,
) -> Outcome {
    let u = displacements::<T>(body.nodes().positions().len() * D * L, strain);
    let mut forces = vec![T::ZERO; u.len()];
    let mut broken = Vec::new();
    body.forces(&u, &mut forces, AtStrength::Break(&mut broken)).unwrap();
    let all = (0..body.bonds().len()).map(|bond| body.intact(bond).count_ones() as usize);
    assert_eq!(all.sum::<usize>(), body.bonds().len() * L, "an evaluation has broken bonds");
    for of in &broken {
        body.set_intact(of.bond, body.intact(of.bond) & !of.lanes);
    }
    let without_them = forces.clone();
    body.forces(&u, &mut forces, AtStrength::Hold).unwrap();
    assert!(forces == without_them, "a bond at its strength has pulled");
    assert!(forces.iter().all(|force| force.is_finite()));
    let lanes = |lanes: u16| (0..L).filter(move |lane| lanes & 1 << lane != 0);
    let all = broken.iter().flat_map(|of| lanes(of.lanes).map(|lane| (of.bond, lane)));
    let (n_told, broken) = (all.clone().count(), all.collect::<BTreeSet<_>>());
    assert_eq!(n_told, broken.len(), "a bond was said to have broken twice");
    for bond in 0..body.bonds().len() {
        for lane in 0..L {
            let lost = body.bond_damage(bond, lane) > 0.5;
            assert_eq!(lost, broken.contains(&(bond, lane)), "bond {bond} in lane {lane}");
        }
    }
    Outcome { forces: forces.iter().map(|force| force.to_f64().to_bits()).collect(), broken }
}

/// All paths at a level.
fn outcomes<const D: usize>(
    of: &(Nodes<D>, Bonds),
    kind: Strain,
    strain: f64,
    level: SimdLevel,
) -> [Outcome; 7] {
    [
        outcome(lattice::<f64, D>(of, kind).at_level(level), strain),
        outcome(lattice::<f32, D>(of, kind).at_level(level), strain),
        outcome(list::<f64, D, 1>(of, kind).at_level(level), strain),
        outcome(list::<f32, D, 1>(of, kind).at_level(level), strain),
        outcome(list::<f64, D, 8>(of, kind).at_level(level), strain),
        outcome(list::<f64, D, 16>(of, kind).at_level(level), strain),
        outcome(list::<f32, D, 16>(of, kind).at_level(level), strain),
    ]
}

fn same_at_all_levels<const D: usize>(condition: Condition, side: f64) {
    let of = body::<D>(condition, side);
    let levels: Vec<SimdLevel> = SimdLevel::available().collect();
    for kind in [Strain::Finite, Strain::Linear] {
        for strain in STRAINS {
            let first = outcomes(&of, kind, strain, levels[0]);
            for &level in &levels[1..] {
                let found = outcomes(&of, kind, strain, level);
                for (path, (found, first)) in found.iter().zip(&first).enumerate() {
                    assert!(found == first, "path {path} {level} D={D} {kind:?} strain {strain}");
                }
            }
        }
    }
}

#[test]
fn every_fast_path_has_the_same_bits_at_every_width_of_registers() {
    same_at_all_levels::<1>(Condition::Bar { area: 0.3 }, 12.0);
    same_at_all_levels::<2>(Condition::PlaneStress { thickness: 0.3 }, 9.0);
    same_at_all_levels::<3>(Condition::Solid, 3.0);
}

#[test]
fn a_lattice_has_the_same_bits_with_any_number_of_threads() {
    let of = body::<3>(Condition::Solid, 5.0);
    for strain in STRAINS {
        let with = |n_threads: usize| {
            let pool = ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| outcome(lattice::<f64, 3>(&of, Strain::Finite), strain))
        };
        let one = with(1);
        for n_threads in [2, 8] {
            assert!(with(n_threads) == one, "{n_threads} threads, strain {strain}");
        }
    }
}

#[test]
fn a_lattice_and_a_list_break_the_same_bonds() {
    let of = body::<2>(Condition::PlaneStress { thickness: 0.3 }, 9.0);
    for kind in [Strain::Finite, Strain::Linear] {
        let on_lattice = outcome(lattice::<f64, 2>(&of, kind), 0.1).broken;
        let in_list = outcome(list::<f64, 2, 1>(&of, kind), 0.1).broken;
        // Neither none nor all: about a third of the bonds has a strain beyond its strength.
        assert!(on_lattice.len() > of.1.len() / 10 && on_lattice.len() < of.1.len() * 9 / 10);
        assert_eq!(on_lattice, in_list, "{kind:?}");
    }
}

#[test]
fn a_lattice_whose_bonds_have_strengths_of_their_own_is_a_list_within_roundoff() {
    let of = body::<2>(Condition::PlaneStress { thickness: 0.3 }, 9.0);
    // Some out of reach, as near prescribed edges.
    let strength = |bond: usize| match bond % 5 {
        0 => 1e6,
        _ => STRENGTH * (1.0 + 0.5 * (1.7 * bond as f64).sin()),
    };
    let strengths: Vec<f64> = (0..of.1.len()).map(strength).collect();
    for kind in [Strain::Finite, Strain::Linear] {
        let list = BondList::<f64, 2, 1>::new(of.0.clone(), of.1.clone(), kind, &strengths);
        let lattice = lattice::<f64, 2>(&of, kind).with_strengths(&strengths).unwrap();
        let (list, lattice) = (outcome(list.unwrap(), 0.1), outcome(lattice, 0.1));
        assert!(list.broken.len() > of.1.len() / 10);
        assert_eq!(lattice.broken, list.broken, "{kind:?}");
        assert!(list.broken.iter().all(|(bond, _)| bond % 5 != 0));
        let forces = [list, lattice].map(|of| of.forces.into_iter().map(f64::from_bits));
        let [list, lattice] = forces.map(Iterator::collect::<Vec<f64>>);
        let largest = list.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        for (a, b) in list.iter().zip(&lattice) {
            // The series of either errs by 8.4e-13 of a pull.
            assert!((a - b).abs() < 1e-11 * largest, "{kind:?}: {a} {b}");
        }
    }
    let short = lattice::<f64, 2>(&of, Strain::Finite).with_strengths(&strengths[1..]);
    assert!(matches!(short, Err(peridyn_sde::Error::Length { .. })));
}

#[test]
fn the_forces_of_a_lattice_sum_to_nothing() {
    let of = body::<2>(Condition::PlaneStress { thickness: 0.3 }, 9.0);
    for strain in STRAINS {
        let forces = outcome(lattice::<f64, 2>(&of, Strain::Finite), strain).forces;
        let forces: Vec<f64> = forces.into_iter().map(f64::from_bits).collect();
        let largest = forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        for k in 0..2 {
            let sum: f64 = forces.iter().skip(k).step_by(2).sum();
            // Both ends of a bond have its force to the last bit; sums over 36 of them, then over 340 nodes, are rounded.
            assert!(sum.abs() <= 400.0 * f64::EPSILON * largest, "{k}: {sum:e} of {largest:e}");
        }
    }
}

fn goes_on_as_cut<T: Real, const D: usize, const L: usize>(
    new: impl Fn() -> Box<dyn Body<T, D, L>>,
) {
    // In bits, under one displacement.
    let forces_of = |body: &mut Box<dyn Body<T, D, L>>| {
        let u = displacements::<T>(body.nodes().positions().len() * D * L, STRAINS[1]);
        let mut forces = vec![T::ZERO; u.len()];
        body.forces(&u, &mut forces, AtStrength::Hold).unwrap();
        forces.iter().map(|force| force.to_f64().to_bits()).collect::<Vec<u64>>()
    };
    let (mut untouched, mut cut, mut other) = (new(), new(), new());
    let bonds: Vec<usize> = (0..cut.bonds().len()).step_by(3).collect();
    for &bond in &bonds {
        cut.set_intact(bond, 0);
    }
    let (before, after) = (forces_of(&mut untouched), forces_of(&mut cut));
    assert!(before != after, "bonds that are cut pull on");
    for bond in 0..cut.bonds().len() {
        other.set_intact(bond, cut.intact(bond));
    }
    assert!(forces_of(&mut other) == after, "as saved");
    for bond in 0..cut.bonds().len() {
        other.set_intact(bond, untouched.intact(bond));
    }
    assert!(forces_of(&mut other) == before, "as if never cut");
}

#[test]
fn bonds_that_are_cut_saved_and_put_back_pull_to_the_same_bits() {
    let of = body::<2>(Condition::PlaneStress { thickness: 0.3 }, 9.0);
    for kind in [Strain::Finite, Strain::Linear] {
        goes_on_as_cut::<f64, 2, 1>(|| Box::new(list::<f64, 2, 1>(&of, kind)));
        goes_on_as_cut::<f32, 2, 1>(|| Box::new(list::<f32, 2, 1>(&of, kind)));
        goes_on_as_cut::<f64, 2, 8>(|| Box::new(list::<f64, 2, 8>(&of, kind)));
        goes_on_as_cut::<f64, 2, 1>(|| Box::new(lattice::<f64, 2>(&of, kind)));
    }
}
