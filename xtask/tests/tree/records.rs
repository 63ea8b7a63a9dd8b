//! The numbers that pages state are those of the records.
//!
//! A page marks a number with a key in a comment behind it, and lists its keys in a comment of their own:
//!
//! ```text
//! E[q^2] is off by 0.22 %<!-- damper-q -->.
//!
//! <!-- records
//! damper-q: fpk-sph/viscous-damper-refined/log-density-fit/second-moment-q/t6 |error|
//! taichi: docs/benchmarks/smpm.json /rows/3/ratio
//! -->
//! ```
//!
//! A source is a claim of `docs/verification.json` with one of its numbers (`measured`, `error`, `reference`,
//! `standard_error`, one between bars for its size, or `standard_error/reference` for a quotient), a case with
//! `cpu_seconds`, or a file with a pointer into it.
//! A number in percent is a hundred times its record, one in ms a thousand times.
//!
//! | source | the page states |
//! |---|---|
//! | `a/b/c error` | the record, rounded |
//! | `a/*/c error` | of all claims that match, the record of the largest size |
//! | `at most a/b/c error` | a bound: the size of the record is below it, and no less than a tenth of it |
//!
//! `records/held.rs` finds numbers without a key on the pages that must have one.

mod held;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::folder::{root, texts};
use serde_json::Value;

type Outcome = Result<(), Box<dyn std::error::Error>>;

const RECORD: &str = "docs/verification.json";

// ---- a page ----

/// A number as a page shows it.
#[derive(Debug, PartialEq)]
struct Shown {
    key: String,
    value: f64,
    /// Half a unit of its last digit.
    half_unit: f64,
}

/// The keys of a page, each with its source.
fn keys(page: &str) -> BTreeMap<String, String> {
    let Some((_, rest)) = page.split_once("<!-- records\n") else { return BTreeMap::new() };
    let list = rest.split("-->").next().unwrap_or_default();
    let entry = |line: &str| {
        line.split_once(": ").map(|(key, source)| (key.trim().to_owned(), source.trim().to_owned()))
    };
    list.lines().filter_map(entry).collect()
}

/// The numbers that have a key of the page behind them; an error names a mark without a number before it.
fn shown(page: &str, keys: &BTreeMap<String, String>) -> Result<Vec<Shown>, String> {
    let mut all = Vec::new();
    for (start, _) in page.match_indices("<!-- ") {
        let key = page[start + 5..].split(" -->").next().unwrap_or_default();
        if keys.contains_key(key) {
            let before = page[..start].trim_end_matches('*');
            let (value, half_unit) =
                number_before(before).ok_or_else(|| format!("no number before `{key}`"))?;
            all.push(Shown { key: key.to_owned(), value, half_unit });
        }
    }
    Ok(all)
}

/// The number at the end of a text in the unit of its record, and half a unit of its last digit.
fn number_before(text: &str) -> Option<(f64, f64)> {
    const UNITS: [(&str, f64); 6] =
        [(" %", 1e-2), (" ms", 1e-3), (" µs", 1e-6), (" s", 1.0), (" mm", 1.0), ("", 1.0)];
    let (text, unit) =
        UNITS.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, size)))?;
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | '-' | '+' | ',');
    let start = text.char_indices().rev().take_while(|&(_, c)| is_part(c)).last()?.0;
    let written = text[start..].trim_start_matches(',').replace(',', "");
    let value: f64 = written.parse().ok()?;
    let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let last = 10_f64.powi(exponent.parse::<i32>().ok()? - i32::try_from(decimals).ok()?);
    Some((value * unit, 0.5 * last * unit))
}

// ---- the records ----

/// Whether a page may show `value`, with `half_unit` of its last digit, for a source; an error says why not.
fn agrees(value: f64, half_unit: f64, source: &str, verification: &Value) -> Result<(), String> {
    let (source, is_bound) =
        source.strip_prefix("at most ").map_or((source, false), |source| (source, true));
    let recorded = recorded(source, verification)?;
    let right = if is_bound {
        (0.1 * value..=value).contains(&recorded.abs())
    } else {
        (recorded - value).abs() <= half_unit * (1.0 + 1e-9)
    };
    let bound = if is_bound { "at most " } else { "" };
    if right { Ok(()) } else { Err(format!("the page has {bound}{value}, the record {recorded}")) }
}

/// The number that a source names; where it has a `*`, the largest in size of those that match.
fn recorded(source: &str, verification: &Value) -> Result<f64, String> {
    let (place, part) = source.rsplit_once(' ').ok_or("no field")?;
    if place.contains('*') {
        let claims = verification["claims"].as_object().ok_or("no claims")?;
        let names = claims.keys().filter(|name| matches(name, place));
        let numbers: Vec<f64> = names
            .map(|name| recorded(&format!("{name} {part}"), verification))
            .collect::<Result<_, _>>()?;
        let largest = numbers.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()));
        return largest.ok_or_else(|| format!("no claim matches `{place}`"));
    }
    let (name, size) = match part.strip_prefix('|').and_then(|part| part.strip_suffix('|')) {
        Some(name) => (name, true),
        None => (part, false),
    };
    let found = if Path::new(place).extension().is_some_and(|ending| ending == "json") {
        let text = fs::read_to_string(root().join(place)).map_err(|error| error.to_string())?;
        let value: Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
        value.pointer(name).and_then(Value::as_f64)
    } else {
        let entry = ["claims", "cases"].iter().find_map(|kind| verification[kind].get(place));
        entry.and_then(|entry| match name.split_once('/') {
            Some((above, below)) => Some(entry[above].as_f64()? / entry[below].as_f64()?),
            None => entry[name].as_f64(),
        })
    };
    let value = found.ok_or_else(|| format!("there is no `{name}` of `{place}`"))?;
    Ok(if size { value.abs() } else { value })
}

