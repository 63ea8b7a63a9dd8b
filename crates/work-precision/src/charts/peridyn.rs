//! Error against cost for the schemes of peridyn-sde: stationary distribution, bond failure rate, crack paths.

use peridyn_sde::statistics::Bootstrap;
use peridyn_sde::{
    Breaking, Dynamics, Mobility, Precision, Real, Scheme, Simulation, SimulationConfig,
};
use rayon::ThreadPoolBuilder;
use result_figures::{Drawing, Measure, Measured, Method, RunOutcome, Words, WorkPrecision};
use scenes::machine::Machine;
use sde_integrators::Noise;

use super::cost::{LONG, cost_in_seconds, run, timed};
use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::peridyn::first_passage::rate as rate_of_breaking;
use reference_problems::peridyn::network::{Network, lanes_of, rate};
use reference_problems::peridyn::notched_plate::{Cause, NOTCH, NotchedPlate, three_shells};
use reference_problems::peridyn::one_bond::{BONDS, seen};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "peridyn",
    title: "schemes of peridyn-sde: error of the stationary distribution, of the bond failure rate and of crack paths against CPU time",
    draw,
};

/// Result of a run, and its cost (CPU seconds) with scatter.
struct Priced {
    found: Measured,
    seconds: f64,
    scatter: f64,
    label: String,
}

/// A run of a scheme at a step.
type Runs<'a> = dyn Fn(Scheme, f64) -> Result<Priced, CaseError> + Sync + 'a;

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    // One thread, so CPU seconds measure the work.
    let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
    let share = match context.profile {
        Profile::Quick => 0.1,
        Profile::Default => 1.0,
        Profile::Full => 8.0,
    };
    pool.install(|| {
        Ok(vec![stationary(context, share)?, breaking(context, share)?, paths(context, share)?])
    })
}

fn priced(
    label: String,
    run: impl FnMut() -> Result<Measured, CaseError>,
) -> Result<Priced, CaseError> {
    let (found, seconds, scatter) = timed(LONG, run)?;
    Ok(Priced { found, seconds, scatter, label })
}

/// Series of a scheme over steps: relative errors of its results.
fn series(
    context: &Context<'_>,
    name: &str,
    scheme: Scheme,
    steps: &[f64],
    exact: f64,
    runs: &Runs<'_>,
) -> Result<Method, CaseError> {
    let mut points = Vec::new();
    for &z in steps {
        context.progress(&format!("{name}, z = {z}"));
        let Priced { found, seconds, scatter, label } = runs(scheme, z)?;
        let outcome = RunOutcome::Error {
            value: (found.value / exact - 1.0).abs(),
            standard_error: found.standard_error.map(|error| error / exact),
        };
        points.push(run((seconds, scatter), outcome, Some(label)));
    }
    Ok(Method { name: name.into(), runs: points })
}

fn drawing(
    name: &str,
    (title, subtitle, y_label): (&str, String, &str),
    mut caption: Vec<String>,
    (series, reference_error): (Vec<Method>, f64),
) -> Result<Drawing, CaseError> {
    caption.push(
        "Across: median CPU time of three runs, the bar half their range (one run beyond 3 s)."
            .into(),
    );
    caption.push(Machine::read().caption());
    let words = Words {
        title: title.into(),
        subtitle,
        x_label: "CPU time (s)".into(),
        y_label: y_label.into(),
        caption,
    };
    let reading = cost_in_seconds(Measure::Relative, reference_error);
    Ok(Drawing::work_precision(name, &WorkPrecision { words, reading, series })?)
}

/// Mean energy of a network over `kT/2` per unknown, over the same time for every scheme and step.
fn energy<T: Real, const L: usize>(
    network: &Network<2>,
    dynamics: &Dynamics,
    z: f64,
    time: f64,
) -> Result<Measured, CaseError> {
    let step = z / rate(network, dynamics)?;
    let config = SimulationConfig {
        dynamics: dynamics.clone(),
        dt: step,
        breaking: Breaking::AtEnds,
        confinement: 0.0,
        noise: Noise::new(31),
    };
    let ids = std::array::from_fn(|lane| lane as u64);
    let body = lanes_of::<T, 2, L>(network, 1e6)?;
    let mut run = Simulation::new(body, network.loading()?, config, ids)?;
    let (settled, end) = (0.2 * time, time);
    let mut sums = [0.0; L];
    let (mut count, mut next) = (0.0, settled);
    while run.time() < end {
        let _ = run.step()?;
        // Once in 1/lambda of the stiffest mode: a sample costs as much as a step in one lane.
        if run.time() >= next {
            next += step / z * 4.0;
            count += 1.0;
            for (lane, sum) in sums.iter_mut().enumerate() {
                *sum += run.energy(lane);
            }
        }
    }
    let half = 0.5 * dynamics.temperature() * network.n_unknowns() as f64;
    let of_lanes = sums.map(|sum| sum / count / half);
    let mean = of_lanes.iter().sum::<f64>() / L as f64;
    let square = of_lanes.iter().map(|lane| (lane - mean).powi(2)).sum::<f64>();
    Ok(Measured::sampled(mean, (square / (L * (L - 1)) as f64).sqrt()))
}

