//! Scenes that once printed a false error, or lost their answer: what they print holds.
//!
//! Other such inputs are tested where they belong:
//!
//! - integrators and importance sampling that a scene names, first passages of an oscillator: `mistakes/fpk.json` of scenes;
//! - a ladder whose trials fail: `long_runs.rs` of scenes;
//! - the convention of the spectral density: `established.rs` of scenes;
//! - nested rules of too many nodes: `linearisation.rs` of random-vibration;
//! - small indices of many inputs: `cube.rs` of uq-estimators.

#![expect(clippy::unwrap_used, reason = "a scene that cannot be read has failed")]

use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;
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
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|it| it.unwrap().path()).collect();
    let n_numbers: usize = files.par_iter().map(|path| n_that_hold(path)).sum();
    assert!(n_numbers > 100, "{n_numbers}");
}

/// Numbers of a scene, all of which hold; none if it is refused as it should be.
fn n_that_hold(path: &Path) -> usize {
    let text = std::fs::read_to_string(path).unwrap();
    let scene: serde_json::Value = serde_json::from_str(&text).unwrap();
    let drawn = known(scene).unwrap();
    let verdicts = judged(&drawn, Duration::from_secs(600));
    let name = path.file_stem().unwrap().to_str().unwrap();
    let refused = REFUSED.iter().find(|(refused, _)| *refused == name);
    if let (Err(error), Some((_, advice))) = (&verdicts, refused) {
        let words = with_causes(error);
        assert!(words.contains(advice), "{name}: {words}");
        return 0;
    }
    let verdicts = verdicts.map_err(|error| format!("{name}: {error:?}")).unwrap();
    assert!(!verdicts.is_empty(), "{name}");
    for verdict in &verdicts {
        let off = verdict.off().unwrap_or_default();
        assert!(off <= MOST, "{name}: {off}: {verdict:?}");
    }
    verdicts.len()
}
