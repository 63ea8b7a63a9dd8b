//! The built-in scene of inference: does it recover the toughness and the scatter of strength of its synthetic plates?

use std::path::Path;

use reference_problems::processes::outcome;
use reference_problems::record::workspace;
use scenes::checkpoint::Start;
use scenes::crack_inference::measured::Measured as Plates;
use scenes::crack_inference::scene::InferenceScene;
use scenes::peridyn::scene::CrackScene;
use scenes::peridyn::scene_problem::CrackProblem;
use scenes::{Options, SceneFile};
use sde_integrators::{Noise, Purpose};
use serde_json::{Value, json};

use crate::cases::prelude::*;
use crate::cases::scene_result::result_of;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/infer-scene",
    title: "The scene infer_toughness: toughness and scatter of strength from cracks and loads of 16 synthetic plates",
    source: "synthetic truth: the plate's own scene at G0 = 4.8 J/m^2 and a coefficient of variation of 0.15, another seed",
    cost: Profile::Default,
    run: Together(run),
};

const SCENE: &str = "tests/scenes/peridyn/infer_toughness.json";
const PLATE: &str = "tests/scenes/peridyn/notched_plate_coarse.json";

/// Of the measured plates: energy release rate (J/m^2) and coefficient of variation of the strength.
const TRUTH: [f64; 2] = [4.8, 0.15];
const PLATES: usize = 16;
/// Seed of the measured plates and of the errors of their measurement.
const SEED: u64 = 2026;
/// A measured path at abscissae 2 mm apart, and its failure load.
struct Synthetic {
    path: Vec<[f64; 2]>,
    load: f64,
}

/// The plates of the files, made again: paths and loads of the model at the truth with errors of measurement.
fn synthetic(scene: &InferenceScene) -> CaseResult<Vec<Synthetic>> {
    let file = SceneFile::read(&workspace().join(PLATE))?;
    let mut keys = file.keys().clone();
    keys["material"]["toughness"]["energy_release_rate"] = json!(TRUTH[0]);
    keys["strength"]["field"]["marginal"]["lognormal"]["coefficient_of_variation"] =
        json!(TRUTH[1]);
    let mut plate: CrackScene = file.with_keys(keys).parse()?;
    plate.ensemble.seed = SEED;
    let problem = CrackProblem::new(&plate, None)?;
    let run = problem.run(&plate, 0..2 * PLATES as u64)?;
    let mut plates = Vec::new();
    // Plates that crack elsewhere are no data: the likelihood is that of complete cracks.
    let complete = run.records.iter().filter(|record| record.exit.is_some());
    for record in complete.take(PLATES) {
        let mut stream = Noise::new(SEED).stream(Purpose::Bootstrap, record.realisation);
        let crack = peridyn_sde::CrackPath::from_points(record.path.clone())?;
        let mut path = Vec::new();
        for k in 8..=20_u32 {
            let (x, error) = (0.002 * f64::from(k), stream.next_normal_pair()[0]);
            if let Some(y) = crack.height_at(x) {
                path.push([x, y + scene.measured.height_error * error]);
            }
        }
        let load = record.failure_load.ok_or("a plate without a load")?;
        let error = scene.measured.load_error * stream.next_normal_pair()[0];
        plates.push(Synthetic { path, load: load * (1.0 + error) });
    }
    Ok(plates)
}

/// Largest distance of the files to the plates made again: of a height (m), and of a load (N).
fn distance(plates: &[Synthetic], files: &Plates) -> CaseResult<[f64; 2]> {
    if plates.len() != files.plates.len() {
        return Err(format!("{} plates in the files", files.plates.len()).into());
    }
    let mut largest = [0.0_f64; 2];
    for (made, read) in plates.iter().zip(&files.plates) {
        if made.path.len() != read.path.len() {
            return Err(format!("{} points of plate {}", read.path.len(), read.name).into());
        }
        for (made, read) in made.path.iter().zip(&read.path) {
            largest[0] = largest[0].max((made[1] - read[1]).abs()).max((made[0] - read[0]).abs());
        }
        let load = read.failure_load.ok_or("a plate of the files without a load")?;
        largest[1] = largest[1].max((made.load - load).abs());
    }
    Ok(largest)
}

