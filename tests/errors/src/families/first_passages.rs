//! First passages of the drifts of linear shear buildings, by importance sampling over their elementary events.

use fpk_scenes::building::scene::{BetweenScene, PassageScene};
use fpk_scenes::building::{DampingScene, HysteresisScene, SoilScene};
use nalgebra::{DMatrix, DVector};
use sde_integrators::{Noise, Purpose, Stream, normal_probability, normal_quantile};
use serde_json::{Value, json};
use vibrating_systems::Window;

use super::linear_systems::built;
use crate::draw::{Draw, rounded};
use crate::verdict::of_scene;
use crate::{Family, Truth};

pub(super) const FAMILY: Family = Family {
    name: "first-passages",
    known_by: "importance sampling over the elementary events of the linear system (Au and Beck 2001), to about 3 %",
    weight: 0.7,
    draw,
    truths: |scene| {
        let scene = serde_json::from_value(scene.clone()).ok();
        scene.filter(|it: &PassageScene| it.solver == "random-vibration").and_then(|it| truths(&it))
    },
    judge: of_scene,
};

/// Steps of the truth per shortest period.
const STEPS_OF_TRUTH: f64 = 60.0;
/// Samples of the truth.
const SAMPLES: u64 = 5_000;

fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let n = draw.whole(1, 2);
    let (frequency, ratio) = (draw.scaled(3.0, 30.0), draw.scaled(0.01, 0.2));
    let (mut mass, mut stiffness, mut damping) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..n {
        let (m, omega) = (draw.scaled(1e3, 1e5), frequency * draw.between(0.8, 1.25));
        mass.push(m);
        stiffness.push(rounded(m * omega * omega));
        damping.push(rounded(2.0 * ratio * m * omega));
    }
    let soil = if draw.chance(0.4) {
        json!({ "kanai_tajimi": { "ground_frequency": draw.between(10.0, 20.0), "ground_damping": draw.between(0.4, 0.8) } })
    } else {
        json!("none")
    };
    let period = std::f64::consts::TAU / frequency;
    let until = rounded(period * draw.between(1.0, 8.0));
    let n_times = draw.whole(1, 2);
    let every = if n_times == 1 { until } else { 0.5 * until };
    let per_period = if hostile { draw.between(6.0, 12.0) } else { draw.between(40.0, 80.0) };
    let (step, seed) = (rounded(period / per_period), draw.whole(1, 1 << 30));
    let name = *draw.one_of(&["guided_paths", "guided_paths", "monte_carlo", "subset_simulation"]);
    let few = |draw: &mut Draw, sensible: [u64; 2]| {
        if hostile { draw.whole(100, 200) } else { draw.whole(sensible[0], sensible[1]) }
    };
    let settings = match name {
        "guided_paths" => {
            json!({ "samples": few(draw, [1_000, 5_000]), "step": step, "seed": seed })
        }
        "monte_carlo" => json!({ "paths": few(draw, [1_000, 10_000]), "step": step, "seed": seed }),
        _ => json!({ "samples": few(draw, [200, 500]), "correlation": draw.between(0.6, 0.9),
                     "runs": draw.whole(4, 10), "step": step, "seed": seed }),
    };
    let storey = if draw.chance(0.5) { json!({ "storey": draw.whole(1, n) }) } else { json!({}) };
    let mut scene = json!({
        "solver": "random-vibration", "title": "first passages of a linear building",
        "building": { "mass": mass, "stiffness": stiffness, "damping": { "storeys": damping }, "hysteresis": "none" },
        "ground": { "soil": soil, "noise_intensity": draw.scaled(1e-3, 1.0) },
        "response": storey, "thresholds": [1.0], "times": { "until": 2.0 * every, "every": every },
        "method": { name: settings },
    });
    scene["times"]["until"] = json!(if n_times == 1 { every } else { 2.0 * every });
    if draw.chance(0.25) {
        scene["response"]["between"] = json!("endpoints");
    }
    let largest = Chain::new(&built(&scene)).map_or(1.0, |chain| chain.largest_deviation());
    let multiples = if hostile {
        [draw.between(0.5, 2.0), draw.between(3.0, 6.0)]
    } else {
        [draw.between(1.5, 2.8), draw.between(3.0, 5.0)]
    };
    scene["thresholds"] = json!(multiples.map(|it| rounded(it * largest)));
    (scene, name)
}

/// The passages that a scene asks for; none of a scene whose equations this family does not write.
fn truths(scene: &PassageScene) -> Option<Vec<Truth>> {
    let chain = Chain::new(scene)?;
    let mut truths = Vec::new();
    for (k, &time) in scene.times.list().iter().enumerate() {
        for &threshold in &scene.thresholds {
            let [value, error] = chain.first_passage(threshold, (k + 1) * chain.each);
            truths.push(Truth {
                id: format!("first-passage/{threshold}"),
                time: Some(time),
                value,
                error,
            });
        }
    }
    Some(truths)
}

