//! Measured strengths of fibres and bars: parameters from one test, prediction of another with intervals.

use peridyn_sde::{
    BondConfig, BondList, Bonds, Breaking, Condition, Dynamics, Horizon, Loading, Mobility, Nodes,
    Program, Scheme, Simulation, SimulationConfig, Strain, StrengthElement, WeibullByVolume,
    WeibullStrength,
};
use sde_integrators::{Noise, Purpose};
use serde::Deserialize;

use super::weibull_posterior::WeibullPosterior;
use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/weibull-strength",
    title: "Measured strengths of carbon and glass fibres and of silicon nitride bars: parameters from one test, 90 % intervals of another",
    source: "Bader & Priest 1982; Smith & Naylor 1987; Jahanmir 1996, all as transcribed",
    cost: Profile::Quick,
    run: Together(run),
};

const SEED: u64 = 61;
/// Bonds along a specimen, on three meshes.
const LINKS: [u32; 3] = [10, 40, 160];
/// Specimens drawn on each.
const SPECIMENS: u64 = 4000;
/// Repetitions of a test, for its standard error.
const REPETITIONS: u64 = 1000;
/// Halves of the glass fibres.
const HALVES: u64 = 20;
/// Strain steps to the scale of the strength.
const STEPS: u32 = 400;

#[derive(Deserialize)]
struct Published {
    carbon_fibre: CarbonFibre,
    glass_fibre: GlassFibre,
    silicon_nitride: SiliconNitride,
}

#[derive(Deserialize)]
struct CarbonFibre {
    gauge_10mm: Vec<f64>,
    gauge_20mm: Vec<f64>,
    maximum_likelihood: MaximumLikelihood,
}

#[derive(Deserialize)]
struct MaximumLikelihood {
    gauge_10mm: Fit,
    gauge_20mm: Fit,
}

#[derive(Deserialize)]
struct Fit {
    modulus: f64,
    scale: f64,
}

#[derive(Deserialize)]
struct GlassFibre {
    gauge_15mm: Vec<f64>,
}

#[derive(Deserialize)]
struct SiliconNitride {
    by_laboratory: Vec<Vec<f64>>,
}

/// A specimen: a bar of one shell, so that each bond is a cross-section, of volume one.
struct Bar {
    nodes: Nodes<1>,
    bonds: Bonds,
}

impl Bar {
    fn new(links: u32) -> CaseResult<Self> {
        let spacing = f64::from(links + 1).recip();
        let bar = Condition::Bar { area: 1.0 };
        let nodes = Nodes::lattice(spacing, ([0.0], [1.0]), bar, |_| true)?;
        let config = BondConfig::uncorrected(Horizon::of_shells(1, spacing)?, 1.0);
        let bonds = Bonds::new(&nodes, &config)?;
        Ok(Self { nodes, bonds })
    }

    /// Strengths of its bonds. The modulus of a fibre cancels: a stress is written for its stretch.
    fn strength(&self, (scale, modulus): (f64, f64), ratio: f64) -> CaseResult<WeibullStrength> {
        let element = StrengthElement::Bond;
        let law = WeibullByVolume { scale, modulus, reference_volume: ratio.recip(), element };
        Ok(WeibullStrength::new(&self.nodes, &self.bonds, law, 0)?)
    }

