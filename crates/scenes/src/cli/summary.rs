//! The last lines of a run: its answers with their errors, what to know of them, and what was written.

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use result_figures::number::counted;
use result_pages::Note;
use scene_runs::kind::{Finished, Found};

/// What a run prints at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// Answers, notes and files in a few lines.
    Answers,
    /// The paths of the files, one a line.
    Paths,
}

/// Prints what a run has found and written.
///
/// # Errors
/// Why a file could not be written, after the answers.
pub(super) fn print_finished(
    finished: Finished,
    ending: Ending,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let code = print(&finished.files, finished.found.as_ref(), ending, output)?;
    finished.unwritten.map_or(Ok(code), |error| Err(error.into()))
}

/// Prints what was found and written. A shard, or a rank without results, has paths alone.
pub(super) fn print(
    files: &[PathBuf],
    found: Option<&Found>,
    ending: Ending,
    output: &mut dyn Write,
) -> miette::Result<ExitCode> {
    let text = match found.filter(|_| ending == Ending::Answers) {
        Some(found) => summary(found, files),
        None => {
            files.iter().fold(String::new(), |text, path| text + &path.display().to_string() + "\n")
        }
    };
    output.write_all(text.as_bytes()).map_err(miette::Report::from_err)?;
    Ok(ExitCode::SUCCESS)
}

fn summary(found: &Found, written: &[PathBuf]) -> String {
    let row = |answer: result_pages::Answer| {
        let at = if answer.at.is_empty() { String::new() } else { format!(", {}", answer.at) };
        let unit = if answer.unit.is_empty() { String::new() } else { format!(" {}", answer.unit) };
        let value = format!("{}{unit}", answer.value_and_error());
        [format!("{}{at}", answer.quantity), value, answer.how]
    };
    let rows: Vec<[String; 3]> = found.answers.headlines().map(|it| row(it.shown())).collect();
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
    if let Some(page) = written.last() {
        let others = counted(written.len() - 1, "file");
        let _ = writeln!(text, "written: {}, in a folder with {others} more", page.display());
    }
    text
}

/// Largest number of notes on the terminal.
const MOST_NOTES: usize = 2;

#[cfg(test)]
mod tests {
    use super::*;
    use scene_runs::answers::{Answer, AnswerValue, Answers, Number, Role, Statistic};

    fn answer(words: &str, error: Option<f64>) -> Answer {
        let last = AnswerValue::at(10.0, Number::sampled(0.0412345, error));
        let answer = Answer::new(words.to_owned(), words.to_owned(), Statistic::Mean, last);
        Answer { unit: "m".to_owned(), time_unit: "s", role: Role::Headline, ..answer }
    }

    #[test]
    fn answers_come_with_errors_then_warnings_then_the_page() {
        let further = Answer { role: Role::Compared, ..answer("E[q^2]", None) };
        let list = vec![answer("E[q]", Some(1.2e-3)), answer("longer", None), further];
        let found = Found {
            answers: Answers { cpu_seconds: 1.0, list },
            notes: vec![
                Note::Remark("b".into()),
                Note::Warning("a".into()),
                Note::Remark("b".into()),
            ],
        };
        let written = ["out/result.json", "out/a.svg", "out/index.html"].map(PathBuf::from);
        let text = summary(&found, &written);
        let expected = "\
E[q], t = 10 s    0.0412 ± 0.0012 m  standard error of the samples
longer, t = 10 s  0.0412345 m        no error estimate
warning: a
note: b
written: out/index.html, in a folder with 2 files more
";
        assert_eq!(text, expected);
    }

    #[test]
    fn without_a_result_the_paths_are_printed() {
        let mut output = Vec::new();
        print(&["out/shard-1-of-2.bin".into()], None, Ending::Answers, &mut output).unwrap();
        assert_eq!(output, b"out/shard-1-of-2.bin\n");
    }
}
