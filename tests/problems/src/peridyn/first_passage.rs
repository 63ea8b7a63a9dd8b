//! First passage of an Ornstein-Uhlenbeck path over a level: of the path itself, and of the paths that steps of schemes make.
//!
//! `dX = -X dt + sqrt(2) dB` has the standard deviation one; one time is that of its relaxation.

use peridyn_sde::Scheme;

/// Below this the density of the path is nothing, in standard deviations.
const FAR: f64 = 12.0;

/// The rate at which paths end at the level `b` after long: the lowest eigenvalue of
///
/// $$ f'' - x f' + \lambda f = 0, \qquad f(b) = 0, $$
///
/// with the solution that grows least towards minus infinity, `|x|^lambda`. By Runge-Kutta from there, and bisection.
#[must_use]
pub fn rate(b: f64) -> f64 {
    let (mut low, mut high) = (0.0, 3.0 * b * (-0.5 * b * b).exp());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at_level(middle, b) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

fn at_level(lambda: f64, b: f64) -> f64 {
    let n = 6000;
    let h = (b + FAR) / f64::from(n);
    let slope = |x: f64, [f, g]: [f64; 2]| [g, x * g - lambda * f];
    let (mut x, mut y) = (-FAR, [1.0, -lambda / FAR]);
    for _ in 0..n {
        let along = |k: [f64; 2], part: f64| [y[0] + part * h * k[0], y[1] + part * h * k[1]];
        let first = slope(x, y);
        let second = slope(x + 0.5 * h, along(first, 0.5));
        let third = slope(x + 0.5 * h, along(second, 0.5));
        let fourth = slope(x + h, along(third, 1.0));
        for k in 0..2 {
            y[k] += h / 6.0 * (first[k] + 2.0 * second[k] + 2.0 * third[k] + fourth[k]);
        }
        x += h;
    }
    y[0]
}

/// The rate of a scheme whose steps `z` are looked at with the bridge: the largest eigenvalue of its transition from `x` to `y` below
/// the level, times the probability not to have crossed in between, on a grid.
#[must_use]
pub fn rate_with_bridge(scheme: Scheme, z: f64, b: f64) -> f64 {
    let (factor, variance) = match scheme {
        Scheme::Theta(theta) => {
            let implicit = 1.0 + theta * z;
            (1.0 - z / implicit, 2.0 * z / (implicit * implicit))
        }
        Scheme::Heun => (1.0 - z + 0.5 * z * z, 2.0 * z * (1.0 - 0.5 * z) * (1.0 - 0.5 * z)),
        _ => (1.0 - z, 2.0 * z),
    };
    // Ten points to a standard deviation of a step.
    let width = b + 8.0;
    let count = (10.0 * width / variance.sqrt()).ceil();
    let h = width / count;
    let places: Vec<f64> = std::iter::successors(Some(b - 0.5 * h), |x| Some(x - h))
        .take_while(|&x| x > -8.0)
        .collect();
    // A step of six deviations and more is nothing.
    let reach = 6.5 * variance.sqrt();
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a place on the grid"
    )]
    let index = |distance: f64| (distance / h).max(0.0) as usize;
    let mut survival = vec![1.0; places.len()];
    let mut eigenvalue = 0.0;
    // After twenty relaxation times the shape is that of the eigenvector.
    for _ in 0..index(h * 20.0 / z) {
        let next: Vec<f64> = places
            .iter()
            .map(|&x| {
                let middle = factor * x;
                let first = index(b - middle - reach - 0.5 * h);
                let last = index(b - middle + reach + 0.5 * h).min(places.len());
                (first..last.max(first))
                    .map(|at| {
                        let y = places[at];
                        let d = y - middle;
                        let step = (-0.5 * d * d / variance).exp();
                        step * -(-(b - x) * (b - y) / z).exp_m1() * survival[at]
                    })
                    .sum::<f64>()
                    * h
                    / (2.0 * std::f64::consts::PI * variance).sqrt()
            })
            .collect();
        eigenvalue = next.iter().copied().fold(0.0, f64::max);
        survival = next.into_iter().map(|value| value / eigenvalue).collect();
    }
    -eigenvalue.ln() / z
}

/// The rate of a scheme whose steps `z` are looked at where they end: the largest eigenvalue of its transition among states that are
/// below the level, on a grid.
///
/// Leimkuhler and Matthews' displacements are `x = y + a R` with `a = sqrt(2 z)/2`, where `y' = (1 - z) y + (2 - z) a R` and the next
/// step draws the next `R`: the state is `y`, and what is looked at is `x`.
#[must_use]
pub fn rate_at_ends(scheme: Scheme, z: f64, b: f64) -> f64 {
    let averaged = scheme == Scheme::LeimkuhlerMatthews;
    let (factor, half) = (1.0 - z, 0.5 * (2.0 * z).sqrt());
    let deviation = if averaged { (2.0 - z) * half } else { 2.0 * half };
    // Twenty points to a standard deviation of a step; a step of 6.5 deviations and more is nothing.
    let h = 0.05 * deviation;
    let (reach, end) = (6.5 * deviation, if averaged { b + 6.5 * half } else { b });
    let places: Vec<f64> = std::iter::successors(Some(end - 0.5 * h), |x| Some(x - h))
        .take_while(|&x| x > -8.0)
        .collect();
    let weight = h / (std::f64::consts::TAU.sqrt() * deviation);
    let mut survival = vec![1.0; places.len()];
    let mut eigenvalue = 0.0;
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "counts of steps and places"
    )]
    let index = |number: f64| number.max(0.0) as usize;
    for _ in 0..index(20.0 / z) {
        let next: Vec<f64> = places
            .iter()
            .map(|&y| {
                let middle = factor * y;
                let first = index((end - middle - reach) / h);
                let last = index((end - middle + reach) / h).min(places.len());
                let sum = (first..last.max(first)).map(|at| {
                    let normal = (places[at] - middle) / deviation;
                    // Where the step before ended: of Euler's the place itself.
                    let seen = if averaged { y + half * normal } else { y };
                    let share = ((b - seen) / (half * h / deviation) + 0.5).clamp(0.0, 1.0);
                    let lives = if averaged { share } else { f64::from(u8::from(seen < b)) };
                    lives * (-0.5 * normal * normal).exp() * survival[at]
                });
                sum.sum::<f64>() * weight
            })
            .collect();
        eigenvalue = next.iter().copied().fold(0.0, f64::max);
        survival = next.into_iter().map(|value| value / eigenvalue).collect();
    }
    -eigenvalue.ln() / z
}
