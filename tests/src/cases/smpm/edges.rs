//! The explosions in 28 x 24 cm against larger and clamped ones: when a gauge first depends on the edges.

use reference_problems::smpm::problems::{Problem, experiment};
use reference_problems::smpm::published::{clamp, widen};
use scenes::smpm::scene::SmpmScene;
use smpm::Simulation;
use smpm::uncertainty::{Experiment, Study};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/edges",
    title: "Explosions in 28 x 24 cm of water against twice the size, and against clamped edges",
    source: "own runs; Chen et al. 2019, section 5: 2 x 2 m of water, a plate with clamped edges",
    cost: Profile::Quick,
    run: Together(run),
};

/// Edges of the water of both scenes (cm).
const HALF_LENGTH: f64 = 14.0;
const HEIGHT: f64 = 12.0;
/// Last time of both scenes, and one at which the edges are seen (us).
const LAST: f64 = 14.0;
const LATER: f64 = 30.0;

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    let times: Vec<f64> = (4..=14).map(f64::from).chain([LATER]).collect();
    for (edges, name) in [("larger", "edges twice as far away"), ("clamped", "clamped edges")] {
        let (mut early, mut later) = (Worst::of_errors(), Worst::of_errors());
        for problem in [Problem::ContactExplosion, Problem::ThickPlate] {
            context.progress(&format!("{problem:?}, {name}"));
            let scene = problem.scene_with(0.05, &times)?;
            let mut other = scene.clone();
            match edges {
                "larger" => widen(&mut other, 2.0 * HALF_LENGTH, 2.0 * HEIGHT),
                _ => clamp(&mut other, HALF_LENGTH, HEIGHT),
            }
            compare(problem, &scene, &other, &mut early, &mut later)?;
        }
        let method = format!("both scenes, all gauges and quantities, {name}");
        let lines = |worst: &Worst| context.lines(edges, worst.method(&method));
        claims.push(
            lines(&early)
                .of("while-it-lasts", "distance up to 14 us, over the quantity's largest")
                .bounded(early.value(), 2e-14)
                .because("roundoff: nothing has come back from an edge; sums of other lengths"),
        );
        let reason = "by then the edges are seen";
        let subject = lines(&later).of("later", "distance at 30 us, over the quantity's largest");
        claims.push(subject.measured(later.value(), (1e-3, 4e-3)).because(reason));
    }
    claims.push(first_return(context)?);
    Ok(claims)
}

/// Takes the distances of two scenes at all gauges.
fn compare(
    problem: Problem,
    scene: &SmpmScene,
    other: &SmpmScene,
    early: &mut Worst,
    later: &mut Worst,
) -> CaseResult<()> {
    let plan = scene.plan::<2>()?;
    let [ours, theirs] = [centre(scene)?, centre(other)?];
    let mut largest = vec![0.0_f64; plan.quantities.len()];
    for (response, value) in ours.iter().enumerate() {
        let quantity = plan.parts(response).1;
        largest[quantity] = largest[quantity].max(value.abs());
    }
    for (response, (a, b)) in ours.iter().zip(&theirs).enumerate() {
        let (gauge, quantity, window) = plan.parts(response);
        let time = plan.windows[window].to;
        let place = format!("{problem:?}, {}, {time} us", plan.gauges[gauge].name);
        let worst = if time > LAST { &mut *later } else { &mut *early };
        worst.take((b - a).abs() / largest[quantity], &place);
    }
    Ok(())
}

/// The responses of the reference run.
fn centre(scene: &SmpmScene) -> CaseResult<Vec<f64>> {
    let experiment = experiment::<2>(scene)?;
    let study = Study::new(&experiment, scene.inputs()?, scene.plan::<2>()?)?;
    Ok(study.centre().to_vec())
}

/// The shortest way from the point of ignition by an edge to a gauge, over the fastest signal of the run: the speed whose
/// Courant number limits the step, viscosity included.
fn first_return(context: &Context<'_>) -> CaseResult<Claim> {
    let scene = Problem::ContactExplosion.scene_with(0.05, &[LAST])?;
    let gauges = scene.plan::<2>()?.gauges;
    let ways = gauges.iter().flat_map(|gauge| {
        let smpm::Place::Nearest([x, y]) = gauge.place else { return vec![] };
        let sides = [2.0 * HALF_LENGTH - x, 2.0 * HALF_LENGTH + x];
        vec![sides[0].hypot(y), sides[1].hypot(y), x.hypot(2.0 * HEIGHT - y)]
    });
    let way = ways.fold(f64::INFINITY, f64::min);
    let experiment = experiment::<2>(&scene)?;
    let inputs = scene.inputs()?;
    let mut run: Simulation<f64, 2> = Experiment::simulation(&experiment, &inputs.centre())?;
    let mut fastest = 0.0_f64;
    while run.time() < LAST {
        let config = run.config();
        fastest = fastest.max(config.courant_number * config.cell / run.longest_step());
        let _ = run.step()?;
    }
    Ok(context
        .lines("", format!("{way:.3} cm at {fastest:.3} cm/us, the fastest signal of the run"))
        .of("first-return", "earliest time at which anything can be back from an edge")
        .unit("us")
        .measured(way / fastest, (21.3, 22.3))
        .because("the scene ends at 14 us"))
}
