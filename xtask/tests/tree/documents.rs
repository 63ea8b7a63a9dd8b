//! Code on Markdown pages matches the sources, and links and paths lead to existing files.
//!
//! A page shows an excerpt of a source by a line `<!-- source: PATH#NAME -->`, with the path from the root, and the
//! following code block. In the source the excerpt is between `// docs: NAME` and `// docs: end`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::folder::{root, texts};

type Outcome = Result<(), Box<dyn std::error::Error>>;

// ---- excerpts of sources ----

/// A code block with its source and excerpt.
#[derive(Debug, PartialEq)]
struct Shown {
    path: String,
    name: String,
    code: String,
}

fn shown(page: &str) -> Vec<Shown> {
    let mut lines = page.lines();
    let mut all = Vec::new();
    while let Some(line) = lines.next() {
        let source = line.strip_prefix("<!-- source: ").and_then(|rest| rest.strip_suffix(" -->"));
        if let Some((path, name)) = source.and_then(|source| source.split_once('#')) {
            let fence = lines.next().unwrap_or_default();
            let code =
                lines.by_ref().take_while(|line| *line != "```").map(|line| line.to_owned() + "\n");
            // Without a fence there is no code, which matches no source.
            let code = if fence.starts_with("```") { code.collect() } else { String::new() };
            all.push(Shown { path: path.to_owned(), name: name.to_owned(), code });
        }
    }
    all
}

/// Excerpts of a source by name, without their common indentation.
fn pieces(source: &str) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    let mut open: Option<(&str, Vec<&str>)> = None;
    for line in source.lines() {
        match (line.trim_start().strip_prefix("// docs: "), &mut open) {
            (Some("end"), _) => {
                if let Some((name, lines)) = open.take() {
                    all.insert(name.to_owned(), without_indentation(&lines));
                }
            }
            (Some(name), _) => open = Some((name, Vec::new())),
            (None, Some((_, lines))) => lines.push(line),
            (None, None) => {}
        }
    }
    all
}

fn without_indentation(lines: &[&str]) -> String {
    let indentation = |line: &&str| line.len() - line.trim_start().len();
    let filled = lines.iter().filter(|line| !line.trim().is_empty());
    let common = filled.map(indentation).min().unwrap_or(0);
    lines.iter().map(|line| line.get(common..).unwrap_or_default().to_owned() + "\n").collect()
}

