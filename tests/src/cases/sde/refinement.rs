//! Increments that are halved, and a Stratonovich system in its Itô form: against what defines them.

use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{Accumulator, BrownianTree, Increment, ItoForm, Noise, Sde, StratonovichSde};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/refinement",
    title: "halves of a Brownian increment: sum, variances, independence; the Itô form of a random rotation",
    source: "Brownian motion and its space-time area conditioned on a step; Stratonovich correction of linear noise",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const DT: f64 = 0.3;
const PATHS: u64 = 40_000;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = vec![sum_claim(context)];
    claims.extend(moment_claims(context)?);
    claims.push(ito_claim(context));
    Ok(claims)
}

fn parts(realisation: u64) -> (Increment<1>, [Increment<1>; 2]) {
    BrownianTree::<1>::new(Noise::new(61), realisation, DT).parts(3, &[])
}

/// What the halves have of the whole: `W = W_1 + W_2`, and `H = (H_1 + H_2)/2 + (W_1 - W_2)/4` for the area over the step.
fn sum_claim(context: &Context<'_>) -> Claim {
    let mut worst = 0.0_f64;
    for realisation in 0..1000 {
        let (whole, [first, second]) = parts(realisation);
        let (w, [w_1, w_2]) = (whole.brownian[0], [first.brownian[0], second.brownian[0]]);
        let (h_1, h_2) = (first.space_time_area[0], second.space_time_area[0]);
        let area = 0.5 * (h_1 + h_2) + 0.25 * (w_1 - w_2);
        for error in [w_1 + w_2 - w, area - whole.space_time_area[0]] {
            worst = if error.is_nan() || worst.is_nan() {
                f64::NAN
            } else {
                worst.max(error.abs() / DT.sqrt())
            };
        }
    }
    let subject = context.subject(
        "halves/sum",
        "worst error of increment and area of the halves together, over sqrt(h)",
        "",
        "BrownianTree, 1,000 increments",
    );
    let reason = "roundoff: ten operations";
    Claim::within(subject, ErrorKind::Absolute, (worst, 0.0), 1e-14, reason)
}

/// Second moments over those of independent increments of half the step, and of an eighth.
fn moment_claims(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut moments: [Accumulator; 4] = Default::default();
    for realisation in 0..PATHS {
        let (_, [first, second]) = parts(realisation);
        let (w_1, w_2) = (first.brownian[0], second.brownian[0]);
        let tree = BrownianTree::<1>::new(Noise::new(61), realisation, DT);
        let eighth = tree.increment(3, &[1, 0, 1]).brownian[0];
        moments[0].push(w_1 * w_1 / (0.5 * DT));
        moments[1].push(w_1 * w_2 / (0.5 * DT));
        moments[2].push(first.space_time_area[0].powi(2) / (DT / 24.0));
        moments[3].push(eighth * eighth / (DT / 8.0));
    }
    let rows = [
        ("halves/variance", "E[W_1^2] over h/2", 1.0),
        ("halves/covariance", "E[W_1 W_2] over h/2", 0.0),
        ("halves/area", "E[H_1^2] over h/24", 1.0),
        ("eighths/variance", "E[W^2] over h/8, of the sixth eighth", 1.0),
    ];
    rows.into_iter().zip(&moments).map(|(row, moment)| moment_claim(context, row, moment)).collect()
}

fn moment_claim(
    context: &Context<'_>,
    (name, quantity, expected): (&str, &str, f64),
    moment: &Accumulator,
) -> Result<Claim, CaseError> {
    let estimate = moment.estimate()?;
    let error = estimate.standard_error().ok_or("a moment without its standard error")?;
    Ok(Claim::judge(
        context.subject(name, quantity, "", &format!("BrownianTree, {PATHS} increments")),
        ErrorKind::Absolute,
        Measured::sampled(estimate.value, error),
        Reference::exact(expected),
        Criterion::MonteCarlo { bias_bound: 0.0, reason: "the law of the halves is exact" },
    ))
}

/// `dX = J X o dB` with the quarter turn `J`.
struct Rotation;

impl StratonovichSde<2, 1> for Rotation {
    fn drift(&self, _: f64, _: &[f64; 2]) -> [f64; 2] {
        [0.0; 2]
    }

    fn noise(&self, _: f64, &[x, y]: &[f64; 2]) -> [[f64; 1]; 2] {
        [[-y], [x]]
    }
}

/// The drift of the Itô form is `J J X/2 = -X/2`.
fn ito_claim(context: &Context<'_>) -> Claim {
    let mut worst = 0.0_f64;
    for x in [[1.0, 0.0], [0.3, -2.0], [-50.0, 7.0], [1e-3, 1e-3]] {
        let drift = Sde::<2, 1>::drift(&ItoForm(Rotation), 0.0, &x);
        let length = x[0].hypot(x[1]);
        for k in 0..2 {
            let error = (drift[k] + 0.5 * x[k]).abs() / length;
            worst = if error.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(error) };
        }
    }
    let subject = context.subject(
        "ito-form/rotation",
        "worst error of the drift, over |x|",
        "",
        "ItoForm of dX = J X o dB at four states",
    );
    let reason =
        "roundoff: central differences of a linear function, eps^(2/3) over the ratio of |x| to 1";
    Claim::within(subject, ErrorKind::Absolute, (worst, 0.0), 1e-7, reason)
}
