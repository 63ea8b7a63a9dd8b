//! Forces against LAMMPS and against the energy.

use peridyn_sde::law::{Bilinear, CriticalStretch, Memory};
use peridyn_sde::{
    BondConfig, BondLaw, Bonds, Condition, Error, Horizon, Network, Nodes, VolumeCorrection,
};

use crate::fixtures::{bonded, config, cube, rows, shaken};

fn are_slopes_of_the_energy<L: BondLaw, const D: usize>(law: L, condition: Condition) {
    let side = if D == 3 { 4.0 } else { 6.0 };
    let (nodes, bonds) = bonded(side, condition, 2);
    let n = nodes.positions().len();
    let strengths = vec![0.2; bonds.len()];
    let mut network = Network::new(nodes, bonds, law, strengths).unwrap();
    network.cut(&[0, 3]).unwrap();
    let (still, mut u) = (vec![[0.0; D]; n], shaken::<D>(n, 0.03));
    network.advance(&still, &u, 0.1).unwrap();
    let mut forces = vec![[0.0; D]; n];
    let _ = network.forces(&u, &mut forces).unwrap();
    let mut unused = forces.clone();
    for node in [0, n / 2, n - 1] {
        for k in 0..D {
            let delta = 1e-6;
            let here = u[node][k];
            u[node][k] = here + delta;
            let above = network.forces(&u, &mut unused).unwrap();
            u[node][k] = here - delta;
            let below = network.forces(&u, &mut unused).unwrap();
            u[node][k] = here;
            let slope = (above - below) / (2.0 * delta);
            // The energy of some 1e-2 has an error of 1e-17, its difference of 1e-11.
            assert!((slope + forces[node][k]).abs() < 1e-9, "{slope} {}", forces[node][k]);
        }
    }
    for k in 0..D {
        let (sum, size) =
            forces.iter().fold((0.0, 0.0), |(sum, size), f| (sum + f[k], size + f[k].abs()));
        assert!(sum.abs() < 1e-13 * size, "{sum} of {size}");
    }
}

#[test]
fn forces_are_minus_the_slope_of_the_energy_and_sum_to_nothing() {
    let plate = Condition::PlaneStress { thickness: 0.5 };
    are_slopes_of_the_energy::<_, 1>(CriticalStretch, Condition::Bar { area: 2.0 });
    are_slopes_of_the_energy::<_, 2>(CriticalStretch, plate);
    are_slopes_of_the_energy::<_, 3>(CriticalStretch, Condition::Solid);
    are_slopes_of_the_energy::<_, 2>(Bilinear::new(3.0).unwrap(), plate);
    let memory = Memory::new(10.0, 1.0, (2.0, 2.0), 0.9).unwrap();
    are_slopes_of_the_energy::<_, 2>(memory, plate);
}

#[test]
fn the_stiffness_of_a_bond_has_the_volumes_of_both_ends() {
    let (places, volumes) = (vec![[0.0], [1.0], [2.0]], [0.5, 2.0, 3.0]);
    let of = |volumes: &[f64]| {
        let bar = Condition::Bar { area: 1.0 };
        let nodes = Nodes::new(places.clone(), volumes.to_vec(), 1.0, bar).unwrap();
        Bonds::new(&nodes, &config(2)).unwrap()
    };
    let (equal, unequal) = (of(&[1.0; 3]), of(&volumes));
    let bonds = equal.all().iter().zip(unequal.all());
    for ((one, other), (i, j)) in bonds.zip(unequal.pairs()) {
        let ratio = other.stiffness / one.stiffness / (volumes[i] * volumes[j]);
        assert!((ratio - 1.0).abs() < 1e-14, "{i} {j}: {ratio}");
    }
    assert_eq!(unequal.len(), 3);
}

#[test]
fn bonds_break_in_tension_alone_and_for_good() {
    let nodes =
        Nodes::new(vec![[0.0], [1.0]], vec![1.0; 2], 1.0, Condition::Bar { area: 1.0 }).unwrap();
    let bonds = Bonds::new(&nodes, &config(1)).unwrap();
    let mut network = Network::new(nodes, bonds, CriticalStretch, vec![0.1]).unwrap();
    let at = |s: f64| [[0.0], [s]];
    network.advance(&at(0.0), &at(-0.5), 1.0).unwrap();
    assert!(network.damage().iter().all(|&damage| damage <= 0.0));
    network.advance(&at(-0.5), &at(0.1), 1.0).unwrap();
    network.advance(&at(0.1), &at(0.0), 1.0).unwrap();
    assert!(network.damage().iter().all(|&damage| damage >= 1.0));
    let mut forces = [[1.0]; 2];
    assert!(network.forces(&at(0.05), &mut forces).unwrap() <= 0.0);
    assert!(forces.iter().all(|f| f[0].abs() <= 0.0));
}

