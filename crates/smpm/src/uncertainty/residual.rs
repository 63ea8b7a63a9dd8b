//! What a Taylor series leaves of whole runs that it has not used.

use perturbation_moments::{MonteCarlo, SIGMA_POINT_DISTANCE};

use super::experiment::Experiment;
use super::series::Series;
use super::study::{MOST_SIGNS, Study, signs};
use crate::error::Error;
use crate::parallel::map_in_order;
use crate::record::gathered::Plain;

/// Directions of check runs; two runs each.
const N_CHECKS: usize = 2;

/// Errors of a series in root mean squares of its residuals. A linear error is that much or less in 78 of 100 cases: with two
/// directions its square is covered with the probability `exp(-1/4)`.
const COVERAGE: f64 = 2.0;

/// Step of differences, in standard deviations, above which check runs at one deviation are too near to those of the series.
const WIDE: f64 = 0.5;

/// Distance of the two runs that look for a response that changes its course, such as by yielding, in standard deviations.
const FAR: f64 = 3.0;
/// Distance of these runs over that of the others, below which they would show nothing new.
const FARTHER: f64 = 1.2;
/// What a kink at $a = \sqrt3$, from which the response departs by $e$ at three deviations, changes of mean and deviation, over $e$:
/// $(\phi(a) - a Q(a))/(3 - a)$ and $Q(a)/(3 - a)$.
const OF_KINK: [f64; 2] = [0.0134, 0.033];

/// Seed of the signs of many normals.
const SEED: u64 = 0x5eed;

/// Errors of mean and standard deviation of a [`Series`], measured by runs that it has not used.
///
/// Along directions $u$ of signs $\pm 1$, a distance of $d$ deviations of every normal at once,
///
/// $$ r = \tfrac1{2 d} (y(d u) - y(-d u)) - g \cdot u, \qquad
///    c = \tfrac1{2 d^2} (y(d u) + y(-d u) - 2 y_0) - \tfrac12 \sum_k h_k . $$
///
/// Of one normal $d = \sqrt3$: with a step $s$ of the differences, third and fourth derivatives leave $\tfrac16 y^{(3)} (3 - s^2)$ in
/// $r$ and $\tfrac1{24} y^{(4)} (3 - s^2)$ in $c$, their exact effects on the slope and on the mean. Of several $d = 1$, and
/// $\sqrt3$ where the step is above a half. Runs at the distance of the step would be those of the series: near $\sqrt3$ it is one.
///
/// A wrong gradient $g + \delta$ has $\operatorname{E} r^2 = \lvert \delta \rvert^2$, mixed curvature
/// $\operatorname{E} c^2 = \tfrac12 \sum_{j \ne k} H_{jk}^2$. With root mean squares $\bar r$ and $\bar c$ over two directions the
/// error of the mean is $2 \bar c$ and the part $2 \bar r/s$ of its curvature, which is no better known than the slopes; that of the
/// standard deviation $s$ is
///
/// $$ 2 \bar r + \sqrt{s^2 + \tfrac12 \sum_k h_k^2 + (2 \bar c)^2} - s . $$
///
/// Two more runs lie at three deviations along each direction, beyond the others. What they depart from the polynomial through all
/// before, with $r$ as a third and $c$ as a second power, is taken as a kink at $\sqrt3$ deviations, along the direction where it is
/// largest: yielding depends on the ratio of modulus and stress, and one direction leaves it as it was. If one of them fails, the errors
/// are infinite.
///
/// Own curvatures of one-sided differences, which have none, are in $\bar c$ by their sum.
/// So a response that jumps between neighbouring inputs, as where particles fail in one run and not in the next, has an error as large
/// as its deviation, however small the step of the differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesError {
    /// Error of [`Series::mean`], in the unit of the response.
    pub mean: f64,
    /// Error of the root of [`Series::variance`], in the unit of the response.
    pub standard_deviation: f64,
}

