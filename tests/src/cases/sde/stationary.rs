//! Stationary laws of the linear oscillator by the discrete Lyapunov equation: no sampling.

use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::{
    Additive, Baoab, EulerMaruyama, Increment, Integrator, LastKick, LeimkuhlerMatthews, Sde,
    SecondOrder, SemiImplicitEuler, Sra1, StateSpace, StepError, StochasticTheta, StrangOscillator,
};
use work_precision::order;
use work_precision::problems::sde::linear::probe;
use work_precision::problems::sde::problems::Oscillator;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/stationary-law",
    title: "stationary covariance of the linear oscillator, by one step of each method",
    source: "discrete Lyapunov equation; closed forms of the covariance of a second-order autoregression",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// Roundoff of the doubling: eps times the number of steps in a relaxation time, at most 1e3.
const EXACT: f64 = 1e-12;
const REASON: &str =
    "roundoff: eps times the steps of a relaxation time, 1e3 at the weakest damping";
/// Damping ratios and angles `h omega` over which the worst error is taken.
const RATIOS: [f64; 3] = [0.02, 0.05, 0.5];
const ANGLES: [f64; 4] = [0.05, 0.4, 1.3, 1.9];

type System = StateSpace<Oscillator>;

fn oscillator(damping_ratio: f64) -> Oscillator {
    Oscillator { frequency: 2.0, damping_ratio, intensity: 0.7 }
}

/// `E[q^2]`, `E[v^2]` and the correlation, relative to the exact law; and what the method remembers of the velocity.
struct Law {
    q: f64,
    v: f64,
    correlation: f64,
    remembered: f64,
}

fn law<I>(
    system: Oscillator,
    method: &I,
    dt: f64,
    read: impl Fn(&[f64; 2], &I::Memory) -> [f64; 1],
) -> Result<Option<Law>, StepError>
where
    I: Integrator<System, 2, 1>,
{
    let (map, memory) = probe(&StateSpace(system), method, dt, read)?;
    let v = system.velocity_variance();
    let q = v / (system.frequency * system.frequency);
    Ok(map.stationary(dt).map(|p| Law {
        q: p[0][0] / q,
        v: p[1][1] / v,
        correlation: p[0][1] / (q * v).sqrt(),
        remembered: memory.covariance(&p, dt)[0][0] / v,
    }))
}

/// The error of largest size over dampings and angles, each against its formula.
fn worst<I>(
    method: &I,
    angles: &[f64],
    error: impl Fn(&Law, f64, f64) -> f64,
    read: impl Fn(&[f64; 2], &I::Memory) -> [f64; 1] + Copy,
) -> Result<f64, CaseError>
where
    I: Integrator<System, 2, 1>,
{
    let mut worst = 0.0_f64;
    for ratio in RATIOS {
        for &angle in angles {
            let system = oscillator(ratio);
            let law = law(system, method, angle / system.frequency, read)?
                .ok_or("a method without a stationary law inside its limit")?;
            let error = error(&law, ratio, angle);
            worst =
                if error.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(error.abs()) };
        }
    }
    Ok(worst)
}

fn velocity<Memory>(x: &[f64; 2], _: &Memory) -> [f64; 1] {
    [x[1]]
}

