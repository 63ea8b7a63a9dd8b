//! A plate with two notches of which neither is preferred: noise chooses.

use peridyn_sde::{
    BondList, Bonds, Breaking, Dynamics, Fractured, Loading, Mobility, Nodes, Notch, PathConfig,
    Program, Scheme, Simulation, SimulationConfig, Strain, crack_path,
};
use reference_problems::peridyn::sample::mean;
use sde_integrators::Noise;

use crate::cases::prelude::*;
use crate::peridyn::plate::{Cracked, Plate};

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/two-notches",
    title: "A symmetric plate with two notches, pulled slowly: with noise each crack is as likely to win",
    source: "symmetry: exactly 1/2 with noise, equal cracks without",
    cost: Profile::Full,
    run: Together(run),
};

/// Of the mean strain to the critical stretch at the end.
const STRAIN: f64 = 0.8;
/// `z = h M lambda` of the stiffest mode.
const RELATIVE_STEP: f64 = 0.6;
/// The critical stretch over the standard deviation of a stretch by equipartition.
const RATIO: f64 = 10.0;
/// Lanes of a register.
const LANES: usize = 16;

/// A plate of unit size around the origin.
struct Symmetric {
    plate: Plate,
    nodes: Nodes<2>,
    bonds: Bonds,
    /// Three rows at each end.
    grips: Vec<usize>,
    free: Vec<bool>,
    /// Upper and lower.
    notches: [Notch; 2],
    cut: Vec<usize>,
    n_steps: u32,
}

impl Symmetric {
    fn new(rows: u32, n_steps: u32) -> CaseResult<Self> {
        let spacing = 1.0 / f64::from(rows);
        // Strains of 1e-3, small beside one.
        let plate = Plate {
            young_modulus: 1.0,
            density: 1.0,
            energy_release_rate: 3e-6 * spacing,
            thickness: 1.0,
            shells: 3,
            spacing,
        };
        let nodes = plate.rectangle([0.0, -0.5], [1.0, 0.5])?;
        let bonds = plate.bonds(&nodes)?;
        let x = nodes.positions();
        let gripped = |node: &usize| x[*node][1].abs() > 0.5 - 3.0 * spacing;
        let grips: Vec<usize> = (0..x.len()).filter(gripped).collect();
        let free = (0..x.len()).map(|node| !gripped(&node)).collect();
        // A height between two rows of 32 or 64.
        let notch = |height: f64| Notch { mouth: [-spacing, height], tip: [0.3, height] };
        let notches = [notch(0.1875), notch(-0.1875)];
        let mut cut = Vec::new();
        for notch in &notches {
            cut.extend(bonds.across_segment(&nodes, (notch.mouth, notch.tip))?);
        }
        Ok(Self { plate, nodes, bonds, grips, free, notches, cut, n_steps })
    }

    /// `kT` at which the stretch of a bond of the length `dx` has the standard deviation `s_0/ratio`, were all bonds alike.
    fn temperature(&self) -> CaseResult<f64> {
        let n_unknowns = 2.0 * self.free.iter().filter(|&&free| free).count() as f64;
        let share = self.bonds.len() as f64 / n_unknowns;
        let stiffness = self.bonds.all()[0].stiffness;
        Ok((self.plate.strength()? / RATIO).powi(2) * stiffness * self.plate.spacing * share)
    }

    fn simulation<const L: usize>(
        &self,
        (dt, temperature): (f64, f64),
        loading: Loading<2>,
        first: u64,
    ) -> CaseResult<Simulation<f32, 2, L>> {
        let strengths = vec![self.plate.strength()?; self.bonds.len()];
        let (nodes, bonds) = (self.nodes.clone(), self.bonds.clone());
        let body = BondList::<f32, 2, L>::new(nodes, bonds, Strain::Finite, &strengths)?;
        let mobility = Mobility::identity(&self.free, 1.0)?;
        let scheme = Scheme::EulerMaruyama;
        let config = SimulationConfig {
            dynamics: Dynamics::Overdamped { mobility, temperature, scheme },
            dt,
            breaking: Breaking::AtEnds,
            confinement: 0.0,
            noise: Noise::new(7),
        };
        let realisations = std::array::from_fn(|lane| first + lane as u64);
        Ok(Simulation::new(body, loading, config, realisations)?)
    }

    /// Which bonds broke in which step, lane by lane.
    fn pulled<const L: usize>(
        &self,
        temperature: f64,
        first: u64,
    ) -> CaseResult<Vec<Vec<(usize, f64)>>> {
        let still = || Loading::new(self.nodes.positions().len());
        let small = 1e-9;
        let patch = self.simulation::<L>((small, 0.0), still().hold(&self.grips)?, first)?;
        let dt = RELATIVE_STEP * small / patch.relative_step();
        let rate = STRAIN * self.plate.strength()? / (dt * f64::from(self.n_steps));
        let gradient = [[0.0; 2], [0.0, 1.0]];
        let program = Program::Linear { rate };
        let loading = still().stretch(&self.nodes, &self.grips, [true; 2], gradient, program)?;
        let mut run = self.simulation::<L>((dt, temperature), loading, first)?;
        run.cut(&self.cut)?;
        let mut breaks = vec![Vec::new(); L];
        for _ in 0..self.n_steps {
            let report = run.step()?;
            for broken in &report.broken {
                for (lane, breaks) in breaks.iter_mut().enumerate() {
                    if broken.lanes >> lane & 1 == 1 {
                        breaks.push((broken.bond, report.time));
                    }
                }
            }
        }
        Ok(breaks)
    }

