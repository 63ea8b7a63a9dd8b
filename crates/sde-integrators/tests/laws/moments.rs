//! The exact moments of a linear system under a method, without sampling: a step is an affine map of state and noise,
//! found by probing it with unit vectors.

use sde_integrators::{Increment, Integrator, Sde};

pub(crate) type Matrix = Vec<Vec<f64>>;

/// `x -> a x + b + by_w w + by_h H` for one Brownian motion.
#[derive(Debug, Clone)]
pub(crate) struct StepMap {
    pub(crate) a: Matrix,
    pub(crate) b: Vec<f64>,
    pub(crate) by_w: Vec<f64>,
    pub(crate) by_h: Vec<f64>,
}

/// The affine map of one step of a method on a linear system.
pub(crate) fn probe<S, I, const D: usize>(system: &S, method: &I, t: f64, dt: f64) -> StepMap
where
    I: Integrator<S, D, 1>,
{
    let image = |x: [f64; D], w: f64, h: f64| {
        let dw = Increment { brownian: [w], space_time_area: [h] };
        let mut x = x;
        method.step(system, t, dt, &dw, &mut x, &mut I::Memory::default()).expect("a step");
        x
    };
    let b = image([0.0; D], 0.0, 0.0);
    let less_b = |x: [f64; D]| x.iter().zip(&b).map(|(x, b)| x - b).collect::<Vec<_>>();
    let columns: Vec<_> = (0..D)
        .map(|j| less_b(image(std::array::from_fn(|i| f64::from(u8::from(i == j))), 0.0, 0.0)))
        .collect();
    StepMap {
        a: transpose(&columns),
        b: b.to_vec(),
        by_w: less_b(image([0.0; D], 1.0, 0.0)),
        by_h: less_b(image([0.0; D], 0.0, 1.0)),
    }
}

impl StepMap {
    /// The covariance that one step of length `dt` adds.
    pub(crate) fn added_covariance(&self, dt: f64) -> Matrix {
        add(&scale(&outer(&self.by_w), dt), &scale(&outer(&self.by_h), dt / 12.0))
    }
}

/// Mean and covariance of a state.
#[derive(Debug, Clone)]
pub(crate) struct Moments {
    pub(crate) mean: Vec<f64>,
    pub(crate) covariance: Matrix,
}

