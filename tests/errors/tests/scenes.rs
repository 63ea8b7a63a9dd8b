//! Scenes that once printed a false error, or lost their answer: what they print holds.

use std::path::Path;
use std::time::Duration;

use scenes::causes::with_causes;
use stated_errors::{judged, known};

/// No number is further from its truth than this many stated errors.
const MOST: f64 = 5.0;

/// Scenes that are refused, with a part of the advice in the message.
const REFUSED: [(&str, &str); 2] =
    [("lattice_that_ends_within", "a larger reach"), ("two_wells", "take a finer lattice")];

#[test]
fn numbers_of_scenes_that_failed_hold() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut n_numbers = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let scene: serde_json::Value = serde_json::from_str(&text).unwrap();
        let drawn = known(scene).unwrap();
        let verdicts = judged(&drawn, Duration::from_secs(600));
        let name = path.file_stem().unwrap().to_str().unwrap();
        let refused = REFUSED.iter().find(|(refused, _)| *refused == name);
        if let (Err(error), Some((_, advice))) = (&verdicts, refused) {
            let words = with_causes(error);
            assert!(words.contains(advice), "{name}: {words}");
            continue;
        }
        let verdicts = verdicts.unwrap_or_else(|error| panic!("{name}: {error:?}"));
        assert!(!verdicts.is_empty(), "{}", path.display());
        for verdict in verdicts {
            let off = verdict.off().unwrap_or_default();
            assert!(off <= MOST, "{}: {off}: {verdict:?}", path.display());
            n_numbers += 1;
        }
    }
    assert!(n_numbers > 100, "{n_numbers}");
}
