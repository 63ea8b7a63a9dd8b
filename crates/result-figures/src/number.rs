//! Number formatting: enough digits to compare, no more.

use crate::error_kind::ErrorKind;

/// A value with six significant digits and its uncertainty with two: `0.0412345 ± 1.2e-5`; `-` for none.
#[must_use]
pub fn with_uncertainty(value: Option<f64>, uncertainty: Option<f64>) -> String {
    match (value, uncertainty) {
        (None, _) => "-".into(),
        (Some(value), None) => long(value),
        (Some(value), Some(uncertainty)) => format!("{} ± {uncertainty:.1e}", long(value)),
    }
}

/// Six significant digits.
#[must_use]
pub fn long(value: f64) -> String {
    digits(value, 6)
}

/// All digits of a number that was given, with an exponent where zeros would fill the line.
#[must_use]
pub fn exact(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() || (1e-5..1e15).contains(&size) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// As [`exact`], without the last six digits, which are roundoff of a product or a difference.
#[must_use]
pub fn tidy(value: f64) -> String {
    exact(format!("{value:.9e}").parse().unwrap_or(value))
}

/// Three significant digits; `-` for none.
#[must_use]
pub fn short(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |value| digits(value, 3))
}

/// A fraction in per cent with three significant digits.
///
/// Errors and changes that are many times the value are printed as `> 1000 %`.
#[must_use]
pub fn percent(part: f64) -> String {
    const MOST: f64 = 10.0;
    if part > MOST { "> 1000 %".to_owned() } else { format!("{} %", short(Some(100.0 * part))) }
}

/// A signed error with three significant digits; logarithms and factors are marked as such.
#[must_use]
pub fn error(value: Option<f64>, kind: ErrorKind) -> String {
    let Some(value) = value else { return "-".into() };
    if kind == ErrorKind::Ratio {
        return format!("x{}", digits(value, 3));
    }
    let sign = if value > 0.0 { "+" } else { "" };
    format!("{sign}{}", digits(value, 3))
}

/// `1 case`, `2 cases`.
#[must_use]
pub fn counted(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

fn digits(value: f64, n_digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let exponent = value.abs().log10().floor();
    if (-3.0..6.0).contains(&exponent) {
        #[expect(clippy::cast_possible_truncation, reason = "the exponent lies in -3..6")]
        let before_point = exponent as i32 + 1;
        let decimals = usize::try_from(i32::try_from(n_digits).unwrap_or(i32::MAX) - before_point)
            .unwrap_or(0);
        // Integers are printed as integers.
        let decimals = if value.fract() == 0.0 { 0 } else { decimals };
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", n_digits - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_size_of_the_number() {
        assert_eq!(long(0.0412345678), "0.0412346");
        assert_eq!(long(1234.5678), "1234.57");
        assert_eq!(long(-4.8e-9), "-4.80000e-9");
        assert_eq!(long(1700.0), "1700");
        assert_eq!(long(123456.7), "123457");
        assert_eq!(short(Some(2e-4)), "2.00e-4");
        assert_eq!(
            ["1e-300", "0.25", "-3"].map(|text| exact(text.parse().unwrap())),
            ["1e-300", "0.25", "-3"]
        );
        assert_eq!([tidy(3.0 * 0.1), tidy(3.2 - 2.0), tidy(0.0)], ["0.3", "1.2", "0"]);
        assert_eq!(short(None), "-");
        assert_eq!(with_uncertainty(Some(0.5), Some(0.00123)), "0.500000 ± 1.2e-3");
    }

    #[test]
    fn one_is_not_many() {
        assert_eq!([0, 1, 2].map(|n| counted(n, "case")), ["0 cases", "1 case", "2 cases"]);
    }

    #[test]
    fn errors_carry_their_sign_or_their_factor() {
        assert_eq!(error(Some(0.031), ErrorKind::Relative), "+0.0310");
        assert_eq!(error(Some(-0.031), ErrorKind::Log10), "-0.0310");
        assert_eq!(error(Some(2.5), ErrorKind::Ratio), "x2.50");
        assert_eq!(error(Some(0.0), ErrorKind::Absolute), "0");
    }
}
