//! The stationary law of `dX = -X^3 dt + sqrt(2) dB` under each method, by iterating its transition operator: no
//! sampling.

use reference_problems::order;
use reference_problems::sde::problems::Cubic;
use reference_problems::sde::quadrature::{expectation, gauss_hermite};
use sde_integrators::{EulerMaruyama, Increment, Integrator, Shark, StepError, StochasticTheta};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/quartic-law",
    title: "bias of the stationary E[x^2] in a quartic potential, by the transition operator of each method",
    source: "2 Gamma(3/4)/Gamma(1/4) = 0.6759782401; derived/sde: 2e7 steps of an independent code",
    cost: Profile::Quick,
    run: Together(run),
};

const EXACT: f64 = Cubic::STATIONARY_SECOND_MOMENT;
/// The grid reaches to +-4, where the density has fallen to exp(-64), in steps of 0.02.
const HALF: usize = 200;
const SPACING: f64 = 0.02;
/// Points of the polynomials between the grid's points: an error of spacing^6.
const POINTS: usize = 6;
/// Step lengths: the order is that of the last four.
const STEPS: [f64; 6] = [0.1, 0.05, 0.025, 0.0125, 0.00625, 0.003_125];

/// What an independent code found with 2e7 steps, standard error 1e-3 to 2e-3: at h = 0.1, 0.05, 0.025.
const SURVEY: [(&str, [f64; 3]); 3] = [
    ("euler-maruyama", [1.61e-2, 7.89e-3, 2.04e-3]),
    ("shark", [-1.29e-2, -2.14e-3, 5.55e-4]),
    ("backward-euler", [-1.17e-2, -7.96e-3, -4.35e-3]),
];

/// The next state and what is observed of this one, from this one and the increment.
type Image<'a> = dyn Fn(f64, f64, &Increment<1>) -> Result<(f64, f64), StepError> + 'a;

