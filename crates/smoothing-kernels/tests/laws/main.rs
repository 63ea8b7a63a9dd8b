//! What every kernel obeys in every dimension, looped over the table.

/// Runs a law in one to six dimensions.
macro_rules! in_every_dimension {
    ($law:ident($($argument:expr),*)) => {
        $law::<1>($($argument),*);
        $law::<2>($($argument),*);
        $law::<3>($($argument),*);
        $law::<4>($($argument),*);
        $law::<5>($($argument),*);
        $law::<6>($($argument),*);
    };
}

mod batch;
mod corrections;
mod custom_kernel;
mod marginals;

// Private to the crate: its error is measured at the arguments themselves, which no distance gives exactly.
#[path = "../../src/exponential.rs"]
mod exponential;
mod published;
#[path = "../../../simd-lanes/tests/shared/reference.rs"]
#[allow(dead_code, reason = "only the exponential is asked for")]
mod reference;

use proptest::prelude::*;
use smoothing_kernels::{Kernel, TruncatedGaussian, all, power, unit_sphere_surface};
use std::f64::consts::PI;

/// Surface of the unit sphere, from a table and not from the crate.
fn surface(dimension: usize) -> f64 {
    [2.0, 2.0 * PI, 4.0 * PI, 2.0 * PI * PI, 8.0 * PI * PI / 3.0, PI * PI * PI][dimension - 1]
}

/// `∫_a^b f` by five-point Gauss-Legendre on `panels` panels: exact to degree 9 in each (DLMF table 3.5.2).
fn quadrature(f: impl Fn(f64) -> f64, a: f64, b: f64, panels: usize) -> f64 {
    let nodes = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let half = 0.5 * (b - a) / panels as f64;
    let mut sum = 0.0;
    for panel in 0..panels {
        let centre = a + (2 * panel + 1) as f64 * half;
        for (node, weight) in nodes {
            sum += weight * f(centre + half * node);
            if node > 0.0 {
                sum += weight * f(centre - half * node);
            }
        }
    }
    sum * half
}

/// Height of the step at the edge of the support, as a part of the peak: zero but for the cut Gaussian.
fn step_at_the_edge(name: &str) -> f64 {
    if name == "TruncatedGaussian" { (-TruncatedGaussian::TRUNCATION.powi(2)).exp() } else { 0.0 }
}

fn surface_and_power_are_those_of_the_textbook<const D: usize>() {
    // At most six roundings.
    let relative = unit_sphere_surface::<D>() / surface(D) - 1.0;
    assert!(relative.abs() < 6.0 * f64::EPSILON, "{D} dimensions: {relative}");
    assert_eq!(power::<D>(2.0).to_bits(), f64::from(1_u32 << D).to_bits());
}

#[test]
fn surface_of_the_unit_sphere_and_powers_are_those_of_the_textbook() {
    in_every_dimension!(surface_and_power_are_those_of_the_textbook());
}

fn integral_is_one<const D: usize>(h: f64) {
    let kernels = all::<D>();
    assert!(!kernels.is_empty());
    for (name, kernel) in kernels {
        // 60 panels over the support put a panel's edge wherever a spline changes piece. Polynomials are of degree 18
        // at most, the Gaussian is smooth: the quadrature is exact within roundoff of some 300 terms.
        let shell = |r: f64| kernel.value(r, h) * surface(D) * power::<D>(r) / r;
        let integral = quadrature(shell, 0.0, kernel.support_radius(h), 60);
        assert!((integral - 1.0).abs() < 1e-13, "{name} in {D} dimensions: {integral}");
    }
}

#[test]
fn every_kernel_integrates_to_one() {
    in_every_dimension!(integral_is_one(1.0));
    in_every_dimension!(integral_is_one(0.3));
}

fn positive_and_falling<const D: usize>() {
    for (name, kernel) in all::<D>() {
        let n = 1000;
        let mut previous = kernel.shape(0.0);
        assert!((previous - 1.0).abs() < f64::EPSILON, "{name}: shape(0) is the peak, one");
        for step in 1..n {
            let q = kernel.support() * f64::from(step) / f64::from(n);
            let shape = kernel.shape(q);
            assert!(
                shape > 0.0 && shape < previous,
                "{name} in {D} dimensions at q = {q}: {shape}"
            );
            assert!(kernel.shape_derivative(q) < 0.0, "{name} in {D} dimensions at q = {q}");
            previous = shape;
        }
    }
}