    /// Of both cracks, zero for none.
    fn lengths(&self, breaks: &[(usize, f64)]) -> CaseResult<[f64; 2]> {
        let mut broken = vec![false; self.bonds.len()];
        for (bond, _) in breaks {
            broken[*bond] = true;
        }
        let Self { nodes, bonds, cut, .. } = self;
        let body = Fractured { nodes, bonds, broken: &broken, cut };
        let config = PathConfig::of_horizon(self.plate.horizon()?.radius());
        let mut lengths = [0.0; 2];
        for (length, notch) in lengths.iter_mut().zip(&self.notches) {
            *length = crack_path(&body, notch, &config)?.map_or(0.0, |path| path.length());
        }
        Ok(lengths)
    }
}

fn run(context: &Context<'_>) -> CaseResult {
    let mut claims = Vec::new();
    let (mut asymmetry, mut difference) = (Worst::default(), Worst::default());
    for (rows, n_steps, batches) in [(32, 2500, 32), (64, 2500, 8)] {
        context.progress(&format!("{rows} rows"));
        let plate = Symmetric::new(rows, n_steps)?;
        let still = without_noise(&plate)?;
        asymmetry.take(still.asymmetry, &format!("{rows} rows"));
        difference.take(still.difference, &format!("{rows} rows"));
        claims.extend(with_noise(context, &format!("n-{rows}"), &plate, batches)?);
    }
    let method = "32 and 64 rows, f32, overdamped, 2500 steps with predictor, no noise";
    let lines = |worst: &Worst| context.lines("without-noise", worst.method(method));
    let quantity = "share of broken bonds whose image did not break in the same step";
    let reason = "roundoff: both cracks are images of each other; in f32, 1e-6 of a stretch may move a break by a step, and with it some of hundreds";
    let claim = lines(&asymmetry).of("asymmetry", quantity).bounded(asymmetry.value(), 0.01);
    claims.push(claim.because(reason));
    let quantity = "length of the upper crack less that of the lower, in horizons";
    let reason = "roundoff: equal; the fit of the paths sums tens of numbers in another order";
    let claim = lines(&difference).of("difference", quantity).bounded(difference.value(), 1e-12);
    claims.push(claim.because(reason));
    Ok(claims)
}

fn method(plate: &Symmetric, what: &str) -> String {
    let rows = plate.plate.spacing.recip().round();
    format!(
        "{rows} rows, horizon 3.015 dx, f32, overdamped, Euler-Maruyama, z = {RELATIVE_STEP}, {} steps with predictor, {what}",
        plate.n_steps
    )
}

/// What is seen without noise.
struct Still {
    asymmetry: f64,
    /// Upper less lower, in horizons.
    difference: f64,
}

fn without_noise(plate: &Symmetric) -> CaseResult<Still> {
    let breaks = plate.pulled::<1>(0.0, 0)?.swap_remove(0);
    let [upper, lower] = plate.lengths(&breaks)?;
    let horizon = plate.plate.horizon()?.radius();
    let cracked = Cracked {
        nodes: plate.nodes.clone(),
        bonds: plate.bonds.clone(),
        cut: plate.cut.clone(),
        breaks,
        horizon,
        n_steps: u64::from(plate.n_steps),
    };
    Ok(Still { asymmetry: cracked.asymmetry(), difference: (upper - lower) / horizon })
}

fn with_noise(
    context: &Context<'_>,
    id: &str,
    plate: &Symmetric,
    batches: u64,
) -> CaseResult<[Claim; 2]> {
    let temperature = plate.temperature()?;
    let mut lengths = Vec::new();
    for batch in 0..batches {
        for breaks in plate.pulled::<LANES>(temperature, batch * LANES as u64)? {
            lengths.push(plate.lengths(&breaks)?);
        }
    }
    let n = lengths.len() as f64;
    let win = |[upper, lower]: &[f64; 2]| match upper.total_cmp(lower) {
        std::cmp::Ordering::Greater => 1.0,
        std::cmp::Ordering::Equal => 0.5,
        std::cmp::Ordering::Less => 0.0,
    };
    let share = lengths.iter().map(win).sum::<f64>() / n;
    let apart: Vec<f64> = lengths.iter().map(|[upper, lower]| (upper - lower).abs()).collect();
    let apart = mean(&apart);
    let what = format!("s0/sigma = {RATIO}, {n} realisations in lanes of {LANES}");
    let lines = context.lines(id, method(plate, &what));
    let quantity = "share of realisations in which the upper crack is the longer";
    let coin = context
        .subject(format!("{id}/share"), quantity, method(plate, &what))
        .absolute(Measured::sampled(share, 0.5 / n.sqrt()), 0.5)
        .monte_carlo(0.0)
        .because("symmetric in law; standard error of a fair coin, ties count half");
    // Four standard errors to both sides of what was seen first.
    let (from, to) = if plate.plate.spacing > 0.02 { (0.49, 0.555) } else { (0.04, 0.074) };
    let seen = lines
        .of("difference", "mean difference of both lengths, over the width of the plate")
        .measured(apart, (from, to))
        .because("the coin falls: cracks are not equal, as they are without noise; on the finer plate, whose steps are as many, both cracks still grow at the end");
    Ok([coin, seen])
}
