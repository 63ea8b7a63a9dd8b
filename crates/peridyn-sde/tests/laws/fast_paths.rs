//! Fast paths against the reference path, and against each other.

use peridyn_sde::law::CriticalStretch;
use peridyn_sde::{
    AtStrength, Body, BondConfig, BondList, Bonds, Condition, Horizon, Influence, LatticeBody,
    Network, Nodes, Real, Strain, SurfaceCorrection, VolumeCorrection,
};
use sde_integrators::{Noise, Purpose, SimdLevel};

/// A body, bonds, and displacements whose strains are about as large as asked.
struct Case<const D: usize> {
    nodes: Nodes<D>,
    bonds: Bonds,
    u: Vec<[f64; D]>,
}

fn case<const D: usize>(
    condition: Condition,
    side: f64,
    strain: f64,
    correction: VolumeCorrection,
) -> Case<D> {
    let nodes =
        Nodes::lattice(0.5, ([0.0; D], [side; D]), condition, |x| x[0] + 0.3 * x[D - 1] < side)
            .unwrap();
    let config = BondConfig {
        horizon: Horizon::of_shells(3, 0.5).unwrap(),
        young_modulus: 7.0,
        influence: Influence::Conical,
        volume_correction: correction,
        surface_correction: SurfaceCorrection::None,
    };
    let bonds = Bonds::new(&nodes, &config).unwrap();
    let mut normals = vec![0.0; nodes.positions().len() * D];
    Noise::new(5).stream(Purpose::Field, 0).fill_normal(&mut normals);
    let u = normals.as_chunks::<D>().0.iter().map(|z| z.map(|z| 0.35 * strain * z)).collect();
    Case { nodes, bonds, u }
}

fn flat<T: Real, const D: usize, const L: usize>(u: &[[f64; D]]) -> Vec<T> {
    u.iter().flatten().flat_map(|&c| [T::of(c); L]).collect()
}

/// The largest difference of a body's forces, in any lane, to the reference, over the largest force.
fn error<T: Real, const D: usize, const L: usize>(
    mut body: impl Body<T, D, L>,
    case: &Case<D>,
    reference: &[[f64; D]],
) -> f64 {
    let u = flat::<T, D, L>(&case.u);
    let mut forces = vec![T::ZERO; u.len()];
    body.forces(&u, &mut forces, AtStrength::Break(&mut Vec::new())).unwrap();
    let largest = reference.iter().flatten().fold(0.0, |m: f64, f| m.max(f.abs()));
    let lanes = forces.as_chunks::<L>().0.iter().zip(reference.as_flattened());
    let worst = lanes.flat_map(|(lanes, f)| lanes.map(|lane| (lane.to_f64() - f).abs()));
    worst.fold(0.0, |m: f64, e| if e.is_nan() { f64::INFINITY } else { m.max(e) }) / largest
}

fn list<T: Real, const D: usize, const L: usize>(
    case: &Case<D>,
    strengths: &[f64],
) -> BondList<T, D, L> {
    BondList::new(case.nodes.clone(), case.bonds.clone(), Strain::Finite, strengths).unwrap()
}

fn agree<const D: usize>(condition: Condition, side: f64) {
    // Strains far below the series' range, across its borders, and far beyond; some bonds break at the last two.
    for strain in [1e-5, 2e-3, 1.5e-2, 0.1] {
        let case = case::<D>(condition, side, strain, VolumeCorrection::Ramp);
        let strengths = vec![0.05; case.bonds.len()];
        let (nodes, bonds) = (|| case.nodes.clone(), || case.bonds.clone());
        let mut network =
            Network::new(nodes(), bonds(), CriticalStretch, strengths.clone()).unwrap();
        let mut reference = vec![[0.0; D]; case.u.len()];
        network.advance(&case.u, &case.u, 1.0).unwrap();
        let _ = network.forces(&case.u, &mut reference).unwrap();
        for level in SimdLevel::available() {
            let lattice =
                LatticeBody::<f64, D>::new(nodes(), bonds(), Strain::Finite, 0.05).unwrap();
            let lattice32 =
                LatticeBody::<f32, D>::new(nodes(), bonds(), Strain::Finite, 0.05).unwrap();
            let found = [
                ("lattice", error(lattice.at_level(level), &case, &reference), 1e-11),
                (
                    "list",
                    error(list::<f64, D, 1>(&case, &strengths).at_level(level), &case, &reference),
                    1e-11,
                ),
                (
                    "list x 8",
                    error(list::<f64, D, 8>(&case, &strengths).at_level(level), &case, &reference),
                    1e-11,
                ),
                ("lattice f32", error(lattice32.at_level(level), &case, &reference), 5e-6),
                (
                    "list f32",
                    error(list::<f32, D, 1>(&case, &strengths).at_level(level), &case, &reference),
                    5e-6,
                ),
                (
                    "list f32 x 16",
                    error(list::<f32, D, 16>(&case, &strengths).at_level(level), &case, &reference),
                    5e-6,
                ),
            ];
            for (name, error, tolerance) in found {
                assert!(error <= tolerance, "{name} {level} D={D} strain {strain}: {error:e}");
            }
        }
    }
}

#[test]
fn every_fast_path_has_the_forces_of_the_reference() {
    agree::<1>(Condition::Bar { area: 0.3 }, 12.0);
    agree::<2>(Condition::PlaneStress { thickness: 0.3 }, 9.0);
    agree::<3>(Condition::Solid, 4.0);
}
