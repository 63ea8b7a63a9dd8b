//! Nodes without bonds: their random walk, and the bias of a confinement.

use peridyn_sde::{Breaking, Dynamics, Mobility, Scheme, Simulation, SimulationConfig};
use result_figures::{Curve, CurvePoint, Curves, Drawing, Scale, Threshold, Words};
use sde_integrators::Noise;

use super::{modes, point};
use crate::context::{CaseError, Context, Profile};
use crate::draw::ChartKind;
use crate::problems::peridyn::background::temperature;
use crate::problems::peridyn::network::{Network, lanes};
use crate::problems::peridyn::stationary::{TEMPERATURE, law_of};
use crate::stability::axes::logarithmic;

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-loose",
    title: "nodes without bonds: their variance over time, with and without confinement, and the bias of the others",
    draw,
};

/// `epsilon` over the stiffness of a bond.
const CONFINEMENTS: [f64; 4] = [0.0, 1e-3, 1e-2, 1e-1];
const LANES: usize = 16;
const STEP: f64 = 0.1;
/// Strength of the bonds of the plate, and its ratio to the noise.
const STRENGTH: (f64, f64) = (0.01, 10.0);

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    Ok(vec![over_time(is_quick)?, bias(is_quick)?])
}

/// Mean square displacement of unbonded nodes at some times, with its standard error.
///
/// Spring constants and `kT` are one.
fn walk(n_nodes: usize, confinement: f64, times: &[f64]) -> Result<Vec<(f64, f64)>, CaseError> {
    let chain = Network::chain(n_nodes)?;
    let mobility = Mobility::identity(&chain.free, 1.0)?;
    let scheme = Scheme::EulerMaruyama;
    let config = SimulationConfig {
        dynamics: Dynamics::Overdamped { mobility, temperature: 1.0, scheme },
        dt: STEP,
        breaking: Breaking::AtEnds,
        confinement,
        noise: Noise::new(31),
    };
    let ids = std::array::from_fn(|lane| lane as u64);
    let body = lanes::<1, LANES>(&chain, 1e6)?;
    let mut run = Simulation::new(body, chain.loading()?, config, ids)?;
    run.cut(&(0..chain.bonds.len()).collect::<Vec<_>>())?;
    let mut found = Vec::new();
    for &time in times {
        while run.time() < time - 0.5 * STEP {
            let _ = run.step()?;
        }
        let squares = (0..LANES).flat_map(|lane| run.displacements(lane)).map(|[u]| u * u);
        let variance = squares.sum::<f64>() / (n_nodes * LANES) as f64;
        // Of a normal distribution.
        found.push((variance, variance * (2.0 / (n_nodes * LANES) as f64).sqrt()));
    }
    Ok(found)
}

/// `2 kT M t` of a free walk, `kT/epsilon (1 - exp(-2 epsilon M t))` of a confined one.
fn exact(confinement: f64, t: f64) -> f64 {
    if confinement > 0.0 { -(-2.0 * confinement * t).exp_m1() / confinement } else { 2.0 * t }
}

fn over_time(is_quick: bool) -> Result<Drawing, CaseError> {
    let (n_nodes, until) = if is_quick { (50, 40.0) } else { (100, 1000.0) };
    // Integer numbers of steps.
    let times: Vec<f64> = logarithmic(if is_quick { 5 } else { 10 }, 1.0, until)
        .into_iter()
        .map(|t| (t / STEP).round() * STEP)
        .collect();
    let (mut series, mut rows) = (Vec::new(), Vec::new());
    for (look, confinement) in CONFINEMENTS.into_iter().enumerate() {
        let found = walk(n_nodes, confinement, &times)?;
        let deviation = |(&t, (variance, error)): (&f64, &(f64, f64))| {
            ((variance - exact(confinement, t)) / error).abs()
        };
        let worst = times.iter().zip(&found).map(deviation).fold(0.0, f64::max);
        let (last, error) = found[found.len() - 1];
        rows.push(format!(
            "  epsilon {confinement:5}: at t = {until} {last:8.1} +- {error:.1}, exact {:8.1}; farthest of {} {worst:.1} standard errors",
            exact(confinement, until),
            times.len()
        ));
        let line = logarithmic(80, 1.0, until).into_iter().map(|t| (t, exact(confinement, t)));
        let name = format!("ε = {confinement} k");
        series.push(Curve::line(name, look, line));
        let at =
            |(&t, (variance, error)): (&f64, (f64, f64))| CurvePoint::sampled(t, variance, error);
        series.push(Curve::points("", look, times.iter().zip(found).map(at).collect()));
    }
    let chart = Curves {
        words: Words {
            title: "A node without bonds walks away without bound; confinement ends it at kT/ε".into(),
            subtitle: format!("{} nodes of which all bonds are cut, Euler-Maruyama, h = {STEP}", n_nodes * LANES),
            x_label: "time, in 1/(M k) of a bond".into(),
            y_label: "variance of a component, in kT/k of a bond".into(),
            caption: vec!["Lines: 2 kT M t without ε, kT/ε (1 - exp(-2 ε M t)) with it. Points: mean square over all nodes, with its standard error.".into()],
        },
        across: Scale::Log,
        upwards: Scale::Log,
        series,
        thresholds: Vec::new(),
    };
    Ok(Drawing { table: rows.join("\n"), ..Drawing::curves("peridyn-loose-variance", &chart)? })
}

