//! No files of a package use each other in a circle, as `docs/ARCHITECTURE.md` states.
//!
//! A file uses the files whose items it names by `crate::`, `super::` or `self::`, and its child modules whose items
//! it names. A re-export is no use: a user of the name uses the file that defines it. Roots and test-only code are
//! excluded.

mod reader;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::folder::texts;
use crate::packages::{packages, word};
use reader::{Names, Reader};

/// Files that a file uses, and the first path of each use.
type Edges = BTreeMap<String, BTreeMap<String, String>>;

/// The file that defines the target of a path, through re-exports; none if it is the root.
fn defining<'a>(
    mut path: Names,
    files: &BTreeMap<&[String], &'a str>,
    exported: &BTreeMap<&Names, &Names>,
) -> Option<&'a str> {
    // No name passes through more re-exports.
    for _ in 0..8 {
        let is_file = |n: &usize| *n == 0 || files.contains_key(&path[..*n]);
        let n = (0..=path.len()).rev().find(is_file)?;
        let names =
            |k: usize| exported.get(&path[..k].to_vec()).map(|to| [to, &path[k..]].concat());
        match (n + 1..=path.len()).find_map(names) {
            Some(further) => path = further,
            None => return files.get(&path[..n]).copied(),
        }
    }
    None
}

/// Edges between the files of a package, by their paths below its sources.
fn edges(sources: &[(String, String)]) -> Edges {
    let read = sources.iter().map(|(file, text)| (file.as_str(), Reader::read(file, text)));
    let read: Vec<(&str, Reader)> = read.collect();
    let modules = read.iter().filter(|(_, reader)| !reader.module.is_empty());
    let files = modules.clone().map(|(file, reader)| (reader.module.as_slice(), *file)).collect();
    let exported = read.iter().flat_map(|(_, reader)| &reader.exported).collect();
    let mut edges = Edges::new();
    for (file, reader) in modules {
        for (path, written) in &reader.used {
            if let Some(to) = defining(path.clone(), &files, &exported).filter(|to| to != file) {
                let uses = edges.entry((*file).to_owned()).or_default();
                uses.entry(to.to_owned()).or_insert_with(|| written.clone());
            }
        }
    }
    edges
}

/// Circles, a line for each edge; removing one edge of each breaks all circles.
fn circles(mut edges: Edges) -> String {
    let mut found = String::new();
    while let Some(circle) = circle(&mut edges) {
        for (from, to) in circle.iter().zip(circle.iter().cycle().skip(1)) {
            found.extend([from, " -> ", to, " by ", &edges[from][to], "\n"]);
        }
        edges.get_mut(&circle[0]).and_then(|uses| uses.remove(&circle[1]));
    }
    found
}

/// The files of a circle, if any; removes edges that lead to none.
fn circle(edges: &mut Edges) -> Option<Vec<String>> {
    // A file without edges is in no circle, and neither is one with edges to such files only.
    let mut n_before = usize::MAX;
    while edges.len() < n_before {
        n_before = edges.len();
        let left: BTreeSet<String> = edges.keys().cloned().collect();
        edges.retain(|_, uses| {
            uses.retain(|to, _| left.contains(to));
            !uses.is_empty()
        });
    }
    // Every remaining file uses a remaining one, so a walk returns to a visited file.
    let (mut walk, mut next) = (Vec::new(), edges.keys().next()?);
    while !walk.contains(next) {
        walk.push(next.clone());
        next = edges[next].keys().next()?;
    }
    let begin = walk.iter().position(|file| file == next)?;
    Some(walk.split_off(begin))
}

#[test]
fn no_files_of_a_package_use_each_other_in_a_circle() {
    let (mut all, mut n_edges) = (String::new(), 0);
    for package in packages() {
        let manifest = word(&package["manifest_path"]);
        let folder = Path::new(&manifest).with_file_name("src");
        let edges = edges(&texts(&folder, ".rs").expect("the sources"));
        n_edges += edges.values().map(BTreeMap::len).sum::<usize>();
        let found = circles(edges);
        if !found.is_empty() {
            all.extend([&word(&package["name"]), ":\n", &found]);
        }
    }
    assert!(all.is_empty(), "{all}");
    assert!(n_edges > 1000, "only {n_edges} uses were found");
}

fn circles_of(sources: &[(&str, &str)]) -> String {
    let own = |(file, text): &(&str, &str)| ((*file).to_owned(), (*text).to_owned());
    circles(edges(&sources.iter().map(own).collect::<Vec<_>>()))
}

#[test]
fn a_circle_through_super_is_seen() {
    let parent = ("a.rs", "mod b; fn f() { b::g() }");
    let by_use = circles_of(&[parent, ("a/b.rs", "use super::f as up; pub fn g() { up() }")]);
    assert_eq!(by_use, "a.rs -> a/b.rs by b::g\na/b.rs -> a.rs by super::f\n");
    let in_macro =
        circles_of(&[parent, ("a/b.rs", "mod c { fn g() { vec![super::super::f()]; } }")]);
    assert_eq!(in_macro, "a.rs -> a/b.rs by b::g\na/b.rs -> a.rs by super::super::f\n");
}

#[test]
fn a_circle_through_a_re_export_is_seen() {
    let sources = [
        ("lib.rs", "pub mod a; mod b; pub use crate::b::Size;"),
        ("a.rs", "mod c; pub use c::{self_made as made}; pub fn size(_: crate::Size) {}"),
        ("a/c.rs", "pub fn self_made() {}"),
        ("b.rs", "use crate::a; pub struct Size; fn f() { a::made(); a::size(); }"),
    ];
    assert_eq!(circles_of(&sources), "a.rs -> b.rs by crate::Size\nb.rs -> a.rs by crate::a\n");
    let sources =
        [sources[0], sources[1], sources[2], ("b.rs", "use crate::a::made; fn f() { made() }")];
    assert_eq!(circles_of(&sources), "");
}

#[test]
fn what_is_no_use_makes_no_circle() {
    let sources = [
        ("a/mod.rs", "mod b; mod c; pub use b::g; fn f(c: f64) -> f64 { c }"),
        ("a/b.rs", "pub(in crate::a) fn g() {} #[cfg(test)] mod tests { use super::super::f; }"),
        ("a/c.rs", "use std::fmt; fn h() { super::g() }"),
    ];
    assert_eq!(circles_of(&sources), "");
}
