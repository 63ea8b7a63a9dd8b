//! Scenes of concrete under slow loads: without scatter against the same tests built by hand, and the scatter of their loads.

use peridyn_sde::CrackRun;
use peridyn_sde::statistics::{Bootstrap, CrackEnsemble};
use scenes::peridyn::scene::CrackScene;
use scenes::peridyn::scene_body::ToughnessScene;
use scenes::peridyn::scene_field::VariationScene;
use scenes::peridyn::scene_problem::CrackProblem;
use scenes::scene::SceneFile;
use sde_integrators::Noise;

use crate::cases::prelude::*;
use crate::peridyn::concrete::{Concrete, Lattice, Tested, beam, panel};

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/slow-scenes",
    title: "Scenes of a notched beam and an L-shaped panel of concrete under slow loads: against tests built by hand, and their scatter",
    source: "the same specimens built by calls of the crate; Gregoire, Rojas-Solano & Pijaudier-Cabot 2013",
    cost: Profile::Default,
    run: Together(run),
};

const BEAM: &str = include_str!("../../../scenes/peridyn/notched_beam.json");
const PANEL: &str = include_str!("../../../scenes/peridyn/l_panel.json");
/// Largest loads of the tests of half-notched beams of 50 mm (N).
const MEASURED: [f64; 2] = [930.0, 1110.0];

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    for (name, text, by_hand, tolerance) in [
        ("notched-beam", BEAM, hand_made_beam as Build, 7e-7),
        ("l-panel", PANEL, hand_made_panel as Build, 3.5e-8),
    ] {
        context.progress(name);
        let mut scene: CrackScene = SceneFile::from_text(name, text.to_owned())?.parse()?;
        scene.strength = VariationScene::Uniform;
        scene.ensemble.realisations = 1;
        let uniform = ensemble(&scene)?;
        let peak = uniform.records[0].failure_load.ok_or("the scene has no load")?;
        let tested = by_hand(concrete(&scene)?, scene.body.spacing)?;
        let lines = context.lines(name, "uniform strength, one realisation");
        let quantity =
            "largest load of the scene, against the same specimen built by calls of the crate";
        let compared = lines.of("peak", quantity).unit("N").relative(peak, tested.peak()?.load);
        claims.push(compared.within(tolerance).because(SAME));
    }
    if context.profile == Profile::Full {
        claims.extend(scatter(context)?);
    } else {
        context.skip("the scatter of the loads of the notched beam: with --full");
    }
    Ok(claims)
}

/// A specimen by calls of the crate, of a spacing.
type Build = fn(Concrete, f64) -> CaseResult<Tested>;

const SAME: &str = "the reaction of the scene, the work of the load by hand: the same but for the residual of an equilibrium, 1e-6 of the reaction";

/// The mean of the largest loads with a random strength, and how much they scatter.
fn scatter(context: &Context<'_>) -> CaseResult {
    context.progress("scatter of the notched beam");
    let scene: CrackScene = SceneFile::from_text("notched_beam", BEAM.to_owned())?.parse()?;
    let run = ensemble(&scene)?;
    let n = scene.ensemble.realisations;
    let cracks = CrackEnsemble::new(n, run.records)?;
    let load = cracks.failure_load(&Bootstrap::new(Noise::new(scene.ensemble.seed)))?;
    let deviation = load.deviation.ok_or("too few loads")?;
    let method =
        format!("{n} realisations, strength lognormal with a deviation of 15 % over 10 mm");
    let lines = context.lines("notched-beam", method);
    let [low, high] = MEASURED;
    Ok(vec![
        lines
            .of("mean-peak", "mean of the largest loads, against the middle of the envelope of tests")
            .unit("N")
            .relative(sampled(&load.mean)?, 0.5 * (low + high))
            .within((high - low) / (high + low))
            .because("the envelope of the tests; strength and energy were fitted to this beam without scatter"),
        lines
            .of("deviation", "standard deviation of the largest loads over their mean")
            .measured(deviation.value / load.mean.value, (0.08, 0.16))
            .because("near the 15 % of the strength: one correlation length in the ligament, of which little is averaged"),
    ])
}

fn ensemble(scene: &CrackScene) -> CaseResult<CrackRun> {
    let problem = CrackProblem::new(scene, None).map_err(|refused| refused.message)?;
    let realisations = 0..scene.ensemble.realisations;
    Ok(problem.run(scene, realisations)?)
}

fn concrete(scene: &CrackScene) -> CaseResult<Concrete> {
    let ToughnessScene::Softening { tensile_strength, fracture_energy } = scene.material.toughness
    else {
        return Err("the scene has another toughness".into());
    };
    let young_modulus = scene.material.young_modulus;
    Ok(Concrete { young_modulus, tensile_strength, fracture_energy })
}

fn hand_made_beam(of: Concrete, spacing: f64) -> CaseResult<Tested> {
    beam(of, Lattice { spacing, shells: 3 }, Some(0.025), 5e-5)
}

fn hand_made_panel(of: Concrete, spacing: f64) -> CaseResult<Tested> {
    panel(of, Lattice { spacing, shells: 3 }, 3e-4, Some([[0.256, 0.244], [0.25, 0.25]]))
}
