//! What is claimed of stated errors: on scenes drawn at random with known answers they hold.

use std::time::Duration;

use stated_errors::{Hunt, Row, Tally, hunt};

use crate::cases::prelude::*;

pub(super) const CASE: Case = Case {
    id: "scenes/random",
    title: "Stated errors of scenes drawn at random whose answers are known, at sensible and at hostile settings",
    source: "moment equations, stationary densities, finite volumes and quadrature, by family: docs/errors.md",
    cost: Profile::Quick,
    run: Together(run),
};

/// Scenes of the quick and of the whole proof, and their longest run: two of the sixty take six times as long as all others.
const SCENES: [u64; 2] = [60, 150];
const LONGEST: [Duration; 2] = [Duration::from_secs(3), Duration::from_secs(10)];
const SEED: u64 = 20;

/// Part of the numbers of normal errors that lie beyond two of them, and the part of scenes that may be refused.
const BEYOND_TWO: f64 = 0.05;
const REFUSED: f64 = 0.1;

fn run(context: &Context<'_>) -> CaseResult {
    let is_whole = usize::from(context.profile != Profile::Quick);
    let (runs, longest) = (SCENES[is_whole], LONGEST[is_whole]);
    let threads = rayon::current_num_threads();
    let (families, methods) = (Vec::new(), Vec::new());
    let asked = Hunt { runs, seed: SEED, first: 0, families, methods, longest, threads };
    let outcomes = hunt(&asked, &mut |outcome| context.progress(&outcome.index.to_string()));
    let tally = Tally::of(&outcomes);
    if outcomes.len() as u64 != runs {
        return Err("not all scenes were run".into());
    }
    let mut claims = Vec::new();
    for (setting, row) in &tally.all {
        let Row { runs, refused, numbers, unknown, silent, .. } = *row;
        let words = format!(
            "{runs} scenes, {refused} refused; {numbers} numbers, {unknown} with an unknown error"
        );
        let lines = context.lines(setting, words);
        let beyond_ten = "numbers off by more than ten stated errors without a warning";
        claims.push(
            lines.of("beyond-ten", beyond_ten).bounded(silent as f64, 0.5).because(
                "statistics: none is allowed, and the tolerance lies between none and one",
            ),
        );
        if setting == "sensible" {
            let beyond_two = "part of the numbers off by more than two stated errors";
            let refused = "part of the scenes that end in an error";
            claims.extend([
                lines.of("beyond-two", beyond_two).bounded(1.0 - row.within_two(), BEYOND_TWO).because(
                    "statistics: 4.6 % of normal errors are larger than two standard deviations",
                ),
                lines.of("refused", refused).bounded(row.refused_part(), REFUSED).because(
                    "statistics: of scenes that a user would call sensible most have an answer",
                ),
            ]);
        }
    }
    Ok(claims)
}
