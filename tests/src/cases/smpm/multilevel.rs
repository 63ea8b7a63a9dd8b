//! Multilevel Monte Carlo over grids: a column against its integral, and two responses behind an explosion, one of which differs
//! from grid to grid.

use std::path::Path;

use rayon::ThreadPoolBuilder;
use reference_problems::smpm::problems::Problem;
use scenes::checkpoint::Start;
use scenes::smpm::method_scene::{MethodScene, MultilevelScene};
use scenes::smpm::scene::SmpmScene;
use scenes::{Options, SceneFile};
use serde_json::Value;

use crate::cases::prelude::*;
use crate::cases::scene_result;
use crate::cases::smpm::contact_explosion;
use crate::cases::smpm::random_fields::{SCENE_COLUMN, column_moments, standard_error};

pub(crate) const COLUMN: Case = Case {
    id: "smpm/multilevel/column",
    title: "Displacement of a column of random stiffness by samples on grids of doubling cells",
    source: "the integral of smpm/random-fields/column; Giles 2008",
    cost: Profile::Default,
    run: Together(column),
};

pub(crate) const EXPLOSION: Case = Case {
    id: "smpm/multilevel/explosion",
    title: "Two responses behind an explosion by samples on grids of doubling cells",
    source: "own plain samples; Giles 2015: levels that do not pay are dropped",
    cost: Profile::Default,
    run: Together(explosion),
};

const STRENGTH: f64 = 0.15;

