//! Errors by kind, and verdicts on both sides of each criterion.

use super::*;

const WHY: &str = "a reason";

fn subject() -> Subject {
    Subject::new("self-check/claim", "x", "by hand").unit("m")
}

fn within(kind: ErrorKind, m: f64, r: f64, tolerance: f64) -> Claim {
    subject().compared(kind, m, r).within(tolerance).because(WHY)
}

fn close(found: Option<f64>, expected: f64) {
    assert!((found.unwrap() - expected).abs() < 1e-12, "{found:?} is not {expected}");
}

#[test]
fn each_kind_forms_its_error() {
    close(within(ErrorKind::Relative, 1.01, 1.0, 0.1).error, 0.01);
    close(within(ErrorKind::Relative, -1.01, -1.0, 0.1).error, -0.01);
    close(within(ErrorKind::Absolute, 3.0, 5.0, 3.0).error, -2.0);
    close(within(ErrorKind::Log10, 1e-9, 1e-8, 2.0).error, -1.0);
    close(within(ErrorKind::Ratio, 2.0, 8.0, 5.0).error, 4.0);
    close(within(ErrorKind::Ratio, 8.0, 2.0, 5.0).error, 4.0);
}

#[test]
fn the_tolerance_decides_on_both_sides() {
    for (m, passed) in [(1.09, true), (0.91, true), (1.11, false), (0.89, false)] {
        assert_eq!(within(ErrorKind::Relative, m, 1.0, 0.1).passed, passed, "{m}");
    }
    assert!(within(ErrorKind::Ratio, 1.9, 1.0, 2.0).passed);
    assert!(!within(ErrorKind::Ratio, 1.0, 2.1, 2.0).passed);
}

#[test]
fn what_is_not_a_number_fails_and_says_so() {
    for claim in [
        within(ErrorKind::Relative, f64::NAN, 1.0, 1.0),
        within(ErrorKind::Absolute, 1.0, f64::NAN, 1.0),
        within(ErrorKind::Absolute, 1.0, 1.0, f64::NAN),
        within(ErrorKind::Absolute, f64::INFINITY, f64::INFINITY, f64::INFINITY),
        within(ErrorKind::Relative, 0.0, 0.0, 1.0),
        within(ErrorKind::Log10, 0.0, 1e-9, 1.0),
        within(ErrorKind::Ratio, -1.0, 1.0, 9.0),
    ] {
        assert!(!claim.passed && claim.reason.contains("[failed: "), "{claim:?}");
        assert!(result_figures::finite::check(&claim).is_ok());
    }
}

#[test]
fn a_claim_without_a_reason_fails() {
    let value = (Measured::exact(1.0), Reference::exact(1.0));
    assert!(!subject().absolute(value.0, value.1).within(1.0).because(" ").passed);
    assert!(!subject().measured(value.0, (0.0, 2.0)).because("").passed);
}

#[test]
fn a_reference_less_certain_than_the_tolerance_proves_nothing() {
    let judge =
        |error| subject().relative(2.0, Reference::uncertain(2.0, error)).within(0.01).because(WHY);
    assert!(judge(0.019).passed);
    assert!(!judge(0.021).passed);
}

#[test]
fn a_monte_carlo_claim_passes_within_bias_and_four_standard_errors() {
    let judge = |m, se, re| {
        subject()
            .absolute(Measured::sampled(m, se), Reference::uncertain(1.0, re))
            .monte_carlo(0.1)
            .because(WHY)
    };
    assert!(judge(1.49, 0.1, 0.0).passed);
    assert!(!judge(1.51, 0.1, 0.0).passed);
    close(judge(1.0, 0.03, 0.04).tolerance, 0.1 + 4.0 * 0.05);
    assert!(!subject().absolute(1.0, 1.0).monte_carlo(1.0).because(WHY).passed);
}

#[test]
fn the_spread_of_a_logarithm_is_relative() {
    let claim = subject().log10(Measured::sampled(2e-8, 1e-9), 2e-8).monte_carlo(0.0).because(WHY);
    close(claim.tolerance, 4.0 * 0.05 / std::f64::consts::LN_10);
}

#[test]
fn an_order_needs_a_standard_error_below_its_tolerance() {
    let judge = |m| subject().order(m, 2.0).within(0.2).because(WHY).passed;
    assert!(judge(Measured::sampled(1.9, 0.05)));
    assert!(!judge(Measured::exact(1.9)));
    assert!(!judge(Measured::sampled(1.9, 0.3)));
}

#[test]
fn a_regression_claim_has_a_range_and_says_so() {
    let judge = |m| subject().relative(m, 1.0).as_measured(0.02, 0.04).because("summation bias");
    assert!(judge(1.03).passed && !judge(1.01).passed && !judge(0.97).passed);
    assert_eq!(judge(1.03).reason, "as measured, error in [0.02, 0.04]: summation bias");
    assert!(subject().measured(40.0, (39.0, 41.0)).because("steps").passed);
    assert!(!subject().measured(f64::NAN, (39.0, 41.0)).because("steps").passed);
}

