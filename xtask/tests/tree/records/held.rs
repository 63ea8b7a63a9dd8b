//! The rule for pages that state measurements: a percentage, or a number with a negative exponent, has a key behind it.
//!
//! Exempt are code, formulas, and what a page marks otherwise:
//!
//! - a block is measured once if it or its heading says so ("measured once", "prototype" or "trial"); a table or a list also
//!   if the paragraph before it does. "Measured once" is followed by the day, as in "measured once, 2026-11-24";
//! - a page is, if it says "numbers of this page were measured once";
//! - `<!-- setting -->`, `<!-- printed -->` or `<!-- derived -->` in a line exempts that line, and alone on a line the
//!   block below: a size or tolerance, a number that a publication prints, a closed form or its evaluation.

use std::collections::BTreeMap;

/// What a line that is no measurement is marked with.
const MARKS: [&str; 3] = ["<!-- setting -->", "<!-- printed -->", "<!-- derived -->"];
/// What a page calls a measurement that no record holds.
const ONCE: [&str; 3] = ["measured once", "prototype", "trial"];

/// A page's lines that state a number without a key, each with its number and text.
pub(crate) fn without_key(page: &str, keys: &BTreeMap<String, String>) -> Vec<String> {
    let text = page.split("<!-- records").next().unwrap_or_default();
    if text.contains("numbers of this page were measured once") {
        return Vec::new();
    }
    let (mut found, mut code) = (Vec::new(), false);
    // Whether the heading, the paragraph before the block, and the block say that they are measured once.
    let (mut heading, mut before, mut exempt) = (false, false, false);
    let lines: Vec<&str> = text.lines().collect();
    for (i, line) in lines.iter().enumerate() {
        let begins = i == 0 || lines[i - 1].trim().is_empty();
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        if begins && !line.trim().is_empty() && !code {
            let mut block = lines[i..].iter().take_while(|line| !line.trim().is_empty());
            let (marked, once) = (MARKS.contains(&line.trim()), block.any(|line| is_once(line)));
            // A paragraph introduces the table or the list below it.
            let is_below = line.starts_with(['|', '-']);
            (exempt, before) = (marked || once || (before && is_below), once && !is_below);
        }
        if code || fence {
            before = false;
            continue;
        }
        if line.starts_with('#') {
            (heading, before) = (is_once(line), false);
        }
        let marked = MARKS.iter().any(|mark| line.contains(mark));
        if !(heading || exempt || marked) {
            let bare = measured(line, keys);
            found.extend(bare.into_iter().map(|number| format!("{}: {number}: {line}", i + 1)));
        }
    }
    found
}

/// The lines that say "measured once" and not on which day. In quotation marks the words are explained.
pub(crate) fn undated(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (number, line) in page.lines().enumerate() {
        let lower = line.to_lowercase();
        let is_dated =
            |rest: &str| rest.starts_with('"') || rest.strip_prefix(", ").is_some_and(is_day);
        if !lower.split(ONCE[0]).skip(1).all(is_dated) {
            found.push(format!("{}: {line}", number + 1));
        }
    }
    found
}

/// Whether a text begins with a day of the form 2026-11-24.
fn is_day(text: &str) -> bool {
    let form = "dddd-dd-dd";
    let fits = |(c, f): (char, char)| if f == 'd' { c.is_ascii_digit() } else { c == f };
    text.len() >= form.len() && text.chars().zip(form.chars()).all(fits)
}

fn is_once(line: &str) -> bool {
    let line = line.to_lowercase();
    ONCE.iter().any(|words| line.contains(words))
}

/// Numbers of a line that look measured and have no key.
fn measured(line: &str, keys: &BTreeMap<String, String>) -> Vec<String> {
    let line = without_code_and_formulas(line);
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | '-' | '+');
    let mut bare = Vec::new();
    let mut rest = line.as_str();
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let end = rest[start..].find(|c| !is_part(c)).map_or(rest.len(), |length| start + length);
        let (number, after) = (&rest[start..end], &rest[end..]);
        let exponent = number
            .split_once("e-")
            .is_some_and(|(_, power)| power.starts_with(|c: char| c.is_ascii_digit()));
        let percentage = after.starts_with(" %");
        let after_unit = after.strip_prefix(" %").unwrap_or(after).trim_start_matches('*');
        let key = after_unit.strip_prefix("<!-- ").and_then(|key| key.split(" -->").next());
        if (exponent || percentage) && !key.is_some_and(|key| keys.contains_key(key)) {
            bare.push(format!("{number}{}", if percentage { " %" } else { "" }));
        }
        rest = after;
    }
    bare
}

/// A line without code spans, formulas and the texts and targets of pictures.
fn without_code_and_formulas(line: &str) -> String {
    let picture = line.trim_start().starts_with("![");
    let line = if picture { "" } else { line };
    let mut text = String::new();
    for (i, part) in line.split('`').enumerate() {
        text.push_str(if i % 2 == 0 { part } else { "x" });
    }
    let formulas = text.split('$').step_by(2).collect::<Vec<_>>();
    formulas.join("x")
}

#[test]
fn a_measured_number_without_a_key_is_found() {
    let keys = BTreeMap::from([("k".to_owned(), "a/b error".to_owned())]);
    let found = |page: &str| without_key(page, &keys).len();
    assert_eq!(found("It is off by 3 %, then by 2e-5."), 2);
    assert_eq!(found("It is off by **3 %**<!-- k -->, then by 2e-5<!-- k -->."), 0);
    assert_eq!(found("It is off by 3 %<!-- other -->."), 1);
    assert_eq!(found("`P = 1e-3` and $10^{-3} = 1e-3$, of 1e4 samples"), 0);
    assert_eq!(found("```\n1e-3\n```\n1e-3\n"), 1);
    assert_eq!(found("a step of 1 %<!-- setting -->\n\nand 2 %"), 1);
    assert_eq!(found("<!-- printed -->\n| 1 % |\n| 2 % |\n\n| 3 % |"), 1);
    assert_eq!(found("Measured once:\n\n| 1 % |\n| 2 % |\n\nand 3 %"), 1);
    assert_eq!(found("Measured once: 1 %\nand 2 %\n"), 0);
    assert_eq!(found("Measured once: 1 %\n\nand 2 %\n"), 1);
    assert_eq!(found("# Costs, measured once\n\n1 %\n\n2 %\n\n# Errors\n\n3 %"), 1);
}

#[test]
fn a_measurement_without_its_day_is_found() {
    assert_eq!(
        undated("Measured once, 2026-11-24: 3 %\n(measured once, 2026-11-24 to 2026-11-25)"),
        [""; 0]
    );
    assert_eq!(undated("a\nit was measured once: 3 %"), ["2: it was measured once: 3 %"]);
    assert_eq!(undated("measured once, 2026-11: 3 %").len(), 1);
    assert_eq!(undated("measured once, 2026-11-24, then measured once more").len(), 1);
    assert_eq!(undated("\"Measured once\" means that no claim holds it"), [""; 0]);
}
