//! A point of Johnson-Cook steel against an independent quadrature and the paper, with derivatives carried and frozen.

use constitutive_models::tensor::von_mises;
use constitutive_models::{JohnsonCook, JohnsonCookParameters, Now, Strength, Units, library};
use perturbation_moments::{Jet, Scalar};

use super::materials::{CGU, Number};
use super::responses::JohnsonCook as FrozenFlowStress;

/// Megapascal, second.
fn point_steel() -> JohnsonCookParameters<f64> {
    let units = Units::new(1.0, 1e6, 1.0).unwrap();
    let steel = library::steel_strength(units);
    assert!((steel.a - 792.0).abs() < 1e-10);
    steel
}

/// The von Mises stress and the state after a total strain at the rate 1e4/s, in equal steps of the point.
fn point<S: Number>(
    parameters: JohnsonCookParameters<S>,
    total: f64,
    steps: usize,
) -> (S, <JohnsonCook<S> as Strength<S>>::State) {
    let material = JohnsonCook::new(parameters).unwrap();
    let mut state = material.start();
    let c = S::constant;
    let rate = 1e4;
    let mut gradient = [[c(0.0); 3]; 3];
    for (k, entry) in [-rate, 0.5 * rate, 0.5 * rate].into_iter().enumerate() {
        gradient[k][k] = c(entry);
    }
    let now = Now {
        velocity_gradient: gradient,
        dt: total / rate / steps as f64,
        time: 0.0,
        volume_before: c(1.0),
        volume: c(1.0),
        viscosity: c(0.0),
        cell: 1.0,
    };
    for _ in 0..steps {
        material.update(&now, &mut state).unwrap();
    }
    (von_mises(&state.deviator), state)
}

/// The five random parameters as directions of a jet.
fn seeded(parameters: JohnsonCookParameters<f64>) -> JohnsonCookParameters<Jet> {
    parameters.map(|name, value| match ["a", "b", "c", "n", "m"].iter().position(|n| *n == name) {
        Some(lane) => Jet::variable(value, lane),
        None => Jet::constant(value),
    })
}

fn reference(total: f64, variation: f64) -> serde_json::Value {
    let text = include_str!("../../../../tests/reference/derived/smpm/johnson_cook_point.json");
    let file: serde_json::Value = serde_json::from_str(text).unwrap();
    let is = |case: &serde_json::Value, key: &str, value: f64| case[key].as_f64() == Some(value);
    let cases = file["cases"].as_array().unwrap();
    cases.iter().find(|c| is(c, "et", total) && is(c, "cv", variation)).unwrap().clone()
}

#[test]
fn the_johnson_cook_point_converges_to_the_reference() {
    for total in [0.006, 0.1, 0.6] {
        let exact = reference(total, 0.1)["sigma_eq_det"].as_f64().unwrap();
        let error = |steps| (point(point_steel(), total, steps).0 - exact) / exact;
        // Temperature of the step before: first order.
        let (coarse, fine): (f64, f64) = (error(1000), error(2000));
        println!("{total}: {coarse:e} {fine:e}");
        assert!((2.0 * fine - coarse).abs() < 1e-6, "{total}: {coarse:e} {fine:e}");
        assert!(fine.abs() < 1e-3);
    }
}

#[test]
fn the_derivatives_of_the_point_are_those_of_its_whole_history() {
    for total in [0.006, 0.1, 0.6] {
        let (stress, _) = point(seeded(point_steel()), total, 500);
        for (lane, name) in ["a", "b", "c", "n", "m"].into_iter().enumerate() {
            let value = point_steel().map(|n, v| if n == name { v } else { 0.0 });
            let value = value.a + value.b + value.c + value.n + value.m;
            let moved = |h: f64| {
                let moved = point_steel().map(|n, v| if n == name { v * (1.0 + h) } else { v });
                point(moved, total, 500).0
            };
            let h = 1e-5;
            let difference = (moved(h) - moved(-h)) / (2.0 * h);
            let ours = stress.first[lane] * value;
            assert!(
                (ours - difference).abs() <= 1e-6 * stress.value,
                "{total}, {name}: {ours} {difference}"
            );
        }
    }
}

