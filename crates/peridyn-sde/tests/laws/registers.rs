//! Forces in wide registers: both potentials in every order of visiting, against reference forces, at every width of registers, with
//! any number of threads, and in what they break.

use std::collections::BTreeSet;

use peridyn_sde::law::CriticalStretch;
use peridyn_sde::{
    AtStrength, Body, BondConfig, BondList, Bonds, Condition, Error, Horizon, Influence,
    LatticeBody, Network, Nodes, Real, SolidBonds, Strain, SurfaceCorrection, VolumeCorrection,
};
use rayon::ThreadPoolBuilder;
use sde_integrators::SimdLevel;

const STRENGTH: f64 = 0.06;
const PLATE: Condition = Condition::PlaneStress { thickness: 0.5 };

/// A body with a hole, and sides that no register divides.
struct Case<const D: usize> {
    nodes: Nodes<D>,
    bonds: Bonds,
    solid: SolidBonds,
}

impl<const D: usize> Case<D> {
    fn new(condition: Condition) -> Self {
        let side = [40.0, 19.0, 8.0][D - 1];
        let hole = |x: &[f64; D]| x.iter().map(|x| (x - 5.0).powi(2)).sum::<f64>() > 4.0;
        let nodes = Nodes::lattice(1.0, ([0.0; D], [side; D]), condition, hole).unwrap();
        let config = BondConfig {
            influence: Influence::Conical,
            volume_correction: VolumeCorrection::Ramp,
            ..BondConfig::uncorrected(Horizon::of_shells(3, 1.0).unwrap(), 1.0)
        };
        let bonds = Bonds::new(&nodes, &config).unwrap();
        let solid = SolidBonds::new(&nodes, &config, 0.4).unwrap();
        Self { nodes, bonds, solid }
    }
}

/// A potential, a strain measure and displacements.
#[derive(Debug, Clone, Copy)]
struct Setup {
    is_solid: bool,
    strain: Strain,
    /// Whether bonds and lanes have strengths of their own.
    own: bool,
    /// The largest displacement: within the series of a pull, beyond it, and with bonds at their strength.
    size: f64,
}

const BREAKS: f64 = 0.07;

fn setups() -> impl Iterator<Item = Setup> {
    let kinds = [false, true].into_iter().flat_map(|is_solid| {
        [Strain::Finite, Strain::Linear].into_iter().map(move |strain| (is_solid, strain))
    });
    kinds.flat_map(|(is_solid, strain)| {
        let cases = [(1e-4, false), (0.02, true), (BREAKS, false), (BREAKS, true)];
        cases.map(|(size, own)| Setup { is_solid, strain, own, size })
    })
}

/// The strengths of a lane; some of its own are out of reach, as near prescribed edges.
fn strengths(setup: Setup, n_bonds: usize, lane: usize) -> Vec<f64> {
    let own = |bond: usize| match bond % 5 {
        0 => 1e6,
        _ => STRENGTH * (1.0 + 0.01 * lane as f64 + 0.3 * (1.7 * bond as f64).sin()),
    };
    (0..n_bonds).map(|bond| if setup.own { own(bond) } else { STRENGTH }).collect()
}

fn list<T: Real, const D: usize, const L: usize>(
    Case { nodes, bonds, solid }: &Case<D>,
    setup: Setup,
    first: usize,
) -> BondList<T, D, L> {
    let (nodes, strain, n) = (nodes.clone(), setup.strain, bonds.len());
    let lanes: Vec<_> = (first..first + L).map(|lane| strengths(setup, n, lane)).collect();
    let body = if setup.is_solid {
        BondList::of_solid(nodes, solid.clone(), strain, &lanes[0]).unwrap()
    } else {
        BondList::new(nodes, bonds.clone(), strain, &lanes[0]).unwrap()
    };
    if setup.own { body.with_strengths(&lanes).unwrap() } else { body }
}

/// The lattice body with the strengths of lane 0.
fn lattice<T: Real, const D: usize>(
    Case { nodes, bonds, solid }: &Case<D>,
    setup: Setup,
) -> LatticeBody<T, D> {
    let (nodes, strain) = (nodes.clone(), setup.strain);
    let body = if setup.is_solid {
        LatticeBody::of_solid(nodes, solid.clone(), strain, STRENGTH).unwrap()
    } else {
        LatticeBody::new(nodes, bonds.clone(), strain, STRENGTH).unwrap()
    };
    if setup.own { body.with_strengths(&strengths(setup, bonds.len(), 0)).unwrap() } else { body }
}

