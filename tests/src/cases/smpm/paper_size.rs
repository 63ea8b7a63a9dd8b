//! The second example of Chen et al. 2019 with as many particles as there: the same values as the built-in scene, and its cost.

use reference_problems::smpm::problems::experiment;
use reference_problems::smpm::published::{scene_as_printed, widen};
use scenes::clock::CpuClock;
use scenes::smpm::reading::MOST_RANDOM;
use smpm::uncertainty::Study;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/paper-size",
    title: "Contact explosion with 160,000 particles in two metres of water against the built-in scene, and its cost",
    source: "own runs; Chen et al. 2019, section 5.2 and Table 9",
    cost: Profile::Full,
    run: Alone(run),
};

/// Two metres of water, cells of 5 mm, four particles a cell: 160,000 of them in the half above the plane of symmetry, half a
/// metre high.
const HALF_LENGTH: f64 = 100.0;
const HEIGHT: f64 = 50.0;
const COEFFICIENT_OF_VARIATION: f64 = 0.1;
const N_SAMPLES: f64 = 1e4;
/// Times at which Tables 6 to 8 may have been read (us).
const TIMES: [f64; 7] = [8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0];

fn run(context: &Context<'_>) -> CaseResult {
    let small = scene_as_printed(COEFFICIENT_OF_VARIATION, &TIMES)?;
    let mut scene = small.clone();
    widen(&mut scene, HALF_LENGTH, HEIGHT);
    let of_small = experiment::<2>(&small)?;
    let of_small = Study::new(&of_small, small.inputs()?, small.plan()?)?.propagated()?;
    let experiment = experiment::<2>(&scene)?;
    let n_particles = experiment.n_particles();
    context.progress("reference run");
    let study = Study::new(&experiment, scene.inputs()?, scene.plan()?)?;
    let start = CpuClock::start();
    let _ = study.run(&[0.0; MOST_RANDOM])?;
    let of_one = start.seconds();
    context.progress("run with derivatives");
    let start = CpuClock::start();
    let propagated = study.propagated()?;
    let of_jets = start.seconds();
    let mut worst = [Worst::of_errors(), Worst::of_errors()];
    for (response, (a, b)) in of_small.moments.iter().zip(&propagated.moments).enumerate() {
        let (gauge, quantity, window) = study.plan().parts(response);
        let place = format!(
            "{}, {}, {} us",
            study.plan().quantities[quantity],
            study.plan().gauges[gauge].name,
            study.plan().windows[window].to
        );
        worst[0].take(b.mean() / a.mean() - 1.0, &place);
        worst[1].take(b.variance() / a.variance() - 1.0, &place);
    }
    let method = format!(
        "jets, {n_particles} particles, cells of 5 mm, {} steps, Johnson-Cook as published",
        study.schedule().n_steps()
    );
    let mut claims = Vec::new();
    for (worst, moment) in worst.iter().zip(["mean", "variance"]) {
        let quantity = format!("relative distance of the {moment} from that of the built-in scene");
        let lines = context.lines("built-in", worst.method(&method));
        let claim = lines.of(moment, quantity).bounded(worst.value(), 6e-14);
        claims.push(claim.because("roundoff: nothing has come back from an edge of either scene"));
    }
    claims.extend(costs(&context.lines("", method), n_particles, of_jets / of_one));
    Ok(claims)
}

/// By the processor time of the run with derivatives over that of one run.
fn costs(lines: &Lines<'_>, n_particles: usize, of_jets: f64) -> [Claim; 3] {
    [
        lines
            .of("particles", "particles")
            .measured(n_particles as f64, (160_000.0, 160_000.0))
            .because("as many as in the paper"),
        lines
            .of("cost/jets", "processor time of the run with derivatives over that of one run")
            .measured(of_jets, (5.0, 40.0))
            .because("17 numbers for one, of the same run; the paper's 1.06 is what derivatives at a frozen state cost"),
        lines
            .of(
                "cost/samples",
                "processor time of 10,000 runs over that of the reference run and the jets",
            )
            .measured(N_SAMPLES / (1.0 + of_jets), (200.0, 2000.0))
            .because("by the time of one run, of the same case; the paper's ratio is 9,404"),
    ]
}