fn full(law: &Law, _: f64, _: f64) -> f64 {
    (law.q - 1.0).abs().max((law.v - 1.0).abs()).max(law.correlation.abs())
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let exact = |id: &str, quantity: &str, method: &str, error: f64| {
        let subject = context.subject(id, quantity, "", method);
        let criterion = Criterion::Within { tolerance: EXACT, reason: REASON };
        let (measured, reference) = (Measured::exact(error), Reference::exact(0.0));
        Claim::judge(subject, ErrorKind::Absolute, measured, reference, criterion)
    };
    let trapezoidal = StochasticTheta::TRAPEZOIDAL;
    let covariance = "worst error of the covariance";
    let mut claims = vec![
        exact(
            "trapezoidal/covariance",
            covariance,
            "trapezoidal rule, h omega 0.05 to 1.9",
            worst(&trapezoidal, &ANGLES, full, velocity)?,
        ),
        exact(
            "strang-oscillator/covariance",
            covariance,
            "Strang with the Ornstein-Uhlenbeck half step, h omega 0.05 to 7",
            worst(&StrangOscillator, &[0.05, 0.4, 1.3, 2.9, 7.0], full, velocity)?,
        ),
        exact(
            "baoab/second-moment-q",
            "worst error of E[q^2]",
            "BAOAB, h omega 0.05 to 1.9",
            worst(&Baoab, &ANGLES, |law, _, _| law.q - 1.0, velocity)?,
        ),
        exact(
            "baoab/second-moment-v",
            "worst error of E[v^2] against (1 - (h omega)^2/4) kT/m",
            "BAOAB, on-step velocity",
            worst(&Baoab, &ANGLES, |law, _, a| law.v - (1.0 - 0.25 * a * a), velocity)?,
        ),
        exact(
            "baoab/second-moment-half-step-v",
            "worst error of E[v^2]",
            "BAOAB, half-step velocity",
            worst(&Baoab, &ANGLES, |law, _, _| law.remembered - 1.0, |_, m| m.velocity())?,
        ),
    ];
    claims.extend(formula_claims(&exact)?);
    claims.push(exact(
        "leimkuhler-matthews/variance",
        "worst error of E[x^2] of an Ornstein-Uhlenbeck process",
        "Leimkuhler-Matthews, h k 0.05 to 1.9",
        leimkuhler_matthews()?,
    ));
    claims.push(separate_claim(context)?);
    claims.push(published_claim(context)?);
    Ok(claims)
}

/// The rest by their formulas: `q` is a second-order autoregression, whose variance is known.
fn formula_claims(
    exact: &impl Fn(&str, &str, &str, f64) -> Claim,
) -> Result<Vec<Claim>, CaseError> {
    // With a = h omega and d = c h = 2 xi a, relative to the exact E[q^2].
    let semi = |xi: f64, a: f64| 1.0 / (1.0 - a * a / (4.0 - 4.0 * xi * a));
    let backward = |xi: f64, a: f64| {
        let d = 2.0 * xi * a;
        2.0 * d * (2.0 + d + a * a) / ((d + a * a) * (4.0 + 2.0 * d + a * a))
    };
    let euler = |xi: f64, a: f64| {
        let d = 2.0 * xi * a;
        (4.0 - 2.0 * d + 2.0 * a * a) / (4.0 - 2.0 * d + a * a) * d / (d - a * a)
    };
    let quantity = "worst error of E[q^2] against its formula";
    let implicit = StochasticTheta::BACKWARD_EULER;
    // Euler-Maruyama is stable for h omega < 2 xi alone.
    let mut worst_euler = 0.0_f64;
    for xi in RATIOS {
        for share in [0.1, 0.5, 0.9] {
            let (system, angle) = (oscillator(xi), share * 2.0 * xi);
            let law = law(system, &EulerMaruyama, angle / system.frequency, velocity)?
                .ok_or("Euler-Maruyama has no stationary law inside its limit")?;
            worst_euler = worst_euler.max((law.q / euler(xi, angle) - 1.0).abs());
        }
    }
    // At half the damping the limit of the semi-implicit method is 2 (sqrt(1.25) - 0.5) = 1.236.
    Ok(vec![
        exact(
            "semi-implicit-euler/second-moment-q",
            quantity,
            "semi-implicit Euler, h omega 0.05 to 1.2",
            worst(
                &SemiImplicitEuler,
                &[0.05, 0.4, 1.2],
                |law, xi, a| law.q / semi(xi, a) - 1.0,
                velocity,
            )?,
        ),
        exact(
            "backward-euler/second-moment-q",
            quantity,
            "backward Euler, h omega 0.05 to 1.9",
            worst(&implicit, &ANGLES, |law, xi, a| law.q / backward(xi, a) - 1.0, velocity)?,
        ),
        exact(
            "euler-maruyama/second-moment-q",
            quantity,
            "Euler-Maruyama, 0.1, 0.5, 0.9 of its limit",
            worst_euler,
        ),
    ])
}

