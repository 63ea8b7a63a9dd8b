//! Waves in a long bar: how their frequency depends on their length.

use peridyn_sde::{
    Body, BondConfig, BondList, Bonds, Condition, Horizon, Influence, Nodes, Strain,
    SurfaceCorrection, VolumeCorrection,
};
use serde_json::Value;

use super::rest::numbers;
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/dispersion",
    title: "Frequency of waves in a bar by their length, on the lattice and in the limit of a fine one",
    source: "sums over the bonds of a lattice, and rho w^2 = (4 E/delta^2) (gamma + ln(k delta) - Ci(k delta)): dispersion1d.json",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// `rho omega^2 dx^2/E` of the wave `cos(kappa x)`, by the force on the node at its crest, with the horizon `shells + beyond`.
pub(super) fn frequency(
    (shells, beyond): (u32, f64),
    volume_correction: VolumeCorrection,
    kappa: f64,
) -> Result<f64, CaseError> {
    let reach = f64::from(shells) + 1.0;
    let ends = ([-reach - 0.5], [reach + 0.5]);
    let nodes = Nodes::lattice(1.0, ends, Condition::Bar { area: 1.0 }, |_| true)?;
    let config = BondConfig {
        horizon: Horizon::new(f64::from(shells) + beyond, 1.0)?,
        young_modulus: 1.0,
        influence: Influence::Constant,
        volume_correction,
        surface_correction: SurfaceCorrection::None,
    };
    let bonds = Bonds::new(&nodes, &config)?;
    let wave: Vec<f64> = nodes.positions().iter().map(|x| (kappa * x[0]).cos()).collect();
    let strengths = vec![1.0; bonds.len()];
    let mut body = BondList::<f64, 1, 1>::new(nodes, bonds, Strain::Linear, &strengths)?;
    let mut forces = vec![0.0; wave.len()];
    body.linear_forces(&wave, &mut forces)?;
    Ok(-forces[wave.len() / 2])
}

/// A horizon that ends on nodes is refused, as roundoff would decide which bonds it has: the limit from above it.
fn limit(shells: u32, correction: VolumeCorrection, kappa: f64) -> Result<f64, CaseError> {
    let at = |beyond: f64| frequency((shells, beyond), correction, kappa);
    Ok(2.0 * at(1e-6)? - at(2e-6)?)
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let text = include_str!("../../../reference/derived/peridyn/dispersion1d.json");
    let reference: Value = serde_json::from_str(text)?;
    let method =
        "linear strain, force at the crest; limit to the horizon m dx of two a little longer";
    let kappas = numbers(&reference["kappa_dx"])?;
    let mut claims = Vec::new();
    for (key, correction, what) in [
        ("halfvol", VolumeCorrection::Partial, "half of the farthest bonds"),
        ("novol", VolumeCorrection::None, "all of the farthest bonds"),
    ] {
        let mut worst = Worst::default();
        for shells in [2, 3, 4, 6] {
            let expected = numbers(&reference[format!("omega2_m{shells}_{key}")])?;
            for (&kappa, expected) in kappas.iter().zip(&expected) {
                let error = limit(shells, correction, kappa)? / expected - 1.0;
                worst.take(error, &format!("m = {shells}, kappa dx = {kappa:.3}"));
            }
        }
        claims.push(Lines { context, id: "", method: worst.method(method) }.bounded(
            (
                key,
                &format!("largest relative error of omega^2 over m = 2, 3, 4, 6 and {} wave numbers up to pi/dx, {what}", kappas.len()),
                "",
            ),
            worst.value(),
            5e-12,
            "square of the distance to the limit, 1e-12, and roundoff of long waves, 1e-12",
        ));
    }
    claims.extend(fine(context, &reference)?);
    Ok(claims)
}

/// Against the continuum at wave numbers over the horizon up to ten, with 16 and 32 nodes in a horizon.
fn fine(context: &Context<'_>, reference: &Value) -> Result<[Claim; 2], CaseError> {
    let kappas = numbers(&reference["kappa_delta"])?;
    let expected = numbers(&reference["continuum_rho_w2_delta2_over_E"])?;
    let error = |shells: u32| -> Result<f64, CaseError> {
        let m = f64::from(shells);
        let mut worst: f64 = 0.0;
        for (kappa, expected) in kappas.iter().zip(&expected).filter(|(kappa, _)| **kappa <= 10.0) {
            let found = limit(shells, VolumeCorrection::Partial, kappa / m)? * m * m;
            worst = worst.max((found / expected - 1.0).abs());
        }
        Ok(worst)
    };
    let (coarse, fine) = (error(16)?, error(32)?);
    let lines = Lines {
        context,
        id: "continuum",
        method: "m = 16 and 32, half of the farthest bonds".into(),
    };
    Ok([
        lines.bounded(
            ("error", "largest relative error of omega^2 for k delta up to 10, m = 32", ""),
            fine,
            4e-3,
            "the sum over bonds is the trapezoidal rule for the integral: at k delta = 10 up to (k dx)^2/12 = 0.8 %, of which the integral sees a part",
        ),
        lines.measured(
            ("order", "order of that error between m = 16 and 32", ""),
            (coarse / fine).log2(),
            (1.95, 2.05),
            "two, that of the trapezoidal rule",
        ),
    ])
}
