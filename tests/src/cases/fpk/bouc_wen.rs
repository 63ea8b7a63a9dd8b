//! The hysteretic oscillator of the paper's section 4.2: three states, a flow that folds the cloud.

use fpk_sph::score::{Degree, VolumeEstimate};
use fpk_sph::systems::BoucWen;
use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, Estimator, InitialLattice, Method, Simulation,
};
use sde_integrators::GaussianMixture;

use super::lines::{Lines, scene};
use crate::case::{Case, CaseError, Context, Profile};
use crate::claim::Criterion;
use crate::fpk::reference::ReferenceTable;
use crate::fpk::scene_system::SceneSystem;
use crate::report::{Claim, ErrorKind};

const SOURCE: &str =
    "Canor & Denoël 2013, section 4.2; references by Monte Carlo and importance sampling";

pub(crate) const COARSE: Case = Case {
    id: "fpk-sph/bouc-wen-coarse",
    title: "Building that yields in an earthquake, flow-map fit, spacing 0.6",
    source: SOURCE,
    cost: Profile::Quick,
    run: coarse,
};

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/bouc-wen",
    title: "Building that yields in an earthquake, flow-map fit, 8,217 particles",
    source: SOURCE,
    cost: Profile::Default,
    run: fine,
};

pub(crate) const TAIL: Case = Case {
    id: "fpk-sph/bouc-wen-tail",
    title: "Building that yields in an earthquake, its tail, log-density fit, ball of 5.5 sigma",
    source: SOURCE,
    cost: Profile::Default,
    run: tail,
};

/// What was seen at one time.
struct Seen {
    t: f64,
    moments: [f64; 3],
    /// Per threshold: by cells, and by counting particles.
    exceedances: Vec<(f64, f64, f64)>,
    /// The largest `|z|` of a particle up to here, over the limit.
    z: f64,
}

/// A run to the last of the times.
struct Run {
    seen: Vec<Seen>,
    words: String,
    reference: ReferenceTable,
}

const THRESHOLDS: [f64; 4] = [0.5, 1.0, 1.5, 2.0];
const POWERS: [([u32; 3], &str, &str, &str); 3] = [
    ([2, 0, 0], "second-moment-q", "E[q^2]", "m^2"),
    ([0, 2, 0], "second-moment-v", "E[v^2]", "m^2/s^2"),
    ([0, 0, 2], "second-moment-z", "E[z^2]", "m^2"),
];
/// A fortieth of the period: the longest step, after each of which `z` is looked at.
const LOOK: f64 = 0.05;

fn run(method: Method, reach: f64, spacing: f64, times: &[f64]) -> Result<Run, CaseError> {
    let text = include_str!("../../../scenes/fpk/bouc_wen.json");
    let scene = scene("tests/scenes/fpk/bouc_wen.json", text)?;
    let SceneSystem::BoucWen(system) = scene.system.build()? else {
        return Err("the scene holds another system".into());
    };
    let law = scene.initial.build(None)?;
    let lattice = InitialLattice::Ball { reach, spacing };
    let reference_period = system.period();
    let config = Config { method, lattice, reference_period, most_steps: DEFAULT_MOST_STEPS };
    watched(system, &law, &config, times)
}

