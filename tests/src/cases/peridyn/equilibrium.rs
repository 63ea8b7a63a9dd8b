//! The stationary law of each scheme on small networks: exactly, and sampled.

use figures::{ErrorKind, Measured, Reference};
use nalgebra::DMatrix;
use peridyn_sde::{
    Breaking, CompactMobility, CorrelatedMobility, Correlation, CorrelationFunction, Error,
    Mobility, Scheme, Simulation, SimulationConfig,
};
use sde_integrators::Noise;
use work_precision::problems::peridyn::network::{
    Network, distance, foster, lanes, rate, stationary,
};
use work_precision::problems::peridyn::stationary::{
    TEMPERATURE, covariance_of_baoab, law_of, overdamped,
};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/equilibrium",
    title: "Covariance of small networks with linear bonds against kT K^-1: the maps of the schemes, and samples",
    source: "discrete Lyapunov equation of each scheme; kT min(i, j) of a chain (chain10.json); Leimkuhler and Matthews 2013; Foster 1961",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

fn correlation(function: CorrelationFunction) -> Correlation {
    Correlation { function, length: 1.3 }
}

/// Identity and three that couple nodes.
fn mobilities<const D: usize>(
    network: &Network<D>,
) -> Result<Vec<(&'static str, Mobility)>, Error> {
    let (x, free) = (network.nodes.positions(), &network.free[..]);
    let correlated = CorrelatedMobility {
        correlation: correlation(CorrelationFunction::Gaussian),
        mobility: 1.0,
        nugget: 0.1,
    };
    let compact = CompactMobility { length: 1.3, support: 2.6, mobility: 1.0, nugget: 0.1 };
    Ok(vec![
        ("identity", Mobility::identity(free, 1.0)?),
        ("dense", Mobility::dense(x, free, &correlated)?),
        ("low rank", Mobility::low_rank(x, free, &correlated, 1e-3)?),
        ("compact", Mobility::compact(x, free, &compact)?),
    ])
}

fn exact_laws<const D: usize>(
    context: &Context<'_>,
    name: &str,
    network: &Network<D>,
) -> Result<Vec<Claim>, CaseError> {
    let k = network.stiffness();
    let exact = TEMPERATURE * k.clone().try_inverse().ok_or("a singular network")?;
    let mut claims = Vec::new();
    for (mobility_name, mobility) in mobilities(network)? {
        let id = format!("{name}/{}", mobility_name.replace(' ', "-"));
        for z in [0.1, 1.0, 1.9] {
            for scheme in [Scheme::LeimkuhlerMatthews, Scheme::Theta(0.5)] {
                let lines = Lines {
                    context,
                    id: &id,
                    method: format!("{}, {mobility_name}, z = {z}", scheme.name()),
                };
                let law = law_of(network, &mobility, scheme, z)?;
                let key = format!("{}/z{z}", scheme.name().to_lowercase().replace([' ', '-'], "-"));
                let reason = "exact for linear forces, for any positive definite M and any stable step; roundoff of the matrices, whose condition is up to 1e3; the linear system of an implicit step is solved to 1e-11, and the covariance is off by up to a condition times that";
                claims.push(lines.bounded(
                    (
                        &format!("{key}/covariance"),
                        "largest entry of cov - kT K^-1 over its largest",
                        "",
                    ),
                    distance(&law.covariance, &exact),
                    if matches!(scheme, Scheme::Theta(_)) { 1e-9 } else { 1e-12 },
                    reason,
                ));
                claims.push(lines.bounded(
                    (
                        &format!("{key}/kick"),
                        "the first step from rest against N z, with the same factor L as in M",
                        "",
                    ),
                    law.kick,
                    if matches!(scheme, Scheme::Theta(_)) { 1e-10 } else { 1e-13 },
                    "roundoff; the linear system of an implicit step is solved to 1e-11",
                ));
            }
        }
        claims.extend(biased(context, &id, network, (mobility_name, &mobility), &exact)?);
    }
    Ok(claims)
}

