//! Scalar processes whose density or moments are known.

use fpk_scenes::law_scene::LawScene;
use fpk_scenes::scene::FpkScene;
use fpk_scenes::system::System;
use fpk_scenes::system_scene::SystemScene;
use serde_json::{Value, json};

use super::density_methods::{Class, Solvable, method, of_density};
use super::linear_systems::{moment_id, times};
use crate::draw::{Draw, rounded};
use crate::normal::Normal;
use crate::verdict::of_scene;
use crate::{Family, Truth};

/// Double wells.
pub(super) const WELLS: Family = Family {
    name: "double-wells",
    known_by: "implicit finite volumes with exponential fluxes at two resolutions",
    weight: 1.0,
    draw: wells,
    truths: |scene| of_density(scene, truths_of_wells),
    judge: of_scene,
};

/// Square-root processes and geometric Brownian motion.
pub(super) const CLOSED: Family = Family {
    name: "scalar-closed-moments",
    known_by: "moment equations that close, solved to 1e-9",
    weight: 1.0,
    draw: closed,
    truths: |scene| of_density(scene, truths_of_closed),
    judge: of_scene,
};

fn wells(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let (growth, cubic) = (draw.scaled(0.3, 2.0), draw.scaled(0.3, 3.0));
    let well = (growth / cubic).sqrt();
    // The barrier a^2 / (4 b) over the diffusion.
    let barrier = draw.between(0.5, if hostile { 4.0 } else { 2.0 });
    let diffusion = rounded(0.25 * growth * growth / cubic / barrier);
    let mean = rounded(well * draw.between(-0.5, 0.5));
    let deviation = rounded(well * draw.between(0.15, 0.5));
    let period = std::f64::consts::TAU * 0.5 / growth;
    let (times, every) = times(draw, period, hostile);
    let thresholds = [0.8, 1.3, 1.8].map(|part| rounded(part * well));
    let of = Solvable {
        n_states: 1,
        period,
        class: Class::Additive,
        has_filter: false,
        is_linear: false,
        has_thresholds: true,
    };
    let (name, method) = method(draw, &of, hostile);
    let scene = json!({
        "solver": "fpk-sph", "title": "a double well",
        "system": { "bistable": { "growth": growth, "cubic": cubic, "diffusion": diffusion } },
        "initial": { "gaussian": { "mean": [mean], "standard_deviation": [deviation] } },
        "method": method, "times": { "until": times.last(), "every": every },
        "moments": [[2], [4]], "thresholds": thresholds,
    });
    (scene, name)
}

fn truths_of_wells(scene: &FpkScene, _: &System) -> Option<Vec<Truth>> {
    let SystemScene::Bistable { growth, cubic, diffusion } = scene.system else { return None };
    let LawScene::Gaussian { mean, standard_deviation } = &scene.initial else { return None };
    let (mean, deviation) = (mean[0], standard_deviation[0]);
    let times = scene.times.list();
    let period = std::f64::consts::TAU * 0.5 / growth.abs();
    let drift = |x: f64| growth * x - cubic * x * x * x;
    let square = growth.max(0.0) / cubic;
    let edge = (square + 6.0 * (40.0 * diffusion / cubic).sqrt()).sqrt();
    let edge = edge.max(mean.abs() + 8.0 * deviation);
    let solve = |n: usize, steps: f64| {
        let grid = Grid { edge, n, step: period / steps };
        finite_volumes(&drift, diffusion, (mean, deviation), &grid, &times)
    };
    let (fine, coarse) = (solve(1_600, 1_200.0), solve(800, 600.0));
    let mut truths = Vec::new();
    for ((&t, fine), coarse) in times.iter().zip(&fine).zip(&coarse) {
        // Both are of second order: the fine one is off by a third of the difference.
        let mut known = |id: String, of: &dyn Fn(&Cells) -> f64| {
            let (value, error) = (of(fine), (of(fine) - of(coarse)).abs());
            truths.push(Truth { id, time: Some(t), value, error });
        };
        for powers in &scene.moments {
            let power = i32::try_from(powers[0]).ok()?;
            known(moment_id(powers), &|cells| cells.mean(&|x| x.powi(power)));
        }
        for &threshold in &scene.thresholds {
            known(format!("exceedance/{threshold}"), &|cells| cells.beyond(threshold));
        }
    }
    Some(truths)
}

