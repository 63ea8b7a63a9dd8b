//! Content of a page, without a browser.

use crate::sample::{HOSTILE, page};
use result_pages::{
    Cell, Frame, Layer, Motion, Page, PageError, Place, Points, Scale, Table, render,
};

/// Size that a page without large fields must not exceed.
const MOST_BYTES: usize = 3_000_000;

#[test]
fn the_page_has_answers_notes_tables_and_nothing_from_outside() {
    let html = render(&page()).unwrap();
    for expected in [
        "0.52082 <span class=\"error\">± 0.00042</span>",
        "0.0806 % of the value",
        "<strong>Warning:</strong> a warning",
        "More values",
        "`cloud` turns them on",
        "data-number=\"9",
        "Last values:",
        "somebody2001",
        "Copyright (c) 2022 Leon Sorokin",
        "default-src &#x27;none&#x27;",
    ] {
        assert!(
            html.contains(expected) || html.contains(&expected.replace("&#x27;", "'")),
            "{expected}"
        );
    }
    // Equal notes are one, and warnings come first.
    assert_eq!(html.matches("<li>a remark</li>").count(), 1);
    assert!(html.find("a warning") < html.find("a remark"));
    for outside in ["<link", " src=", "@import", "url("] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert!(html.len() < MOST_BYTES, "{}", html.len());
}

#[test]
fn text_of_a_scene_is_shown_and_never_run() {
    let html = render(&page()).unwrap();
    assert!(!html.contains(HOSTILE) && !html.contains("<script>document.body"));
    // The scripts of the page itself: data, uPlot, programs.
    assert_eq!((html.matches("<script").count(), html.matches("</script>").count()), (3, 3));
    assert!(
        html.contains("&lt;&#x2f;script&gt;&lt;script&gt;document.body")
            && html.contains("\\u003c/script\\u003e")
    );
}

#[test]
fn a_number_that_is_not_finite_is_refused_with_its_place() {
    let mut broken = page();
    broken.charts[1].series[0].points[2].y = f64::NAN;
    let error = render(&broken).unwrap_err();
    assert!(matches!(error, PageError::Number(_)));
    let cause = std::error::Error::source(&error).unwrap().to_string();
    assert!(cause.contains("charts[1].series[0].points[2].y"), "{cause}");
    let mut broken = page();
    broken.motions[1].layers[0].values[2].pop();
    let error = render(&broken).unwrap_err().to_string();
    assert_eq!(error, "frame 2 of the field `pressure` has 399 values; 400 are required");
}

#[test]
fn long_series_are_thinned_and_the_page_says_so() {
    let mut long = page();
    let series = &mut long.charts[0].series[0];
    let first = series.points[0].clone();
    series.points =
        (0..60_000).map(|k| result_pages::Point { x: f64::from(k), ..first.clone() }).collect();
    let html = render(&long).unwrap();
    // 60,063 points in all: one in eleven.
    assert!(html.contains("One in 11 points is shown") && html.contains("{\"x\":59999.0,"));
    assert!(html.len() < MOST_BYTES, "{}", html.len());
    assert!(!render(&page()).unwrap().contains("points is shown"));
}

/// Writes the page for the eye: `SAMPLE_FOLDER=dir cargo test -p pages sample`.
#[test]
fn sample_page_for_the_eye() {
    let Some(folder) = std::env::var_os("SAMPLE_FOLDER") else { return };
    std::fs::write(std::path::Path::new(&folder).join("index.html"), render(&page()).unwrap())
        .unwrap();
}

#[test]
fn a_page_stays_below_its_limit_and_says_what_it_left_out() {
    let mut large = page();
    let n = 4000_u16;
    let frame = |k: usize| Frame { name: format!("t = {k}") };
    large.motions = vec![Motion {
        title: "Stress".to_owned(),
        about: String::new(),
        slider: "time".to_owned(),
        axes: vec!["x (m)".to_owned()],
        frames: (0..1000).map(frame).collect(),
        place: Place::Points(Points {
            spacing: 1.0,
            positions: vec![(0..n).map(f64::from).collect()],
        }),
        layers: vec![Layer {
            name: "stress".to_owned(),
            unit: "Pa".to_owned(),
            scale: Scale::Linear,
            values: (0..1000_u16).map(|k| vec![f32::from(k); n.into()]).collect(),
        }],
    }];
    let row = |k: usize| vec![Cell::text(format!("row {k} {}", "x".repeat(100)))];
    let (title, about) = ("All values".to_owned(), String::new());
    let heads = vec!["value".to_owned()];
    large.tables = vec![Table { title, about, heads, rows: (0..60_000).map(row).collect() }];
    let html = render(&large).unwrap();
    assert!(html.len() <= Page::MOST_BYTES, "{}", html.len());
    assert!(html.contains("left out: frames of &quot;Stress&quot;"));
    assert!(html.contains("left out: the last rows of &quot;All values&quot;"));
    // The last frame and the first rows are there.
    assert!(html.contains("t = 999") && html.contains("row 0 x"));
}