/// The bias of Euler and Heun, as matrix functions of `Z = h M K`.
fn biased<const D: usize>(
    context: &Context<'_>,
    id: &str,
    network: &Network<D>,
    (name, mobility): (&str, &Mobility),
    exact: &DMatrix<f64>,
) -> Result<Vec<Claim>, CaseError> {
    let (l, k) = (network.factor(mobility)?, network.stiffness());
    let n = network.n_unknowns();
    let one = DMatrix::<f64>::identity(n, n);
    let mut claims = Vec::new();
    for scheme in [Scheme::EulerMaruyama, Scheme::Heun] {
        let z = 1.0;
        let dt = z / rate(network, &overdamped(mobility, 0.0, scheme))?;
        let law = law_of(network, mobility, scheme, z)?;
        let zk = dt * &l * l.transpose() * &k;
        // kT f(Z) K^-1 with f of the scheme.
        let factor = match scheme {
            Scheme::Heun => {
                (2.0 * &one - &zk)
                    * (2.0 * &one - &zk + 0.5 * &zk * &zk).try_inverse().ok_or("singular")?
            }
            _ => (&one - 0.5 * &zk).try_inverse().ok_or("singular")?,
        };
        let lines = Lines { context, id, method: format!("{}, {name}, z = 1", scheme.name()) };
        let key = scheme.name().to_lowercase();
        let reason = "the scheme's own bias, variance of a mode over kT/lambda: 1/(1 - z/2) of Euler, (2 - z)/(2 - z + z^2/2) of Heun; roundoff";
        claims.push(lines.bounded(
            (
                &format!("{key}/bias"),
                "largest entry of cov - kT f(h M K) K^-1 over its largest",
                "",
            ),
            distance(&law.covariance, &(factor * exact)),
            1e-11,
            reason,
        ));
        let stiffest = scheme.variance_factor(z);
        let (from, to) = if stiffest > 1.0 { (1.05, 2.0) } else { (0.6, 0.99) };
        claims.push(lines.measured(
            (&format!("{key}/energy"), "mean energy over kT dof/2", ""),
            foster(network, &law.covariance) / (TEMPERATURE * n as f64),
            (from, to),
            "between 1 and the bias of the stiffest mode, 2 for Euler and 2/3 for Heun",
        ));
    }
    Ok(claims)
}

/// BAOAB on displacements and velocities.
fn inertial(context: &Context<'_>, network: &Network<1>) -> Result<Vec<Claim>, CaseError> {
    let exact = TEMPERATURE * network.stiffness().try_inverse().ok_or("a singular network")?;
    let mut claims = Vec::new();
    for (friction, part) in [(0.3, 0.5), (3.0, 0.9)] {
        let covariance = covariance_of_baoab(network, friction, 2.0 * part)?;
        let lines = Lines {
            context,
            id: "chain10/baoab",
            method: format!("BAOAB, gamma = {friction}, omega h = {}", 2.0 * part),
        };
        claims.push(lines.bounded(
            (&format!("gamma{friction}/covariance"), "largest entry of cov(u) - kT K^-1 over its largest", ""),
            distance(&covariance, &exact),
            1e-11,
            "exact in displacements for linear forces at any stable step; roundoff over more steps than overdamped",
        ));
    }
    Ok(claims)
}

/// The first code of the note's authors had `M` in the noise alone.
fn noise_alone(context: &Context<'_>, network: &Network<2>) -> Result<Vec<Claim>, CaseError> {
    let k = network.stiffness();
    let exact = TEMPERATURE * k.clone().try_inverse().ok_or("a singular network")?;
    let mobility = &mobilities(network)?[1].1;
    let l = network.factor(mobility)?;
    let n = network.n_unknowns();
    let one = DMatrix::<f64>::identity(n, n);
    // du = -K u dt + sqrt(2 kT) L dB by theta = 1/2, whose stationary law is that of the equation.
    let dt = 0.1;
    let half = (&one + 0.5 * dt * &k).try_inverse().ok_or("singular")?;
    let noise = (2.0 * TEMPERATURE * dt).sqrt() * &half * &l;
    let covariance = stationary(&(&half * (&one - 0.5 * dt * &k)), &(&noise * noise.transpose()));
    // The nugget puts the diagonal of M above one; the trace is what energy sees.
    let trace = (&l * l.transpose()).trace() / n as f64;
    let lines =
        Lines { context, id: "noise-alone", method: "M in the noise alone, unit diagonal".into() };
    let energy = foster(network, &covariance) / (TEMPERATURE * n as f64 * trace);
    Ok(vec![
        lines.relative(
            ("energy", "mean energy over kT tr M/2", ""),
            energy,
            1.0,
            1e-10,
            "the energy sees the trace of M alone: equipartition does not tell a wrong noise; roundoff",
        ),
        lines.measured(
            ("covariance", "largest entry of cov - kT K^-1 over its largest", ""),
            distance(&(covariance / trace), &exact),
            (0.3, 20.0),
            "the covariance does tell it; what is known to be wrong is held to be far off",
        ),
    ])
}

