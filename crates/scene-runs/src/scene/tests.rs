//! Every error of a scene, with its text, line and column.

use serde::Deserialize;
use serde_json::Value;

use super::{Objection, Retired, Scene, SceneError, SceneFile, WrongKey, read_keys};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sample {
    solver: String,
    system: System,
    times: Vec<f64>,
    n_particles: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum System {
    ViscousDamper { intensity: f64, mean: Option<f64> },
    LinearOscillator { frequency: f64 },
}

impl Scene for Sample {
    type Built = ();
    const RETIRED: &[Retired] = &[
        Retired { path: "system.pendulum", successor: "`linear_oscillator`, which is as small" },
        Retired { path: "viscous_damper.strength", successor: "`intensity`" },
    ];

    fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
        read_keys(keys)
    }

    fn check(&self) -> Result<(), Objection> {
        if self.n_particles == 0 {
            return Err(Objection::new("n_particles", "there must be at least one particle"));
        }
        if let Some(i) = self.times.iter().position(|&t| t < 0.0) {
            return Err(Objection::new(format!("times[{i}]"), "a time must not be negative"));
        }
        match self.system {
            System::ViscousDamper { intensity, .. } if intensity < 0.0 => {
                let path = "system.viscous_damper.intensity";
                Err(Objection::new(path, format!("the intensity {intensity} must not be negative")))
            }
            System::LinearOscillator { frequency } if frequency <= 0.0 => {
                Err(Objection::new("system.linear_oscillator", "it needs a positive frequency"))
            }
            _ => Ok(()),
        }
    }
}

const GOOD: &str = r#"{
  "solver": "self-check",
  "system": { "viscous_damper": { "intensity": 0.2 } },
  "times": [1, 2.5, 6],
  "n_particles": 1700
}
"#;

fn parse(text: &str) -> Result<Sample, SceneError> {
    SceneFile::from_text("scene.json", text.to_owned())?.parse()
}

/// Replaces `from` in the valid scene, which must contain it, and expects an error.
#[track_caller]
fn mistake(
    from: &str,
    to: &str,
    place: (usize, usize),
    path: &str,
    message: &str,
) -> Option<String> {
    assert!(GOOD.contains(from));
    let error = parse(&GOOD.replacen(from, to, 1)).unwrap_err();
    let mistake = error.mistake().unwrap_or_else(|| panic!("{error}"));
    assert_eq!(mistake.message, message);
    assert_eq!(mistake.path, path);
    assert_eq!((mistake.line, mistake.column), place);
    mistake.help.clone()
}

#[test]
fn a_good_scene_is_read() {
    let scene = parse(GOOD).unwrap();
    assert_eq!(
        (scene.solver.as_str(), scene.times.len(), scene.n_particles),
        ("self-check", 3, 1700)
    );
    assert!(matches!(scene.system, System::ViscousDamper { intensity: 0.2, mean: None }));
    let file = SceneFile::from_text("scene.json", GOOD.to_owned()).unwrap();
    assert_eq!(file.text_at_top("solver").unwrap(), "self-check");
}

#[test]
fn an_unknown_key_names_the_nearest_known_one() {
    let message = "unknown key `intensty`, expected `intensity` or `mean`";
    let path = "system.viscous_damper.intensty";
    let help = mistake("intensity", "intensty", (3, 35), path, message);
    assert_eq!(help.as_deref(), Some("did you mean `intensity`?"));
    let message =
        "unknown key `n_particle`, expected one of `solver`, `system`, `times`, `n_particles`";
    let help = mistake("n_particles", "n_particle", (5, 3), "n_particle", message);
    assert_eq!(help.as_deref(), Some("did you mean `n_particles`?"));
}

#[test]
fn an_unknown_variant_names_the_nearest_known_one() {
    let message =
        "unknown variant `viscous_dampr`, expected `viscous_damper` or `linear_oscillator`";
    let help = mistake("viscous_damper", "viscous_dampr", (3, 15), "system", message);
    assert_eq!(help.as_deref(), Some("did you mean `viscous_damper`?"));
}

#[test]
fn a_name_alone_that_has_keys_is_told_what_to_write() {
    let (from, to) = ("{ \"viscous_damper\": { \"intensity\": 0.2 } }", "\"linear_oscillator\"");
    let message = "`linear_oscillator` has keys of its own";
    let help = mistake(from, to, (3, 13), "system.linear_oscillator", message);
    assert_eq!(help.as_deref(), Some("write { \"linear_oscillator\": { ... } } with them"));
}

