//! The stationary law of each scheme on small networks: exactly, and sampled.

use nalgebra::{DMatrix, SymmetricEigen};
use peridyn_sde::{
    Breaking, CorrelatedMobility, Error, Mobility, Scheme, Simulation, SimulationConfig,
};
use random_fields::{Correlation, CorrelationFunction};
use reference_problems::peridyn::network::{Network, distance, foster, lanes, rate, stationary};
use reference_problems::peridyn::stationary::{
    TEMPERATURE, covariance_of_baoab, law_of, overdamped,
};
use sde_integrators::Noise;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/equilibrium",
    title: "Covariance of small networks with linear bonds against kT K^-1: the maps of the schemes, and samples",
    source: "discrete Lyapunov equation of each scheme; kT min(i, j) of a chain (chain10.json); Leimkuhler and Matthews 2013; Foster 1961",
    cost: Profile::Quick,
    run: Together(run),
};

fn correlation(function: CorrelationFunction) -> Correlation {
    Correlation { function, length: 1.3 }
}

/// Identity and two that couple nodes.
fn mobilities<const D: usize>(
    network: &Network<D>,
) -> Result<Vec<(&'static str, Mobility)>, Error> {
    let (x, free) = (network.nodes.positions(), &network.free[..]);
    let correlated = CorrelatedMobility {
        correlation: correlation(CorrelationFunction::Gaussian),
        mobility: 1.0,
        nugget: 0.1,
    };
    Ok(vec![
        ("identity", Mobility::identity(free, 1.0)?),
        ("dense", Mobility::dense(x, free, &correlated)?),
        ("low rank", Mobility::low_rank(x, free, &correlated, 1e-3)?),
    ])
}

/// Whose stationary covariance is exact for linear forces, and what an error of it and of the first step may be.
const EXACT: [(Scheme, &str, f64, f64, &str); 2] = [
    (
        Scheme::LeimkuhlerMatthews,
        "leimkuhler-matthews",
        3e-13,
        2e-15,
        "roundoff: exact for linear forces, for any positive definite M and any stable step; 2e-16 times the condition of the matrices, up to 1e3; of a first step, a sum of up to 24 terms",
    ),
    (
        Scheme::Theta(0.5),
        "theta-0.5",
        3e-10,
        4e-11,
        "exact for linear forces, for any positive definite M; the linear system of a step is solved to 1e-11, and the covariance is off by some times that",
    ),
];

/// Those with a bias that is known.
const BIASED: [(Scheme, &str); 2] =
    [(Scheme::EulerMaruyama, "euler-maruyama"), (Scheme::Heun, "heun")];

/// The worst errors with a mobility, over networks and steps, by scheme.
#[derive(Default)]
struct Laws {
    covariance: [Worst; 2],
    kick: [Worst; 2],
    bias: [Worst; 2],
}

