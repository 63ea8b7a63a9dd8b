//! Blocks thrown up against gravity: the velocity, or the length of the block, from which its middle is above a height.

use serde_json::{Value, json};

use crate::draw::{Draw, rounded};
use crate::verdict::of_scene;
use crate::{Family, Truth};

pub(super) const FAMILY: Family = Family {
    name: "smpm-sweeps",
    known_by: "parabolas of flight, linear in what is swept and in what is random, but for half a step of gravity",
    weight: 0.5,
    draw,
    truths,
    judge: |scene, truths, longest| {
        let mut verdicts = of_scene(scene, truths, longest)?;
        // That a number is by a model of the probability is no warning.
        for verdict in &mut verdicts {
            verdict.is_warned = false;
        }
        Ok(verdicts)
    },
};

/// The height of the middle at the last time is `L / 2 + v T - g T^2 / 2`.
struct Flight {
    length: f64,
    velocity: f64,
    gravity: f64,
    time: f64,
}

/// Numbers by their paths.
const LENGTH: &str = "bodies[0].shape.box.to[0]";
const VELOCITY: &str = "bodies[0].velocity[0]";
const GRAVITY: &str = "gravity[0]";

/// Steps of these scenes (s): the time in which a sound wave at 129 m/s, with and without a velocity of 30 m/s, passes half a cell.
const STEP: [f64; 2] = [3.1e-4, 3.9e-4];

impl Flight {
    fn height(&self) -> f64 {
        0.5 * self.length + self.velocity * self.time - 0.5 * self.gravity * self.time.powi(2)
    }

    /// The number at a path, and the height that one unit of it adds.
    fn number(&self, path: &str) -> Option<(f64, f64)> {
        match path {
            LENGTH => Some((self.length, 0.5)),
            VELOCITY => Some((self.velocity, self.time)),
            GRAVITY => Some((-self.gravity, 0.5 * self.time.powi(2))),
            _ => None,
        }
    }
}

fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let flight = Flight {
        length: draw.between(0.3, 0.9),
        velocity: draw.between(5.0, 15.0),
        gravity: draw.between(5.0, 15.0),
        time: draw.between(0.5, 1.0),
    };
    let swept = if draw.chance(0.7) { VELOCITY } else { LENGTH };
    let (limit, slope) = flight.number(swept).unwrap_or_default();
    let half_range = rounded(limit * draw.between(0.3, 0.8));
    // Of the limit, over the range; hostile ones are hardly seen in it, or exceed it.
    let spread = match (hostile, draw.chance(0.5)) {
        (false, _) => draw.scaled(0.03, 0.2),
        (true, false) => draw.scaled(0.001, 0.01),
        (true, true) => draw.between(0.3, 1.0),
    };
    let others = [LENGTH, VELOCITY, GRAVITY].into_iter().filter(|path| *path != swept);
    let others: Vec<&str> = others.filter(|path| *path == GRAVITY || draw.chance(0.5)).collect();
    let share = 2.0 * half_range * spread * slope / (others.len() as f64).sqrt();
    let random = |path: &&str| {
        let (value, slope) = flight.number(path).unwrap_or_default();
        // Of no block the length comes near zero, nor does gravity turn round.
        let variation = (share / (slope * value).abs()).min(0.2);
        json!({ "parameter": path, "law": "normal", "coefficient_of_variation": rounded(variation) })
    };
    let [from, to] =
        [-half_range, half_range].map(|away| rounded(limit + away * draw.between(0.8, 1.2)));
    let mut scene = json!({
        "solver": "smpm", "title": "a block in flight", "units": "si", "dimension": 1,
        "grid": { "cell": 0.1, "particles_per_cell": 2 },
        "gravity": [-flight.gravity],
        "materials": { "block": { "equation": { "neo_hookean": {
            "set": { "density": 1000.0, "bulk_modulus": 1e7, "shear_modulus": 5e6 } } } } },
        "bodies": [{ "name": "block", "material": "block",
            "shape": { "box": { "from": [0], "to": [flight.length] } }, "velocity": [flight.velocity] }],
        "gauges": [{ "name": "block", "body": "block", "within": [[-1], [9]] }],
        "quantities": ["position_1"],
        "times": [0.5 * flight.time, flight.time],
        "sweep": { "number": swept, "from": from, "to": to,
            "event": { "name": "above", "gauge": "block", "quantity": "position_1", "above": flight.height() } },
    });
    if draw.chance(0.3) {
        scene["method"] = json!("deterministic");
        return (scene, "deterministic");
    }
    let samples = if hostile { draw.whole(8, 20) } else { draw.whole(40, 80) };
    scene["random"] = others.iter().map(random).collect();
    scene["method"] = json!({ "monte_carlo":
        { "samples": samples, "seed": draw.whole(1, 1 << 30), "control": false } });
    (scene, "monte_carlo")
}

fn truths(scene: &Value) -> Option<Vec<Truth>> {
    let number = |pointer: &str| scene.pointer(pointer)?.as_f64();
    let flight = Flight {
        length: number("/bodies/0/shape/box/to/0")?,
        velocity: number("/bodies/0/velocity/0")?,
        gravity: -number("/gravity/0")?,
        time: number("/times/1")?,
    };
    let (value, slope) = flight.number(scene["sweep"]["number"].as_str()?)?;
    let missing = number("/sweep/event/above")? - flight.height();
    // Each step moves the block by the velocity at its end, so that it is lower by half of what gravity does in a step.
    let [least, most] = STEP.map(|step| 0.5 * flight.gravity * flight.time * step / slope);
    let known = |part: &str, value: f64, error: f64| {
        let id = format!("sweep/{part}");
        Truth { id, time: None, value, error }
    };
    let limit = value + missing / slope + 0.5 * (least + most);
    let limit = known("limit", limit, 0.5 * (most - least));
    let Some(random) = scene["random"].as_array() else { return Some(vec![limit]) };
    let variance = random.iter().try_fold(0.0, |sum, random| {
        let (value, own) = flight.number(random["parameter"].as_str()?)?;
        let deviation = own * value * random["coefficient_of_variation"].as_f64()? / slope;
        Some(sum + deviation * deviation)
    })?;
    Some(vec![limit, known("deviation", variance.sqrt(), 0.0)])
}
