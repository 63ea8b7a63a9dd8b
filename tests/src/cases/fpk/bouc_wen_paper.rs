//! The paper's method on the hysteretic oscillator of its section 4.2.

use fpk_sph::{Combination, Error, InitialLattice, Method};

use super::bouc_wen::{SOURCE, run as run_to};
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/bouc-wen-canor-denoel-2013",
    title: "Building that yields in an earthquake, the paper's method: 13^3 and 21^3 particles",
    source: SOURCE,
    cost: Profile::Full,
    run: Together(run),
};

/// The paper's method on its lattice: where its errors were seen, with room, since the run is chaotic in the last bit.
struct PaperRun {
    id: &'static str,
    count: usize,
    support_over_spacing: f64,
    most_steps: u64,
    /// Of the relative errors of `E[q^2]`, `E[v^2]`, `E[z^2]` at t = 1, then at t = 2.
    moments: [[Criterion<'static>; 3]; 2],
    /// Of the error of log10 P(|q| > T) by the indicator at t = 2: T, tolerance.
    tail: &'static [(f64, f64)],
    /// Steps to t = 2.
    steps: (f64, f64),
}

const MOMENTS: &str = "isotropic kernel on a sheared lattice, kernel smoothing, forward Euler";
const CHAOTIC: &str = "chaos: the same three errors; another time to land on, or another last bit, moves them by several per cent";

const fn band(from: f64, to: f64) -> Criterion<'static> {
    Criterion::AsMeasured { from, to, reason: MOMENTS }
}

const fn chaotic(tolerance: f64) -> Criterion<'static> {
    Criterion::Within { tolerance, reason: CHAOTIC }
}

const SMALL: PaperRun = PaperRun {
    id: "particles-13",
    count: 13,
    support_over_spacing: 2.2,
    most_steps: 6_000,
    moments: [
        [chaotic(0.05), band(-0.18, -0.10), chaotic(0.07)],
        [chaotic(0.06), chaotic(0.06), chaotic(0.09)],
    ],
    tail: &[(0.5, 0.12), (1.0, 0.5)],
    steps: (2_000.0, 6_000.0),
};

const LARGE: PaperRun = PaperRun {
    id: "particles-21",
    count: 21,
    support_over_spacing: 2.5,
    most_steps: 12_000,
    moments: [
        [chaotic(0.08), band(-0.12, -0.04), chaotic(0.08)],
        [chaotic(0.05), chaotic(0.05), chaotic(0.05)],
    ],
    tail: &[(0.5, 0.06), (1.0, 0.1), (1.5, 0.6)],
    steps: (3_000.0, 10_000.0),
};

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = paper_run(context, &SMALL)?;
    claims.extend(paper_run(context, &LARGE)?);
    Ok(claims)
}

fn paper_run(context: &Context<'_>, paper: &PaperRun) -> CaseResult {
    let &PaperRun { count, support_over_spacing, most_steps, .. } = paper;
    let method = Method::Custom(Combination {
        support_over_spacing,
        ..Method::CanorDenoel2013.combination()
    });
    let lattice = InitialLattice::Rectangle { half_width: [0.2; 3], count: [count; 3] };
    let run = run_to(method, lattice, &[1.0, 2.0, 4.0], most_steps)?;
    let words = format!("Canor & Denoël 2013, {count}^3, support/spacing {support_over_spacing}");
    let lines = run.lines(context, paper.id, &words);
    let mut claims = Vec::new();
    for (seen, criteria) in run.seen.iter().zip(paper.moments) {
        for (k, criterion) in criteria.into_iter().enumerate() {
            claims.push(run.moment(&lines, (k, seen), criterion)?);
        }
    }
    let reason = "chaos: the lattice ends at 4 sigma, and fewer particles reach a threshold the higher it is; other times to land on move 13^3 from +0.02 to -0.07 at T = 0.5 and from -0.08 to -0.28 at T = 1";
    claims.extend(run.tail(&lines, false, |threshold, t| {
        let &(_, tolerance) = paper.tail.iter().find(|at| (at.0 - threshold).abs() < 1e-9)?;
        (t > 1.5).then_some(Criterion::Within { tolerance, reason })
    }));
    let steps = run.seen.get(1).map_or(f64::NAN, |seen| seen.steps as f64);
    let reason = "the Courant rule follows the smallest smoothing length, which clumping drives down; the prototype took 6,016 with 21^3";
    let claim = lines.of("steps/t2", "steps to t = 2").measured(steps, paper.steps);
    claims.push(claim.because(reason));
    let (time, words) = match &run.stopped {
        Some((time, error @ (Error::WorkLimit { .. } | Error::StepCollapsed { .. }))) => {
            (*time, error.to_string())
        }
        Some((_, error)) => (f64::NAN, format!("another error: {error}")),
        None => (f64::NAN, "the run reached t = 4 within its steps".to_owned()),
    };
    let lines = context.lines(paper.id, words);
    let reason = "steps of 1e-4 and less: it goes on, but not to an end worth waiting for";
    let subject = lines.of("ends", "time at which the limit of steps ends it").unit("s");
    claims.push(subject.measured(time, (2.0, 3.9)).because(reason));
    claims.push(run.bounded(&lines));
    Ok(claims)
}