#[test]
fn every_kernel_is_positive_and_falls_up_to_its_edge() {
    in_every_dimension!(positive_and_falling());
}

fn nothing_beyond_the_support<const D: usize>() {
    for (name, kernel) in all::<D>() {
        let s = kernel.support();
        for q in [s, s * (1.0 + f64::EPSILON), 1.5 * s, 1e3, f64::INFINITY] {
            for value in
                [kernel.shape(q), kernel.shape_derivative(q), kernel.shape_derivative_over_q(q)]
            {
                assert!(value.abs() == 0.0, "{name} in {D} dimensions at q = {q}: {value}");
            }
        }
        assert!(kernel.shape(0.99 * s) > 0.0, "{name}: the support is not overstated");
        let step = step_at_the_edge(name);
        // Every polynomial here vanishes at least as the cube of the distance to its edge, its slope as the square.
        let inside = s * (1.0 - 1e-6);
        assert!(
            (kernel.shape(inside) - step).abs() < 1e-15 + 1e-4 * step,
            "{name} jumps at its edge"
        );
        let slope = -2.0 * s * step;
        let error = (kernel.shape_derivative(inside) - slope).abs();
        assert!(error < 1e-10 + 1e-4 * slope.abs(), "{name}: slope jumps at its edge");
    }
}

#[test]
fn every_kernel_ends_at_its_support_and_steps_only_where_it_says_so() {
    in_every_dimension!(nothing_beyond_the_support());
}

fn finite_at_zero<const D: usize>() {
    for (name, kernel) in all::<D>() {
        let at_zero = kernel.gradient_factor(0.0, 0.7);
        // The quotient moves by at most about 2 q of itself near 0.
        let nearby = kernel.radial_derivative(0.7e-6, 0.7) / 0.7e-6;
        assert!(
            at_zero < 0.0 && (nearby / at_zero - 1.0).abs() < 1e-5,
            "{name}: {at_zero} {nearby}"
        );
        assert!(norm(&kernel.gradient(&[0.0; D], 0.0, 0.7)) == 0.0, "{name}");
    }
}

#[test]
fn gradient_of_coincident_points_is_zero_and_its_factor_finite() {
    in_every_dimension!(finite_at_zero());
}

fn nan_stays_nan<const D: usize>() {
    for (name, kernel) in all::<D>() {
        assert!(kernel.value(f64::NAN, 1.0).is_nan(), "{name}");
        assert!(kernel.gradient_factor(f64::NAN, 1.0).is_nan(), "{name}");
        assert!(kernel.value(0.5, f64::NAN).is_nan(), "{name}");
    }
}

#[test]
fn nan_is_never_taken_for_a_distant_point() {
    in_every_dimension!(nan_stays_nan());
}

fn norm<const D: usize>(x: &[f64; D]) -> f64 {
    x.iter().map(|component| component * component).sum::<f64>().sqrt()
}

