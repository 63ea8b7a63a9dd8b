//! Factors of a covariance from any numbers.

use proptest::prelude::*;
use sde_integrators::{DenseFactor, DiagonalFactor, LowRankFactor, NoiseFactor, SparseFactor};

use super::drawn::{count, numbers};

/// Factors up to this many motions are applied.
const MOST_MOTIONS: usize = 100;
/// Factors up to this many unknowns are applied.
const MOST_UNKNOWNS: usize = 1000;
/// Factors beyond this must be refused.
const TOO_MANY_MOTIONS: usize = 5_000_000_000;

/// Numbers from which factors are made.
#[derive(Debug)]
pub(crate) struct Entries {
    n: usize,
    motions: usize,
    values: Vec<f64>,
    rows: Vec<usize>,
    columns: Vec<usize>,
}

pub(crate) fn entries() -> impl Strategy<Value = Entries> {
    let places = || prop::collection::vec(count(), 0..5);
    let parts = (count(), count(), numbers(), places(), places());
    parts.prop_map(|(n, motions, values, rows, columns)| Entries {
        n,
        motions,
        values,
        rows,
        columns,
    })
}

/// The products of a factor with nothing are nothing: no entry is NaN or infinite.
fn is_finite(factor: &impl NoiseFactor) -> Result<(), TestCaseError> {
    // A low-rank factor without columns may have any number of rows.
    if factor.n_unknowns() > MOST_UNKNOWNS {
        return Ok(());
    }
    let (mut result, mut back) =
        (vec![f64::NAN; factor.n_unknowns()], vec![0.0; factor.n_motions()]);
    factor.apply(&vec![0.0; factor.n_motions()], &mut result);
    prop_assert!(result.iter().all(|x| x.abs() <= 0.0));
    factor.apply_transposed(&result, &mut back);
    prop_assert!(back.iter().all(|z| z.abs() <= 0.0));
    Ok(())
}

#[allow(clippy::needless_pass_by_value, reason = "every check takes what is drawn")]
pub(crate) fn makes_every_factor(entries: Entries) -> Result<(), TestCaseError> {
    let Entries { n, motions, values, rows, columns } = &entries;
    let (n, motions) = (*n, *motions);
    if let Ok(factor) = DiagonalFactor::new(values.clone()) {
        is_finite(&factor)?;
    }
    if let Ok(factor) = LowRankFactor::new(n, values.clone()) {
        is_finite(&factor)?;
    }
    if let Ok(factor) = DenseFactor::new(n, values) {
        is_finite(&factor)?;
    }
    let few = n.min(4);
    let identity: Vec<f64> =
        (0..few.pow(2)).map(|k| f64::from(u8::from(k % (few + 1) == 0))).collect();
    if let Ok(factor) = DenseFactor::new(few, &identity) {
        is_finite(&factor)?;
    }
    if !(MOST_MOTIONS..TOO_MANY_MOTIONS).contains(&motions) {
        let values = [values.as_slice(), &[0.5; 5]].concat()[..columns.len()].to_vec();
        for row_starts in [rows.clone(), (0..=columns.len()).collect()] {
            let factor = SparseFactor::new(motions, row_starts, columns.clone(), values.clone());
            if let Ok(factor) = factor {
                is_finite(&factor)?;
            }
        }
    }
    Ok(())
}
