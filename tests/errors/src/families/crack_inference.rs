//! One parameter from plates whose summaries are normal: how often its true value lies within posterior deviations of the mean.

use std::time::Duration;

use crack_inference::{
    Absent, Emulator, EmulatorMixture, Error, Observations, Parameter, ParameterSpace, Posterior,
    Prior, SamplerConfig, Scale, Summaries, Verdict as Identification,
};
use scenes::RunError;
use scenes::answers::{ErrorOrigin, Number};
use sde_integrators::{Noise, Purpose};
use serde_json::{Value, json};

use crate::draw::Draw;
use crate::{Family, Truth, Verdict};

pub(super) const FAMILY: Family = Family {
    name: "crack-inference",
    known_by: "parameter by which the plates were drawn",
    weight: 1.0,
    draw,
    truths,
    judge,
};

/// The prior is uniform between these.
const BOUNDS: [f64; 2] = [-1.0, 1.0];

/// As scenes compare data with predictions: a summary is outside the model where so few plates are within its middle 90 % that chance
/// does it in one case of 500.
fn is_predicted(measured: &Summaries, (mean, covariance): &(Vec<f64>, Vec<f64>)) -> bool {
    const QUANTILE: f64 = 1.645;
    (0..mean.len()).all(|i| {
        let width = QUANTILE * covariance[i * (mean.len() + 1)].sqrt();
        let n = measured.n_realisations();
        let inside = measured.rows().filter(|row| (row[i] - mean[i]).abs() < width).count();
        let mut term = 0.1_f64.powf(n as f64);
        let mut by_chance = term;
        for k in 0..inside {
            term *= 9.0 * (n - k) as f64 / (k + 1) as f64;
            by_chance += term;
        }
        by_chance >= 1.0 / 500.0
    })
}

/// Summaries of mean `slope theta + bend theta^2` and deviation `scatter exp(growth theta)`, at a true `theta` drawn from the prior; of a
/// hostile one at its bound, or of data that no parameter predicts.
fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let (kind, truth, offset) = match (hostile, draw.chance(0.5)) {
        (false, _) => ("inside", draw.between(-0.9, 0.9), 0.0),
        (true, true) => ("at the bound", BOUNDS[usize::from(draw.chance(0.5))], 0.0),
        (true, false) => ("outside", draw.between(-0.9, 0.9), draw.between(3.0, 6.0)),
    };
    let scene = json!({
        "crack_inference": { "truth": truth, "offset": offset, "slope": draw.between(1.0, 3.0),
            "bend": draw.between(-0.3, 0.3), "growth": draw.between(-0.3, 0.3), "scatter": draw.scaled(0.1, 1.0),
            "plates": draw.whole(if hostile { 1 } else { 4 }, 20), "points": draw.whole(8, 14),
            "realisations": draw.whole(if hostile { 8 } else { 24 }, 60), "seed": draw.whole(1, 99_999) },
    });
    (scene, kind)
}

fn truths(scene: &Value) -> Option<Vec<Truth>> {
    let value = scene["crack_inference"]["truth"].as_f64()?;
    Some(vec![Truth { id: "parameter/mean".into(), time: None, value, error: 0.0 }])
}

fn judge(scene: &Value, truths: &[Truth], _: Duration) -> Result<Vec<Verdict>, RunError> {
    posterior(&scene["crack_inference"], truths).map_err(RunError::solver)
}

fn posterior(keys: &Value, truths: &[Truth]) -> Result<Vec<Verdict>, Error> {
    let key = |name: &str| keys[name].as_f64().unwrap_or_default();
    let count = |name: &str| usize::try_from(keys[name].as_u64().unwrap_or(1)).unwrap_or(1);
    let noise = Noise::new(count("seed") as u64);
    let plates = |theta: f64, number: u64, n: usize, offset: f64| {
        let mut stream = noise.stream(Purpose::Field, number);
        let scatter = key("scatter") * (key("growth") * theta).exp();
        let mean = key("slope") * theta + key("bend") * theta * theta;
        let row = |_| stream.next_normal_pair().map(|z| mean + scatter * z).to_vec();
        let mut rows: Vec<Vec<f64>> = (0..n).map(row).collect();
        // The second summary of the data is moved against the first, whatever the parameter.
        for row in &mut rows {
            row[1] += offset * key("scatter");
        }
        Summaries::new(&rows, Absent::default())
    };
    let [low, high] = BOUNDS;
    let (name, prior) = ("parameter".to_owned(), Prior::Uniform);
    let parameter = Parameter { name, scale: Scale::Linear, low, high, prior };
    let space = ParameterSpace::new(vec![parameter])?;
    let points = space.design(count("points"))?;
    let ensemble =
        |(point, number): (&Vec<f64>, u64)| plates(point[0], number, count("realisations"), 0.0);
    let ensembles = points.iter().zip(1..).map(ensemble).collect::<Result<Vec<_>, _>>()?;
    let emulator = Emulator::new(&space, &points, &ensembles)?;
    let mixture = EmulatorMixture::new(&emulator, 24, &noise)?;
    let measured = plates(key("truth"), 0, count("plates"), key("offset"))?;
    let data = Observations::new(&measured, &[0.0; 2])?;
    let sampler = SamplerConfig {
        n_particles: 100,
        n_warm_up: 100,
        n_draws: 500,
        ..SamplerConfig::new(noise)
    };
    let posterior = Posterior::sample(&space, &|point| mixture.value(point, &data), &sampler)?;
    let [of] = posterior.parameters() else { return Ok(Vec::new()) };
    let error = Some(of.standard_deviation.value);
    let number = Number { value: of.mean.value, error, error_kind: ErrorOrigin::StandardError };
    let is_predicted = is_predicted(&measured, &emulator.moments(&[of.mean.value])?);
    let is_warned = of.verdict != Identification::Identified || !is_predicted;
    Ok(truths.iter().map(|truth| Verdict { truth: truth.clone(), number, is_warned }).collect())
}