fn stationary(context: &Context<'_>, share: f64) -> Result<Drawing, CaseError> {
    let network = Network::square(8, 3)?;
    let mobility = Mobility::identity(&network.free, 1.0)?;
    let overdamped =
        |scheme| Dynamics::Overdamped { mobility: mobility.clone(), temperature: 1e-6, scheme };
    // In units of 1/lambda of the stiffest mode.
    let time = 8000.0 * share / rate(&network, &overdamped(Scheme::EulerMaruyama))?;
    let of = |z: f64| format!("z = {z}");
    let in_f64 =
        |scheme, z| priced(of(z), || energy::<f64, 8>(&network, &overdamped(scheme), z, time));
    let in_f32 =
        |scheme, z| priced(of(z), || energy::<f32, 16>(&network, &overdamped(scheme), z, time));
    let (coarse, fine) = ([1.6, 0.8, 0.4], [1.6, 0.8, 0.4, 0.2, 0.1, 0.05]);
    let line = |name: &str, scheme, steps: &[f64], runs: &Runs<'_>| {
        series(context, name, scheme, steps, 1.0, runs)
    };
    let all = vec![
        line("Euler-Maruyama, 8 lanes f64", Scheme::EulerMaruyama, &fine, &in_f64)?,
        line("Euler-Maruyama, 16 lanes f32", Scheme::EulerMaruyama, &fine, &in_f32)?,
        line("Heun, 8 lanes f64", Scheme::Heun, &fine[..5], &in_f64)?,
        line("Leimkuhler-Matthews, 8 lanes f64", Scheme::LeimkuhlerMatthews, &coarse, &in_f64)?,
        line("Leimkuhler-Matthews, 16 lanes f32", Scheme::LeimkuhlerMatthews, &coarse, &in_f32)?,
        line("theta 1/2, 8 lanes f64", Scheme::Theta(0.5), &[12.8, 3.2, 0.8], &in_f64)?,
    ];
    let caption = vec![
        format!("The same time for all, {:.0}/lambda of the stiffest mode. Bars: one standard error over the lanes.", 8000.0 * share),
        "Euler and Heun are biased, by 1/(1 - z/2) and (2 - z)/(2 - z + z^2/2) in a mode; the others err by sampling alone.".into(),
    ];
    let subtitle = format!(
        "plate of 8 x 8 nodes, one edge held, {} linear bonds: energy over kT/2 for each unknown",
        network.bonds.len()
    );
    drawing(
        "peridyn-stationary",
        (
            "Error of the stationary distribution against cost",
            subtitle,
            "relative error of the mean energy",
        ),
        caption,
        (all, 0.0),
    )
}

