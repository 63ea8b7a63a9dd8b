//! Linear systems of one to six states: normal at all times, by their moment equations.

use fpk_scenes::law_scene::LawScene;
use fpk_scenes::paths::Paths;
use fpk_scenes::scene::FpkScene;
use fpk_scenes::system::{System, Visitor};
use fpk_scenes::system_scene::SystemScene;
use serde_json::{Value, json};

use super::density_methods::{Class, Solvable, method, of_density};
use crate::draw::{Draw, rounded};
use crate::normal::{Linear, Normal, laws};
use crate::verdict::of_scene;
use crate::{Family, Truth};

pub(super) const FAMILY: Family = Family {
    name: "linear-systems",
    known_by: "moment equations, solved to 1e-9",
    weight: 4.0,
    draw,
    truths: |scene| of_density(scene, truths),
    judge: of_scene,
};

/// Steps of the moment equations per shortest period, and their relative error.
const STEPS_OF_TRUTH: f64 = 400.0;
const ERROR_OF_TRUTH: f64 = 1e-8;

/// Methods that start at a point too.
const FROM_REST: [&str; 2] = ["monte_carlo", "subset_simulation"];

fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let keys = system(draw, hostile);
    let system = valid(built::<SystemScene>(&keys).build());
    let n = system.states().len();
    let period = system.reference_period();
    let period = if period.is_finite() { period } else { draw.scaled(0.3, 3.0) };
    let (times, every) = times(draw, period, hostile);
    let until = times.last().copied().unwrap_or(every);
    let mut initial = initial(draw, &system, period);
    let of = Solvable {
        n_states: n,
        period,
        class: if system.oscillator().is_some() { Class::Oscillator } else { Class::Additive },
        has_filter: system.filter_covariance().is_some(),
        is_linear: true,
        has_thresholds: true,
    };
    let (name, method) = method(draw, &of, hostile);
    if FROM_REST.contains(&name) && draw.chance(0.15) {
        for law in initial.as_object_mut().into_iter().flat_map(|laws| laws.values_mut()) {
            for deviation in law["standard_deviation"].as_array_mut().into_iter().flatten() {
                *deviation = json!(0);
            }
        }
    }
    let is_conditioned = method["flow_map_fit"]["filter"] == json!("conditioned");
    let mut moments = vec![vec![0; n]; 3];
    (moments[0][0], moments[1][0], moments[2][0]) = (2, 4, 1);
    moments[2][n - 1] = 1;
    if is_conditioned {
        moments.pop();
    }
    let first = |k: usize| f64::from(u8::from(k == 0));
    let mut weights: Vec<f64> = (0..n).map(first).collect();
    let mut scene = json!({
        "solver": "fpk-sph", "title": "a linear system", "system": keys, "initial": initial, "method": method,
        "times": { "until": until, "every": every }, "moments": moments, "thresholds": [],
    });
    if n > 1 && !is_conditioned && of.class != Class::Oscillator && draw.chance(0.3) {
        weights = (0..n).map(|_| draw.between(-1.0, 1.0)).collect();
        scene["demand"] = json!({ "combination": { "name": "y", "weights": weights } });
    }
    let law = laws_of(&built(&initial), &system, &[until]).remove(0);
    let (mean, deviation) = law.of_sum(&weights);
    let multiples = [draw.between(0.3, 1.2), draw.between(1.5, 2.5), draw.between(3.0, 4.5)];
    scene["thresholds"] = json!(multiples.map(|it| rounded(mean.abs() + it * deviation)));
    (scene, name)
}

