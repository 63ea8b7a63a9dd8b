//! The schemes in time, on an oscillator without damping and noise, where each particle is a path of its own.

use std::f64::consts::PI;

use fpk_sph::systems::{LinearOscillator, LinearOscillatorParameters, Window};
use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, Error, InitialLattice, Method, Scheme, Simulation,
    StepRule,
};
use result_figures::{ErrorKind, Reference};
use sde_integrators::GaussianMixture;
use work_precision::problems::fpk::problem::Problem;

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/schemes",
    title: "Energy that the schemes in time give to an undamped oscillator; what leap-frog makes of damping",
    source: "closed form, from the roots of each scheme for x' = i w x",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const END: f64 = 10.0;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = one_step_schemes(context)?;
    claims.extend(leap_frog(context)?);
    claims.push(with_noise(context)?);
    Ok(claims)
}

/// `E[v^2 + w^2 q^2]` at the given times over that at the start, `w = pi`, steps of `dt` that divide the times.
fn energies(
    scheme: Scheme,
    dt: f64,
    damping_ratio: f64,
    times: &[f64],
) -> Result<Vec<f64>, CaseError> {
    let system = LinearOscillator::new(LinearOscillatorParameters {
        natural_frequency: PI,
        damping_ratio,
        noise_intensity: 0.0,
        window: Window::Stationary,
    })?;
    let law = GaussianMixture::independent([0.0; 2], [0.15, 0.10])?;
    let step = StepRule::Fixed { dt };
    let combination = Combination { scheme, step, ..Method::CanorDenoel2013.combination() };
    let config = Config {
        method: Method::Custom(combination),
        lattice: InitialLattice::Box { reach: 4.0, count: [15, 15] },
        reference_period: system.period(),
        most_steps: DEFAULT_MOST_STEPS,
    };
    let mut simulation = Simulation::new(system, &law, &config)?;
    let energy = |simulation: &Simulation<_, 2, 1>| {
        simulation.raw_moment([0, 2]) + PI * PI * simulation.raw_moment([2, 0])
    };
    let start = energy(&simulation);
    let mut energies = Vec::new();
    simulation.run::<Error>(times, |simulation| {
        energies.push(energy(simulation) / start);
        Ok(())
    })?;
    Ok(energies)
}

fn lines<'a>(context: &'a Context<'a>, id: &'a str, words: String) -> Lines<'a> {
    Lines { context, id, method: words }
}

/// Every mode grows by the root of its scheme: `|R(i theta)|^2` a step, `theta = w dt`.
fn one_step_schemes(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let (dt, n) = (0.02_f64, 500.0);
    let theta = PI * dt;
    let euler = energies(Scheme::ForwardEuler, dt, 0.0, &[END])?[0];
    let judge = |id, what, value, reference, tolerance, reason| {
        lines(context, id, format!("steps of {dt}, 500 of them")).judge(
            (what, "E(10)/E(0) - 1, E = E[v^2] + w^2 E[q^2]", ""),
            ErrorKind::Relative,
            value,
            Reference::exact(reference),
            Criterion::Within { tolerance, reason },
        )
    };
    let mut claims = vec![judge(
        "forward-euler",
        "energy-growth",
        euler - 1.0,
        (PI * PI * dt * END).exp_m1(),
        0.006,
        "exp(w^2 dt t) for (1 + theta^2)^n: the next term of the logarithm is n theta^4 / 2 = 0.4 %",
    )];
    for (id, scheme, growth, tolerance, reason) in [
        (
            "heun",
            Scheme::Heun,
            theta.powi(4) / 4.0,
            1e-10,
            "roundoff: |R|^2 = 1 + theta^4 / 4 exactly; 1e-13 of the moments in 500 steps over the growth, 2e-3",
        ),
        (
            "runge-kutta-4",
            Scheme::RungeKutta4,
            -theta.powi(6) / 72.0 + theta.powi(8) / 576.0,
            3e-7,
            "roundoff: |R|^2 = 1 - theta^6 / 72 + theta^8 / 576 exactly; 1e-13 of the moments in 500 steps over the loss, 4e-7",
        ),
    ] {
        let grown = energies(scheme, dt, 0.0, &[END])?[0] - 1.0;
        let expected = (n * growth.ln_1p()).exp_m1();
        claims.push(judge(id, "energy-growth", grown, expected, tolerance, reason));
    }
    Ok(claims)
}

