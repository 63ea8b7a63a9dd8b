//! One line per case with its worst claims and those that fail, or one row per claim, in columns that stay aligned from case to case.

use std::io::{self, IsTerminal, Write};

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table, Width, presets};
use result_figures::{ErrorKind, number};

use crate::report::{CaseRecord, Claim, ClaimKind, Counts, Report};

/// Repeats the method of the row above.
const DITTO: &str = "\"";
/// The width of a number of claims.
const COUNT: usize = 6;
/// Rows are indented below the heading of their case.
const INDENT: u16 = 2;

/// What is printed of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rows {
    /// One line, and the claims that fail.
    Cases,
    /// All claims.
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

    /// Claim, quantity, method, measured, reference, error, tolerance, seconds, verdict.
    fn claim_columns(self) -> [u16; 9] {
        // Value and uncertainty are side by side where there is room and below each other elsewhere.
        let value = if self.width >= 145 { 20 } else { 12 };
        let numbers = [value, value, 14, 9, 7, 7];
        let gaps = INDENT + 8 * 2;
        let text = self.width - gaps - numbers.iter().sum::<u16>();
        let (claim, quantity) = (text * 2 / 5, text / 4);
        let method = text - claim - quantity;
        [
            claim, quantity, method, numbers[0], numbers[1], numbers[2], numbers[3], numbers[4],
            numbers[5],
        ]
    }
}

/// The names of the columns.
pub(super) fn write_header(style: Style, output: &mut dyn Write) -> io::Result<()> {
    match style.rows {
        Rows::Cases => {
            let names = ["case", "problem", "worst claim of each kind of error: error / tolerance"];
            let last = ["accur.", "struct", "bounds", "seconds", "verdict"];
            write_line(names.map(str::to_owned), last.map(str::to_owned), style, output)?;
        }
        Rows::Claims => {
            let mut table = empty_table();
            table.add_row(vec![
                "claim",
                "quantity",
                "method",
                "measured ± s.e.",
                "reference ± error",
                "error",
                "tolerance",
                "seconds",
                "verdict",
            ]);
            write_table(table, style, output)?;
        }
    }
    writeln!(output, "{}", "-".repeat(usize::from(style.width)))
}

/// One line, or a heading with id and title and one row per claim.
pub(super) fn write_case(
    case: &CaseRecord,
    style: Style,
    output: &mut dyn Write,
) -> io::Result<()> {
    match style.rows {
        Rows::Cases => write_case_line(case, style, output),
        Rows::Claims => write_claims(case, style, output),
    }
}

/// Id, title, the claims that come closest to their tolerances, how many of each kind hold, seconds and verdict; then each claim
/// that fails.
fn write_case_line(case: &CaseRecord, style: Style, output: &mut dyn Write) -> io::Result<()> {
    let Counts { accuracy, structural, regression_bounds, failed, .. } = Counts::of(&case.claims);
    let verdict = if failed == 0 { "pass" } else { "FAIL" };
    let words = [case.id.clone(), case.title.clone(), worst(case)];
    let [a, b, c] = [accuracy, structural, regression_bounds].map(|count| count.to_string());
    let last = [a, b, c, format!("{:.2}", case.seconds), verdict.to_owned()];
    write_line(words, last, style, output)?;
    for claim in case.claims.iter().filter(|claim| !claim.passed) {
        writeln!(output, "  FAIL {}: {}", claim.id, claim.reason)?;
    }
    write_skipped(case, output)
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

fn write_skipped(case: &CaseRecord, output: &mut dyn Write) -> io::Result<()> {
    for skipped in &case.skipped {
        writeln!(output, "  SKIPPED {skipped}")?;
    }
    Ok(())
}

/// A heading with id and title, then one row per claim.
fn write_claims(case: &CaseRecord, style: Style, output: &mut dyn Write) -> io::Result<()> {
    writeln!(output, "{}: {}", case.id, case.title)?;
    let mut table = empty_table();
    let name_width = usize::from(style.claim_columns()[0]);
    let mut method_above = "";
    for (i, claim) in case.claims.iter().enumerate() {
        // The claims of a case share its run, so its time is printed once, in the first row.
        let seconds = if i == 0 { format!("{:.2}", case.seconds) } else { String::new() };
        let mut row = cells(claim, &case.id, seconds, name_width);
        if !claim.method.is_empty() && claim.method == method_above {
            row[2] = DITTO.into();
        }
        table.add_row(row);
        method_above = &claim.method;
    }
    write_table(table, style, output)?;
    for claim in case.claims.iter().filter(|claim| is_case_error(claim)) {
        writeln!(output, "  {}", claim.reason)?;
    }
    write_skipped(case, output)?;
    writeln!(output)
}

/// Such a row has no numbers; what it has to say needs the whole width.
fn is_case_error(claim: &Claim) -> bool {
    claim.measured.is_none() && claim.method.is_empty()
}

fn cells(claim: &Claim, case_id: &str, seconds: String, name_width: usize) -> Vec<String> {
    let name = claim.id.strip_prefix(case_id).unwrap_or(&claim.id).trim_start_matches('/');
    let quantity = match &claim.unit {
        Some(unit) => format!("{} ({unit})", claim.quantity),
        None => claim.quantity.clone(),
    };
    vec![
        broken_at_slashes(name, name_width),
        quantity,
        claim.method.clone(),
        number::with_uncertainty(claim.measured, claim.standard_error),
        number::with_uncertainty(claim.reference, claim.reference_error),
        measure(claim),
        number::short(claim.tolerance),
        seconds,
        verdict(claim).into(),
    ]
}

/// The verdict; a claim that holds and is not of accuracy is named by its kind.
const fn verdict(claim: &Claim) -> &'static str {
    match (claim.passed, claim.kind) {
        (false, _) => "FAIL",
        (true, Some(ClaimKind::Structural)) => "struct.",
        (true, Some(ClaimKind::RegressionBound)) => "bound",
        (true, _) => "pass",
    }
}

