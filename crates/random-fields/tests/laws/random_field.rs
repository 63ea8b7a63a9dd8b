//! Expansions: their modes, their truncation, one function on every mesh.

use random_fields::{
    Correlation, CorrelationFunction, RandomField, SpatialCorrelation, Truncation,
};
use sde_integrators::Noise;

fn along(length: f64) -> Correlation {
    Correlation { function: CorrelationFunction::Exponential, length }
}

fn lattice(counts: [usize; 2], spacing: f64) -> Vec<[f64; 2]> {
    let place = |k: usize| [(k % counts[0]) as f64 * spacing, (k / counts[0]) as f64 * spacing];
    (0..counts[0] * counts[1]).map(place).collect()
}

/// The field by each way: a box of 3 by 1.5 lengths.
fn both(truncation: Truncation) -> [RandomField<2>; 2] {
    let correlation = SpatialCorrelation::separable([along(1.0), along(1.0)]);
    [
        RandomField::on_box([[0.0, 0.0], [3.0, 1.5]], correlation, truncation).unwrap(),
        RandomField::on_points(&lattice([25, 13], 0.125), correlation, truncation).unwrap(),
    ]
}

#[test]
fn terms_are_ordered_and_hold_the_share_that_was_asked_for_and_no_term_more() {
    for field in both(Truncation::Share(0.8)) {
        let shares = field.shares();
        assert!(shares.windows(2).all(|pair| pair[0] >= pair[1]));
        let sum: f64 = shares.iter().sum();
        assert!(sum >= 0.8 && sum - shares[shares.len() - 1] < 0.8, "{sum}");
        assert!((field.mean_left_out_variance() - (1.0 - sum)).abs() < 1e-15);
    }
}

#[test]
fn mean_of_the_squares_of_a_mode_is_its_share() {
    let [on_box, on_points] = both(Truncation::Terms(12));
    // Over the points that made the modes exactly; over the box by the midpoint rule, whose error is about (m h)^2.
    let points = lattice([25, 13], 0.125);
    let middles: Vec<[f64; 2]> =
        lattice([240, 120], 0.0125).iter().map(|x| x.map(|x| x + 0.00625)).collect();
    for (field, points, limit) in [(on_points, points, 1e-13), (on_box, middles, 2e-4)] {
        let n = field.n_terms();
        let mut modes = vec![0.0; n * points.len()];
        field.modes(&points, &mut modes).unwrap();
        for i in 0..n {
            for j in 0..n {
                let mean = modes.chunks_exact(n).map(|row| row[i] * row[j]).sum::<f64>()
                    / points.len() as f64;
                let expected = if i == j { field.shares()[i] } else { 0.0 };
                assert!((mean - expected).abs() < limit, "{i}, {j}: {mean} {expected}");
            }
        }
    }
}

#[test]
fn covariance_differs_from_the_correlation_by_at_most_what_is_left_out() {
    for field in both(Truncation::Share(0.9)) {
        let points = lattice([7, 4], 0.5);
        let mut largest: f64 = 0.0;
        for a in &points {
            for b in &points {
                let error =
                    (field.correlation().between(a, b) - field.covariance(a, b).unwrap()).abs();
                let bound =
                    field.left_out_variance(a).unwrap() * field.left_out_variance(b).unwrap();
                assert!(error <= bound.sqrt() + 1e-12, "{a:?}, {b:?}: {error}");
                largest = largest.max(error);
            }
        }
        assert!(largest > 0.05, "{largest}: nothing was left out");
    }
}

#[test]
fn realisation_is_the_same_function_on_every_mesh_to_the_last_bit() {
    for field in both(Truncation::Terms(30)) {
        for field in [field.clone(), field.with_unit_variance()] {
            let mut coefficients = vec![0.0; field.n_terms()];
            field.coefficients(&Noise::new(3), 5, 1, &mut coefficients).unwrap();
            let (coarse, fine) = (lattice([13, 7], 0.25), lattice([25, 13], 0.125));
            let values = |points: &[[f64; 2]]| {
                let mut out = vec![0.0; points.len()];
                field.values(&coefficients, points, &mut out).unwrap();
                out
            };
            let (on_coarse, on_fine) = (values(&coarse), values(&fine));
            for (x, value) in coarse.iter().zip(&on_coarse) {
                let k = fine.iter().position(|y| x == y).unwrap();
                assert_eq!(value.to_bits(), on_fine[k].to_bits());
            }
        }
    }
}

#[test]
fn modes_are_the_derivatives_of_the_values() {
    for field in both(Truncation::Terms(9)) {
        let field = field.with_unit_variance();
        let points = [[0.3, 0.4], [2.9, 1.4], [1.5, 0.0]];
        let mut modes = vec![0.0; 27];
        field.modes(&points, &mut modes).unwrap();
        for j in 0..9 {
            let mut unit = [0.0; 9];
            unit[j] = 1.0;
            let mut values = [0.0; 3];
            field.values(&unit, &points, &mut values).unwrap();
            assert!((0..3).all(|i| values[i] == modes[9 * i + j]));
        }
        for row in modes.chunks_exact(9) {
            assert!((row.iter().map(|mode| mode * mode).sum::<f64>() - 1.0).abs() < 1e-14);
        }
    }
}