#[test]
fn a_removed_name_is_reported_with_its_successor() {
    let message = "`pendulum` was removed: use `linear_oscillator`, which is as small";
    assert_eq!(mistake("viscous_damper", "pendulum", (3, 15), "system.pendulum", message), None);
    let message = "`strength` was removed: use `intensity`";
    let path = "system.viscous_damper.strength";
    assert_eq!(mistake("intensity", "strength", (3, 35), path, message), None);
}

#[test]
fn a_text_that_would_move_the_cursor_of_a_terminal_is_refused() {
    let message = "the text has the control character U+001B";
    assert_eq!(mistake("viscous_damper", "\\u001b[2J", (3, 15), "system", message), None);
    assert_eq!(mistake("self-check", "\\u001b[2J", (2, 13), "solver", message), None);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let path = "system.viscous_damper.intensity";
    mistake("0.2", "1e999", (3, 48), path, "the number 1e999 is beyond the range of a double");
    mistake(
        "2.5",
        "-1e400",
        (4, 16),
        "times[1]",
        "the number -1e400 is beyond the range of a double",
    );
    mistake(
        "1700",
        "-3",
        (5, 18),
        "n_particles",
        "invalid value: integer `-3`, expected a whole number",
    );
}

#[test]
fn null_and_wrong_types_are_refused() {
    let path = "system.viscous_damper.intensity";
    mistake("0.2", "null", (3, 48), path, "invalid type: null, expected a number");
    mistake(
        "2.5",
        "\"two\"",
        (4, 16),
        "times[1]",
        "invalid type: string \"two\", expected a number",
    );
    mistake(
        "1700",
        "1.5",
        (5, 18),
        "n_particles",
        "invalid type: floating point `1.5`, expected a whole number",
    );
    mistake("[1, 2.5, 6]", "{}", (4, 12), "times", "invalid type: map, expected a sequence");
}

#[test]
fn a_missing_key_points_at_the_object_that_lacks_it() {
    let path = "system.viscous_damper";
    mistake("\"intensity\": 0.2", "\"mean\": 1", (3, 33), path, "missing key `intensity`");
    mistake(",\n  \"n_particles\": 1700", "", (1, 1), "", "missing key `n_particles`");
}

#[test]
fn a_key_given_twice_is_refused() {
    let from = "\"intensity\": 0.2";
    let help = mistake(
        from,
        "\"intensity\": 0.2, \"intensity\": 0.3",
        (3, 53),
        "system.viscous_damper.intensity",
        "the key `intensity` is given twice",
    );
    assert_eq!(help.as_deref(), Some("it was first given in line 3"));
}

#[test]
fn syntax_errors_and_trailing_text_have_a_place() {
    mistake("1700\n}", "1700\n} x", (6, 3), "", "trailing characters");
    mistake("1700\n}", "1700\n}\n{}", (7, 1), "", "trailing characters");
    mistake("[1, 2.5, 6]", "[1, 2.5, 6,]", (4, 23), "", "trailing comma");
    mistake("0.2", "NaN", (3, 48), "", "expected value");
    mistake("0.2", "0.2 /* m^2/s^3 */", (3, 52), "", "expected `,` or `}`");
    mistake("1700\n}\n", "1700\n", (6, 1), "", "EOF while parsing an object");
}

#[test]
fn what_other_dialects_of_json_allow_is_told_with_what_to_write_instead() {
    let help = |from: &str, to: &str| {
        let error = parse(&GOOD.replacen(from, to, 1)).unwrap_err();
        error.mistake().unwrap().help.clone().unwrap_or_default()
    };
    for (from, to, expected) in [
        ("{", "\u{feff}{", "byte order mark"),
        ("{", "// a comment\n{", "no comments"),
        ("0.2", "0.2 /* m^2/s^3 */", "no comments"),
        ("0.2", "NaN", "finite"),
        ("0.2", "nan", "finite"),
        ("0.2", "-Infinity", "finite"),
        ("\"self-check\"", "'self-check'", "double quotes"),
        ("0.2", "True", "`true`"),
    ] {
        let help = help(from, to);
        assert!(help.contains(expected), "{to}: {help}");
    }
    assert_eq!(help("[1, 2.5, 6]", "[1, 2.5, 6,]"), "");
}

