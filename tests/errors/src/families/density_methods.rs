//! Methods of a density scene, with sensible or hostile settings.

use fpk_scenes::scene::FpkScene;
use fpk_scenes::system::System;
use serde_json::{Value, json};

use crate::Truth;
use crate::draw::{Draw, rounded};

/// What is known of the answers of a scene of this solver; none of a scene of another one.
pub(super) fn of_density(
    scene: &Value,
    truths: impl Fn(&FpkScene, &System) -> Option<Vec<Truth>>,
) -> Option<Vec<Truth>> {
    let (scene, system) = FpkScene::read("scene.json", &scene.to_string()).ok()?;
    truths(&scene, &system)
}

/// What a method has to know of a system.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solvable {
    pub(super) n_states: usize,
    /// Shortest period, or relaxation time of the steps.
    pub(super) period: f64,
    pub(super) class: Class,
    pub(super) has_filter: bool,
    /// Whether its drift is linear: a flow map of another one folds, and needs remeshing.
    pub(super) is_linear: bool,
    /// Whether a demand is compared with thresholds.
    pub(super) has_thresholds: bool,
}

/// What of the noise and the states a method relies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Class {
    /// Two states, noise on the velocity alone.
    Oscillator,
    /// Additive noise.
    Additive,
    /// Noise that depends on the state.
    General,
}

/// A method that solves the system, by its name; hostile settings are valid and chosen badly.
pub(super) fn method(draw: &mut Draw, of: &Solvable, hostile: bool) -> (&'static str, Value) {
    let mut names = vec!["flow_map_fit", "flow_map_fit", "monte_carlo"];
    if of.class == Class::Oscillator {
        names.push("conservative_grid");
    }
    if of.class != Class::General {
        names.push("statistical_linearisation");
        if of.has_thresholds {
            names.extend(["guided_paths", "subset_simulation"]);
        }
    }
    let name = *draw.one_of(&names);
    let step = |draw: &mut Draw| {
        let per_period = if hostile { draw.between(8.0, 16.0) } else { draw.between(40.0, 80.0) };
        rounded(of.period / per_period)
    };
    let settings = match name {
        "flow_map_fit" => return ("flow_map_fit", json!({ name: lattice(draw, of, hostile) })),
        "conservative_grid" => {
            let cells = if hostile { draw.whole(24, 64) } else { draw.whole(80, 200) };
            let reach = if hostile { draw.between(4.0, 5.0) } else { draw.between(5.5, 8.0) };
            let steps = if hostile { draw.between(6.0, 20.0) } else { draw.between(40.0, 100.0) };
            json!({ "cells": cells, "reach": reach, "steps_per_period": steps })
        }
        "statistical_linearisation" => {
            let per_period = if hostile { draw.scaled(5.0, 16.0) } else { draw.scaled(20.0, 80.0) };
            json!({ "step": rounded(of.period / per_period) })
        }
        "monte_carlo" => {
            let paths = if hostile { draw.whole(20, 200) } else { draw.whole(1_000, 10_000) };
            json!({ "paths": paths, "step": step(draw), "seed": draw.whole(1, 1_000_000) })
        }
        "guided_paths" => {
            let samples = if hostile { draw.whole(100, 200) } else { draw.whole(500, 2_000) };
            json!({ "samples": samples, "step": step(draw), "seed": draw.whole(1, 1_000_000) })
        }
        _ => {
            let samples = if hostile { draw.whole(100, 200) } else { draw.whole(300, 800) };
            let correlation = if hostile { draw.between(0.1, 0.99) } else { 0.8 };
            let runs = if hostile { draw.whole(4, 6) } else { draw.whole(8, 16) };
            let seed = draw.whole(1, 1_000_000);
            json!({ "samples": samples, "correlation": correlation, "runs": runs, "step": step(draw), "seed": seed })
        }
    };
    (name, json!({ name: settings }))
}

/// A lattice of the flow-map fit.
fn lattice(draw: &mut Draw, of: &Solvable, hostile: bool) -> Value {
    let reach = if hostile { draw.between(1.0, 4.0) } else { draw.between(4.5, 6.5) };
    let mut lattice = if of.n_states == 1 {
        let count = if hostile { draw.whole(9, 41) } else { draw.whole(61, 161) };
        json!({ "count": [count], "reach": reach })
    } else if of.n_states <= 2 && draw.chance(0.5) {
        let count = if hostile {
            draw.whole(7, 17)
        } else {
            draw.whole(if of.is_linear { 25 } else { 41 }, 49)
        };
        json!({ "count": vec![count; of.n_states], "reach": reach })
    } else if of.n_states <= 2 {
        let spacing = if hostile {
            draw.between(0.6, 1.2)
        } else {
            draw.between(0.2, if of.is_linear { 0.4 } else { 0.3 })
        };
        json!({ "spacing": spacing, "reach": reach })
    } else {
        let (finest, widest) = if of.n_states <= 4 { (0.8, 4.5) } else { (1.1, 4.0) };
        let spacing = draw.between(finest, if hostile { 1.5 } else { finest + 0.1 });
        json!({ "spacing": spacing, "reach": reach.min(widest) })
    };
    if of.has_filter && (of.n_states > 4 || draw.chance(0.5)) {
        lattice["filter"] = json!("conditioned");
        lattice["spacing"] = json!(if hostile { 0.9 } else { 0.35 });
        lattice["reach"] = json!(reach);
    } else if draw.chance(0.3) || !of.is_linear && !hostile {
        lattice["fresh_lattices"] = json!({});
    }
    if draw.chance(0.3) {
        let steps = if hostile { draw.between(8.0, 16.0) } else { draw.between(40.0, 100.0) };
        lattice["steps_per_period"] = json!(steps);
    }
    lattice
}