fn run(context: &Context<'_>) -> CaseResult {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    let file = SceneFile::read(&workspace().join(SCENE))?;
    let scene: InferenceScene = file.parse()?;
    context.progress("synthetic plates");
    let size = SceneFile::read(&workspace().join(PLATE))?.parse::<CrackScene>()?.body.size;
    let distance = distance(&synthetic(&scene)?, &Plates::read(&scene, file.folder(), size)?)?;
    context.progress("inference");
    let result = run_file(&file, &folder.join("whole"), Start::Anew)?;
    let method = format!(
        "{} ensembles of {}, averaged over {} emulators, 4 chains of {}",
        scene.design.points, scene.design.realisations, scene.design.emulators, scene.sampler.draws
    );
    let lines = context.lines("", method);
    let mut claims = vec![
        lines
            .of("files/height", "largest distance of a measured height to the plate made again")
            .unit("m")
            .bounded(distance[0], 0.5e-6 * (1.0 + 1e-6))
            .because("rounding: the files have six digits of a metre"),
        lines
            .of("files/load", "largest distance of a failure load to the plate made again")
            .unit("N")
            .bounded(distance[1], 0.5e-6 * (1.0 + 1e-6))
            .because("rounding: the files have six digits of a newton"),
    ];
    for (parameter, (name, truth)) in result["parameters"]
        .as_array()
        .into_iter()
        .flatten()
        .zip(["toughness", "scatter"].into_iter().zip(TRUTH))
    {
        claims.extend(of_parameter(&lines, name, parameter, truth)?);
    }
    claims.extend(quality(&lines, &result)?);
    claims.push(resumed(&lines, &file, folder)?);
    Ok(claims)
}

fn number(value: &Value, pointer: &str) -> CaseResult<f64> {
    Ok(value.pointer(pointer).and_then(Value::as_f64).ok_or_else(|| format!("no {pointer}"))?)
}

fn of_parameter(lines: &Lines<'_>, name: &str, of: &Value, truth: f64) -> CaseResult {
    let (mean, deviation) = (number(of, "/mean/value")?, number(of, "/standard_deviation/value")?);
    let error = number(of, "/mean/error")?;
    Ok(vec![
        lines
            .of(
                format!("{name}/mean"),
                format!("distance of the posterior mean of the {name} to the truth, in posterior deviations"),
            )
            .absolute(Measured::sampled((mean - truth) / deviation, error / deviation), 0.0)
            .within(3.0)
            .because("statistics: a truth lies beyond three deviations of its posterior once in 370 data sets"),
        lines
            .of(
                format!("{name}/contraction"),
                format!("share of the variance of the prior of the {name} that the plates remove"),
            )
            .measured(number(of, "/contraction/value")?, (0.5, 1.0))
            .because("above one half data say more of a parameter than its prior"),
        lines
            .of(format!("{name}/r-hat"), format!("R-hat of the {name}, less one"))
            .bounded(number(of, "/r_hat")? - 1.0, 0.01)
            .because("Vehtari et al. 2021 ask for 1.01"),
        lines
            .of(format!("{name}/effective-draws"), format!("bulk effective sample size of the {name}"))
            .measured(number(of, "/effective_sample_size")?, (400.0, 20_000.0))
            .because("Vehtari et al. 2021 ask for 400 over four chains"),
    ])
}

fn quality(lines: &Lines<'_>, result: &Value) -> CaseResult {
    let share = "/predictive/share_inside";
    let error = number(result, &format!("{share}/error"))?;
    Ok(vec![
        lines
            .of("predictive/share", "share of measured heights and loads inside the predicted 90 %")
            .absolute(number(result, &format!("{share}/value"))?, 0.9)
            .within(3.0 * error)
            .because("statistics: three standard errors of 16 plates; the posterior has seen them, which raises the share a little"),
        lines
            .of("least-share", "smallest share of realisations of an ensemble that have all summaries")
            .measured(number(result, "/emulator/least_share")?, (0.5, 1.0))
            .because("the likelihood is that of plates whose crack comes to all abscissae"),
    ])
}

/// A smaller scene: some points of its design, then all with `--resume`, against all at once.
fn resumed(lines: &Lines<'_>, file: &SceneFile, folder: &Path) -> CaseResult<Claim> {
    lines.context.progress("resumed");
    let of_points = |points: u64| {
        let mut keys = file.keys().clone();
        keys["design"] = json!({ "points": points, "realisations": 16, "emulators": 8 });
        keys["sampler"] = json!({ "particles": 100, "draws": 200 });
        keys["predictive"] = json!({ "draws": 4, "realisations": 16 });
        file.with_keys(keys)
    };
    let out = folder.join("resumed");
    run_file(&of_points(10), &out, Start::Anew)?;
    run_file(&of_points(12), &out, Start::GoOn)?;
    let at_once = folder.join("at-once");
    run_file(&of_points(12), &at_once, Start::Anew)?;
    let (resumed, at_once) = (outcome(&out)?, outcome(&at_once)?);
    let different = resumed.symmetric_difference(&at_once).count();
    Ok(lines
        .context
        .subject(
            "resumed",
            "entries of the result that differ",
            "10 points, then 12 with --resume, against 12 at once",
        )
        .same_bits(different, at_once.len())
        .because("an ensemble depends on its number and its point alone"))
}

fn run_file(file: &SceneFile, out: &Path, start: Start) -> CaseResult<Value> {
    result_of(file, &Options { start, ..Options::new(out) })
}
