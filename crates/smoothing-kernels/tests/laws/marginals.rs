//! Second moments, marginal densities and distributions of every kernel, against other ways to the same number.

use proptest::prelude::*;
use smoothing_kernels::{Kernel, Lucy, WendlandC2, all};
use std::f64::consts::PI;

/// What the documentation promises of the marginals.
const PROMISED: f64 = 1e-10;

/// `∫_a^b f` by Simpson's rule: another rule than the crate's.
fn simpson(f: impl Fn(f64) -> f64, a: f64, b: f64, panels: u32) -> f64 {
    let width = (b - a) / f64::from(panels);
    (0..panels)
        .map(|panel| {
            let start = a + f64::from(panel) * width;
            width / 6.0 * (f(start) + 4.0 * f(start + 0.5 * width) + f(start + width))
        })
        .sum()
}

#[test]
fn second_moments_of_lucy_are_the_closed_ones() {
    // ∫ (1 - 6q^2 + 8q^3 - 3q^4) q^n dq = 24 / ((n+1)(n+3)(n+4)(n+5)): kappa = (D)(D+2)(D+3)(D+4) over D times the
    // denominator at n = D + 1, that is (D+3) / ((D+5)(D+6)) for every D.
    fn closed<const D: usize>() {
        let d = D as f64;
        let expected = (d + 3.0) / ((d + 5.0) * (d + 6.0));
        let kappa = Kernel::<D>::second_moment(&Lucy);
        assert!((kappa / expected - 1.0).abs() < 1e-13, "{D}: {kappa} {expected}");
    }
    in_every_dimension!(closed());
}

#[test]
fn second_moments_of_wendland_are_the_published_ones() {
    // Dehnen & Aly 2012, table 1: the standard deviation over the support, squared, is 2/21 in one dimension, 5/72 in
    // two and 1/15 in three; the support is 2 h.
    let ours = [
        Kernel::<1>::second_moment(&WendlandC2),
        Kernel::<2>::second_moment(&WendlandC2),
        Kernel::<3>::second_moment(&WendlandC2),
    ];
    for (ours, published) in ours.into_iter().zip([2.0 / 21.0, 5.0 / 72.0, 1.0 / 15.0]) {
        assert!((ours / (4.0 * published) - 1.0).abs() < 1e-13, "{ours} {published}");
    }
}

fn marginal_has_mass_one_and_the_second_moment<const D: usize>() {
    let h = 0.7;
    for (name, kernel) in all::<D>() {
        // 600 panels end at every knot; the error of Simpson's rule goes as their width to the fourth, 1e-8 of the
        // shortest scale, a sixth of the support. Where the Gaussian is cut its marginal in the plane ends as a root, of
        // height 1e-4: over the last panel, 2e-3 wide, Simpson's rule misses some 1e-4 (2e-3)^(3/2).
        let tolerance = if name == "TruncatedGaussian" { 1e-7 } else { 1e-8 };
        let edge = kernel.support_radius(h) * (1.0 - 1e-14);
        let mass = 2.0 * simpson(|x| kernel.marginal_density(x, h), 0.0, edge, 600);
        assert!((mass - 1.0).abs() < tolerance, "{name} in {D} dimensions: {mass}");
        let moment = 2.0 * simpson(|x| x * x * kernel.marginal_density(x, h), 0.0, edge, 600);
        let expected = kernel.second_moment() * h * h;
        assert!(
            (moment - expected).abs() < tolerance,
            "{name} in {D} dimensions: {moment} {expected}"
        );
    }
}

#[test]
fn marginal_of_every_kernel_has_mass_one_and_its_second_moment() {
    in_every_dimension!(marginal_has_mass_one_and_the_second_moment());
}

fn distribution_is_the_integral<const D: usize>() {
    let h = 1.3;
    for (name, kernel) in all::<D>() {
        let edge = kernel.support_radius(h);
        let mut previous = 0.0;
        for step in -20..=20_i32 {
            let x = edge * f64::from(step) / 20.0;
            let below = kernel.marginal_distribution(x, h);
            assert!(below >= previous - PROMISED, "{name} in {D} dimensions falls at {x}");
            let mirrored = kernel.marginal_distribution(-x, h);
            assert!((below + mirrored - 1.0).abs() < 2.0 * PROMISED, "{name} at {x}: {below}");
            if step > -20 {
                let from = edge * f64::from(step - 1) / 20.0;
                let inside = (1.0 - 1e-14) * edge;
                let density = |x: f64| kernel.marginal_density(x.clamp(-inside, inside), h);
                let mass = simpson(density, from, x, 60);
                assert!(
                    (below - previous - mass).abs() < 1e-8,
                    "{name} in {D} dimensions up to {x}: {below} {previous} {mass}"
                );
            }
            previous = below;
        }
        assert!((kernel.marginal_distribution(0.0, h) - 0.5).abs() < PROMISED, "{name}");
        assert!((kernel.marginal_distribution(2.0 * edge, h) - 1.0).abs() < 1e-15, "{name}");
        assert!(kernel.marginal_distribution(-2.0 * edge, h).abs() < 1e-15, "{name}");
        assert!(kernel.marginal_density(2.0 * edge, h).abs() < 1e-15, "{name}");
        assert!(kernel.marginal_density(f64::NAN, h).is_nan(), "{name}");
        assert!(kernel.marginal_distribution(f64::NAN, h).is_nan(), "{name}");
    }
}

#[test]
fn distribution_of_every_kernel_is_the_integral_of_its_density() {
    in_every_dimension!(distribution_is_the_integral());
}