/// Leap-frog has two roots, `z = i theta +- sqrt(1 - theta^2)`, both on the unit circle where `theta < 1`. Heun's first step
/// gives the second one the amplitude `a`.
fn leap_frog(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for (name, dt) in [("energy-growth", 0.02_f64), ("energy-growth-coarse", 0.25)] {
        let theta = PI * dt;
        let root = (1.0 - theta * theta).sqrt();
        let amplitude = (1.0 - theta * theta / 2.0 - root) / (2.0 * root);
        // (a_+ - a_-)^2 and (a_+ + a_-)^2 with a_+ = 1 + a, a_- = -a.
        let largest = (1.0 + 2.0 * amplitude).powi(2) - 1.0;
        let odd = END - dt;
        let worst = energies(Scheme::LeapFrog, dt, 0.0, &[odd, END])?
            .into_iter()
            .fold(0.0_f64, |worst, energy| worst.max((energy - 1.0).abs()));
        claims.push(lines(context, "leap-frog", format!("steps of {dt}, theta = {theta:.3}")).measured(
            (name, "worst |E(t)/E(0) - 1| at t = 10 and one step before", ""),
            worst,
            (0.0, largest + 1e-12),
            "both roots keep their size; Heun's first step puts a = (1 - theta^2/2 - sqrt(1 - theta^2)) / (2 sqrt(1 - theta^2)) \
             into the second, so that E stays from E(0) to (1 + 2a)^2 E(0); and roundoff",
        ));
    }
    let dt = END / 29.0;
    let outside = energies(Scheme::LeapFrog, dt, 0.0, &[END])?[0];
    let theta = PI * dt;
    let n_steps = 29.0;
    claims.push(lines(context, "leap-frog", format!("29 steps of {dt:.3}, theta = {theta:.3}")).measured(
        ("outside", "growth of ln E over that of the root, per step", ""),
        outside.ln() / (2.0 * n_steps * (theta + (theta * theta - 1.0).sqrt()).ln()),
        (0.85, 1.1),
        "beyond theta = 1 a root leaves the circle, |z| = theta + sqrt(theta^2 - 1); the amplitude that it starts with takes a few steps off",
    ));
    let (xi, dt) = (0.5_f64, 0.02);
    // The energy of a damped mode wavers with the period of its square.
    let two_periods = 2.0 / (1.0 - xi * xi).sqrt();
    let damped = energies(Scheme::LeapFrog, dt, xi, &[END - two_periods, END])?;
    claims.push(lines(context, "leap-frog", format!("damping ratio {xi}, steps of {dt}")).judge(
        ("second-root", "growth of ln E over two of its periods to t = 10, per unit of time", ""),
        ErrorKind::Relative,
        (damped[1] / damped[0]).ln() / two_periods,
        Reference::exact(2.0 * xi * PI),
        Criterion::Within {
            tolerance: 2e-3,
            reason: "the second root grows as the true solution decays, by exp(xi w dt) a step up to theta^2 / 6; \
                     nothing else is left by then",
        },
    ));
    Ok(claims)
}

/// The paper's method with leap-frog in the place of Euler: diffusion damps the disorder of the particles, the second root
/// makes it grow.
fn with_noise(context: &Context<'_>) -> Result<Claim, CaseError> {
    let problem = Problem::viscous_damper()?;
    let work_precision::problems::fpk::oscillator::Oscillator::Damper(system) =
        problem.system.clone()
    else {
        return Err("the scene holds another system".into());
    };
    let combination =
        Combination { scheme: Scheme::LeapFrog, ..Method::CanorDenoel2013.combination() };
    let config = Config {
        method: Method::Custom(combination),
        ..work_precision::problems::fpk::methods::papers_config(problem.system.period())
    };
    let mut simulation = Simulation::new(system, &problem.law, &config)?;
    let (time, words) = match simulation.advance_to(6.0) {
        Err(error @ Error::StepCollapsed { .. }) => (simulation.time(), error.to_string()),
        Err(error) => (f64::NAN, format!("another error: {error}")),
        Ok(()) => (f64::NAN, "the run did not end early".to_owned()),
    };
    Ok(lines(context, "leap-frog", words).measured(
        ("damper-ends", "time of the typed error, damper as in section 4.1", "s"),
        time,
        (0.5, 1.5),
        "diffusion damps the disorder of the particles at its fastest rate at the smallest scale, and the second root makes that \
         grow at the same rate: particles clump and the Courant step collapses; when is up to roundoff, seen at 0.87",
    ))
}