/// Cells over `[-edge, edge]`, and the longest step.
struct Grid {
    edge: f64,
    n: usize,
    step: f64,
}

/// Masses of cells of equal width on `[-edge, edge]`.
struct Cells {
    edge: f64,
    masses: Vec<f64>,
}

impl Cells {
    fn width(&self) -> f64 {
        2.0 * self.edge / self.masses.len() as f64
    }

    fn mean(&self, f: &dyn Fn(f64) -> f64) -> f64 {
        let centre = |k: usize| -self.edge + (k as f64 + 0.5) * self.width();
        self.masses.iter().enumerate().map(|(k, mass)| mass * f(centre(k))).sum()
    }

    /// `P(|x| > T)`, with the part of the cell that holds the threshold.
    fn beyond(&self, threshold: f64) -> f64 {
        let h = self.width();
        let part = |k: usize| {
            let (low, high) = (-self.edge + k as f64 * h, -self.edge + (k + 1) as f64 * h);
            let above = (high - threshold).clamp(0.0, h) + (-threshold - low).clamp(0.0, h);
            above / h
        };
        self.masses.iter().enumerate().map(|(k, mass)| mass * part(k)).sum()
    }
}

/// Exponentially fitted finite volumes (Scharfetter and Gummel 1969) with Crank-Nicolson steps, after four implicit ones.
fn finite_volumes(
    drift: &dyn Fn(f64) -> f64,
    diffusion: f64,
    (mean, deviation): (f64, f64),
    &Grid { edge, n, step }: &Grid,
    times: &[f64],
) -> Vec<Cells> {
    let h = 2.0 * edge / n as f64;
    let at = |face: usize| -edge + face as f64 * h;
    let bernoulli = |z: f64| if z.abs() < 1e-8 { 1.0 - 0.5 * z } else { z / z.exp_m1() };
    // Flux over a face: up * mass below - down * mass above.
    let rates: Vec<[f64; 2]> = (0..=n)
        .map(|face| {
            if face == 0 || face == n {
                return [0.0; 2];
            }
            let z = drift(at(face)) * h / diffusion;
            let unit = diffusion / (h * h);
            [unit * bernoulli(-z), unit * bernoulli(z)]
        })
        .collect();
    let normal = |x: f64| sde_integrators::normal_probability((x - mean) / deviation);
    let mut masses: Vec<f64> = (0..n).map(|k| normal(at(k + 1)) - normal(at(k))).collect();
    let (mut t, mut done) = (0.0, 0_u32);
    let mut all = Vec::new();
    for &end in times {
        let steps = ((end - t) / step).ceil().max(1.0);
        let dt = (end - t) / steps;
        let mut k = 0.0;
        while k < steps {
            let implicit = if done < 4 { 1.0 } else { 0.5 };
            masses = stepped(&masses, &rates, dt, implicit);
            done += 1;
            k += 1.0;
        }
        t = end;
        all.push(Cells { edge, masses: masses.clone() });
    }
    all
}

fn stepped(masses: &[f64], rates: &[[f64; 2]], dt: f64, implicit: f64) -> Vec<f64> {
    let n = masses.len();
    let explicit = (1.0 - implicit) * dt;
    let flux = |face: usize| {
        let [up, down] = rates[face];
        let below = if face > 0 { masses[face - 1] } else { 0.0 };
        let above = if face < n { masses[face] } else { 0.0 };
        up * below - down * above
    };
    let mut right: Vec<f64> =
        (0..n).map(|k| masses[k] + explicit * (flux(k) - flux(k + 1))).collect();
    // (1 + theta dt (out)) m_k - theta dt (in from both sides) = right, solved by elimination.
    let theta = implicit * dt;
    let mut upper = vec![0.0; n];
    for k in 0..n {
        let diagonal = 1.0 + theta * (rates[k][1] + rates[k + 1][0]);
        let lower = if k > 0 { -theta * rates[k][0] } else { 0.0 };
        let pivot = diagonal - if k > 0 { lower * upper[k - 1] } else { 0.0 };
        upper[k] = -theta * rates[k + 1][1] / pivot;
        right[k] = (right[k] - if k > 0 { lower * right[k - 1] } else { 0.0 }) / pivot;
    }
    for k in (0..n.saturating_sub(1)).rev() {
        right[k] -= upper[k] * right[k + 1];
    }
    right
}

