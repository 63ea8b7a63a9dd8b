//! Language check of pages, comments and messages: standard terms, short sentences, short lines.
//!
//! It reads the prose of Markdown pages, and the comments and strings of Rust files. Generated pages are excluded, because
//! their text comes from the sources. `language/pending.txt` holds the allowed findings of each file; a count may only
//! decrease.

mod words;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::folder::{root, texts};
use words::{ENTRIES, NO_VERBS, VERBS};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Largest length of a page's line, in characters.
const LONGEST_LINE: usize = 400;
/// Largest length of a sentence, in words.
const LONGEST_SENTENCE: usize = 40;
/// Clipped sentences in all comments; it may only decrease.
const MOST_CLIPPED: usize = 35;

/// Pages that a command generates from sources checked here.
const GENERATED: [&str; 6] = [
    "docs/verification.md",
    "docs/benchmarks.md",
    "docs/scenes.md",
    "docs/charts/",
    "docs/mutants.md",
    "CHANGELOG.md",
];

/// Files that list the avoided words.
const ABOUT_WORDS: [&str; 2] =
    ["xtask/tests/tree/language.rs", "xtask/tests/tree/language/words.rs"];

// ---- prose ----

/// A piece of prose: the number of its first line, and its text without code.
#[derive(Debug, PartialEq)]
struct Prose {
    line: usize,
    text: String,
}

/// Removes code spans and the targets of links.
fn without_code(line: &str) -> String {
    let spans: Vec<&str> = line.split('`').collect();
    let mut text = spans.iter().step_by(2).copied().collect::<Vec<_>>().join("x");
    while let Some((start, end)) = text
        .find("](")
        .and_then(|start| text[start..].find(')').map(|length| (start + 1, start + length + 1)))
    {
        text.replace_range(start..end, "");
    }
    text
}

/// Lines of prose on a page: paragraphs, list items, headings and rows of tables.
fn of_page(page: &str) -> Vec<Prose> {
    let (mut all, mut code, mut comment): (Vec<Prose>, bool, bool) = (Vec::new(), false, false);
    for (i, line) in page.lines().enumerate() {
        comment |= line.starts_with("<!--");
        if line.trim_start().starts_with("```") {
            code = !code;
        } else if !code && !comment && !line.trim().is_empty() {
            all.push(Prose { line: i + 1, text: without_code(&without_comments(line)) });
        }
        comment &= !line.ends_with("-->");
    }
    all
}

/// A line as a reader sees it: keys of records are comments.
fn without_comments(line: &str) -> String {
    let mut parts = line.split("<!--");
    let first = parts.next().unwrap_or_default();
    let rest = parts.map(|part| part.split_once("-->").map_or("", |(_, shown)| shown));
    std::iter::once(first).chain(rest).collect()
}

/// Comments of a source, with adjacent lines joined, and its strings.
fn of_source(source: &str) -> Vec<Prose> {
    let (mut all, mut last_comment): (Vec<Prose>, usize) = (Vec::new(), 0);
    let mut code = false;
    for (i, line) in source.lines().enumerate() {
        let trimmed = line.trim_start();
        if let Some(rest) = trimmed.strip_prefix("//") {
            let text = rest.trim_start_matches(['/', '!']).trim();
            code ^= text.starts_with("```");
            let is_prose = !code && !text.starts_with("```");
            match all.last_mut() {
                Some(prose) if is_prose && last_comment == i && continues(text) => {
                    prose.text.push(' ');
                    prose.text.push_str(&without_code(text));
                }
                _ if is_prose => all.push(Prose { line: i + 1, text: without_code(text) }),
                _ => {}
            }
            last_comment = i + 1;
        } else {
            code = false;
            let strings: Vec<&str> = line.split('"').skip(1).step_by(2).collect();
            // A sentence contains a space; a key or a path contains none.
            let sentences = strings.into_iter().filter(|text| text.contains(' '));
            all.extend(sentences.map(|text| Prose { line: i + 1, text: without_code(text) }));
        }
    }
    all
}

fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with("//")
}

/// Whether a line of a comment continues the sentence before it.
fn continues(text: &str) -> bool {
    !text.is_empty() && !text.starts_with(['-', '|', '#', '$', '*'])
}

// ---- findings ----