#[test]
fn more_terms_continue_the_same_coefficients_and_realisations_differ() {
    let [few, _] = both(Truncation::Terms(10));
    let [many, _] = both(Truncation::Terms(100));
    let draw = |field: &RandomField<2>, seed, realisation, number| {
        let mut out = vec![0.0; field.n_terms()];
        field.coefficients(&Noise::new(seed), realisation, number, &mut out).unwrap();
        out
    };
    assert_eq!(draw(&few, 1, 2, 3), draw(&many, 1, 2, 3)[..10]);
    for other in [draw(&few, 2, 2, 3), draw(&few, 1, 3, 3), draw(&few, 1, 2, 4)] {
        assert!(other.iter().zip(draw(&few, 1, 2, 3)).all(|(a, b)| *a != b));
    }
    // Modes are shared, too: a truncated field is the beginning of a longer one.
    assert_eq!(few.shares(), &many.shares()[..10]);
}

#[test]
fn points_of_other_volumes_weigh_the_mean_variance() {
    let points: Vec<[f64; 1]> = (0..41).map(|k| [0.05 * f64::from(k)]).collect();
    // Nearly all of the body is near its left end.
    let volumes: Vec<f64> = (0..41).map(|k| if k < 5 { 1.0 } else { 1e-4 }).collect();
    let truncation = Truncation::Terms(3);
    let even = RandomField::on_points(&points, along(0.5), truncation).unwrap();
    let left = RandomField::on_weighted_points(&points, &volumes, along(0.5), truncation).unwrap();
    let at = |field: &RandomField<1>, x: f64| field.left_out_variance(&[x]).unwrap();
    assert!(at(&left, 0.1) < 0.1 && at(&even, 0.1) > 0.15);
    assert!(at(&left, 1.9) > 0.5 && at(&even, 1.9) < 0.5);
    assert!(left.mean_left_out_variance() < 0.5 * even.mean_left_out_variance());
}

#[test]
fn inclined_layers_are_those_of_the_turned_body() {
    // About axes turned by 90 degrees the long length is vertical.
    let soil = SpatialCorrelation::separable([along(4.0), along(0.5)]);
    let turned = soil.with_axes([[0.0, 1.0], [-1.0, 0.0]]);
    let truncation = Truncation::Terms(40);
    let lying = RandomField::on_box([[0.0, 0.0], [3.0, 1.0]], soil, truncation).unwrap();
    let standing = RandomField::on_box([[0.0, 0.0], [1.0, 3.0]], turned, truncation).unwrap();
    for (a, b) in [([0.2, 0.3], [2.5, 0.9]), ([1.0, 0.5], [1.0, 0.6])] {
        let turn = |x: [f64; 2]| [1.0 - x[1], x[0]];
        let expected = lying.covariance(&a, &b).unwrap();
        let found = standing.covariance(&turn(a), &turn(b)).unwrap();
        assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    }
    // By 20 degrees, the covariance is that of the turned correlation within what is left out.
    let (sine, cosine) = 20.0_f64.to_radians().sin_cos();
    let inclined = soil.with_axes([[cosine, sine], [-sine, cosine]]);
    let field =
        RandomField::on_box([[0.0, 0.0], [3.0, 1.0]], inclined, Truncation::Share(0.95)).unwrap();
    let (a, b) = ([0.5, 0.2], [2.0, 0.2 + 1.5 * 20.0_f64.to_radians().tan()]);
    let left = field.left_out_variance(&a).unwrap().max(field.left_out_variance(&b).unwrap());
    let layer = (-1.5 / cosine / 4.0).exp();
    assert!((inclined.between(&a, &b) - layer).abs() < 1e-12);
    assert!((field.covariance(&a, &b).unwrap() - layer).abs() < left && left < 0.15);
}

#[test]
fn every_function_is_expanded_on_points_in_one_to_three_dimensions() {
    for function in CorrelationFunction::ALL {
        let correlation = Correlation { function, length: 1.0 };
        let line: Vec<[f64; 1]> = (0..60).map(|k| [0.05 * f64::from(k)]).collect();
        let cube: Vec<[f64; 3]> =
            (0..343).map(|k| [k % 7, k / 7 % 7, k / 49].map(|k| 0.25 * f64::from(k))).collect();
        let of_line = RandomField::on_points(&line, correlation, Truncation::Share(0.9)).unwrap();
        let elliptic = SpatialCorrelation::elliptic(function, [1.0, 2.0, 0.7]);
        let of_cube = RandomField::on_points(&cube, elliptic, Truncation::Share(0.8)).unwrap();
        assert!(of_line.mean_left_out_variance() <= 0.1, "{function:?}");
        assert!(of_cube.mean_left_out_variance() <= 0.2, "{function:?}");
        // At a pivot everything is known but for the truncation; far away nothing is.
        assert!((of_line.left_out_variance(&[1e3]).unwrap() - 1.0).abs() < 1e-9);
    }
}
