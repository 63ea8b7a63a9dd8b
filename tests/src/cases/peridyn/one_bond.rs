//! One bond in noise: when it first comes to its strength.

use peridyn_sde::{Breaking, Dynamics, Loading, Mobility, Scheme, Simulation, SimulationConfig};
use sde_integrators::Noise;

use crate::case::{Case, CaseError, Context, Profile};
use crate::cases::lines::Lines;
use crate::claim::{Criterion, Measured, Reference};
use crate::peridyn::first_passage::{rate, rate_with_bridge};
use crate::peridyn::network::{Network, lanes};
use crate::report::{Claim, ErrorKind};

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/one-bond",
    title: "A bond as an Ornstein-Uhlenbeck path: the rate at which it breaks, by scheme, with and without the bridge",
    source: "lowest eigenvalue of the killed process, f'' - x f' + lambda f = 0, f(s0/sigma) = 0; Karatzas and Shreve 1991, eq 4.3.40",
    cost: Profile::Quick,
    run,
};

/// Bonds of a chain whose other nodes are held, each for itself.
const BONDS: usize = 500;

const LANES: usize = 8;

/// The rate seen over some relaxation times, with its standard error.
fn seen(
    scheme: Scheme,
    breaking: Breaking,
    (ratio, z, times): (f64, f64, f64),
) -> Result<Measured, CaseError> {
    let mut network = Network::chain(2 * BONDS - 1)?;
    for (node, free) in network.free.iter_mut().enumerate() {
        *free = node % 2 == 1;
    }
    // kT = k = 1: the deviation of a stretch is one.
    let body = lanes::<1, LANES>(&network, ratio)?;
    let loading = Loading::new(network.free.len()).hold(&network.held())?;
    let mobility = Mobility::identity(&network.free, 1.0)?;
    let config = SimulationConfig {
        dynamics: Dynamics::Overdamped { mobility, temperature: 1.0, scheme },
        dt: z,
        breaking,
        confinement: 0.0,
        noise: Noise::new(23),
    };
    let ids = std::array::from_fn(|lane| lane as u64);
    let mut run = Simulation::new(body, loading, config, ids)?;
    // A free node keeps the bond to its left.
    let others: Vec<usize> = (1..2 * BONDS - 1).step_by(2).collect();
    run.cut(&others)?;
    let mut whole = (BONDS * LANES) as f64;
    let (mut broken, mut time) = (0.0, 0.0);
    let (settled, last) = (count(5.0 / z), count(times / z));
    for step in 0..last {
        let report = run.step()?;
        let lost: u32 = report
            .broken
            .iter()
            .filter(|event| event.cause != peridyn_sde::Cause::Cut)
            .map(|event| event.lanes.count_ones())
            .sum();
        // From rest a path needs some times to forget its start.
        if step >= settled {
            broken += f64::from(lost);
            time += (whole - 0.5 * f64::from(lost)) * z;
        }
        whole -= f64::from(lost);
    }
    Ok(Measured::sampled(broken / time, broken.sqrt() / time))
}

/// A number of steps.
fn count(steps: f64) -> u64 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of steps")]
    let whole = steps.round() as u64;
    whole
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    for ratio in [3.0, 5.0] {
        let exact = rate(ratio);
        for (scheme, tolerance) in [(Scheme::Theta(0.5), 0.02), (Scheme::Heun, 0.02)] {
            for z in [0.1, 0.05] {
                let id =
                    format!("{}/ratio{ratio}/z{z}", scheme.name().to_lowercase().replace(' ', "-"));
                let lines = Lines {
                    context,
                    id: &id,
                    method: format!("{} with the bridge, on a grid", scheme.name()),
                };
                claims.push(lines.relative(
                    ("transition", "rate of breaking, from the transition of one step", "1/relaxation time"),
                    rate_with_bridge(scheme, z, ratio),
                    exact,
                    tolerance,
                    "asked: 2 % at z = 0.1 and below. Of second order in z: the step has its law to that order, and the bridge is that of a path without drift",
                ));
            }
        }
        let euler = rate_with_bridge(Scheme::EulerMaruyama, 0.1, ratio) / exact;
        let lines = Lines {
            context,
            id: &format!("euler-maruyama/ratio{ratio}/z0.1"),
            method: "Euler-Maruyama with the bridge, on a grid".into(),
        };
        claims.push(lines.measured(
            ("transition", "rate over the exact one", ""),
            euler,
            if ratio < 4.0 { (1.2, 1.25) } else { (1.7, 1.85) },
            "too large: its variance is, by 1/(1 - z/2), and a rare event sees that in its exponent",
        ));
    }
    let times = if context.profile == Profile::Quick { 60.0 } else { 400.0 };
    let exact = rate(3.0);
    for (scheme, breaking, name) in [
        (Scheme::Theta(0.5), Breaking::Bridge, "theta-0.5"),
        (Scheme::Heun, Breaking::Bridge, "heun"),
    ] {
        let found = seen(scheme, breaking, (3.0, 0.1, times))?;
        claims.push(Claim::judge(
            context.subject(&format!("{name}/ratio3/z0.1/sampled"), "rate of breaking", "1/relaxation time", &format!("{} with the bridge, {BONDS} bonds in {LANES} lanes", scheme.name())),
            ErrorKind::Relative,
            found,
            Reference::exact(exact),
            Criterion::MonteCarlo { bias_bound: 0.02, reason: "asked: 2 % at z = 0.1; on a grid theta = 1/2 is 0.6 % above, Heun 0.4 % below" },
        ));
    }
    for (scheme, name, band) in [
        (Scheme::EulerMaruyama, "euler-maruyama", (0.5, 0.8)),
        (Scheme::LeimkuhlerMatthews, "leimkuhler-matthews", (0.35, 0.6)),
    ] {
        let found = seen(scheme, Breaking::AtEnds, (3.0, 0.1, times))?;
        let subject = context.subject(
            &format!("{name}/ratio3/z0.1/at-ends"),
            "rate of breaking over the exact one",
            "",
            &format!("{}, looked at the ends of steps", scheme.name()),
        );
        let scaled =
            Measured::sampled(found.value / exact, found.standard_error.unwrap_or(0.0) / exact);
        claims.push(Claim::as_measured(subject, scaled, band.0, band.1, "too small: crossings between the ends are missed, of the order sqrt(z); Leimkuhler and Matthews' steps are averages besides"));
    }
    Ok(claims)
}
