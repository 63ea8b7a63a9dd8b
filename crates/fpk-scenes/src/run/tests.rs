//! Invalid density scenes and their messages.

use fpk_sph::Scheme;

use super::*;

const SCENE: &str = include_str!("../../../../tests/scenes/fpk/viscous_damper.json");
const BOUC_WEN: &str = include_str!("../../../../tests/scenes/fpk/bouc_wen.json");

/// Replaces a text of the scene and returns the resulting message with line, column and help.
fn mistake(from: &str, to: &str) -> (String, usize, usize, Option<String>) {
    mistake_in(SCENE, from, to)
}

fn mistake_in(scene: &str, from: &str, to: &str) -> (String, usize, usize, Option<String>) {
    assert!(scene.contains(from), "{from}");
    let file = SceneFile::from_text("scene.json", scene.replacen(from, to, 1));
    let error = file.and_then(|file| file.parse::<FpkScene>()).unwrap_err();
    let mistake = error.mistake().unwrap();
    (mistake.message.clone(), mistake.line, mistake.column, mistake.help.clone())
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
        let file = SceneFile::from_text("scene.json", text.to_owned()).unwrap();
        let scene: FpkScene = file.parse().unwrap();
        let written = serde_json::to_string(&scene).unwrap();
        let again = SceneFile::from_text("result.json", written).unwrap();
        assert_eq!(again.parse::<FpkScene>().unwrap(), scene);
    }
}

#[test]
fn a_misspelt_key_of_the_hysteretic_scene_is_refused_where_it_stands() {
    let (message, line, column, help) = mistake_in(BOUC_WEN, "\"hardening\"", "\"hardning\"");
    assert!(message.starts_with("unknown key `hardning`"), "{message}");
    assert_eq!((line, column), (8, 7));
    assert_eq!(help.as_deref(), Some("did you mean `hardening`?"));
}

#[test]
fn a_negative_exponent_and_a_loop_without_a_limit_are_refused_where_they_stand() {
    let (message, line, column, _) = mistake_in(BOUC_WEN, "\"exponent\": 1", "\"exponent\": -1");
    assert_eq!(message, "exponent is -1; it must be greater than 0");
    assert_eq!((line, column), (12, 19));
    let (message, line, ..) = mistake_in(BOUC_WEN, "\"gamma\": 0.5", "\"gamma\": -0.5");
    assert_eq!(message, "gamma is -0.5; it must be greater than -beta, which is -0.5");
    assert_eq!(line, 11);
}

#[test]
fn thresholds_that_are_not_sorted_are_refused_where_they_stand() {
    let (message, line, column, _) = mistake_in(BOUC_WEN, "[0.5, 1, 1.5, 2]", "[0.5, 1.5, 1, 2]");
    assert_eq!(message, "1 was given; it must be greater than the one before it");
    assert_eq!((line, column), (22, 28));
}

#[test]
fn lists_of_another_length_than_the_system_has_states_are_refused_where_they_stand() {
    let (message, line, _, help) = mistake_in(BOUC_WEN, "\"mean\": [0, 0, 0]", "\"mean\": [0, 0]");
    assert_eq!(message, "`mean` has 2 entries; the system has 3 states");
    assert_eq!((line, help.as_deref()), (17, Some("the states are q, v, z")));
    let (message, line, ..) = mistake_in(BOUC_WEN, "[[2, 0, 0],", "[[2, 0],");
    assert_eq!(message, "there are 2 entries; the system has 3 states");
    assert_eq!(line, 20);
    let (message, line, ..) = mistake("\"count\": [49, 49]", "\"count\": [41, 41, 41]");
    assert_eq!(message, "there are 3 entries; the system has 2 states");
    assert_eq!(line, 19);
}

