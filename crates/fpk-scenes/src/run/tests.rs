//! Invalid density scenes and their messages.

use fpk_sph::Scheme;

use super::*;

const SCENE: &str = include_str!("../../../../tests/scenes/fpk/viscous_damper.json");
const BOUC_WEN: &str = include_str!("../../../../tests/scenes/fpk/bouc_wen.json");

/// A method of the damper, and one of the hysteretic oscillator.
const FIT: &str = "\"flow_map_fit\": { \"count\": [49, 49], \"reach\": 7 }";
const BALL: &str = "\"flow_map_fit\": { \"spacing\": 0.5, \"reach\": 5 }";
const GRID: &str =
    "\"conservative_grid\": { \"cells\": 64, \"reach\": 8, \"steps_per_period\": 40 }";
const GUIDED: &str = "\"guided_paths\": { \"samples\": 100, \"step\": 0.01, \"seed\": 1 }";
const SUBSET: &str = "\"subset_simulation\": { \"samples\": 100, \"correlation\": 1, \"runs\": 2, \
                      \"step\": 0.01, \"seed\": 1 }";
const NORMAL: &str = "\"gaussian\": { \"mean\": [0, 0], \"standard_deviation\": [0.15, 0.10] }";
const MIXTURE: &str = "\"mixture\": [\
    { \"weight\": 0.5, \"mean\": [0, 0], \"covariance\": [[1, 0], [0, 1]] }, \
    { \"weight\": 0.5, \"mean\": [0, 0], \"covariance\": [[1, 0], [0, 1]] }]";
const PEAK: &str = "{ \"single_peak\": { \"peak\": 1, \"peak_time\": 2 } }";

fn parse(text: String) -> FpkScene {
    SceneFile::from_text("scene.json", text).and_then(|file| file.parse()).unwrap()
}

/// What is replaced in a scene and by what, the line of the mistake, a part of its message, and its help.
type Mistake = (&'static str, &'static str, usize, &'static str, Option<&'static str>);

#[track_caller]
fn refused(scene: &str, mistakes: &[Mistake]) {
    for &(from, to, line, words, help) in mistakes {
        assert!(scene.contains(from), "{from}");
        let file = SceneFile::from_text("scene.json", scene.replacen(from, to, 1));
        let error = file.and_then(|file| file.parse::<FpkScene>()).unwrap_err();
        let mistake = error.mistake().unwrap();
        assert!(mistake.message.contains(words), "{to}: {}", mistake.message);
        assert_eq!(mistake.line, line, "{to}: {}", mistake.message);
        assert_eq!(help.and(mistake.help.as_deref()), help, "{to}");
    }
}

#[test]
fn every_built_in_scene_is_read_and_comes_back_from_its_result() {
    for text in [
        SCENE,
        BOUC_WEN,
        include_str!("../../../../tests/scenes/fpk/linear_oscillator.json"),
        include_str!("../../../../tests/scenes/fpk/kanai_tajimi.json"),
        include_str!("../../../../tests/scenes/fpk/damper_kanai_tajimi.json"),
        include_str!("../../../../tests/scenes/fpk/duffing.json"),
        include_str!("../../../../tests/scenes/fpk/van_der_pol.json"),
        include_str!("../../../../tests/scenes/fpk/two_storey.json"),
        include_str!("../../../../tests/scenes/fpk/bouc_wen_kanai_tajimi.json"),
    ] {
        let scene = parse(text.to_owned());
        assert_eq!(parse(serde_json::to_string(&scene).unwrap()), scene);
    }
}

/// What a method that needs a deviation says of a start from rest.
const AT_REST: Option<&str> = Some(
    "a density and its covariance need a deviation: monte_carlo and subset_simulation start at a point too",
);

const ORDER: &str = "it must be greater than the one before it";

#[test]
fn mistakes_in_an_oscillator_are_refused_at_their_lines() {
    refused(
        SCENE,
        &[
            (
                "\"noise_intensity\": 0.2",
                "\"noise_intensity\": -0.2",
                9,
                "it must be 0 or greater",
                None,
            ),
            ("\"mean\": [0, 0]", "\"mean\": [1e999, 0]", 18, "1e999", None),
            ("\"damper_coefficient\": 0.25", "\"damper_coefficient\": null", 14, "null", None),
            (
                "\"damper_exponent\"",
                "\"damper_exponant\"",
                15,
                "unknown key `damper_exponant`",
                Some("did you mean `damper_exponent`?"),
            ),
            ("\"count\": [49, 49]", "\"count\": [0, 41]", 19, "from 3 to 2000 particles", None),
            (
                "\"count\": [49, 49]",
                "\"count\": [41, 41, 41]",
                19,
                "there are 3 entries; the system has 2",
                None,
            ),
            ("[0.1, 0.25,", "[0.3, 0.25,", 22, ORDER, None),
            ("[0.15, 0.10]", "[0, 0.10]", 18, "0 was given; it must be greater than 0", AT_REST),
            ("\"gaussian\"", "\"stationary_filter\"", 18, "the system has no filter", None),
            (
                "\"reach\": 7",
                "\"reach\": 7, \"scheme\": \"runge_kuta_4\"",
                19,
                "`runge_kutta_4` or `lawson_adams_bashforth_2`",
                Some("did you mean `runge_kutta_4`?"),
            ),
            (FIT, SUBSET, 19, "1 was given; it must be between 0 and 1", None),
        ],
    );
}