impl SeriesError {
    /// From the responses at both ends of each direction, near and far.
    fn new(
        series: &Series,
        directions: &[Vec<f64>],
        (distance, pairs): (f64, &[[f64; 2]]),
        far: Option<(f64, &[[f64; 2]])>,
    ) -> Self {
        let of = |(ends, u): (&[f64; 2], &Vec<f64>)| residuals(series, u, distance, ends);
        let residuals: Vec<[f64; 2]> = pairs.iter().zip(directions).map(of).collect();
        let n = residuals.len().max(1) as f64;
        let mean_square = |k: usize| residuals.iter().map(|r| r[k] * r[k]).sum::<f64>() / n;
        let [odd, even] = [0, 1].map(|k| COVERAGE * mean_square(k).sqrt());
        let curved = series.surrogate_variance() + even * even;
        let standard_deviation = odd + (curved.sqrt() - series.variance().sqrt());
        let deviation = series.variance().sqrt();
        let unsure = if deviation > 0.0 { odd / deviation } else { 0.0 };
        let mean = even + unsure * (series.mean() - series.value).abs();
        let along = |(far, ends): (f64, &[[f64; 2]])| {
            let kinks = ends.iter().zip(residuals.iter().zip(directions));
            kinks
                .map(|(ends, (near, u))| kink(series, u, (distance, near), (far, ends)))
                .fold(0.0, f64::max)
        };
        let kink = far.map_or(0.0, along);
        let [of_mean, of_deviation] = OF_KINK;
        Self {
            mean: mean + of_mean * kink,
            standard_deviation: standard_deviation + of_deviation * kink,
        }
    }
}

/// The residuals `r` and `c` at both ends of a direction.
fn residuals(series: &Series, u: &[f64], distance: f64, [plus, minus]: &[f64; 2]) -> [f64; 2] {
    let slope: f64 = series.gradient.iter().zip(u).map(|(g, u)| g * u).sum();
    let square = distance * distance;
    // The squares of signs are one: the curvature of the series is in its mean.
    let curved = series.value + square * (series.mean() - series.value);
    let odd = 0.5 * (plus - minus) / distance - slope;
    [odd, 0.5 * ((plus - curved) + (minus - curved)) / square]
}

/// What the responses farther out depart from the polynomial through the nearer ones, times the coverage.
fn kink(
    series: &Series,
    u: &[f64],
    (distance, [odd, even]): (f64, &[f64; 2]),
    (far, ends): (f64, &[f64; 2]),
) -> f64 {
    let [odd_far, even_far] = residuals(series, u, far, ends);
    let ratio = far / distance;
    let odd = far * (odd_far - odd * ratio * ratio);
    let even = far * far * (even_far - even);
    COVERAGE * (odd.abs() + even.abs())
}

impl<X: Experiment<D>, const D: usize> Study<'_, X, D> {
    /// Errors of the series of all responses, of differences with this step in standard deviations, from up to eight whole runs that
    /// they have not used.
    ///
    /// # Errors
    /// [`Error::NoSuchResponse`] for another number of series; those of the experiment and of a run.
    pub fn series_errors(&self, series: &[Series], step: f64) -> Result<Vec<SeriesError>, Error> {
        let (value, limit) = (series.len(), self.runs.plan.n_responses());
        if value != limit {
            return Err(Error::NoSuchResponse { value, limit });
        }
        let directions = self.check_directions();
        let distance = check_distance(self.inputs.n_random(), step);
        let far = self.far_distance(distance);
        let ends: Vec<(usize, f64)> = [Some(distance), far]
            .into_iter()
            .flatten()
            .flat_map(|distance| (0..directions.len()).map(move |k| (k, distance)))
            .flat_map(|(k, distance)| [(k, distance), (k, -distance)])
            .collect();
        let run = |&(k, distance): &(usize, f64)| {
            let normals: Vec<f64> = directions[k].iter().map(|sign| distance * sign).collect();
            let mut simulation = self.simulation_at(&normals)?;
            let name = format!("check run at {distance} along {k}");
            self.runs.follow(name, &mut simulation, &Plain, ()).map(|(values, ())| values)
        };
        let mut near = map_in_order(&ends, &run);
        let far_ends: Option<Vec<Vec<f64>>> =
            near.split_off(2 * directions.len()).into_iter().collect::<Result<_, _>>().ok();
        let ends: Vec<Vec<f64>> = near.into_iter().collect::<Result<_, _>>()?;
        let of = |(response, series): (usize, &Series)| {
            let pair = |ends: &[Vec<f64>]| [ends[0][response], ends[1][response]];
            let pairs = |ends: &[Vec<f64>]| ends.chunks_exact(2).map(pair).collect::<Vec<_>>();
            let failed = || vec![[f64::INFINITY; 2]; directions.len()];
            let far_pairs = far_ends.as_deref().map_or_else(failed, pairs);
            let far = far.map(|far| (far, far_pairs.as_slice()));
            SeriesError::new(series, &directions, (distance, &pairs(&ends)), far)
        };
        Ok(series.iter().enumerate().map(of).collect())
    }

    /// Distance of the farther runs for every normal, where it is beyond that of the others.
    fn far_distance(&self, distance: f64) -> Option<f64> {
        let far = FAR / (self.inputs.n_random() as f64).sqrt();
        (far > FARTHER * distance).then_some(far)
    }

    /// Number of runs of [`series_errors`](Self::series_errors).
    #[must_use]
    pub fn n_check_runs(&self, step: f64) -> u64 {
        let far = self.far_distance(check_distance(self.inputs.n_random(), step));
        2 * self.check_directions().len() as u64 * (1 + u64::from(far.is_some()))
    }

    /// Different directions of signs.
    fn check_directions(&self) -> Vec<Vec<f64>> {
        let (n, all) = (self.inputs.n_random(), self.n_normals());
        let mut directions = signs(n, N_CHECKS);
        if n > MOST_SIGNS {
            let sign = |normal: &f64| normal.signum();
            let of = |k: usize| {
                let mut normals = vec![0.0; n];
                MonteCarlo { seed: SEED, n_samples: 0 }.fill_normals(k as u64, &mut normals);
                normals.iter().map(sign).collect()
            };
            directions = (0..N_CHECKS).map(of).collect();
        }
        for signs in &mut directions {
            signs.resize(all, 0.0);
        }
        directions
    }
}