#[test]
fn what_cannot_be_is_refused_with_its_value() {
    let bar = Condition::Bar { area: 1.0 };
    let refused = |positions: Vec<[f64; 1]>, volumes: Vec<f64>| {
        let nodes = Nodes::new(positions, volumes, 1.0, bar)?;
        Bonds::new(&nodes, &config(1))
    };
    assert_eq!(refused(vec![], vec![]).unwrap_err(), Error::EmptyBody { spacing: 1.0 });
    let negative = refused(vec![[0.0], [1.0]], vec![1.0, -1.0]).unwrap_err();
    assert_eq!(
        negative.to_string(),
        "the volume of node 1 is -1; it must be greater than 0 and finite"
    );
    let nan = refused(vec![[0.0], [f64::NAN]], vec![1.0; 2]).unwrap_err();
    assert_eq!(nan.to_string(), "a coordinate of node 1 is NaN; it must be finite");
    let short = refused(vec![[0.0], [1.0]], vec![1.0]).unwrap_err();
    assert_eq!(short, Error::Length { name: "volumes", value: 1, expected: 2 });
    let twice = refused(vec![[0.0], [0.0]], vec![1.0; 2]).unwrap_err();
    assert_eq!(twice, Error::Coincident { first: 0, second: 1 });
    let far = refused(vec![[0.0], [1.0], [9.0]], vec![1.0; 3]).unwrap_err();
    assert_eq!(far, Error::LooseNode { node: 2, horizon: 1.015 });
    let plate = Condition::PlaneStress { thickness: 1.0 };
    let flat = Nodes::new(vec![[0.0]], vec![1.0], 1.0, plate).unwrap_err();
    assert_eq!(flat.to_string(), "plane stress has 2 dimensions; the body has 1");

    let nodes = Nodes::new(vec![[0.0], [1.0]], vec![1.0; 2], 1.0, bar).unwrap();
    let bonds = Bonds::new(&nodes, &config(1)).unwrap();
    let weak = Network::new(nodes.clone(), bonds.clone(), CriticalStretch, vec![-0.1]).unwrap_err();
    assert!(matches!(weak, Error::Parameter { name: "strength of a bond", .. }));
    let mut network = Network::new(nodes, bonds, CriticalStretch, vec![0.1]).unwrap();
    let mut forces = [[0.0]; 2];
    let lost = network.forces(&[[0.0], [f64::INFINITY]], &mut forces).unwrap_err();
    assert!(matches!(lost, Error::Node { node: 1, .. }));
    let met = network.forces(&[[0.0], [-1.0]], &mut forces).unwrap_err();
    assert_eq!(met, Error::Coincident { first: 0, second: 1 });
    assert!(network.cut(&[1]).is_err() && network.advance(&[[0.0]; 2], &[[0.0]; 2], 0.0).is_err());
}

#[test]
fn forces_are_those_of_lammps() {
    let text = include_str!("../data/lammps_pmb_forces_6x6x6.json");
    let data: serde_json::Value = serde_json::from_str(text).unwrap();
    let (x, expected) = (rows(&data["x"]), rows(&data["f"]));
    let dx = 5e-4;
    // The first index fastest, from the origin. As products of the spacing, so that displacements are exact differences.
    let at = |node: usize| [node % 6, node / 6 % 6, node / 36].map(|index| index as f64 * dx);
    let positions: Vec<[f64; 3]> = (0..216).map(at).collect();
    let u: Vec<[f64; 3]> = (0..216).map(|i| std::array::from_fn(|k| x[i][k] - at(i)[k])).collect();
    let nodes = Nodes::new(positions, vec![dx.powi(3); 216], dx, Condition::Solid).unwrap();
    let horizon = Horizon::of_shells(3, dx).unwrap();
    let config = BondConfig {
        volume_correction: VolumeCorrection::Partial,
        ..BondConfig::uncorrected(horizon, 1.5 * 14.9e9)
    };
    let bonds = Bonds::new(&nodes, &config).unwrap();
    let strengths = vec![1.0; bonds.len()];
    let network = Network::new(nodes, bonds, CriticalStretch, strengths).unwrap();
    let mut forces = vec![[0.0; 3]; 216];
    let _ = network.forces(&u, &mut forces).unwrap();
    let volume = dx.powi(3);
    let off = |expected: &[[f64; 3]]| {
        let flat = || forces.iter().flatten().zip(expected.iter().flatten());
        let largest = flat().fold(0.0_f64, |most, (_, f)| most.max(f.abs()));
        flat().fold(0.0_f64, |most, (ours, f)| most.max((ours / volume - f).abs() / largest))
    };
    // LAMMPS takes the stretch as a difference of lengths: its own roundoff is 1.2e-13 of the largest force, by arithmetic of 40
    // digits over the same positions, which ours meets.
    let (lammps, exact) = (off(&expected), off(&rows(&data["exact"])));
    assert!(lammps < 1.5e-13 && exact < 2e-15, "{lammps:e} {exact:e}");
}

#[test]
fn a_notch_cuts_the_bonds_that_cross_it() {
    let plate = Condition::PlaneStrain { thickness: 1.0 };
    let nodes = cube(6.0, plate);
    let config = BondConfig::uncorrected(Horizon::new(1.1, 1.0).unwrap(), 1.0);
    let bonds = Bonds::new(&nodes, &config).unwrap();
    // From the left edge between the rows at 2.5 and 3.5, past the nodes at 0.5, 1.5 and 2.5.
    let cut = bonds.across_segment(&nodes, ([-1.0, 3.0], [3.0, 3.0])).unwrap();
    let pairs: Vec<_> = bonds.pairs().collect();
    assert_eq!(
        cut.iter().map(|&bond| pairs[bond]).collect::<Vec<_>>(),
        [(12, 18), (13, 19), (14, 20)]
    );
    let outside = bonds.across_segment(&nodes, ([7.0, 0.0], [9.0, 3.0])).unwrap_err();
    assert_eq!(outside, Error::NotchOutsideBody);
    let nowhere = bonds.across_segment(&nodes, ([f64::NAN, 0.0], [9.0, 3.0])).unwrap_err();
    assert!(matches!(nowhere, Error::Parameter { .. }));
}
