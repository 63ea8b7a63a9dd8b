//! The pages of all keys of all scenes, as Markdown: one a solver, and one that lists them.

use std::path::{Path, PathBuf};

use result_figures::markdown::table;

use super::example::{BuiltIn, Example, Examples};
use super::rows::{Row, is_list_of_words, label, rows};
use super::tree::{Holds, Key, Named, Presence, Tree};
use super::unit;
use super::value::compact;

const HEAD: &str = "\
# Scenes

A scene is one JSON file: which solver, what is modelled, what is random, what is asked, by which method. Every key that a
scene may have is on the page of its solver. To start, copy a built-in scene, change a number and run it:

```sh
cp tests/scenes/fpk/duffing.json my.json
cargo xtask run my.json --out target/run/my
```

A key that is not on the page, or a value of another type, is rejected with its line and column and the nearest known key.
";

const HOW_TO_READ: &str = "\
## How to read the tables of a page

- **key**: path from the object of the table: `single_peak.peak` is the key `peak` inside `single_peak`.
- **type**: type of the value. A link leads to the keys or the choices of an object.
  Give one of several choices: a word alone, such as `\"stationary\"`, or an object whose only key is the word,
  such as `{ \"single_peak\": { \"peak\": 1, \"peak_time\": 2 } }`.
- **unit**: unit of a number; `-` for a dimensionless number. If it names `units`, it follows from that key of the scene: with
  `\"cm_g_us\"` a \"length of `units`\" is in cm.
- **default**: value if the key is omitted; *required* if it must be given; *optional* if its meaning states the effect of its
  absence. A choice has no default.
- **example**: value in the first built-in scene, by name, that has the key; without a link, from no scene.

`cargo xtask schema --record` generates the pages from the scene types and the built-in scenes, and also the schemas for
completion and checks in an editor. In Visual Studio Code: `\"json.schemas\": [{ \"fileMatch\": [\"my.json\"],
\"url\": \"./docs/schema/fpk-sph.schema.json\" }]`.
";

/// Largest number of places listed for a type.
const MOST_PLACES: usize = 4;

/// Largest number of choices listed next to their link.
const MOST_CHOICES: usize = 5;

/// Description of a solver on the page.
pub(super) struct Described {
    pub(super) solver: &'static str,
    pub(super) tree: Tree,
    pub(super) scenes: Vec<BuiltIn>,
    pub(super) examples: Examples,
}

pub(super) fn schema_path(solver: &str) -> PathBuf {
    Path::new("schema").join(format!("{solver}.schema.json"))
}

/// Path of the page of a solver's keys.
pub(super) fn page_path(solver: &str) -> PathBuf {
    Path::new("scenes").join(format!("{solver}.md"))
}

/// The page that lists the pages of all solvers.
pub(super) fn overview(described: &[Described]) -> String {
    let line = |of: &Described| {
        vec![
            format!("[{}]({})", of.solver, page_path(of.solver).display()),
            of.tree.root().about.clone(),
            format!("[{0}]({0})", schema_path(of.solver).display()),
            of.scenes.len().to_string(),
        ]
    };
    let lines: Vec<Vec<String>> = described.iter().map(line).collect();
    let heads = ["solver", "what a scene of it is", "schema", "built-in scenes"].map(str::to_owned);
    format!("{HEAD}\n{}\n{HOW_TO_READ}", table(&heads, &lines))
}

/// The page of a solver's keys.
pub(super) fn page(of: &Described) -> String {
    let root = of.tree.root();
    let scene = |scene: &BuiltIn| {
        vec![format!("[{}]", scene.name), cell(scene.value["title"].as_str().unwrap_or_default())]
    };
    let scenes: Vec<Vec<String>> = of.scenes.iter().map(scene).collect();
    let scenes = table(&["built-in scene", "title"].map(str::to_owned), &scenes);
    let places = places(&of.tree);
    let mut last = None;
    let section = |named: &Named| {
        let places = places.iter().filter(|(name, _)| *name == named.name);
        let places: Vec<&str> = places.map(|(_, place)| place.as_str()).collect();
        let top = places.first().and_then(|place| place.split(['.', '[']).next());
        let head = match top.filter(|_| top != last) {
            Some(top) => format!("\n## `{top}`\n"),
            None => String::new(),
        };
        last = top;
        head + &section(of, named, &places)
    };
    let sections: String = of.tree.types[1..].iter().map(section).collect();
    let target = |scene: &BuiltIn| format!("[{0}]: ../../tests/scenes/{0}.json\n", scene.name);
    let targets: String = of.scenes.iter().map(target).collect();
    let (solver, about, keys) = (of.solver, &root.about, keys(of, root));
    format!(
        "# Scenes of {solver}\n\n{about} [How to read the tables](../scenes.md#how-to-read-the-tables-of-a-page).\n\n\
         {scenes}\n## Keys of a scene\n\n{keys}{sections}\n{targets}"
    )
}

/// Section of a type: its description, places and keys.
fn section(of: &Described, named: &Named, places: &[&str]) -> String {
    let shown: Vec<String> =
        places.iter().take(MOST_PLACES).map(|place| format!("`{place}`")).collect();
    let more = match places.len().saturating_sub(MOST_PLACES) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let words = words_of(&named.name);
    format!(
        "\n<a id=\"{}\"></a>\n\n### {words}\n\n{} At {}{more}.\n\n{}",
        anchor(of.solver, &named.name),
        named.about,
        shown.join(", "),
        keys(of, named)
    )
}