/// Variance reduction of a mode by `epsilon`, against the displacement of an unbonded node.
fn bias(is_quick: bool) -> Result<Drawing, CaseError> {
    let mut plate = Network::square(8, 3)?;
    let modes = modes(plate.stiffness())?;
    let (Some(softest), Some(stiffest)) = (modes.first(), modes.last()) else {
        return Err("a plate without a mode".into());
    };
    let kt = temperature(&plate, STRENGTH.0, STRENGTH.1);
    let confinements = logarithmic(if is_quick { 3 } else { 9 }, 1e-5, 1.0);
    let scheme = Scheme::LeimkuhlerMatthews;
    let mobility = Mobility::identity(&plate.free, 1.0)?;
    let (mut points, mut rows) = ([Vec::new(), Vec::new()], Vec::new());
    for &relative in &confinements {
        plate.confinement = relative * softest.0;
        let covariance = law_of(&plate, &mobility, scheme, 1.0)?.covariance;
        let mut row = vec![format!("  epsilon {relative:8.1e} of the softest mode: bias")];
        for (points, (lambda, mode)) in points.iter_mut().zip([softest, stiffest]) {
            let ratio = (mode.transpose() * &covariance * mode)[0] * lambda / TEMPERATURE;
            row.push(format!("{:.2e}", 1.0 - ratio));
            points.push(point(relative, Ok(1.0 - ratio)));
        }
        let away = (kt / plate.confinement).sqrt();
        rows.push(format!("{}; a loose node {away:.1e} spacings", row.join(" ")));
    }
    let line = |lambda: f64| {
        let softest = softest.0;
        logarithmic(60, 1e-5, 1.0).into_iter().map(move |relative| {
            let epsilon = relative * softest;
            (relative, epsilon / (lambda + epsilon))
        })
    };
    let away = logarithmic(60, 1e-5, 1.0).into_iter();
    let away = away.map(|relative| (relative, (kt / (relative * softest.0)).sqrt()));
    let [of_softest, of_stiffest] = points;
    let series = vec![
        Curve::line("bias of the softest mode", 0, line(softest.0)),
        Curve::points("", 0, of_softest),
        Curve::line("bias of the stiffest mode", 1, line(stiffest.0)),
        Curve::points("", 1, of_stiffest),
        Curve::line("deviation of a loose node, in spacings", 2, away),
    ];
    let chart = Curves {
        words: Words {
            title: "Confinement of 1 % of the softest mode costs it 1 % and holds loose nodes to 0.1 spacings".into(),
            subtitle: format!("plate of 8 x 8 nodes, three shells, held along one edge; s₀ = {}, s₀/σ = {}", STRENGTH.0, STRENGTH.1),
            x_label: "ε over λ of the softest mode".into(),
            y_label: "part of the variance that is lost; spacings".into(),
            caption: vec!["Lines: ε/(λ + ε). Points: the stationary distribution of a Leimkuhler-Matthews step with ε, relative to that without. The softest mode falls with the size of the plate: what ε costs is to be looked at for each body.".into()],
        },
        across: Scale::Log,
        upwards: Scale::Log,
        series,
        thresholds: vec![Threshold::upwards("a hundredth", 0.01)],
    };
    Ok(Drawing { table: rows.join("\n"), ..Drawing::curves("peridyn-loose-bias", &chart)? })
}
