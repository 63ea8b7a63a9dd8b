//! What is claimed of `advise`: on the built-in scenes its short trials find what longer ones confirm.

use scenes::advise::{Advice, Candidate, Options, from_trials};
use scenes::ladder::{BuiltIn, Trial, is_next_beyond, try_scene};

use crate::cases::prelude::*;

pub(super) const CASE: Case = Case {
    id: "advise/built-in-scenes",
    title: "What `advise` says from short trials, against longer ones of all methods",
    source: "the ladders of the built-in scenes, climbed until a run costs 5 s of CPU instead of 0.3 s",
    cost: Profile::Full,
    run: Alone(run),
};

/// The dearest short trial, and the dearest that judges it (CPU s).
const BUDGETS: [f64; 2] = [0.3, 5.0];
/// What is asked for.
const TOLERANCES: [f64; 2] = [0.1, 0.01];
/// The part of the answers that must be good, and the cost over the cheapest up to which one is.
const SHARE: f64 = 0.8;
const FACTOR: f64 = 2.0;

/// The expected cost over the cheapest beyond which advice is too expensive without a run.
const HOPELESS: f64 = 10.0;

/// How many pieces of advice were given, and how many were good.
#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    given: u32,
    good: u32,
    /// No method was named though one reaches the tolerance.
    silent: u32,
    /// The error was larger than asked for.
    too_rough: u32,
    /// It was more than twice as dear as the cheapest.
    too_dear: u32,
}

/// CPU times below this are counted as this: they scatter by more than methods differ (s).
const LEAST_COST: f64 = 0.02;

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    for solver in ["fpk", "smpm", "peridyn"] {
        let mut all = Tally::default();
        for scene in BuiltIn::all(
            scenes::ALL,
            &reference_problems::record::workspace().join("tests/scenes"),
        )? {
            if scene.name.starts_with(solver) {
                context.progress(&scene.name);
                tally(&scene, &mut all)?;
            }
        }
        claims.push(claim(context, solver, all));
    }
    Ok(claims)
}

fn tally(scene: &BuiltIn, tally: &mut Tally) -> CaseResult<()> {
    let [short, long] = BUDGETS;
    let trials = scene.trials(long, |_, _| {});
    for tolerance in TOLERANCES {
        let options = Options { tolerance, budget: short, quantities: Vec::new() };
        let of = |trials: Vec<Trial>| from_trials(scene.ladder.clone(), trials, &options);
        let truth = of(trials.clone())?;
        let advice = of(short_of(&trials, short))?;
        for quantity in 0..truth.judgements.len() {
            judge_one(scene, (&truth, &advice), quantity, tally);
        }
    }
    Ok(())
}

/// The trials that a smaller budget would have made: of each method up to the first after which the next would be too dear.
fn short_of(trials: &[Trial], budget: f64) -> Vec<Trial> {
    let mut short: Vec<Trial> = Vec::new();
    for trial in trials {
        let is_over = short.iter().any(|earlier| {
            earlier.method == trial.method
                && earlier.answers().is_some_and(|it| is_next_beyond(it.cpu_seconds, budget))
        });
        if !is_over {
            short.push(trial.clone());
        }
    }
    short
}

/// One quantity at one tolerance, where the long trials know it and a method that reaches it.
fn judge_one(
    scene: &BuiltIn,
    (truth, advice): (&Advice, &Advice),
    quantity: usize,
    tally: &mut Tally,
) {
    let known = &truth.judgements[quantity];
    let tolerance = truth.options.tolerance;
    let seen = |candidate: &&Candidate| candidate.needed.beyond <= 1.0;
    let candidates = truth.candidates(quantity);
    let Some(cheapest) = candidates.iter().find(seen) else { return };
    if known.error > 0.5 * tolerance * known.scale {
        return;
    }
    tally.given += 1;
    let place = advice.judgements.iter().position(|other| other.id == known.id);
    let given = place.filter(|&q| advice.is_known(q)).map(|q| advice.candidates(q));
    let Some(given) = given.as_ref().and_then(|all| all.first()) else {
        tally.silent += 1;
        return;
    };
    if given.needed.cost > HOPELESS * cheapest.needed.cost.max(LEAST_COST) {
        tally.too_dear += 1;
        return;
    }
    let ladder = &scene.ladder;
    let Some(rung) = (ladder.methods[given.method].rung)(given.needed.size) else { return };
    let ran = try_scene(scene.kind, &scene.file, &rung.trial, None);
    let found = ran.answers().and_then(|it| Some((it.cpu_seconds, it.get(&known.id)?)));
    let error = found.map(|(_, found)| (found.last.number.value - known.value).abs() / known.scale);
    // What was sampled may be off by two standard errors and no more was promised.
    if error.is_none_or(|error| error > tolerance) {
        tally.too_rough += 1;
        return;
    }
    let cost = found.map_or(f64::INFINITY, |(cost, _)| cost);
    if cost.max(LEAST_COST) > FACTOR * cheapest.needed.cost.max(LEAST_COST) {
        tally.too_dear += 1;
        return;
    }
    tally.good += 1;
}

fn claim(context: &Context<'_>, solver: &str, tally: Tally) -> Claim {
    let Tally { given, good, silent, too_rough, too_dear } = tally;
    let quantity = "share of quantities and tolerances for which the advice is within a factor 2 of the cheapest";
    let method = format!(
        "of {given}: {good} good, {silent} without advice, {too_rough} too rough, {too_dear} too dear"
    );
    let reason = "what a user may rely on: four pieces of advice of five; the rest is an error of the trials";
    let share = f64::from(good) / f64::from(given.max(1));
    context.subject(solver, quantity, method).measured(share, (SHARE, 1.0)).because(reason)
}
