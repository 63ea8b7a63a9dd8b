//! A few steps of fields, by every factor of their noise.

use proptest::prelude::*;
use sde_integrators::{
    DenseFactor, DiagonalFactor, EulerMaruyama, FieldPath, FieldSde, LinearTheta, LowRankFactor,
    Noise, NoiseFactor, SparseFactor,
};

use super::drawn::{count, number, numbers};

/// Factors up to this many motions are used.
const MOST_MOTIONS: usize = 100;
/// Factors beyond this must be refused.
const TOO_MANY_MOTIONS: usize = 5_000_000_000;

/// A field without a drift.
struct Noisy<F>(F);

impl<F: NoiseFactor> FieldSde for Noisy<F> {
    type Factor = F;

    fn drift(&self, _t: f64, x: &[f64], drift: &mut [f64]) {
        for (drift, x) in drift.iter_mut().zip(x) {
            *drift = -x * x;
        }
    }

    fn factor(&self) -> &F {
        &self.0
    }
}

/// A few steps of a field, if it starts; a state is finite whatever happened.
fn step_field(
    factor: impl NoiseFactor,
    start: &[f64],
    (theta, operator, dt): (f64, &[f64], f64),
) -> Result<(), TestCaseError> {
    let (field, noise) = (Noisy(factor), Noise::new(1));
    if let Ok(mut path) = FieldPath::new(&field, &EulerMaruyama, &noise, 0, start.to_vec()) {
        let _ = path.step(dt).and_then(|()| path.step(dt));
        prop_assert!(path.state().iter().all(|x| x.is_finite()));
    }
    if let Ok(operator) = DiagonalFactor::new(operator.to_vec())
        && let Ok(method) = LinearTheta::new(theta, operator)
        && let Ok(mut path) = FieldPath::new(&field, &method, &noise, 0, start.to_vec())
    {
        let _ = path.step(dt);
        prop_assert!(path.state().iter().all(|x| x.is_finite()));
    }
    Ok(())
}

/// Of the factors of a field, and of a method for it.
#[derive(Debug)]
pub(crate) struct Field {
    n: usize,
    motions: usize,
    values: Vec<f64>,
    start: Vec<f64>,
    operator: Vec<f64>,
    rows: Vec<usize>,
    columns: Vec<usize>,
    theta: f64,
    dt: f64,
}

pub(crate) fn field() -> impl Strategy<Value = Field> {
    let places = || prop::collection::vec(count(), 0..5);
    let parts = (
        (count(), count()),
        (numbers(), numbers(), numbers()),
        (places(), places()),
        (number(), number()),
    );
    parts.prop_map(|((n, motions), (values, start, operator), (rows, columns), (theta, dt))| {
        Field { n, motions, values, start, operator, rows, columns, theta, dt }
    })
}

impl Field {
    /// A start that fits, as a rule.
    fn start(&self, n: usize) -> Vec<f64> {
        if n < 10 {
            [self.start.as_slice(), &[0.5; 10]].concat()[..n].to_vec()
        } else {
            self.start.clone()
        }
    }

    fn step(&self, factor: impl NoiseFactor, n: usize) -> Result<(), TestCaseError> {
        step_field(factor, &self.start(n), (self.theta, &self.operator, self.dt))
    }
}

#[allow(clippy::needless_pass_by_value, reason = "every check takes what is drawn")]
pub(crate) fn steps_by_every_factor(field: Field) -> Result<(), TestCaseError> {
    let Field { n, motions, values, rows, columns, .. } = &field;
    let (n, motions) = (*n, *motions);
    if let Ok(factor) = DiagonalFactor::new(values.clone()) {
        field.step(factor, values.len())?;
    }
    if let Ok(factor) = LowRankFactor::new(n, values.clone()) {
        field.step(factor, n)?;
    }
    if let Ok(factor) = DenseFactor::new(n, values) {
        field.step(factor, n)?;
    }
    let few = n.min(4);
    let identity: Vec<f64> =
        (0..few.pow(2)).map(|k| f64::from(u8::from(k % (few + 1) == 0))).collect();
    if let Ok(factor) = DenseFactor::new(few, &identity) {
        field.step(factor, few)?;
    }
    if !(MOST_MOTIONS..TOO_MANY_MOTIONS).contains(&motions) {
        let values = [values.as_slice(), &[0.5; 5]].concat()[..columns.len()].to_vec();
        for row_starts in [rows.clone(), (0..=columns.len()).collect()] {
            let factor = SparseFactor::new(motions, row_starts, columns.clone(), values.clone());
            if let Ok(factor) = factor {
                let n = factor.n_unknowns();
                field.step(factor, n)?;
            }
        }
    }
    Ok(())
}
