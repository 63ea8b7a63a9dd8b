use result_figures::Reference;
use scenes::machine::Machine;

use super::rows::MOST_ROWS;
use super::*;
use crate::claim::Subject;
use crate::report::Claim;

const METHOD: &str = "log-density fit";
const TRUNCATION: &str = "truncation < 1 %";

/// A claim whose error is this part of its tolerance.
fn claim(name: &str, used: f64) -> Claim {
    Subject::new(format!("self-check/page/{name}"), "P(|q| > 1)", METHOD)
        .unit("m^2")
        .relative(1.0 + 0.01 * used, Reference::uncertain(1.0, 1e-4))
        .within(0.01)
        .because(TRUNCATION)
}

fn bound(name: &str) -> Claim {
    Subject::new(format!("self-check/page/{name}"), "x", "the paper's method")
        .relative(1.3, 1.0)
        .as_measured(0.2, 0.4)
        .because("it loses particles")
}

fn report(claims: Vec<Claim>) -> Report {
    let case = CaseRecord {
        id: "self-check/page".into(),
        title: "a page & its <claims>".into(),
        source: "A paper, eq 26.".into(),
        seconds: 1.5,
        cpu_seconds: 2.5,
        claims,
        skipped: vec!["ranks: no MPI".into()],
    };
    Report::new(Profile::Default, Machine::read(), vec![case])
}

fn page(claims: Vec<Claim>) -> String {
    let page = render_page(&report(claims));
    assert!(page.contains("\nSkipped ranks: no MPI.\n"), "{page}");
    page
}

#[test]
fn a_claim_stands_with_value_reference_tolerance_reason_verdict_and_command() {
    let page = page(vec![claim("good", 0.4), claim("bad", 1.4), bound("paper")]);
    for expected in [
        "profile default, 1 case, 3 claims, 1 of accuracy, 0 structural, 1 regression bound; 1 failed; 0 loose.",
        "| [self-check](#self-check) | 1 | 3 | 1 | 0 | 1 | 1 | 0 | 2.50 |",
        "- **failed** `self-check/page/bad`: truncation \\< 1 % [failed: the error 1.400e-2 exceeds",
        "### self-check/page\n\na page & its \\<claims>. Source: A paper, eq 26.",
        "`cargo xtask verify self-check/page`: 3 claims, **1 failed**, CPU 2.50 s.",
        "| good | P(\\|q\\| > 1) (m^2) | 1.00400 | 1 ± 1.0e-4 | +0.00400 relative | 0.0100 | 1 | 1 | 40 % | passed |",
        "| 140 % | **failed** |",
        "| 2 | 3 | regression bound | passed |",
        "By:\n\n1. log-density fit\n2. the paper's method\n",
        "3. as measured, error in [0.2, 0.4]: it loses particles\n",
    ] {
        assert!(page.contains(expected), "{expected} is missing from\n{page}");
    }
}

#[test]
fn of_many_claims_the_worst_of_each_family_stand_worst_first_with_what_failed_or_falls_short() {
    let family = |k: u32| {
        (0..3).map(move |t| {
            let claim = claim(&format!("moment-{k}/t{t}"), 0.01 * f64::from(10 * k + t));
            // By another method each, and of one quantity.
            Claim { quantity: format!("moment {k}"), method: format!("method {t}"), ..claim }
        })
    };
    let mut claims: Vec<Claim> = (0..8).flat_map(family).collect();
    // Of one family, and yet all there.
    claims.extend((0..9).map(|t| bound(&format!("paper/t{t}"))));
    claims.push(claim("moment-0/t9", 1.4));
    let page = page(claims);
    let names: Vec<&str> = page
        .lines()
        .filter(|line| line.starts_with("| moment-") || line.starts_with("| paper"))
        .map(|line| line.split('|').nth(1).unwrap().trim())
        .collect();
    let bounds: Vec<String> = (0..9).map(|t| format!("paper/t{t}")).collect();
    let mut expected = vec!["moment-0/t9"];
    expected.extend(bounds.iter().map(String::as_str));
    expected.extend(["moment-7/t2", "moment-6/t2"]);
    assert_eq!(names, expected);
    assert_eq!(names.len(), MOST_ROWS);
    assert!(page.contains("| moment-7/t2 | 3 |"), "{page}");
    assert!(
        page.contains("18 claims more, of 6 quantities or reasons; the worst used 52 %: `cargo xtask verify self-check/page --json FILE` has all."),
        "{page}"
    );
}

#[test]
fn what_falls_short_is_never_left_out() {
    let page = page((0..20).map(|t| bound(&format!("paper/t{t}"))).collect());
    assert_eq!(page.matches("| regression bound |").count(), 20);
    assert!(!page.contains("claims more"), "{page}");
}