#[test]
fn a_state_that_is_none_is_refused_with_those_that_are() {
    let (message, line, _, help) =
        mistake_in(BOUC_WEN, "{ \"state\": \"q\" }", "{ \"state\": \"y\" }");
    assert_eq!(message, "the system has no state `y`");
    assert_eq!((line, help.as_deref()), (21, Some("the states are q, v, z")));
    let (message, line, ..) = mistake_in(BOUC_WEN, "[\"q\", \"z\"]", "[\"q\", \"w\"]");
    assert_eq!((message.as_str(), line), ("the system has no state `w`", 23));
}

#[test]
fn a_box_and_a_ball_at_once_and_an_integrator_of_another_system_are_refused() {
    let (message, ..) =
        mistake_in(BOUC_WEN, "\"spacing\": 0.5", "\"spacing\": 0.5, \"count\": [9, 9, 9]");
    assert_eq!(message, "either `count` for a box or `spacing` for a ball must be given");
    let sampled = "\"monte_carlo\": { \"paths\": 100, \"step\": 0.01, \"seed\": 1, \
                   \"integrator\": \"strang_oscillator\" }";
    let fit = "\"flow_map_fit\": { \"spacing\": 0.5, \"reach\": 5 }";
    let (message, _, _, help) = mistake_in(BOUC_WEN, fit, sampled);
    assert_eq!(message, "the integrator Strang does not apply to this system");
    assert_eq!(
        help.as_deref(),
        Some("leave it out: paths of this system are by Strang with hysteresis")
    );
}

const LATTICE: &str = "\"count\": [49, 49], \"reach\": 7";

fn with_scheme(name: &str) -> String {
    format!("{LATTICE}, \"scheme\": \"{name}\"")
}

#[test]
fn a_scheme_that_is_none_is_refused_with_those_that_are() {
    let (message, line, _, help) = mistake(LATTICE, &with_scheme("runge_kuta_4"));
    for name in ["runge_kutta_4", "lawson_adams_bashforth_2"] {
        assert!(message.contains(&format!("`{name}`")), "{message}");
    }
    assert_eq!((line, help.as_deref()), (19, Some("did you mean `runge_kutta_4`?")));
}

#[test]
fn each_method_takes_its_own_scheme_unless_another_is_asked_for() {
    let scheme = |method: &str| {
        let scene: FpkScene = SceneFile::from_text("scene.json", SCENE.replacen(FIT, method, 1))
            .unwrap()
            .parse()
            .unwrap();
        scene.method.density_config::<2>(2.0, 1.0).unwrap().method.combination().scheme
    };
    let paper = "\"canor_denoel_2013\": { \"count\": [50, 33], \"half_width\": [0.6, 0.4], \"courant\": 0.8, \
                 \"support_over_spacing\": 2.5 }";
    assert_eq!(scheme(paper), Scheme::ForwardEuler);
    assert_eq!(scheme(FIT), Scheme::RungeKutta4);
    let asked = format!("\"flow_map_fit\": {{ {} }}", with_scheme("lawson_adams_bashforth_2"));
    assert_eq!(scheme(&asked), Scheme::LawsonAdamsBashforth2);
}

#[test]
fn a_filter_needs_a_system_that_has_one_and_at_most_six_states() {
    let (message, line, ..) = mistake("\"gaussian\"", "\"stationary_filter\"");
    assert_eq!((message.as_str(), line), ("the system has no filter", 18));
    let scene = BOUC_WEN.replacen(
        "\"bouc_wen\": {",
        "\"clough_penzien\": { \"structure\": { \"bouc_wen\": {",
        1,
    );
    let filter = "} }, \"ground_frequency\": 15.6, \"ground_damping\": 0.6, \
                  \"low_cut_frequency\": 1.5, \"low_cut_damping\": 0.6";
    let window = "\"window\": { \"single_peak\": { \"peak\": 1, \"peak_time\": 2 } }\n";
    let (message, line, ..) =
        mistake_in(&scene, window, &format!("{} {filter}", window.trim_end()));
    assert!(message.contains("7 states; the density solver takes 6 at most"), "{message}");
    assert_eq!(line, 5);
}

