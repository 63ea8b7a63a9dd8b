//! A page with everything that a page can have.

use result_pages::{
    Answer, Cell, Cells, Chart, Fact, Frame, Layer, Motion, Note, Page, Place, Point, Points,
    Scale, SceneKey, Series, Source, Table,
};

/// A text that would run, or break the page, if it were not escaped.
pub(crate) const HOSTILE: &str =
    "</script><script>document.body.dataset.hostile = 1</script><b>&amp;\"'";

/// The decimals of a number that the page shows under the pointer.
pub(crate) const SHOWN: f64 = 0.520815759215;

pub(crate) fn page() -> Page {
    Page {
        title: format!("A sample of made-up numbers {HOSTILE}"),
        solver: "sample".into(),
        notes: vec![
            Note::Remark("a remark".into()),
            Note::Warning(format!("a warning {HOSTILE}")),
            Note::Remark("a remark".into()),
        ],
        answers: vec![answer("E[q^2]", SHOWN, Some(4.2e-4)), answer("P(|q| > 1.5)", 3.1e-5, None)],
        motions: vec![density(), bodies()],
        absent: vec!["Particles over time: `cloud` turns them on.".into()],
        charts: vec![chart(false), chart(true)],
        tables: vec![table()],
        facts: vec![Fact { name: "Method".into(), text: "log-density fit".into() }],
        scene: vec![key("times.every", "0.1", false), key("method.bandwidth", "null", true)],
        sources: vec![Source {
            key: "somebody2001",
            text: "Somebody, A. (2001). Title. Journal.",
            role: "method",
        }],
        files: vec!["result.json".into(), "moments.svg".into()],
        origin: "pages 0.1.0".into(),
    }
}

fn answer(quantity: &str, value: f64, error: Option<f64>) -> Answer {
    Answer {
        quantity: format!("{quantity} {HOSTILE}"),
        at: "t = 10 s".into(),
        value,
        error,
        bound: None,
        unit: "m^2".into(),
        how: "from a coarser run".into(),
    }
}

fn chart(is_logarithmic: bool) -> Chart {
    let point = |k: i32, phase: f64| {
        let x = 0.5 * f64::from(k);
        let y = SHOWN * (-phase * (x - 10.0) / 10.0).exp();
        Point {
            x,
            y,
            error: Some(4.2e-4),
            bound: None,
            how: "from a coarser run".into(),
            spread: Some(0.1 * y),
        }
    };
    let series = |phase: f64| Series {
        name: format!("series {phase} {HOSTILE}"),
        points: (0..=20).map(|k| point(k, phase)).collect(),
    };
    Chart {
        title: format!("Moments {HOSTILE}"),
        x_label: "time (s)".into(),
        y_label: "second moment (m^2)".into(),
        is_logarithmic,

        x_is_logarithmic: false,
        spread: "one standard deviation".into(),
        series: vec![series(0.0), series(1.0)],
    }
}

fn density() -> Motion {
    const N: usize = 40;
    let frame = |t: usize| {
        let at = move |k: usize| {
            let x = |i: usize| -3.0 + 6.0 * (i as f64 + 0.5) / N as f64;
            let (q, v) = (x(k % N) - 0.2 * t as f64, x(k / N));
            #[expect(
                clippy::cast_possible_truncation,
                reason = "single precision is what is packed"
            )]
            let density = (-0.5 * (q * q + v * v)).exp() as f32;
            density
        };
        (0..N * N).map(at).collect()
    };
    let cells = Cells { count: [N, N], x: [-3.0, 3.0], y: [-3.0, 3.0] };
    Motion {
        title: "Density of q and v".into(),
        about: "Made up.".into(),
        slider: "time".into(),
        axes: vec!["q (m)".into(), "v (m/s)".into()],
        frames: (0..6).map(|t| Frame { name: format!("t = {t} s") }).collect(),
        place: Place::Cells(vec![cells; 6]),
        layers: vec![Layer {
            name: "density".into(),
            unit: String::new(),
            scale: Scale::SixDecades,
            values: (0..6).map(frame).collect(),
        }],
    }
}

fn bodies() -> Motion {
    const N: u32 = 20;
    let positions = |t: u32| {
        let at = |k: u32| [f64::from(k % N) + 0.5 * f64::from(t), f64::from(k / N)];
        (0..N * N).flat_map(at).collect()
    };
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let values = |t: u32| (0..N * N).map(|k| (k + 10 * t) as f32).collect::<Vec<f32>>();
    let layer = |name: &str| Layer {
        name: name.into(),
        unit: "Pa".into(),
        scale: Scale::Linear,
        values: (0..3).map(values).collect(),
    };
    Motion {
        title: "Particles".into(),
        about: "Made up.".into(),
        slider: "time".into(),
        axes: vec!["x (m)".into(), "y (m)".into()],
        frames: (0..3).map(|t| Frame { name: format!("t = {t} s") }).collect(),
        place: Place::Points(Points { spacing: 1.0, positions: (0..3).map(positions).collect() }),
        layers: vec![layer("pressure"), layer("flow stress")],
    }
}

fn table() -> Table {
    let row = |(name, value): (&str, f64)| {
        vec![Cell::text(format!("{name} {HOSTILE}")), Cell::number(value.to_string(), value)]
    };
    Table {
        title: "All values".into(),
        about: "Made up.".into(),
        heads: vec!["quantity".into(), "value".into()],
        rows: [("b", 10.0), ("a", 9.0), ("c", 100.0)].map(row).to_vec(),
    }
}

fn key(key: &str, value: &str, is_default: bool) -> SceneKey {
    SceneKey {
        key: key.into(),
        value: value.into(),
        unit: "s".into(),
        is_default,
        meaning: format!("A key {HOSTILE}."),
    }
}
