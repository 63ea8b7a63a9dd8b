//! Invented charts for tests and visual inspection.

use crate::data::{
    Line, Measure, Method, Reading, ReferencePoint, ReferencePoints, Run, RunOutcome, Scale,
    TimeSeries, Words, WorkPrecision,
};

fn words(title: &str, subtitle: &str, y_label: &str, x_label: &str) -> Words {
    Words {
        title: title.into(),
        subtitle: subtitle.into(),
        x_label: x_label.into(),
        y_label: y_label.into(),
        caption: vec![
            "Made-up numbers. Bars: one standard error of the error, and the scatter of the time over five runs.".into(),
            "Example CPU @ 2.00 GHz, 1 thread of 2 cores, load 0.3, commit 0123456789ab".into(),
        ],
    }
}

/// Words of a chart over a plane, without a subtitle or a caption.
#[cfg(test)]
pub(crate) fn named(title: &str) -> Words {
    Words { caption: Vec::new(), ..words(title, "", "y (m)", "x (m)") }
}

fn method(name: &str, runs: &[(f64, f64, f64, &str)]) -> Method {
    let run = |&(cost, value, bar, label): &(f64, f64, f64, &str)| Run {
        cost,
        cost_error: Some(0.07 * cost),
        outcome: RunOutcome::Error { value, standard_error: (bar > 0.0).then_some(bar) },
        label: (!label.is_empty()).then(|| label.to_owned()),
    };
    Method { name: name.into(), runs: runs.iter().map(run).collect() }
}

/// Error against cost of four methods, one of which fails at its ends.
#[must_use]
pub fn work_precision() -> WorkPrecision {
    let mut paper = method(
        "summation density, isotropic, forward Euler (the paper's)",
        &[
            (0.4, 0.09, 0.0, "400"),
            (1.9, 0.045, 0.0, "1,700"),
            (8.0, 0.032, 0.0, "6,600"),
            (34.0, 0.028, 0.0, "26,000"),
        ],
    );
    let failed = |cost| Run {
        cost,
        cost_error: None,
        outcome: RunOutcome::Failed { reason: "step collapsed".into() },
        label: Some("1.5".into()),
    };
    paper.runs.extend([failed(0.9), failed(3.1)]);
    let series = vec![
        method(
            "log-density fit, whitened, RK4",
            &[
                (0.12, 0.02, 0.0, "400"),
                (0.8, 0.006, 0.0, "1,700"),
                (3.6, 0.0017, 0.0, "6,600"),
                (17.0, 0.0005, 0.0, "26,000"),
            ],
        ),
        paper,
        method(
            "Monte Carlo, forward Euler",
            &[
                (0.1, 0.11, 0.03, "10⁴"),
                (1.0, 0.035, 0.01, "10⁵"),
                (10.0, 0.013, 0.004, "10⁶"),
                (100.0, 0.009, 0.002, "10⁷"),
            ],
        ),
        method(
            "Monte Carlo, Strang",
            &[
                (0.05, 0.1, 0.03, "10⁴"),
                (0.5, 0.031, 0.01, "10⁵"),
                (5.0, 0.011, 0.012, "10⁶"),
                (50.0, 0.003, 0.001, "10⁷"),
            ],
        ),
    ];
    let subtitle = "Nonlinear viscous damper, P(|q| > 1) at t = 6";
    WorkPrecision {
        words: words("Error against cost", subtitle, "|error of log10 P|", "CPU time (s)"),
        reading: Reading::Cost { unit: "s".into(), errors: Measure::Log10, reference_error: 1e-3 },
        series,
    }
}

/// Three decaying lines over time and a set of reference points.
#[must_use]
pub fn time_series(scale: Scale) -> TimeSeries {
    let decay = |t: f64, rate: f64| 0.02 + (-rate * t).exp() * (1.0 + 0.3 * (3.0 * t).cos());
    let line = |name: &str, rate: f64| {
        let points =
            (0..=120).map(|i| 0.05 * f64::from(i)).map(|t| (t, Some(decay(t, rate)))).collect();
        Line { name: name.into(), points }
    };
    let reference = |t: i32| {
        let t = f64::from(t);
        ReferencePoint { x: t, y: decay(t, 0.8), error: Some(0.2 * decay(t, 0.8)) }
    };
    TimeSeries {
        words: words(
            "Second moments",
            "Linear oscillator, made-up decay",
            "E[q²] (m²)",
            "time (s)",
        ),
        scale,
        lines: vec![
            line("E[q²], log-density fit", 0.8),
            line("E[v²], log-density fit", 1.1),
            line("E[qv]", 0.5),
        ],
        bands: Vec::new(),
        references: vec![ReferencePoints {
            name: "closed form, one sigma".into(),
            points: (1..=6).map(reference).collect(),
        }],
    }
}

/// Writes the pictures: `SAMPLE_FOLDER=dir cargo test -p verification sample`.
#[test]
fn sample_charts_for_the_eye() {
    let Some(folder) = std::env::var_os("SAMPLE_FOLDER") else { return };
    let folder = std::path::PathBuf::from(folder);
    let write = |name: &str, svg: String| std::fs::write(folder.join(name), svg).unwrap();
    write("work_precision.svg", super::work_precision(&work_precision()).unwrap());
    write("linear.svg", super::time_series(&time_series(Scale::Linear)).unwrap());
    write("log.svg", super::time_series(&time_series(Scale::Log)).unwrap());
}
