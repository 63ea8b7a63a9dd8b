//! Constants of bonds against the elastic body, on lattices and in the limit of a fine one.

use peridyn_sde::law::CriticalStretch;
use peridyn_sde::{
    BondConfig, Bonds, Condition, Horizon, Influence, Network, Nodes, VolumeCorrection,
    critical_stretch,
};

/// Around the node in the middle of a body that holds all that it sees: twice the energy of its bonds under a small uniform
/// strain, over its volume and `E`; and how many bonds it has.
fn energy_of_middle<const D: usize>(
    condition: Condition,
    config: BondConfig,
    strain: impl Fn(&[f64; D]) -> [f64; D],
) -> (f64, usize) {
    let reach = (config.horizon.radius() + 1.0).ceil();
    let nodes =
        Nodes::lattice(1.0, ([-reach - 0.5; D], [reach + 0.5; D]), condition, |_| true).unwrap();
    let middle = nodes.positions().len() / 2;
    assert!(nodes.positions()[middle].iter().all(|c| c.abs() < 1e-12));
    let bonds = Bonds::new(&nodes, &config).unwrap();
    let (mut energy, mut count) = (0.0, 0);
    for (bond, (i, j)) in bonds.all().iter().zip(bonds.pairs()) {
        if i != middle && j != middle {
            continue;
        }
        let (a, b) = (&nodes.positions()[i], &nodes.positions()[j]);
        let (ua, ub) = (strain(a), strain(b));
        let along: f64 = (0..D).map(|k| (b[k] - a[k]) * (ub[k] - ua[k])).sum();
        let stretch = along / (bond.length * bond.length);
        // Half of a bond's energy belongs to each of its nodes.
        energy += 0.25 * bond.stiffness * bond.length * stretch * stretch;
        count += 1;
    }
    (2.0 * energy / (nodes.volumes()[middle] * config.young_modulus), count)
}

fn config(horizon: Horizon, correction: VolumeCorrection) -> BondConfig {
    BondConfig { volume_correction: correction, ..BondConfig::uncorrected(horizon, 3.0) }
}

const CORRECTIONS: [(&str, VolumeCorrection); 3] = [
    ("none<=", VolumeCorrection::None),
    ("lammps", VolumeCorrection::Partial),
    ("PA", VolumeCorrection::Ramp),
];

fn lattice_has_its_stiffness<const D: usize>(name: &str, condition: Condition, c11: f64, c12: f64) {
    let text = include_str!("../data/lattice_stiffness.json");
    let data: serde_json::Value = serde_json::from_str(text).unwrap();
    for shells in [2, 3, 4] {
        let horizon = Horizon::of_shells(shells, 1.0).unwrap();
        for (key, correction) in CORRECTIONS {
            let expected = &data["table"][format!("{name} m={shells}.015")][key];
            let config = config(horizon, correction);
            let uniaxial = |x: &[f64; D]| std::array::from_fn(|k| if k == 0 { x[0] } else { 0.0 });
            let biaxial = |x: &[f64; D]| std::array::from_fn(|k| if k < 2 { x[k] } else { 0.0 });
            let (one, count) = energy_of_middle(condition, config, uniaxial);
            // 2 C11 + 2 C12.
            let (both, _) = energy_of_middle(condition, config, biaxial);
            let found = [one / c11, (0.5 * both - one) / c12];
            assert_eq!(count as u64, expected["neigh"].as_u64().unwrap(), "{name} {shells} {key}");
            for (value, label) in found.into_iter().zip(["C11", "C12"]) {
                let expected = expected[label].as_f64().unwrap();
                assert!(
                    (value / expected - 1.0).abs() < if D == 2 { 2e-14 } else { 2e-13 },
                    "{name} {shells} {key} {label}: {value} {expected}"
                );
            }
        }
    }
}

#[test]
fn lattices_have_the_stiffness_of_the_reference_table() {
    // Plane stress, nu = 1/3: E/(1 - nu^2) = 9/8 and a third of it; three dimensions, nu = 1/4: 6/5 and a third of it.
    let plate = Condition::PlaneStress { thickness: 0.7 };
    lattice_has_its_stiffness::<2>("2D", plate, 9.0 / 8.0, 3.0 / 8.0);
    lattice_has_its_stiffness::<3>("3D", Condition::Solid, 1.2, 0.4);
}

const CONDITIONS: [Condition; 4] = [
    Condition::Bar { area: 0.3 },
    Condition::PlaneStress { thickness: 0.7 },
    Condition::PlaneStrain { thickness: 0.7 },
    Condition::Solid,
];

