//! The table that an audit ends with.

use std::fmt;

/// How a check ended.
#[derive(Debug)]
pub(super) enum Outcome {
    Passed,
    /// With what its program ended.
    Failed(String),
    /// Why it was not run.
    Skipped(String),
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Passed => write!(f, "passed"),
            Self::Failed(how) => write!(f, "failed: {how}"),
            Self::Skipped(reason) => write!(f, "skipped: {reason}"),
        }
    }
}

/// One check and how it ended.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) check: &'static str,
    pub(super) outcome: Outcome,
    /// Wall time (s).
    pub(super) seconds: f64,
}

/// Columns check, outcome and seconds, as wide as their widest entry.
pub(super) fn text(rows: &[Row]) -> String {
    let head = ["check", "outcome", "seconds"].map(str::to_owned);
    let body = rows
        .iter()
        .map(|row| [row.check.to_owned(), row.outcome.to_string(), format!("{:.1}", row.seconds)]);
    let lines: Vec<[String; 3]> = std::iter::once(head).chain(body).collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max();
    let [first, second, third] = [0, 1, 2].map(|column| width(column).unwrap_or(0));
    let line = |[check, outcome, seconds]: &[String; 3]| {
        format!("{check:<first$}  {outcome:<second$}  {seconds:>third$}\n")
    };
    lines.iter().map(line).collect::<Vec<_>>().concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_entry() {
        let rows = [
            Row { check: "deny", outcome: Outcome::Passed, seconds: 1.25 },
            Row {
                check: "features",
                outcome: Outcome::Skipped("no tool".to_owned()),
                seconds: 0.0,
            },
            Row {
                check: "publish",
                outcome: Outcome::Failed("exit 101".to_owned()),
                seconds: 123.4,
            },
        ];
        let expected = "check     outcome           seconds\n\
                        deny      passed                1.2\n\
                        features  skipped: no tool      0.0\n\
                        publish   failed: exit 101    123.4\n";
        assert_eq!(text(&rows), expected);
    }
}
