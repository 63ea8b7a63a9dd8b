//! One line a case with its worst claims and those that fail; where asked for, every claim below it.

use std::io::{self, IsTerminal, Write};

use result_figures::{ErrorKind, number};

use crate::report::{CaseRecord, Claim, Counts, Report};

/// The width of a number of claims.
const COUNT: usize = 6;

/// What is printed of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rows {
    /// One line, and the claims that fail.
    Cases,
    /// The same with all claims.
    Claims,
}

/// How wide the table is, whether verdicts are coloured, and what has a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    width: u16,
    colour: bool,
    rows: Rows,
}

impl Style {
    /// The width of the terminal within 120 to 180; 150 and no colour where there is none.
    #[must_use]
    pub fn of_terminal(rows: Rows) -> Self {
        let is_terminal = io::stdout().is_terminal();
        let size = if is_terminal { terminal_size::terminal_size() } else { None };
        let width = size.map_or(150, |(width, _)| width.0.clamp(120, 180));
        Self { width, colour: is_terminal && std::env::var_os("NO_COLOR").is_none(), rows }
    }

    /// A given width and no colour.
    #[must_use]
    pub const fn plain(width: u16, rows: Rows) -> Self {
        Self { width, colour: false, rows }
    }

    /// Case, title, worst claims, claims of accuracy, structural ones, regression bounds, seconds, verdict.
    fn case_columns(self) -> [usize; 8] {
        let (numbers, gaps) = (3 * COUNT + 8 + 5, 7 * 2);
        let text = usize::from(self.width) - numbers - gaps;
        let (id, title) = (text * 3 / 10, text * 3 / 10);
        [id, title, text - id - title, COUNT, COUNT, COUNT, 8, 5]
    }
}

/// The names of the columns.
pub(super) fn write_header(style: Style, output: &mut dyn Write) -> io::Result<()> {
    let names = ["case", "problem", "worst claim of each kind of error: error / tolerance"];
    let last = ["accur.", "struct", "bounds", "seconds", "verdict"];
    write_line(names.map(str::to_owned), last.map(str::to_owned), style, output)?;
    writeln!(output, "{}", "-".repeat(usize::from(style.width)))
}

/// Id, title, the claims that come closest to their tolerances, how many of each kind hold, seconds and verdict; then each claim
/// that fails, or all of them.
pub(super) fn write_case(
    case: &CaseRecord,
    style: Style,
    output: &mut dyn Write,
) -> io::Result<()> {
    let Counts { accuracy, structural, regression_bounds, failed, .. } = Counts::of(&case.claims);
    let verdict = if failed == 0 { "pass" } else { "FAIL" };
    let words = [case.id.clone(), case.title.clone(), worst(case)];
    let [a, b, c] = [accuracy, structural, regression_bounds].map(|count| count.to_string());
    let last = [a, b, c, format!("{:.2}", case.seconds), verdict.to_owned()];
    write_line(words, last, style, output)?;
    for claim in &case.claims {
        if !claim.passed {
            writeln!(output, "  FAIL {}: {}", claim.id, claim.reason)?;
        } else if style.rows == Rows::Claims {
            writeln!(output, "  {}", claim_words(claim))?;
        }
    }
    for skipped in &case.skipped {
        writeln!(output, "  SKIPPED {skipped}")?;
    }
    Ok(())
}

/// Kind, id, quantity, values, error, tolerance, method and reason of a claim that holds.
fn claim_words(claim: &Claim) -> String {
    let unit = claim.unit.as_ref().map_or_else(String::new, |unit| format!(" ({unit})"));
    let reference = match claim.reference {
        Some(_) => {
            let reference = number::with_uncertainty(claim.reference, claim.reference_error);
            let error = number::error(claim.error, claim.error_kind);
            let tolerance = number::short(claim.tolerance);
            format!(" for {reference}, {} {error} of {tolerance}", claim.error_kind.name())
        }
        None => String::new(),
    };
    format!(
        "{} {}: {}{unit} {}{reference}; {}; {}",
        claim.kind.name(),
        claim.id,
        claim.quantity,
        number::with_uncertainty(claim.measured, claim.standard_error),
        claim.method,
        claim.reason
    )
}