/// Displacements of a lane.
fn displacements(n: usize, size: f64, lane: usize) -> Vec<f64> {
    (0..n).map(|at| size * (1.7 * at as f64 + 0.4 + lane as f64).sin()).collect()
}

/// Whether a bond is intact in a lane before the evaluation.
fn is_intact(bond: usize, lane: usize) -> bool {
    !(bond.is_multiple_of(7) || bond % 7 == 3 && lane.is_multiple_of(2))
}

/// The forces of a lane after an evaluation, and the bonds found at their strength.
#[derive(Debug, Clone, PartialEq)]
struct Outcome {
    forces: Vec<f64>,
    broken: BTreeSet<usize>,
}

/// Of all lanes, the first of which is lane `first`.
fn outcomes<T: Real, const D: usize, const L: usize>(
    mut body: impl Body<T, D, L>,
    size: f64,
    first: usize,
) -> Vec<Outcome> {
    let (n, n_bonds) = (body.nodes().positions().len() * D, body.bonds().len());
    for bond in 0..n_bonds {
        let intact = (0..L).filter(|lane| is_intact(bond, first + lane));
        body.set_intact(bond, intact.fold(0, |lanes, lane| lanes | 1 << lane));
    }
    let before: Vec<u16> = (0..n_bonds).map(|bond| body.intact(bond)).collect();
    let mut u = vec![T::ZERO; n * L];
    for lane in 0..L {
        for (at, value) in displacements(n, size, first + lane).into_iter().enumerate() {
            u[at * L + lane] = T::of(value);
        }
    }
    let (mut forces, mut broken) = (vec![T::ZERO; u.len()], Vec::new());
    body.forces(&u, &mut forces, AtStrength::Break(&mut broken)).unwrap();
    assert!((0..n_bonds).all(|bond| body.intact(bond) == before[bond]), "bonds were broken");
    for of in &broken {
        assert!(of.lanes & !body.intact(of.bond) == 0, "a bond was found twice or broken before");
        body.set_intact(of.bond, body.intact(of.bond) & !of.lanes);
    }
    let without_them = forces.clone();
    body.forces(&u, &mut forces, AtStrength::Hold).unwrap();
    assert!(forces == without_them, "a bond at its strength has pulled");
    let of_lane = |lane: usize| Outcome {
        forces: forces.iter().skip(lane).step_by(L).map(|force| force.to_f64()).collect(),
        broken: broken.iter().filter(|of| of.lanes & 1 << lane != 0).map(|of| of.bond).collect(),
    };
    (0..L).map(of_lane).collect()
}

/// Forces of a pair potential bond by bond, at finite strains; of others by one realisation of a list in double precision.
fn reference<const D: usize>(case: &Case<D>, setup: Setup, lane: usize) -> Outcome {
    let Setup { is_solid, strain, size, .. } = setup;
    if is_solid || strain == Strain::Linear {
        return outcomes(list::<f64, D, 1>(case, setup, lane), size, lane).remove(0);
    }
    let n_bonds = case.bonds.len();
    let (nodes, bonds) = (case.nodes.clone(), case.bonds.clone());
    let strengths = strengths(setup, n_bonds, lane);
    let mut network = Network::new(nodes, bonds, CriticalStretch, strengths).unwrap();
    let cut: Vec<usize> = (0..n_bonds).filter(|&bond| !is_intact(bond, lane)).collect();
    network.cut(&cut).unwrap();
    let u = displacements(case.nodes.positions().len() * D, size, lane);
    let u = u.as_chunks::<D>().0;
    network.advance(u, u, 1.0).unwrap();
    let mut forces = vec![[0.0; D]; u.len()];
    let _ = Network::forces(&network, u, &mut forces).unwrap();
    let found = network.states().iter().enumerate().filter(|(_, broken)| **broken);
    let broken = found.map(|(bond, _)| bond).filter(|&bond| is_intact(bond, lane)).collect();
    Outcome { forces: forces.into_flattened(), broken }
}

fn largest(forces: &[f64]) -> f64 {
    forces.iter().fold(0.0, |most, force| most.max(force.abs()))
}