    /// The stretches at which eight bars break, in steps of `step`.
    fn pull(&self, strengths: &[Vec<f64>], step: f64, n_steps: u32) -> CaseResult<[f64; 8]> {
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        let n = nodes.positions().len();
        let mut free = vec![true; n];
        (free[0], free[n - 1]) = (false, false);
        let dt = 0.1 / (bonds.all()[0].stiffness * f64::from(u32::try_from(n)?));
        let program = Program::Linear { rate: step / dt };
        let loading = Loading::new(n).stretch(&nodes, &[0, n - 1], [true], [[1.0]], program)?;
        let mobility = Mobility::identity(&free, 1.0)?;
        let config = SimulationConfig {
            dynamics: Dynamics::Overdamped {
                mobility,
                temperature: 0.0,
                scheme: Scheme::EulerMaruyama,
            },
            dt,
            breaking: Breaking::AtEnds,
            confinement: 0.0,
            noise: Noise::new(SEED),
        };
        let body = BondList::<f64, 1, 8>::new(nodes, bonds, Strain::Finite, &strengths[0])?;
        let body = body.with_strengths(strengths)?;
        let mut run = Simulation::new(body, loading, config, std::array::from_fn(|k| k as u64))?;
        let mut broken = [f64::NAN; 8];
        for _ in 0..n_steps {
            let report = run.step()?;
            for event in report.broken {
                for (lane, at) in broken.iter_mut().enumerate() {
                    if event.lanes & 1 << lane != 0 && at.is_nan() {
                        // Forces of a step are those where it began.
                        *at = (report.step - 1) as f64 * step;
                    }
                }
            }
        }
        Ok(broken)
    }
}

/// What a test says of another.
struct Prediction<'a> {
    posterior: WeibullPosterior,
    measured: &'a [f64],
    /// Volume of the others over that of the bodies of the test.
    ratio: f64,
}

impl Prediction<'_> {
    /// The ends of the 90 % interval.
    fn interval(&self) -> [f64; 2] {
        [0.05, 0.95].map(|share| self.posterior.quantile(share, self.ratio))
    }

    /// The share of values inside it.
    fn inside(&self) -> f64 {
        share_inside(self.measured, self.interval())
    }

    /// The mean of the predicted probabilities to be weaker.
    fn mean_rank(&self, values: &[f64], ratio: f64) -> f64 {
        let ranks = values.iter().map(|&value| self.posterior.below(value, ratio));
        ranks.sum::<f64>() / values.len() as f64
    }

    /// Standard errors of the share inside and of the mean rank: over repetitions, each of parameters of its own.
    fn errors(&self) -> [f64; 2] {
        let sets = self.posterior.repetitions(REPETITIONS, self.measured.len(), self.ratio, SEED);
        let interval = self.interval();
        let shares: Vec<f64> = sets.iter().map(|set| share_inside(set, interval)).collect();
        let ranks: Vec<f64> =
            sets.iter().take(100).map(|set| self.mean_rank(set, self.ratio)).collect();
        [deviation(&shares), deviation(&ranks)]
    }
}

fn share_inside(values: &[f64], [low, high]: [f64; 2]) -> f64 {
    values.iter().filter(|&&value| low <= value && value <= high).count() as f64
        / values.len() as f64
}

fn deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

fn run(context: &Context<'_>) -> CaseResult {
    let text = include_str!("../../../reference/published/peridyn-sde/weibull_strength.json");
    let published: Published = serde_json::from_str(text)?;
    let CarbonFibre { gauge_10mm, gauge_20mm, maximum_likelihood } = &published.carbon_fibre;
    let mut claims = vec![pulled(context, gauge_10mm)?];
    let tests = [
        ("carbon-10-to-20", gauge_10mm, gauge_20mm, 2.0, &maximum_likelihood.gauge_10mm),
        ("carbon-20-to-10", gauge_20mm, gauge_10mm, 0.5, &maximum_likelihood.gauge_20mm),
    ];
    for (id, test, measured, ratio, fit) in tests {
        let prediction = Prediction { posterior: WeibullPosterior::new(test), measured, ratio };
        let method = format!(
            "parameters from {} fibres, posterior by quadrature; {} fibres of {ratio} times the length predicted",
            test.len(),
            measured.len()
        );
        let lines = context.lines(id, method);
        claims.extend(parameters(&lines, &prediction, fit));
        claims.extend(by_bonds(&lines, &prediction)?);
        claims.extend(against_measured(&lines, &prediction));
    }
    claims.push(glass(context, &published.glass_fibre.gauge_15mm));
    claims.extend(silicon_nitride(context, &published.silicon_nitride.by_laboratory));
    Ok(claims)
}

