//! Plates whose load is linear in noise or in a random stiffness: normal loads, by the modes of the network of bonds.

use nalgebra::{DMatrix, DVector, SMatrix, SVector, SymmetricEigen};
use scenes::SceneFile;
use scenes::peridyn::scene::CrackScene;
use scenes::peridyn::scene_dynamics::{DynamicsScene, MobilityScene};
use scenes::peridyn::scene_load::LoadingScene;
use scenes::peridyn::scene_problem::CrackProblem;
use serde_json::{Value, json};

use crate::draw::{Draw, rounded};
use crate::verdict::of_scene;
use crate::{Family, Truth};

pub(super) const FAMILY: Family = Family {
    name: "peridyn-linear",
    known_by: "modes of the network of bonds, each by its moment equations; closed covariance of a random stiffness",
    weight: 1.0,
    draw,
    truths,
    judge: of_scene,
};

/// Distance of nodes (m).
const DX: f64 = 1e-3;
const YOUNG_MODULUS: f64 = 72e9;
const DENSITY: f64 = 2440.0;
/// Relative error of what is solved here, by linear strains and by finite ones at a stretch of 1e-3.
const ERROR_OF_LINEAR: f64 = 1e-6;
const ERROR_OF_FINITE: f64 = 2e-3;

fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let realisations = realisations(draw, hostile);
    if draw.chance(0.2) {
        return (random_stiffness(draw, realisations), "quasi-static");
    }
    let (columns, rows) = (draw.whole(5, 6) as f64, 2.0 * draw.whole(3, 4) as f64);
    let ratio = if hostile { draw.scaled(0.5, 300.0) } else { draw.scaled(5.0, 50.0) };
    let z = if hostile { draw.between(1.0, 1.95) } else { draw.between(0.1, 0.8) };
    let (mut name, temperature) = ("inertial", json!({ "ratio": ratio }));
    let mut step = json!({ "z": z });
    let dynamics = if draw.chance(0.4) {
        json!({ "inertial": { "friction": draw.scaled(1e5, 1e6), "temperature": temperature } })
    } else {
        let scheme = match draw.whole(0, 3) {
            0 => json!("euler_maruyama"),
            1 => json!("leimkuhler_matthews"),
            2 => json!("heun"),
            _ => {
                step = json!({ "z": rounded(if hostile { 10.0 * z } else { z }) });
                json!({ "theta": 0.5 })
            }
        };
        name = "overdamped";
        json!({ "overdamped": {
            "mobility": { "identity": { "value": draw.scaled(0.1, 10.0) } },
            "temperature": temperature, "scheme": scheme } })
    };
    let windows = if draw.chance(0.5) { 1 } else { draw.whole(2, 10) };
    let steps = windows * if hostile { draw.whole(3, 60) } else { draw.whole(40, 300) };
    let mut scene = plate([columns, rows], realisations, draw.whole(1, 9999));
    scene["bonds"] = json!({
        "horizon": { "shells": draw.whole(2, 3) }, "volume_correction": draw.one_of(&["none", "ramp"]),
        "strain": if draw.chance(0.7) { "linear" } else { "finite" } });
    scene["notch"] = notch(rows, 1.3);
    // Within it no bond breaks, and it holds all nodes.
    scene["grips"] =
        json!({ "height": 1.1 * DX, "hold": "clamped", "protected": 0.499 * rows * DX });
    let strain = if hostile { draw.scaled(1e-6, 1e-3) } else { draw.scaled(1e-4, 1e-3) };
    scene["loading"] = json!({ "stretch": { "strain": { "value": strain } } });
    scene["dynamics"] = dynamics;
    scene["time"] = json!({ "step": step, "steps": steps });
    scene["ensemble"]["precision"] = json!(draw.one_of(&["f64", "f32"]));
    scene["output"] = json!({ "windows": windows });
    (scene, name)
}

