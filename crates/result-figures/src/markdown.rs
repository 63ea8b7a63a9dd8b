//! Markdown output: escaped text and tables.

/// `raw` on one line, with Markdown's special characters escaped.
#[must_use]
pub fn text(raw: &str) -> String {
    let mut escaped = String::with_capacity(raw.len());
    for c in raw.split_whitespace().collect::<Vec<_>>().join(" ").chars() {
        if matches!(c, '|' | '<' | '*' | '~' | '\\') {
            escaped.push('\\');
        }
        escaped.push(c);
    }
    escaped
}

/// A Markdown table; its cells are Markdown already.
#[must_use]
pub fn table(heads: &[String], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule = format!("|{}\n", "---|".repeat(heads.len()));
    let body: String = rows.iter().map(|row| line(row)).collect();
    format!("{}{rule}{body}", line(heads))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_escaped_and_lines_joined() {
        assert_eq!(text("P(|q| > 1)\n < 2*h"), "P(\\|q\\| > 1) \\< 2\\*h");
    }

    #[test]
    fn a_table_has_a_head_a_rule_and_a_line_for_each_row() {
        let words = |list: [&str; 2]| list.map(str::to_owned).to_vec();
        let written = table(&words(["a", "b"]), &[words(["1", "2"]), words(["3", "4"])]);
        assert_eq!(written, "| a | b |\n|---|---|\n| 1 | 2 |\n| 3 | 4 |\n");
    }
}
