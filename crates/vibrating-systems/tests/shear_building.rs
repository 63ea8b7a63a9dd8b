//! The shear building: its drift is the sum of its linear part and its terms, and that of the textbook.

use sde_integrators::{LaneSde, PairwiseSde, Sde};
use vibrating_systems::{
    CloughPenzienParameters, Error, Ground, Hysteresis, KanaiTajimiParameters, ShearBuilding,
    ShearBuildingParameters, Storey, TwoStorey, TwoStoreyParameters, Window,
};

const BOUC_WEN: Hysteresis =
    Hysteresis::BoucWen { post_yield_ratio: 0.2, yield_drift: 0.3, beta: 0.6, exponent: 2.0 };
const BILINEAR: Hysteresis = Hysteresis::Bilinear { post_yield_ratio: 0.1, yield_drift: 0.2 };

fn parameters(hysteresis: [Hysteresis; 3], ground: Ground) -> ShearBuildingParameters {
    let storey = |(i, hysteresis)| {
        let i = i as f64;
        Storey { mass: 1.0 + i, stiffness: 30.0 - 4.0 * i, damping: 0.3 + 0.1 * i, hysteresis }
    };
    ShearBuildingParameters {
        storeys: hysteresis.into_iter().enumerate().map(storey).collect(),
        mass_damping: 0.05,
        ground,
        noise_intensity: 0.2,
        window: Window::Stationary,
    }
}

fn drift(building: &ShearBuilding, x: &[f64]) -> Vec<f64> {
    let rows: Vec<[f64; 1]> = x.iter().map(|&value| [value]).collect();
    let mut rates = vec![[f64::NAN]; x.len()];
    building.drift(0.0, &rows, &mut rates);
    rates.into_iter().map(|[rate]| rate).collect()
}

#[test]
fn the_drift_is_the_sum_of_the_linear_part_and_the_terms() {
    let soil = KanaiTajimiParameters { ground_frequency: 15.0, ground_damping: 0.6 };
    let filter = CloughPenzienParameters { soil, low_cut_frequency: 1.5, low_cut_damping: 0.7 };
    for hysteresis in [[Hysteresis::None; 3], [BOUC_WEN; 3], [BILINEAR, Hysteresis::None, BOUC_WEN]]
    {
        for ground in [Ground::WhiteNoise, Ground::KanaiTajimi(soil), Ground::CloughPenzien(filter)]
        {
            let building = ShearBuilding::new(parameters(hysteresis, ground)).unwrap();
            let n = building.n_states();
            let x: Vec<f64> = (0..n).map(|i| 0.15 * (1.0 + 2.3 * i as f64).sin()).collect();
            let mut expected = vec![0.0; n];
            for (i, j, value) in building.linear_part() {
                expected[i] += value * x[j];
            }
            for (k, term) in building.pair_terms().into_iter().enumerate() {
                let [a, b] = term.states.map(|state| x[state]);
                expected[term.row] += building.pair_term(k, a, b);
            }
            for (found, expected) in drift(&building, &x).into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{hysteresis:?} {ground:?}");
            }
        }
    }
}

#[test]
fn two_linear_storeys_move_as_the_frame_of_the_textbook() {
    let mut given = parameters([Hysteresis::None; 3], Ground::WhiteNoise);
    given.storeys.truncate(2);
    given.mass_damping = 0.0;
    let frame = TwoStorey::new(TwoStoreyParameters {
        mass: [1.0, 2.0],
        stiffness: [30.0, 26.0],
        damping: [0.3, 0.4],
        damper_coefficient: [0.0; 2],
        damper_exponent: 1.0,
        noise_intensity: 0.2,
        window: Window::Stationary,
    })
    .unwrap();
    let building = ShearBuilding::new(given).unwrap();
    for (found, expected) in building.natural_frequencies().iter().zip(frame.natural_frequencies())
    {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }
    // Drifts (q_1, q_2 - q_1) and their rates.
    let q = [0.1, 0.25, -0.3, 0.2];
    let f = frame.drift(0.0, &q);
    let u = drift(&building, &[q[0], q[1] - q[0], q[2], q[3] - q[2]]);
    for (found, expected) in u.iter().zip([f[0], f[1] - f[0], f[2], f[3] - f[2]]) {
        assert!((found - expected).abs() < 1e-13, "{u:?} {f:?}");
    }
    let mut g = [0.0; 4];
    building.noise(0.0, &mut g);
    let of_frame = frame.noise(0.0, &q);
    assert!((g[2] - of_frame[2][0]).abs() < 1e-15 && g[3].abs() < 1e-300, "{g:?}");
}

#[test]
fn rayleigh_damping_is_that_of_its_modes() {
    let given = parameters([BOUC_WEN; 3], Ground::WhiteNoise);
    let damped = given.with_rayleigh_damping([1, 3], [0.05, 0.04]).unwrap();
    let ratio = damped.storeys[0].damping / damped.storeys[0].stiffness;
    let omega = ShearBuilding::new(damped.clone()).unwrap().natural_frequencies();
    for (omega, xi) in [(omega[0], 0.05), (omega[2], 0.04)] {
        assert!((0.5 * (damped.mass_damping / omega + ratio * omega) - xi).abs() < 1e-12);
    }
}

#[test]
fn what_is_no_building_is_refused_by_name() {
    let message = |change: fn(&mut ShearBuildingParameters)| {
        let mut given = parameters([BOUC_WEN; 3], Ground::WhiteNoise);
        change(&mut given);
        ShearBuilding::new(given).unwrap_err().to_string()
    };
    assert_eq!(message(|p| p.storeys[1].mass = 0.0), "mass is 0; it must be greater than 0");
    assert_eq!(
        message(|p| p.storeys[2].hysteresis =
            Hysteresis::Bilinear { post_yield_ratio: 1.5, yield_drift: 1.0 }),
        "post_yield_ratio is 1.5; it must be from 0 to 1"
    );
    let mut none = parameters([BOUC_WEN; 3], Ground::WhiteNoise);
    none.storeys.clear();
    let refused = ShearBuilding::new(none).unwrap_err();
    assert!(matches!(refused, Error::TooFewRows { name: "storeys", count: 0, .. }));
}
