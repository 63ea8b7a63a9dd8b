//! Loads that grow slowly, supports, laws of bonds.

use super::*;
use crate::harness::result_in;

/// A plate pulled slowly; each realisation takes a fraction of a second.
const SLOW: &str = include_str!("../../small/peridyn/slow.json");

const GRIPS: &str = "'grips': { 'height': 0.002, 'hold': 'clamped' },";
const STRETCH: &str = "'stretch': { 'strain': { 'over_critical_stretch': 0.8 } }";
const SUPPORTS: &str = "'supports': [{ 'region': { 'low': [0, 0], 'high': [0.016, 0.001] }, 'hold': 'both', 'protected': 0.001 }],";
const LIFTED: &str = "'displacement': { 'region': { 'low': [0, 0.015], 'high': [0.016, 0.016] }, 'until': [0, 2e-6], 'protected': 0.001 }";
const TOUGHNESS: &str = "'toughness': { 'energy_release_rate': 3.8 }";
/// Bonds that break at once at this strength take 3.8 J/m^2.
const SOFTENING: &str =
    "'toughness': { 'softening': { 'tensile_strength': 14e6, 'fracture_energy': 10 } }";
const SOLID: (&str, &str) = (
    "'young_modulus': 72e9",
    "'young_modulus': 72e9, 'law': { 'linear_solid': { 'poisson_ratio': 0.22 } }",
);

#[test]
fn every_law_runs_slowly_and_its_load_is_over_strain_or_displacement() {
    let cases: [&[(&str, &str)]; 4] =
        [&[], &[(TOUGHNESS, SOFTENING)], &[SOLID], &[(GRIPS, SUPPORTS), (STRETCH, LIFTED)]];
    for (number, changes) in cases.into_iter().enumerate() {
        let result = SceneRun::of(&changed(SLOW, changes)).result();
        assert!(result["failures"].as_array().unwrap().is_empty(), "{}", result["failures"]);
        assert!(result["broken_bonds"]["value"].as_f64().unwrap() > 10.0);
        let (resolved, load) = (&result["resolved"], &result["load"]);
        assert!(resolved["dt"].is_null() && resolved["duration"].is_null());
        let key = if number == 3 { "displacement" } else { "strain" };
        let end = resolved[format!("final_{key}")].as_f64().unwrap();
        assert_eq!(load.as_array().unwrap().len(), 10);
        assert!((load[9][key].as_f64().unwrap() / end - 1.0).abs() < 1e-12);
        // A plate, less its notch, as a bar of plane stress between plates that hold it.
        let first = load[0]["load"]["value"].as_f64().unwrap();
        let strain = if number == 3 { end / 0.015 } else { end } / 10.0;
        let bar = 72e9 * strain * 0.016 * 0.001;
        assert!(first > 0.5 * bar && first < 1.2 * bar, "{number}: {first} {bar}");
    }
}

#[test]
fn a_solid_runs_in_time_and_in_single_precision() {
    let steps = ("'steps': 400", "'steps': 400, 'breaking': 'bridge'");
    let heun = ("'leimkuhler_matthews'", "'heun'");
    for precision in ["'f64'", "'f32'"] {
        let result = SceneRun::of(&with(&[steps, heun, SOLID, ("'f64'", precision)])).result();
        assert!(result["failures"].as_array().unwrap().is_empty());
        assert!(result["failure_load"]["mean"]["value"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn a_slow_ensemble_has_the_same_bits_in_shards_and_after_a_checkpoint() {
    let ran = SceneRun::of(SLOW);
    let whole = ran.result();
    let shards = ["2/2", "1/2"].map(|place| ran.shard(place, &place.replace('/', "-")).unwrap());
    ran.merge(&[&shards[0], &shards[1]]).unwrap();
    let merged = result_in(&ran.folder().join("merged"));
    // Two realisations, then one more after the checkpoint of these.
    let one_shown = ("[0, 2]", "[0]");
    let grown =
        SceneRun::of(&changed(SLOW, &[("'realisations': 3", "'realisations': 2"), one_shown]));
    grown.resume(&changed(SLOW, &[one_shown])).unwrap();
    let grown = grown.result();
    for key in ["realisations", "load", "path", "failure_load", "outcomes"] {
        assert_eq!(merged[key], whole[key], "{key}");
        assert_eq!(grown[key], whole[key], "{key}");
    }
}
