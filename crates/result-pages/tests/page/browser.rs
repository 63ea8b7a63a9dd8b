//! The page in a browser: skipped, by this name, where none is installed.

use std::io::Write;

use crate::drive::{axe, browser, drive, violations, width_in_a_narrow_frame};
use crate::sample::page;
use result_pages::render;

#[test]
fn a_reader_moves_points_sorts_and_switches_without_an_error_or_a_request() {
    let Some(browser) = browser() else {
        let _ = writeln!(std::io::stderr(), "skipped: no Chromium is installed");
        return;
    };
    let html = render(&page()).unwrap();
    let seen = drive(&browser, &html);
    assert_eq!(seen["errors"], serde_json::json!([]), "{seen:#}");
    assert_eq!(seen["requests"], serde_json::json!([]));
    assert_eq!(seen["unlabelled"], serde_json::json!([]));
    // The title of the sample would set it.
    assert!(seen["hostile"].is_null());
    assert!(seen["width"].as_f64().unwrap() <= 0.0, "{}", seen["width"]);

    let motions = seen["motions"].as_array().unwrap();
    assert_eq!(motions.len(), 2);
    for motion in motions {
        assert!(motion["moves"] == true && motion["isBlank"] == false, "{motion:#}");
        assert_ne!(motion["texts"][0], motion["texts"][1]);
        assert!(motion["pointed"].as_str().unwrap().ends_with("under the pointer"), "{motion:#}");
    }
    assert_eq!((&motions[0]["frames"], &motions[1]["layers"]), (&6.into(), &2.into()));
    assert_eq!(motions[0]["value"], "t = 5 s");

    for chart in seen["charts"].as_array().unwrap() {
        for (place, x) in [("start", "0"), ("end", "10"), ("home", "0"), ("next", "0.5")] {
            let lines = &chart[place];
            assert_eq!(lines[0], format!("time (s): {x}"), "{place}");
            // The number, its error, how it is known, and the range.
            let text = lines[1].as_str().unwrap();
            let expected = ": 0.52082 ± 0.00042, from a coarser run; one standard deviation 0.0521";
            assert!(text.ends_with(expected), "{place}: {text}");
        }
    }
    let sorted = &seen["tables"][0];
    assert_eq!(sorted[0]["column"], serde_json::json!(["9", "10", "100"]));
    assert_eq!(sorted[1]["column"], serde_json::json!(["100", "10", "9"]));
    assert_eq!([&sorted[0]["order"], &sorted[1]["order"]], ["ascending", "descending"]);

    let themes = &seen["themes"];
    assert_ne!(themes[0]["ground"], themes[1]["ground"]);
    for theme in themes.as_array().unwrap() {
        // The least for text by WCAG 2.2, level AA.
        assert!(theme["contrast"].as_f64().unwrap() >= 4.5, "{theme:#}");
    }
    for text in seen["described"].as_array().unwrap() {
        assert!(text.as_str().unwrap().contains("Last values: "), "{text}");
    }
}

#[test]
fn the_page_fits_a_narrow_screen() {
    let Some(browser) = browser() else {
        let _ = writeln!(std::io::stderr(), "skipped: no Chromium is installed");
        return;
    };
    let width = width_in_a_narrow_frame(&browser, &render(&page()).unwrap());
    assert!(width <= 400.0, "{width}");
}

/// Contrast, names, roles and labels by axe-core in both themes: skipped, by this name, without it.
#[test]
fn axe_finds_nothing_to_object_to() {
    let (Some(browser), Some(axe)) = (browser(), axe()) else {
        let _ =
            writeln!(std::io::stderr(), "skipped: no Chromium, or AXE_CORE names no axe.min.js");
        return;
    };
    let seen = violations(&browser, &axe, &render(&page()).unwrap());
    assert_eq!(seen["violations"], serde_json::json!([]), "{seen:#}");
    assert!(seen["passes"].as_u64().unwrap() > 40, "{}", seen["passes"]);
}
