//! The report as one self-contained page, in the style of the page of a run: no request, no file beside it.

use minijinja::{AutoEscape, Environment, Value, context};
use result_figures::number;
use scenes::machine;

use crate::report::{CaseRecord, Claim, Counts, Report};

const TEMPLATE: &str = include_str!("page.html");

/// The page of a report, to read in a browser.
///
/// # Errors
/// Those of the template engine.
pub fn render_html(report: &Report) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("page.html", TEMPLATE)?;
    let counts = report.counts();
    let seconds: f64 = report.cases.iter().map(|case| case.seconds).sum();
    let cases: Vec<Value> =
        report.cases.iter().enumerate().map(|(i, case)| case_value(i, case)).collect();
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

fn case_value(index: usize, case: &CaseRecord) -> Value {
    let claims: Vec<Value> = case.claims.iter().map(|claim| claim_value(claim, &case.id)).collect();
    let counts = Counts::of(&case.claims);
    context! {
        anchor => format!("case-{index}"),
        id => &case.id,
        title => &case.title,
        source => &case.source,
        seconds => format!("{:.2}", case.seconds),
        counts => counts_value(counts),
        failed => counts.failed,
        claims => claims,
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
        kind => claim.kind.name(),
        passed => claim.passed,
    }
}

#[cfg(test)]
mod tests {
    use result_figures::Measured;
    use scenes::machine::Machine;

    use super::*;
    use crate::case::Profile;
    use crate::claim::Subject;

    fn claim(name: &str, value: f64) -> Claim {
        Subject::new(format!("self-check/page/{name}"), "P(|q| > 1)", "least squares")
            .unit("m^2")
            .relative(Measured::sampled(value, 1e-3), 1.0)
            .within(0.01)
            .because("truncation < 1 %")
    }

    #[test]
    fn the_page_shows_verdicts_and_reasons_and_escapes_text() {
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
        let page = render_html(&report).unwrap();
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
            "<code>self-check/<wbr>page</code>",
        ] {
            assert!(page.contains(expected), "{expected} is missing from\n{page}");
        }
        assert_eq!(page.matches(">fail<").count(), 2);
        assert_eq!(page.matches(">pass<").count(), 1);
        // Self-contained: nothing is fetched.
        assert!(!page.contains("src=") && !page.contains("<link") && !page.contains("url("));
    }
}
