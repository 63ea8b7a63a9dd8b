//! A law of a user's own: strings, which resist tension alone and never break.

use peridyn_sde::{
    Body, BondConfig, BondLaw, Bonds, Condition, Error, Horizon, Loading, Network, Scheme,
    Simulation,
};

use crate::fixtures::{cube, in_time, overdamped};

// docs: law
#[derive(Debug)]
struct Cord;

impl BondLaw for Cord {
    /// A string has no history.
    type State = ();

    fn advance(&self, _strength: f64, _from: f64, _to: f64, _dt: f64, _state: &mut ()) {}

    fn tension(&self, _strength: f64, s: f64, _state: &()) -> f64 {
        s.max(0.0)
    }

    fn energy(&self, _strength: f64, s: f64, _state: &()) -> f64 {
        0.5 * s * s.max(0.0)
    }

    fn damage(&self, _strength: f64, _state: &()) -> f64 {
        0.0
    }
}
// docs: end

/// Five nodes in a row.
fn net() -> Network<Cord, 1> {
    let nodes = cube(5.0, Condition::Bar { area: 1.0 });
    let config = BondConfig::uncorrected(Horizon::of_shells(1, 1.0).unwrap(), 2.0);
    let bonds = Bonds::new(&nodes, &config).unwrap();
    let strengths = vec![1.0; bonds.len()];
    Network::new(nodes, bonds, Cord, strengths).unwrap()
}

// docs: test
#[test]
fn a_net_of_strings_pulls_and_does_not_push() {
    let network = net();
    let stiffness = network.bonds().all()[0].stiffness;
    let mut forces = [[0.0]; 5];
    for (strain, pull) in [(0.01, 0.01), (-0.01, 0.0)] {
        let u: Vec<[f64; 1]> =
            network.nodes().positions().iter().map(|x| [strain * x[0]]).collect();
        let _ = network.forces(&u, &mut forces).unwrap();
        assert!((forces[0][0] - stiffness * pull).abs() < 1e-15 * stiffness);
        assert!(forces[2][0].abs() < 1e-15 * stiffness);
    }
}
// docs: end

/// The law knows nothing of it.
#[test]
fn a_cut_string_carries_nothing_until_it_is_intact_again() {
    let mut network = net();
    let u: Vec<[f64; 1]> = network.nodes().positions().iter().map(|x| [0.01 * x[0]]).collect();
    let pull_and_slope = |network: &Network<Cord, 1>| {
        let mut forces = [[0.0]; 5];
        let energy = network.forces(&u, &mut forces).unwrap();
        (forces[0][0], energy, network.slope(0, 0))
    };
    let (pull, energy, slope) = pull_and_slope(&network);
    assert!(pull > 0.0 && slope > 0.99);
    network.cut(&[0]).unwrap();
    let (without, less, flat) = pull_and_slope(&network);
    assert_eq!((without, flat), (0.0, 0.0));
    assert!((less / energy - 0.75).abs() < 1e-14, "one of four strings of {energy}: {less}");
    assert_eq!(network.damage(), [1.0, 0.5, 0.0, 0.0, 0.0]);
    assert_eq!(Body::intact(&network, 0), 0);
    network.set_intact(0, 1);
    assert_eq!(pull_and_slope(&network), (pull, energy, slope));
}

/// A string is as stiff as its steeper side: with two springs of `kappa/r` to a node the stiffest mode of a long row has four,
/// of five free nodes `4 sin^2(2 pi/5)`.
#[test]
fn the_step_is_held_against_the_steeper_side_at_rest() {
    let start = |scheme, z: f64| {
        let network = net();
        let spring = network.bonds().all()[0].stiffness / network.bonds().all()[0].length;
        let rate = 4.0 * spring * (2.0 * std::f64::consts::PI / 5.0).sin().powi(2);
        let config = in_time(overdamped(&[true; 5], scheme, 0.0), z / rate, 1);
        Simulation::new(network, Loading::new(5), config, [0])
    };
    let z = start(Scheme::EulerMaruyama, 1.99).unwrap().relative_step();
    assert!((z - 1.99).abs() < 2e-3, "{z}");
    let beyond = start(Scheme::EulerMaruyama, 2.01).unwrap_err();
    assert!(matches!(beyond, Error::Unstable { limit, .. } if limit <= 2.0), "{beyond}");
    // An implicit step takes it for a bond that pushes too, and comes to rest.
    let mut implicit = start(Scheme::Theta(1.0), 20.0).unwrap();
    let stretched: Vec<[f64; 1]> = (0..5).map(|node| [0.1 * f64::from(node)]).collect();
    implicit.set_displacements(0, &stretched).unwrap();
    for _ in 0..200 {
        let _ = implicit.step().unwrap();
    }
    let ends = implicit.displacements(0);
    assert!((ends[4][0] - ends[0][0]).abs() < 1e-6, "{ends:?}");
}