fn closed(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let (system, period, mean) = if draw.chance(0.5) {
        let (rate, level) = (draw.scaled(0.5, 2.0), draw.scaled(0.5, 2.0));
        // Twice rate and level over the variance of the noise: above one the process never reaches zero.
        let order = draw.between(if hostile { 1.5 } else { 6.0 }, 30.0);
        let volatility = rounded((2.0 * rate * level / order).sqrt());
        let system = json!({ "cox_ingersoll_ross": { "rate": rate, "mean": level, "volatility": volatility } });
        (system, std::f64::consts::TAU / rate, rounded(level * draw.between(0.7, 1.5)))
    } else {
        let (growth, volatility) = (draw.between(-0.3, 0.3), draw.between(0.1, 0.5));
        let system =
            json!({ "geometric_brownian_motion": { "growth": growth, "volatility": volatility } });
        (system, 1.0, draw.between(0.5, 2.0))
    };
    let deviation = rounded(mean * draw.between(0.05, 0.12));
    let (times, every) = times(draw, period, hostile);
    let of = Solvable {
        n_states: 1,
        period,
        class: Class::General,
        has_filter: false,
        is_linear: false,
        has_thresholds: false,
    };
    let (name, method) = method(draw, &of, hostile);
    let scene = json!({
        "solver": "fpk-sph", "title": "a scalar process", "system": system,
        "initial": { "gaussian": { "mean": [mean], "standard_deviation": [deviation] } },
        "method": method, "times": { "until": times.last(), "every": every },
        "moments": [[1], [2], [3]], "thresholds": [],
    });
    (scene, name)
}

/// `d E[X^k] / dt`, a combination of moments up to the `k`-th.
fn rates(system: &SystemScene, m: &[f64]) -> Option<Vec<f64>> {
    let rate = |n: usize| {
        let k = n as f64;
        Some(match *system {
            _ if n == 0 => 0.0,
            SystemScene::CoxIngersollRoss { rate, mean, volatility } => {
                let noise = 0.5 * k * (k - 1.0) * volatility * volatility;
                k * rate * (mean * m[n - 1] - m[n]) + noise * m[n - 1]
            }
            SystemScene::GeometricBrownianMotion { growth, volatility } => {
                m[n] * (k * growth + 0.5 * k * (k - 1.0) * volatility * volatility)
            }
            _ => return None,
        })
    };
    (0..m.len()).map(rate).collect()
}

/// Highest power of a moment.
const MOST_POWER: u32 = 8;

fn truths_of_closed(scene: &FpkScene, system: &System) -> Option<Vec<Truth>> {
    let LawScene::Gaussian { mean, standard_deviation } = &scene.initial else { return None };
    let variance = standard_deviation[0].powi(2);
    let law = Normal { mean: mean.clone(), covariance: vec![vec![variance]] };
    let mut now: Vec<f64> = (0..=MOST_POWER).map(|power| law.raw_moment(&[power])).collect();
    let _ = rates(&scene.system, &now)?;
    let of = |m: &[f64]| rates(&scene.system, m).unwrap_or_default();
    let (mut t, mut truths) = (0.0, Vec::new());
    for end in scene.times.list() {
        let steps = 400.0 * ((end - t) / system.reference_period()).ceil();
        let dt = (end - t) / steps;
        let mut done = 0.0;
        while done < steps {
            now = runge_kutta(&now, dt, &of);
            done += 1.0;
        }
        t = end;
        for powers in &scene.moments {
            let value = *now.get(usize::try_from(powers[0]).ok()?)?;
            let (id, error) = (moment_id(powers), 1e-8 * value.abs());
            truths.push(Truth { id, time: Some(end), value, error });
        }
    }
    Some(truths)
}

fn runge_kutta(m: &[f64], dt: f64, rates: &dyn Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let moved =
        |k: &[f64], by: f64| -> Vec<f64> { m.iter().zip(k).map(|(m, k)| m + by * k).collect() };
    let k_1 = rates(m);
    let k_2 = rates(&moved(&k_1, 0.5 * dt));
    let k_3 = rates(&moved(&k_2, 0.5 * dt));
    let k_4 = rates(&moved(&k_3, dt));
    let sum = |n: usize| k_1[n] + 2.0 * (k_2[n] + k_3[n]) + k_4[n];
    m.iter().enumerate().map(|(n, m)| m + dt / 6.0 * sum(n)).collect()
}
