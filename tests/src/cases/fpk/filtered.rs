//! Buildings behind the ground filter of Kanai and Tajimi, four and five states, against paths.

use fpk_sph::InitialLattice;
use scenes::fpk::density::{Demand, DensityRun, Exceedances, Requested, run_on};
use scenes::fpk::monte_carlo::{SampledRun, Sampling, run_on as sample};
use scenes::fpk::paths::Paths;
use scenes::fpk::scene::FpkScene;
use scenes::fpk::system::System;
use sde_integrators::GaussianMixture;

use super::conditioned::NAMES;
use super::{exceedance_at, flow_map_fit, row, scene, worst};
use crate::cases::prelude::*;

pub(crate) const DAMPER: Case = Case {
    id: "fpk-sph/filtered-damper",
    title: "Building with a viscous damper behind Kanai-Tajimi, 4 states, against Monte Carlo",
    source: "the same system sampled by ShARK",
    cost: Profile::Full,
    run: Together(damper),
};

pub(crate) const BOUC_WEN: Case = Case {
    id: "fpk-sph/filtered-bouc-wen",
    title: "Building that yields behind Kanai-Tajimi, 5 states, against Monte Carlo",
    source: "the same system sampled by ShARK; spectrum of Housner & Jennings 1964, window C of Jennings, Housner & Tsai 1968",
    cost: Profile::Default,
    run: Together(bouc_wen),
};

/// A run of the density and the paths that it is held against.
struct Compared<'a, const D: usize> {
    run: DensityRun,
    sampled: SampledRun,
    asked: Requested<D>,
    lines: Lines<'a>,
}

/// Both, with the law and the system of the scene.
fn compare<'a, S: Paths<D, 1>, const D: usize>(
    context: &'a Context<'a>,
    (scene, built, system): (&FpkScene, &System, &S),
    lattice: InitialLattice<D>,
    sampling: &Sampling,
    asked: Requested<D>,
) -> CaseResult<Compared<'a, D>> {
    let law: GaussianMixture<D> = scene.initial.build(built.filter_covariance().as_deref())?;
    let config = flow_map_fit(lattice, built.reference_period());
    let run = run_on(system.clone(), &law, &config, &asked, |_, _| ())?;
    context.progress("paths");
    let sampled = sample(system, &law, sampling, &asked)?;
    let InitialLattice::Ball { reach, spacing } = lattice else {
        return Err("the lattice is no ball".into());
    };
    let method = format!(
        "{}; against {} paths, step {} s, {:.1} s CPU",
        run.words(&format!("flow-map fit, ball of {reach} sigma, spacing {spacing}")),
        sampling.paths,
        sampling.step,
        sampled.cpu_seconds
    );
    Ok(Compared { run, sampled, asked, lines: context.lines("flow-map-fit", method) })
}

impl<const D: usize> Compared<'_, D> {
    /// The second moments at some of the times, in the order asked, by these names.
    fn moments(
        &self,
        names: &[(&str, &str, &str)],
        times: &[f64],
        criterion: Criterion<'_>,
    ) -> CaseResult {
        let mut claims = Vec::new();
        for sampled in self.sampled.rows.iter().filter(|sampled| times.contains(&sampled.t)) {
            let (t, row) = (sampled.t, row(&self.run, sampled.t)?);
            for (&(name, quantity, unit), (value, paths)) in
                names.iter().zip(row.moments.iter().zip(&sampled.moments))
            {
                let subject = self.lines.of(format!("{name}/t{t}"), quantity).unit(unit);
                claims.push(subject.relative(*value, estimated(paths)).judged(criterion));
            }
        }
        Ok(claims)
    }

    /// `P(|q| > T)` by an estimator, where the paths know it: the worst.
    fn tail(&self, tail: &Tail, criterion: Criterion<'_>) -> CaseResult<Claim> {
        let mut claims = Vec::new();
        for sampled in &self.sampled.rows {
            let (t, row) = (sampled.t, row(&self.run, sampled.t)?);
            for (&threshold, (found, paths)) in
                self.asked.thresholds.iter().zip(row.exceedances.iter().zip(&sampled.exceedances))
            {
                let reference = estimated(paths);
                if !tail.is_known(&reference) {
                    continue;
                }
                let subject = exceedance_at(&self.lines, tail.estimator, threshold, t);
                claims.push(subject.log10((tail.pick)(found), reference).judged(criterion));
            }
        }
        let name = format!("flow-map-fit/exceedance-{}/worst", tail.estimator);
        let over = "times and thresholds whose P the paths know";
        worst(self.lines.context, (&name, over), claims)
    }
}

