//! Whether the indicators of a Taylor series say when to believe it: all responses of the two explosions.

use reference_problems::quantile::quantile;
use reference_problems::smpm::problems::Problem;
use smpm::uncertainty::Switch;

use super::contact_explosion::solved;
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/trust",
    title: "Curvature ratio and distance to a switch against the true error of the variance, over all responses of the explosions",
    source: "own sampled runs with control variate",
    cost: Profile::Default,
    run: Together(run),
};

/// Below this ratio of curvature to slope a variance is to be believed.
const TRUSTED: f64 = 0.03;
/// A variance off by more is wrong.
const WRONG: f64 = 0.05;

/// A response: its indicators and the error of its variance.
struct Judged {
    ratio: f64,
    switch: f64,
    error: f64,
}

fn judged(context: &Context<'_>) -> CaseResult<Vec<Judged>> {
    let runs = [
        (Problem::ContactExplosion, 0.05),
        (Problem::ContactExplosion, 0.15),
        (Problem::ThickPlate, 0.01),
        (Problem::ThickPlate, 0.05),
    ];
    let mut all = Vec::new();
    for (problem, cv) in runs {
        let solved = solved(context, problem, cv)?;
        for (response, moments) in solved.propagated.moments.iter().enumerate() {
            let Some(ratio) = moments.curvature_ratio() else { continue };
            let truth = solved.sampled.controlled(response, moments)?.variance.value;
            all.push(Judged {
                ratio: ratio.sqrt(),
                switch: solved.propagated.switches[response].at_end,
                error: (moments.variance() / truth - 1.0).abs(),
            });
        }
    }
    Ok(all)
}

fn run(context: &Context<'_>) -> CaseResult {
    let all = judged(context)?;
    let trusted: Vec<f64> =
        all.iter().filter(|one| one.ratio < TRUSTED).map(|one| one.error).collect();
    let method = format!("{} responses, {} of them trusted", all.len(), trusted.len());
    let lines = context.lines("", method);
    let count = |warned: &dyn Fn(&Judged) -> bool, wrong: bool| {
        let hits = all.iter().filter(|one| warned(one) != wrong && (one.error > WRONG) == wrong);
        hits.count() as f64
    };
    let by_ratio = |one: &Judged| one.ratio >= TRUSTED;
    let by_both = |one: &Judged| one.ratio >= TRUSTED || one.switch <= Switch::LIMIT;
    let n = all.len() as f64;
    let counted = |name: &str, quantity: &str, measured: f64, range: (f64, f64)| {
        let reason = "counted, out of all responses; wrong is a variance that is off by more than 5 %. The limit is cautious: two in five are warned and right. Another set of samples moves a few";
        lines.of(name, quantity).measured(measured, range).because(reason)
    };
    Ok(vec![
        lines
            .of("responses", "responses with a curvature ratio")
            .measured(n, (324.0, 324.0))
            .because("two gauges or four, one quantity or four, nine times, two coefficients of variation of each problem"),
        lines
            .of("median", "median relative error of the variance where the ratio is below 0.03")
            .bounded(quantile(&trusted, 0.5), 2e-3)
            .because("the curvature's part of the variance is the square of the ratio, 1e-3"),
        lines
            .of("p90", "ninth decile of the same")
            .measured(quantile(&trusted, 0.9), (0.01, 0.015))
            .because("1 % is not reached: 1.2 % with 250 samples, 1.1 % with 1000. What is beyond the curvature's part are switches, which it does not see"),
        counted("false-alarms", "warned by the ratio and right", count(&by_ratio, false), (120.0, 134.0)),
        counted("misses", "not warned by the ratio and wrong", count(&by_ratio, true), (1.0, 3.0)),
        counted(
            "false-alarms-with-switch",
            "warned by ratio or switch and right",
            count(&by_both, false),
            (128.0, 142.0),
        ),
        counted(
            "misses-with-switch",
            "not warned by ratio or switch and wrong",
            count(&by_both, true),
            (0.0, 0.0),
        ),
    ])
}
