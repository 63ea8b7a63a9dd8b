//! Notes of scenes of bodies on constants, gaps and tears, and debris that closes again.

use serde_json::Value;

use crate::harness::{SceneRun, changed};

const CHARGE: &str = include_str!("../small/smpm/charge.json");
const BODIES: &str = include_str!("../small/smpm/bodies.json");

/// Files beside the scenes; the first has a comment that is not UTF-8.
pub(crate) fn cards() -> [(&'static str, Vec<u8>); 4] {
    let steel = include_bytes!("../small/smpm/steel.k");
    [
        ("steel.k", [b"$ \xe4\n", steel.as_slice()].concat()),
        ("steel_by_commas.k", include_bytes!("../small/smpm/steel_by_commas.k").to_vec()),
        ("cards.k", include_bytes!("../small/smpm/cards.k").to_vec()),
        ("long.k", include_bytes!("../small/smpm/long.k").to_vec()),
    ]
}

/// The plate alone, by one run.
fn plate(changes: &[(&str, &str)]) -> String {
    let one = [("'propagated'", "'deterministic'"), ("'fields': true", "'fields': false")];
    changed(BODIES, &[&one[..], changes].concat())
}

fn notes(ran: &SceneRun) -> Vec<String> {
    let notes = ran.result()["notes"].take();
    let notes = notes.as_array().cloned().unwrap_or_default();
    notes.iter().filter_map(Value::as_str).map(str::to_owned).collect()
}

fn says(ran: &SceneRun, words: &str) -> bool {
    notes(ran).iter().any(|note| note.contains(words))
}

/// The value of the first quantity at a gauge, at the last time.
fn value(ran: &SceneRun, gauge: usize) -> f64 {
    let values = ran.result()["gauges"][gauge]["quantities"][0]["values"].take();
    values.as_array().unwrap().last().unwrap()["mean"].as_f64().unwrap()
}

#[test]
fn bonded_bodies_that_are_apart_have_a_note_and_those_in_contact_have_none() {
    let moved = ("'from': [2, 0], 'to': [3, 2]", "'from': [3, 0], 'to': [4, 2]");
    let gauges = [("[2.25, 1]", "[3.25, 1]"), ("[2.75, 1]", "[3.75, 1]")];
    let apart = [&[moved][..], &gauges].concat();
    assert!(says(&SceneRun::of(&changed(CHARGE, &apart)), "are 2 cells apart"));
    assert!(notes(&SceneRun::of(CHARGE)).is_empty());
    let friction =
        ("'dimension': 2", "'dimension': 2, 'contact': { 'friction': { 'coefficient': 0 } }");
    let parted = changed(CHARGE, &[&apart[..], &[friction]].concat());
    assert!(notes(&SceneRun::of(&parted)).is_empty());
}

#[test]
fn one_system_of_units_gives_the_answers_of_another() {
    let factors = "'units': { 'factors': { 'length': 0.01, 'mass': 0.001, 'time': 1e-6 } }";
    let with = |units: &str| SceneRun::of(&changed(CHARGE, &[("'units': 'cm_g_us'", units)]));
    let (named, by_factors) = (with("'units': 'cm_g_us'"), with(factors));
    for gauge in [0, 1] {
        assert_eq!(value(&named, gauge).to_bits(), value(&by_factors, gauge).to_bits());
    }
}

#[test]
fn constants_of_another_system_of_units_are_noted() {
    let heavy = "{ 'mie_gruneisen': { 'library': 'steel', 'set': { 'density': 7830 } } }";
    let mass = ("{ 'mie_gruneisen': { 'library': 'steel' } }", heavy);
    assert!(says(&SceneRun::of(&plate(&[mass])), "density 7830 is 7.83e6 kg/m^3"));
    assert!(notes(&SceneRun::of(&plate(&[]))).is_empty());
}

#[test]
fn a_bar_that_the_grid_tears_has_a_note_and_one_that_swings_back_has_none() {
    let bar = include_str!("../small/smpm/hanging_bar.json");
    assert!(says(&SceneRun::of(bar), "`bar` is torn by the grid"));
    assert!(notes(&SceneRun::of(&changed(bar, &[("-1200", "-120")]))).is_empty());
}

#[test]
fn debris_of_lead_runs_to_its_end() {
    let scene = include_str!("../small/smpm/debris.json");
    let ran = SceneRun::of(scene);
    ran.written.as_ref().unwrap();
    // The middle of the plate flies ahead, and the ball is slower than before.
    let (ball, behind) = (value(&ran, 0), value(&ran, 1));
    assert!(ball < 6.58 && ball > 1.0 && behind > 1.0, "{ball} {behind}");
}

#[test]
fn with_a_spall_strength_alone_a_plate_fails_by_tension() {
    // A plate hits a rigid wall, which it may leave: where rarefactions from its free faces meet, it is in tension.
    let damage = "'library': 'steel' } }, 'strength': { 'johnson_cook': { 'library': 'steel' } }, 'damage': { 'set': { 'spall_strength': 0.001 } }";
    let with = |damage: &str| {
        let material = ("'library': 'steel' } }", damage);
        let open = ("'kind': 'symmetry'", "'kind': 'rigid'");
        let quantity = ("['pressure']", "['damage']");
        let late = ("[0.5, 1, 1.5]", "[12]");
        value(&SceneRun::of(&plate(&[material, open, quantity, late])), 0)
    };
    assert!(with(damage) >= 1.0);
    assert!(with(&damage.replace("0.001", "1000")) <= 0.0);
}

#[test]
fn cards_of_a_keyword_file_give_the_run_of_the_library_and_the_page_names_them() {
    let text = include_str!("../small/smpm/cards.json");
    let files = cards();
    let files = files.each_ref().map(|(name, bytes)| (*name, bytes.as_slice()));
    let run = |changes: &[(&str, &str)]| SceneRun::beside(&changed(text, changes), &files);
    let by_columns = run(&[]);
    let by_commas = run(&[("steel.k", "steel_by_commas.k"), ("mm_kg_ms", "mm_tonne_s")]);
    let library = run(&[
        (",\n      'keyword_file': { 'path': 'steel.k', 'units': 'mm_kg_ms' }", ""),
        ("{ 'set': { 'taylor_quinney': 0.9, 'rate_floor': 1 } }", "{ 'library': 'steel' }"),
        ("'damage': {}", "'damage': { 'library': 'steel' }"),
        ("{ 'mie_gruneisen': {} }", "{ 'mie_gruneisen': { 'library': 'steel' } }"),
    ]);
    let expected = value(&library, 0);
    for ran in [&by_columns, &by_commas] {
        let error = (value(ran, 0) / expected - 1.0).abs();
        assert!(error < 1e-15, "{error:e}");
    }
    assert!(says(&by_columns, "without effect in *MAT_JOHNSON_COOK 7: VP 1"));
    assert_eq!(by_columns.result()["files"][0]["path"], "steel.k");
    for (ran, words) in [
        (&by_columns, "cards of steel.k: *EOS_GRUNEISEN 9, *MAT_JOHNSON_COOK 7"),
        (&library, "johnson_cook: `steel` of the library, 4340, Johnson and Cook 1983"),
    ] {
        let page = std::fs::read_to_string(ran.out().join("index.html")).unwrap();
        assert!(page.contains(words), "{words}");
    }
}

/// An octahedron of radius 10 in text.
fn octahedron(turned: bool) -> String {
    let mut text = String::from("solid tip\n");
    for number in 0..8 {
        let side = |k: usize| if number >> k & 1 == 0 { 10 } else { -10 };
        let mut corners = [[side(0), 0, 0], [0, side(1), 0], [0, 0, side(2)]];
        if turned != (side(0) * side(1) * side(2) < 0) {
            corners.swap(0, 1);
        }
        text += "facet normal 0 0 0\nouter loop\n";
        let vertex = |[x, y, z]: &[i32; 3]| format!("vertex {x} {y} {z}\n");
        text += &corners.iter().map(vertex).collect::<String>();
        text += "endloop\nendfacet\n";
    }
    text + "endsolid tip\n"
}

#[test]
fn a_projectile_from_a_file_hits_a_plate_and_another_file_is_another_run() {
    let tip = "{ 'name': 'tip', 'material': 'steel', 'velocity': [0, 0, 0.1], 'shape': { 'surface': { 'file': 'tip.stl', 'scale': 0.1, 'shift': [1, 0, -1] } } }";
    let scene = plate(&[
        ("'dimension': 2", "'dimension': 3"),
        ("'from': [0, 0], 'to': [4, 2]", "'from': [0, -1, 0], 'to': [2, 1, 0.5]"),
        ("'velocity': [-0.1, 0]\n    }", &format!("'velocity': [0, 0, 0] }}, {tip}")),
        ("'at': [1, 1]", "'at': [1, 0, 0.25]"),
    ]);
    let ran = SceneRun::beside(&scene, &[("tip.stl", octahedron(false).as_bytes())]);
    let result = ran.result();
    // Of the octahedron 80, of its volume 85.3; the plate has 128.
    assert_eq!(result["work"]["particles"], 208);
    assert!(value(&ran, 0) > 0.01, "{}", value(&ran, 0));
    assert_eq!(result["files"][0]["path"], "tip.stl");
    std::fs::write(ran.folder().join("tip.stl"), octahedron(true)).unwrap();
    let refused = ran.resume(&scene).unwrap_err().to_string();
    assert!(refused.contains("tip.stl"), "{refused}");
}

#[test]
fn particles_from_a_file_are_those_of_the_box_that_they_fill() {
    let at = |n: i32| 0.125 + 0.25 * f64::from(n);
    let lines = (0..128).map(|n| format!("{}, {}\n", at(n % 16), at(n / 16)));
    let list = lines.collect::<Vec<_>>().concat();
    let files = [("plate.csv", list.as_bytes())];
    let shape = (
        "{ 'box': { 'from': [0, 0], 'to': [4, 2] } }",
        "{ 'points': { 'file': 'plate.csv', 'spacing': 0.25 } }",
    );
    let listed = SceneRun::beside(&plate(&[shape]), &files);
    assert_eq!(value(&listed, 0).to_bits(), value(&SceneRun::of(&plate(&[])), 0).to_bits());
    let material = "'material': 'steel',";
    let other = format!(
        "'bodies': [{{ 'name': 'other', {material} 'shape': {{ 'box': {{ 'from': [3.5, 1], 'to': [6, 2] }} }} }},"
    );
    for (change, words) in [
        (
            (material, "'material': 'steel', 'rotation': { 'about': [0, 0], 'degrees': 1 },"),
            "from a file are not rotated",
        ),
        (
            (
                material,
                "'material': 'steel', 'except': [{ 'points': { 'file': 'plate.csv', 'spacing': 0.25 } }],",
            ),
            "no region to cut out",
        ),
        (
            ("'deterministic'", "{ 'multilevel': { 'tolerance': 0.1, 'seed': 3 } }"),
            "listed for one grid alone",
        ),
        (("'bodies': [", other.as_str()), "overlap: "),
    ] {
        let ran = SceneRun::beside(&plate(&[change, shape]), &files);
        assert!(ran.mistake().message.contains(words), "{}", ran.mistake().message);
    }
}
