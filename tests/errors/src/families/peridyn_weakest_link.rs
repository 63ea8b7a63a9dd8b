//! Plates that break with the weaker of two blocks: Weibull failure loads, scaled from the same plate of uniform strength.

use std::time::Duration;

use serde_json::{Value, json};

use super::peridyn_linear::{notch, plate, realisations};
use crate::draw::Draw;
use crate::verdict::of_scene;
use crate::{Family, Truth};

pub(super) const FAMILY: Family = Family {
    name: "peridyn-weakest-link",
    known_by: "Weibull's distribution of the weaker block, and the load of the plate at uniform strength",
    weight: 1.0,
    draw,
    truths,
    judge: of_scene,
};

/// Relative error of the load at uniform strength, by the residual of equilibria.
const ERROR: f64 = 1e-5;

/// One block, or two whose border is the plane of the notch; only bonds across it break, each as strong as the weaker block.
fn draw(draw: &mut Draw, hostile: bool) -> (Value, &'static str) {
    let (columns, rows) = (draw.whole(4, 6) as f64, 12.0);
    let blocks = draw.whole(1, 2);
    let mut scene = plate([columns, rows], realisations(draw, hostile), draw.whole(1, 9999));
    let [width, height] = [&scene["body"]["size"][0], &scene["body"]["size"][1]]
        .map(|it| it.as_f64().unwrap_or_default());
    let dx = height / rows;
    let modulus = if hostile { draw.between(0.7, 3.0) } else { draw.between(3.0, 20.0) };
    scene["bonds"] = json!({ "horizon": { "length": 1.5 * dx } });
    scene["notch"] = notch(rows, 1.3);
    scene["grips"] =
        json!({ "height": 1.1 * dx, "hold": "clamped", "protected": 0.5 * height - 0.9 * dx });
    // No plate is a million times as strong; strains of equilibria are taken for small.
    scene["loading"] = json!({ "stretch": { "strain": { "value": 1e3 } } });
    scene["dynamics"] =
        json!({ "quasi_static": { "batch": if draw.chance(0.5) { 0.0 } else { 0.02 } } });
    scene["strength"] = json!({ "weibull_by_volume": {
        "modulus": modulus, "reference_volume": width * height * dx * draw.scaled(0.1, 10.0),
        "element": { "block": { "size": 1.0001 * height / blocks as f64 } } } });
    (scene, if blocks == 1 { "one block" } else { "two blocks" })
}

fn truths(scene: &Value) -> Option<Vec<Truth>> {
    let weibull = &scene["strength"]["weibull_by_volume"];
    let number = |value: &Value| value.as_f64();
    let (modulus, reference) =
        (number(&weibull["modulus"])?, number(&weibull["reference_volume"])?);
    let size = [number(&scene["body"]["size"][0])?, number(&scene["body"]["size"][1])?];
    let is_whole = number(&weibull["element"]["block"]["size"])? >= 0.5 * size[1];
    let mut uniform = scene.clone();
    uniform["strength"] = json!("uniform");
    uniform["ensemble"]["realisations"] = json!(1);
    let at_scale = Truth { id: "failure_load/mean".into(), time: None, value: 0.0, error: 0.0 };
    let of_scale = of_scene(&uniform, &[at_scale], Duration::from_secs(60)).ok()?;
    let of_scale = of_scale.first().filter(|_| is_whole)?.number.value;
    // The weaker of both blocks is a block of the volume of the plate.
    let volume = size[0] * size[1] * number(&scene["body"]["spacing"])?;
    let scale = of_scale * (reference / volume).powf(1.0 / modulus);
    let gamma = |k: f64| libm::tgamma(1.0 + k / modulus);
    let known = |part: &str, value: f64| Truth {
        id: format!("failure_load/{part}"),
        time: None,
        value: scale * value,
        error: ERROR * scale * value,
    };
    let deviation = (gamma(2.0) - gamma(1.0).powi(2)).sqrt();
    Some(vec![known("mean", gamma(1.0)), known("standard_deviation", deviation)])
}