/// Bars loaded in tension step by step.
fn pulled(context: &Context<'_>, test: &[f64]) -> CaseResult<Claim> {
    let posterior = WeibullPosterior::new(test);
    let (bar, parameters) = (Bar::new(20)?, (1e-3, posterior.modulus().0));
    let strength = bar.strength(parameters, 1.0)?;
    let step = 1e-3 / f64::from(STEPS);
    let mut worst: f64 = 0.0;
    for group in 0..4 {
        let mut strengths = vec![vec![0.0; bar.bonds.len()]; 8];
        for (of, realisation) in strengths.iter_mut().zip(8 * group..) {
            strength.sample(&Noise::new(SEED), realisation, of)?;
        }
        let broken = bar.pull(&strengths, step, 2 * STEPS)?;
        for (of, at) in strengths.iter().zip(broken) {
            let weakest = of.iter().copied().fold(f64::INFINITY, f64::min);
            // The first multiple of the step at which the weakest bond is at its strength; NaN where none broke.
            let late = (at - weakest) / step;
            worst = if late.is_nan() { f64::INFINITY } else { worst.max((late - 0.5).abs()) };
        }
    }
    let method = "32 bars of 20 bonds, pulled by overdamped steps that follow the affine field";
    let lines = context.lines("pulled", method);
    let quantity = "largest distance of the strain at which a bar breaks from half a step above that of its weakest bond";
    let reason = "a bar in equilibrium has one stretch, so that it breaks in the step in which its weakest bond comes to its strength; roundoff and the square of the stretch";
    Ok(lines.of("strain", quantity).unit("steps").bounded(worst, 0.501).because(reason))
}

fn parameters(lines: &Lines<'_>, prediction: &Prediction<'_>, fit: &Fit) -> [Claim; 2] {
    let (modulus, scale) = (prediction.posterior.modulus(), prediction.posterior.scale());
    let of = |name: &str, quantity: &str, unit: &str, (mean, error): (f64, f64), exact: f64| {
        let reason = "the mean of a posterior of n values and the maximum of the likelihood differ by the order of 1/n, here 1.5 % and less";
        let subject = lines.of(name, quantity).unit(unit);
        subject.relative(Measured::sampled(mean, error), exact).within(0.03).because(reason)
    };
    [
        of("modulus", "posterior mean of Weibull's modulus", "", modulus, fit.modulus),
        of("scale", "posterior mean of Weibull's scale", "GPa", scale, fit.scale),
    ]
}

/// The predictive distribution of bars of bonds against that of the formula.
fn by_bonds(lines: &Lines<'_>, prediction: &Prediction<'_>) -> CaseResult {
    let interval = prediction.interval();
    let mut claims = Vec::new();
    for links in LINKS {
        let bar = Bar::new(links)?;
        let (mut below, mut above) = (0.0, 0.0);
        let mut strengths = vec![0.0; bar.bonds.len()];
        for specimen in 0..SPECIMENS {
            let mut stream = Noise::new(SEED).stream(Purpose::UnitCube, specimen);
            let parameters = prediction.posterior.draw(stream.next_uniform());
            let strength = bar.strength(parameters, prediction.ratio)?;
            strength.sample(&Noise::new(SEED), specimen, &mut strengths)?;
            let weakest = strengths.iter().copied().fold(f64::INFINITY, f64::min);
            below += f64::from(weakest < interval[0]);
            above += f64::from(weakest > interval[1]);
        }
        let n = SPECIMENS as f64;
        let error = (0.05 * 0.95 / n).sqrt();
        for (name, count) in [("below", below), ("above", above)] {
            let quantity = format!(
                "share of {SPECIMENS} predicted bars of {links} bonds {name} the interval of the formula"
            );
            let subject = lines.of(format!("n-{links}/{name}"), quantity);
            let compared = subject.absolute(Measured::sampled(count / n, error), 0.05);
            let reason = "the weakest bond has the law of the volume of the bar, on every mesh";
            claims.push(compared.monte_carlo(0.0).because(reason));
        }
    }
    Ok(claims)
}