/// The largest difference of a force over the largest force.
fn off(found: &Outcome, exact: &Outcome) -> f64 {
    let apart = found.forces.iter().zip(&exact.forces).map(|(a, b)| (a - b).abs());
    apart.fold(0.0, |most: f64, e| if e.is_nan() { f64::INFINITY } else { most.max(e) })
        / largest(&exact.forces)
}

/// Every path of a precision has the forces of the reference, and is bitwise identical at every level.
fn agrees<T: Real, const D: usize, const L: usize>(condition: Condition, tolerance: f64) {
    let case = Case::<D>::new(condition);
    for setup in setups() {
        let at = |level: SimdLevel| {
            let on_lattice = outcomes(lattice::<T, D>(&case, setup).at_level(level), setup.size, 0);
            let alone = list::<T, D, 1>(&case, setup, 1).at_level(level);
            let in_lanes = list::<T, D, L>(&case, setup, 0).at_level(level);
            (on_lattice, outcomes(alone, setup.size, 1), outcomes(in_lanes, setup.size, 0))
        };
        let first = at(SimdLevel::best());
        for level in SimdLevel::available() {
            assert!(at(level) == first, "{level} {condition:?} {setup:?}");
        }
        let (on_lattice, alone, in_lanes) = first;
        for (lane, name, found) in [
            (0, "lattice", &on_lattice[0]),
            (1, "list", &alone[0]),
            (0, "first lane", &in_lanes[0]),
            (1, "second lane", &in_lanes[1]),
            (L - 1, "last lane", &in_lanes[L - 1]),
        ] {
            let exact = reference(&case, setup, lane);
            let label = format!("{name} of {} {condition:?} {setup:?}", T::NAME);
            let off = off(found, &exact);
            assert!(off <= tolerance, "{label}: {off:e}");
            assert_eq!(found.broken, exact.broken, "{label}");
            let share = found.broken.len() as f64 / case.bonds.len() as f64;
            assert!(share < 0.9 && (share > 0.01) == (setup.size >= BREAKS), "{label}: {share}");
            assert!(!setup.own || found.broken.iter().all(|bond| bond % 5 != 0), "{label}");
        }
        // Both ends of a bond have its force to the last bit; sums over some bonds of a node, then over the nodes, are rounded.
        let epsilon = if T::NAME == "f64" { f64::EPSILON } else { f64::from(f32::EPSILON) };
        for k in 0..D {
            let forces = &on_lattice[0].forces;
            let sum: f64 = forces.iter().skip(k).step_by(D).sum();
            assert!(sum.abs() <= 500.0 * epsilon * largest(forces), "{setup:?} {sum:e}");
        }
    }
}

/// The series errs by 8.4e-13 of a pull; single precision by its roundoff.
#[test]
fn every_path_has_the_forces_and_failures_of_the_reference_and_one_result_at_all_levels() {
    agrees::<f64, 1, 8>(Condition::Bar { area: 0.5 }, 1e-11);
    agrees::<f64, 2, 8>(PLATE, 1e-11);
    agrees::<f64, 3, 8>(Condition::Solid, 1e-11);
    agrees::<f64, 2, 16>(PLATE, 1e-11);
}

#[test]
fn every_path_in_single_precision_has_the_forces_of_the_reference_and_one_result_at_all_levels() {
    agrees::<f32, 1, 16>(Condition::Bar { area: 0.5 }, 1e-5);
    agrees::<f32, 2, 16>(PLATE, 1e-5);
    agrees::<f32, 3, 16>(Condition::Solid, 1e-5);
}

#[test]
fn a_lattice_has_the_same_bits_with_any_number_of_threads() {
    let case = Case::<2>::new(PLATE);
    for setup in setups() {
        let with = |n_threads: usize| {
            let pool = ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| outcomes(lattice::<f64, 2>(&case, setup), setup.size, 0))
        };
        let one = with(1);
        for n_threads in [2, 8] {
            assert!(with(n_threads) == one, "{n_threads} threads, {setup:?}");
        }
    }
}

