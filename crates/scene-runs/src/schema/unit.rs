//! The unit in the parentheses of a description.

/// Symbols of units, besides powers and numbers; `u` is the unit of a state defined in a description.
const SYMBOLS: [&str; 12] =
    ["m", "s", "kg", "N", "J", "Pa", "K", "rad", "degree", "u", "per", "MB"];

/// The first unit in a description, and the description without it.
///
/// A unit is text in parentheses that contains the word `unit` or `units`, or consists of unit symbols only.
pub(super) fn split(about: &str) -> Option<(&str, String)> {
    let mut from = 0;
    while let Some(open) = about[from..].find('(').map(|at| from + at) {
        let Some(close) = closing(&about[open..]).map(|at| open + at) else { break };
        let inside = &about[open + 1..close];
        if is_unit(inside) {
            let rest = format!("{}{}", about[..open].trim_end(), &about[close + 1..]);
            return Some((inside, rest));
        }
        from = open + 1;
    }
    None
}

/// Position at which the opening parenthesis of a text closes.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    text.char_indices().find_map(|(at, c)| {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        (depth == 0).then_some(at)
    })
}

fn is_unit(text: &str) -> bool {
    let mut words = text.split(|c: char| !c.is_alphabetic());
    if words.any(|word| word == "unit" || word == "units") {
        return true;
    }
    // A power of a parenthesis leaves an empty string before its `^`.
    let factors = text.split([' ', '/', '(', ')']).filter_map(|factor| factor.split('^').next());
    let factors: Vec<&str> = factors.filter(|factor| !factor.is_empty()).collect();
    factors.iter().any(|factor| SYMBOLS.contains(factor))
        && factors.iter().all(|factor| *factor == "1" || SYMBOLS.contains(factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_found_among_other_words_in_parentheses() {
        let (unit, rest) =
            split("Rise (Canor & Denoël 2013, eq 27), to `f(t)` (m^2/s^3).").unwrap();
        assert_eq!(
            (unit, rest.as_str()),
            ("m^2/s^3", "Rise (Canor & Denoël 2013, eq 27), to `f(t)`.")
        );
        for unit in [
            "no unit",
            "1/s",
            "u^0.5/s^0.5",
            "1/(u^2 s)",
            "m/s^2 per (m/s)^alpha",
            "length/time^2 of `units`",
            "unit of each state",
        ] {
            let about = format!("A number ({unit}), positive.");
            assert_eq!(split(&about), Some((unit, "A number, positive.".to_owned())));
        }
    }

    #[test]
    fn words_and_formulas_in_parentheses_are_no_units() {
        for about in
            ["A number.", "Of `(m + 0.015) dx`.", "A number (positive).", "It opens (m", "(1)"]
        {
            assert_eq!(split(about), None, "{about}");
        }
    }
}
