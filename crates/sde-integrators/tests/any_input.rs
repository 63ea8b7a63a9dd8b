//! Whatever numbers come in, laws, factors, methods and first steps end in a result or a typed error: no panic, no hang, no memory
//! beyond [`MOST_BYTES`], no NaN in a result. `PROPTEST_CASES` says how many are tried.

#[path = "any_input/drawn.rs"]
mod drawn;
#[path = "any_input/ensembles.rs"]
mod ensembles;
#[path = "any_input/fields.rs"]
mod fields;
#[path = "any_input/rare.rs"]
mod rare;

use std::alloc::System;

use cap::Cap;
use proptest::prelude::*;
use sde_integrators::{
    AdaptivePath, DiagonalNoise, Estimate, Milstein, Noise, Samples, Sra1, StepControl,
};

use drawn::{Cubic, cubic, is_told, number, numbers};
pub(crate) use ensembles::{ensemble, has_maxima, is_followed_by_every_method, watched};
pub(crate) use fields::{field, steps_by_every_factor};
pub(crate) use rare::{estimates_the_rare, rare};

/// An allocation beyond it ends the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// A system, its start, the control of its step, seed and realisation.
type Path = (Cubic, [f64; 2], StepControl, (u64, u64));

pub(crate) fn adaptive_path() -> impl Strategy<Value = Path> {
    let halvings = prop_oneof![6 => 0_u32..20, 1 => any::<u32>()];
    let control = (number(), number(), number(), halvings).prop_map(
        |(longest, absolute, relative, halvings)| StepControl {
            longest,
            absolute,
            relative,
            halvings,
        },
    );
    (cubic(), prop::array::uniform2(number()), control, any::<(u64, u64)>())
}

pub(crate) fn adapts(
    (system, start, control, (seed, realisation)): Path,
) -> Result<(), TestCaseError> {
    let noise = Noise::new(seed);
    if let Ok(mut path) = AdaptivePath::new(&system, &Sra1, &noise, realisation, start, &control) {
        let _ = path.step().and_then(|_| path.step());
        prop_assert!(path.state().iter().all(|x| x.is_finite()));
    }
    let system = DiagonalNoise(system);
    let path = AdaptivePath::new(&system, &Milstein, &noise, realisation, start, &control);
    if let Ok(mut path) = path {
        let _ = path.step().and_then(|_| path.step());
        prop_assert!(path.state().iter().all(|x| x.is_finite()));
    }
    Ok(())
}

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
    fn an_adaptive_path_starts_or_says_why_not(path in adaptive_path()) {
        adapts(path)?;
    }

    #[test]
    fn a_field_starts_or_says_why_not(field in field()) {
        steps_by_every_factor(field)?;
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