fn keys(of: &Described, named: &Named) -> String {
    let heads = ["key", "type", "unit", "default", "meaning", "example"].map(str::to_owned);
    let lines: Vec<Vec<String>> = rows(named).iter().map(|row| line(of, named, row)).collect();
    table(&heads, &lines)
}

fn line(of: &Described, named: &Named, row: &Row<'_>) -> Vec<String> {
    let unit = if row.may_have_unit() { unit::split(row.about) } else { None };
    let (unit, meaning) = match unit {
        Some(("no unit", meaning)) => ("-".to_owned(), meaning),
        Some((unit, meaning)) => (unit.to_owned(), meaning),
        None => (String::new(), row.about.to_owned()),
    };
    let default = match row.presence {
        Some(Presence::Required) => "*required*".to_owned(),
        Some(Presence::Optional) => "*optional*".to_owned(),
        Some(Presence::Default(value)) => format!("`{}`", compact(value)),
        None => String::new(),
    };
    let example = match of.examples.of(&named.name, &row.path) {
        Some(Example { value, scene: Some(scene) }) => format!("`{}` in [{scene}]", compact(value)),
        Some(Example { value, scene: None }) => format!("`{}`", compact(value)),
        None => format!("`\"{}\"`", row.path),
    };
    let key = if row.path.contains(' ') { row.path.clone() } else { format!("`{}`", row.path) };
    let kind = row.holds.map_or_else(|| "word".to_owned(), |holds| kind(of, holds, Count::One));
    [key, kind, unit, default, meaning, example].iter().map(|text| cell(text)).collect()
}

/// Text escaped for a table cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Count {
    One,
    Many,
}

/// Description of a value's kind.
fn kind(of: &Described, holds: &Holds, count: Count) -> String {
    let word = |one: &str, many: &str| if count == Count::One { one } else { many }.to_owned();
    match holds {
        Holds::Text => word("text", "texts"),
        Holds::Number => word("number", "numbers"),
        Holds::Whole => word("whole number", "whole numbers"),
        Holds::Flag => "`true` or `false`".to_owned(),
        Holds::List(inner, length) => {
            let inner = kind(of, inner, Count::Many);
            match length {
                Some(length) => format!("{} of {length} {inner}", word("list", "lists")),
                None => format!("{} of {inner}", word("list", "lists")),
            }
        }
        Holds::Map(inner) => format!("by name: {}", kind(of, inner, Count::One)),
        Holds::Object(_) => word("object", "objects"),
        Holds::Choice(variants) if is_list_of_words(variants) => {
            let words: Vec<String> =
                variants.iter().map(|variant| format!("`{}`", label(variant))).collect();
            words.join(", ")
        }
        Holds::Choice(_) => word("choice", "choices"),
        Holds::Named(name) => link(of, name),
    }
}

/// A link to a type, with its choices if they are few.
fn link(of: &Described, name: &str) -> String {
    let link = format!("[{}](#{})", words_of(name), anchor(of.solver, name));
    match of.tree.get(name).map(|named| &named.holds) {
        Some(Holds::Choice(variants))
            if variants.len() <= MOST_CHOICES && variants.iter().all(|v| v.name.is_some()) =>
        {
            let words: Vec<String> =
                variants.iter().map(|variant| format!("`{}`", label(variant))).collect();
            format!("{link}: {}", words.join(", "))
        }
        _ => link,
    }
}

/// `two storey` for `TwoStoreyScene`.
fn words_of(name: &str) -> String {
    let mut words = String::new();
    for c in name.strip_suffix("Scene").unwrap_or(name).chars() {
        if c.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(c.to_lowercase());
    }
    words
}

fn anchor(solver: &str, name: &str) -> String {
    format!("{solver}-{}", words_of(name).replace(' ', "-"))
}

/// Every type with each of its places in a scene, in reading order.
fn places(tree: &Tree) -> Vec<(String, String)> {
    let mut places = Vec::new();
    visit(tree, "", &tree.root().holds, &mut places);
    places
}

fn visit(tree: &Tree, path: &str, holds: &Holds, places: &mut Vec<(String, String)>) {
    let join = |key: &str| super::rows::join(path, key);
    match holds {
        Holds::Object(keys) => {
            for Key { name, holds, .. } in keys {
                visit(tree, &join(name), holds, places);
            }
        }
        Holds::Choice(variants) => {
            for variant in variants {
                let path = variant.name.as_deref().map_or_else(|| path.to_owned(), join);
                if let Some(holds) = &variant.holds {
                    visit(tree, &path, holds, places);
                }
            }
        }
        Holds::List(of, _) => visit(tree, &format!("{path}[]"), of, places),
        Holds::Map(of) => visit(tree, &join("NAME"), of, places),
        Holds::Named(name) => {
            places.push((name.clone(), path.to_owned()));
            if let Some(named) = tree.get(name) {
                visit(tree, path, &named.holds, places);
            }
        }
        _ => {}
    }
}
