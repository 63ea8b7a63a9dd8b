//! Bars and columns with one or two random inputs, by all methods of the material point solver.

use serde_json::{Value, json};
use smpm::uncertainty::Study;
use smpm_scenes::experiment::SceneExperiment;
use smpm_scenes::scene::SmpmScene;

use crate::draw::{Draw, rounded};
use crate::verdict::of_scene;
use crate::{Family, Truth, Verdict};

pub(super) const FAMILY: Family = Family {
    name: "smpm-responses",
    known_by: "runs on the grid and by the steps of the scene, summed over the normals by trapezoidal rules; not judged above a kurtosis of \
               eight and a quarter of the samples",
    weight: 1.5,
    draw,
    truths,
    judge: |scene, truths, longest| {
        let mut verdicts = of_scene(scene, truths, longest)?;
        for verdict in &mut verdicts {
            verdict.is_warned = is_unseen(scene, truths, verdict);
        }
        Ok(verdicts)
    },
};

/// Whether a number is off by no more than its remark says of events that no sample has met. Other remarks are no warnings.
fn is_unseen(scene: &Value, truths: &[Truth], verdict: &Verdict) -> bool {
    let method = scene["method"].as_object().and_then(|keys| keys.values().next());
    let Some(n) = method.filter(|keys| keys["control"] == true).and_then(n_samples) else {
        return false;
    };
    let id = verdict.truth.id.replace("/mean", "/standard_deviation");
    let is_deviation = |truth: &&Truth| truth.id == id && truth.time == verdict.truth.time;
    let deviation = truths.iter().find(is_deviation).map_or(0.0, |truth| truth.value);
    verdict.away() <= 3.0 / n * deviation
}

/// Samples of a method, if it has a number of them.
fn n_samples(method: &Value) -> Option<f64> {
    let number = |key: &str| method[key].as_f64();
    number("samples").or_else(|| Some(number("points")? * number("replicas")?))
}

/// Distances of the points of a rule for one and for two inputs, in standard deviations, and how far they reach.
const DISTANCES: [f64; 2] = [0.5, 1.2];
const REACH: f64 = 6.0;
const MOST_STEPS: i32 = 12;
/// Kurtosis that few runs can show, and runs for each of it where there are more: what rarer events decide no run knows.
const KURTOSIS: f64 = 8.0;
const RUNS_OF_KURTOSIS: f64 = 4.0;
/// Largest probability of points where the solver leaves its range, and distance of what they would have answered, in deviations.
const MOST_FAILED: f64 = 1e-5;
const FARTHEST: f64 = 100.0;
/// Roundoff of a deviation over the mean; what events that no run meets may change, over the deviation.
const ROUNDOFF: f64 = 1e-12;
const RAREST: f64 = 1e-4;

/// A material with its random parameters, a velocity, the speed of its waves, and two quantities.
fn material(draw: &mut Draw) -> (Value, &'static [&'static str], f64, f64, [&'static str; 2]) {
    match draw.whole(0, 4) {
        0 => (
            json!({ "equation": { "elastic_bulk": { "set": { "density": 7.8, "bulk_modulus": 160 } } },
                "strength": { "elastic": { "set": { "shear_modulus": 80 } } } }),
            &["equation.bulk_modulus", "strength.shear_modulus", "equation.density"],
            draw.scaled(0.01, 0.3),
            5.8,
            ["position_1", "stress_11"],
        ),
        1 => (
            json!({ "equation": { "mie_gruneisen": { "library": "steel" } } }),
            &["equation.s1", "equation.sound_speed", "equation.density"],
            draw.scaled(0.1, 1.0),
            4.6,
            ["pressure", "density"],
        ),
        2 => (
            json!({ "equation": { "mie_gruneisen": { "library": "copper" } },
                "strength": { "von_mises": { "library": "copper" } } }),
            &["strength.yield_stress", "strength.hardening_modulus", "strength.shear_modulus"],
            draw.scaled(0.01, 0.2),
            4.6,
            ["plastic_strain", "deviator_11"],
        ),
        3 => (
            json!({ "equation": { "stiffened_gas": {
                "set": { "density": 1, "exponent": 1.4, "stiffness": 0, "pressure": 1 } } } }),
            &["equation.exponent", "equation.pressure", "equation.density"],
            draw.scaled(0.05, 0.8),
            1.2,
            ["pressure", "energy"],
        ),
        _ => (
            json!({ "equation": { "neo_hookean": {
                "set": { "density": 1, "shear_modulus": 0.5, "bulk_modulus": 2 } } } }),
            &["equation.bulk_modulus", "equation.shear_modulus"],
            draw.scaled(0.05, 0.3),
            1.6,
            ["stress_11", "velocity_1"],
        ),
    }
}

fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let (material, parameters, velocity, speed, quantities) = material(draw);
    let length = 6.0;
    let times = [0.6, 1.0, 1.8].map(|part| rounded(part * length / speed * draw.between(0.9, 1.2)));
    let mut scene = json!({
        "solver": "smpm", "title": "a bar", "units": "mm_mg_us", "dimension": 1,
        "grid": { "cell": 0.5, "particles_per_cell": 2 },
        "boundaries": [{ "axis": 1, "position": 0, "side": "above", "kind": "symmetry" }],
        "materials": { "m": material },
        "bodies": [{ "name": "bar", "material": "m", "shape": { "box": { "from": [0], "to": [length] } },
            "velocity": [-velocity] }],
        "gauges": [{ "name": "end", "body": "bar", "at": [5.9] }, { "name": "wall", "body": "bar", "within": [[0], [2]] }],
        "quantities": quantities, "times": times,
    });
    let variation = |draw: &mut Draw| {
        if hostile { draw.between(0.1, 0.6) } else { draw.scaled(0.01, 0.15) }
    };
    let first = usize::try_from(draw.whole(0, parameters.len() as u64 - 1)).unwrap_or_default();
    let can_vary =
        scene["materials"]["m"]["strength"].is_object() && !parameters[first].ends_with("density");
    let (has_field, mut has_path) = (can_vary && draw.chance(0.2), false);
    if has_field {
        scene["random_fields"] = json!([{
            "parameters": [format!("m.{}", parameters[first])],
            "marginal": { "lognormal": { "coefficient_of_variation": variation(draw) } },
            "correlation": { "function": "matern32", "lengths": [draw.between(2.0, 8.0)] },
            "terms": { "number": draw.whole(1, 2) } }]);
    } else {
        let one = |draw: &mut Draw, parameter: &str| {
            let (variation, parameter) = (variation(draw), format!("m.{parameter}"));
            let law = if variation < 0.05 && draw.chance(0.5) { "normal" } else { "lognormal" };
            json!({ "parameter": parameter, "law": law, "coefficient_of_variation": variation })
        };
        let mut random = vec![one(draw, parameters[first])];
        has_path = draw.chance(0.2);
        if has_path {
            let mut velocity = one(draw, "");
            velocity["parameter"] = json!("bodies[0].velocity[0]");
            random.push(velocity);
        } else if draw.chance(0.6) {
            random.push(one(draw, parameters[(first + 1) % parameters.len()]));
            if draw.chance(0.2) {
                scene["correlations"] = json!([{ "value": draw.between(-0.9, 0.9),
                    "between": [random[0]["parameter"], random[1]["parameter"]] }]);
            }
        }
        scene["random"] = json!(random);
    }
    let is_correlated = scene["correlations"].is_array();
    let (name, method) = method(draw, [has_field, has_path, is_correlated], hostile);
    scene["method"] = method;
    (scene, name)
}

fn method(
    draw: &mut Draw,
    [has_field, has_path, is_correlated]: [bool; 3],
    hostile: bool,
) -> (&'static str, Value) {
    let seed = draw.whole(1, 1 << 30);
    let step = |draw: &mut Draw, usual: [f64; 2]| {
        let [low, high] = if hostile { [1e-5, 3.0] } else { usual };
        if hostile && draw.chance(0.3) { 1.0 } else { draw.scaled(low, high) }
    };
    let (points, replicas) = if hostile {
        (1 << draw.whole(1, 2), 8)
    } else {
        (1 << draw.whole(3, 5), draw.whole(8, 16))
    };
    let place = draw.whole(0, 11);
    let samples = if hostile { draw.whole(8, 24) } else { draw.whole(50, 400) };
    let control = draw.chance(0.5);
    let sampled = |control: bool| json!({ "monte_carlo": { "samples": samples, "seed": seed, "control": control } });
    match place {
        0 if !has_path => ("propagated", json!("propagated")),
        1 if !has_field && !has_path => ("frozen", json!({ "frozen": { "as_printed": false } })),
        2 if !has_field => ("sigma-points", json!("sigma_points")),
        3 | 4 if !has_field => {
            ("differences", json!({ "finite_difference": { "step": step(draw, [0.02, 0.5]) } }))
        }
        5 if !has_field => {
            ("one-sided", json!({ "forward_difference": { "step": step(draw, [0.005, 0.1]) } }))
        }
        6 | 7 if !has_field => (
            "quasi-monte-carlo",
            json!({ "quasi_monte_carlo":
                { "points": points, "replicas": replicas, "seed": seed, "control": control } }),
        ),
        8 if !has_field && !is_correlated => (
            "sobol-indices",
            json!({ "sobol_indices": { "points": points, "replicas": replicas, "seed": seed } }),
        ),
        9 => {
            let tolerance = if hostile { draw.between(0.2, 0.6) } else { draw.between(0.08, 0.2) };
            let pilot = if hostile { 8 } else { 16 };
            (
                "multilevel",
                json!({ "multilevel": { "tolerance": tolerance, "seed": seed,
                "responses": "last_time", "pilot": pilot, "most_runs": 4000 } }),
            )
        }
        _ if control => ("monte-carlo-controlled", sampled(true)),
        _ => ("monte-carlo", sampled(false)),
    }
}