/// A linear system at equal times: `x_(k+1) = F x_k + w_k` from rest, with `cov w_k = Q`.
struct Chain {
    transition: DMatrix<f64>,
    /// A root of `Q`: `w = R z`.
    root: DMatrix<f64>,
    /// Covariance of the state after each step, from none on.
    covariances: Vec<DMatrix<f64>>,
    /// States whose magnitude counts.
    drifts: Vec<usize>,
    /// Steps from one time of the scene to the next.
    each: usize,
    /// Relative error of a largest drift that is seen at these times alone.
    unseen: f64,
}

impl Chain {
    fn new(scene: &PassageScene) -> Option<Self> {
        let (rates, load) = equations(scene)?;
        let d = rates.nrows();
        let largest =
            rates.clone().complex_eigenvalues().iter().map(|it| it.norm()).fold(0.0, f64::max);
        let every = scene.times.every;
        // Counted at the ends of its own steps, under noise that is constant over each, a scene asks for that very chain.
        let is_at_ends = scene.response.between == BetweenScene::Endpoints;
        let wanted = STEPS_OF_TRUTH * largest * every / std::f64::consts::TAU;
        let steps =
            if is_at_ends { (every / scene.method.step() - 1e-9).ceil() } else { wanted.ceil() };
        let h = every / steps;
        let transition = (&rates * h).exp();
        let root = if is_at_ends {
            // The integral of exp(A s) b over a step, by the exponential of [[A, b], [0, 0]].
            let mut block = DMatrix::zeros(d + 1, d + 1);
            block.view_mut((0, 0), (d, d)).copy_from(&(&rates * h));
            block.view_mut((0, d), (d, 1)).copy_from(&(&load * h));
            block.exp().view((0, d), (d, 1)) / h.sqrt()
        } else {
            // Van Loan 1978: the exponential of [[-A, b b'], [0, A']].
            let mut block = DMatrix::zeros(2 * d, 2 * d);
            block.view_mut((0, 0), (d, d)).copy_from(&(&rates * -h));
            block.view_mut((0, d), (d, d)).copy_from(&(&load * load.transpose() * h));
            block.view_mut((d, d), (d, d)).copy_from(&(rates.transpose() * h));
            let noise = &transition * block.exp().view((0, d), (d, d));
            let eigen = (0.5 * (&noise + noise.transpose())).symmetric_eigen();
            let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
            &eigen.eigenvectors * DMatrix::from_diagonal(&roots)
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few thousand steps, rounded up"
        )]
        let each = steps as usize;
        let n = scene.times.list().len() * each;
        let mut covariances = vec![DMatrix::zeros(d, d)];
        let noise = &root * root.transpose();
        for k in 0..n {
            covariances.push(&transition * &covariances[k] * transition.transpose() + &noise);
        }
        let n_storeys = scene.building.mass.len();
        let drifts = scene.response.storey.map_or(0..n_storeys, |it| it - 1..it).collect();
        // A largest drift between two times is higher than at the nearer one by `(omega h)^2/24` of it on average.
        let unseen = if is_at_ends { 0.0 } else { (largest * h).powi(2) / 24.0 };
        Some(Self { transition, root, covariances, drifts, each, unseen })
    }

    fn deviation(&self, k: usize, drift: usize) -> f64 {
        self.covariances[k][(drift, drift)].sqrt()
    }

    fn largest_deviation(&self) -> f64 {
        let last = self.covariances.len() - 1;
        self.drifts.iter().map(|&drift| self.deviation(last, drift)).fold(0.0, f64::max)
    }

    /// `P(max |u| > T)` up to a step, and its error: `sum_e P(e)` times the mean of one over the number of events `e` that happen, each
    /// a drift beyond the threshold at a step, on paths that are conditioned to one of them.
    fn first_passage(&self, threshold: f64, last: usize) -> [f64; 2] {
        let mut events = Vec::new();
        let mut total = 0.0;
        for k in 1..=last {
            for &drift in &self.drifts {
                total += 2.0 * normal_probability(-threshold / self.deviation(k, drift));
                events.push((k, drift, total));
            }
        }
        let noise = Noise::new(threshold.to_bits() ^ last as u64);
        let (mut sum, mut squares) = (0.0, 0.0);
        for realisation in 0..SAMPLES {
            let mut stream = noise.stream(Purpose::Path, realisation);
            let at = total * stream.next_uniform();
            let (k, drift, _) =
                events[events.partition_point(|event| event.2 <= at).min(events.len() - 1)];
            let n = self.events_of_path(&mut stream, (k, drift), threshold, last);
            sum += 1.0 / n;
            squares += 1.0 / (n * n);
        }
        let n = SAMPLES as f64;
        let mean = sum / n;
        let deviation = ((squares / n - mean * mean).max(0.0) / n).sqrt();
        let value = (total * mean).min(1.0);
        let square = threshold / self.largest_deviation();
        let of_unseen = value * self.unseen * square * square;
        [value, 2.0 * total * deviation + of_unseen.min(value * (1.0 - value))]
    }

    /// Number of events on a path of which one is given.
    fn events_of_path(
        &self,
        stream: &mut Stream,
        (at, drift): (usize, usize),
        threshold: f64,
        last: usize,
    ) -> f64 {
        let (d, rank) = (self.root.nrows(), self.root.ncols());
        let mut normals = vec![0.0; last * rank];
        stream.fill_normal(&mut normals);
        let mut path = vec![DVector::zeros(d)];
        for k in 0..last {
            let z = DVector::from_column_slice(&normals[k * rank..(k + 1) * rank]);
            path.push(&self.transition * &path[k] + &self.root * z);
        }
        // The drift of the event has the part of a normal distribution beyond the threshold.
        let deviation = self.deviation(at, drift);
        let beyond = normal_probability(-threshold / deviation);
        let z = -normal_quantile(beyond * (1.0 - stream.next_uniform()));
        let drift_of_event =
            if stream.next_uniform() < 0.5 { z * deviation } else { -z * deviation };
        let shift = (drift_of_event - path[at][drift]) / (deviation * deviation);
        // Matheron's rule: what is known of one number is carried to all others by their covariances with it.
        let mut unit = DVector::zeros(d);
        unit[drift] = 1.0;
        let mut after = &self.covariances[at] * &unit;
        for state in &mut path[at..] {
            state.axpy(shift, &after, 1.0);
            after = &self.transition * after;
        }
        let mut before = self.transition.tr_mul(&unit);
        for k in (1..at).rev() {
            path[k].axpy(shift, &(&self.covariances[k] * &before), 1.0);
            before = self.transition.tr_mul(&before);
        }
        let seen = |state: &DVector<f64>| {
            self.drifts.iter().filter(|&&i| state[i].abs() > threshold).count()
        };
        // The event itself is at the threshold at least, but for roundoff.
        path.iter().map(seen).sum::<usize>().max(1) as f64
    }
}