#[test]
fn equal_bits_need_something_to_compare() {
    assert!(subject().same_bits(0, 10).because(WHY).passed);
    assert!(!subject().same_bits(1, 10).because(WHY).passed);
    assert!(!subject().same_bits(0, 0).because(WHY).passed);
}

#[test]
fn the_part_of_a_tolerance_that_the_error_takes() {
    close(within(ErrorKind::Relative, 0.99, 1.0, 0.1).used(), 0.1);
    close(within(ErrorKind::Ratio, 2.0, 1.0, 3.0).used(), 0.5);
    close(within(ErrorKind::Absolute, 1.0, 1.0, 0.0).used(), 0.0);
    assert_eq!(subject().measured(1.0, (0.0, 2.0)).because(WHY).used(), None);
}

#[test]
fn the_grounds_of_a_monte_carlo_claim_are_without_its_numbers() {
    let (measured, reference) = (Measured::sampled(1.0, 0.1), Reference::exact(1.0));
    let claim = subject().absolute(measured, reference).monte_carlo(0.01).because("step: 0.1");
    assert!(claim.reason.starts_with("bias bound 0.01 + 4 s.e."), "{}", claim.reason);
    assert_eq!(claim.grounds(), "step: 0.1");
    assert_eq!(within(ErrorKind::Absolute, 1.0, 1.0, 0.1).grounds(), WHY);
}

#[test]
fn regression_bounds_and_missed_aims_fall_short() {
    let bound = subject().measured(1.0, (0.0, 2.0)).because(WHY);
    assert!(bound.is_regression_bound() && bound.falls_short());
    let held = within(ErrorKind::Absolute, 1.0, 1.0, 0.1);
    assert!(!held.is_regression_bound() && !held.falls_short());
    let missed = Claim { reason: "1 % is not reached: switches".into(), ..held };
    assert!(!missed.is_regression_bound() && missed.falls_short());
}

#[test]
fn the_kind_of_a_claim_follows_from_how_it_is_judged() {
    let kind_of =
        |kind, value, reference, tolerance| within(kind, value, reference, tolerance).kind;
    assert_eq!(kind_of(ErrorKind::Relative, 1.0, 1.0, 0.1), ClaimKind::Accuracy);
    // A count: no tolerance about a whole number.
    assert_eq!(kind_of(ErrorKind::Absolute, 3.0, 3.0, 0.0), ClaimKind::Structural);
    assert_eq!(kind_of(ErrorKind::Absolute, 3.0, 3.0, 0.5), ClaimKind::Accuracy);
    assert_eq!(kind_of(ErrorKind::Absolute, 0.25, 0.25, 0.0), ClaimKind::Accuracy);
    assert_eq!(subject().same_bits(0, 10).because(WHY).kind, ClaimKind::Structural);
    assert_eq!(Claim::case_error("a", "b").kind, ClaimKind::Structural);
    let bound = subject().measured(1.0, (0.0, 2.0)).because(WHY);
    assert_eq!(bound.kind, ClaimKind::RegressionBound);
    let held = within(ErrorKind::Absolute, 1.0, 1.0, 0.1);
    assert_eq!(held.structural().kind, ClaimKind::Structural);
}

#[test]
fn a_tolerance_over_ten_times_the_error_is_loose() {
    let is_loose = |error: f64, tolerance, reason: &str| {
        let claim = within(ErrorKind::Absolute, 1.0 + error, 1.0, tolerance);
        Claim { reason: reason.into(), ..claim }.is_loose()
    };
    assert!(is_loose(0.125, 1.5, "truncation") && !is_loose(0.125, 1.0, "truncation"));
    assert!(is_loose(0.0, 1e-12, "truncation") && !is_loose(0.0, 0.0, "truncation"));
    for reason in ["roundoff: 40 operations", "statistics: a small sample", "chaos: the last bit"] {
        assert!(!is_loose(0.0, 1e-12, reason), "{reason}");
        assert!(is_loose(0.0, 1e-12, reason.split_once(' ').unwrap().1), "{reason}");
    }
    // A factor of 1 is no error.
    assert!(!within(ErrorKind::Ratio, 1.25, 1.0, 3.0).is_loose());
    assert!(within(ErrorKind::Ratio, 1.125, 1.0, 3.0).is_loose());
    let bound = subject().measured(1.0, (0.0, 200.0)).because(WHY);
    assert!(!bound.is_loose());
    let (measured, reference) = (Measured::sampled(1.0, 1.0), Reference::exact(1.0));
    assert!(!subject().absolute(measured, reference).monte_carlo(1.0).because(WHY).is_loose());
}
