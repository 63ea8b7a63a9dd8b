//! Rare events: subset simulation.

use sde_integrators::{
    Additive, DrivenPath, Error, EulerMaruyama, Noise, Sde, StrangOscillator, SubsetConfig,
    subset_simulation,
};

use super::{Oscillator, against_exact, upper_tail};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/ensembles/rare-events",
    title: "Subset simulation against exact values",
    source: "Caughey & Stumpf 1961; reflection principle",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const OSCILLATOR: Oscillator = Oscillator { omega: 2.0, xi: 0.05, intensity: 1.0 };
const TIME: f64 = 6.0;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    Ok(vec![oscillator(context)?, first_passage(context)?])
}

/// `P(q(T) > b)` from rest at 4.5 deviations, 3.4e-6.
fn oscillator(context: &Context<'_>) -> Result<Claim, CaseError> {
    let n_steps = 120;
    let path = DrivenPath {
        system: &OSCILLATOR,
        integrator: &StrangOscillator,
        start: [0.0; 2],
        dt: TIME / n_steps as f64,
        n_steps,
    };
    let n_normals = path.n_normals::<1>();
    let response =
        |normals: &[f64]| -> Result<f64, Error> { Ok(path.run::<1>(normals, |_, _, _| ())?[0]) };
    let threshold = 4.5 * OSCILLATOR.variance(TIME).sqrt();
    let exact = upper_tail(4.5);
    // Number of full runs that shows a bias of 10 % per run at five standard errors.
    let n_runs = if context.profile == Profile::Full { 600 } else { 24 };
    let config = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs };
    let subset = subset_simulation(&response, n_normals, threshold, &Noise::new(4), &config)?;
    against_exact(
        context,
        (
            "subset",
            "P(q(6) > 4.5 deviations)",
            &format!("subset simulation, {n_runs} runs of 1,000 per level"),
        ),
        &subset,
        exact,
        (
            0.06,
            "beta^2 times the error of the deviation, below 1e-3 each way, and the bias of a run: 600 runs are off by -1.0 %, standard error 1.7 %",
        ),
    )
}

/// `dX = dB`.
struct BrownianMotion;

impl Sde<1, 1> for BrownianMotion {
    type Noise = Additive;

    fn drift(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [0.0]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[1.0]]
    }
}

/// `P(max W > 4)` over the unit of time, `2 Phi(-4) = 6.3e-5`. The maximum between steps is a function of two more
/// normals per step, `-ln U = (z_1^2 + z_2^2)/2`, so that the answer is exact with 16 steps.
fn first_passage(context: &Context<'_>) -> Result<Claim, CaseError> {
    let n_steps = 16;
    let dt = 1.0 / n_steps as f64;
    let path = DrivenPath {
        system: &BrownianMotion,
        integrator: &EulerMaruyama,
        start: [0.0],
        dt,
        n_steps,
    };
    let n_driving = path.n_normals::<1>();
    let response = |normals: &[f64]| -> Result<f64, Error> {
        let (driving, between) = normals.split_at(n_driving);
        let (mut largest, mut pairs) = (0.0_f64, between.chunks_exact(2));
        path.run::<1>(driving, |_, &[x_0], &[x_1]| {
            let square: f64 = pairs.next().into_iter().flatten().map(|z| z * z).sum();
            let spread = ((x_1 - x_0).powi(2) + dt * square).sqrt();
            largest = largest.max(0.5 * (x_0 + x_1 + spread));
        })?;
        Ok(largest)
    };
    let config = SubsetConfig { n_samples: 1_000, correlation: 0.8, n_runs: 24 };
    let estimate = subset_simulation(&response, 3 * n_steps, 4.0, &Noise::new(5), &config)?;
    against_exact(
        context,
        ("subset-passage", "P(max W > 4)", "subset simulation, 24 runs of 1,000 per level"),
        &estimate,
        2.0 * upper_tail(4.0),
        (0.1, "the bias of a run: the square of its coefficient of variation, 0.3"),
    )
}