/// `x' = A x + b W` of a linear building with unit white noise `W`: drifts, their rates, and the states of the soil. None of a building
/// that yields or has Rayleigh's damping, of noise that varies in time, and of another filter.
fn equations(scene: &PassageScene) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let building = &scene.building;
    let n = building.mass.len();
    let (DampingScene::Storeys(damping), HysteresisScene::None, Window::Stationary) =
        (&building.damping, &building.hysteresis, &scene.ground.window)
    else {
        return None;
    };
    let soil = match scene.ground.soil {
        SoilScene::KanaiTajimi { ground_frequency, ground_damping } => {
            Some((ground_frequency, ground_damping))
        }
        SoilScene::None => None,
        SoilScene::CloughPenzien { .. } => return None,
    };
    let d = 2 * n + if soil.is_some() { 2 } else { 0 };
    let (mut a, mut b) = (DMatrix::zeros(d, d), DVector::zeros(d));
    for i in 0..n {
        a[(i, n + i)] = 1.0;
        // A storey pulls its own floor back and the one below after it; the drift is the difference of both.
        let mut pull = |row: usize, storey: usize, per_mass: f64| {
            a[(n + row, storey)] -= per_mass * building.stiffness[storey];
            a[(n + row, n + storey)] -= per_mass * damping[storey];
        };
        pull(i, i, 1.0 / building.mass[i]);
        if i + 1 < n {
            pull(i, i + 1, -1.0 / building.mass[i]);
            pull(i + 1, i + 1, 1.0 / building.mass[i]);
            pull(i + 1, i, -1.0 / building.mass[i]);
        }
    }
    let intensity = (2.0 * scene.ground.noise_intensity).sqrt();
    match soil {
        // The ground is at rest but for white noise.
        None => b[n] = intensity,
        Some((frequency, ratio)) => {
            let (square, rate) = (frequency * frequency, 2.0 * ratio * frequency);
            a[(2 * n, 2 * n + 1)] = 1.0;
            a[(2 * n + 1, 2 * n)] = -square;
            a[(2 * n + 1, 2 * n + 1)] = -rate;
            a[(n, 2 * n)] = square;
            a[(n, 2 * n + 1)] = rate;
            b[2 * n + 1] = intensity;
        }
    }
    Some((a, b))
}