fn extension_has_its_energy<const D: usize>(condition: Condition, shells: u32) {
    for influence in Influence::ALL {
        let horizon = Horizon::of_shells(shells, 1.0).unwrap();
        let config = BondConfig { influence, ..config(horizon, VolumeCorrection::Ramp) };
        let (twice, _) = energy_of_middle::<D>(condition, config, |x| *x);
        let error = 0.5 * twice / condition.energy_of_extension() - 1.0;
        assert!(error.abs() < 0.05, "{condition:?} {influence:?}: {error}");
    }
}

/// Within 5 %: what is left is the lattice, which falls with the spacing.
#[test]
fn a_uniform_extension_has_the_energy_of_the_elastic_body() {
    extension_has_its_energy::<1>(CONDITIONS[0], 8);
    extension_has_its_energy::<2>(CONDITIONS[1], 5);
    extension_has_its_energy::<2>(CONDITIONS[2], 5);
    extension_has_its_energy::<3>(CONDITIONS[3], 4);
}

/// The energy of all bonds across the plane in the middle at the critical stretch, over the area of the plane.
fn energy_of_a_crack<const D: usize>(
    condition: Condition,
    shells: u32,
    influence: Influence,
) -> f64 {
    let horizon = Horizon::of_shells(shells, 1.0).unwrap();
    let (release, modulus) = (0.02, 3.0);
    let strength =
        critical_stretch(release, modulus, horizon.radius(), influence, condition).unwrap();
    let reach = f64::from(shells) + 1.0;
    // The plane is at zero, between two layers of nodes; to its sides the body goes on for two horizons.
    let along = 2.0 * reach + 0.5;
    let side = |sign: f64| std::array::from_fn(|k| sign * if k == 0 { reach } else { along });
    let nodes = Nodes::<D>::lattice(1.0, (side(-1.0), side(1.0)), condition, |_| true).unwrap();
    let config = BondConfig { influence, ..config(horizon, VolumeCorrection::Ramp) };
    let bonds = Bonds::new(&nodes, &config).unwrap();
    let across = |c: &[f64; D]| c[1..].iter().all(|c| c.abs() < 0.5);
    let mut energy = 0.0;
    for (bond, (i, j)) in bonds.all().iter().zip(bonds.pairs()) {
        let (a, b) = (&nodes.positions()[i], &nodes.positions()[j]);
        // Each bond of the column of nodes in the middle, once from each of its ends within the column.
        if a[0] * b[0] < 0.0 {
            let ends = f64::from(u8::from(across(a)) + u8::from(across(b)));
            energy += 0.5 * ends * 0.5 * bond.stiffness * bond.length * strength * strength;
        }
    }
    energy / condition.across() / release
}

/// Within 5 % too, and by the finer lattice nearer.
#[test]
fn a_crack_takes_its_energy() {
    for influence in Influence::ALL {
        for (name, energies) in [
            ("bar", [6, 12].map(|m| energy_of_a_crack::<1>(CONDITIONS[0], m, influence))),
            ("plane stress", [4, 8].map(|m| energy_of_a_crack::<2>(CONDITIONS[1], m, influence))),
            ("plane strain", [4, 8].map(|m| energy_of_a_crack::<2>(CONDITIONS[2], m, influence))),
            ("solid", [3, 5].map(|m| energy_of_a_crack::<3>(CONDITIONS[3], m, influence))),
        ] {
            let [_, fine] = energies;
            assert!((fine - 1.0).abs() < 0.05, "{name} {influence:?}: {energies:?}");
        }
    }
}

/// An independent path: forces of the network under a stretch of the bar give its modulus.
#[test]
fn a_stretched_bar_pulls_with_its_modulus() {
    let condition = Condition::Bar { area: 0.3 };
    let nodes = Nodes::lattice(1.0, ([0.0], [60.0]), condition, |_| true).unwrap();
    let horizon = Horizon::of_shells(3, 1.0).unwrap();
    let bonds = Bonds::new(&nodes, &config(horizon, VolumeCorrection::Ramp)).unwrap();
    let strengths = vec![1.0; bonds.len()];
    let network = Network::new(nodes, bonds, CriticalStretch, strengths).unwrap();
    let u: Vec<[f64; 1]> = network.nodes().positions().iter().map(|x| [1e-3 * x[0]]).collect();
    let mut forces = vec![[0.0]; u.len()];
    let _ = network.forces(&u, &mut forces).unwrap();
    // The force on one half of the bar, by its other half.
    let pull: f64 = -forces[30..].iter().map(|f| f[0]).sum::<f64>();
    assert!((pull / (3.0 * 0.3 * 1e-3) - 1.0).abs() < 0.05, "{pull}");
    assert!(forces[10..50].iter().all(|f| f[0].abs() < 1e-15), "the middle is in equilibrium");
}
