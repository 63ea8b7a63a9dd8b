//! Whatever numbers come in, laws, factors, methods and first steps end in a result or a typed error: no panic, no hang, no memory
//! beyond [`MOST_BYTES`], no NaN in a result. `PROPTEST_CASES` says how many are tried.

#[path = "any_input/drawn.rs"]
mod drawn;
#[path = "any_input/ensembles.rs"]
mod ensembles;
#[path = "any_input/factors.rs"]
mod factors;
#[path = "any_input/rare.rs"]
mod rare;

use std::alloc::System;

use cap::Cap;
use proptest::prelude::*;
use sde_integrators::{Estimate, Samples};

use drawn::{is_told, number, numbers};
pub(crate) use ensembles::{ensemble, has_maxima, is_followed_by_every_method, watched};
pub(crate) use factors::{entries, makes_every_factor};
pub(crate) use rare::{estimates_the_rare, rare};

/// An allocation beyond it ends the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// Values, a level, a probability, hits and trials.
type Sample = (Vec<f64>, f64, f64, (u64, u64));

pub(crate) fn sample() -> impl Strategy<Value = Sample> {
    (numbers(), number(), number(), any::<(u64, u64)>())
}

pub(crate) fn tells_numbers(
    (values, level, probability, (hits, trials)): Sample,
) -> Result<(), TestCaseError> {
    if let Ok(samples) = Samples::new(values) {
        for estimate in [samples.exceedance(level), samples.quantile(probability)].iter().flatten()
        {
            prop_assert!(is_told(estimate), "{estimate:?}");
        }
    }
    if let Ok(estimate) = Estimate::probability(hits, trials) {
        prop_assert!(is_told(&estimate), "{estimate:?}");
    }
    Ok(())
}

proptest! {
    #[test]
    fn an_ensemble_is_followed_by_every_method_or_says_why_not(ensemble in ensemble()) {
        is_followed_by_every_method(ensemble)?;
    }

    #[test]
    fn a_factor_is_made_or_says_why_not(entries in entries()) {
        makes_every_factor(entries)?;
    }

    #[test]
    fn a_sample_tells_numbers_or_says_why_not(sample in sample()) {
        tells_numbers(sample)?;
    }

    #[test]
    fn an_ensemble_has_maxima_or_says_why_not(watched in watched()) {
        has_maxima(watched)?;
    }

    #[test]
    fn the_rare_is_estimated_or_says_why_not(rare in rare()) {
        estimates_the_rare(rare)?;
    }
}