fn watched(
    system: BoucWen,
    law: &GaussianMixture<3>,
    config: &Config<3>,
    times: &[f64],
) -> Result<Run, CaseError> {
    let limit = system.z_limit();
    let start = cpu_time::ProcessTime::now();
    let mut simulation = Simulation::new(system, law, config)?;
    let (mut seen, mut z, mut looks) = (Vec::new(), 0.0_f64, 0.0);
    for &t in times {
        while simulation.time() < t {
            looks += 1.0;
            simulation.advance_to((looks * LOOK).min(t))?;
            z = simulation.positions().iter().fold(z, |z, x| z.max(x[2].abs() / limit));
            // A time between two looks is one itself.
            looks = (simulation.time() / LOOK + 1e-9).floor();
        }
        let cells = simulation.cell_integral()?;
        let exceedance = |threshold: f64| -> Result<_, CaseError> {
            let demand = |x: &[f64; 3]| x[0].abs();
            let by_cells = cells.exceedance(demand, threshold)?.probability;
            Ok((threshold, by_cells, simulation.exceedance_indicator(demand, threshold)?))
        };
        let exceedances = THRESHOLDS.into_iter().map(exceedance).collect::<Result<_, _>>()?;
        let moments = POWERS.map(|(powers, ..)| simulation.raw_moment(powers));
        seen.push(Seen { t, moments, exceedances, z });
    }
    let words = format!(
        "ball, {} particles, {} steps, {:.1} s CPU with observation",
        simulation.n_particles(),
        simulation.work().steps,
        start.elapsed().as_secs_f64()
    );
    Ok(Run { seen, words, reference: ReferenceTable::bouc_wen()? })
}

impl Run {
    fn lines<'a>(&self, context: &'a Context<'a>, id: &'a str, words: &str) -> Lines<'a> {
        Lines { context, id, method: format!("{words}, {}", self.words) }
    }

    fn moments(
        &self,
        lines: &Lines<'_>,
        criterion: Criterion<'_>,
    ) -> Result<Vec<Claim>, CaseError> {
        let mut claims = Vec::new();
        for Seen { t, moments, .. } in &self.seen {
            for ((powers, name, quantity, unit), &value) in POWERS.into_iter().zip(moments) {
                let reference = self.reference.moment(powers, *t).ok_or("no reference")?;
                let name = format!("{name}/t{t}");
                let what = (name.as_str(), quantity, unit);
                claims.push(lines.judge(what, ErrorKind::Relative, value, reference, criterion));
            }
        }
        Ok(claims)
    }

    /// `P(|q| > T)` where the criterion says how; by cells, or by counting particles.
    fn tail<'c>(
        &self,
        lines: &Lines<'_>,
        cells: bool,
        criterion: impl Fn(f64, f64) -> Option<Criterion<'c>>,
    ) -> Vec<Claim> {
        let mut claims = Vec::new();
        for Seen { t, exceedances, .. } in &self.seen {
            for &(threshold, by_cells, indicator) in exceedances {
                let (Some(criterion), Some(reference)) =
                    (criterion(threshold, *t), self.reference.exceedance(threshold, *t))
                else {
                    continue;
                };
                let (value, estimator) =
                    if cells { (by_cells, "cell") } else { (indicator, "indicator") };
                let name = format!("exceedance-{estimator}/threshold-{threshold}/t{t}");
                let quantity = format!("P(|q| > {threshold})");
                let what = (name.as_str(), quantity.as_str(), "");
                claims.push(lines.judge(what, ErrorKind::Log10, value, reference, criterion));
            }
        }
        claims
    }

    /// The hysteretic force stays within its limit.
    fn bounded(&self, lines: &Lines<'_>) -> Claim {
        let z = self.seen.last().map_or(f64::NAN, |seen| seen.z);
        let reason = "z' = 0 at |z| = (A/(beta + gamma))^(1/n): no path passes it; looked at every 0.05 s or finer";
        lines.measured(("largest-z", "largest |z| over its limit", ""), z, (0.0, 1.0), reason)
    }
}

fn coarse(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let run = run(Method::FlowMapFit, 5.0, 0.6, &[1.0, 2.0, 3.0, 3.6])?;
    let lines = run.lines(context, "flow-map-fit", "flow-map fit, 5 sigma, spacing 0.6");
    let reason = "truncation of the cubic fit at the fold that the hysteresis makes of the cloud; seen within 0.62 %";
    let mut claims = run.moments(&lines, Criterion::Within { tolerance: 0.01, reason })?;
    let reason =
        "the same truncation, and a limit taken as linear in a part of a cell; seen within 0.013";
    claims.extend(run.tail(&lines, true, |threshold, _| {
        (threshold <= 1.0).then_some(Criterion::Within { tolerance: 0.05, reason })
    }));
    claims.push(run.bounded(&lines));
    Ok(claims)
}

