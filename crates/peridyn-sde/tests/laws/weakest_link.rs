//! Strengths by volume: the strength of a body does not depend on its mesh.

use peridyn_sde::{
    BondConfig, Bonds, Condition, Error, Horizon, Nodes, Requirement, Stiffness, Strength,
    StrengthElement, WeibullByVolume, WeibullStrength,
};
use sde_integrators::Noise;

use crate::given::{Plate, STRETCH};

const AREA: f64 = 0.01;
const LENGTH: f64 = 2.0;
const LAW: WeibullByVolume = WeibullByVolume {
    scale: 1e-3,
    modulus: 5.0,
    reference_volume: 0.005,
    element: StrengthElement::Bond,
};
const N: usize = 2000;

fn bar(n: u32, shells: u32) -> (Nodes<1>, Bonds) {
    let spacing = LENGTH / f64::from(n);
    let condition = Condition::Bar { area: AREA };
    let nodes = Nodes::lattice(spacing, ([0.0], [LENGTH]), condition, |_| true).unwrap();
    let config = BondConfig::uncorrected(Horizon::of_shells(shells, spacing).unwrap(), 1.0);
    let bonds = Bonds::new(&nodes, &config).unwrap();
    (nodes, bonds)
}

/// The weakest bond of each of `N` realisations, in ascending order.
fn weakest(strength: &WeibullStrength, n_bonds: usize, seed: u64) -> Vec<f64> {
    let mut strengths = vec![0.0; n_bonds];
    let mut all: Vec<f64> = (0..N as u64)
        .map(|realisation| {
            strength.sample(&Noise::new(seed), realisation, &mut strengths).unwrap();
            strengths.iter().copied().fold(f64::INFINITY, f64::min)
        })
        .collect();
    all.sort_unstable_by(f64::total_cmp);
    all
}

/// The largest distance between the distribution of values and a law.
fn kolmogorov(values: &[f64], law: impl Fn(f64) -> f64) -> f64 {
    let n = values.len() as f64;
    let at = |(k, &value): (usize, &f64)| {
        let below = law(value);
        (below - k as f64 / n).abs().max((below - (k + 1) as f64 / n).abs())
    };
    values.iter().enumerate().map(at).fold(0.0, f64::max)
}

#[test]
fn weakest_bond_of_a_bar_has_the_law_of_its_volume_on_every_mesh() {
    let elements =
        [StrengthElement::Bond, StrengthElement::Node, StrengthElement::Block { size: 0.21 }];
    let volume = AREA * LENGTH;
    let below = |stretch: f64| -f64::exp_m1(-volume / 0.005 * (stretch / 1e-3).powi(5));
    // Kolmogorov's distribution: 1.95/sqrt(n) is exceeded with a probability of 0.001.
    let limit = 1.95 / (N as f64).sqrt();
    for element in elements {
        for (n, shells) in [(20, 1), (50, 1), (50, 3), (150, 3)] {
            let (nodes, bonds) = bar(n, shells);
            let law = WeibullByVolume { element, ..LAW };
            let strength = WeibullStrength::new(&nodes, &bonds, law, 0).unwrap();
            let total: f64 = strength.volumes().iter().sum();
            assert!((total - volume).abs() < 1e-14, "{element:?}, {n}: {total}");
            let values = weakest(&strength, bonds.len(), 5);
            let distance = kolmogorov(&values, below);
            assert!(distance < limit, "{element:?}, {n}, {shells}: {distance} > {limit}");
            // Without the scaling the law would be another one: the test can fail.
            let without = |stretch: f64| -f64::exp_m1(-(stretch / 1e-3).powi(5));
            assert!(kolmogorov(&values, without) > 5.0 * limit);
        }
    }
}