/// Few or many.
pub(super) fn realisations(draw: &mut Draw, hostile: bool) -> u64 {
    match (hostile, draw.chance(0.5)) {
        (false, _) => draw.whole(16, 64),
        (true, true) => draw.whole(2, 9),
        (true, false) => draw.whole(200, 400),
    }
}

/// What all plates share.
pub(super) fn plate([columns, rows]: [f64; 2], realisations: u64, seed: u64) -> Value {
    json!({
        "solver": "peridyn-sde", "title": "a small plate",
        "body": { "size": [columns * DX, rows * DX], "spacing": DX, "condition": { "plane_stress": { "thickness": DX } } },
        "material": { "young_modulus": YOUNG_MODULUS, "density": DENSITY, "toughness": { "critical_stretch": 1e-3 } },
        "strength": "uniform", "ensemble": { "realisations": realisations, "seed": seed, "precision": "f64" },
    })
}

/// A notch from the left edge, so many spacings long.
pub(super) fn notch(rows: f64, length: f64) -> Value {
    json!({ "mouth": [0.0, 0.5 * rows * DX], "tip": [length * DX, 0.5 * rows * DX] })
}

/// Two rigid halves between which each bond is a spring with the mean of two random factors.
fn random_stiffness(draw: &mut Draw, realisations: u64) -> Value {
    let columns = draw.whole(4, 8) as f64;
    let mut scene = plate([columns, 6.0], realisations, draw.whole(1, 9999));
    let rows = |from: f64, to: f64, width: f64| json!({ "low": [0.0, from * DX], "high": [width * DX, to * DX] });
    scene["bonds"] = json!({ "horizon": { "shells": 2 } });
    scene["notch"] = notch(6.0, 0.6);
    // A node in a corner is free along x, where nothing pulls.
    scene["supports"] = json!([
        { "region": rows(0.0, 3.0, columns), "hold": "y" },
        { "region": rows(0.0, 1.0, columns - 1.0), "hold": "x" },
        { "region": rows(1.0, 6.0, columns), "hold": "x" } ]);
    let until = 1e-4 * DX;
    scene["loading"] =
        json!({ "displacement": { "region": rows(3.0, 6.0, columns), "until": [0.0, until] } });
    scene["dynamics"] = json!({ "quasi_static": {} });
    scene["stiffness"] = json!({ "field": {
        "marginal": { "lognormal": { "coefficient_of_variation": draw.between(0.05, 0.4) } },
        "correlation": { "function": "exponential", "length": draw.scaled(0.3 * DX, 10.0 * DX) } } });
    scene
}

fn truths(value: &Value) -> Option<Vec<Truth>> {
    let file = SceneFile::from_text("scene.json", value.to_string()).ok()?;
    let scene = file.parse::<CrackScene>().ok()?;
    let problem = CrackProblem::new(&scene, None).ok()?;
    let (mean, deviation, error) = match scene.loading {
        LoadingScene::Displacement { .. } => load_of_springs(value, &problem, &scene)?,
        LoadingScene::Stretch { .. } => load_of_modes(&problem, &scene)?,
        LoadingScene::Velocity { .. } => return None,
    };
    let known = |part: &str, value: f64| Truth {
        id: format!("failure_load/{part}"),
        time: None,
        value,
        error: error * (mean.abs() + deviation),
    };
    Some(vec![known("mean", mean), known("standard_deviation", deviation)])
}