/// Distance of check runs of so many normals, in standard deviations, for differences with this step.
fn check_distance(n: usize, step: f64) -> f64 {
    let is_wide = n == 1 || step > WIDE;
    let is_used = (step * step - SIGMA_POINT_DISTANCE * SIGMA_POINT_DISTANCE).abs() < 1.0;
    if is_wide && !is_used { SIGMA_POINT_DISTANCE } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error of a series whose differences have these slopes, against a response.
    fn error_of(y: &dyn Fn(&[f64]) -> f64, gradient: &[f64]) -> SeriesError {
        let n = gradient.len();
        let (value, curvature) = (y(&vec![0.0; n]), Vec::new());
        let series = Series { value, gradient: gradient.to_vec(), curvature, mixed_squares: None };
        let directions = signs(n, N_CHECKS);
        let distance = check_distance(n, 0.05);
        let ends = |u: &Vec<f64>| {
            let at = |side: f64| y(&u.iter().map(|u| side * distance * u).collect::<Vec<f64>>());
            [at(1.0), at(-1.0)]
        };
        let pairs: Vec<[f64; 2]> = directions.iter().map(ends).collect();
        SeriesError::new(&series, &directions, (distance, &pairs), None)
    }

    #[test]
    fn steps_of_any_width_have_the_errors_of_higher_derivatives() {
        let y = |t: f64| 1.0 + t + 0.2 * t.powi(3) + 0.1 * t.powi(4);
        // Mean 1 + 0.1 E t^4, slope E t y.
        let (mean, slope) = (1.3, 1.6);
        for step in [0.01, 0.3, 0.9, 1.0, 1.1, 1.5, 2.5] {
            let distance = check_distance(1, step);
            let pair = |t: f64| [y(t), y(-t)];
            let [plus, minus] = pair(step);
            let gradient = vec![0.5 * (plus - minus) / step];
            let curvature = vec![(plus + minus - 2.0) / (step * step)];
            let series = Series { value: 1.0, gradient, curvature, mixed_squares: None };
            let far = [pair(FAR)];
            let far = Some((FAR, &far[..]));
            let near = (distance, &[pair(distance)][..]);
            let found = SeriesError::new(&series, &[vec![1.0]], near, far);
            assert!((series.mean() - mean).abs() <= found.mean, "{step}: {found:?}");
            let off = (series.gradient[0] - slope).abs();
            assert!(off <= found.standard_deviation, "{step}: {off} {found:?}");
        }
    }

    #[test]
    fn a_kink_beyond_the_check_runs_is_in_the_error() {
        for kink in [1.8, 2.0, 2.5] {
            let y = |t: f64| t - 0.7 * (t - kink).max(0.0);
            let pair = |t: f64| [y(t), y(-t)];
            let series = Series {
                value: 0.0,
                gradient: vec![1.0],
                curvature: Vec::new(),
                mixed_squares: None,
            };
            let (near, far) = ([pair(SIGMA_POINT_DISTANCE)], [pair(FAR)]);
            let near = (SIGMA_POINT_DISTANCE, &near[..]);
            let found = SeriesError::new(&series, &[vec![1.0]], near, Some((FAR, &far[..])));
            // Moments by the trapezoidal rule.
            let h = 1e-3;
            let sum = |f: &dyn Fn(f64) -> f64| -> f64 {
                let at = |k: i32| f64::from(k) * h;
                (-9000..=9000).map(|k| f(y(at(k))) * (-0.5 * at(k) * at(k)).exp()).sum::<f64>() * h
                    / std::f64::consts::TAU.sqrt()
            };
            let mean = sum(&|y| y);
            let deviation = (sum(&|y| y * y) - mean * mean).sqrt();
            assert!(
                mean.abs() <= found.mean && mean.abs() > 0.02 * found.mean,
                "{kink}: {found:?}"
            );
            assert!((deviation - 1.0).abs() <= found.standard_deviation, "{kink}: {found:?}");
        }
    }

    #[test]
    fn a_kink_of_a_ratio_is_in_the_error_whichever_input_is_above() {
        for side in [1.0, -1.0] {
            // Nothing yields along (1, 1), nor at one deviation along (1, -1).
            let y = |t: &[f64]| t[1] + 0.5 * (side * (t[1] - t[0]) / 2.0_f64.sqrt() - 1.6).max(0.0);
            let series = Series {
                value: 0.0,
                gradient: vec![0.0, 1.0],
                curvature: Vec::new(),
                mixed_squares: None,
            };
            let directions = signs(2, N_CHECKS);
            let pair = |u: &Vec<f64>, d: f64| {
                [d, -d].map(|d| y(&u.iter().map(|u| d * u).collect::<Vec<_>>()))
            };
            let pairs = |d: f64| directions.iter().map(|u| pair(u, d)).collect::<Vec<_>>();
            let (near, far) = (pairs(1.0), pairs(FAR / 2.0_f64.sqrt()));
            let far = Some((FAR / 2.0_f64.sqrt(), &far[..]));
            let found = SeriesError::new(&series, &directions, (1.0, &near), far);
            // (phi(a) - a Q(a))/2 at a = 1.6.
            let off = 0.5 * (0.110_92 - 1.6 * 0.054_80);
            assert!(off <= found.mean && off > 0.1 * found.mean, "{side}: {off} {found:?}");
        }
    }

    fn normals(case: u64, n: usize) -> Vec<f64> {
        let mut normals = vec![0.0; n];
        MonteCarlo { seed: 11, n_samples: 0 }.fill_normals(case, &mut normals);
        normals
    }

    #[test]
    fn errors_of_wrong_slopes_hold_however_many_inputs_there_are() {
        let length = |g: &[f64]| g.iter().map(|g| g * g).sum::<f64>().sqrt();
        for n in [1, 2, 3, 5, 8, 17] {
            for noise in [0.05, 0.5, 20.0] {
                let held = |case: &u64| {
                    let (right, wrong) = (normals(2 * case, n), normals(2 * case + 1, n));
                    let slopes: Vec<f64> =
                        right.iter().zip(wrong).map(|(g, e)| g + noise * e).collect();
                    let linear =
                        |t: &[f64]| 3.0 + t.iter().zip(&right).map(|(t, g)| t * g).sum::<f64>();
                    let found = error_of(&linear, &slopes).standard_deviation;
                    (length(&slopes) - length(&right)).abs() <= found
                };
                let share = (0..400).filter(held).count() as f64 / 400.0;
                // At least exp(-1/4) = 0.78 less four standard errors of 400 cases.
                assert!(share > 0.69, "{n} {noise}: {share}");
            }
        }
    }

    #[test]
    fn a_jump_near_the_centre_has_an_error_as_large_as_its_deviation_at_every_step() {
        let jump = |t: &[f64]| if t[0] > 0.004 { 0.3 } else { 0.0 };
        let response = |t: &[f64]| 0.1 * t[1] + jump(t);
        for step in [0.005, 0.01, 0.05] {
            let slopes = [jump(&[step]) / step, 0.1];
            let found = error_of(&response, &slopes).standard_deviation;
            // The right deviation of the sum: of the line, and of a jump that half of the samples pass.
            let right = 0.1_f64.hypot(0.15);
            let deviation = slopes[0].hypot(slopes[1]);
            assert!((deviation - right).abs() < found && found > 0.7 * deviation, "{found}");
        }
    }
}