fn breaking(context: &Context<'_>, share: f64) -> Result<Drawing, CaseError> {
    let (ratio, times) = (3.0, 400.0 * share);
    let of = |z: f64| format!("z = {z}");
    let runs = |breaking: Breaking| {
        move |scheme: Scheme, z: f64| {
            priced(of(z), || seen::<f64, 8>(scheme, breaking, (ratio, z, times)))
        }
    };
    let in_f32 = |scheme: Scheme, z: f64| {
        priced(of(z), || seen::<f32, 16>(scheme, Breaking::Bridge, (ratio, z, times)))
    };
    let (bridge, ends) = (runs(Breaking::Bridge), runs(Breaking::AtEnds));
    let steps = [0.4, 0.2, 0.1, 0.05];
    let exact = rate_of_breaking(ratio);
    let line =
        |name: &str, scheme, runs: &Runs<'_>| series(context, name, scheme, &steps, exact, runs);
    let all = vec![
        line("Euler-Maruyama, ends of steps", Scheme::EulerMaruyama, &ends)?,
        line("Leimkuhler-Matthews, ends of steps", Scheme::LeimkuhlerMatthews, &ends)?,
        line("Heun, ends of steps", Scheme::Heun, &ends)?,
        line("Euler-Maruyama, bridge", Scheme::EulerMaruyama, &bridge)?,
        line("Heun, bridge", Scheme::Heun, &bridge)?,
        line("Heun, bridge, 16 lanes f32", Scheme::Heun, &in_f32)?,
        line("theta 1/2, bridge", Scheme::Theta(0.5), &bridge)?,
    ];
    let caption = vec![
        format!("{BONDS} bonds in 8 lanes of f64 (16 of f32) over {times:.0} relaxation times. Bars: one standard error."),
        "Reference: the lowest eigenvalue of the killed process. Where a bar reaches below the picture, the error is that of sampling.".into(),
    ];
    let subtitle =
        "a bond as an Ornstein-Uhlenbeck path, strength three deviations: its failure rate".into();
    drawing(
        "peridyn-breaking",
        ("Error of the bond failure rate against cost", subtitle, "relative error of the rate"),
        caption,
        (all, 0.0),
    )
}

fn paths(context: &Context<'_>, share: f64) -> Result<Drawing, CaseError> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of paths")]
    let realisations = ((8.0 * share).round() as u64).max(2) * 16;
    let plate = |scheme, z| NotchedPlate {
        rows: 32,
        horizon: three_shells(32),
        cause: Cause::WhiteNoise { ratio: 10.0, scheme, z },
        rotation: 0.0,
        tip: NOTCH,
    };
    let bootstrap = Bootstrap::new(Noise::new(41));
    let spread = |heights: &[f64]| -> Result<Measured, CaseError> {
        let interval = bootstrap.deviation(heights)?;
        Ok(Measured::sampled(interval.value, 0.25 * (interval.high - interval.low)))
    };
    let of = |z: f64| format!("z = {z}");
    let in_f32 = |scheme, z| {
        priced(of(z), || {
            spread(&plate(scheme, z).cracks(Precision::Single, realisations, 7)?.heights(0.65))
        })
    };
    let in_f64 = |scheme, z| {
        priced(of(z), || {
            spread(&plate(scheme, z).cracks(Precision::Double, realisations, 7)?.heights(0.65))
        })
    };
    context.progress("reference of paths");
    // Independent noise, with more realisations.
    let reference =
        plate(Scheme::LeimkuhlerMatthews, 0.45).cracks(Precision::Single, 4 * realisations, 8)?;
    let exact = spread(&reference.heights(0.65))?;
    let line = |name: &str, scheme, steps: &[f64], runs: &Runs<'_>| {
        series(context, name, scheme, steps, exact.value, runs)
    };
    let explicit = [1.8, 0.9, 0.45, 0.225];
    let all = vec![
        line("Euler-Maruyama, 16 lanes f32", Scheme::EulerMaruyama, &explicit, &in_f32)?,
        line("Euler-Maruyama, 8 lanes f64", Scheme::EulerMaruyama, &explicit[1..3], &in_f64)?,
        line(
            "Leimkuhler-Matthews, 16 lanes f32",
            Scheme::LeimkuhlerMatthews,
            &explicit[..3],
            &in_f32,
        )?,
        line("Heun, 16 lanes f32", Scheme::Heun, &explicit[..3], &in_f32)?,
        line("theta 1/2, 16 lanes f32", Scheme::Theta(0.5), &[3.6, 0.9], &in_f32)?,
    ];
    let subtitle =
        "cracks from an edge notch: standard deviation of their height at x = 0.65".into();
    drawing(
        "peridyn-paths",
        (
            "Error of the spread of crack paths against cost",
            subtitle,
            "relative error of the standard deviation",
        ),
        paths_caption(realisations, exact),
        (all, exact.standard_error.unwrap_or(0.0) / exact.value),
    )
}

fn paths_caption(realisations: u64, exact: Measured) -> Vec<String> {
    vec![
        format!(
            "{realisations} paths each, plate of 32 rows, white noise with s0/sigma = 10. Bars: one standard error, a quarter of the bootstrap interval."
        ),
        format!(
            "Reference: Leimkuhler-Matthews, z = 0.45, {} other paths: {:.4} ± {:.4} widths. Errors below the bars are not significant.",
            4 * realisations,
            exact.value,
            exact.standard_error.unwrap_or(f64::NAN)
        ),
    ]
}