#[test]
fn code_blocks_are_the_text_of_the_sources_they_name() -> Outcome {
    let mut wrong = Vec::new();
    let mut seen = BTreeSet::new();
    for (page, text) in texts(&root(), ".md")? {
        for Shown { path, name, code } in shown(&text) {
            let source = fs::read_to_string(root().join(&path)).unwrap_or_default();
            let same = pieces(&source).get(&name) == Some(&code);
            if !same {
                wrong.push(format!("{page}: differs from `{name}` in {path}"));
            }
            seen.insert((path, name));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(seen.len() >= 10, "only {} pieces of sources are shown", seen.len());
    // An excerpt that no page shows has lost its page.
    for (path, text) in texts(&root().join("crates"), ".rs")? {
        let path = format!("crates/{path}");
        for name in pieces(&text).into_keys() {
            assert!(seen.contains(&(path.clone(), name.clone())), "no page shows {path}#{name}");
        }
    }
    Ok(())
}

#[test]
fn every_page_on_extending_and_every_tutorial_shows_code_that_is_compiled() -> Outcome {
    for folder in ["docs/extend", "docs/tutorials"] {
        let pages = texts(&root().join(folder), ".md")?;
        assert!(pages.len() >= 3, "{folder} has {} pages", pages.len());
        for (page, text) in pages {
            assert!(!shown(&text).is_empty(), "{folder}/{page} shows no piece of a source");
        }
    }
    Ok(())
}

#[test]
fn a_block_that_differs_from_its_source_is_seen() {
    let source =
        "fn a() {\n    // docs: middle\n    one();\n\n        two();\n    // docs: end\n}\n";
    let page = "text\n<!-- source: a.rs#middle -->\n```rust\none();\n\n    two();\n```\n";
    let code = shown(page).remove(0).code;
    assert_eq!(pieces(source)["middle"], code);
    assert_ne!(pieces(&source.replace("two", "three"))["middle"], code);
    assert_eq!(shown("<!-- source: a.rs#middle -->\nno fence\n")[0].code, "");
}

// ---- links ----

/// Targets of the links and pictures of a page, outside code.
fn targets(page: &str) -> Vec<String> {
    let mut all = Vec::new();
    for line in prose(page) {
        let pieces: Vec<&str> = line.split('`').collect();
        // Every second piece is code. The `](` of a link is outside.
        let text: String = pieces.iter().step_by(2).copied().collect::<Vec<_>>().join("");
        for rest in text.split("](").skip(1) {
            if let Some((target, _)) = rest.split_once(')') {
                all.push(target.to_owned());
            }
        }
    }
    all
}

/// Lines of a page outside code.
fn prose(page: &str) -> Vec<&str> {
    let mut code = false;
    page.lines()
        .filter(|line| {
            let fence = line.starts_with("```");
            code ^= fence;
            !fence && !code
        })
        .collect()
}

/// Anchors of a page's headings: small letters, hyphens for spaces, no other characters but underscores.
fn anchors(page: &str) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for heading in prose(page).iter().filter(|line| line.starts_with('#')) {
        let title = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        let name: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let again = (1..=all.len()).map(|n| format!("{name}-{n}"));
        let free = std::iter::once(name.clone()).chain(again).find(|name| !all.contains(name));
        all.extend(free);
    }
    // Anchors without a heading.
    let named = page.split("<a id=\"").skip(1).filter_map(|rest| rest.split_once('"'));
    all.extend(named.map(|(name, _)| name.to_owned()));
    all
}

/// Describes the error of a relative link from a page, if any.
fn broken(page: &Path, text: &str, target: &str) -> Option<String> {
    let elsewhere = ["http://", "https://", "mailto:"].iter().any(|kind| target.starts_with(kind));
    // `crate::Name` is a link of rustdoc, which checks it.
    if elsewhere || target.contains("::") {
        return None;
    }
    let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
    let place = if file.is_empty() { page.to_owned() } else { page.parent()?.join(file) };
    if !place.exists() {
        return Some(format!("{}: {target} is not there", page.display()));
    }
    if anchor.is_empty() {
        return None;
    }
    let there = if file.is_empty() { text.to_owned() } else { fs::read_to_string(&place).ok()? };
    let found = anchors(&there).contains(anchor);
    (!found).then(|| format!("{}: {target} names nothing on it", page.display()))
}

#[test]
fn relative_links_lead_somewhere() -> Outcome {
    let (mut wrong, mut n_links) = (Vec::new(), 0);
    for (page, text) in texts(&root(), ".md")? {
        for target in targets(&text) {
            wrong.extend(broken(&root().join(&page), &text, &target));
            n_links += 1;
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(n_links > 100, "only {n_links} links were found");
    Ok(())
}

#[test]
fn a_link_to_nothing_is_seen() {
    let page = root().join("README.md");
    let text = "# Here it is\n[a](docs/no_such_page.md) ![b](LICENSE-MIT) `[c](code)` [d](#here-it-is) [e](#gone)\n";
    assert_eq!(targets(text), ["docs/no_such_page.md", "LICENSE-MIT", "#here-it-is", "#gone"]);
    let wrong: Vec<bool> =
        targets(text).iter().map(|target| broken(&page, text, target).is_some()).collect();
    assert_eq!(wrong, [true, false, false, true]);
}

// ---- paths ----

/// Folders at the root whose files pages name.
const FOLDERS: [&str; 6] = ["crates/", "tests/", "benches/", "xtask/", "docs/", ".ci/"];

/// Paths from the root in the code spans of a page: up to the first placeholder, `crates/*/tests` to `crates/`.
fn named_paths(page: &str) -> Vec<String> {
    let mut all = Vec::new();
    for line in prose(page) {
        for span in line.split('`').skip(1).step_by(2) {
            if FOLDERS.iter().any(|folder| span.starts_with(folder)) {
                let end = span.find(['<', '*', '{', ' ', '#', '|']).unwrap_or(span.len());
                let kept = &span[..end];
                // A name with a placeholder is reduced to its folder.
                let folder = kept.rfind('/').map_or(kept, |slash| &kept[..slash]);
                all.push(if end < span.len() { folder } else { kept }.to_owned());
            }
        }
    }
    all
}

/// Whether a path exists from the root, from the folder of the page, or from a crate.
///
/// For example, `tests/laws` is that of a crate.
fn is_there(page: &Path, path: &str) -> std::io::Result<bool> {
    let mut starts = vec![root(), page.parent().map(Path::to_owned).unwrap_or_default()];
    for entry in fs::read_dir(root().join("crates"))? {
        starts.push(entry?.path());
    }
    Ok(starts.iter().any(|start| start.join(path).exists()))
}

/// Changelogs refer to earlier states.
#[test]
fn the_files_and_folders_that_pages_name_are_there() -> Outcome {
    let (mut wrong, mut n_paths) = (Vec::new(), 0);
    let pages = texts(&root(), ".md")?.into_iter();
    for (page, text) in pages.filter(|(page, _)| !page.ends_with("CHANGELOG.md")) {
        for path in named_paths(&text) {
            n_paths += 1;
            if !is_there(&root().join(&page), &path)? {
                wrong.push(format!("{page}: {path} is not there"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(n_paths > 50, "only {n_paths} paths were found");
    Ok(())
}

#[test]
fn paths_are_read_up_to_their_placeholders() {
    let page =
        "`crates/smpm/src/<name>.rs`, `tests/scenes/a.json`, `not/a/path`\n```\n`tests/x`\n```\n";
    assert_eq!(named_paths(page), ["crates/smpm/src", "tests/scenes/a.json"]);
}

// ---- merges ----

/// Lines that an unfinished merge leaves.
fn merge_marks(text: &str) -> Vec<usize> {
    let is_mark = |line: &str| {
        ["<<<<<<<", ">>>>>>>"].iter().any(|mark| line.starts_with(mark)) || line == "======="
    };
    let lines = text.lines().enumerate().filter(|(_, line)| is_mark(line));
    lines.map(|(number, _)| number + 1).collect()
}

#[test]
fn no_page_holds_the_marks_of_a_merge() -> Outcome {
    for (page, text) in texts(&root(), ".md")? {
        let marks = merge_marks(&text);
        assert!(marks.is_empty(), "{page}: lines {marks:?}");
    }
    assert_eq!(merge_marks("a\n<<<<<<< HEAD\n=======\n>>>>>>> b\n"), [2, 3, 4]);
    Ok(())
}
