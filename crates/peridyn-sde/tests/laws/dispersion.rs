//! Waves in a long bar: their frequency by their length, on the lattice and in the limit of a fine one.

use peridyn_sde::{
    Body, BondConfig, BondList, Bonds, Condition, Horizon, Nodes, Strain, VolumeCorrection,
};
use serde_json::Value;

/// `rho omega^2 dx^2/E` of the wave `cos(kappa x)`, by the force on the node at its crest. A horizon that ends on nodes is
/// refused, since roundoff would decide which bonds it has: the limit from above it.
fn frequency(shells: u32, volume_correction: VolumeCorrection, kappa: f64) -> f64 {
    let reach = f64::from(shells) + 1.0;
    let at = |beyond: f64| {
        let ends = ([-reach - 0.5], [reach + 0.5]);
        let nodes = Nodes::lattice(1.0, ends, Condition::Bar { area: 1.0 }, |_| true).unwrap();
        let config = BondConfig {
            volume_correction,
            ..BondConfig::uncorrected(Horizon::new(f64::from(shells) + beyond, 1.0).unwrap(), 1.0)
        };
        let bonds = Bonds::new(&nodes, &config).unwrap();
        let wave: Vec<f64> = nodes.positions().iter().map(|x| (kappa * x[0]).cos()).collect();
        let strengths = vec![1.0; bonds.len()];
        let mut body =
            BondList::<f64, 1, 1>::new(nodes, bonds, Strain::Linear, &strengths).unwrap();
        let mut forces = vec![0.0; wave.len()];
        body.linear_forces(&wave, &mut forces).unwrap();
        -forces[wave.len() / 2]
    };
    2.0 * at(1e-6) - at(2e-6)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

fn reference() -> Value {
    serde_json::from_str(include_str!("../data/dispersion1d.json")).unwrap()
}

/// Square of the distance to the limit, 1e-12, and roundoff of long waves, 1e-12.
#[test]
fn frequencies_are_those_of_the_sums_over_bonds() {
    let reference = reference();
    let kappas = numbers(&reference["kappa_dx"]);
    for (key, correction) in
        [("halfvol", VolumeCorrection::Partial), ("novol", VolumeCorrection::None)]
    {
        for shells in [2, 3, 4, 6] {
            let expected = numbers(&reference[format!("omega2_m{shells}_{key}")]);
            assert_eq!(expected.len(), kappas.len());
            for (&kappa, expected) in kappas.iter().zip(&expected) {
                let error = frequency(shells, correction, kappa) / expected - 1.0;
                assert!(error.abs() < 5e-12, "{key}, m = {shells}, {kappa}: {error:e}");
            }
        }
    }
}

/// `rho w^2 = (4 E/delta^2) (gamma + ln(k delta) - Ci(k delta))` up to `k delta` of ten: the sum over bonds is the trapezoidal rule
/// for the integral, of second order.
#[test]
fn frequencies_on_a_fine_lattice_are_those_of_the_continuum() {
    let reference = reference();
    let kappas = numbers(&reference["kappa_delta"]);
    let expected = numbers(&reference["continuum_rho_w2_delta2_over_E"]);
    let error = |shells: u32| {
        let m = f64::from(shells);
        let both = kappas.iter().zip(&expected).filter(|(kappa, _)| **kappa <= 10.0);
        let off = both.map(|(kappa, expected)| {
            let found = frequency(shells, VolumeCorrection::Partial, kappa / m) * m * m;
            (found / expected - 1.0).abs()
        });
        off.fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(16), error(32));
    assert!(fine < 4e-3, "{fine}");
    let order = (coarse / fine).log2();
    assert!((order - 2.0).abs() < 0.05, "{order}");
}