/// Whether a name matches a pattern, in which each `*` matches any text.
fn matches(name: &str, pattern: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else { return name == pattern };
    let Some(name) = name.strip_prefix(first) else { return false };
    name.char_indices().any(|(at, _)| matches(&name[at..], rest)) || rest.is_empty()
}

/// What is wrong with the numbers of a page.
fn wrong(page: &str, verification: &Value) -> Vec<String> {
    let keys = keys(page);
    let shown = match shown(page, &keys) {
        Ok(shown) => shown,
        Err(error) => return vec![error],
    };
    let unused = keys.keys().filter(|key| shown.iter().all(|shown| shown.key != **key));
    let mut wrong: Vec<String> =
        unused.map(|key| format!("no number has the key `{key}`")).collect();
    for Shown { key, value, half_unit } in &shown {
        if let Err(error) = agrees(*value, *half_unit, &keys[key], verification) {
            wrong.push(format!("`{key}`: {error}"));
        }
    }
    wrong
}

#[test]
fn numbers_of_pages_are_those_of_the_records() -> Outcome {
    let verification: Value = serde_json::from_str(&fs::read_to_string(root().join(RECORD))?)?;
    let (mut all_wrong, mut n_numbers) = (Vec::new(), 0);
    for (path, page) in texts(&root(), ".md")? {
        n_numbers += shown(&page, &keys(&page)).map_or(0, |shown| shown.len());
        let lines = wrong(&page, &verification);
        all_wrong.extend(lines.into_iter().map(|line| format!("{path}: {line}")));
    }
    assert!(all_wrong.is_empty(), "{all_wrong:#?}");
    assert!(n_numbers >= 200, "only {n_numbers} numbers have a record");
    Ok(())
}

/// Pages on which every measured number has a key: a reader takes them at their word.
fn is_held(path: &str) -> bool {
    const PAGES: [&str; 4] =
        ["README.md", "docs/choosing.md", "docs/performance.md", "docs/errata.md"];
    let of_a_crate = path.starts_with("crates/") && path.ends_with("/README.md");
    PAGES.contains(&path) || of_a_crate || path.starts_with("docs/methods/")
}

#[test]
fn every_measured_number_of_a_held_page_has_a_record() -> Outcome {
    let (mut bare, mut n_pages) = (Vec::new(), 0);
    for (path, page) in texts(&root(), ".md")? {
        if is_held(&path) {
            n_pages += 1;
            let lines = held::without_key(&page, &keys(&page));
            bare.extend(lines.into_iter().map(|line| format!("{path}:{line}")));
        }
    }
    assert!(bare.is_empty(), "numbers without a record:\n{}", bare.join("\n"));
    assert!(n_pages >= 20, "only {n_pages} pages were read");
    Ok(())
}

#[test]
fn what_was_measured_once_has_its_day() -> Outcome {
    let mut bare = Vec::new();
    for (path, page) in texts(&root(), ".md")? {
        let lines = held::undated(&page);
        bare.extend(lines.into_iter().map(|line| format!("{path}:{line}")));
    }
    assert!(bare.is_empty(), "measured once, but not on which day:\n{}", bare.join("\n"));
    Ok(())
}

#[test]
fn a_number_that_differs_from_its_record_is_found() {
    let verification: Value = serde_json::json!({
        "claims": { "a/b/c": { "measured": 1.639e-3, "error": -0.00224 } },
        "cases": { "a/b": { "cpu_seconds": 2.0149 } },
    });
    let of = |text: &str, source: &str| {
        wrong(&format!("{text}<!-- k -->\n\n<!-- records\nk: {source}\n-->\n"), &verification).len()
    };
    assert_eq!(of("it is 1.639e-3", "a/b/c measured"), 0);
    assert_eq!(of("it is 1.64e-3", "a/b/c measured"), 0);
    assert_eq!(of("it is 1.65e-3", "a/b/c measured"), 1);
    assert_eq!(of("off by **0.22 %**", "a/b/c |error|"), 0);
    assert_eq!(of("off by -0.2 %", "a/b/c error"), 0);
    assert_eq!(of("off by 0.2 %", "a/b/c error"), 1);
    assert_eq!(of("in 2.01 s", "a/b cpu_seconds"), 0);
    assert_eq!(of("in 2,015 ms", "a/b cpu_seconds"), 0);
    assert_eq!(of("no number", "a/b cpu_seconds"), 1);
    assert_eq!(of("within 0.3 %", "at most a/b/c error"), 0);
    assert_eq!(of("within 0.2 %", "at most a/b/c error"), 1);
    assert_eq!(of("within 3 %", "at most a/b/c error"), 1);
    assert_eq!(of("off by -0.2 %", "a/*/c error"), 0);
    assert_eq!(of("off by -0.2 %", "a/*/d error"), 1);
    assert_eq!(of("in 2.01 s", "a/x cpu_seconds"), 1);
    assert_eq!(wrong("<!-- records\nk: a/b/c error\n-->\n", &verification).len(), 1);
}