#[test]
fn blocks_have_the_same_strengths_on_every_mesh() {
    let law = WeibullByVolume { element: StrengthElement::Block { size: 0.5 }, ..LAW };
    let of = |n: u32| {
        let (nodes, bonds) = bar(n, 1);
        let strength = WeibullStrength::new(&nodes, &bonds, law, 0).unwrap();
        let mut strengths = vec![0.0; bonds.len()];
        strength.sample(&Noise::new(9), 4, &mut strengths).unwrap();
        // In the middle of the four blocks.
        [1, 3, 5, 7].map(|eighth| strengths[n as usize * eighth / 8])
    };
    let (coarse, fine) = (of(40), of(160));
    for k in 0..4 {
        assert!((coarse[k] / fine[k] - 1.0).abs() < 1e-12, "{coarse:?} {fine:?}");
    }
    assert!(coarse.windows(2).all(|pair| (pair[0] / pair[1] - 1.0).abs() > 1e-6), "{coarse:?}");
}

#[test]
fn fields_of_other_numbers_and_realisations_are_others() {
    let (nodes, bonds) = bar(20, 1);
    let of = |number: u32, realisation: u64| {
        let strength = WeibullStrength::new(&nodes, &bonds, LAW, number).unwrap();
        let mut strengths = vec![0.0; bonds.len()];
        strength.sample(&Noise::new(9), realisation, &mut strengths).unwrap();
        strengths
    };
    assert_eq!(of(0, 3), of(0, 3));
    assert!(of(0, 3).iter().zip(of(1, 3)).all(|(a, b)| a.to_bits() != b.to_bits()));
    assert!(of(0, 3).iter().zip(of(0, 4)).all(|(a, b)| a.to_bits() != b.to_bits()));
}

#[test]
fn ensemble_with_strengths_by_volume_is_one_in_shards_and_beside_other_lanes() {
    let plate = Plate::lattice();
    let (nodes, bonds) = plate.body();
    let law = WeibullByVolume {
        scale: STRETCH,
        modulus: 8.0,
        reference_volume: nodes.volumes()[0],
        element: StrengthElement::Node,
    };
    let weibull = WeibullStrength::new(nodes, bonds, law, 0).unwrap();
    let study = plate.study(Strength::Weibull(&weibull), Stiffness::Uniform);
    let whole = study.run(0..11, &[2]).unwrap();
    assert!(whole.broken.iter().all(|&broken| broken > 0), "{:?}", whole.broken);
    assert!(whole.broken.iter().any(|&broken| broken != whole.broken[0]), "{:?}", whole.broken);
    let [later, mut joined] = [6..11, 0..6].map(|range| study.run(range, &[2]).unwrap());
    joined.append(later).unwrap();
    assert!(joined == whole);
    let alone = study.run(2..3, &[2]).unwrap();
    assert!(alone.records[0] == whole.records[2] && alone.kept == whole.kept);
    let kept = whole.kept[0].strength.as_ref().unwrap();
    assert_eq!(kept.len(), nodes.positions().len());
}

#[test]
fn law_that_cannot_be_is_refused_with_its_value() {
    let (nodes, bonds) = bar(20, 1);
    let refused = |law: WeibullByVolume| WeibullStrength::new(&nodes, &bonds, law, 0).unwrap_err();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let not = |error: Error| matches!(error, Error::Parameter { .. });
        assert!(not(refused(WeibullByVolume { scale: bad, ..LAW })), "{bad}");
        assert!(not(refused(WeibullByVolume { reference_volume: bad, ..LAW })), "{bad}");
        let element = StrengthElement::Block { size: bad };
        assert!(not(refused(WeibullByVolume { element, ..LAW })), "{bad}");
        let modulus = refused(WeibullByVolume { modulus: bad, ..LAW });
        assert!(matches!(modulus, Error::Parameter { .. }), "{bad}");
    }
    let element = StrengthElement::Block { size: 1e-9 };
    let blocks = refused(WeibullByVolume { element, ..LAW });
    let must = Requirement::Between { from: 0.0, to: 16_777_216.0 };
    assert!(matches!(blocks, Error::Parameter { must: of, .. } if of == must), "{blocks}");
    let strength = WeibullStrength::new(&nodes, &bonds, LAW, 0).unwrap();
    let short = strength.sample(&Noise::new(1), 0, &mut [0.0; 3]).unwrap_err();
    assert!(matches!(short, Error::Length { value: 3, expected: 19, .. }), "{short}");
    let other = WeibullStrength::new(&bar(30, 1).0, &bonds, LAW, 0).unwrap_err();
    assert!(matches!(other, Error::Length { value: 20, expected: 30, .. }), "{other}");
}