/// Cut, saved and put back, with forces in bits.
fn goes_on_as_cut<T: Real, const L: usize>(new: impl Fn() -> Box<dyn Body<T, 2, L>>) {
    let forces_of = |body: &mut dyn Body<T, 2, L>| {
        let n = body.nodes().positions().len() * 2 * L;
        let u: Vec<T> = displacements(n, 0.02, 0).into_iter().map(T::of).collect();
        let mut forces = vec![T::ZERO; n];
        body.forces(&u, &mut forces, AtStrength::Hold).unwrap();
        forces.iter().map(|force| force.to_f64().to_bits()).collect::<Vec<u64>>()
    };
    let (mut untouched, mut cut, mut other) = (new(), new(), new());
    for bond in (0..cut.bonds().len()).step_by(3) {
        cut.set_intact(bond, 0);
    }
    let (before, after) = (forces_of(&mut *untouched), forces_of(&mut *cut));
    assert!(before != after, "bonds that are cut pull on");
    for (body, forces) in [(cut, after), (untouched, before)] {
        for bond in 0..body.bonds().len() {
            other.set_intact(bond, body.intact(bond));
        }
        assert!(forces_of(&mut *other) == forces);
    }
}

#[test]
fn bonds_that_are_cut_saved_and_put_back_pull_to_the_same_bits() {
    let case = Case::<2>::new(PLATE);
    for setup in setups().filter(|setup| !setup.own && setup.size < BREAKS) {
        goes_on_as_cut::<f64, 1>(|| Box::new(list(&case, setup, 0)));
        goes_on_as_cut::<f32, 1>(|| Box::new(list(&case, setup, 0)));
        goes_on_as_cut::<f64, 8>(|| Box::new(list(&case, setup, 0)));
        goes_on_as_cut::<f64, 1>(|| Box::new(lattice(&case, setup)));
    }
}

/// `D^2 A/(m^2 V)` of this plate in metres is beyond the numbers of single precision.
#[test]
fn a_small_plate_in_metres_has_its_forces_in_single_precision() {
    let (spacing, condition) = (2e-3, Condition::PlaneStress { thickness: 1e-3 });
    let nodes = Nodes::<2>::lattice(spacing, ([0.0; 2], [0.022; 2]), condition, |_| true).unwrap();
    let config = BondConfig {
        volume_correction: VolumeCorrection::Ramp,
        ..BondConfig::uncorrected(Horizon::of_shells(3, spacing).unwrap(), 72e9)
    };
    let solid = SolidBonds::new(&nodes, &config, 0.22).unwrap();
    let case = Case { bonds: solid.bonds().clone(), nodes, solid };
    let (strain, size) = (Strain::Finite, 1e-4 * spacing);
    let setup = Setup { is_solid: true, strain, own: false, size };
    let exact = reference(&case, setup, 0);
    let in_lanes = outcomes(list::<f32, 2, 16>(&case, setup, 0), size, 0);
    let on_lattice = outcomes(lattice::<f32, 2>(&case, setup), size, 0);
    for found in [&in_lanes[0], &on_lattice[0]] {
        assert!(off(found, &exact) < 5e-6);
    }
}

#[test]
fn strengths_of_another_body_and_bonds_of_one_vector_that_are_not_alike_are_refused() {
    let Case { nodes, bonds, solid } = Case::<2>::new(PLATE);
    let body = LatticeBody::<f64, 2>::new(nodes.clone(), bonds.clone(), Strain::Finite, STRENGTH);
    let short = body.unwrap().with_strengths(&vec![STRENGTH; bonds.len() - 1]);
    assert!(matches!(short, Err(Error::Length { .. })));
    let list = BondList::<f64, 2, 8>::of_solid(nodes.clone(), solid, Strain::Finite, &[0.1]);
    assert!(matches!(list, Err(Error::Length { .. })));
    let config = BondConfig {
        surface_correction: SurfaceCorrection::Energy,
        ..BondConfig::uncorrected(Horizon::of_shells(2, 1.0).unwrap(), 1.0)
    };
    let solid = SolidBonds::new(&nodes, &config, 0.2).unwrap();
    let strengths = vec![0.1; solid.bonds().len()];
    let list =
        BondList::<f64, 2, 1>::of_solid(nodes.clone(), solid.clone(), Strain::Finite, &strengths);
    let varying = list.unwrap().with_stiffness_factors(&[strengths]).unwrap_err();
    assert!(matches!(varying, Error::UniformStiffness { .. }));
    let refused = LatticeBody::<f64, 2>::of_solid(nodes, solid, Strain::Finite, 0.1).unwrap_err();
    assert!(matches!(refused, Error::NotLattice { what: "the stiffness of a bond", .. }));
}
