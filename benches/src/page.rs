//! The page of recorded benchmarks: `docs/benchmarks.md`, from the files in `docs/benchmarks`.

use std::path::Path;

use crate::record::{Measured, RecordError, Recorded, TARGETS, read};
use result_figures::markdown::{table, text};
use scene_runs::machine::{commit_words, short};

/// The page, from the root of the workspace.
pub const PAGE: &str = "docs/benchmarks.md";

/// The file of a target, from the root of the workspace.
#[must_use]
pub fn file_of(target: &str) -> String {
    format!("docs/benchmarks/{target}.json")
}

const HEAD: &str = "\
# Benchmarks

Written by `cargo xtask bench [NAME]... --record`; do not edit. What limits these numbers, and rivals from elsewhere, stand on a page [of their own](performance.md).

CPU time of the process, on one thread unless a name says otherwise. Of works with a rival: contenders take turns, the ratio is the median over the rounds, with its quartiles; M/s are millions of pairs, points, particles or bonds a second, ours; a target is reached if it is not above the lower quartile, `about` if it lies between them. Criterion: median with its interval of 95 %. Load is that of the last minute before and after, in processes that want to run: above the number of cores times err upwards, ratios less.

A section is stale where `git diff --stat COMMIT HEAD -- crates benches` shows what it measures.
";

/// Renders the records below a root.
///
/// # Errors
/// Errors of the files.
pub fn render(root: &Path) -> Result<String, RecordError> {
    let mut page = HEAD.to_owned();
    let mut missing = Vec::new();
    for target in TARGETS {
        match read::<Option<Recorded>>(&root.join(file_of(target)))? {
            Some(recorded) => page.push_str(&section(&recorded)),
            None => missing.push(format!("`{target}`")),
        }
    }
    if !missing.is_empty() {
        page.extend(["\n## Not recorded\n\n", &missing.join(", "), ".\n"]);
    }
    Ok(page)
}

fn section(recorded: &Recorded) -> String {
    let Recorded { target, command, cores, instruction_set, load: [before, after], .. } = recorded;
    let cpu = text(recorded.cpu.as_deref().unwrap_or("unknown processor"));
    let date = recorded.date.as_deref().unwrap_or("date unknown");
    let commit = commit_words(Some(&short(&recorded.commit)));
    let mut section = format!(
        "\n## {target}\n\n`{command}`: {commit}, {date}, {cpu}, {cores} cores, {instruction_set}, load {before} to {after}.\n"
    );
    for listed in &recorded.tables.tables {
        let escape = |cells: &Vec<String>| cells.iter().map(|cell| text(cell)).collect::<Vec<_>>();
        let rows: Vec<Vec<String>> = listed.rows.iter().map(escape).collect();
        let listing = table(&escape(&listed.head), &rows);
        section.extend(["\n", &text(&listed.title), "\n\n", &listing]);
    }
    if !recorded.tables.notes.is_empty() {
        section.push('\n');
        for note in &recorded.tables.notes {
            section.extend(["- ", &text(note), "\n"]);
        }
    }
    if !recorded.measured.is_empty() {
        let head = ["criterion", "median", "interval of 95 %", "M/s"].map(String::from);
        let rows: Vec<Vec<String>> = recorded.measured.iter().map(row).collect();
        section.extend(["\n", &table(&head, &rows)]);
    }
    section
}

fn row(measured: &Measured) -> Vec<String> {
    let [low, high] = measured.interval.map(duration);
    // One element per nanosecond is a thousand million per second.
    let rate = measured.elements.map(|n| 1e3 * n as f64 / measured.median);
    vec![
        text(&measured.name),
        duration(measured.median),
        format!("{low} to {high}"),
        rate.map_or_else(|| "-".to_owned(), |rate| format!("{rate:.1}")),
    ]
}

/// Formats a duration in nanoseconds.
fn duration(nanoseconds: f64) -> String {
    let (unit, factor) = match nanoseconds {
        n if n < 1e3 => ("ns", 1.0),
        n if n < 1e6 => ("µs", 1e-3),
        n if n < 1e9 => ("ms", 1e-6),
        _ => ("s", 1e-9),
    };
    format!("{:.3} {unit}", nanoseconds * factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace;

    #[test]
    fn the_page_is_what_its_files_say() {
        let page = std::fs::read_to_string(workspace().join(PAGE)).unwrap();
        assert_eq!(page, render(&workspace()).unwrap());
    }

    #[test]
    fn a_measurement_has_its_interval_and_its_rate() {
        let measured = Measured {
            name: "a|b".into(),
            median: 2.0e6,
            interval: [1.9e6, 2.1e6],
            elements: Some(4_000_000),
        };
        // Four million in two milliseconds are two thousand million per second.
        let expected = ["a\\|b", "2.000 ms", "1.900 ms to 2.100 ms", "2000.0"];
        assert_eq!(row(&measured), expected);
    }
}
