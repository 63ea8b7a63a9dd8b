//! The linear peridynamic solid on a lattice against the list, at every level and on any number of threads.

use peridyn_sde::{
    AtStrength, Body, BondConfig, Condition, Error, Horizon, Influence, Nodes, Real, SolidBonds,
    SolidLattice, Strain, SurfaceCorrection, VolumeCorrection,
};
use sde_integrators::SimdLevel;

use super::solid::one;

const STRENGTH: f64 = 0.06;
const PLANE_STRESS: Condition = Condition::PlaneStress { thickness: 0.5 };

/// With a hole, and sides that no register divides.
fn parts<const D: usize>(condition: Condition) -> (Nodes<D>, SolidBonds) {
    let side = [40.0, 19.0, 11.0][D - 1];
    let hole = |x: &[f64; D]| x.iter().map(|x| (x - 5.0).powi(2)).sum::<f64>() > 4.0;
    let nodes = Nodes::lattice(1.0, ([0.0; D], [side; D]), condition, hole).unwrap();
    let config = BondConfig {
        horizon: Horizon::of_shells(3, 1.0).unwrap(),
        young_modulus: 1.0,
        influence: Influence::Conical,
        volume_correction: VolumeCorrection::Partial,
        surface_correction: SurfaceCorrection::None,
    };
    let solid = SolidBonds::new(&nodes, &config, 0.4).unwrap();
    (nodes, solid)
}

fn shaken(n: usize, size: f64) -> Vec<f64> {
    (0..n).map(|at| size * (1.7 * at as f64 + 0.4).sin()).collect()
}

/// Forces, and the bonds found at their strength, after some were broken.
fn forces<T: Real, const D: usize>(
    mut body: impl Body<T, D, 1>,
    u: &[f64],
) -> (Vec<T>, Vec<usize>) {
    for bond in (0..body.bonds().len()).step_by(7) {
        body.set_intact(bond, 0);
    }
    let u: Vec<T> = u.iter().map(|&u| T::of(u)).collect();
    let (mut forces, mut found) = (vec![T::ZERO; u.len()], Vec::new());
    body.forces(&u, &mut forces, AtStrength::Break(&mut found)).unwrap();
    assert!(found.iter().all(|found| body.intact(found.bond) == 1 && found.bond % 7 != 0));
    let mut found: Vec<usize> = found.iter().map(|found| found.bond).collect();
    found.sort_unstable();
    (forces, found)
}

/// The largest difference over the largest force.
fn off<T: Real>(found: &[T], exact: &[f64]) -> f64 {
    let largest = exact.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
    found.iter().zip(exact).fold(0.0, |most: f64, (f, e)| most.max((f.to_f64() - e).abs()))
        / largest
}

fn agrees<const D: usize>(condition: Condition) {
    let (nodes, solid) = parts::<D>(condition);
    let n = nodes.positions().len();
    for strain in [Strain::Finite, Strain::Linear] {
        // Within the series, beyond it, and with bonds at their strength.
        for (size, breaks) in [(1e-4, false), (0.02, false), (0.05, true)] {
            let u = shaken(n * D, size);
            let list = one(&nodes, &solid, strain, STRENGTH);
            let energy = list.energy(&u, 0);
            let (exact, broken) = forces(list, &u);
            assert_eq!(!broken.is_empty(), breaks, "{condition:?} {size}");
            let lattice =
                SolidLattice::<f64, D>::new(nodes.clone(), solid.clone(), strain, STRENGTH);
            assert!((lattice.as_ref().unwrap().energy(&u, 0) / energy - 1.0).abs() < 1e-12);
            let (found, found_broken) = forces(lattice.unwrap(), &u);
            assert_eq!(found_broken, broken);
            // The series of the fast paths errs by 8.4e-13 of a pull.
            assert!(off(&found, &exact) < 1e-11, "{condition:?} {size} {:e}", off(&found, &exact));
            let single =
                SolidLattice::<f32, D>::new(nodes.clone(), solid.clone(), strain, STRENGTH);
            let (found, _) = forces(single.unwrap(), &u);
            if !breaks {
                assert!(
                    off(&found, &exact) < 1e-5,
                    "{condition:?} {size} {:e}",
                    off(&found, &exact)
                );
            }
        }
    }
}

#[test]
fn forces_and_failures_are_those_of_the_list() {
    agrees::<1>(Condition::Bar { area: 2.0 });
    agrees::<2>(PLANE_STRESS);
    agrees::<3>(Condition::Solid);
}

fn has_one_result<T: Real, const D: usize>(condition: Condition) {
    let (nodes, solid) = parts::<D>(condition);
    let u = shaken(nodes.positions().len() * D, 0.04);
    let by = |level: SimdLevel, threads: usize| {
        let body =
            SolidLattice::<T, D>::new(nodes.clone(), solid.clone(), Strain::Finite, STRENGTH);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| forces(body.unwrap().at_level(level), &u))
    };
    let first = by(SimdLevel::best(), 1);
    for level in SimdLevel::available() {
        for threads in [1, 3] {
            assert_eq!(by(level, threads), first, "{level} {threads}");
        }
    }
}

#[test]
fn every_level_and_number_of_threads_has_the_same_bits() {
    has_one_result::<f64, 2>(PLANE_STRESS);
    has_one_result::<f32, 2>(PLANE_STRESS);
    has_one_result::<f64, 3>(Condition::Solid);
    has_one_result::<f32, 1>(Condition::Bar { area: 1.0 });
}

#[test]
fn bonds_of_one_vector_must_be_alike() {
    let (nodes, _) = parts::<2>(PLANE_STRESS);
    let config = BondConfig {
        horizon: Horizon::of_shells(2, 1.0).unwrap(),
        young_modulus: 1.0,
        influence: Influence::Constant,
        volume_correction: VolumeCorrection::None,
        surface_correction: SurfaceCorrection::Energy,
    };
    let solid = SolidBonds::new(&nodes, &config, 0.2).unwrap();
    let refused = SolidLattice::<f64, 2>::new(nodes, solid, Strain::Finite, 0.1).unwrap_err();
    assert!(matches!(refused, Error::NotLattice { what: "the stiffness of a bond", .. }));
}
