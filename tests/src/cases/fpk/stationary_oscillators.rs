//! Oscillators with an exact stationary law, from a Gaussian, with remeshing.

use fpk_sph::{
    Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Remapping, Simulation,
    StepRule,
};
use reference_problems::fpk::problem;
use scenes::fpk::density::{Demand, Requested, run_on};
use scenes::fpk::system::System;
use sde_integrators::{GaussianMixture, Sde};
use vibrating_systems::StationaryOscillator;

use super::{row, scene, worst};
use crate::cases::prelude::*;

pub(crate) const DUFFING: Case = Case {
    id: "fpk-sph/duffing-remapped",
    title: "Duffing's oscillator from a Gaussian to its exact stationary law, with remeshing",
    source: "Caughey 1971: exact stationary density",
    cost: Profile::Quick,
    run: Together(duffing),
};

pub(crate) const VAN_DER_POL: Case = Case {
    id: "fpk-sph/van-der-pol-remapped",
    title: "Oscillator of van der Pol and Rayleigh from a Gaussian to its ring, with remeshing",
    source: "Caughey & Payne 1967: exact stationary density",
    cost: Profile::Default,
    run: Together(van_der_pol),
};

/// The flow-map fit with remeshing.
pub(super) fn remapped(remapping: Remapping, steps_per_period: f64) -> Method {
    Method::Custom(Combination {
        remapping: Some(remapping),
        step: StepRule::PeriodFraction { steps_per_period },
        ..Method::FlowMapFit.combination()
    })
}

fn config(method: Method, reach: f64, spacing: f64, reference_period: f64) -> Config<2> {
    let lattice = InitialLattice::Ball { reach, spacing };
    Config { method, lattice, reference_period, most_steps: DEFAULT_MOST_STEPS }
}

fn duffing(context: &Context<'_>) -> CaseResult {
    let (system, law) = problem::duffing()?;
    let stationary = system.stationary()?;
    let period = system.period();
    let config = config(remapped(Remapping::MEASURED, 40.0), 6.0, 0.3, period);
    // 5 / (zeta omega_0) = 100.
    let tolerances = [1.5e-4, 8e-4, 2e-3];
    let lines = Stationary { context, law: &law, config: &config, end: &stationary, tolerances };
    let mut claims = lines.claims(system.clone(), 100.0, &[1.0, 2.0, 3.0])?;
    let whole = || -> CaseResult<Vec<u64>> {
        let mut simulation = Simulation::new(system.clone(), &law, &config)?;
        simulation.advance_to(5.0)?;
        if simulation.n_remaps() == 0 {
            return Err("no remeshing took place".into());
        }
        Ok(simulation.positions().iter().flatten().map(|x| x.to_bits()).collect())
    };
    let reason =
        "every position of a new lattice is computed independently, in the order of the lattice";
    claims.extend(super::over_threads(context, "flow-map-fit", reason, whole)?);
    Ok(claims)
}

fn van_der_pol(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../scenes/fpk/van_der_pol.json");
    let scene = scene("tests/scenes/fpk/van_der_pol.json", text)?;
    let System::VanDerPol(system) = scene.system.build()? else {
        return Err("the scene holds another system".into());
    };
    let law = scene.initial.build(None)?;
    let stationary = system.stationary()?;
    let config = config(remapped(Remapping::MEASURED, 80.0), 5.0, 0.25, system.period());
    // The linear damping is -2 zeta omega_0 = -0.2: 5 / (zeta omega_0) = 50.
    let tolerances = [4e-4, 8e-4, 1e-3];
    let lines = Stationary { context, law: &law, config: &config, end: &stationary, tolerances };
    lines.claims(system, 50.0, &[1.0, 2.0])
}

/// A run that ends in a stationary law.
struct Stationary<'a> {
    context: &'a Context<'a>,
    law: &'a GaussianMixture<2>,
    config: &'a Config<2>,
    end: &'a StationaryOscillator,
    /// Of second moments, relative; of the fourth; of log10 P to T = 2.
    tolerances: [f64; 3],
}

impl Stationary<'_> {
    fn claims<S: Sde<2, 1>>(&self, system: S, time: f64, thresholds: &[f64]) -> CaseResult {
        let asked = Requested {
            times: vec![time],
            powers: vec![[2, 0], [0, 2], [4, 0]],
            demand: Demand::displacement(),
            thresholds: thresholds.to_vec(),
            kinks: Vec::new(),
            cells: true,
        };
        let mut laid = (0, 0);
        let run = run_on(system, self.law, self.config, &asked, |simulation, _| {
            laid = (simulation.n_remaps(), simulation.n_particles());
        })?;
        let row = row(&run, time)?;
        let words = run.words("flow-map fit, ball, remeshing");
        let method = format!("{words}, {} remeshings, {} particles at the end", laid.0, laid.1);
        let lines = self.context.lines("flow-map-fit", method);
        let mut claims = Vec::new();
        let reason = "truncation of the fits; of the start exp(-10) of the energy is left";
        for ((powers, name, quantity, unit, tolerance), &value) in [
            ([2, 0], "second-moment-q", "E[q^2]", "m^2", self.tolerances[0]),
            ([0, 2], "second-moment-v", "E[v^2]", "m^2/s^2", self.tolerances[0]),
            ([4, 0], "fourth-moment-q", "E[q^4]", "m^4", self.tolerances[1]),
        ]
        .into_iter()
        .zip(&row.moments)
        {
            let subject = lines.of(name, quantity).unit(unit);
            let compared = subject.relative(value, self.end.moment(powers));
            claims.push(compared.within(tolerance).because(reason));
        }
        let mut near = Vec::new();
        for (&threshold, exceedance) in thresholds.iter().zip(&row.exceedances) {
            let value = exceedance.cell_integrated.ok_or("cells were asked for")?;
            let quantity = format!("P(|q| > {threshold})");
            let far = threshold > 2.5;
            let (tolerance, reason) = if far {
                (0.02, "truncation of the fits at P = 2.4e-8, at the boundary of the new lattices")
            } else {
                (self.tolerances[2], "truncation of the fits")
            };
            let claim = lines
                .of(format!("exceedance-cell/threshold-{threshold}"), quantity)
                .log10(value, self.end.exceedance(threshold)?)
                .within(tolerance)
                .because(reason);
            if far { &mut claims } else { &mut near }.push(claim);
        }
        let name = format!("{}/exceedance-cell/worst", lines.id);
        claims.push(worst(self.context, (&name, "T = 1, 2"), near)?);
        Ok(claims)
    }
}