/// The moments and probabilities that a scene of a linear system asks for; none of another system.
fn truths(scene: &FpkScene, system: &System) -> Option<Vec<Truth>> {
    if !system.is_linear() {
        return None;
    }
    let (times, demand) = (scene.times.list(), scene.demand(system.states()).ok()?);
    // Steps end at kinks of a window, across which they would lose their order.
    let mut stops = [scene.system.kinks(), times.clone()].concat();
    stops.retain(|t| *t > 0.0 && times.last().is_some_and(|last| t <= last));
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    let mut truths = Vec::new();
    let laws = laws_of(&scene.initial, system, &stops);
    for (t, law) in stops.into_iter().zip(laws).filter(|(t, _)| times.contains(t)) {
        let mut known = |id: String, value: f64| {
            truths.push(Truth { id, time: Some(t), value, error: ERROR_OF_TRUTH * value.abs() });
        };
        for powers in &scene.moments {
            known(moment_id(powers), law.raw_moment(powers));
        }
        for &threshold in &scene.thresholds {
            known(format!("exceedance/{threshold}"), law.exceedance(&demand.weights, threshold));
        }
    }
    Some(truths)
}

fn laws_of(initial: &LawScene, system: &System, times: &[f64]) -> Vec<Normal> {
    let period = system.reference_period().min(times.last().copied().unwrap_or(1.0));
    let (filter, step) = (system.filter_covariance(), period / STEPS_OF_TRUTH);
    system.visit(TruthOf { initial, filter, times, step })
}

/// Id of a moment.
pub(super) fn moment_id(powers: &[u32]) -> String {
    let words: Vec<String> = powers.iter().map(ToString::to_string).collect();
    format!("moment/{}", words.join("-"))
}

/// Keys that were drawn.
pub(super) fn built<T: serde::de::DeserializeOwned>(keys: &Value) -> T {
    valid(serde_json::from_value(keys.clone()))
}

/// What was drawn is valid.
#[expect(clippy::panic, reason = "a family that draws what is no scene is wrong itself")]
fn valid<T, E: std::fmt::Display>(drawn: Result<T, E>) -> T {
    drawn.unwrap_or_else(|error| panic!("{error}"))
}

/// Times of observation at equal intervals.
pub(super) fn times(draw: &mut Draw, period: f64, hostile: bool) -> (Vec<f64>, f64) {
    let every = if hostile && draw.chance(0.5) {
        // Shorter than a step, or several periods.
        if draw.chance(0.5) { draw.between(0.005, 0.05) } else { draw.between(1.0, 3.0) }
    } else {
        draw.between(0.1, 1.0)
    };
    let every = rounded(every * period);
    let n = draw.whole(1, 6);
    let n = if every < 0.06 * period { 20 * n } else { n };
    ((1..=n).map(|k| k as f64 * every).collect(), every)
}

fn oscillator(draw: &mut Draw) -> Value {
    let window = match draw.whole(0, 3) {
        0 => {
            json!({ "rise_plateau_decay": { "rise_exponent": 1, "rise_end": 2, "decay_rate": 1, "decay_start": 5 } })
        }
        1 => json!({ "single_peak": { "peak": 1, "peak_time": draw.between(0.5, 3.0) } }),
        _ => json!("stationary"),
    };
    json!({
        "natural_frequency": draw.scaled(0.5, 20.0), "damping_ratio": draw.scaled(0.005, 0.5),
        "noise_intensity": draw.scaled(1e-3, 1.0), "window": window,
    })
}