/// Which probabilities of exceedance are compared, and by which estimator.
struct Tail {
    estimator: &'static str,
    pick: fn(&Exceedances) -> f64,
    /// The least probability.
    least: f64,
    /// The largest standard error of the paths, over the probability.
    known: f64,
}

impl Tail {
    fn is_known(&self, reference: &Reference) -> bool {
        reference.value >= self.least
            && reference.error.is_some_and(|error| error <= self.known * reference.value)
    }
}

const OTHER: &str = "the scene holds another system";

fn damper(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../scenes/fpk/damper_kanai_tajimi.json");
    let scene = scene("tests/scenes/fpk/damper_kanai_tajimi.json", text)?;
    let built = scene.system.build()?;
    let System::KanaiTajimiDamper(system) = &built else { return Err(OTHER.into()) };
    let asked = Requested {
        times: vec![1.0, 2.0, 3.0, 4.0],
        powers: vec![[2, 0, 0, 0], [0, 2, 0, 0]],
        demand: Demand::of_state(0, "q", 4),
        thresholds: vec![0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75],
        kinks: Vec::new(),
        cells: true,
    };
    let lattice = InitialLattice::Ball { reach: 6.5, spacing: 0.8 };
    let sampling = sampling(2_000_000);
    let compared = compare(context, (&scene, &built, system), lattice, &sampling, asked)?;
    let reason = "truncation of the cubic fit at a spacing of 0.8 sigma; seen within 2.1 %, of which the paths know 0.1 %. With \
                  half their step the moments of as many paths differ by 0.3 % at most";
    let within = Criterion::Within { tolerance: 0.03, reason };
    let times = [1.0, 2.0, 3.0, 4.0];
    let family = compared.moments(&NAMES[..2], &times, within)?;
    let over = format!("E[q^2], E[v^2], t = {times:?}");
    let mut claims = vec![worst(context, ("flow-map-fit/second-moments/worst", &over), family)?];
    let cells = Tail {
        estimator: "cell",
        pick: |found| found.cell_integrated.unwrap_or(f64::NAN),
        least: 1e-4,
        known: 0.1,
    };
    let reason = "the fit within a cell of 0.8 sigma, and what starts beyond the ball: with one of 6 sigma -0.16 at P = 2e-4, \
                  t = 4. The paths know P = 1e-4 to 7 %, 0.03. Half their step moves P by less than two standard errors";
    claims.push(compared.tail(&cells, Criterion::Within { tolerance: 0.15, reason })?);
    Ok(claims)
}

fn sampling(paths: u64) -> Sampling {
    Sampling { paths, step: 0.01, seed: 7 }
}

fn bouc_wen(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../scenes/fpk/bouc_wen_kanai_tajimi.json");
    let scene = scene("tests/scenes/fpk/bouc_wen_kanai_tajimi.json", text)?;
    let built = scene.system.build()?;
    let System::KanaiTajimiBoucWen(system) = &built else { return Err(OTHER.into()) };
    let asked = Requested {
        times: vec![1.0, 2.0, 3.0, 4.0],
        powers: vec![[2, 0, 0, 0, 0], [0, 2, 0, 0, 0], [0, 0, 2, 0, 0]],
        demand: Demand::of_state(0, "q", 5),
        thresholds: vec![0.25, 0.5, 1.0],
        kinks: Vec::new(),
        cells: false,
    };
    let lattice = InitialLattice::Ball { reach: 4.5, spacing: 1.2 };
    let compared = compare(context, (&scene, &built, system), lattice, &sampling(200_000), asked)?;
    let elastic = "a quadratic fit at 1.2 standard deviations, and 0.3 % of the paths, while the building is elastic";
    let yields = "not reached: the same fit is low by 3 to 9 % once the building yields and the window is at its plateau. A \
                  spacing of 1 ends in `TooMuchUnresolved` at t = 1.73";
    let mut claims = Vec::new();
    for (name, times, tolerance, reason) in
        [("elastic", [1.0, 2.0], 0.02, elastic), ("yielding", [3.0, 4.0], 0.12, yields)]
    {
        let family = compared.moments(&NAMES, &times, Criterion::Within { tolerance, reason })?;
        let over = format!("E[q^2], E[v^2], E[z^2], t = {times:?}");
        let name = format!("flow-map-fit/second-moments/worst-{name}");
        claims.push(worst(context, (&name, &over), family)?);
    }
    let reason = "not reached: the same, and few particles beyond a threshold";
    let counted = Tail {
        estimator: "log-interpolated",
        pick: |found| found.log_interpolated,
        least: 0.0,
        known: 0.03,
    };
    claims.push(compared.tail(&counted, Criterion::Within { tolerance: 0.18, reason })?);
    Ok(claims)
}