#[test]
fn mistakes_in_a_hysteretic_oscillator_are_refused_at_their_lines() {
    refused(
        BOUC_WEN,
        &[
            (
                "\"hardening\"",
                "\"hardning\"",
                8,
                "unknown key `hardning`",
                Some("did you mean `hardening`?"),
            ),
            (
                "\"exponent\": 1",
                "\"exponent\": -1",
                12,
                "exponent is -1; it must be greater than 0",
                None,
            ),
            (
                "\"gamma\": 0.5",
                "\"gamma\": -0.5",
                11,
                "must be greater than -beta, which is -0.5",
                None,
            ),
            ("[0.5, 1, 1.5, 2]", "[0.5, 1.5, 1, 2]", 22, ORDER, None),
            (
                "\"mean\": [0, 0, 0]",
                "\"mean\": [0, 0]",
                17,
                "`mean` has 2 entries; the system has 3 states",
                Some("the states are q, v, z"),
            ),
            ("[[2, 0, 0],", "[[2, 0],", 20, "there are 2 entries; the system has 3 states", None),
            (
                "{ \"state\": \"q\" }",
                "{ \"state\": \"y\" }",
                21,
                "the system has no state `y`",
                Some("the states are q, v, z"),
            ),
            ("[\"q\", \"z\"]", "[\"q\", \"w\"]", 23, "the system has no state `w`", None),
            (
                "\"spacing\": 0.5",
                "\"spacing\": 0.5, \"count\": [9, 9, 9]",
                18,
                "either `count` for a box",
                None,
            ),
            (
                PEAK,
                "{ \"tabulated\": [[0, 0], [2, 1], [2, 0]] }",
                14,
                "row 2 is at 2; it must be greater",
                None,
            ),
            (
                BALL,
                "\"guided_paths\": { \"samples\": 100, \"step\": 0.01, \"integrator\": \"shark\", \"seed\": 1 }",
                18,
                "`integrator` was removed: use nothing in its place",
                None,
            ),
            (
                BALL,
                GRID,
                18,
                "this system has the states q, v, z",
                Some("use `flow_map_fit` for the density, `statistical_linearisation` for moments"),
            ),
        ],
    );
    let behind = "\"clough_penzien\": { \"structure\": { \"bouc_wen\": {";
    let filter = "} }, \"ground_frequency\": 15.6, \"ground_damping\": 0.6, \
                  \"low_cut_frequency\": 1.5, \"low_cut_damping\": 0.6";
    let filtered = BOUC_WEN.replacen(PEAK, &format!("{PEAK} {filter}"), 1);
    let words = "7 states; the density solver takes 6 at most";
    refused(&filtered, &[("\"bouc_wen\": {", behind, 5, words, None)]);
}

#[test]
fn a_grid_and_a_probability_take_what_they_know() {
    let on_grid = SCENE.replacen(FIT, GRID, 1);
    refused(
        &on_grid,
        &[
            (
                "\"cells\": 64",
                "\"cells\": 23",
                19,
                "23 was given; it must be from 24 to 8192",
                None,
            ),
            ("\"reach\": 8", "\"reach\": 3", 19, "3 was given; it must be at least 4", None),
            (
                "\"steps_per_period\": 40",
                "\"steps_per_period\": 5",
                19,
                "it must be at least 6",
                None,
            ),
            ("[4, 0]", "[5, 0]", 21, "of power 4 at most in each state on a grid", None),
            (
                "\"thresholds\"",
                "\"demand\": { \"state\": \"v\" }, \"thresholds\"",
                22,
                "the grid knows exceedances of the state q alone",
                Some("leave out `demand`"),
            ),
        ],
    );
    refused(
        &SCENE.replacen(FIT, GUIDED, 1),
        &[
            (
                "\"step\": 0.01",
                "\"step\": 1e-6",
                19,
                "such that a path has at most 100000 steps",
                None,
            ),
            ("[0.1, 0.25, 0.5, 0.75, 1, 1.25, 1.5]", "[]", 22, "there is no threshold", None),
            (NORMAL, MIXTURE, 18, "the method needs one normal distribution at the start", None),
        ],
    );
}