fn run(context: &Context<'_>) -> CaseResult {
    let implicit = StochasticTheta::BACKWARD_EULER;
    let (euler, backward) = (Some(first_order_bias(1.0)), Some(first_order_bias(-1.0)));
    // Orders of the stationary distribution, with the bias of first order; ShARK is of weak order 2.
    let rows: [(&str, &Image<'_>, f64, Option<f64>); 3] = [
        ("euler-maruyama", &|x, dt, dw| after_step(&EulerMaruyama, x, dt, dw), 1.0, euler),
        ("shark", &|x, dt, dw| after_step(&Shark, x, dt, dw), 2.0, None),
        ("backward-euler", &|x, dt, dw| after_step(&implicit, x, dt, dw), 1.0, backward),
    ];
    let mut claims = Vec::new();
    let mut furthest = (0.0_f64, String::new());
    for (id, image, expected, first_order) in rows {
        context.progress(id);
        let mut levels = Vec::new();
        for dt in STEPS {
            levels.push((dt, stationary(dt, image)? / EXACT - 1.0));
        }
        let words: Vec<String> =
            levels.iter().map(|(dt, bias)| format!("{bias:+.2e} at h = {dt}")).collect();
        let reason = "no sampling: the next term of the error at h = 0.025";
        let order = order::fit(&levels[2..])?;
        let subject = context.subject(format!("{id}/order"), "order of E[x^2]", words.join(", "));
        claims.push(subject.order(order, expected).within(0.15).because(reason));
        let survey = SURVEY.iter().find(|row| row.0 == id).map(|row| row.1);
        for ((dt, bias), sampled) in levels.iter().zip(survey.into_iter().flatten()) {
            let deviations = (bias - sampled).abs() / (1e-3 * (0.1 / dt).sqrt());
            if deviations.is_nan() || deviations > furthest.0 {
                furthest = (deviations, format!("{id} at h = {dt}"));
            }
        }
        if let Some(first_order) = first_order {
            claims.push(limit_claim(context, id, &levels, first_order));
        }
    }
    claims.push(survey_claim(context, furthest));
    Ok(claims)
}

/// All sampled values of the independent code at once.
fn survey_claim(context: &Context<'_>, (deviations, place): (f64, String)) -> Claim {
    let quantity = "standard errors between the operator and a sampled value, the largest of 9";
    let method = format!("three methods, h = 0.1, 0.05, 0.025; furthest: {place}");
    let claim = context.subject("survey", quantity, method).unit("s.e.").bounded(deviations, 4.0);
    claim.because("statistics: four standard errors of the sampled value, each 1e-3 sqrt(0.1/h)")
}

/// The limit of bias over step as the step goes to zero, by Richardson's extrapolation of the two shortest steps.
fn limit_claim(context: &Context<'_>, id: &str, levels: &[(f64, f64)], first_order: f64) -> Claim {
    let slopes: Vec<f64> = levels[levels.len() - 2..].iter().map(|(dt, bias)| bias / dt).collect();
    let found = 2.0 * slopes[1] - slopes[0];
    let quantity = "relative bias of E[x^2] over h, as h goes to 0";
    let method = "transition operator, extrapolated from h = 0.00625 and 0.003125";
    let reason = "what the extrapolation leaves: the third order in h, 1e-5 times its coefficient";
    let subject = context.subject(format!("{id}/first-order-bias"), quantity, method);
    subject.relative(found, first_order).within(LIMIT_TOLERANCE).because(reason)
}

/// Of the coefficient of the first-order bias.
const LIMIT_TOLERANCE: f64 = 2e-4;

/// `E|x|^n` under the density `exp(-x^4/4)` over its integral, `4^(n/4) Gamma((n+1)/4)/Gamma(1/4)`: by parts from the first four,
/// `E|x|^(n+4) = (n+1) E|x|^n`.
fn absolute_moment(n: u16) -> f64 {
    const GAMMA_QUARTER: f64 = 3.625_609_908_221_908;
    let tau = std::f64::consts::TAU;
    let first = [1.0, tau.sqrt() / GAMMA_QUARTER, EXACT, 8_f64.sqrt() / GAMMA_QUARTER];
    let by_parts: f64 = (0..n / 4).map(|k| f64::from(n % 4 + 4 * k + 1)).product();
    by_parts * first[usize::from(n % 4)]
}

/// The coefficient of `h` in the relative bias of `E[x^2]` of Euler's method, for a sign of 1: its stationary density is that of
/// the equation times `1 + h (V'^2/4 - V''/2)` up to a constant, with `V = x^4/4` (Leimkuhler & Matthews 2013). Backward Euler
/// has the opposite sign.
fn first_order_bias(sign: f64) -> f64 {
    let m = absolute_moment;
    let with_square = 0.25 * m(8) - 1.5 * m(4);
    let alone = 0.25 * m(6) - 1.5 * m(2);
    sign * (with_square / m(2) - alone)
}

const SYSTEM: Cubic = Cubic { intensity: std::f64::consts::SQRT_2 };

fn after_step<I>(method: &I, x: f64, dt: f64, dw: &Increment<1>) -> Result<(f64, f64), StepError>
where
    I: Integrator<Cubic, 1, 1>,
{
    let mut next = [x];
    method.step(&SYSTEM, 0.0, dt, dw, &mut next, &mut I::Memory::default())?;
    Ok((next[0], x * x))
}

/// `E[x^2]` of the stationary chain: the expectation of the observable after many steps, as a function of the start,
/// tends to a constant.
fn stationary(dt: f64, image: &Image<'_>) -> CaseResult<f64> {
    let rule = gauss_hermite(14);
    let n = 2 * HALF + 1;
    let mut rows: Vec<Vec<f64>> = vec![vec![0.0; n]; n];
    let mut value = vec![0.0; n];
    for (i, row) in rows.iter_mut().enumerate() {
        let x = SPACING * (i as f64 - HALF as f64);
        let mut observed = 0.0;
        // The weight of each node is the expectation of its indicator.
        let n_nodes = rule.len();
        let mut node = 0;
        let mut images = Vec::with_capacity(n_nodes * n_nodes);
        expectation(dt, &rule, |dw| {
            images.push(image(x, dt, dw)?);
            Ok::<_, StepError>(0.0)
        })?;
        for &(_, p) in &rule {
            for &(_, r) in &rule {
                let (next, seen) = images[node];
                node += 1;
                observed += p * r * seen;
                spread(row, next, p * r);
            }
        }
        value[i] = observed;
    }
    // Even functions relax at a rate of about 6; 5 units of time leave 1e-13.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 1000")]
    let n_steps = (6.0 / dt) as usize;
    for _ in 0..n_steps {
        value = rows.iter().map(|row| row.iter().zip(&value).map(|(a, b)| a * b).sum()).collect();
    }
    let (middle, beside) = (value[HALF], value[HALF + 50]);
    if (middle - beside).abs() > 1e-9 {
        return Err(format!("not stationary: {middle} from 0, {beside} from 1").into());
    }
    Ok(middle)
}

/// Adds the weights with which a function on the grid is read at `x`, by Lagrange's polynomial; a state beyond the grid
/// is read at its end.
fn spread(row: &mut [f64], x: f64, weight: f64) {
    let last = (row.len() - POINTS) as f64;
    let place = (x / SPACING + HALF as f64).clamp(0.0, (row.len() - 1) as f64);
    let first = (place - 0.5 * POINTS as f64 + 0.5).round().clamp(0.0, last);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "on the grid")]
    let start = first as usize;
    for k in 0..POINTS {
        let mut basis = 1.0;
        for j in 0..POINTS {
            if j != k {
                basis *= (place - first - j as f64) / (k as f64 - j as f64);
            }
        }
        row[start + k] += weight * basis;
    }
}