/// Adds a network.
fn see<const D: usize>(
    name: &str,
    network: &Network<D>,
    laws: &mut [(&'static str, Laws)],
) -> CaseResult<()> {
    let k = network.stiffness();
    let exact = TEMPERATURE * k.clone().try_inverse().ok_or("a singular network")?;
    for ((_, mobility), (_, laws)) in mobilities(network)?.iter().zip(laws) {
        for z in [0.1, 1.0, 1.9] {
            let place = format!("{name}, z = {z}");
            for (at, (scheme, ..)) in EXACT.into_iter().enumerate() {
                let law = law_of(network, mobility, scheme, z)?;
                laws.covariance[at].take(distance(&law.covariance, &exact), &place);
                laws.kick[at].take(law.kick, &place);
            }
        }
        for (at, (scheme, _)) in BIASED.into_iter().enumerate() {
            laws.bias[at].take(biased(network, mobility, scheme, &exact)?, name);
        }
    }
    Ok(())
}

/// How far the covariance of Euler or Heun at `z = 1` is from its own bias, a matrix function of `Z = h M K`.
fn biased<const D: usize>(
    network: &Network<D>,
    mobility: &Mobility,
    scheme: Scheme,
    exact: &DMatrix<f64>,
) -> CaseResult<f64> {
    let (l, k) = (network.factor(mobility)?, network.stiffness());
    let n = network.n_unknowns();
    let one = DMatrix::<f64>::identity(n, n);
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
    Ok(distance(&law.covariance, &(factor * exact)))
}

fn claims_of(context: &Context<'_>, name: &str, laws: &Laws) -> Vec<Claim> {
    let over = format!("{name}, chain of 10 and square of 16 nodes");
    let claim = |id: &str, quantity: &str, worst: &Worst, of: &str, tolerance, reason: &str| {
        let method = worst.method(&format!("{of}, {over}"));
        let lines = context.lines("", method);
        let subject = lines.of(format!("{}/{id}", name.replace(' ', "-")), quantity);
        subject.bounded(worst.value(), tolerance).because(reason)
    };
    let mut claims = Vec::new();
    for (at, (scheme, key, covariance, kick, reason)) in EXACT.into_iter().enumerate() {
        let of = format!("{}, z = 0.1, 1 and 1.9", scheme.name());
        claims.push(claim(
            &format!("{key}/covariance"),
            "largest entry of cov - kT K^-1 over its largest",
            &laws.covariance[at],
            &of,
            covariance,
            reason,
        ));
        claims.push(claim(
            &format!("{key}/kick"),
            "the first step from rest against N z, with the same factor L as in M",
            &laws.kick[at],
            &of,
            kick,
            reason,
        ));
    }
    for (at, (scheme, key)) in BIASED.into_iter().enumerate() {
        claims.push(claim(
            &format!("{key}/bias"),
            "largest entry of cov - kT f(h M K) K^-1 over its largest",
            &laws.bias[at],
            &format!("{}, z = 1", scheme.name()),
            3e-14,
            "roundoff: the scheme's own bias, variance of a mode over kT/lambda: 1/(1 - z/2) of Euler, (2 - z)/(2 - z + z^2/2) of Heun; 2e-16 times the condition of 2 - Z",
        ));
    }
    claims
}

/// BAOAB on displacements and velocities.
fn inertial(context: &Context<'_>, network: &Network<1>) -> CaseResult<Claim> {
    let exact = TEMPERATURE * network.stiffness().try_inverse().ok_or("a singular network")?;
    let mut worst = Worst::default();
    for (friction, part) in [(0.3, 0.5), (3.0, 0.9)] {
        let covariance = covariance_of_baoab(network, friction, 2.0 * part)?;
        let place = format!("gamma = {friction}, omega h = {}", 2.0 * part);
        worst.take(distance(&covariance, &exact), &place);
    }
    let lines = context.lines("chain10/baoab", worst.method("BAOAB, two frictions"));
    let reason = "roundoff: exact in displacements for linear forces at any stable step; 2e-16 times the condition of the chain, 200, over more steps than overdamped";
    let subject = lines.of("covariance", "largest entry of cov(u) - kT K^-1 over its largest");
    Ok(subject.bounded(worst.value(), 1e-13).because(reason))
}

/// `epsilon` of the confining energy takes `lambda/(lambda + epsilon)` of the variance of a mode, and holds a node without bonds
/// to `kT/epsilon`.
fn confined(context: &Context<'_>) -> CaseResult<[Claim; 2]> {
    let mut chain = Network::chain(11)?;
    // The last node is loose: its only bond is cut.
    chain.cut = vec![chain.bonds.len() - 1];
    chain.confinement = 0.05;
    let mobility = Mobility::identity(&chain.free, 1.0)?;
    let law = law_of(&chain, &mobility, Scheme::LeimkuhlerMatthews, 1.0)?;
    let modes = SymmetricEigen::new(chain.stiffness());
    let (mut bonded, mut loose) = (Worst::default(), f64::NAN);
    for (lambda, mode) in modes.eigenvalues.iter().zip(modes.eigenvectors.column_iter()) {
        let variance = (mode.transpose() * &law.covariance * mode)[0];
        if *lambda < 1e-9 {
            loose = variance * chain.confinement / TEMPERATURE;
        } else {
            let share = variance * lambda / TEMPERATURE;
            let exact = lambda / (lambda + chain.confinement);
            bonded
                .take(share / exact - 1.0, &format!("lambda = {lambda:.3}, a share of {exact:.3}"));
        }
    }
    let reason = "roundoff: linear forces, exact by Leimkuhler and Matthews' method; 2e-16 times the condition, 200";
    let method =
        "Leimkuhler-Matthews, z = 1, chain of 10 bonded nodes and a loose one, epsilon = 0.05";
    let lines = context.lines("confinement", bonded.method(method));
    Ok([
        lines
            .of(
                "modes",
                "largest relative error of the variance of a mode against kT/(lambda + epsilon)",
            )
            .bounded(bonded.value(), 1e-13)
            .because(reason),
        context
            .lines("confinement", method)
            .of("loose-node", "variance of the node without bonds, over kT/epsilon")
            .relative(loose, 1.0)
            .within(1e-13)
            .because(reason),
    ])
}

/// The first code of the note's authors had `M` in the noise alone.
fn noise_alone(context: &Context<'_>, network: &Network<2>) -> CaseResult {
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
    let lines = context.lines("noise-alone", "M in the noise alone, unit diagonal");
    let energy = foster(network, &covariance) / (TEMPERATURE * n as f64 * trace);
    // S of K S + S K = 2 kT M, by the modes of K.
    let modes = SymmetricEigen::new(k);
    let v = &modes.eigenvectors;
    let mobility = v.transpose() * &l * l.transpose() * v;
    let by_modes = DMatrix::from_fn(n, n, |i, j| {
        2.0 * TEMPERATURE * mobility[(i, j)] / (modes.eigenvalues[i] + modes.eigenvalues[j])
    });
    let expected = distance(&(v * by_modes * v.transpose() / trace), &exact);
    Ok(vec![
        lines
            .of("energy", "mean energy over kT tr M/2")
            .relative(energy, 1.0)
            .within(1e-13)
            .because("roundoff: the energy sees the trace of M alone: equipartition does not detect a wrong noise; 2e-16 times the condition of K"),
        lines
            .of(
                "covariance",
                "largest entry of cov - kT K^-1 over its largest, 1.87 where it should be zero",
            )
            .relative(distance(&(covariance / trace), &exact), expected)
            .within(1e-12)
            .because("roundoff: the covariance does detect it: it is that of K S + S K = 2 kT M, far from kT K^-1; 2e-16 times the condition of K, by another path"),
    ])
}

/// All entries of a sampled covariance in one number.
fn sampled(context: &Context<'_>, network: &Network<1>) -> CaseResult {
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
        let quantity = "chi-square of all entries of the covariance";
        let method = format!("Leimkuhler-Matthews, {name}, z = {z}, {count} realisations");
        let value = Measured::sampled(chi_square, (2.0 * freedom).sqrt());
        let reason = "n/2 |W - 1|^2 of the whitened covariance W has the law of chi-square with n (n + 1)/2 degrees of freedom; what is left of the start";
        let subject = context.subject(format!("chain10/sampled/{name}"), quantity, method);
        claims.push(subject.absolute(value, freedom).monte_carlo(0.5).because(reason));
    }
    Ok(claims)
}

fn run(context: &Context<'_>) -> CaseResult {
    let chain = Network::chain(10)?;
    let lines = context.lines("chain10", "springs of stiffness one");
    let minimum = DMatrix::from_fn(10, 10, |i, j| (i.min(j) + 1) as f64);
    let inverse = chain.stiffness().try_inverse().ok_or("a singular chain")?;
    let mut claims = vec![
        lines
            .of("inverse", "largest entry of K^-1 - min(i, j) over its largest")
            .bounded(distance(&inverse, &minimum), 4e-14)
            .because("roundoff: chain10.json, the closed form of a chain; 2e-16 times its condition, 200"),
    ];
    let square = Network::square(4, 2)?;
    let mut laws: Vec<(&str, Laws)> =
        mobilities(&chain)?.into_iter().map(|(name, _)| (name, Laws::default())).collect();
    see("chain", &chain, &mut laws)?;
    see("square", &square, &mut laws)?;
    for (name, laws) in &laws {
        claims.extend(claims_of(context, name, laws));
    }
    claims.push(inertial(context, &chain)?);
    claims.extend(confined(context)?);
    claims.extend(noise_alone(context, &square)?);
    claims.extend(sampled(context, &chain)?);
    Ok(claims)
}
