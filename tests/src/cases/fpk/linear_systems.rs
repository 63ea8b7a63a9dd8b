//! Linear systems of one to four states, whose law is Gaussian at all times, by the flow-map fit.

use fpk_sph::InitialLattice;
use reference_problems::fpk::linear_moments::{NormalLaw, linear_moments};
use reference_problems::fpk::methods::KANAI_TAJIMI_LATTICE;
use scenes::fpk::density::{Demand, DensityRun, Requested, run_on};
use scenes::fpk::system::System;
use sde_integrators::{GaussianMixture, Sde};
use vibrating_systems::{OrnsteinUhlenbeck, OrnsteinUhlenbeckParameters};

use super::{exceedance_at, flow_map_fit, row, scene, worst};
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "fpk-sph/linear-systems",
    title: "Ornstein-Uhlenbeck in 1 to 4 dimensions, by the flow-map fit",
    source: "Risken 1996, section 6.5: exact",
    cost: Profile::Quick,
    run: Together(processes),
};

pub(crate) const KANAI_TAJIMI: Case = Case {
    id: "fpk-sph/kanai-tajimi",
    title: "Linear building on filtered ground motion, 4 states, by the flow-map fit",
    source: "Lyapunov equation; Kanai 1957, Tajimi 1960",
    cost: Profile::Default,
    run: Together(kanai_tajimi),
};

fn processes(context: &Context<'_>) -> CaseResult {
    Ok(vec![
        ornstein_uhlenbeck::<1>(context, 0.5, 5e-5)?,
        ornstein_uhlenbeck::<2>(context, 0.5, 1.5e-5)?,
        ornstein_uhlenbeck::<3>(context, 0.8, 2e-4)?,
        ornstein_uhlenbeck::<4>(context, 1.2, 2e-4)?,
    ])
}

/// States whose product is taken.
const PAIRS: [(usize, usize); 5] = [(0, 0), (0, 1), (1, 1), (2, 2), (3, 3)];

fn kanai_tajimi(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../scenes/fpk/kanai_tajimi.json");
    let scene = scene("tests/scenes/fpk/kanai_tajimi.json", text)?;
    let built = scene.system.build()?;
    let System::KanaiTajimiLinear(system) = &built else {
        return Err("the scene holds another system".into());
    };
    let law: GaussianMixture<4> = scene.initial.build(built.filter_covariance().as_deref())?;
    let times = [1.0, 2.0, 4.0];
    let laws = linear_moments(system, &law, &times, 2e-3)?;
    let config = flow_map_fit(KANAI_TAJIMI_LATTICE, built.reference_period());
    let asked = Requested {
        times: times.to_vec(),
        powers: PAIRS.map(powers_of).to_vec(),
        demand: Demand::of_state(0, "q", 4),
        thresholds: scene.thresholds.clone(),
        kinks: Vec::new(),
        cells: true,
    };
    let run = run_on(system.clone(), &law, &config, &asked, |_, _| ())?;
    let method = run.words("flow-map fit, ball of 5 sigma, spacing 1.2");
    let lines = context.lines("flow-map-fit", method);
    let (mut second, mut tails) = (Vec::new(), Vec::new());
    for exact in &laws {
        second.extend(moments(&lines, &run, exact, built.states())?);
        tails.extend(tail(&lines, &run, exact, &scene.thresholds)?);
    }
    let over = format!("t = {times:?}, the building's and the filter's states");
    let tail_over = format!("t = {times:?} and thresholds with P >= 1e-5");
    Ok(vec![
        worst(context, ("flow-map-fit/second-moment/worst", &over), second)?,
        worst(context, ("flow-map-fit/exceedance-cell/worst", &tail_over), tails)?,
    ])
}

fn powers_of((i, j): (usize, usize)) -> [u32; 4] {
    std::array::from_fn(|k| u32::from(k == i) + u32::from(k == j))
}

fn moments(
    lines: &Lines<'_>,
    run: &DensityRun,
    exact: &NormalLaw<4>,
    states: &[&str],
) -> CaseResult {
    let t = exact.t;
    let reason = "the probability beyond 5 sigma that the ball leaves out, 5e-5, times the square of 5 over 2, and \
                  Runge-Kutta 4";
    let claim = |((i, j), &value): ((usize, usize), &f64)| {
        let scale = (exact.covariance[i][i] * exact.covariance[j][j]).sqrt();
        let Reference { value: expected, error } = exact.second_moment(i, j);
        let quantity = format!("E[{} {}] over its scale", states[i], states[j]);
        let reference =
            Reference { value: expected / scale, error: error.map(|error| error / scale) };
        let subject = lines.of(format!("second-moment/{}-{}/t{t}", states[i], states[j]), quantity);
        subject.absolute(value / scale, reference).within(1e-3).because(reason)
    };
    Ok(PAIRS.into_iter().zip(&row(run, t)?.moments).map(claim).collect())
}

