//! Which cases a filter means, and whether the table of cases is sound.

use std::collections::BTreeSet;

use scenes::nearest::nearest;

use super::VerifyError;
use crate::case::{Case, Profile};

/// A mistake in the table of cases.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum TableError {
    /// Two cases have one id.
    #[error("two cases have the id `{id}`")]
    DuplicateCase {
        /// That id.
        id: String,
    },
    /// An id is not of the form `crate/scene/...`.
    #[error("the case id `{id}` is not lower-case words joined by `-` and `/`")]
    IllFormedId {
        /// That id.
        id: String,
    },
}

/// Refuses duplicate and ill-formed ids.
///
/// # Errors
/// [`TableError`], naming the first.
pub fn check_table(cases: &[Case]) -> Result<(), TableError> {
    let mut seen = BTreeSet::new();
    for case in cases {
        if !well_formed(case.id) {
            return Err(TableError::IllFormedId { id: case.id.into() });
        }
        if !seen.insert(case.id) {
            return Err(TableError::DuplicateCase { id: case.id.into() });
        }
    }
    Ok(())
}

/// Lower-case words of letters, digits and `.`, joined by `-` and `/`; at least two parts.
pub(super) fn well_formed(id: &str) -> bool {
    let word = |word: &str| {
        !word.is_empty()
            && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '.')
    };
    id.contains('/') && id.split('/').all(|part| part.split('-').all(word))
}

/// The cases that `filters` mean: those whose id contains a filter, or is the case of the claim it names.
///
/// # Errors
/// [`VerifyError::NoMatch`] for a filter that means nothing, [`VerifyError::OutsideProfile`] for one that means
/// only cases `profile` leaves out, [`VerifyError::NothingToRun`] if nothing is left.
pub fn select<'a>(
    cases: &'a [Case],
    filters: &[String],
    profile: Profile,
) -> Result<Vec<&'a Case>, VerifyError> {
    for filter in filters {
        let mut matching = cases.iter().filter(|case| matches(case.id, filter)).peekable();
        let Some(first) = matching.peek().copied() else {
            return Err(no_match(cases, filter));
        };
        if !matching.any(|case| case.cost <= profile) {
            let (filter, id) = (filter.clone(), first.id.to_owned());
            return Err(VerifyError::OutsideProfile { filter, id, profile, cost: first.cost });
        }
    }
    let wanted =
        |case: &&Case| filters.is_empty() || filters.iter().any(|filter| matches(case.id, filter));
    let selected: Vec<&Case> =
        cases.iter().filter(|case| case.cost <= profile).filter(wanted).collect();
    if selected.is_empty() { Err(VerifyError::NothingToRun { profile }) } else { Ok(selected) }
}

fn matches(id: &str, filter: &str) -> bool {
    id.contains(filter) || filter.strip_prefix(id).is_some_and(|rest| rest.starts_with('/'))
}

fn no_match(cases: &[Case], filter: &str) -> VerifyError {
    // A filter is often one part of an id, so parts are compared too.
    let parts = cases.iter().flat_map(|case| std::iter::once(case.id).chain(case.id.split('/')));
    let nearest_part = nearest(filter, parts);
    let case = nearest_part.and_then(|part| cases.iter().find(|case| case.id.contains(part)));
    let hint = match (nearest_part, case) {
        (Some(part), Some(case)) if part == case.id => format!("did you mean `{part}`? "),
        (Some(part), Some(case)) => format!("did you mean `{part}`, as in `{}`? ", case.id),
        _ => String::new(),
    };
    VerifyError::NoMatch { filter: filter.into(), help: format!("{hint}--list shows all cases") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::tests::case;

    const CASES: [Case; 3] = [
        case("fpk-sph/linear-oscillator", Profile::Quick),
        case("fpk-sph/viscous-damper", Profile::Default),
        case("smpm/elastic-bar", Profile::Full),
    ];

    fn ids(filters: &[&str], profile: Profile) -> Result<Vec<&'static str>, VerifyError> {
        let filters: Vec<String> = filters.iter().map(|&filter| filter.to_owned()).collect();
        Ok(select(&CASES, &filters, profile)?.iter().map(|case| case.id).collect())
    }

    #[test]
    fn a_profile_runs_its_own_and_cheaper_cases() {
        assert_eq!(ids(&[], Profile::Quick).unwrap(), ["fpk-sph/linear-oscillator"]);
        assert_eq!(ids(&[], Profile::Default).unwrap().len(), 2);
        assert_eq!(ids(&[], Profile::Full).unwrap().len(), 3);
    }

    #[test]
    fn a_filter_is_part_of_an_id_or_the_id_of_a_claim() {
        assert_eq!(ids(&["damper"], Profile::Default).unwrap(), ["fpk-sph/viscous-damper"]);
        assert_eq!(
            ids(&["fpk-sph/viscous-damper/second-moment-q/t6"], Profile::Default).unwrap().len(),
            1
        );
        assert_eq!(ids(&["damper", "linear"], Profile::Default).unwrap().len(), 2);
    }

    #[test]
    fn a_filter_that_means_nothing_names_the_nearest_id() {
        let help_of = |filter| match ids(&[filter], Profile::Full).unwrap_err() {
            VerifyError::NoMatch { help, .. } => help,
            other => panic!("{other}"),
        };
        assert_eq!(
            help_of("viscus-damper"),
            "did you mean `viscous-damper`, as in `fpk-sph/viscous-damper`? --list shows all cases"
        );
        assert_eq!(
            help_of("fpk-sph/linear-oscilator"),
            "did you mean `fpk-sph/linear-oscillator`? --list shows all cases"
        );
        assert_eq!(help_of("zzzzzzzz"), "--list shows all cases");
    }

    #[test]
    fn a_filter_outside_the_profile_names_the_profile_it_needs() {
        let error = ids(&["elastic-bar"], Profile::Quick).unwrap_err();
        assert!(
            matches!(error, VerifyError::OutsideProfile { cost: Profile::Full, .. }),
            "{error}"
        );
    }

    #[test]
    fn nothing_to_run_is_an_error() {
        let error = select(&CASES[2..], &[], Profile::Quick).unwrap_err();
        assert!(matches!(error, VerifyError::NothingToRun { profile: Profile::Quick }));
    }

    #[test]
    fn duplicate_and_ill_formed_ids_are_refused() {
        let twice = [CASES[0], CASES[1], CASES[0]];
        assert!(matches!(check_table(&twice), Err(TableError::DuplicateCase { .. })));
        for id in ["single", "A/b", "a//b", "a/b-", "a/b c"] {
            assert!(
                matches!(
                    check_table(&[case(id, Profile::Quick)]),
                    Err(TableError::IllFormedId { .. })
                ),
                "{id}"
            );
        }
    }
}