fn against_measured(lines: &Lines<'_>, prediction: &Prediction<'_>) -> [Claim; 3] {
    let [of_share, of_rank] = prediction.errors();
    let rank = prediction.mean_rank(prediction.measured, prediction.ratio);
    let unscaled = prediction.mean_rank(prediction.measured, 1.0);
    [
        lines
            .of("coverage", "share of measured strengths inside the 90 % interval")
            .absolute(Measured::sampled(prediction.inside(), of_share), 0.9)
            .monte_carlo(0.0)
            .because("nine of ten; standard error over repetitions of both tests"),
        lines
            .of("rank", "mean predicted probability to be weaker than the measured strengths")
            .absolute(Measured::sampled(rank, of_rank), 0.5)
            .monte_carlo(0.0)
            .because("half, if the length acts by the weakest link; standard error over repetitions of both tests"),
        lines
            .of(
                "unscaled",
                "distance of that mean from one half without the scaling of length, in standard errors",
            )
            .absolute((unscaled - 0.5).abs() / of_rank, 5.0)
            .within(1.0)
            .because("statistics: no effect of the length is excluded at four standard errors or more"),
    ]
}

/// Halves of one test: whether two parameters describe it. There is no second length.
fn glass(context: &Context<'_>, all: &[f64]) -> Claim {
    let mut shares = Vec::new();
    for number in 0..HALVES {
        let mut stream = Noise::new(SEED).stream(Purpose::Bootstrap, number);
        let mut order: Vec<(u64, f64)> = all.iter().map(|&s| (stream.next_u64(), s)).collect();
        order.sort_unstable_by_key(|of| of.0);
        let values: Vec<f64> = order.into_iter().map(|of| of.1).collect();
        let (test, measured) = values.split_at(all.len() / 2);
        let posterior = WeibullPosterior::new(test);
        shares.push(Prediction { posterior, measured, ratio: 1.0 }.inside());
    }
    let method =
        format!("{HALVES} random halves of 63 fibres of one length; the other half predicted");
    let lines = context.lines("glass-halves", method);
    let share = shares.iter().sum::<f64>() / HALVES as f64;
    coverage(&lines, share, all.len())
}

/// A laboratory against the seven others: bars of one size.
fn silicon_nitride(context: &Context<'_>, laboratories: &[Vec<f64>]) -> [Claim; 2] {
    let mut shares = Vec::new();
    for (number, test) in laboratories.iter().enumerate() {
        let others = laboratories.iter().enumerate().filter(|(other, _)| *other != number);
        let measured: Vec<f64> = others.flat_map(|(_, of)| of.iter().copied()).collect();
        let posterior = WeibullPosterior::new(test);
        shares.push(Prediction { posterior, measured: &measured, ratio: 1.0 }.inside());
    }
    let method = "30 bars of each of eight laboratories, the other 210 predicted; one size and one way of bending";
    let lines = context.lines("silicon-nitride", method);
    let share = shares.iter().sum::<f64>() / shares.len() as f64;
    let n = laboratories.iter().map(Vec::len).sum();
    let least = shares.iter().copied().fold(1.0, f64::min);
    [
        coverage(&lines, share, n),
        lines
            .of("least", "share inside the interval of the laboratory whose interval holds the fewest")
            .measured(least, (0.7, 0.9))
            .because("laboratories differ by more than the scatter of 30 bars: the narrowest interval is too narrow for the others"),
    ]
}

fn coverage(lines: &Lines<'_>, share: f64, n: usize) -> Claim {
    let quantity =
        "share of measured strengths inside the 90 % interval, mean over the predictions";
    let value = Measured::sampled(share, (0.9 * 0.1 / n as f64).sqrt());
    let compared = lines.of("coverage", quantity).absolute(value, 0.9);
    compared.monte_carlo(0.0).because("nine of ten; binomial standard error of all specimens")
}
