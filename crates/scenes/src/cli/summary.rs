//! The last lines of a run: its answers with their errors, what to know of them, and what was written.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use result_figures::number::counted;
use result_pages::{Answer, Note};
use serde_json::Value;

use crate::built_in::ALL;
use crate::findings::Findings;
use crate::kind::KIND_KEY;

/// What a run prints at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// Answers, notes and files in a few lines.
    Answers,
    /// The paths of the files, one a line.
    Paths,
}

/// Prints what was found and written. A shard, or a rank without results, has paths alone.
pub(super) fn print(
    written: &[PathBuf],
    ending: Ending,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let result = written.iter().find(|path| path.ends_with("result.json"));
    let found =
        result.filter(|_| ending == Ending::Answers).and_then(|path| Some((path, findings(path)?)));
    let text = match found {
        Some((path, found)) => summary(&found, path, written),
        None => written
            .iter()
            .fold(String::new(), |text, path| text + &path.display().to_string() + "\n"),
    };
    output.write_all(text.as_bytes()).map_err(miette::Report::from_err)?;
    Ok(ExitCode::SUCCESS)
}

/// What a result found; none for a result that cannot be read, whose files are then listed.
fn findings(path: &Path) -> Option<Findings> {
    let result: Value = serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()?;
    let solver = result["scene"][KIND_KEY].as_str()?;
    let kind = ALL.iter().find(|kind| kind.solver == solver)?;
    (kind.findings)(&result).ok()
}

fn summary(found: &Findings, result: &Path, written: &[PathBuf]) -> String {
    let row = |answer: &Answer| {
        let at = if answer.at.is_empty() { String::new() } else { format!(", {}", answer.at) };
        let unit = if answer.unit.is_empty() { String::new() } else { format!(" {}", answer.unit) };
        [
            format!("{}{at}", answer.quantity),
            format!("{}{unit}", answer.value_and_error()),
            answer.how.clone(),
        ]
    };
    let rows: Vec<[String; 3]> = found.answers.iter().map(row).collect();
    let width =
        |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let (first, second) = (width(0), width(1));
    let mut text = String::new();
    for [quantity, value, how] in &rows {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{quantity:<first$}  {value:<second$}  {how}");
    }
    let mut notes = found.notes.clone();
    notes.sort();
    notes.dedup();
    for note in notes.iter().take(MOST_NOTES) {
        let kind = if matches!(note, Note::Warning(_)) { "warning" } else { "note" };
        let _ = writeln!(text, "{kind}: {}", note.text());
    }
    if notes.len() > MOST_NOTES {
        let _ =
            writeln!(text, "and {} on the page", counted(notes.len() - MOST_NOTES, "more note"));
    }
    let page = written.iter().find(|path| path.ends_with("index.html"));
    let shown = page.map_or(result, PathBuf::as_path);
    let more = match found.n_more {
        0 => String::new(),
        n => format!(" with {}", counted(n, "more value")),
    };
    let others = counted(written.len() - 1, "file");
    let _ = writeln!(text, "written: {}{more}, in a folder with {others} more", shown.display());
    text
}

/// Largest number of notes on the terminal.
const MOST_NOTES: usize = 2;

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(quantity: &str, error: Option<f64>) -> Answer {
        Answer {
            quantity: quantity.to_owned(),
            at: "t = 10 s".to_owned(),
            value: 0.0412345,
            error,
            bound: None,
            unit: "m".to_owned(),
            how: "standard error of the samples".to_owned(),
        }
    }

    #[test]
    fn a_bound_is_printed_in_place_of_a_value_and_its_error() {
        let bound = Answer { bound: Some(4.2e-7), ..answer("P(|q| > 2)", Some(2.5e-7)) };
        let found = Findings { answers: vec![bound], ..Findings::default() };
        let written = [PathBuf::from("out/result.json")];
        let text = summary(&found, &written[0], &written);
        assert!(text.starts_with("P(|q| > 2), t = 10 s  < 4.2e-7 m  "), "{text}");
    }

    #[test]
    fn answers_come_with_errors_then_warnings_then_the_page() {
        let found = Findings {
            answers: vec![answer("E[q]", Some(1.2e-3)), answer("longer", None)],
            n_more: 5,
            notes: vec![
                Note::Remark("b".into()),
                Note::Warning("a".into()),
                Note::Remark("b".into()),
            ],
            ..Findings::default()
        };
        let written = ["out/result.json", "out/index.html", "out/a.svg"].map(PathBuf::from);
        let text = summary(&found, &written[0], &written);
        let expected = "\
E[q], t = 10 s    0.0412 ± 0.0012 m  standard error of the samples
longer, t = 10 s  0.0412345 m        standard error of the samples
warning: a
note: b
written: out/index.html with 5 more values, in a folder with 2 files more
";
        assert_eq!(text, expected);
    }

    #[test]
    fn without_a_result_the_paths_are_printed() {
        let mut output = Vec::new();
        print(&["out/shard-1-of-2.bin".into()], Ending::Answers, &mut output).unwrap();
        assert_eq!(output, b"out/shard-1-of-2.bin\n");
    }
}