/// Mean and deviation of every response at every time.
fn truths(scene: &Value) -> Option<Vec<Truth>> {
    let is_of_solver = scene["solver"] == "smpm" && scene["dimension"] == 1;
    let scene: SmpmScene = serde_json::from_value(scene.clone()).ok().filter(|_| is_of_solver)?;
    let (experiment, plan) = (SceneExperiment::<1>::new(&scene).ok()?, scene.plan::<1>().ok()?);
    let study = Study::new(&experiment, experiment.inputs(), plan.clone()).ok()?;
    let n = if scene.random.is_empty() { study.n_normals() } else { scene.random.len() };
    let distance = *DISTANCES.get(n.checked_sub(1)?)?;
    let [even, odd] = [0.0, 0.5].map(|shift| Sums::new(&study, n, distance, shift));
    let (even, odd) = (even?, odd?);
    let method = serde_json::to_value(scene.method).ok()?;
    let keys = method.as_object().and_then(|keys| keys.values().next());
    let samples = keys.and_then(n_samples).unwrap_or(0.0);
    let most = KURTOSIS.max(samples / RUNS_OF_KURTOSIS);
    let mut truths = Vec::new();
    for i in 0..plan.n_responses() {
        let (gauge, quantity, window) = plan.parts(i);
        let (time, [a, b]) = (plan.windows[window].to, [&even, &odd].map(|sums| sums.moments(i)));
        if even.kurtosis(i).max(odd.kurtosis(i)) > most {
            continue;
        }
        let missing = (FARTHEST * even.failed.max(odd.failed) + RAREST) * a[1];
        let floor = [0.0, ROUNDOFF * a[0].abs()];
        for (k, part) in ["mean", "standard_deviation"].into_iter().enumerate() {
            let id = format!("{}/{}/{part}", plan.gauges[gauge].name, plan.quantities[quantity]);
            let error = (a[k] - b[k]).abs() + missing + floor[k];
            truths.push(Truth { id, time: Some(time), value: 0.5 * (a[k] + b[k]), error });
        }
    }
    Some(truths)
}

/// Sums over the points of a trapezoidal rule, with the weights of a normal density.
struct Sums {
    centre: Vec<f64>,
    weight: f64,
    /// Share of the weight where a run ended in an error.
    failed: f64,
    /// Of the powers of the distance from the centre, from the first to the fourth.
    powers: Vec<[f64; 4]>,
}

impl Sums {
    /// Of `n` normals at equal distances, shifted by a part of it; none where runs fail that count.
    fn new(
        study: &Study<'_, SceneExperiment<1>, 1>,
        n: usize,
        distance: f64,
        shift: f64,
    ) -> Option<Self> {
        let centre = study.centre().to_vec();
        let powers = vec![[0.0; 4]; centre.len()];
        let mut sums = Self { centre, weight: 0.0, failed: 0.0, powers };
        let places: Vec<f64> =
            (-MOST_STEPS..=MOST_STEPS).map(|k| distance * (f64::from(k) + shift)).collect();
        let others = if n > 1 { places.as_slice() } else { &[0.0] };
        for (x, y) in places.iter().flat_map(|x| others.iter().map(move |y| (*x, *y))) {
            let square = x * x + y * y;
            if square > REACH * REACH {
                continue;
            }
            let mut normals = vec![0.0; study.n_normals()];
            normals[..n].copy_from_slice(&[x, y][..n]);
            let weight = (-0.5 * square).exp();
            sums.weight += weight;
            let Ok(values) = study.run(&normals) else {
                sums.failed += weight;
                continue;
            };
            for (i, value) in values.iter().enumerate() {
                let away = value - sums.centre[i];
                let mut term = weight;
                for power in &mut sums.powers[i] {
                    term *= away;
                    *power += term;
                }
            }
        }
        sums.failed /= sums.weight;
        (sums.failed <= MOST_FAILED).then_some(sums)
    }

    /// Mean and standard deviation of a response.
    fn moments(&self, i: usize) -> [f64; 2] {
        let [first, second, ..] = self.powers[i].map(|sum| sum / self.weight);
        [self.centre[i] + first, (second - first * first).max(0.0).sqrt()]
    }

    /// Fourth central moment over the square of the variance; zero of what does not vary.
    fn kurtosis(&self, i: usize) -> f64 {
        let [m, second, third, fourth] = self.powers[i].map(|sum| sum / self.weight);
        let variance = second - m * m;
        let central = fourth - 4.0 * m * third + 6.0 * m * m * second - 3.0 * m.powi(4);
        if variance > 0.0 { central / (variance * variance) } else { 0.0 }
    }
}