/// Where a panel ends near `x` the integrand is least smooth: points of every size, from the edge down to zero.
fn places(support: f64) -> impl Iterator<Item = f64> {
    [0.0, 1e-9, 1e-5, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.2, 0.31, 0.5, 0.77, 0.98]
        .into_iter()
        .map(move |part| part * support)
}

#[test]
fn marginal_in_three_dimensions_is_that_of_archimedes() {
    // A sphere's slices are equal: m(x) = 2π σ ∫_x^s w(t) t dt, and the distribution beyond x is
    // 2π σ ∫_x^s w(t) t (t - x) dt.
    for (name, kernel) in all::<3>() {
        let (s, scale) = (kernel.support(), 2.0 * PI * kernel.normalisation());
        let below_edge = s * (1.0 - 1e-15);
        for x in places(s) {
            let shell = |t: f64| kernel.shape(t.min(below_edge)) * t;
            let density = scale * simpson(shell, x, s, 4000);
            let error = (kernel.marginal_density(x, 1.0) - density).abs();
            assert!(error < PROMISED, "{name} at {x}: {error}");
            let beyond = scale * simpson(|t| shell(t) * (t - x), x, s, 4000);
            let error = (1.0 - kernel.marginal_distribution(x, 1.0) - beyond).abs();
            assert!(error < PROMISED, "{name} at {x}: {error}");
        }
    }
}

#[test]
fn marginal_in_the_plane_is_the_integral_along_a_line() {
    for (name, kernel) in all::<2>() {
        let s = kernel.support();
        for x in places(s) {
            // Panels that grow as the cube of their number: fine where the integrand turns, near y = 0.
            let reach = ((s - x) * (s + x)).sqrt() * (1.0 - 1e-13);
            let line = |u: f64| {
                let y = reach * u * u * u;
                kernel.value(x.hypot(y), 1.0) * 3.0 * reach * u * u
            };
            let density = 2.0 * simpson(line, 0.0, 1.0, 20000);
            let error = (kernel.marginal_density(x, 1.0) - density).abs();
            assert!(error < PROMISED, "{name} at {x}: {error}");
        }
    }
}

fn transform_has_the_sign_it_should<const D: usize>() {
    for (name, kernel) in all::<D>() {
        // The transform of a radial function along an axis is that of its marginal.
        let s = kernel.support();
        let points: Vec<(f64, f64)> = (0..600_u32)
            .map(|k| {
                let x = s * (f64::from(k) + 0.5) / 600.0;
                (x, kernel.marginal_density(x, 1.0))
            })
            .collect();
        let transform = |wave_number: f64| -> f64 {
            let sum: f64 = points.iter().map(|(x, m)| m * (wave_number * x).cos()).sum();
            2.0 * s / 600.0 * sum
        };
        // The midpoint rule's error for a function that vanishes at its edge as (s - x)^2 or faster is below 1e-7.
        let lowest = (1..200).map(|k| transform(f64::from(k) * 0.2 / s)).fold(1.0, f64::min);
        let positive = name.starts_with("Wendland") || (name == "Lucy" && D == 1);
        if positive {
            assert!(lowest > -1e-7, "{name} in {D} dimensions: {lowest}");
        } else if D == 2 || D == 3 {
            assert!(lowest < -2e-6, "{name} in {D} dimensions: {lowest}");
        }
    }
}

#[test]
fn only_wendland_functions_have_a_positive_fourier_transform() {
    in_every_dimension!(transform_has_the_sign_it_should());
}

/// The density is the slope of the distribution, which rises from 0 to 1 and is even about one half.
fn density_is_the_slope<const D: usize>(which: prop::sample::Index, part: f64, h: f64) {
    let kernels = all::<D>();
    let (name, kernel) = &kernels[which.index(kernels.len())];
    let edge = kernel.support_radius(h);
    let (x, step) = (part * edge, 1e-3 * edge);
    // At its cut the Gaussian's marginal has a step in one dimension and ends as a root in two.
    if *name == "TruncatedGaussian" && (1.0 - part.abs()).abs() < 0.05 {
        return;
    }
    let (below, above) =
        (kernel.marginal_distribution(x - step, h), kernel.marginal_distribution(x + step, h));
    let mean = (above - below) / (2.0 * step) * edge;
    let density = kernel.marginal_density(x, h) * edge;
    // In units of the support second derivatives of the marginals stay below 150: step^2 / 6 of them, and PROMISED over
    // the step.
    assert!((mean - density).abs() < 3e-5, "{name} in {D} dimensions at {part}: {mean} {density}");
    assert!(below >= -PROMISED && above <= 1.0 + PROMISED && below <= above + PROMISED, "{name}");
    let mirrored = kernel.marginal_distribution(-x - step, h);
    assert!((above + mirrored - 1.0).abs() < 2.0 * PROMISED, "{name} in {D} dimensions at {part}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100_000))]

    #[test]
    fn density_of_a_coordinate_is_the_slope_of_its_distribution(
        dimension in 1..=6_u8, which in any::<prop::sample::Index>(),
        part in -1.3..1.3_f64, h in 0.1..3.0_f64,
    ) {
        match dimension {
            1 => density_is_the_slope::<1>(which, part, h),
            2 => density_is_the_slope::<2>(which, part, h),
            3 => density_is_the_slope::<3>(which, part, h),
            4 => density_is_the_slope::<4>(which, part, h),
            5 => density_is_the_slope::<5>(which, part, h),
            _ => density_is_the_slope::<6>(which, part, h),
        }
    }
}