/// The result of a scene by multilevel Monte Carlo, run in a folder.
fn result_of(scene: &SmpmScene, tolerance: f64, out: &Path, start: Start) -> CaseResult<Value> {
    let method = MultilevelScene::new(tolerance, 11);
    let scene = SmpmScene { method: MethodScene::Multilevel(method), ..scene.clone() };
    let text = serde_json::to_string(&scene)?;
    let file = SceneFile::from_text("scene.json", text)?;
    scene_result::result_of(&file, &Options { start, ..Options::new(out) })
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// The first quantity at the first gauge at the last time: the response whose tolerance decides.
fn decisive(result: &Value) -> Value {
    let values = &result["gauges"][0]["quantities"][0]["values"];
    values.as_array().and_then(|values| values.last()).cloned().unwrap_or_default()
}

/// A moment of a response with its standard error.
fn moment(response: &Value, name: &str) -> Measured {
    let error = number(&response[&format!("{name}_standard_error")]);
    Measured::sampled(number(&response[name]), error)
}

/// Work of plain samples for the standard errors of a result, over the work of the result: the larger of mean and variance, for a normal
/// distribution.
fn gain(result: &Value) -> f64 {
    let response = decisive(result);
    let [mean, variance] = ["mean", "variance"].map(|name| moment(&response, name));
    let samples = |variance: f64, of: Measured| variance / of.standard_error.unwrap_or(0.0).powi(2);
    let n = samples(variance.value, mean).max(samples(2.0 * variance.value.powi(2), variance));
    let finest = result["multilevel"]["grids"].as_array().and_then(|grids| grids.last());
    let count = |key: &str| finest.map_or(f64::NAN, |grid| number(&grid[key]));
    n * count("particles") * count("steps") / number(&result["multilevel"]["work"])
}

/// Cells of the grids that an estimate uses, the coarsest first.
fn used_cells(result: &Value) -> Vec<f64> {
    let grids = result["multilevel"]["grids"].as_array().cloned().unwrap_or_default();
    let used = grids.iter().filter(|grid| grid["is_used"] == true);
    used.map(|grid| number(&grid["cell"])).collect()
}

fn column(context: &Context<'_>) -> CaseResult {
    let folder = tempfile::tempdir()?;
    let mut scene = Problem::RandomColumn.scene()?;
    scene.grid.cell = 0.0625;
    let tolerance = 0.02;
    context.progress("samples on grids");
    let result = result_of(&scene, tolerance, &folder.path().join("fine"), Start::Anew)?;
    let response = decisive(&result);
    let start = number(&result["gauges"][0]["quantities"][0]["values"][0]["mean"]);
    let [mean, variance, _] = column_moments(&SCENE_COLUMN, start);
    let method = format!(
        "cells {:?}, mean and variance to {tolerance}, {} runs",
        used_cells(&result),
        result["work"]["runs"]
    );
    let lines = context.lines("", method);
    let found = moment(&response, "mean");
    let mut claims = vec![
        lines
            .of("mean", "mean displacement, middle")
            .unit("m")
            .relative(Measured { value: found.value - start, ..found }, mean)
            .monte_carlo(5e-4)
            .because("320 particles, and the terms of the field that are left out"),
        lines
            .of("variance", "variance of the displacement, middle")
            .unit("m^2")
            .relative(moment(&response, "variance"), variance)
            .monte_carlo(5e-3)
            .because("320 particles, and the terms of the field that are left out"),
        lines
            .of("gain", "work of plain samples over that of the grids, for the same errors")
            .measured(gain(&result), (50.0, 400.0))
            .because("grids as coarse as five cells follow the finest one; most of the work is the pilot"),
    ];
    scene.grid.cell = 0.25;
    claims.push(same_bits(context, &scene, folder.path())?);
    Ok(claims)
}

/// A run on one thread, on two, and one that continues a run with a larger tolerance.
fn same_bits(context: &Context<'_>, scene: &SmpmScene, folder: &Path) -> CaseResult<Claim> {
    let tolerance = 0.05;
    let on = |n_threads: usize| -> CaseResult<Value> {
        let pool = ThreadPoolBuilder::new().num_threads(n_threads).build()?;
        let out = folder.join(format!("{n_threads}-threads"));
        pool.install(|| result_of(scene, tolerance, &out, Start::Anew))
    };
    let continued = folder.join("continued");
    result_of(scene, 3.0 * tolerance, &continued, Start::Anew)?;
    let runs = [on(1)?, on(2)?, result_of(scene, tolerance, &continued, Start::GoOn)?];
    let numbers =
        |result: &Value| ["gauges", "multilevel"].map(|key| result[key].to_string()).concat();
    let n_different = runs[1..].iter().filter(|run| numbers(run) != numbers(&runs[0])).count();
    let n_values = numbers(&runs[0]).split(',').count();
    let quantity = "results that differ from that on one thread";
    let method = "two threads; a run continued from a larger tolerance";
    let reason = "blocks of samples are functions of their addresses, the plan of the blocks alone";
    let subject = context.subject("same-bits", quantity, method);
    Ok(subject.same_bits(n_different, 2 * n_values).because(reason))
}

fn explosion(context: &Context<'_>) -> CaseResult {
    let solved = contact_explosion::solved(context, Problem::ContactExplosion, STRENGTH)?;
    let folder = tempfile::tempdir()?;
    let mut scene = Problem::ContactExplosion.scene_with(STRENGTH, &contact_explosion::TIMES)?;
    scene.fields = false;
    scene.levels.clear();
    context.progress("flow stress on three grids");
    let flow = result_of(&scene, 0.03, &folder.path().join("flow"), Start::Anew)?;
    let method = format!(
        "flow stress at H to 0.03, cells {:?}, {} runs",
        used_cells(&flow),
        flow["work"]["runs"]
    );
    let lines = context.lines("", method);
    let response = solved.plan.index(0, 0, solved.plan.windows.len() - 1);
    let plain = solved.sampled.controlled(response, &solved.propagated.moments[response])?;
    let mut claims = Vec::new();
    for (name, estimate) in [("mean", &plain.mean), ("variance", &plain.variance)] {
        let quantity = format!("{name} of sigma_y at H, 14 us");
        let value = moment(&decisive(&flow), name);
        let reference = Reference::uncertain(estimate.value, standard_error(estimate));
        let compared = lines.of(format!("flow-stress/{name}"), quantity).relative(value, reference);
        claims.push(compared.monte_carlo(1e-12).because("none: the same runs on the finest grid"));
    }
    let quantity = "work of plain samples over that of the grids, for the same errors";
    let reason = "each level's variance is about its own mean, so the shift of the flow stress from grid to grid costs nothing";
    let claim = lines.of("flow-stress/gain", quantity).measured(gain(&flow), (5.0, 80.0));
    claims.push(claim.because(reason));
    context.progress("S11 on three grids");
    scene.quantities.swap(0, 1);
    let deviator = result_of(&scene, 0.2, &folder.path().join("deviator"), Start::Anew)?;
    let notes = deviator["notes"].to_string();
    let kept =
        used_cells(&deviator).len() as f64 - f64::from(u8::from(!notes.contains("does not pay")));
    let method =
        "S11 at H to 0.2; the deviation on the next grid is several times larger".to_owned();
    let lines = context.lines("", method);
    let reason = "statistics: the variance of the difference is fifty times that of the response";
    let subject = lines.of("deviator-11/grids", "grids that are used and reported");
    claims.push(subject.absolute(kept, 1.0).within(0.0).because(reason));
    Ok(claims)
}
