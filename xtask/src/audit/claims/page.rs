//! Outcomes as a table, and as a page of the documents.

use std::collections::BTreeMap;

use super::mutant::{Breaks, Mutant};
use super::outcome::{Kept, Outcomes};

/// Name, crate and physics of each mutant.
pub(super) fn list(mutants: &[Mutant]) -> String {
    let line = |m: &Mutant| format!("{:<28}{:<22}{}\n", m.name, m.package, m.what);
    mutants.iter().map(line).collect()
}

/// A line for each mutant: verdict, counts, seconds, first claim.
pub(super) fn table(mutants: &[Mutant], outcomes: &Outcomes) -> String {
    let line = |mutant: &Mutant| {
        let said = outcomes.of(mutant).map_or("not run".to_owned(), |kept| kept.outcome.words());
        format!("{:<10}{:<28}{said}\n", verdict(mutant, outcomes), mutant.name)
    };
    mutants.iter().map(line).collect()
}

fn verdict(mutant: &Mutant, outcomes: &Outcomes) -> &'static str {
    let Some(last) = outcomes.last_of(mutant) else { return "not run" };
    let (is_caught, is_now) =
        (last.outcome.is_caught(mutant.breaks), outcomes.of(mutant).is_some());
    match (is_caught, is_now) {
        (true, true) => "caught",
        (true, false) => "caught before",
        _ if !last.outcome.fault.is_empty() => "NO RESULT",
        (false, true) => "SURVIVED",
        (false, false) => "SURVIVED before",
    }
}

/// The page `docs/mutants.md`.
pub(super) fn render(mutants: &[Mutant], outcomes: &Outcomes, machine: &str) -> String {
    let mut page = head(mutants, outcomes, machine);
    page.push_str(
        "\n| crate | mutants | caught | caught before | survived | not run |\n|---|---|---|---|---|---|\n",
    );
    let mut crates: BTreeMap<&str, Vec<&Mutant>> = BTreeMap::new();
    for mutant in mutants {
        crates.entry(&mutant.package).or_default().push(mutant);
    }
    for (name, of) in &crates {
        let count = |word: &str| of.iter().filter(|m| verdict(m, outcomes) == word).count();
        let [caught, before, not_run] = ["caught", "caught before", "not run"].map(count);
        let survived = of.len() - caught - before - not_run;
        let cells = [of.len(), caught, before, survived, not_run].map(|count| count.to_string());
        page.extend(["| ", name, " | ", cells.join(" | ").as_str(), " |\n"]);
    }
    for (name, of) in &crates {
        page.extend(["\n## ", name, "\n\n", COLUMNS]);
        page.extend(of.iter().map(|mutant| row(mutant, outcomes)));
    }
    page
}

const COLUMNS: &str = "\
| mutant | what it breaks | verdict | accuracy | structural | regression bounds | stopped cases | first claim that fails | seconds | commit |
|---|---|---|---|---|---|---|---|---|---|
";

fn head(mutants: &[Mutant], outcomes: &Outcomes, machine: &str) -> String {
    let count = |word: &str| mutants.iter().filter(|m| verdict(m, outcomes) == word).count();
    let [n_caught, n_before, n_not_run] = ["caught", "caught before", "not run"].map(count);
    format!(
        "# Mutants\n\nThis page says which wrong constants and signs the claims of each crate notice. \
         Written by `cargo xtask audit claims --record`: {} mutants, {n_caught} caught, {n_before} caught before a change, {} survived, {n_not_run} not run. {machine}.\n\n\
         Each mutant replaces one text in one file (`xtask/src/audit/mutants.json`). The workspace is built with it, and the \
         cases of its crate are run. A mutant is caught if a claim of accuracy fails or a case stops with an error; a mutant \
         that breaks a structure, also by a structural claim. A regression bound alone catches nothing.\n\n\
         `cargo xtask audit claims --only NAME` repeats a row; *seconds* is its share of the build and the run. An outcome counts \
         as long as the mutant, the file that it changes and the files of its cases stay the same; after a change of one of \
         them it is *caught before*, at its *commit*. `cargo xtask audit claims --missing` runs those again.\n",
        mutants.len(),
        mutants.len() - n_caught - n_before - n_not_run,
    )
}

fn row(mutant: &Mutant, outcomes: &Outcomes) -> String {
    let kind = if mutant.breaks == Breaks::Structure { " (structure)" } else { "" };
    let start = format!("| {} | {}{kind} ", mutant.name, mutant.what);
    let Some(Kept { commit, outcome, .. }) = outcomes.last_of(mutant) else {
        return format!("{start}| not run | | | | | | | |\n");
    };
    let said = if outcome.fault.is_empty() {
        format!("`{}`", outcome.first)
    } else {
        outcome.fault.replace('|', "\\|")
    };
    format!(
        "{start}| {} | {} | {} | {} | {} | {said} | {:.0} | {commit} |\n",
        verdict(mutant, outcomes),
        outcome.accuracy,
        outcome.structure,
        outcome.regression,
        outcome.stopped,
        outcome.seconds,
    )
}

#[cfg(test)]
mod tests {
    use super::super::mutant::tests::mutant;
    use super::super::outcome::Outcome;
    use super::*;

    #[test]
    fn the_page_counts_what_was_run_and_what_was_caught() {
        let mutants = [
            mutant("a", "smpm", "smpm"),
            mutant("b", "smpm", "smpm"),
            mutant("c", "simd-lanes", "x"),
        ];
        let names = ["a", "b", "c"].map(|name| (name.to_owned(), String::new()));
        let mut outcomes = Outcomes::read(&[], BTreeMap::from(names));
        let caught = Outcome { accuracy: 2, first: "smpm/x/y".into(), ..Outcome::default() };
        outcomes.keep(&mutants[0], "1234".into(), caught);
        outcomes.keep(&mutants[1], "1234".into(), Outcome { regression: 1, ..Outcome::default() });
        let page = render(&mutants, &outcomes, "a machine");
        for expected in [
            "3 mutants, 1 caught, 0 caught before a change, 1 survived, 1 not run. a machine.",
            "| smpm | 2 | 1 | 0 | 1 | 0 |",
            "| simd-lanes | 1 | 0 | 0 | 0 | 1 |",
            "| a | a constant | caught | 2 | 0 | 0 | 0 | `smpm/x/y` | 0 | 1234 |",
            "| b | a constant | SURVIVED | 0 | 0 | 1 |",
            "| c | a constant | not run |",
        ] {
            assert!(page.contains(expected), "{expected} is missing from\n{page}");
        }
        assert!(table(&mutants, &outcomes).starts_with("caught    a "));
    }
}
