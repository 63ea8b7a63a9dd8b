//! The map of damage of an ensemble and the damage of single realisations, as fields of its page.

use pages::{Frame, Layer, Motion, Place, Points, Scale};
use peridyn_sde::{CrackRun, FinalState};
use sde_integrators::Estimate;

use crate::kind::RunError;
use crate::peridyn::scene::CrackScene;
use crate::peridyn::scene_problem::CrackProblem;

/// The map, if there are realisations, and the realisations that the scene names.
pub(super) fn motions(
    scene: &CrackScene,
    problem: &CrackProblem,
    run: &CrackRun,
) -> Result<Vec<Motion>, RunError> {
    let map = (!run.damage.realisations().is_empty()).then(|| map(scene, problem, run));
    let single = (!run.kept.is_empty()).then(|| realisations(scene, problem, &run.kept));
    Ok(map.transpose()?.into_iter().chain(single).collect())
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

    fn motion(&self, title: &str, about: &str, names: Vec<String>, layers: Vec<Layer>) -> Motion {
        let places = self.problem.nodes().positions();
        let thinned = match self.stride {
            1 => String::new(),
            stride => format!(" One in {stride} of {} nodes is shown.", places.len()),
        };
        Motion {
            title: title.to_owned(),
            about: format!("{about}{thinned}"),
            slider: "realisation".to_owned(),
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
    let probability = values(&run.damage.probability()?);
    let mut layers = vec![nodes.layer(("probability of damage", ""), vec![probability])];
    let n = run.damage.realisations().len();
    if n >= 2 {
        let mean = run.damage.mean()?;
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
    Ok(nodes.motion("Map of damage", &about, names, layers))
}

/// Damage at the end of each realisation that was kept, and its strength where it is a field.
fn realisations(scene: &CrackScene, problem: &CrackProblem, kept: &[FinalState]) -> Motion {
    let shown = Motion::shown_frames(kept.len(), Motion::MOST_FRAMES);
    let nodes = Nodes::new(scene, problem, 2 * shown.len());
    let states: Vec<&FinalState> = shown.iter().map(|&k| &kept[k]).collect();
    let damage = states.iter().map(|state| state.damage.clone()).collect();
    let mut layers = vec![nodes.layer(("damage", ""), damage)];
    let strengths: Option<Vec<Vec<f64>>> =
        states.iter().map(|state| state.strength.clone()).collect();
    layers.extend(strengths.map(|it| nodes.layer(("critical stretch", ""), it)));
    let left_out = match kept.len() - states.len() {
        0 => String::new(),
        n => {
            format!(" {n} of {} realisations are left out; the folder fields has all.", kept.len())
        }
    };
    let about =
        format!("Part of the stiffness of its bonds that a node has lost at the end.{left_out}");
    let names = states.iter().map(|state| format!("realisation {}", state.realisation)).collect();
    nodes.motion("Damage of single realisations", &about, names, layers)
}