/// The error, with a word for how it was formed.
fn measure(claim: &Claim) -> String {
    let error = number::error(claim.error, claim.error_kind);
    let word = short_name(claim.error_kind);
    if claim.error.is_some() { format!("{word} {error}") } else { error }
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

/// A claim's name in lines of at most `width`, each but the last ending in a slash.
fn broken_at_slashes(name: &str, width: usize) -> String {
    let mut text = String::new();
    let mut line_length = 0;
    for part in name.split_inclusive('/') {
        if line_length > 0 && line_length + part.len() > width {
            text.push('\n');
            line_length = 0;
        }
        text.push_str(part);
        line_length += part.len();
    }
    text
}

fn empty_table() -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
    table
}

fn write_table(mut table: Table, style: Style, output: &mut dyn Write) -> io::Result<()> {
    table.set_width(style.width);
    for (i, (column, width)) in table.column_iter_mut().zip(style.claim_columns()).enumerate() {
        let gap = if i < 8 { 2 } else { 0 };
        let indent = if i == 0 { INDENT } else { 0 };
        let fixed = ColumnConstraint::Absolute(Width::Fixed(indent + width + gap));
        column.set_padding((indent, gap)).set_constraint(fixed);
        if (3..8).contains(&i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    for line in table.lines() {
        writeln!(output, "{}", coloured(line.trim_end(), style))?;
    }
    Ok(())
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

/// The claims that did not hold, each with its full id and the reason.
///
/// # Errors
/// Those of writing to `output`.
pub fn write_failures(report: &Report, output: &mut dyn Write) -> io::Result<()> {
    for claim in report.failures() {
        writeln!(output, "FAIL {}\n     {}", claim.id, claim.reason)?;
    }
    Ok(())
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
    fn columns_fill_the_width() {
        for width in [120, 144, 150, 180] {
            let style = Style::plain(width, Rows::Claims);
            let columns = style.claim_columns();
            assert_eq!(columns.iter().sum::<u16>() + INDENT + 16, width);
            assert_eq!(style.case_columns().iter().sum::<usize>() + 14, usize::from(width));
            assert!(columns.iter().all(|&column| column >= 7), "{columns:?}");
        }
    }

    #[test]
    fn names_break_at_slashes() {
        assert_eq!(
            broken_at_slashes("exceedance/cell-integrated/t6", 20),
            "exceedance/\ncell-integrated/t6"
        );
        assert_eq!(broken_at_slashes("second-moment-q/t6", 20), "second-moment-q/t6");
    }

    #[test]
    fn colour_is_beside_the_word_and_only_where_asked_for() {
        let coloured_style = Style { width: 150, colour: true, rows: Rows::Cases };
        assert_eq!(coloured("x  pass", coloured_style), "x  \x1b[32mpass\x1b[0m");
        assert_eq!(coloured("x  FAIL", Style::plain(150, Rows::Cases)), "x  FAIL");
    }
}