/// All entries of a sampled covariance in one number.
fn sampled(context: &Context<'_>, network: &Network<1>) -> Result<Vec<Claim>, CaseError> {
    let n = network.n_unknowns();
    let stiffness = network.stiffness();
    let root = stiffness.clone().cholesky().ok_or("not positive definite")?.l();
    let (groups, z) = (if context.profile == Profile::Quick { 60 } else { 400 }, 1.8);
    let mut claims = Vec::new();
    for (name, mobility) in
        [mobilities(network)?.swap_remove(0), mobilities(network)?.swap_remove(1)]
    {
        let dynamics = overdamped(&mobility, TEMPERATURE, Scheme::LeimkuhlerMatthews);
        let dt = z / rate(network, &dynamics)?;
        let mut sum = DMatrix::<f64>::zeros(n, n);
        let count = groups * 16;
        for group in 0..groups {
            let ids = std::array::from_fn(|lane| group * 16 + lane as u64);
            let config = SimulationConfig {
                dynamics: dynamics.clone(),
                dt,
                breaking: Breaking::AtEnds,
                confinement: 0.0,
                noise: Noise::new(5),
            };
            let body = lanes::<1, 16>(network, 1e6)?;
            let mut run = Simulation::new(body, network.loading()?, config, ids)?;
            // The slowest mode has forgotten its start to 1e-4 after 600 steps.
            for _ in 0..900 {
                let _ = run.step()?;
            }
            for lane in 0..16 {
                let u = run.displacements(lane);
                let u: Vec<f64> =
                    network.unknowns().into_iter().map(|(node, k)| u[node][k]).collect();
                // Whitened: its covariance would be one.
                let white = root.transpose() * DMatrix::from_vec(n, 1, u) / TEMPERATURE.sqrt();
                sum += &white * white.transpose();
            }
        }
        let error = sum / count as f64 - DMatrix::<f64>::identity(n, n);
        let chi_square = 0.5 * count as f64 * error.norm_squared();
        let freedom = (n * (n + 1) / 2) as f64;
        claims.push(Claim::judge(
            context.subject(
                &format!("chain10/sampled/{name}"),
                "chi-square of all entries of the covariance",
                "",
                &format!("Leimkuhler-Matthews, {name}, z = {z}, {count} realisations"),
            ),
            ErrorKind::Absolute,
            Measured::sampled(chi_square, (2.0 * freedom).sqrt()),
            Reference::exact(freedom),
            Criterion::MonteCarlo {
                bias_bound: 0.5,
                reason: "n/2 |W - 1|^2 of the whitened covariance W has the law of chi-square with n (n + 1)/2 degrees of freedom; what is left of the start",
            },
        ));
    }
    Ok(claims)
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let chain = Network::chain(10)?;
    let lines = Lines { context, id: "chain10", method: "springs of stiffness one".into() };
    let minimum = DMatrix::from_fn(10, 10, |i, j| (i.min(j) + 1) as f64);
    let inverse = chain.stiffness().try_inverse().ok_or("a singular chain")?;
    let mut claims = vec![lines.bounded(
        ("inverse", "largest entry of K^-1 - min(i, j) over its largest", ""),
        distance(&inverse, &minimum),
        1e-13,
        "chain10.json: the closed form of a chain; roundoff",
    )];
    claims.extend(exact_laws(context, "chain10", &chain)?);
    let square = Network::square(4, 2)?;
    claims.extend(exact_laws(context, "square", &square)?);
    claims.extend(inertial(context, &chain)?);
    claims.extend(noise_alone(context, &square)?);
    claims.extend(sampled(context, &chain)?);
    Ok(claims)
}
