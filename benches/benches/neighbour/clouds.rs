//! Clouds of points in random memory order, the same in every run.

use std::f64::consts::{PI, TAU};

use particle_store::Lattice;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

/// Largest radius of a normal cloud, in units of its smallest.
const RADIUS_RATIO: f64 = 20.0;

/// Random numbers with a fixed seed, so that every run has the same clouds.
fn random<T, L: Distribution<T>>(law: L) -> impl FnMut() -> T {
    let mut generator = ChaCha8Rng::seed_from_u64(20);
    move || law.sample(&mut generator)
}

fn shuffle<T>(items: &mut [T]) {
    let mut next = random::<u64, _>(StandardUniform);
    for last in (1..items.len()).rev() {
        items.swap(last, usize::try_from(next() % (last as u64 + 1)).unwrap());
    }
}

/// Cloud of a density solver with spacing 1: 41 x 41 particles over 6 standard deviations, deformed by the flow.
pub(crate) fn sheared_lattice() -> Vec<[f64; 2]> {
    let lattice = Lattice::<2>::box_lattice([20.0; 2], [41; 2]).unwrap();
    let (sin, cos) = 0.5_f64.sin_cos();
    let mut points: Vec<_> = lattice
        .points
        .iter()
        .map(|[x, y]| {
            let x = x + 0.2 * y;
            [cos * x - sin * y, sin * x + cos * y]
        })
        .collect();
    shuffle(&mut points);
    points
}

/// Independent points in the unit box, and the radius that contains a number of neighbours in the interior.
///
/// Near the faces part of the ball is empty.
pub(crate) fn uniform<const D: usize>(n_points: usize, neighbours: f64) -> (Vec<[f64; D]>, f64) {
    let mut next = random::<f64, _>(StandardUniform);
    let points = (0..n_points).map(|_| std::array::from_fn(|_| next())).collect();
    (points, radius::<D>(neighbours, n_points as f64))
}

/// A normal cloud, and radii with about `neighbours` points everywhere.
///
/// `h` is proportional to the density to the power `-1/D`, up to 20 times its smallest value. Radii are a formula of
/// the point, so none equals the distance of a neighbour.
pub(crate) fn normal<const D: usize>(
    n_points: usize,
    neighbours: f64,
) -> (Vec<[f64; D]>, Vec<f64>) {
    let mut next = random::<f64, _>(StandardNormal);
    let points: Vec<[f64; D]> = (0..n_points).map(|_| std::array::from_fn(|_| next())).collect();
    let densest = n_points as f64 / TAU.powf(D as f64 / 2.0);
    let smallest = radius::<D>(neighbours, densest);
    let radii = points
        .iter()
        .map(|x| {
            let square: f64 = x.iter().map(|x_k| x_k * x_k).sum();
            smallest * (0.5 * square / D as f64).exp().min(RADIUS_RATIO)
        })
        .collect();
    (points, radii)
}

/// Radius of the disc or ball with a number of points at a density.
fn radius<const D: usize>(neighbours: f64, density: f64) -> f64 {
    let unit_ball = if D == 2 { PI } else { PI * 4.0 / 3.0 };
    (neighbours / (density * unit_ball)).powf(1.0 / D as f64)
}