/// The largest part of its tolerance that a claim of each kind of error takes: `relative 3.1e-3 / 0.02, log10 0.01 / 0.1`.
fn worst(case: &CaseRecord) -> String {
    let kinds = [
        ErrorKind::Relative,
        ErrorKind::Absolute,
        ErrorKind::Log10,
        ErrorKind::Ratio,
        ErrorKind::Order,
    ];
    let of_kind = |kind: ErrorKind| {
        let claims = case.claims.iter().filter(|claim| claim.error_kind == kind);
        let by_part = claims.filter_map(|claim| Some((claim.used()?, claim)));
        let (_, claim) = by_part.max_by(|(a, _), (b, _)| a.total_cmp(b))?;
        let error = number::error(claim.error.map(f64::abs), kind);
        let error = error.trim_start_matches('+');
        Some(format!("{} {error} / {}", short_name(kind), number::short(claim.tolerance)))
    };
    kinds.into_iter().filter_map(of_kind).collect::<Vec<_>>().join(", ")
}

/// A line of the table of cases; what is too long for its column ends in an ellipsis.
fn write_line(
    words: [String; 3],
    last: [String; 5],
    style: Style,
    output: &mut dyn Write,
) -> io::Result<()> {
    let [id, title, worst, a, b, c, number, word] = style.case_columns();
    let [accuracy, structural, bounds, seconds, verdict] = last;
    let [of_id, of_title, of_worst] = words;
    // An id is what other commands take: it is never cut.
    let title = (title + id).saturating_sub(of_id.chars().count().max(id));
    let line = format!(
        "{of_id:<id$}  {:<title$}  {:<worst$}  {accuracy:>a$}  {structural:>b$}  {bounds:>c$}  {seconds:>number$}  {verdict:<word$}",
        shortened(&of_title, title),
        shortened(&of_worst, worst),
    );
    writeln!(output, "{}", coloured(line.trim_end(), style))
}

fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}

const fn short_name(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::Relative => "rel",
        ErrorKind::Absolute => "abs",
        ErrorKind::Log10 => "log10",
        ErrorKind::Ratio => "factor",
        ErrorKind::Order => "order",
    }
}

/// Green and red beside the words, never instead of them.
fn coloured(line: &str, style: Style) -> String {
    let paint = |word: &str, code: &str| {
        line.strip_suffix(word).map(|rest| format!("{rest}\x1b[{code}m{word}\x1b[0m"))
    };
    let painted =
        if style.colour { paint("pass", "32").or_else(|| paint("FAIL", "1;31")) } else { None };
    painted.unwrap_or_else(|| line.to_owned())
}

/// The claims whose tolerance is loose, each with its error, tolerance and reason; then how many they are.
///
/// # Errors
/// Those of writing to `output`.
pub fn write_loose(report: &Report, output: &mut dyn Write) -> io::Result<()> {
    for claim in report.claims().filter(|claim| claim.is_loose()) {
        writeln!(output, "LOOSE {}", loose_words(claim))?;
    }
    Ok(())
}

/// Id, error, tolerance and reason of a loose claim.
pub(super) fn loose_words(claim: &Claim) -> String {
    let error = number::error(claim.error, claim.error_kind);
    let tolerance = number::short(claim.tolerance);
    format!("{}: error {error}, tolerance {tolerance}: {}", claim.id, claim.reason)
}

/// How many claims are loose, and the last line: `N of accuracy, M structural, K regression bounds; F failed`.
///
/// # Errors
/// Those of writing to `output`.
pub fn write_summary(report: &Report, output: &mut dyn Write) -> io::Result<()> {
    let counts = report.counts();
    let loose = number::counted(counts.loose, "loose claim");
    writeln!(output, "{loose} (tolerance over ten times the error, no reason for it)\n{counts}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_is_beside_the_word_and_only_where_asked_for() {
        let coloured_style = Style { width: 150, colour: true, rows: Rows::Cases };
        assert_eq!(coloured("x  pass", coloured_style), "x  \x1b[32mpass\x1b[0m");
        assert_eq!(coloured("x  FAIL", Style::plain(150, Rows::Cases)), "x  FAIL");
    }
}