#[test]
fn a_window_that_does_not_increase_is_refused_where_it_stands() {
    let (message, line, ..) = mistake_in(
        BOUC_WEN,
        "{ \"single_peak\": { \"peak\": 1, \"peak_time\": 2 } }",
        "{ \"tabulated\": [[0, 0], [2, 1], [2, 0]] }",
    );
    assert!(message.contains("row 2 is at 2; it must be greater"), "{message}");
    assert_eq!(line, 14);
}

#[test]
fn five_states_say_that_nothing_is_integrated_over_their_cells_and_four_do_not() {
    let file = SceneFile::from_text("scene.json", SCENE.to_owned()).unwrap();
    let method = file.parse::<FpkScene>().unwrap().method;
    let Unknown { what, reason } = no_cells(&method, 5).unwrap();
    assert!(what.contains("exceedance-cell") && reason.contains("5 states"), "{what} {reason}");
    assert_eq!(no_cells(&method, 4), None);
}

#[test]
fn a_negative_diffusion_is_refused_where_it_stands() {
    let (message, line, column, _) =
        mistake("\"noise_intensity\": 0.2", "\"noise_intensity\": -0.2");
    assert_eq!(message, "noise_intensity is -0.2; it must be 0 or greater");
    assert_eq!((line, column), (9, 28));
}

#[test]
fn a_mean_beyond_the_range_a_null_and_an_unknown_key_are_refused_where_they_stand() {
    let (message, line, ..) = mistake("\"mean\": [0, 0]", "\"mean\": [1e999, 0]");
    assert!(message.contains("1e999") && line == 18, "{message} {line}");
    let (message, line, ..) =
        mistake("\"damper_coefficient\": 0.25", "\"damper_coefficient\": null");
    assert!(message.contains("null") && line == 14, "{message} {line}");
    let (message, line, _, help) = mistake("\"damper_exponent\"", "\"damper_exponant\"");
    assert!(message.contains("damper_exponant") && line == 15, "{message} {line}");
    assert_eq!(help.as_deref(), Some("did you mean `damper_exponent`?"));
}

#[test]
fn zero_particles_and_thresholds_out_of_order_are_refused_where_they_stand() {
    let (message, line, ..) = mistake("\"count\": [49, 49]", "\"count\": [0, 41]");
    assert_eq!((message.as_str(), line), ("0 was given; it must be from 3 to 2000 particles", 19));
    let (message, line, ..) = mistake("[0.1, 0.25,", "[0.3, 0.25,");
    assert_eq!(
        (message.as_str(), line),
        ("0.25 was given; it must be greater than the one before it", 22)
    );
}

const FIT: &str = "\"flow_map_fit\": { \"count\": [49, 49], \"reach\": 7 }";
const FLOW: &str = "\"flow_map_fit\": { \"spacing\": 0.5, \"reach\": 5 }";
const GRID: &str =
    "\"conservative_grid\": { \"cells\": 64, \"reach\": 8, \"steps_per_period\": 40 }";

#[test]
fn a_grid_takes_oscillators_and_what_it_knows_of_them() {
    let (message, line, _, help) = mistake_in(BOUC_WEN, FLOW, GRID);
    assert!(message.contains("the states q, v; this system has the states q, v, z"), "{message}");
    assert!(line == 18 && help.unwrap().contains("`flow_map_fit`"));
    let (message, ..) = mistake(FIT, &GRID.replace("64", "23"));
    assert_eq!(message, "23 was given; it must be from 24 to 8192");
    let (message, ..) = mistake(FIT, &GRID.replace("\"reach\": 8", "\"reach\": 3"));
    assert_eq!(message, "3 was given; it must be at least 4");
    let (message, ..) = mistake(FIT, &GRID.replace("40", "5"));
    assert_eq!(message, "5 was given; it must be at least 6");
    let on_grid = SCENE.replacen(FIT, GRID, 1);
    let (message, line, ..) = mistake_in(&on_grid, "[4, 0]", "[5, 0]");
    assert_eq!(message, "5 was given; it must be of power 4 at most in each state on a grid");
    assert_eq!(line, 21);
    let demand = "\"demand\": { \"state\": \"v\" }, \"thresholds\"";
    let (message, .., help) = mistake_in(&on_grid, "\"thresholds\"", demand);
    assert_eq!(message, "the grid knows exceedances of the state q alone");
    assert_eq!(help.as_deref(), Some("leave out `demand`"));
}

