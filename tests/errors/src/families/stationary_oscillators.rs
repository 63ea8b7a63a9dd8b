//! Nonlinear oscillators in their exact stationary distribution (Caughey 1971).

use fpk_scenes::scene::FpkScene;
use fpk_scenes::system::System;
use fpk_scenes::system_scene::SystemScene;
use serde_json::{Value, json};
use vibrating_systems::Window;

use super::density_methods::{Class, Solvable, method, of_density};
use super::linear_systems::{built, moment_id};
use crate::draw::{Draw, rounded};
use crate::verdict::of_scene;
use crate::{Family, Truth};

pub(super) const FAMILY: Family = Family {
    name: "stationary-oscillators",
    known_by: "closed stationary density, integrated to 1e-9; what is left of the start is below 1e-4",
    weight: 1.0,
    draw,
    truths: |scene| of_density(scene, truths),
    judge: of_scene,
};

/// Relative distance from the stationary distribution at the end of a run.
const LEFT: f64 = 1e-4;

fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let w = draw.scaled(1.0, 6.0);
    let s = draw.scaled(0.01, 1.0);
    let system = if draw.chance(0.6) {
        let xi = draw.between(0.1, 0.3);
        let linear = s / (2.0 * xi * w.powi(3));
        // Mean cubic force over the linear one.
        let cubic = rounded(draw.between(0.05, 0.5) / linear);
        json!({ "duffing": { "structure": {
            "natural_frequency": w, "damping_ratio": xi, "noise_intensity": s, "window": "stationary" },
            "cubic_stiffness": cubic } })
    } else {
        let a = w * draw.between(0.05, 0.3);
        let b = rounded(a / draw.between(0.5, 3.0) / (s / w));
        json!({ "van_der_pol": { "natural_frequency": w, "self_excitation": a,
            "energy_damping": b, "noise_intensity": s, "window": "stationary" } })
    };
    let Some((second, until)) = stationary(&built(&system)) else { unreachable!("it is one") };
    let every = rounded(until / 2.0);
    let deviation = [[2, 0], [0, 2]].map(|powers| rounded(second(powers).sqrt()));
    let of = Solvable {
        n_states: 2,
        period: std::f64::consts::TAU / w,
        class: Class::Oscillator,
        has_filter: false,
        is_linear: false,
        has_thresholds: false,
    };
    let (name, method) = method(draw, &of, hostile);
    let scene = json!({
        "solver": "fpk-sph", "title": "a stationary oscillator", "system": system,
        "initial": { "gaussian": { "mean": [0, 0], "standard_deviation": deviation } },
        "method": method, "times": { "until": 2.0 * every, "every": every },
        "moments": [[2, 0], [0, 2], [4, 0], [0, 4]], "thresholds": [],
    });
    (scene, name)
}

/// A moment of even powers in the stationary distribution.
type Moment = Box<dyn Fn([i32; 2]) -> f64>;

/// Moments in the stationary distribution, and the time after which it is reached from one of the same variance.
fn stationary(system: &SystemScene) -> Option<(Moment, f64)> {
    match *system {
        SystemScene::Duffing(ref hardening) if hardening.structure.window == Window::Stationary => {
            let (cubic, structure) = (hardening.cubic_stiffness, &hardening.structure);
            let (w, xi) = (structure.natural_frequency, structure.damping_ratio);
            let v2 = structure.noise_intensity / (2.0 * xi * w);
            let potential = move |q: f64| w * w * (0.5 * q * q + 0.25 * cubic * q.powi(4));
            let edge = 9.0 * v2.sqrt() / w;
            let of =
                move |power: i32| integral(edge, &|q| q.powi(power) * (-potential(q) / v2).exp());
            // E[v^2n] = (2n - 1)!! E[v^2]^n, independent of q.
            let of_v = move |power: i32| match power {
                0 => 1.0,
                2 => v2,
                _ => 3.0 * v2 * v2,
            };
            let moment = move |[q, v]: [i32; 2]| of(q) / of(0) * of_v(v);
            Some((Box::new(moment), 10.0 / (2.0 * xi * w)))
        }
        SystemScene::VanDerPol {
            natural_frequency: w,
            self_excitation: a,
            energy_damping: b,
            noise_intensity: s,
            window: Window::Stationary,
        } => {
            // With r = w^2 q^2 + v^2 the density is exp((a r/2 - b r^2/4)/S_0).
            let density = move |r: f64| ((0.5 * a * r - 0.25 * b * r * r) / s).exp();
            let edge = a / b + 12.0 * (s / b).sqrt();
            let of = move |power: i32| {
                // The rule takes half of its first point.
                let half = |r: f64| {
                    if r < 0.0 {
                        0.0
                    } else if r == 0.0 {
                        0.5
                    } else {
                        1.0
                    }
                };
                integral(edge, &|r| half(r) * r.powi(power) * density(r))
            };
            // Means of cos^q sin^v over the phase.
            let phase = |powers: [i32; 2]| match powers {
                [0, 0] => 1.0,
                [2, 0] | [0, 2] => 0.5,
                [2, 2] => 0.125,
                _ => 0.375,
            };
            let moment = move |powers: [i32; 2]| {
                let half = i32::midpoint(powers[0], powers[1]);
                of(half) / of(0) * phase(powers) / w.powi(powers[0])
            };
            Some((Box::new(moment), 12.0 / a))
        }
        _ => None,
    }
}

fn truths(scene: &FpkScene, _: &System) -> Option<Vec<Truth>> {
    let (moment, until) = stationary(&scene.system)?;
    let time = scene.times.list().pop().filter(|&t| t > 0.99 * until)?;
    let is_known = |powers: &&Vec<u32>| {
        powers.iter().all(|power| power % 2 == 0) && (2..=4).contains(&powers.iter().sum::<u32>())
    };
    let known = |powers: &Vec<u32>| {
        let value = moment(std::array::from_fn(|k| i32::try_from(powers[k]).unwrap_or(0)));
        Truth { id: moment_id(powers), time: Some(time), value, error: LEFT * value }
    };
    Some(scene.moments.iter().filter(is_known).map(known).collect())
}

/// Trapezoidal rule, which converges faster than any power where the integrand vanishes at both ends.
fn integral(edge: f64, f: &dyn Fn(f64) -> f64) -> f64 {
    let n = 40_000;
    let h = 2.0 * edge / f64::from(n);
    (0..=n).map(|k| h * f(-edge + f64::from(k) * h)).sum()
}
