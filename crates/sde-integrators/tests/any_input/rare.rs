//! Probabilities of rare events, by subset simulation.

use proptest::prelude::*;
use sde_integrators::{
    DrivenPath, Estimate, Heun, Noise, SubsetConfig, Uncertainty, subset_simulation,
};

use super::drawn::{Cubic, count, cubic, is_told, number};

/// A path and what of it is rare.
#[derive(Debug)]
pub(crate) struct Rare {
    system: Cubic,
    start: [f64; 2],
    dt: f64,
    n_steps: usize,
    /// Beside those that the path takes, as a rule none.
    more_normals: usize,
    /// Whether the response is a ratio, which need not be a number.
    is_ratio: bool,
    threshold: f64,
    subset: SubsetConfig,
}

pub(crate) fn rare() -> impl Strategy<Value = Rare> {
    let more = prop_oneof![20 => Just(0), 1 => count()];
    let n_samples = prop_oneof![9 => 100_usize..120, 1 => count()];
    let n_runs = prop_oneof![9 => 0_u64..4, 1 => any::<u64>()]
        .prop_filter("runs that are made, and only slow", |n| !(4..=1 << 16).contains(n));
    let correlation = prop_oneof![4 => 0.1..0.9, 1 => number()];
    let subset = (n_samples, correlation, n_runs).prop_map(|(n_samples, correlation, n_runs)| {
        SubsetConfig { n_samples, correlation, n_runs }
    });
    (
        (cubic(), prop::array::uniform2(number()), number(), 0_usize..4),
        (more, any::<bool>(), number()),
        subset,
    )
        .prop_map(
            |((system, start, dt, n_steps), (more_normals, is_ratio, threshold), subset)| Rare {
                system,
                start,
                dt,
                n_steps,
                more_normals,
                is_ratio,
                threshold,
                subset,
            },
        )
}

/// A probability with an error, or one of which no error is known.
fn is_probability(estimate: &Estimate, largest: f64) -> bool {
    is_told(estimate)
        && (0.0..=largest).contains(&estimate.value)
        && (estimate.value > 0.0 || estimate.uncertainty == Uncertainty::Unknown)
}

#[allow(clippy::needless_pass_by_value, reason = "every check takes what is drawn")]
pub(crate) fn estimates_the_rare(rare: Rare) -> Result<(), TestCaseError> {
    let Rare { system, start, dt, n_steps, threshold, .. } = rare;
    let path = DrivenPath { system: &system, integrator: &Heun, start, dt, n_steps };
    let n_normals = path.n_normals::<1>().saturating_add(rare.more_normals);
    let response = |normals: &[f64]| {
        let [x, v] = path.run::<1>(normals, |_, _, _| ())?;
        Ok(if rare.is_ratio { x / v } else { x })
    };
    let noise = Noise::new(1);
    let subset = subset_simulation(&response, n_normals, threshold, &noise, &rare.subset);
    if let Ok(estimate) = subset {
        prop_assert!(is_probability(&estimate, 1.0), "{estimate:?}");
    }
    Ok(())
}