#[test]
fn the_propagated_variance_is_right_and_the_frozen_one_is_not() {
    for (total, steps, variation) in [
        (0.1, 2000, 0.05),
        (0.1, 2000, 0.1),
        (0.1, 2000, 0.15),
        (0.6, 6000, 0.05),
        (0.6, 6000, 0.1),
        (0.6, 6000, 0.15),
    ] {
        let case = reference(total, variation);
        let quadrature = case["gauss_hermite9"]["var"].as_f64().unwrap();
        let p = point_steel();
        let x = [p.a, p.b, p.c, p.n, p.m];
        let variance =
            |first: &[f64]| -> f64 { (0..5).map(|k| (first[k] * variation * x[k]).powi(2)).sum() };
        let (stress, state) = point(seeded(p), total, steps);
        let propagated = variance(&stress.first);
        let mean: f64 = stress.value
            + (0..5).map(|k| 0.5 * stress.second[k] * (variation * x[k]).powi(2)).sum::<f64>();
        let frozen = FrozenFlowStress::new(
            state.plastic_strain.value,
            1e4,
            state.homologous_temperature.value,
        )
        .diagonal(&x);
        let frozen = variance(&frozen.1);
        // Third derivatives, of the order of the square of the coefficient of variation; the mean, of its fourth power.
        let square = (variation / 0.1).powi(2);
        let off = propagated / quadrature - 1.0;
        assert!(off.abs() <= 0.01 * square, "strain {total}, {variation}: {off}");
        let expected_mean = case["gauss_hermite9"]["mean"].as_f64().unwrap();
        let off = mean / expected_mean - 1.0;
        assert!(
            off.abs() <= 2e-4 * square.max(1.0).powi(2),
            "strain {total}, {variation}: {off:e}"
        );
        // The frozen form at its tabulated error: +4 % and +27 %. The step leaves 0.1 %.
        let tabulated = case["frozen"]["var"].as_f64().unwrap();
        assert!((frozen / tabulated - 1.0).abs() < 2e-3, "{frozen} {tabulated}");
        assert!(frozen > 1.03 * quadrature);
    }
}

#[test]
fn the_published_set_gives_table_6_of_the_paper_and_the_physical_one_does_not() {
    // Points H, I, G, K at a coefficient of variation of 0.1 (Chen et al. 2019, Table 6): mean in 1e-2 Mbar, variance in 1e-6 Mbar^2; with the plastic
    // strain and the rate (1/us) that were inferred from mean, variance and curvature, three numbers for two.
    let points = [
        (0.912_377_54, 0.616_314_72, 0.01741, 0.01351),
        (0.939_404_29, 0.629_883_12, 0.02841, 0.01857),
        (0.951_179_8, 0.633_913_11, 0.03603, 0.01815),
        (0.925_823_61, 0.621_742_78, 0.02314, 0.01418),
    ];
    let moments = |p: JohnsonCookParameters<f64>, strain: f64, rate: f64| {
        // No heat: the least homologous temperature that has a logarithm.
        let state = FrozenFlowStress::new(strain, rate / p.reference_rate, 1e-300);
        let x = [p.a, p.b, p.c, p.n, p.m];
        let (value, first, second) = state.diagonal(&x);
        let deviation = x.map(|x| 0.1 * x);
        let mean = value + (0..5).map(|k| 0.5 * second[k] * deviation[k].powi(2)).sum::<f64>();
        (mean, (0..5).map(|k| (first[k] * deviation[k]).powi(2)).sum::<f64>())
    };
    for (mean, variance, strain, rate) in points {
        let published = moments(library::steel_strength_as_published(CGU), strain, rate);
        // Four digits of the strain: 3e-4 of it, 5e-5 of the stress.
        assert!((published.0 / (1e-2 * mean) - 1.0).abs() < 1e-4, "{published:?}");
        assert!((published.1 / (1e-6 * variance) - 1.0).abs() < 2e-4, "{published:?}");
        let physical = moments(library::steel_strength(CGU), strain, rate);
        assert!(physical.0 > 1.15 * 1e-2 * mean, "{physical:?}");
    }
}