#[test]
fn steps_end_at_the_kinks_of_a_window_unless_a_table_is_finer_than_they_are() {
    let window = "{\n          \"rise_plateau_decay\": { \"rise_exponent\": 1, \"rise_end\": 2, \"decay_rate\": 2, \"decay_start\": 6 }\n        }";
    assert!(SCENE.contains(window));
    let of = |scene: &FpkScene| {
        let config = scene.method.density_config::<2>(2.0, 1.0);
        let (interval, kinks) = step_runs::Interval::of_scene(scene, config.as_ref(), 2.0);
        (interval.has_kinks, kinks)
    };
    assert_eq!(of(&parse(SCENE.to_owned())), (false, vec![2.0, 6.0]));
    let table = |rows: u32| {
        let rows = (0..rows).map(|k| format!("[{}, {}]", 0.01 * f64::from(k + 1), k % 2));
        let table = format!("{{ \"tabulated\": [{}] }}", rows.collect::<Vec<_>>().join(", "));
        parse(SCENE.replacen(window, &table, 1))
    };
    // 10 s of 2 s a period and 40 steps in each.
    let (has_kinks, kinks) = of(&table(200));
    assert!(!has_kinks && kinks.len() == 200 && kinks.is_sorted());
    assert_eq!(of(&table(201)), (true, vec![]));
    let paper = "\"canor_denoel_2013\": { \"count\": [50, 33], \"half_width\": [0.6, 0.4], \"courant\": 0.8, \
                 \"support_over_spacing\": 2.5 }";
    assert_eq!(of(&parse(SCENE.replacen(FIT, paper, 1))), (true, vec![]));
}

#[test]
fn a_structure_at_rest_is_a_start_of_sampled_paths() {
    let at_rest = SCENE.replacen("[0.15, 0.10]", "[0, 0]", 1);
    let paths = "\"monte_carlo\": { \"paths\": 100, \"step\": 0.01, \"seed\": 1 }";
    let subset = SUBSET.replace("\"correlation\": 1", "\"correlation\": 0.8");
    for method in [paths, &subset.replace("\"runs\": 2", "\"runs\": 4")] {
        let scene = parse(at_rest.replacen(FIT, method, 1));
        let (system, law) = (scene.system.build().unwrap(), scene.initial.build::<2>(None));
        let law = law.unwrap();
        assert!(law.covariance()[0][0] > 0.0 && law.covariance()[0][0] < 1e-200);
        assert!(scene.initial.check(&system, scene.method.starts_at_points()).is_ok());
    }
}

#[test]
fn linearisation_refuses_noise_that_depends_on_the_state() {
    let (start, end) =
        (SCENE.find("\"viscous_damper\"").unwrap(), SCENE.find("\"initial\"").unwrap());
    let system = "\"geometric_brownian_motion\": { \"growth\": 0.1, \"volatility\": 0.3 } },\n  ";
    let mean = "\"gaussian\": { \"mean\": [1], \"standard_deviation\": [0.1] }";
    let of_one_state = SCENE
        .replace(&SCENE[start..end], system)
        .replace(NORMAL, mean)
        .replace("[[2, 0], [1, 1], [0, 2], [4, 0], [2, 2], [0, 4]]", "[[2]]");
    let line = 1 + of_one_state.lines().position(|line| line.contains(FIT)).unwrap();
    let method = "\"statistical_linearisation\": { \"step\": 0.05 }";
    let help = Some("use `monte_carlo` or a density method");
    refused(&of_one_state, &[(FIT, method, line, "linearisation needs additive noise", help)]);
}

#[test]
fn each_method_takes_its_own_scheme_unless_another_is_asked_for() {
    let scheme = |method: &str| {
        let scene = parse(SCENE.replacen(FIT, method, 1));
        scene.method.density_config::<2>(2.0, 1.0).unwrap().method.combination().scheme
    };
    let paper = "\"canor_denoel_2013\": { \"count\": [50, 33], \"half_width\": [0.6, 0.4], \"courant\": 0.8, \
                 \"support_over_spacing\": 2.5 }";
    assert_eq!(scheme(paper), Scheme::ForwardEuler);
    assert_eq!(scheme(FIT), Scheme::RungeKutta4);
    let lawson = FIT.replace("7 }", "7, \"scheme\": \"lawson_adams_bashforth_2\" }");
    assert_eq!(scheme(&lawson), Scheme::LawsonAdamsBashforth2);
}

#[test]
fn five_states_say_that_nothing_is_integrated_over_their_cells_and_four_do_not() {
    let method = parse(SCENE.to_owned()).method;
    let Unknown { what, reason } = no_cells(&method, 5).unwrap();
    assert!(what.contains("exceedance-cell") && reason.contains("5 states"), "{what} {reason}");
    assert_eq!(no_cells(&method, 4), None);
}

#[test]
fn a_moment_has_the_unit_of_its_states() {
    let unit = |powers: &[u32], states| record::moment_unit(powers, states);
    let soil = &["q", "v", "xg", "vg"];
    for (powers, expected) in [
        ([2, 0, 0, 0], "m^2"),
        ([1, 1, 0, 0], "m^2/s"),
        ([0, 0, 1, 0], "m"),
        ([0, 1, 0, 1], "m^2/s^2"),
        ([0, 0, 0, 0], ""),
    ] {
        assert_eq!(unit(&powers, soil), expected, "{powers:?}");
    }
    assert_eq!(unit(&[0, 0, 2], &["q", "v", "z"]), "m^2");
    // A process in the unit of its user.
    assert_eq!(unit(&[2, 1], &["x1", "x2"]), "");
}