/// Words of a text in small letters, with sentence separators as separate words.
fn words_of(text: &str) -> Vec<String> {
    let is_inside = |c: char| c.is_alphanumeric() || matches!(c, '\'' | '-');
    let (mut all, mut word) = (Vec::new(), String::new());
    for c in text.chars().chain([' ']) {
        // A full stop inside a word or a number does not end it.
        if is_inside(c) || (c == '.' && !word.is_empty()) {
            word.extend(c.to_lowercase());
        } else {
            let bare = word.trim_end_matches('.');
            let ends = bare.len() < word.len() && !bare.contains('.');
            let kept = if bare.contains('.') { &word[..] } else { bare };
            all.extend(Some(kept.to_owned()).filter(|kept| !kept.is_empty()));
            if ends || matches!(c, '.' | ':' | ';' | '?' | '!' | '|') {
                all.push(".".to_owned());
            }
            word.clear();
        }
    }
    all
}

/// Avoided phrases in a text, each with its replacement.
fn avoided(text: &str) -> Vec<(&'static str, &'static str)> {
    let words = words_of(text);
    let mut found = Vec::new();
    for entry in ENTRIES {
        for &phrase in entry.avoid {
            let wanted: Vec<&str> = phrase.split(' ').collect();
            let times = words.windows(wanted.len()).filter(|window| *window == wanted).count();
            found.extend(std::iter::repeat_n((phrase, entry.write), times));
        }
    }
    found
}

/// Word counts of sentences that are too long; display formulas between `$$` do not count.
fn long_sentences(text: &str) -> Vec<usize> {
    let prose: Vec<&str> = text.split("$$").step_by(2).collect();
    let words = words_of(&prose.join("."));
    let lengths = words.split(|word| word == ".").map(<[String]>::len);
    lengths.filter(|&length| length > LONGEST_SENTENCE).collect()
}

/// Sentences of a comment after another one that are clipped: at most ten words without a verb.
///
/// A word other than the first that ends in `s` counts as a verb unless [`NO_VERBS`] has it, so that few sentences are found
/// wrongly. The first sentence may be a noun phrase.
fn clipped(text: &str) -> Vec<String> {
    let (mut found, mut before) = (Vec::new(), "");
    for sentence in text.split_inclusive(". ").map(str::trim) {
        let words = words_of(sentence);
        let words: Vec<&str> =
            words.iter().map(String::as_str).filter(|word| *word != ".").collect();
        let is_verb = |(place, word): (usize, &&str)| {
            let is_third_person = place > 0 && word.len() > 3 && word.ends_with('s');
            VERBS.contains(word) || (is_third_person && !NO_VERBS.contains(word))
        };
        let is_clipped = before.ends_with('.')
            && sentence.ends_with('.')
            && sentence.starts_with(char::is_uppercase)
            && !sentence.contains([':', '='])
            && (1..=10).contains(&words.len())
            && !words.iter().enumerate().any(is_verb);
        found.extend(is_clipped.then(|| sentence.to_owned()));
        before = sentence;
    }
    found
}

/// Findings in a file, one line each.
fn found_in(path: &str, text: &str) -> Vec<String> {
    let is_page = Path::new(path).extension().is_some_and(|ending| ending == "md");
    let mut found = Vec::new();
    for Prose { line, text } in if is_page { of_page(text) } else { of_source(text) } {
        for (phrase, write) in avoided(&text) {
            found.push(format!("{path}:{line}: `{phrase}`: write {write}"));
        }
        for length in long_sentences(&text) {
            found.push(format!(
                "{path}:{line}: a sentence of {length} words; {LONGEST_SENTENCE} at most"
            ));
        }
    }
    if is_page {
        for (i, line) in text.lines().enumerate() {
            let length = without_comments(line).chars().count();
            if length > LONGEST_LINE {
                found
                    .push(format!("{path}:{}: {length} characters; {LONGEST_LINE} at most", i + 1));
            }
        }
    }
    found
}

// ---- the tree ----

/// Counts of `pending.txt` by path.
fn pending(text: &str) -> BTreeMap<String, usize> {
    let entry = |line: &str| {
        let (count, path) = line.split_once(' ')?;
        Some((path.to_owned(), count.parse().ok()?))
    };
    text.lines().filter_map(entry).collect()
}

/// Findings in every checked file, by its path from the root.
fn found_in_tree() -> std::io::Result<BTreeMap<String, Vec<String>>> {
    let mut all = BTreeMap::new();
    for ending in [".md", ".rs"] {
        for (path, text) in texts(&root(), ending)? {
            let is_left_out = |part: &&str| path.starts_with(*part) || path.ends_with(*part);
            if !GENERATED.iter().chain(&ABOUT_WORDS).any(is_left_out) {
                let found = found_in(&path, &text);
                all.insert(path, found);
            }
        }
    }
    Ok(all)
}

