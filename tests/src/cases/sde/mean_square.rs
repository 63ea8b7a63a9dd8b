//! Mean-square stability on `dX = l X dt + m X dB`: the amplification of one step by quadrature, never by sampling.

use reference_problems::sde::problems::Geometric;
use reference_problems::sde::reference::MeanSquare;
use reference_problems::sde::stability::{Formula, boundary, formula_boundary};
use sde_integrators::{
    DiagonalNoise, EulerMaruyama, Heun, Increment, Integrator, ItoForm, Milstein, Sde,
    StochasticTheta, StratonovichForm, StratonovichSde,
};

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "sde-integrators/mean-square-stability",
    title: "mean-square amplification and its boundary on the linear test equation, by quadrature; the Itô form of a random rotation",
    source: "Higham 2000; derived/sde/mean_square_stability.json",
    cost: Profile::Quick,
    run: Together(run),
};

/// The worst error of the boundary of each method against its formula, and the worst of all against the survey.
#[derive(Default)]
struct Worst {
    /// Method and error, in the order in which methods come.
    formula: Vec<(String, f64)>,
    survey: f64,
    place: String,
}

impl Worst {
    fn take(
        &mut self,
        id: &str,
        ray: f64,
        found: f64,
        formula: Formula,
        published: Option<f64>,
    ) -> CaseResult<()> {
        let expected = formula_boundary(ray, formula).ok_or("the formula has no boundary")?;
        let error = (found / expected - 1.0).abs();
        match self.formula.iter_mut().find(|(name, _)| name == id) {
            Some((_, worst)) => *worst = larger(*worst, error),
            None => self.formula.push((id.to_owned(), error)),
        }
        if let Some(published) = published {
            let error = (found / published - 1.0).abs();
            if larger(self.survey, error).to_bits() != self.survey.to_bits() {
                self.survey = larger(self.survey, error);
                self.place = format!("{id}, ray {ray}");
            }
        }
        Ok(())
    }
}

/// The larger; NaN stays.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

fn run(context: &Context<'_>) -> CaseResult {
    let theta = StochasticTheta::new(0.25)?;
    let mut worst = Worst::default();
    let survey = MeanSquare::read()?;
    for (k, &ray) in survey.rays.iter().enumerate() {
        let euler = survey.euler_maruyama.get(k).copied();
        let milstein = survey.milstein.get(k).copied();
        worst.take(
            "euler-maruyama",
            ray,
            on_ray(ray, &EulerMaruyama)?,
            Formula::Theta(0.0),
            euler,
        )?;
        worst.take("milstein", ray, on_ray(ray, &Milstein)?, Formula::Milstein, milstein)?;
        worst.take("theta-0.25", ray, on_ray(ray, &theta)?, Formula::Theta(0.25), None)?;
        worst.take("heun", ray, heun_on_ray(ray)?, Formula::Heun, survey.heun.get(k).copied())?;
    }
    let mut claims: Vec<Claim> =
        worst.formula.iter().map(|(id, error)| boundary_claim(context, id, *error)).collect();
    claims.push(survey_claim(context, &worst));
    claims.push(amplification_claim(context)?);
    claims.push(unlimited_claim(context)?);
    claims.push(ito_claim(context));
    Ok(claims)
}

fn on_ray<I>(ray: f64, method: &I) -> CaseResult<f64>
where
    I: Integrator<DiagonalNoise<Geometric>, 1, 1>,
{
    let step = |system: &DiagonalNoise<Geometric>, dt: f64, dw: &Increment<1>| {
        let mut x = [1.0];
        method.step(system, 0.0, dt, dw, &mut x, &mut I::Memory::default())?;
        Ok(x[0])
    };
    boundary(ray, &step)?.ok_or_else(|| "no boundary below 10^4".into())
}

fn heun_on_ray(ray: f64) -> CaseResult<f64> {
    boundary(ray, &heun)?.ok_or_else(|| "no boundary below 10^4".into())
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

fn boundary_claim(context: &Context<'_>, id: &str, error: f64) -> Claim {
    let quantity = "worst relative error of the largest stable |l| h over all rays";
    let method = "E|R|^2 = 1 by Gauss-Hermite quadrature and bisection, against its formula";
    let reason = "roundoff: eps over the slope of E|R|^2 at its boundary; the quadrature is exact for the polynomial of a step";
    let subject = context.subject(format!("{id}/boundary"), quantity, method);
    subject.bounded(error, 3e-13).because(reason)
}

fn survey_claim(context: &Context<'_>, worst: &Worst) -> Claim {
    let quantity = "worst relative difference of the largest stable |l| h to an independent script";
    let method = format!("three methods on five rays; furthest: {}", worst.place);
    let claim = context.subject("survey", quantity, method).bounded(worst.survey, 3.5e-3);
    claim.because("the script's grid has steps of 0.3 %")
}

/// The amplification itself, off the boundary: the values at which sampling of 1e6 paths went wrong by up to 3 %.
fn amplification_claim(context: &Context<'_>) -> CaseResult<Claim> {
    let mut worst = 0.0_f64;
    for (formula, dt) in [0.1, 0.25, 0.4].into_iter().flat_map(|dt| {
        [Formula::Theta(0.0), Formula::Milstein, Formula::Heun].map(|formula| (formula, dt))
    }) {
        let measured = reference_problems::sde::stability::amplification_of(
            formula,
            -3.0,
            3.0_f64.sqrt(),
            dt,
        )?;
        let expected = formula.amplification(-3.0 * dt, 3.0 * dt);
        worst = worst.max((measured / expected - 1.0).abs());
    }
    let method = "Euler-Maruyama, Milstein, Heun at l = -3, m = sqrt(3), h = 0.1, 0.25, 0.4";
    let subject = context.subject("amplification", "worst relative error of E|R|^2", method);
    Ok(subject.bounded(worst, 1e-14).because("roundoff: some hundred operations of the quadrature"))
}

/// `theta >= 1/2` is stable whenever the equation is: amplifications over rays and step lengths above one.
fn unlimited_claim(context: &Context<'_>) -> CaseResult<Claim> {
    let (mut unstable, mut all) = (0, 0);
    for theta in [0.5, 0.75, 1.0] {
        for ray in [0.0, 0.5, 0.9, 0.999] {
            for exponent in -2..=6 {
                let dt = 10.0_f64.powi(exponent);
                let (l, m) = (-1.0, (2.0_f64 * ray).sqrt());
                let formula = Formula::Theta(theta);
                let measured =
                    reference_problems::sde::stability::amplification_of(formula, l, m, dt)?;
                let is_stable = measured <= 1.0 + 1e-9;
                unstable += usize::from(!is_stable);
                all += 1;
            }
        }
    }
    let quantity = "step lengths and rays with E|R|^2 above 1 + 1e-9";
    let method = "theta 0.5, 0.75, 1; |l| h from 0.01 to 10^6; noise up to 0.999 of the limit of the equation";
    let subject = context.subject("theta-at-least-half/amplification", quantity, method);
    Ok(subject.same_bits(unstable, all).because("stable whenever the equation is"))
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
    let quantity = "worst error of the drift, over |x|";
    let method = "ItoForm of dX = J X o dB at four states";
    let reason =
        "roundoff: central differences of a linear function, eps^(2/3) over the ratio of |x| to 1";
    context.subject("ito-form/rotation", quantity, method).bounded(worst, 4e-11).because(reason)
}
