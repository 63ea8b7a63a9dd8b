//! The page `docs/errors.md`.

use std::fmt::Write;

use crate::{ALL, Hunt, Outcome, Tally, Verdict};

/// Numbers farthest from the truth that are listed.
const WORST: usize = 12;

/// What a hunt found, as a page.
#[must_use]
pub fn page(hunt: &Hunt, outcomes: &[Outcome], tally: &Tally) -> String {
    let mut page = String::new();
    let (runs, seed, longest) = (hunt.runs, hunt.seed, hunt.longest.as_secs_f64());
    let command = format!(
        "cargo xtask audit errors --runs {runs} --seed {seed} --longest {longest} --record"
    );
    let seconds: f64 = outcomes.iter().map(|outcome| outcome.seconds).sum();
    let _ = writeln!(
        page,
        "# Stated errors\n\n\
         This page says how often the truth lies within the errors that runs state. Written by `{command}`: {} scenes drawn at \
         random, each of a family with a known answer, run as `cargo xtask run` runs them; {seconds:.0} s of computing.\n\n\
         Settings are sensible, or hostile: valid and chosen badly, such as a lattice that ends within the distribution, twenty \
         paths, or steps as long as a method takes at all.\nA number without a stated error is *unknown*. *Silent* are numbers \
         that are off by more than ten stated errors and have no warning beside them. A run that would take longer than the hunt \
         allows is *too long*; one that ends in another error is *refused*. *Stated/true* leaves out what a run calls a bound.\n\n\
         | family | answers known by |\n|---|---|",
        outcomes.len()
    );
    for family in ALL {
        let _ = writeln!(page, "| {} | {} |", family.name, family.known_by);
    }
    let _ = writeln!(page, "\n## How often the truth lies within the stated errors\n\n{tally}");
    let mut all: Vec<(&Outcome, &Verdict, f64)> = outcomes
        .iter()
        .flat_map(|outcome| {
            let verdicts = outcome.verdicts.as_deref().unwrap_or_default();
            verdicts.iter().filter_map(move |verdict| Some((outcome, verdict, verdict.off()?)))
        })
        .collect();
    all.sort_by(|a, b| b.2.total_cmp(&a.2));
    let _ = writeln!(
        page,
        "## The numbers farthest from the truth\n\n\
         `cargo xtask audit errors --seed {seed} --first N --runs 1` repeats a scene.\n\n\
         | scene | family, method | quantity | value | stated error | truth | stated errors | warning |\n|---|---|---|---|---|---|---|---|"
    );
    for (outcome, verdict, off) in all.into_iter().take(WORST) {
        let drawn = &outcome.drawn;
        let setting = if drawn.is_hostile { "hostile" } else { "sensible" };
        let (number, truth) = (&verdict.number, &verdict.truth);
        let _ = writeln!(
            page,
            "| {} | {}, {}, {setting} | `{}` | {:.4e} | {:.1e} | {:.4e} | {off:.1} | {} |",
            outcome.index,
            drawn.family.name,
            drawn.method,
            truth.id,
            number.value,
            number.error.unwrap_or_default(),
            truth.value,
            if verdict.is_warned { "yes" } else { "" }
        );
    }
    page
}
