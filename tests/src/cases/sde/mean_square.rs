//! Mean-square stability on `dX = l X dt + m X dB`: the amplification of one step by quadrature, never by sampling.

use figures::{ErrorKind, Measured, Reference};
use sde_integrators::{
    DiagonalNoise, EulerMaruyama, Heun, Increment, Integrator, Milstein, SkRock, StochasticTheta,
    StratonovichForm,
};
use work_precision::problems::sde::problems::Geometric;
use work_precision::problems::sde::reference::MeanSquare;
use work_precision::problems::sde::stability::{Formula, boundary, formula_boundary};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/mean-square-stability",
    title: "mean-square amplification and its boundary on the linear test equation, by quadrature",
    source: "Higham 2000; Abdulle, Almuslimani and Vilmart 2018; derived/sde/mean_square_stability.json",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let theta = StochasticTheta::new(0.25)?;
    let mut claims = Vec::new();
    let survey = MeanSquare::read()?;
    for (k, &ray) in survey.rays.iter().enumerate() {
        let rows: [(&str, Measured, Formula); 4] = [
            ("euler-maruyama", on_ray(ray, &EulerMaruyama)?, Formula::Theta(0.0)),
            ("milstein", on_ray(ray, &Milstein)?, Formula::Milstein),
            ("theta-0.25", on_ray(ray, &theta)?, Formula::Theta(0.25)),
            ("heun", heun_on_ray(ray)?, Formula::Heun),
        ];
        for (id, measured, formula) in rows {
            claims.push(boundary_claim(context, id, ray, measured, formula)?);
            let published = match id {
                "euler-maruyama" => survey.euler_maruyama.get(k),
                "milstein" => survey.milstein.get(k),
                "heun" => survey.heun.get(k),
                _ => None,
            };
            if let Some(&published) = published {
                claims.push(survey_claim(context, id, ray, measured, published));
            }
        }
    }
    for (n_stages, without_noise, with_noise) in survey.sk_rock {
        let method = SkRock::new(n_stages)?;
        for (ray, published) in [(0.0, without_noise), (0.999, with_noise)] {
            let id = format!("sk-rock-{n_stages}");
            let measured = on_ray(ray, &method)?;
            let formula = Formula::SkRock(n_stages);
            claims.push(boundary_claim(context, &id, ray, measured, formula)?);
            claims.push(survey_claim(context, &id, ray, measured, published));
        }
    }
    claims.push(amplification_claim(context)?);
    claims.push(unlimited_claim(context)?);
    Ok(claims)
}

fn on_ray<I>(ray: f64, method: &I) -> Result<Measured, CaseError>
where
    I: Integrator<DiagonalNoise<Geometric>, 1, 1>,
{
    let step = |system: &DiagonalNoise<Geometric>, dt: f64, dw: &Increment<1>| {
        let mut x = [1.0];
        method.step(system, 0.0, dt, dw, &mut x, &mut I::Memory::default())?;
        Ok(x[0])
    };
    boundary(ray, &step)?.map(Measured::exact).ok_or_else(|| "no boundary below 10^4".into())
}

fn heun_on_ray(ray: f64) -> Result<Measured, CaseError> {
    boundary(ray, &heun)?.map(Measured::exact).ok_or_else(|| "no boundary below 10^4".into())
}

/// Heun's method solves the Stratonovich form of the test equation.
fn heun(
    system: &DiagonalNoise<Geometric>,
    dt: f64,
    dw: &Increment<1>,
) -> Result<f64, sde_integrators::StepError> {
    let mut x = [1.0];
    Heun.step(&StratonovichForm(system.0), 0.0, dt, dw, &mut x, &mut ())?;
    Ok(x[0])
}

fn boundary_claim(
    context: &Context<'_>,
    id: &str,
    ray: f64,
    measured: Measured,
    formula: Formula,
) -> Result<Claim, CaseError> {
    let expected = formula_boundary(ray, formula).ok_or("the formula has no boundary")?;
    let subject = context.subject(
        &format!("{id}/boundary/ray-{ray}"),
        "largest stable |l| h",
        "",
        "E|R|^2 = 1 by Gauss-Hermite quadrature and bisection",
    );
    let reason = "bisection to 1e-10; the quadrature is exact for the polynomial of the step";
    let criterion = Criterion::Within { tolerance: 1e-8, reason };
    let expected = Reference::exact(expected);
    Ok(Claim::judge(subject, ErrorKind::Relative, measured, expected, criterion))
}

fn survey_claim(
    context: &Context<'_>,
    id: &str,
    ray: f64,
    measured: Measured,
    published: f64,
) -> Claim {
    let subject = context.subject(
        &format!("{id}/boundary-survey/ray-{ray}"),
        "largest stable |l| h against an independent script",
        "",
        "E|R|^2 = 1 by Gauss-Hermite quadrature and bisection",
    );
    let reason = "the script's grid has steps of 0.3 %";
    let criterion = Criterion::Within { tolerance: 3.5e-3, reason };
    Claim::judge(subject, ErrorKind::Relative, measured, Reference::exact(published), criterion)
}

/// The amplification itself, off the boundary: the values at which sampling of 1e6 paths went wrong by up to 3 %.
fn amplification_claim(context: &Context<'_>) -> Result<Claim, CaseError> {
    let mut worst = 0.0_f64;
    for (formula, dt) in [0.1, 0.25, 0.4].into_iter().flat_map(|dt| {
        [Formula::Theta(0.0), Formula::Milstein, Formula::Heun, Formula::SkRock(5)]
            .map(|formula| (formula, dt))
    }) {
        let measured = work_precision::problems::sde::stability::amplification_of(
            formula,
            -3.0,
            3.0_f64.sqrt(),
            dt,
        )?;
        let expected = formula.amplification(-3.0 * dt, 3.0 * dt);
        worst = worst.max((measured / expected - 1.0).abs());
    }
    let subject = context.subject(
        "amplification",
        "worst relative error of E|R|^2",
        "",
        "Euler-Maruyama, Milstein, Heun, SK-ROCK 5 at l = -3, m = sqrt(3), h = 0.1, 0.25, 0.4",
    );
    let criterion = Criterion::Within { tolerance: 1e-12, reason: "roundoff" };
    let (measured, zero) = (Measured::exact(worst), Reference::exact(0.0));
    Ok(Claim::judge(subject, ErrorKind::Absolute, measured, zero, criterion))
}

/// `theta >= 1/2` is stable whenever the equation is: the largest amplification over rays and step lengths.
fn unlimited_claim(context: &Context<'_>) -> Result<Claim, CaseError> {
    let mut largest = 0.0_f64;
    for theta in [0.5, 0.75, 1.0] {
        for ray in [0.0, 0.5, 0.9, 0.999] {
            for exponent in -2..=6 {
                let dt = 10.0_f64.powi(exponent);
                let (l, m) = (-1.0, (2.0_f64 * ray).sqrt());
                let formula = Formula::Theta(theta);
                let measured =
                    work_precision::problems::sde::stability::amplification_of(formula, l, m, dt)?;
                largest = if measured.is_nan() { f64::NAN } else { largest.max(measured) };
            }
        }
    }
    let subject = context.subject(
        "theta-at-least-half/amplification",
        "largest E|R|^2",
        "",
        "theta 0.5, 0.75, 1; |l| h from 0.01 to 10^6; noise up to 0.999 of the limit of the equation",
    );
    let reason = "stable: below 1, up to roundoff";
    Ok(Claim::as_measured(subject, Measured::exact(largest), 0.0, 1.0 + 1e-9, reason))
}
