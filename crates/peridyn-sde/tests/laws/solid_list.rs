//! The list of a linear peridynamic solid, of one realisation and with a realisation in each lane.

use peridyn_sde::{
    AtStrength, Body, BondConfig, Condition, Horizon, Influence, Nodes, Real, SolidBonds,
    SolidLattice, SolidList, Strain, SurfaceCorrection, VolumeCorrection,
};
use sde_integrators::SimdLevel;

use super::solid::one;

const STRENGTH: f64 = 0.06;

fn parts<const D: usize>(condition: Condition) -> (Nodes<D>, SolidBonds) {
    let side = if D == 3 { 6.0 } else { 11.0 };
    let nodes = Nodes::lattice(1.0, ([0.0; D], [side; D]), condition, |_| true).unwrap();
    let config = BondConfig {
        horizon: Horizon::of_shells(3, 1.0).unwrap(),
        young_modulus: 1.0,
        influence: Influence::Constant,
        volume_correction: VolumeCorrection::Ramp,
        surface_correction: SurfaceCorrection::Energy,
    };
    let solid = SolidBonds::new(&nodes, &config, 0.4).unwrap();
    (nodes, solid)
}

/// Of a lane.
fn shaken(n: usize, size: f64, lane: usize) -> Vec<f64> {
    (0..n).map(|at| size * (1.7 * at as f64 + 0.4 + lane as f64).sin()).collect()
}

/// Strengths of a lane, larger from lane to lane.
fn strengths(n: usize, lane: usize) -> Vec<f64> {
    vec![STRENGTH * (1.0 + 0.01 * lane as f64); n]
}

/// Lanes in which some bonds are intact; of one realisation none.
fn some<const L: usize>() -> u16 {
    if L == 1 { 0 } else { 0b0101 | 1 << (L - 1) }
}

/// Forces of all lanes, and bond and lane of those found at their strength.
type Found<T> = (Vec<T>, Vec<(usize, usize)>);

fn by_list<T: Real, const D: usize, const L: usize>(
    (nodes, solid): &(Nodes<D>, SolidBonds),
    (strain, size): (Strain, f64),
    level: SimdLevel,
) -> Found<T> {
    let (n, n_bonds) = (nodes.positions().len() * D, solid.bonds().len());
    let of_lanes: Vec<Vec<f64>> = (0..L).map(|lane| strengths(n_bonds, lane)).collect();
    let body = SolidList::<T, D, L>::new(nodes.clone(), solid.clone(), strain, &of_lanes);
    let mut body = body.unwrap().at_level(level);
    for bond in (0..n_bonds).step_by(7) {
        body.set_intact(bond, some::<L>());
    }
    let before: Vec<u16> = (0..n_bonds).map(|bond| body.intact(bond)).collect();
    let mut u = vec![T::ZERO; n * L];
    for lane in 0..L {
        for (at, value) in shaken(n, size, lane).into_iter().enumerate() {
            u[at * L + lane] = T::of(value);
        }
    }
    let (mut forces, mut found) = (vec![T::ZERO; u.len()], Vec::new());
    body.forces(&u, &mut forces, AtStrength::Break(&mut found)).unwrap();
    assert!((0..n_bonds).all(|bond| body.intact(bond) == before[bond]));
    let lanes = |lanes: u16| (0..L).filter(move |lane| lanes & 1 << lane != 0);
    let found = found.iter().flat_map(|of| lanes(of.lanes).map(|lane| (of.bond, lane)));
    let mut found: Vec<_> = found.collect();
    found.sort_unstable();
    (forces, found)
}

