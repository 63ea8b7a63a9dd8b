//! A law of a user's own: strings, which resist tension alone and never break.

use peridyn_sde::{
    BondConfig, BondLaw, Bonds, Condition, Horizon, Influence, Network, Nodes, SurfaceCorrection,
    VolumeCorrection,
};

#[derive(Debug)]
struct Cord;

impl BondLaw for Cord {
    /// Whether it is cut.
    type State = bool;

    fn start(&self) -> bool {
        false
    }

    fn cut(&self) -> bool {
        true
    }

    fn advance(&self, _strength: f64, _from: f64, _to: f64, _dt: f64, _cut: &mut bool) {}

    fn tension(&self, _strength: f64, s: f64, cut: &bool) -> f64 {
        if *cut { 0.0 } else { s.max(0.0) }
    }

    fn energy(&self, strength: f64, s: f64, cut: &bool) -> f64 {
        0.5 * s * self.tension(strength, s, cut)
    }

    fn damage(&self, _strength: f64, cut: &bool) -> f64 {
        f64::from(*cut)
    }

    fn threshold(&self, _strength: f64, _cut: &bool) -> Option<f64> {
        None
    }
}

#[test]
fn a_net_of_strings_pulls_and_does_not_push() {
    let nodes =
        Nodes::lattice(1.0, ([0.0], [5.0]), Condition::Bar { area: 1.0 }, |_| true).unwrap();
    let config = BondConfig {
        horizon: Horizon::of_shells(1, 1.0).unwrap(),
        young_modulus: 2.0,
        influence: Influence::Constant,
        volume_correction: VolumeCorrection::None,
        surface_correction: SurfaceCorrection::None,
    };
    let bonds = Bonds::new(&nodes, &config).unwrap();
    let strengths = vec![1.0; bonds.len()];
    let network = Network::new(nodes, bonds, Cord, strengths).unwrap();
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
