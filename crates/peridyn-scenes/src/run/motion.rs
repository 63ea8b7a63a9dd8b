//! The map of damage of an ensemble and the growth of cracks in single realisations, as fields of its page.

use peridyn_sde::{CrackRun, FinalState};
use result_figures::number::short;
use result_pages::{Frame, Layer, Motion, Place, Points, Scale};
use scene_runs::kind::RunError;
use sde_integrators::Estimate;

use super::growth::Growth;
use crate::scene::CrackScene;
use crate::scene_problem::CrackProblem;

/// Realisations to choose from.
const MOST_REALISATIONS: usize = 16;

/// The map, if there are realisations, and the realisations that the scene names.
pub(super) fn motions(
    scene: &CrackScene,
    problem: &CrackProblem,
    run: &CrackRun,
) -> Result<Vec<Motion>, RunError> {
    let map = (!run.damage.realisations().is_empty()).then(|| map(scene, problem, run));
    let grown = (!run.kept.is_empty()).then(|| realisations(scene, problem, &run.kept));
    Ok(map.transpose()?.into_iter().chain(grown.transpose()?).collect())
}

/// Nodes that are shown, one in `stride`.
struct Nodes<'a> {
    scene: &'a CrackScene,
    problem: &'a CrackProblem,
    stride: usize,
}

impl<'a> Nodes<'a> {
    /// Nodes of a field with this number of frames and layers; two fields share the page.
    fn new(scene: &'a CrackScene, problem: &'a CrackProblem, bytes: usize) -> Self {
        let n = problem.nodes().positions().len();
        // Positions are stored once.
        Self { scene, problem, stride: Motion::stride(2 * n, 1, 2, bytes) }
    }

    fn layer(&self, (name, unit): (&str, &str), frames: Vec<Vec<f64>>) -> Layer {
        #[expect(clippy::cast_possible_truncation, reason = "a byte is what is shown of it")]
        let thin = |values: Vec<f64>| -> Vec<f32> {
            values.into_iter().step_by(self.stride).map(|value| value as f32).collect()
        };
        let values = frames.into_iter().map(thin).collect();
        Layer { name: name.to_owned(), unit: unit.to_owned(), scale: Scale::Linear, values }
    }

    fn motion(
        &self,
        (title, slider): (&str, &str),
        about: &str,
        names: Vec<String>,
        layers: Vec<Layer>,
    ) -> Motion {
        let places = self.problem.nodes().positions();
        let thinned = match self.stride {
            1 => String::new(),
            stride => format!(" One in {stride} of {} nodes is shown.", places.len()),
        };
        Motion {
            title: title.to_owned(),
            about: format!("{about}{thinned}"),
            slider: slider.to_owned(),
            axes: vec!["x (m)".to_owned(), "y (m)".to_owned()],
            frames: names.into_iter().map(|name| Frame { name }).collect(),
            place: Place::Points(Points {
                spacing: self.scene.body.spacing * (self.stride as f64).sqrt(),
                positions: vec![places.iter().step_by(self.stride).flatten().copied().collect()],
            }),
            layers,
        }
    }
}

/// Probability that a node is damaged, and its mean damage with the standard error where there are two realisations.
fn map(scene: &CrackScene, problem: &CrackProblem, run: &CrackRun) -> Result<Motion, RunError> {
    let nodes = Nodes::new(scene, problem, 3);
    let values = |estimates: &[Estimate]| estimates.iter().map(|it| it.value).collect::<Vec<f64>>();
    let probability = values(&run.damage.probability().map_err(RunError::solver)?);
    let mut layers = vec![nodes.layer(("probability of damage", ""), vec![probability])];
    let n = run.damage.realisations().len();
    if n >= 2 {
        let mean = run.damage.mean().map_err(RunError::solver)?;
        layers.push(nodes.layer(("mean damage", ""), vec![values(&mean)]));
        let errors = mean.iter().map(|it| it.standard_error().unwrap_or(0.0)).collect();
        layers.push(nodes.layer(("standard error of the mean damage", ""), vec![errors]));
    }
    let about = format!(
        "Probability that a node has lost {} of the stiffness of its bonds, the notch included; standard error at most {:.2}.",
        scene.output.damage_threshold,
        0.5 / (n as f64).sqrt()
    );
    let names = vec![format!("{n} realisations")];
    Ok(nodes.motion(("Map of damage", "ensemble"), &about, names, layers))
}

/// How the cracks of the realisations that were kept grew, a layer for each, and their strength where it is a field.
fn realisations(
    scene: &CrackScene,
    problem: &CrackProblem,
    kept: &[FinalState],
) -> Result<Motion, RunError> {
    let shown = Motion::shown_frames(kept.len(), MOST_REALISATIONS);
    let states: Vec<&FinalState> = shown.iter().map(|&k| &kept[k]).collect();
    let growth = Growth::of(scene, problem, &states)?;
    let nodes = Nodes::new(scene, problem, states.len() * (growth.times.len() + 1));
    let mut layers = Vec::new();
    for (state, damage) in states.iter().zip(growth.damage) {
        let of = |what: &str| format!("{what}, realisation {}", state.realisation);
        layers.push(nodes.layer((&of("damage"), ""), damage));
        let strength = state.strength.clone();
        layers.extend(strength.map(|it| nodes.layer((&of("critical stretch"), ""), vec![it])));
    }
    let left_out = match kept.len() - states.len() {
        0 => String::new(),
        n => {
            format!(" {n} of {} realisations are left out; the folder fields has all.", kept.len())
        }
    };
    let about = format!(
        "Part of the stiffness of its bonds that a node has lost, at the start, between the first and the last failure of a \
         bond, and at the end.{left_out}"
    );
    let (symbol, unit) = growth.axis;
    let name = |&at: &f64| format!("{symbol} = {} {unit}", short(Some(at))).trim_end().to_owned();
    let names = growth.times.iter().map(name).collect();
    let slider = if symbol == "t" { "time" } else { "load" };
    Ok(nodes.motion(("Growth of cracks", slider), &about, names, layers))
}