fn agrees<T: Real, const D: usize, const L: usize>(condition: Condition, tolerance: f64) {
    let of = parts::<D>(condition);
    let (n, n_bonds) = (of.0.positions().len() * D, of.1.bonds().len());
    for strain in [Strain::Finite, Strain::Linear] {
        for (size, breaks) in [(1e-4, false), (0.05, true)] {
            let (forces, found) = by_list::<T, D, L>(&of, (strain, size), SimdLevel::best());
            assert_eq!(!found.is_empty(), breaks);
            for level in SimdLevel::available() {
                assert!(
                    by_list::<T, D, L>(&of, (strain, size), level)
                        == (forces.clone(), found.clone())
                );
            }
            for lane in [0, 1 % L, L - 1] {
                // One realisation in double precision.
                let mut alone = one(&of.0, &of.1, strain, strengths(1, lane)[0]);
                for bond in (0..n_bonds).step_by(7) {
                    alone.set_intact(bond, some::<L>() >> lane & 1);
                }
                let (mut exact, mut broken) = (vec![0.0; n], Vec::new());
                let at = AtStrength::Break(&mut broken);
                alone.forces(&shaken(n, size, lane), &mut exact, at).unwrap();
                let of_lane = found.iter().filter(|found| found.1 == lane).map(|found| found.0);
                assert!(of_lane.eq(broken.iter().map(|of| of.bond)), "{condition:?} {lane}");
                let largest = exact.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
                let off = exact
                    .iter()
                    .enumerate()
                    .map(|(at, exact)| (forces[at * L + lane].to_f64() - exact).abs());
                let off = off.fold(0.0, f64::max) / largest;
                assert!(off < tolerance, "{condition:?} {strain:?} {size} {lane}: {off:e}");
            }
        }
    }
}

#[test]
fn every_lane_has_the_forces_and_failures_of_one_realisation_at_every_level() {
    let plate = Condition::PlaneStress { thickness: 0.5 };
    // The series errs by 8.4e-13 of a pull; single precision by its roundoff.
    agrees::<f64, 1, 8>(Condition::Bar { area: 0.5 }, 1e-11);
    agrees::<f32, 3, 1>(Condition::Solid, 1e-5);
    agrees::<f64, 2, 8>(plate, 1e-11);
    agrees::<f64, 3, 8>(Condition::Solid, 1e-11);
    agrees::<f32, 2, 16>(plate, 1e-5);
}

/// `D^2 A/(m^2 V)` of this plate in metres is beyond the numbers of single precision.
#[test]
fn a_small_plate_in_metres_has_its_forces_in_single_precision() {
    let (spacing, condition) = (2e-3, Condition::PlaneStress { thickness: 1e-3 });
    let nodes = Nodes::<2>::lattice(spacing, ([0.0; 2], [0.022; 2]), condition, |_| true).unwrap();
    let config = BondConfig {
        horizon: Horizon::of_shells(3, spacing).unwrap(),
        young_modulus: 72e9,
        influence: Influence::Constant,
        volume_correction: VolumeCorrection::Ramp,
        surface_correction: SurfaceCorrection::None,
    };
    let solid = SolidBonds::new(&nodes, &config, 0.22).unwrap();
    let (n, n_bonds) = (2 * nodes.positions().len(), solid.bonds().len());
    let u = shaken(n, 1e-4 * spacing, 0);
    let mut exact = vec![0.0; n];
    one(&nodes, &solid, Strain::Finite, 1.0).forces(&u, &mut exact, AtStrength::Hold).unwrap();
    let largest = exact.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
    let check = |forces: &[f32]| {
        for (force, exact) in forces.iter().zip(&exact) {
            assert!((f64::from(*force) - exact).abs() < 5e-6 * largest, "{force} {exact}");
        }
    };
    let strengths = vec![vec![1.0; n_bonds]; 16];
    let mut list =
        SolidList::<f32, 2, 16>::new(nodes.clone(), solid.clone(), Strain::Finite, &strengths)
            .unwrap();
    let mut forces = vec![0.0; n * 16];
    let side_by_side: Vec<f32> = u.iter().flat_map(|&u| [f32::of(u); 16]).collect();
    list.forces(&side_by_side, &mut forces, AtStrength::Hold).unwrap();
    check(&forces.iter().step_by(16).copied().collect::<Vec<_>>());
    let mut lattice = SolidLattice::<f32, 2>::new(nodes, solid, Strain::Finite, 1.0).unwrap();
    let mut forces = vec![0.0; n];
    let u: Vec<f32> = u.iter().map(|&u| f32::of(u)).collect();
    lattice.forces(&u, &mut forces, AtStrength::Hold).unwrap();
    check(&forces);
}