#[test]
fn two_variants_of_one_value_are_named() {
    let from = "\"viscous_damper\": { \"intensity\": 0.2 }";
    let to = format!("{from}, \"linear_oscillator\": {{ \"frequency\": 2 }}");
    let message = "one key is expected; 2 are given: `viscous_damper`, `linear_oscillator`";
    mistake(from, &to, (3, 55), "system", message);
    mistake(from, "", (3, 13), "system", "one key is expected; none is given");
}

#[test]
fn objections_are_shown_at_the_value_they_name() {
    let path = "system.viscous_damper.intensity";
    mistake("0.2", "-0.2", (3, 48), path, "the intensity -0.2 must not be negative");
    mistake("2.5", "-2.5", (4, 16), "times[1]", "a time must not be negative");
    mistake("1700", "0", (5, 18), "n_particles", "there must be at least one particle");
    let oscillator = "\"linear_oscillator\": { \"frequency\": 0 }";
    let from = "\"viscous_damper\": { \"intensity\": 0.2 }";
    mistake(from, oscillator, (3, 15), "system.linear_oscillator", "it needs a positive frequency");
}

#[test]
fn the_whole_error_is_one_line_and_the_drawing_shows_the_source() {
    let error = parse(&GOOD.replacen("intensity", "intensty", 1)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "unknown key `intensty`, expected `intensity` or `mean` (at `system.viscous_damper.intensty`), \
         scene.json line 3 column 35"
    );
    let mut drawing = String::new();
    let theme = miette::GraphicalTheme::unicode_nocolor();
    miette::GraphicalReportHandler::new_themed(theme).render_report(&mut drawing, &error).unwrap();
    for expected in ["scene.json:3:35", "\"intensty\": 0.2", "did you mean `intensity`?"] {
        assert!(drawing.contains(expected), "{expected} is missing from\n{drawing}");
    }
}

#[test]
fn columns_count_characters() {
    let text = GOOD.replacen("self-check", "Größe", 1).replacen("\"times\"", "\"zeiten\"", 1);
    assert_eq!(parse(&text).unwrap_err().mistake().unwrap().line, 4);
    let text = "{ \"ä\": 1e999 }";
    let error = SceneFile::from_text("scene.json", text.to_owned()).unwrap_err();
    assert_eq!(error.mistake().unwrap().column, 8);
}

#[test]
fn files_without_text_are_refused() {
    let folder = std::env::temp_dir().join(format!("scene-files-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("scene.json");
    let missing = SceneFile::read(&path).unwrap_err();
    assert!(matches!(missing, SceneError::Unreadable { .. }), "{missing}");
    std::fs::write(&path, [b'{', b'"', 0xff, b'"']).unwrap();
    assert!(matches!(SceneFile::read(&path).unwrap_err(), SceneError::NotUtf8 { offset: 2, .. }));
    std::fs::write(&path, " \n").unwrap();
    assert!(matches!(SceneFile::read(&path).unwrap_err(), SceneError::Empty { .. }));
    std::fs::write(&path, GOOD).unwrap();
    assert!(SceneFile::read(&path).unwrap().parse::<Sample>().is_ok());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn deep_nesting_is_an_error_and_no_overflow() {
    let text = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(SceneFile::from_text("scene.json", text).is_err());
}

#[test]
fn the_kind_of_a_scene_must_be_a_text() {
    let kind = |text: &str| {
        let file = SceneFile::from_text("scene.json", text.to_owned()).unwrap();
        file.text_at_top("solver").map_err(|error| error.to_string())
    };
    assert_eq!(
        kind("{}").unwrap_err(),
        "the key `solver` is missing at the top, scene.json line 1 column 1"
    );
    assert_eq!(
        kind("{\"solver\": 3}").unwrap_err(),
        "`solver` must be a text (at `solver`), scene.json line 1 column 12"
    );
    assert!(kind("[]").is_err());
}

#[test]
fn a_mistake_on_a_line_too_wide_to_draw_is_told_without_its_source() {
    for (spaces, is_drawn) in [(100, true), (500, false), (70_000, false)] {
        let text = format!("{}{{ \"rate\": }}", " ".repeat(spaces));
        let error = SceneFile::from_text("scene.json", text).unwrap_err();
        let mistake = error.mistake().unwrap();
        assert_eq!((mistake.line, mistake.column), (1, spaces + 11));
        let report = miette::Report::new(error);
        assert_eq!(report.source_code().is_some(), is_drawn);
        assert!(format!("{report:?}").contains("line 1 column"));
    }
}