/// Errors of `E[q^2]` that a survey found by another code, to the digits it gives.
fn published_claim(context: &Context<'_>) -> Result<Claim, CaseError> {
    // (h omega, error, half a unit of its last digit) at a damping ratio of 0.05
    let sra1 =
        [(0.4, 0.15, 0.005), (0.2, 0.014, 0.0005), (0.1, 8e-4, 0.5e-4), (0.05, -1e-4, 0.5e-4)];
    let mut worst = 0.0_f64;
    for (angle, published, half_digit) in sra1 {
        let law =
            law(oscillator(0.05), &Sra1, angle / 2.0, velocity)?.ok_or("no stationary law")?;
        let error = (law.q - 1.0 - published).abs() / half_digit;
        worst = if error.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(error) };
    }
    let subject = context.subject(
        "sra1/second-moment-q",
        "relative error of E[q^2] against a survey, in half units of its last digit",
        "",
        "SRA1, damping ratio 0.05, worst of h omega 0.4, 0.2, 0.1, 0.05",
    );
    let reason = "the survey rounds to its last digit";
    Ok(Claim::within(subject, ErrorKind::Absolute, (worst, 0.0), 1.0, reason))
}

/// `dX = -X dt + sqrt(2) dB`.
struct Relaxation;

impl Sde<1, 1> for Relaxation {
    type Noise = Additive;

    fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [-x[0]]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[2.0_f64.sqrt()]]
    }
}

/// The step is `x' = a x + b w_before + c w`, so that `P (1 - a^2) = h (2 a b c + b^2 + c^2)`; exact is `P = 1`.
fn leimkuhler_matthews() -> Result<f64, CaseError> {
    let mut worst = 0.0_f64;
    for dt in [0.05, 0.4, 1.0, 1.5, 1.9] {
        let image = |x: f64, before: f64, w: f64| -> Result<f64, StepError> {
            let dw = |w| Increment { brownian: [w], space_time_area: [0.0] };
            let (mut memory, mut state) = (LastKick::default(), [0.0]);
            LeimkuhlerMatthews.step(&Relaxation, 0.0, dt, &dw(before), &mut state, &mut memory)?;
            let mut state = [x];
            LeimkuhlerMatthews.step(&Relaxation, dt, dt, &dw(w), &mut state, &mut memory)?;
            Ok(state[0])
        };
        let (a, b, c) = (image(1.0, 0.0, 0.0)?, image(0.0, 1.0, 0.0)?, image(0.0, 0.0, 1.0)?);
        let variance = dt * (2.0 * a * b * c + b * b + c * c) / (1.0 - a * a);
        worst = worst.max((variance - 1.0).abs());
    }
    Ok(worst)
}

/// Strang's splitting with the damping as a flow of its own and bare kicks, as a user would write it: half a flow, half
/// a kick, the rotation, half a kick, half a flow.
struct SeparateKick;

impl Integrator<System, 2, 1> for SeparateKick {
    type Memory = ();

    fn step(
        &self,
        system: &System,
        _: f64,
        dt: f64,
        dw: &Increment<1>,
        [q, v]: &mut [f64; 2],
        (): &mut (),
    ) -> Result<(), StepError> {
        let ([omega], [c]) = (system.natural_frequency(), system.linear_damping());
        let [[s]] = system.noise_intensity(0.0);
        let (half, skew) = (0.5 * dw.brownian[0], 3.0_f64.sqrt() * dw.space_time_area[0]);
        *v = (-0.5 * c * dt).exp() * *v + s * (half + skew);
        let (sin, cos) = (omega * dt).sin_cos();
        (*q, *v) = (cos * *q + sin / omega * *v, cos * *v - omega * sin * *q);
        *v = (-0.5 * c * dt).exp() * (*v + s * (half - skew));
        Ok(())
    }
}

fn separate_claim(context: &Context<'_>) -> Result<Claim, CaseError> {
    let mut levels = Vec::new();
    for angle in [0.8, 0.4, 0.2, 0.1, 0.05] {
        let system = oscillator(0.5);
        let law = law(system, &SeparateKick, angle / system.frequency, velocity)?
            .ok_or("no stationary law")?;
        levels.push((angle, law.q - 1.0));
    }
    let method = "Strang with separate damping flow and kick, damping ratio 0.5";
    let subject =
        context.subject("strang-separate-kick/second-moment-q", "order of E[q^2]", "", method);
    let reason = "no sampling: the next term of the error";
    let criterion = Criterion::Within { tolerance: 0.05, reason };
    let order = order::fit(&levels)?;
    Ok(Claim::judge(subject, ErrorKind::Order, order, Reference::exact(2.0), criterion))
}