/// `P(|q| > T)` down to 1e-5.
fn tail(
    lines: &Lines<'_>,
    run: &DensityRun,
    exact: &NormalLaw<4>,
    thresholds: &[f64],
) -> CaseResult {
    let t = exact.t;
    let reason = "a cell of 1.2 sigma in three parts along each axis, fourth order in 0.4, and the variance that the ball \
                  leaves out times the square of 4.4 over 2";
    let mut claims = Vec::new();
    for (&threshold, found) in thresholds.iter().zip(&row(run, t)?.exceedances) {
        let reference = exact.exceedance(&[1.0, 0.0, 0.0, 0.0], threshold);
        if reference.value < 1e-5 {
            continue;
        }
        let value = found.cell_integrated.unwrap_or(f64::NAN);
        let compared = exceedance_at(lines, "cell", threshold, t).log10(value, reference);
        claims.push(compared.within(4e-3).because(reason));
    }
    Ok(claims)
}

/// Rates and noise without symmetry, so that no entry of the covariance is zero.
fn process<const D: usize>() -> CaseResult<OrnsteinUhlenbeck<D>> {
    const RATES: [[f64; 4]; 4] =
        [[1.0, 0.5, 0.0, 0.1], [-0.5, 1.5, 0.2, 0.0], [0.0, 0.3, 0.4, -0.2], [0.2, 0.0, 0.1, 0.8]];
    const NOISE: [[f64; 4]; 4] =
        [[0.5, 0.0, 0.0, 0.0], [0.1, 0.4, 0.0, 0.0], [0.0, 0.2, 0.3, 0.0], [0.1, 0.0, 0.1, 0.4]];
    let part = |of: &[[f64; 4]; 4]| std::array::from_fn(|i| std::array::from_fn(|j| of[i][j]));
    let mean = std::array::from_fn(|i| [0.2, 0.0, -0.1, 0.3][i]);
    let parameters = OrnsteinUhlenbeckParameters { rates: part(&RATES), mean, noise: part(&NOISE) };
    Ok(OrnsteinUhlenbeck::new(parameters)?)
}

fn ornstein_uhlenbeck<const D: usize>(
    context: &Context<'_>,
    spacing: f64,
    tolerance: f64,
) -> CaseResult<Claim>
where
    OrnsteinUhlenbeck<D>: Sde<D, D>,
{
    context.progress(&format!("Ornstein-Uhlenbeck, D = {D}"));
    let process = process::<D>()?;
    let start_mean = std::array::from_fn(|i| [1.0, 0.0, 0.0, -0.5][i]);
    let deviation = std::array::from_fn(|i| [0.1, 0.2, 0.3, 0.2][i]);
    let law = GaussianMixture::independent(start_mean, deviation)?;
    let config = flow_map_fit(InitialLattice::Ball { reach: 6.0, spacing }, 3.0);
    let times = [0.5, 1.0, 2.0];
    let mut powers = Vec::new();
    for i in 0..D {
        powers.push(std::array::from_fn(|k| u32::from(k == i)));
        for j in 0..=i {
            powers.push(std::array::from_fn(|k| u32::from(k == i) + u32::from(k == j)));
        }
    }
    let asked = Requested {
        times: times.to_vec(),
        powers,
        demand: Demand::of_state(0, "x1", D),
        thresholds: vec![],
        kinks: Vec::new(),
        cells: false,
    };
    let run = run_on(process, &law, &config, &asked, |_, _| ())?;
    let mut worst = 0.0_f64;
    for t in times {
        let mut moments = row(&run, t)?.moments.iter();
        let covariance = process.covariance_at(t, &law.covariance())?;
        let mut means = Vec::new();
        for i in 0..D {
            means.push(*moments.next().ok_or("a moment is missing")?);
            for j in 0..=i {
                let found = moments.next().ok_or("a moment is missing")? - means[i] * means[j];
                let scale = (covariance[i][i] * covariance[j][j]).sqrt();
                let error = (found - covariance[i][j]).abs() / scale;
                worst = if error.is_nan() { f64::NAN } else { worst.max(error) };
            }
        }
    }
    let method = run.words(&format!("flow-map fit, ball of 6 sigma, spacing {spacing}"));
    let lines = context.lines(format!("ornstein-uhlenbeck-{D}"), method);
    let reason = "the trapezoidal sum of the start over a ball of 6 sigma, 7e-5 of a variance in four dimensions, and \
                  Runge-Kutta 4";
    let subject = lines.of("covariance/worst", "worst error of C_ij over its scale, t = 0.5, 1, 2");
    Ok(subject.bounded(worst, tolerance).because(reason))
}