/// Findings do not exceed the pending counts.
///
/// `LANGUAGE_RECORD=1 cargo test -p xtask --test tree language` rewrites the counts, after they have decreased.
/// `LANGUAGE_SHOW=PATH` lists the findings in files whose paths begin with `PATH`.
#[test]
fn pages_comments_and_messages_use_the_words_of_the_field() -> Outcome {
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tree/language/pending.txt");
    let allowed = pending(&fs::read_to_string(&list).unwrap_or_default());
    let tree = found_in_tree()?;
    assert!(tree.len() > 500, "only {} files were read", tree.len());
    if std::env::var_os("LANGUAGE_RECORD").is_some() {
        let left = tree.iter().filter(|(_, found)| !found.is_empty());
        let lines: Vec<String> =
            left.map(|(path, found)| format!("{} {path}\n", found.len())).collect();
        fs::write(&list, lines.concat())?;
        return Ok(());
    }
    if let Ok(prefix) = std::env::var("LANGUAGE_SHOW") {
        let shown = tree.iter().filter(|(path, _)| path.starts_with(&prefix));
        let lines: Vec<&str> = shown.flat_map(|(_, found)| found).map(String::as_str).collect();
        return Err(format!("\n{}\n{} in all", lines.join("\n"), lines.len()).into());
    }
    let rose =
        tree.iter().filter(|(path, found)| found.len() > allowed.get(*path).copied().unwrap_or(0));
    let lines: Vec<&str> = rose.flat_map(|(_, found)| found).map(String::as_str).collect();
    assert!(lines.is_empty(), "more than before in these files:\n{}", lines.join("\n"));
    let gone: Vec<&String> = allowed.keys().filter(|path| !tree.contains_key(*path)).collect();
    assert!(gone.is_empty(), "pending.txt names files that are not there: {gone:?}");
    Ok(())
}

/// `LANGUAGE_SHOW=1 cargo test -p xtask --test tree language clipped` lists them.
#[test]
fn comments_have_fewer_clipped_sentences_than_before() -> Outcome {
    let mut found = Vec::new();
    let all = texts(&root(), ".rs")?.into_iter();
    for (path, source) in all.filter(|(path, _)| !ABOUT_WORDS.contains(&path.as_str())) {
        // Strings have titles and names of authors.
        let lines = source.lines().map(|line| if is_comment(line) { line } else { "" });
        for Prose { line, text } in of_source(&lines.collect::<Vec<_>>().join("\n")) {
            let of_line = clipped(&text).into_iter();
            found.extend(of_line.map(|sentence| format!("{path}:{line}: {sentence}")));
        }
    }
    let is_shown = std::env::var_os("LANGUAGE_SHOW").is_some();
    assert!(found.len() <= MOST_CLIPPED && !is_shown, "{}: {found:#?}", found.len());
    Ok(())
}

#[test]
fn what_a_reader_would_stumble_over_is_found() {
    let found = |text: &str| avoided(&without_code(text)).len();
    assert_eq!(found("The mean run stands here."), 2);
    assert_eq!(found("It says where `stands` is code, and bystanders stay."), 0);
    assert_eq!(found("a C.V. of 0.1, equal to roundoff"), 2);
    let long = "word ".repeat(41);
    assert_eq!(long_sentences(&long), [41]);
    assert_eq!(long_sentences(&format!("{long}. short")), [41]);
    assert_eq!(long_sentences(&"a number of 1.5 words. ".repeat(30)), [0; 0]);
    assert_eq!(long_sentences(&format!("$$ {long} $$")), [0; 0]);
    assert_eq!(
        clipped(
            "It has mass. Of the particle alone. Which. Not told. For x it is one. It knows no grid."
        ),
        ["Of the particle alone.", "Which.", "Not told."]
    );
    let page = "<!-- records\nthe mean run\n-->\nno<!-- the mean run --> more\n";
    assert_eq!(found_in("a.md", page).len(), 0);
    let page = format!("# Title\n\n{}\n\n```\nthe mean run\n```\n", "x".repeat(401));
    assert_eq!(found_in("a.md", &page).len(), 1);
    let source = "/// A ledger\n/// of mass.\nlet a = \"has told\"; let ledger = key(\"told\");\n";
    assert_eq!(found_in("a.rs", source).len(), 2);
}