/// The springs from the lower to the upper half.
fn load_of_springs(
    value: &Value,
    problem: &CrackProblem,
    scene: &CrackScene,
) -> Option<(f64, f64, f64)> {
    let field = &value["stiffness"]["field"];
    let variation = field["marginal"]["lognormal"]["coefficient_of_variation"].as_f64()?;
    let length = field["correlation"]["length"].as_f64()?;
    let until = value["loading"]["displacement"]["until"][1].as_f64()?;
    let study = problem.study(scene);
    let cut = study.bonds.across_segment(study.nodes, (study.notch.mouth, study.notch.tip)).ok()?;
    let (x, middle) = (study.nodes.positions(), 0.5 * scene.body.size[1]);
    let mut factors = vec![0.0; x.len()];
    for (bond, (i, j)) in study.bonds.pairs().enumerate() {
        if (x[i][1] < middle) != (x[j][1] < middle) && !cut.contains(&bond) {
            let of = study.bonds.all()[bond];
            let along = (x[j][1] - x[i][1]) / of.length;
            let load = of.stiffness / of.length * along * along * until;
            factors[i] += 0.5 * load;
            factors[j] += 0.5 * load;
        }
    }
    let square = (1.0 + variation * variation).ln();
    let mut variance = 0.0;
    for i in 0..x.len() {
        for j in 0..x.len() {
            let r = (x[i][0] - x[j][0]).hypot(x[i][1] - x[j][1]);
            variance += factors[i] * factors[j] * (square * (-r / length).exp()).exp_m1();
        }
    }
    Some((factors.iter().sum(), variance.sqrt(), ERROR_OF_LINEAR))
}

/// The mean load of the last window, where that is the largest of all.
fn load_of_modes(problem: &CrackProblem, scene: &CrackScene) -> Option<(f64, f64, f64)> {
    let grips = scene.grips.as_ref().filter(|it| it.protected > 0.49 * scene.body.size[1])?;
    let (study, resolved) = (problem.study(scene), &problem.resolved);
    let cut = study.bonds.across_segment(study.nodes, (study.notch.mouth, study.notch.tip)).ok()?;
    let (x, n) = (study.nodes.positions(), 2 * study.nodes.positions().len());
    let mut stiffness = DMatrix::<f64>::zeros(n, n);
    for (bond, (i, j)) in study.bonds.pairs().enumerate().filter(|(bond, _)| !cut.contains(bond)) {
        let of = study.bonds.all()[bond];
        let along = [0, 1].map(|k| (x[j][k] - x[i][k]) / of.length);
        for a in 0..2 {
            for b in 0..2 {
                let entry = of.stiffness / of.length * along[a] * along[b];
                stiffness[(2 * i + a, 2 * i + b)] += entry;
                stiffness[(2 * j + a, 2 * j + b)] += entry;
                stiffness[(2 * i + a, 2 * j + b)] -= entry;
                stiffness[(2 * j + a, 2 * i + b)] -= entry;
            }
        }
    }
    let duration = resolved.duration?;
    let rate = resolved.final_strain? / duration;
    let prescribed = study.loading.prescribed().as_flattened();
    let free: Vec<usize> = (0..n).filter(|&k| !prescribed[k]).collect();
    let field = |k: usize| if k % 2 == 1 { rate * x[k / 2][1] } else { 0.0 };
    let held = DVector::from_fn(n, |k, _| if prescribed[k] { field(k) } else { 0.0 });
    let (pulled, moved) = (&stiffness * &held, DVector::from_fn(free.len(), |k, _| field(free[k])));
    let is_upper = |k: usize| k % 2 == 1 && x[k / 2][1] > scene.body.size[1] - grips.height;
    let on_upper = DVector::from_fn(n, |k, _| f64::from(u8::from(is_upper(k))));
    let reaction = &stiffness * &on_upper;
    let of_free = |of: &DVector<f64>| DVector::from_fn(free.len(), |k, _| of[free[k]]);
    let network = DMatrix::from_fn(free.len(), free.len(), |i, j| stiffness[(free[i], free[j])]);
    let modes = SymmetricEigen::try_new(network, 1e-15, 100_000)?;
    let window = duration / scene.output.windows as f64;
    let load = |from: f64| {
        let (mut mean, mut variance) = (reaction.dot(&held) * (from + 0.5 * window), 0.0);
        for (column, &stiffness) in modes.eigenvectors.column_iter().zip(modes.eigenvalues.iter()) {
            let [pull, along, seen] =
                [&of_free(&pulled), &moved, &of_free(&reaction)].map(|it| column.dot(it));
            let mode = Mode { stiffness, pull, along, temperature: resolved.temperature };
            let [of_mean, of_variance] = mode.window(scene, [from, window])?;
            mean += seen * of_mean;
            variance += seen * seen * of_variance;
        }
        Some((mean, variance.sqrt()))
    };
    let (mean, deviation) = load(duration - window)?;
    let is_last = scene.output.windows == 1 || {
        let (before, other) = load(duration - 2.0 * window)?;
        mean - before > 6.0 * (deviation + other)
    };
    let finite = scene.bonds.strain != scenes::peridyn::scene_body::StrainKindScene::Linear;
    is_last.then_some((mean, deviation, if finite { ERROR_OF_FINITE } else { ERROR_OF_LINEAR }))
}

