//! Mistakes in scenes, each shown at its key.

use std::path::Path;

use serde_json::Value;

use crate::harness::{SceneRun, changed};
use crate::peridyn::inference;
use crate::smpm_bodies::cards;

/// The rows of `mistakes/*.json`: parts of a small scene that are replaced, in which `'` is `"`; the path of the key at which the mistake
/// is shown; a part of the message; and, where it is given, the text under which the message points.
#[test]
fn mistakes_are_shown_where_they_are() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
    let files = inference::files();
    let mut files: Vec<(&str, &[u8])> =
        files.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
    let cards = cards();
    files.extend(cards.iter().map(|(name, bytes)| (*name, bytes.as_slice())));
    let mut n_rows = 0;
    for table in ["fpk", "smpm", "peridyn"] {
        let rows: Value = serde_json::from_str(&read(&format!("mistakes/{table}.json"))).unwrap();
        for row in rows.as_array().unwrap() {
            let word = |key: &str| row[key].as_str().unwrap_or_default();
            let changes = row["with"].as_array().unwrap().iter();
            let changes: Vec<(&str, &str)> = changes
                .map(|pair| (pair[0].as_str().unwrap(), pair[1].as_str().unwrap()))
                .collect();
            let text = changed(&read(word("scene")), &changes);
            let ran = SceneRun::beside(&text, &files);
            let mistake = ran.mistake();
            assert_eq!(mistake.path, word("at"), "{row}: {}", mistake.message);
            assert!(mistake.message.contains(word("says")), "{row}: {}", mistake.message);
            let line = text.lines().nth(mistake.line - 1).unwrap();
            let rest: String = line.chars().skip(mistake.column - 1).collect();
            assert!(rest.starts_with(&word("under").replace('\'', "\"")), "{row}: {rest}");
            n_rows += 1;
        }
    }
    assert!(n_rows > 100, "{n_rows}");
}