#[test]
fn one_probability_needs_a_threshold_a_normal_start_and_an_integrator_of_the_system() {
    let method = |integrator: &str, step: &str| {
        format!(
            "\"guided_paths\": {{ \"samples\": 100, \"step\": {step}, \
             \"integrator\": \"{integrator}\", \"seed\": 1 }}"
        )
    };
    let (message, .., help) = mistake_in(BOUC_WEN, FLOW, &method("shark", "0.01"));
    assert_eq!(message, "the integrator ShARK does not apply to this system");
    assert_eq!(
        help.as_deref(),
        Some("leave it out: paths of this system are by Strang with hysteresis")
    );
    let (message, ..) = mistake(FIT, &method("strang_oscillator", "1e-6"));
    assert_eq!(message, "1e-6 was given; it must be such that a path has at most 100000 steps");
    let scene = SCENE.replacen(FIT, &method("strang_oscillator", "0.01"), 1);
    let (message, line, ..) = mistake_in(&scene, "[0.1, 0.25, 0.5, 0.75, 1, 1.25, 1.5]", "[]");
    assert!(message.contains("there is no threshold") && line == 22, "{message} {line}");
    let component = "{ \"weight\": 0.5, \"mean\": [0, 0], \"covariance\": [[1, 0], [0, 1]] }";
    let mixture = format!("\"mixture\": [{component}, {component}]");
    let normal = "\"gaussian\": { \"mean\": [0, 0], \"standard_deviation\": [0.15, 0.10] }";
    let (message, line, ..) = mistake_in(&scene, normal, &mixture);
    assert_eq!(message, "the method needs one normal distribution at the start");
    assert_eq!(line, 18);
    let subset = "\"subset_simulation\": { \"samples\": 100, \"correlation\": 1, \"runs\": 2, \
                  \"step\": 0.01, \"integrator\": \"strang_oscillator\", \"seed\": 1 }";
    let (message, ..) = mistake(FIT, subset);
    assert_eq!(message, "1 was given; it must be between 0 and 1");
}

#[test]
fn linearisation_refuses_noise_that_depends_on_the_state() {
    let start = SCENE.find("\"viscous_damper\"").unwrap();
    let end = SCENE.find("\"initial\"").unwrap();
    let of_one_state = [
        (
            &SCENE[start..end],
            "\"geometric_brownian_motion\": { \"growth\": 0.1, \"volatility\": 0.3 } },\n  ",
        ),
        (
            "\"mean\": [0, 0], \"standard_deviation\": [0.15, 0.10]",
            "\"mean\": [1], \"standard_deviation\": [0.1]",
        ),
        ("[[2, 0], [1, 1], [0, 2], [4, 0], [2, 2], [0, 4]]", "[[2]]"),
    ];
    let scene = of_one_state.iter().fold(SCENE.to_owned(), |scene, (from, to)| {
        assert!(scene.contains(from), "{from}");
        scene.replacen(from, to, 1)
    });
    let method = "\"statistical_linearisation\": { \"step\": 0.05 }";
    let (message, .., help) = mistake_in(&scene, FIT, method);
    assert!(message.contains("linearisation needs additive noise"), "{message}");
    assert!(help.unwrap().contains("`monte_carlo`"));
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
