//! A body with two steps: that of the library and a hand-written baseline.

use std::error::Error;

pub(crate) type Failure = Box<dyn Error>;

/// Numbers of all particles or nodes, by name.
pub(crate) type State = Vec<(&'static str, Vec<f64>)>;

/// A body over time.
pub(crate) trait Run {
    fn step(&mut self) -> Result<(), Failure>;
    fn state(&self) -> State;
    /// Particles or bonds.
    fn n_elements(&self) -> usize;
}

/// Creates a body with a number of particles or nodes along its edge.
pub(crate) type Start = fn(u32) -> Result<Box<dyn Run>, Failure>;

/// The same body in both implementations.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) what: &'static str,
    pub(crate) element: &'static str,
    /// Number along an edge: for timing, and for counting instructions or a run without measurement.
    pub(crate) edges: [u32; 2],
    pub(crate) ours: Start,
    pub(crate) plain: Start,
    /// Largest difference after [`STEPS_COMPARED`] steps, relative to the largest number of a kind.
    pub(crate) tolerance: f64,
}

/// The implementation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Who {
    Ours,
    Plain,
}

impl Who {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Plain => "plain",
        }
    }

    pub(crate) fn start(self, case: &Case, edge: u32) -> Result<Box<dyn Run>, Failure> {
        match self {
            Self::Ours => (case.ours)(edge),
            Self::Plain => (case.plain)(edge),
        }
    }
}

const STEPS_COMPARED: u32 = 20;

/// Rejects a comparison of the cost of different work.
///
/// # Errors
/// Errors of both runs, and states that differ by more than roundoff.
pub(crate) fn require_agreement(case: &Case) -> Result<(), Failure> {
    let mut runs = [Who::Ours, Who::Plain]
        .into_iter()
        .map(|who| who.start(case, case.edges[1]))
        .collect::<Result<Vec<_>, _>>()?;
    let before = runs[0].state();
    for run in &mut runs {
        for _ in 0..STEPS_COMPARED {
            run.step()?;
        }
    }
    let (ours, plain) = (runs[0].state(), runs[1].state());
    for ((name, ours), (_, plain)) in ours.iter().zip(&plain) {
        let difference = largest(ours.iter().zip(plain).map(|(a, b)| a - b));
        let error = difference / largest(ours.iter().copied());
        // NaN, and a different length or name, are no agreement.
        if ours.len() != plain.len() || !(difference == 0.0 || error <= case.tolerance) {
            let Case { name: case, tolerance, .. } = case;
            return Err(format!(
                "{case}: {name} differs by {error:.1e}, more than {tolerance:.0e}"
            )
            .into());
        }
    }
    if before == ours || ours.len() != plain.len() {
        return Err(format!("{}: nothing moved, or not the same is compared", case.name).into());
    }
    Ok(())
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| if value.is_nan() { value } else { most.max(value.abs()) })
}