/// Central differences of `value` in each coordinate of the first point, and in `h`.
fn derivatives_are_differences<const D: usize>(coordinates: &[f64], h: f64) {
    let x: [f64; D] = std::array::from_fn(|axis| coordinates[axis] * h);
    let r = norm(&x);
    let step = 1e-5 * h;
    for (name, kernel) in all::<D>() {
        let edge = kernel.support_radius(h);
        if step_at_the_edge(name) > 0.0 && (r - edge).abs() < 5.0 * step {
            continue;
        }
        // In units of sigma/h^(D+1): third derivatives of the shapes stay below 200 (D = 6), so the truncation is below
        // 200/6 * 1e-10; roundoff of a value is some 20 ulps, over the step 4e-10.
        let tolerance = 5e-9 * kernel.normalisation() / (power::<D>(h) * h);
        let gradient = kernel.gradient(&x, r, h);
        for axis in 0..D {
            let shifted = |by: f64| {
                let mut shifted = x;
                shifted[axis] += by;
                kernel.value(norm(&shifted), h)
            };
            let difference = (shifted(step) - shifted(-step)) / (2.0 * step);
            let error = (gradient[axis] - difference).abs();
            assert!(error < tolerance, "{name} in {D} dimensions at r = {r}, h = {h}: {error}");
            let opposite = kernel.gradient(&x.map(|component| -component), r, h)[axis];
            assert_eq!(
                opposite.to_bits(),
                (-gradient[axis]).to_bits(),
                "{name}: not antisymmetric"
            );
        }
        let along = (kernel.value(r + step, h) - kernel.value((r - step).abs(), h)) / (2.0 * step);
        assert!((kernel.radial_derivative(r, h) - along).abs() < tolerance, "{name} dW/dr at {r}");
        let in_h = (kernel.value(r, h + step) - kernel.value(r, h - step)) / (2.0 * step);
        let error = (kernel.smoothing_length_derivative(r, h) - in_h).abs();
        // W goes as h^-D: third derivatives in h up to (D+2)(D+1)D and those of the shape with q^3 up to 27.
        assert!(
            error < 20.0 * tolerance,
            "{name} dW/dh in {D} dimensions at r = {r}, h = {h}: {error}"
        );
    }
}

fn scales_with_length<const D: usize>(q: f64, h: f64, scale: f64) {
    for (name, kernel) in all::<D>() {
        let value = kernel.value(q * h, h);
        let scaled = kernel.value(q * h * scale, h * scale) * power::<D>(scale);
        // q is off by two roundings, which the slope (at most 2 of the peak) and the powers of D turn into 3 D + 8 ulps.
        let peak = kernel.value(0.0, h);
        let edge = (q - kernel.support()).abs() < 1e-9 && step_at_the_edge(name) > 0.0;
        let tolerance = (3 * D + 8) as f64 * f64::EPSILON * peak;
        assert!(edge || (scaled - value).abs() <= tolerance, "{name} in {D} dimensions at q = {q}");
    }
}

/// Of two places the nearer has the larger value; neither is negative, and beyond the support there is nothing.
fn nearer_is_larger<const D: usize>(a: f64, b: f64) {
    let (near, far) = (a.min(b), a.max(b));
    for (name, kernel) in all::<D>() {
        let (larger, smaller) = (kernel.shape(near), kernel.shape(far));
        // Half a dozen roundings of numbers below one; of the quintic spline's pieces, up to 6 * 3^5 / 66 times one.
        assert!(
            larger >= smaller - 64.0 * f64::EPSILON && larger <= 1.0 + 64.0 * f64::EPSILON,
            "{name} in {D} dimensions at {near} and {far}: {larger} {smaller}"
        );
        for (q, shape) in [(near, larger), (far, smaller)] {
            let is_inside = q < kernel.support();
            // Within a hundredth of the edge the tenth power of a distance may be lost.
            let is_well_inside = q < 0.99 * kernel.support();
            assert!(
                shape >= 0.0 && (shape > 0.0 || !is_well_inside) && (is_inside || shape == 0.0),
                "{name} in {D} dimensions at {q}: {shape}"
            );
            let slope = kernel.shape_derivative(q);
            let small = 64.0 * f64::EPSILON;
            assert!(slope <= small && (is_inside || slope == 0.0), "{name} at {q}: {slope}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100_000))]

    #[test]
    fn nearer_of_two_places_has_the_larger_value(a in 0.0..4.0_f64, b in 0.0..4.0_f64) {
        in_every_dimension!(nearer_is_larger(a, b));
    }

    #[test]
    fn derivatives_are_the_differences_of_the_value(
        direction in prop::collection::vec(-1.0..1.0_f64, 6),
        h in 0.1..3.0_f64,
    ) {
        // Scaled so that r covers the supports, 1 to 3 h, in every dimension.
        let reach: Vec<f64> = direction.iter().map(|component| 1.6 * component).collect();
        in_every_dimension!(derivatives_are_differences(&reach, h));
    }

    #[test]
    fn value_scales_with_the_unit_of_length(q in 0.0..3.5_f64, h in 0.1..3.0_f64, scale in 0.1..10.0_f64) {
        in_every_dimension!(scales_with_length(q, h, scale));
    }
}