/// A mode of the network: its stiffness, the rate of the load by the prescribed displacement, and how fast the mean strain moves it.
struct Mode {
    stiffness: f64,
    pull: f64,
    along: f64,
    temperature: f64,
}

/// Integral, displacement, velocity, time, one.
type Matrix = SMatrix<f64, 5, 5>;

impl Mode {
    /// Mean and variance of the mean displacement over a window, with its start and length.
    fn window(&self, scene: &CrackScene, [from, length]: [f64; 2]) -> Option<[f64; 2]> {
        // Times in units of the window.
        let (mut flow, mut noise) = (Matrix::zeros(), Matrix::zeros());
        (flow[(0, 1)], flow[(3, 4)], flow[(1, 4)]) = (1.0, 1.0, self.along * length);
        match &scene.dynamics {
            DynamicsScene::Overdamped { mobility: MobilityScene::Identity { value }, .. } => {
                flow[(1, 1)] = -value * self.stiffness * length;
                flow[(1, 3)] = -value * self.pull * length * length;
                noise[(1, 1)] = 2.0 * self.temperature * value * length;
            }
            DynamicsScene::Inertial { friction, .. } => {
                let over_mass = length * length / (DENSITY * DX * DX * DX);
                (flow[(1, 2)], flow[(2, 2)]) = (1.0, -friction * length);
                flow[(2, 1)] = -self.stiffness * over_mass;
                flow[(2, 3)] = -self.pull * over_mass * length;
                noise[(2, 2)] = 2.0 * friction * self.temperature * over_mass * length;
            }
            _ => return None,
        }
        let mut state = SVector::<f64, 5>::zeros();
        state[4] = 1.0;
        let mut covariance = Matrix::zeros();
        for time in [from / length, 1.0] {
            state[0] = 0.0;
            covariance.row_mut(0).fill(0.0);
            covariance.column_mut(0).fill(0.0);
            let (map, made) = over(&flow, &noise, time);
            state = map * state;
            covariance = map * covariance * map.transpose() + made;
        }
        Some([state[0], covariance[(0, 0)]])
    }
}

/// What becomes of a state over a time, and the covariance that noise makes.
fn over(flow: &Matrix, noise: &Matrix, time: f64) -> (Matrix, Matrix) {
    let (mut step, mut doublings) = (time, 0);
    while step * flow.norm() > 0.05 {
        step *= 0.5;
        doublings += 1;
    }
    let exp = |h: f64| {
        let (mut sum, mut term) = (Matrix::identity(), Matrix::identity());
        for k in 1..=10 {
            term = term * flow * (h / f64::from(k));
            sum += term;
        }
        sum
    };
    let mut made = Matrix::zeros();
    for (place, weight) in [(-0.6_f64.sqrt(), 5.0), (0.0, 8.0), (0.6_f64.sqrt(), 5.0)] {
        let map = exp(0.5 * (1.0 + place) * step);
        made += map * noise * map.transpose() * (weight / 18.0 * step);
    }
    let mut map = exp(step);
    for _ in 0..doublings {
        made += map * made * map.transpose();
        map *= map;
    }
    (map, made)
}
