//! The report as one self-contained page, in the style of the page of a run: no request, no file beside it.

use minijinja::{AutoEscape, Environment, Value, context};
use result_figures::number;
use scenes::machine;

use crate::case::InlineChart;
use crate::report::{CaseRecord, Claim, Counts, Report};

const TEMPLATE: &str = include_str!("page.html");

/// The page of a report, with the charts under the cases that showed them.
///
/// # Errors
/// Those of the template engine.
pub fn render_page(report: &Report, charts: &[InlineChart]) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("page.html", TEMPLATE)?;
    let counts = report.counts();
    let seconds: f64 = report.cases.iter().map(|case| case.seconds).sum();
    let cases: Vec<Value> =
        report.cases.iter().enumerate().map(|(i, case)| case_value(i, case, charts)).collect();
    environment.get_template("page.html")?.render(context! {
        style => Value::from_safe_string(result_pages::STYLE.to_owned()),
        programs => Value::from_safe_string([result_pages::THEME, result_pages::SORT].join("\n")),
        counts => counts_value(counts),
        failed => report.failed,
        version => &report.version,
        commit => report.commit.as_deref().map(machine::short),
        profile => report.profile.name(),
        machine => context! {
            cpu => &report.machine.cpu,
            cores => report.machine.cores,
            threads => report.machine.threads,
            load => report.machine.load_average.map(|load| format!("{load:.2}")),
            os => &report.machine.os,
            arch => &report.machine.arch,
        },
        seconds => format!("{seconds:.1}"),
        cases => cases,
    })
}

fn case_value(index: usize, case: &CaseRecord, charts: &[InlineChart]) -> Value {
    let claims: Vec<Value> = case.claims.iter().map(|claim| claim_value(claim, &case.id)).collect();
    let counts = Counts::of(&case.claims);
    let charts = charts.iter().filter(|chart| chart.case_id == case.id);
    let charts: Vec<Value> =
        charts.map(|chart| context! { title => &chart.title, svg => &chart.svg }).collect();
    context! {
        anchor => format!("case-{index}"),
        id => &case.id,
        title => &case.title,
        source => &case.source,
        seconds => format!("{:.2}", case.seconds),
        counts => counts_value(counts),
        failed => counts.failed,
        claims => claims,
        charts => charts,
        skipped => &case.skipped,
    }
}

fn counts_value(counts: Counts) -> Value {
    context! {
        accuracy => counts.accuracy,
        structural => counts.structural,
        regression_bounds => counts.regression_bounds,
        bounds_word => if counts.regression_bounds == 1 { "bound" } else { "bounds" },
        loose => counts.loose,
    }
}

fn claim_value(claim: &Claim, case_id: &str) -> Value {
    context! {
        name => claim.id.strip_prefix(case_id).unwrap_or(&claim.id).trim_start_matches('/'),
        quantity => &claim.quantity,
        unit => &claim.unit,
        method => &claim.method,
        measured => number::with_uncertainty(claim.measured, claim.standard_error),
        reference => number::with_uncertainty(claim.reference, claim.reference_error),
        error => number::error(claim.error, claim.error_kind),
        error_kind => claim.error.map(|_| claim.error_kind.name()),
        tolerance => number::short(claim.tolerance),
        reason => &claim.reason,
        kind => claim.kind().name(),
        passed => claim.passed,
    }
}

#[cfg(test)]
mod tests {
    use result_figures::{ErrorKind, Measured, Reference};
    use scenes::machine::Machine;

    use super::*;
    use crate::case::Profile;
    use crate::claim::{Criterion, Subject};

    fn claim(name: &str, value: f64) -> Claim {
        Claim::judge(
            Subject::new(format!("self-check/page/{name}"), "P(|q| > 1)", "m^2", "least squares"),
            ErrorKind::Relative,
            Measured::sampled(value, 1e-3),
            Reference::exact(1.0),
            Criterion::Within { tolerance: 0.01, reason: "truncation < 1 %" },
        )
    }

    #[test]
    fn the_page_shows_verdicts_reasons_and_charts_and_escapes_text() {
        let case = CaseRecord {
            id: "self-check/page".into(),
            title: "a page & its <claims>".into(),
            source: "none".into(),
            seconds: 1.5,
            cpu_seconds: 2.5,
            claims: vec![
                claim("good", 1.001),
                claim("bad", 1.5),
                Claim::case_error("self-check/page", "stopped"),
            ],
            skipped: vec!["ranks: no <MPI>".into()],
        };
        let report = Report::new(Profile::Quick, Machine::read(), vec![case]);
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"></svg>".to_owned();
        let chart = InlineChart { case_id: "self-check/page".into(), title: "moments".into(), svg };
        let page = render_page(&report, &[chart]).unwrap();
        for expected in [
            "<strong>Skipped</strong> ranks: no &lt;MPI&gt;",
            "1 of accuracy",
            "0 structural",
            "0 regression bounds",
            "0 loose",
            "2 failed",
            "<td>structural</td>",
            "a page &amp; its &lt;claims&gt;",
            "truncation &lt; 1 %",
            "<svg ",
            "moments",
        ] {
            assert!(page.contains(expected), "{expected} is missing from\n{page}");
        }
        assert_eq!(page.matches(">fail<").count(), 2);
        assert_eq!(page.matches(">pass<").count(), 1);
        // Self-contained: nothing is fetched.
        assert!(!page.contains("src=") && !page.contains("<link") && !page.contains("url("));
    }

    /// Writes the page of a made-up report for the eye: `SAMPLE_FOLDER=dir cargo test -p verification sample`.
    #[test]
    fn sample_page_for_the_eye() {
        let Some(folder) = std::env::var_os("SAMPLE_FOLDER") else { return };
        let times = [1, 2, 6];
        let claims = |case: &str| -> Vec<Claim> {
            let of_time = |t: &i32| {
                let mut claim =
                    claim(&format!("second-moment-q/t{t}"), 1.0 + 0.002 * f64::from(*t));
                claim.id = format!("{case}/second-moment-q/t{t}");
                claim.quantity = format!("E[q^2] at t = {t}");
                claim
            };
            times.iter().map(of_time).collect()
        };
        let case = |id: &str, title: &str, extra: Option<Claim>| CaseRecord {
            id: id.into(),
            title: title.into(),
            source: "A paper, Journal 12 (2013) 34-56, section 4.1, eqs 26 and 27".into(),
            seconds: 1.23,
            cpu_seconds: 2.1,
            claims: claims(id).into_iter().chain(extra).collect(),
            skipped: Vec::new(),
        };
        let failed = Claim::case_error(
            "self-check/damper",
            "step collapsed: dt = 3e-8 below 1e-6 of a period",
        );
        let cases = vec![
            case("self-check/oscillator", "Made-up rows of an oscillator", None),
            case("self-check/damper", "Made-up rows of a damper", Some(failed)),
        ];
        let svg =
            result_figures::work_precision(&result_figures::samples::work_precision()).unwrap();
        let chart = InlineChart {
            case_id: "self-check/oscillator".into(),
            title: "Error against cost".into(),
            svg,
        };
        let report = Report::new(Profile::Quick, Machine::read(), cases);
        let path = std::path::Path::new(&folder).join("page.html");
        std::fs::write(path, render_page(&report, &[chart]).unwrap()).unwrap();
    }
}