/// Where the tail is not reached: threshold, time, and the band of the error in log10 P around what was seen.
const MISSED: [(f64, f64, f64, f64); 13] = [
    (1.5, 2.0, -0.3, -0.15),
    (2.0, 2.0, -3.0, -1.8),
    (1.5, 3.0, -0.45, -0.25),
    (2.0, 3.0, -0.9, -0.5),
    (1.5, 3.6, -0.55, -0.3),
    (2.0, 3.6, -1.4, -0.8),
    (1.5, 4.0, -0.25, 0.0),
    (2.0, 4.0, 0.8, 1.5),
    (1.5, 5.0, 0.9, 1.4),
    (2.0, 5.0, 3.5, 4.4),
    (1.0, 6.0, 0.1, 0.2),
    (1.5, 6.0, 2.6, 3.5),
    (2.0, 6.0, 7.0, 8.4),
];

fn fine(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let times = [1.0, 2.0, 3.0, 3.6, 4.0, 5.0, 6.0];
    let run = run(Method::FlowMapFit, 5.0, 0.4, &times)?;
    let lines = run.lines(context, "flow-map-fit", "flow-map fit, 5 sigma, spacing 0.4");
    let reason = "truncation of the cubic fit at the fold that the hysteresis makes of the cloud; seen within 0.59 %";
    let mut claims = run.moments(&lines, Criterion::Within { tolerance: 0.01, reason })?;
    let reason = "the same truncation; seen within 0.009 up to t = 4 and 0.023 at t = 5";
    let missed = "not reached: the rim of the ball folds, its cells turn over, and what they take from their \
                  neighbours is no tail; too little of it up to t = 4, far too much after";
    claims.extend(run.tail(&lines, true, |threshold, t| {
        let same = |at: &&(f64, f64, f64, f64)| (at.0 - threshold).abs() + (at.1 - t).abs() < 1e-9;
        Some(match MISSED.iter().find(same) {
            Some(&(_, _, from, to)) => Criterion::AsMeasured { from, to, reason: missed },
            None => Criterion::Within { tolerance: 0.05, reason },
        })
    }));
    claims.push(run.bounded(&lines));
    Ok(claims)
}

/// A run for the tail alone. The flow-map fit folds its rim (see [`MISSED`]); the log-density fit finds its neighbours anew
/// where the rim has gone, and kernel sums need no lattice cell.
fn tail(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let (volume, degree) = (VolumeEstimate::KernelSum, Degree::Quadratic);
    let method = Method::Custom(Combination {
        estimator: Estimator::LogDensityFit { volume, degree },
        ..Method::LogDensityFit.combination()
    });
    let run = run(method, 5.5, 0.35, &[3.6])?;
    let lines = run.lines(
        context,
        "log-density-fit",
        "log-density fit, kernel sums, 5.5 sigma, spacing 0.35",
    );
    let reason = "truncation of the quadratic fit, of order 2 in the spacing: at 0.5 the same run is 0.32 high at T = 2; \
                  seen within 0.097";
    let mut claims =
        run.tail(&lines, true, |_, _| Some(Criterion::Within { tolerance: 0.1, reason }));
    let reason = "the same truncation, and the particles beyond T = 2 are few: seen within 0.095";
    claims
        .extend(run.tail(&lines, false, |_, _| Some(Criterion::Within { tolerance: 0.1, reason })));
    let reason = "truncation of the quadratic fit: for moments the flow-map fit is three times as accurate and cheaper; \
                  seen +1.5, +1.7 and +0.7 %";
    claims.extend(run.moments(&lines, Criterion::Within { tolerance: 0.025, reason })?);
    claims.push(run.bounded(&lines));
    Ok(claims)
}
