//! The surface correction: bonds of a body at its surface and inside it. Bodies at rest are in the case `peridyn-sde/rest`.

use peridyn_sde::law::CriticalStretch;
use peridyn_sde::{
    BondConfig, Bonds, Condition, Horizon, Network, Nodes, SurfaceCorrection, VolumeCorrection,
};

fn plate_config(rows: usize, volume: VolumeCorrection, surface: SurfaceCorrection) -> BondConfig {
    BondConfig {
        volume_correction: volume,
        surface_correction: surface,
        ..BondConfig::uncorrected(Horizon::of_shells(3, 1.0 / rows as f64).unwrap(), 1.0)
    }
}

/// The stiffness of each bond with the correction over that without.
fn factors<const D: usize>(nodes: &Nodes<D>, config: BondConfig) -> Vec<f64> {
    let of = |surface_correction| {
        Bonds::new(nodes, &BondConfig { surface_correction, ..config }).unwrap()
    };
    let (with, without) = (of(SurfaceCorrection::Energy), of(SurfaceCorrection::None));
    with.all().iter().zip(without.all()).map(|(a, b)| a.stiffness / b.stiffness).collect()
}

/// In the interior of a lattice all bonds get the same factor, which makes `C11` that of the elastic body.
#[test]
fn inside_a_lattice_the_correction_is_that_of_its_stiffness() {
    let condition = Condition::PlaneStress { thickness: 0.3 };
    let dx = 0.1;
    let nodes = Nodes::lattice(dx, ([0.0; 2], [2.0; 2]), condition, |_| true).unwrap();
    // `C11` over the elastic one, as in `lattice_stiffness.json` of the case `peridyn-sde/lattice`.
    for (c11, volume) in [
        (1.037_133_559_947_411_6, VolumeCorrection::None),
        (1.030_723_737_553_475_2, VolumeCorrection::Ramp),
    ] {
        let config = plate_config(10, volume, SurfaceCorrection::None);
        let bonds = Bonds::new(&nodes, &config).unwrap();
        let inside = |node: usize| nodes.positions()[node].iter().all(|c| (c - 1.0).abs() < 0.6);
        let (mut count, mut least) = (0, f64::INFINITY);
        for (factor, (i, j)) in factors(&nodes, config).into_iter().zip(bonds.pairs()) {
            least = least.min(factor);
            if inside(i) && inside(j) {
                assert!((factor * c11 - 1.0).abs() < 1e-12, "{c11} {factor}");
                count += 1;
            }
        }
        // A node inside has 14 bonds to those above it, and none is made softer than inside.
        assert!(count > 1000 && least * c11 > 1.0 - 1e-12, "{c11} {count} {least}");
    }
}

/// With half of the bonds of length 3 dx a bar has its very modulus, so that its bonds inside are left as they are.
#[test]
fn inside_a_bar_without_a_lattice_error_bonds_are_left_as_they_are() {
    let nodes =
        Nodes::lattice(0.01, ([0.0], [1.0]), Condition::Bar { area: 2.0 }, |_| true).unwrap();
    let config = |beyond: f64| BondConfig {
        horizon: Horizon::new((3.0 + beyond) * 0.01, 0.01).unwrap(),
        ..plate_config(100, VolumeCorrection::Partial, SurfaceCorrection::None)
    };
    // Extrapolated to the horizon 3 dx, which counts half of the bonds of that length.
    let (near, far) = (factors(&nodes, config(1e-6)), factors(&nodes, config(2e-6)));
    let bonds = Bonds::new(&nodes, &config(1e-6)).unwrap();
    for ((near, far), (i, j)) in near.iter().zip(&far).zip(bonds.pairs()) {
        if i >= 3 && j < 97 {
            assert!((2.0 * near - far - 1.0).abs() < 1e-10, "{i} {j} {near}");
        }
    }
    // The end node has half of its energy, and the bond to its neighbour, which has (1 + 1 + 2 + 1.5)/9 of it, the mean of both.
    assert!((near[0] - 0.5 * (2.0 + 9.0 / 5.5)).abs() < 1e-5, "{}", near[0]);
}

#[test]
fn a_corrected_body_rests_is_symmetric_and_loses_no_momentum() {
    let condition = Condition::PlaneStrain { thickness: 0.3 };
    let nodes = Nodes::lattice(1.0, ([-4.0; 2], [4.0; 2]), condition, |_| true).unwrap();
    let config = BondConfig {
        horizon: Horizon::of_shells(2, 1.0).unwrap(),
        ..plate_config(1, VolumeCorrection::Ramp, SurfaceCorrection::Energy)
    };
    let bonds = Bonds::new(&nodes, &config).unwrap();
    let strengths = vec![1e-9; bonds.len()];
    let mut body = Network::new(nodes, bonds, CriticalStretch, strengths).unwrap();
    let (still, n) = (vec![[0.0; 2]; 64], 64);
    let mut forces = vec![[1.0; 2]; n];
    assert!(body.forces(&still, &mut forces).unwrap() <= 0.0);
    assert!(forces.iter().flatten().all(|f| f.abs() <= 0.0));
    body.advance(&still, &still, 1.0).unwrap();
    assert!(body.damage().iter().all(|&damage| damage <= 0.0));
    // Stretched evenly: node (i, j) and its images in both axes and the diagonal.
    let u: Vec<[f64; 2]> = body.nodes().positions().iter().map(|x| x.map(|c| 1e-3 * c)).collect();
    let _ = body.forces(&u, &mut forces).unwrap();
    let largest = forces.iter().flatten().fold(0.0_f64, |most, f| most.max(f.abs()));
    for (node, force) in forces.iter().enumerate() {
        let (i, j) = (node % 8, node / 8);
        let images = [
            (8 * j + 7 - i, [-force[0], force[1]]),
            (8 * (7 - j) + i, [force[0], -force[1]]),
            (8 * i + j, [force[1], force[0]]),
        ];
        for (image, expected) in images {
            for k in 0..2 {
                assert!((forces[image][k] - expected[k]).abs() < 1e-13 * largest, "{node}");
            }
        }
    }
    for k in 0..2 {
        assert!(forces.iter().map(|f| f[k]).sum::<f64>().abs() < 1e-13 * largest);
    }
}

#[test]
fn a_row_of_nodes_in_a_plane_has_finite_corrections() {
    let condition = Condition::PlaneStress { thickness: 1.0 };
    let nodes = Nodes::lattice(1.0, ([0.0; 2], [9.0, 1.0]), condition, |_| true).unwrap();
    let config = BondConfig {
        horizon: Horizon::of_shells(3, 1.0).unwrap(),
        ..plate_config(1, VolumeCorrection::None, SurfaceCorrection::None)
    };
    assert!(factors(&nodes, config).iter().all(|factor| factor.is_finite() && *factor > 1.0));
}