fn system(draw: &mut Draw, hostile: bool) -> Value {
    match draw.whole(0, 5) {
        0 | 1 => json!({ "linear_oscillator": oscillator(draw) }),
        2 => json!({ "kanai_tajimi": {
            "structure": { "linear_oscillator": oscillator(draw) },
            "ground_frequency": draw.between(6.0, 20.0), "ground_damping": draw.between(0.3, 0.8) } }),
        3 => json!({ "clough_penzien": {
            "structure": { "linear_oscillator": oscillator(draw) },
            "ground_frequency": draw.between(6.0, 20.0), "ground_damping": draw.between(0.3, 0.8),
            "low_cut_frequency": draw.between(0.8, 2.0), "low_cut_damping": draw.between(0.4, 0.8) } }),
        _ => {
            let n = usize::try_from(draw.whole(1, 4)).unwrap_or(1);
            let mut rates = vec![vec![0.0; n]; n];
            for (i, row) in rates.iter_mut().enumerate() {
                for (j, rate) in row.iter_mut().enumerate() {
                    *rate = if i == j { draw.between(0.5, 2.0) } else { draw.between(-0.6, 0.6) };
                }
            }
            // Pure Brownian motion.
            if n == 1 && hostile && draw.chance(0.3) {
                rates[0][0] = 0.0;
            }
            let noise: Vec<Vec<f64>> =
                (0..n)
                    .map(|i| {
                        (0..n)
                            .map(|j| {
                                if i == j {
                                    draw.between(0.2, 1.0)
                                } else {
                                    draw.between(-0.3, 0.3)
                                }
                            })
                            .collect()
                    })
                    .collect();
            let mean: Vec<f64> = (0..n).map(|_| draw.between(-0.5, 0.5)).collect();
            json!({ "ornstein_uhlenbeck": { "rates": rates, "mean": mean, "noise": noise } })
        }
    }
}

/// An initial distribution of the order of what the noise makes in a period.
fn initial(draw: &mut Draw, system: &System, period: f64) -> Value {
    let n = system.structure_states().map_or(system.states().len(), <[_]>::len);
    let grown = system.visit(NoiseOf { time: period });
    let scale = grown[n - 1].max(1e-6);
    let deviation: Vec<f64> = (0..n)
        .map(|k| {
            // A displacement is a velocity by a time.
            let unit = if system.states()[k].starts_with('q') { period / 6.0 } else { 1.0 };
            rounded(scale * unit * draw.scaled(0.1, 1.0))
        })
        .collect();
    let mean: Vec<f64> = deviation
        .iter()
        .map(|s| if draw.chance(0.7) { 0.0 } else { rounded(s * draw.between(-2.0, 2.0)) })
        .collect();
    let law = json!({ "mean": mean, "standard_deviation": deviation });
    if system.filter_covariance().is_some() {
        json!({ "stationary_filter": law })
    } else {
        json!({ "gaussian": law })
    }
}

/// Deviation of the states that white noise makes within a time, without drift.
struct NoiseOf {
    time: f64,
}

impl Visitor for NoiseOf {
    type Output = Vec<f64>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Vec<f64> {
        let t = 0.5 * self.time;
        let diffusion = system.diffusion(t, &[0.0; D]);
        let largest = (0..D).map(|k| diffusion[k][k]).fold(0.0, f64::max);
        let of = |d: f64| (2.0 * if d > 0.0 { d } else { largest } * self.time).sqrt();
        (0..D).map(|k| of(diffusion[k][k])).collect()
    }
}

/// The distributions of a linear system.
struct TruthOf<'a> {
    initial: &'a LawScene,
    filter: Option<Vec<Vec<f64>>>,
    times: &'a [f64],
    step: f64,
}

struct Of<'a, S, const D: usize, const M: usize>(&'a S);

impl<S: Paths<D, M>, const D: usize, const M: usize> Linear for Of<'_, S, D, M> {
    fn drift(&self, t: f64, x: &[f64]) -> Vec<f64> {
        self.0.drift(t, &std::array::from_fn(|k| x[k])).to_vec()
    }

    fn noise(&self, t: f64) -> Vec<Vec<f64>> {
        let diffusion = self.0.diffusion(t, &[0.0; D]);
        diffusion.iter().map(|row| row.iter().map(|entry| 2.0 * entry).collect()).collect()
    }
}

impl Visitor for TruthOf<'_> {
    type Output = Vec<Normal>;

    fn visit<S: Paths<D, M>, const D: usize, const M: usize>(self, system: &S) -> Vec<Normal> {
        let law = valid(self.initial.build::<D>(self.filter.as_deref()));
        let covariance = law.covariance().iter().map(|row| row.to_vec()).collect();
        let start = Normal { mean: law.mean().to_vec(), covariance };
        laws(&Of(system), &start, self.times, self.step)
    }
}
