//! Ensembles of the paper's oscillator with viscous damper against an independent code; and proof that the comparison
//! can fail: with a constant changed, it does.

use reference_problems::sde::reference::OscillatorEnsemble;
use sde_integrators::{
    EnsembleConfig, GaussianMixture, Integrator, Observable, SecondOrder, SemiImplicitEuler,
    StrangOscillator, simulate,
};
use vibrating_systems::{
    LinearOscillatorParameters, ViscousDamper, ViscousDamperParameters, Window,
};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/oscillator-ensemble",
    title: "E[q^2], E[v^2] and P(|q| > 0.5) of the damped building over time, and the same with a constant changed",
    source: "Canor and Denoël 2013, eq 26-27; derived/sde/oscillator_ensemble.json, 320,000 paths of an independent code",
    cost: Profile::Quick,
    run: Together(run),
};

const LIMIT: f64 = 0.5;
const DEVIATIONS: [f64; 2] = [0.15, 0.10];

/// The damper with constants changed: factors on the noise, on the damper's force and on the natural frequency.
#[derive(Debug, Clone)]
struct Changed {
    system: ViscousDamper,
    noise: f64,
    damper: f64,
    frequency: f64,
}

impl SecondOrder<1, 1> for Changed {
    #[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
    #[inline(always)]
    fn natural_frequency(&self) -> [f64; 1] {
        self.system.natural_frequency().map(|omega| self.frequency * omega)
    }

    #[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
    #[inline(always)]
    fn linear_damping(&self) -> [f64; 1] {
        self.system.linear_damping()
    }

    #[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
    #[inline(always)]
    fn remaining_acceleration(&self, t: f64, q: &[f64; 1], v: &[f64; 1]) -> [f64; 1] {
        self.system.remaining_acceleration(t, q, v).map(|force| self.damper * force)
    }

    #[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
    #[inline(always)]
    fn remaining_flow(&self, t: f64, dt: f64, q: &[f64; 1], v: &mut [f64; 1]) {
        // A force c times as large moves as far in dt as the force itself in c dt; backwards for c < 0.
        self.system.remaining_flow(t, self.damper * dt, q, v);
    }

    #[allow(clippy::inline_always, reason = "ensembles compile it for lanes of paths")]
    #[inline(always)]
    fn noise_intensity(&self, t: f64) -> [[f64; 1]; 1] {
        self.system.noise_intensity(t).map(|row| row.map(|s| self.noise * s))
    }
}

fn run(context: &Context<'_>) -> CaseResult {
    let structure = LinearOscillatorParameters {
        natural_frequency: std::f64::consts::PI,
        damping_ratio: 0.01,
        noise_intensity: 0.2,
        window: Window::CANOR_DENOEL_2013,
    };
    let parameters =
        ViscousDamperParameters { structure, damper_coefficient: 0.25, damper_exponent: 0.35 };
    let system = Changed {
        system: ViscousDamper::new(parameters)?,
        noise: 1.0,
        damper: 1.0,
        frequency: 1.0,
    };
    let n_paths = match context.profile {
        Profile::Quick => 16_384,
        Profile::Default => 65_536,
        Profile::Full => 327_680,
    };
    context.progress("Strang, BAOAB, semi-implicit Euler");
    let mut claims = rows(context, "strang", &StrangOscillator, &system, (0.02, n_paths))?;
    let semi_implicit = ("semi-implicit-euler", &SemiImplicitEuler);
    claims.extend(rows(context, semi_implicit.0, semi_implicit.1, &system, (0.005, n_paths))?);
    if context.profile > Profile::Quick {
        claims.push(mutations(context, &system)?);
    }
    Ok(claims)
}

/// A row per quantity and time.
fn rows<I>(
    context: &Context<'_>,
    id: &str,
    method: &I,
    system: &Changed,
    (dt, n_paths): (f64, u64),
) -> CaseResult
where
    I: Integrator<Changed, 2, 1>,
{
    let reference = OscillatorEnsemble::read()?;
    let law = GaussianMixture::independent([0.0; 2], DEVIATIONS)?;
    let times = reference.rows.iter().map(|row| row[0]).collect();
    let config = EnsembleConfig { seed: 57, n_paths, dt, times };
    let observables = [
        Observable::Mean(&|_, x: &[f64; 2]| x[0] * x[0]),
        Observable::Mean(&|_, x: &[f64; 2]| x[1] * x[1]),
        Observable::Probability(&|_, x: &[f64; 2]| x[0].abs() > LIMIT),
    ];
    let ensemble = simulate(system, method, &law, &config, &observables)?;
    let named = format!("{id}, h = {dt}, {n_paths} paths");
    let mut claims = Vec::new();
    for (estimates, [t, q, q_error, v, v_error, p]) in ensemble.estimates.iter().zip(reference.rows)
    {
        let p_error = (p * (1.0 - p) / reference.paths as f64).sqrt();
        for ((name, quantity, expected, error), estimate) in [
            ("second-moment-q", "E[q^2]", q, q_error),
            ("second-moment-v", "E[v^2]", v, v_error),
            ("exceedance", "P(|q| > 0.5)", p, p_error),
        ]
        .into_iter()
        .zip(estimates)
        {
            let reference = Reference::uncertain(expected, error);
            let reason = "the bias of this step is below the standard errors";
            let subject = context.subject(format!("{id}/{name}/t{t}"), quantity, &named);
            let compared = subject.relative(sampled(estimate)?, reference);
            claims.push(compared.monte_carlo(0.0).because(reason));
        }
    }
    Ok(claims)
}

/// The same rows must not hold where a constant is wrong.
fn mutations(context: &Context<'_>, system: &Changed) -> CaseResult<Claim> {
    // The smallest change that 4 standard errors can see: 1 % of the noise moves E[v^2] by 2 %.
    let n_paths = 262_144;
    let changed = [
        ("noise 1 % up", Changed { noise: 1.01, ..system.clone() }),
        ("noise 1 % down", Changed { noise: 0.99, ..system.clone() }),
        ("frequency 2 % up", Changed { frequency: 1.02, ..system.clone() }),
        ("damper 5 % up", Changed { damper: 1.05, ..system.clone() }),
        ("damper's sign", Changed { damper: -1.0, ..system.clone() }),
    ];
    let (mut unnoticed, mut words) = (0, Vec::new());
    for (name, changed) in &changed {
        context.progress(name);
        let claims = rows(context, "strang", &StrangOscillator, changed, (0.04, n_paths))?;
        let n_failed = claims.iter().filter(|claim| !claim.passed).count();
        unnoticed += usize::from(n_failed == 0);
        words.push(format!("{name}: {n_failed} of {} fail", claims.len()));
    }
    let method = format!("Strang, h = 0.04, {n_paths} paths; {}", words.join(", "));
    let reason =
        "of 15 claims that hold with the right constant at least one must see the wrong one";
    let subject = context.subject("mutated", "wrong constants that no claim notices", method);
    Ok(subject.same_bits(unnoticed, changed.len()).because(reason))
}