impl Moments {
    pub(crate) fn largest_difference(&self, other: &Self) -> f64 {
        let values = |m: &Self| [m.mean.clone(), m.covariance.concat()].concat();
        let difference =
            values(self).iter().zip(values(other)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(values(self).iter().all(|value| value.is_finite()));
        difference
    }
}

/// The moments after `n_steps` steps to time `end`, from time 0.
pub(crate) fn after_steps<S, I, const D: usize>(
    system: &S,
    method: &I,
    start: &Moments,
    end: f64,
    n_steps: u32,
) -> Moments
where
    I: Integrator<S, D, 1>,
{
    let dt = end / f64::from(n_steps);
    let mut now = start.clone();
    for n in 0..n_steps {
        let map = probe(system, method, f64::from(n) * dt, dt);
        now.mean = apply(&map.a, &now.mean).iter().zip(&map.b).map(|(x, b)| x + b).collect();
        now.covariance = add(&congruence(&map.a, &now.covariance), &map.added_covariance(dt));
    }
    now
}

/// The moments of the linear system itself: its moment equations by the classical Runge-Kutta method,
/// `m' = F m + f`, `P' = F P + P F^T + g g^T`.
pub(crate) fn exact<S, const D: usize>(
    system: &S,
    start: &Moments,
    end: f64,
    n_steps: u32,
) -> Moments
where
    S: Sde<D, 1>,
{
    let h = end / f64::from(n_steps);
    let rate = |t: f64, now: &Moments| {
        let f = system.drift(t, &[0.0; D]);
        let columns: Vec<Vec<f64>> = (0..D)
            .map(|j| {
                let unit = std::array::from_fn(|i| f64::from(u8::from(i == j)));
                system.drift(t, &unit).iter().zip(&f).map(|(x, f)| x - f).collect()
            })
            .collect();
        let jacobian = transpose(&columns);
        let flow = multiply(&jacobian, &now.covariance);
        let noise = system.noise(t, &[0.0; D]).concat();
        Moments {
            mean: apply(&jacobian, &now.mean).iter().zip(&f).map(|(x, f)| x + f).collect(),
            covariance: add(&add(&flow, &transpose(&flow)), &outer(&noise)),
        }
    };
    let moved = |from: &Moments, by: &Moments, length: f64| Moments {
        mean: from.mean.iter().zip(&by.mean).map(|(x, v)| x + length * v).collect(),
        covariance: add(&from.covariance, &scale(&by.covariance, length)),
    };
    let mut now = start.clone();
    for n in 0..n_steps {
        let t = f64::from(n) * h;
        let k_1 = rate(t, &now);
        let k_2 = rate(t + 0.5 * h, &moved(&now, &k_1, 0.5 * h));
        let k_3 = rate(t + 0.5 * h, &moved(&now, &k_2, 0.5 * h));
        let k_4 = rate(t + h, &moved(&now, &k_3, h));
        for (k, weight) in [(k_1, 1.0), (k_2, 2.0), (k_3, 2.0), (k_4, 1.0)] {
            now = moved(&now, &k, h * weight / 6.0);
        }
    }
    now
}

/// The solution of `P = A P A^T + Q` by doubling: after `k` rounds the first `2^k` terms of its series.
pub(crate) fn stationary(map: &StepMap, dt: f64) -> Matrix {
    let (mut a, mut p) = (map.a.clone(), map.added_covariance(dt));
    for _ in 0..40 {
        p = add(&p, &congruence(&a, &p));
        a = multiply(&a, &a);
    }
    p
}

/// `sqrt(E |X_h - X_{h/2}|^2)` at time `end` for a method on one path seen at two step lengths, from a given point.
pub(crate) fn strong_difference<S, I, const D: usize>(
    system: &S,
    method: &I,
    start: [f64; D],
    end: f64,
    n_steps: u32,
) -> f64
where
    I: Integrator<S, D, 1>,
{
    let (h, fine_h) = (end / f64::from(n_steps), 0.5 * end / f64::from(n_steps));
    let mut mean = [start, start].concat();
    let mut covariance = vec![vec![0.0; 2 * D]; 2 * D];
    for n in 0..n_steps {
        let t = f64::from(n) * h;
        let coarse = probe(system, method, t, h);
        let fine = [probe(system, method, t, fine_h), probe(system, method, t + fine_h, fine_h)];
        let pushed = |x: &[f64]| apply(&fine[1].a, x);
        let fine_a = multiply(&fine[1].a, &fine[0].a);
        let fine_b: Vec<_> =
            pushed(&fine[0].b).iter().zip(&fine[1].b).map(|(x, y)| x + y).collect();
        let a: Matrix = (0..2 * D)
            .map(|i| {
                let (row, from) = if i < D { (&coarse.a[i], 0) } else { (&fine_a[i - D], D) };
                (0..2 * D)
                    .map(|j| if (from..from + D).contains(&j) { row[j - from] } else { 0.0 })
                    .collect()
            })
            .collect();
        mean = apply(&a, &mean)
            .iter()
            .zip([coarse.b.clone(), fine_b].concat())
            .map(|(x, b)| x + b)
            .collect();
        covariance = congruence(&a, &covariance);
        // How w_1, H_1, w_2, H_2 enter: the coarse increment is that of Increment::from_halves.
        let increment = |w: f64, h: f64| Increment { brownian: [w], space_time_area: [h] };
        let units = [(1.0, 0.0, 0), (0.0, 1.0, 0), (1.0, 0.0, 1), (0.0, 1.0, 1)];
        for (w, area, half) in units {
            let mut halves = [Increment::ZERO; 2];
            halves[half] = increment(w, area);
            let whole = Increment::from_halves(&halves[0], &halves[1]);
            let of = |map: &StepMap, dw: &Increment<1>| -> Vec<f64> {
                map.by_w
                    .iter()
                    .zip(&map.by_h)
                    .map(|(w, h)| w * dw.brownian[0] + h * dw.space_time_area[0])
                    .collect()
            };
            let own = of(&fine[half], &halves[half]);
            let fine_effect = if half == 0 { pushed(&own) } else { own };
            let effect = [of(&coarse, &whole), fine_effect].concat();
            let variance = if area > 0.0 { fine_h / 12.0 } else { fine_h };
            covariance = add(&covariance, &scale(&outer(&effect), variance));
        }
    }
    let square: f64 = (0..D)
        .map(|i| {
            let bias = mean[i] - mean[i + D];
            bias * bias + covariance[i][i] + covariance[i + D][i + D] - 2.0 * covariance[i][i + D]
        })
        .sum();
    square.sqrt()
}

/// The slope of `log2 error` over `log2 h` by least squares, for errors at step lengths halved each time.
pub(crate) fn order(errors: &[f64]) -> f64 {
    assert!(errors.len() >= 4 && errors.iter().all(|e| e.is_finite() && *e > 1e-11), "{errors:?}");
    let n = errors.len() as f64;
    let centre = 0.5 * (n - 1.0);
    let (mut numerator, mut denominator) = (0.0, 0.0);
    for (level, error) in errors.iter().enumerate() {
        let distance = level as f64 - centre;
        numerator -= distance * error.log2();
        denominator += distance * distance;
    }
    numerator / denominator
}

pub(crate) fn transpose(a: &Matrix) -> Matrix {
    (0..a[0].len()).map(|j| a.iter().map(|row| row[j]).collect()).collect()
}

pub(crate) fn apply(a: &Matrix, x: &[f64]) -> Vec<f64> {
    a.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
}

pub(crate) fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transpose(b);
    a.iter().map(|row| apply(&columns, row)).collect()
}

fn congruence(a: &Matrix, p: &Matrix) -> Matrix {
    multiply(&multiply(a, p), &transpose(a))
}

fn outer(x: &[f64]) -> Matrix {
    x.iter().map(|a| x.iter().map(|b| a * b).collect()).collect()
}

fn add(a: &Matrix, b: &Matrix) -> Matrix {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a + b).collect()).collect()
}

fn scale(a: &Matrix, factor: f64) -> Matrix {
    a.iter().map(|row| row.iter().map(|a| a * factor).collect()).collect()
}
