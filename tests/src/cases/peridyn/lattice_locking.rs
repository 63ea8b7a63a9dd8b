//! Whether the scatter of cracks is that of the material or of the lattice: one horizon, other spacings, rotated lattices.

use peridyn_sde::Precision;
use peridyn_sde::statistics::{Bootstrap, Interval};
use reference_problems::peridyn::notched_plate::{
    CORRELATION, Cause, NOTCH, NotchedPlate, StrengthLaw, Varies, three_shells,
};
use reference_problems::peridyn::sample::mean;
use sde_integrators::Noise;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/lattice-locking",
    title: "Cracks from an edge notch at one horizon: 3, 4 and 6 spacings in it, lattices rotated by 0 to 45 degrees, four kinds of random strength",
    source: "self-convergence: the material's scatter depends on neither spacing nor rotation",
    cost: Profile::Default,
    run: Together(run),
};

const SEED: u64 = 7;
/// Where heights are compared (widths of the plate).
const ABSCISSA: f64 = 0.65;
/// Standard deviation over mean, that of Weibull's distribution with the modulus 5.
const VARIATION: f64 = 0.229;

/// What is random.
#[derive(Clone, Copy, PartialEq)]
enum Law {
    Bonds,
    Nodes,
    Blocks,
    Field,
}

impl Law {
    const ALL: [Self; 4] = [Self::Bonds, Self::Nodes, Self::Blocks, Self::Field];

    const fn id(self) -> &'static str {
        match self {
            Self::Bonds => "bonds",
            Self::Nodes => "nodes",
            Self::Blocks => "blocks",
            Self::Field => "field",
        }
    }

    const fn method(self) -> &'static str {
        match self {
            Self::Bonds => "independent strengths of bonds, one law on all lattices",
            Self::Nodes => "independent strengths of nodes, Weibull's scaled by their volume",
            Self::Blocks => {
                "independent strengths of boxes of one horizon, Weibull's scaled by their volume"
            }
            Self::Field => "lognormal field of strength, length of three horizons",
        }
    }

    const fn cause(self) -> Cause {
        match self {
            Self::Bonds => Cause::Strength(StrengthLaw::Bonds),
            Self::Nodes => Cause::Strength(StrengthLaw::NodesByVolume),
            Self::Blocks => Cause::Strength(StrengthLaw::BlocksByVolume),
            Self::Field => Cause::Field {
                of: Varies::Strength,
                coefficient_of_variation: VARIATION,
                length: CORRELATION,
            },
        }
    }
}

/// Cracks of a law on a lattice.
struct Scatter {
    law: Law,
    rows: u32,
    rotation: f64,
    heights: Vec<f64>,
    deviation: Interval,
    /// Coefficient of variation of the failure load, and its standard error.
    load: Measured,
}

impl Scatter {
    fn new(law: Law, (rows, rotation): (u32, f64), realisations: u64) -> CaseResult<Self> {
        let plate = NotchedPlate {
            rows,
            horizon: three_shells(32),
            cause: law.cause(),
            rotation,
            tip: NOTCH,
        };
        let cracks = plate.cracks(Precision::Single, realisations, SEED)?;
        let heights = cracks.heights(ABSCISSA);
        let deviation = bootstrap().deviation(&heights)?;
        let loads: Vec<f64> =
            cracks.records().iter().filter_map(|record| record.failure_load).collect();
        let spread = bootstrap().deviation(&loads)?;
        let over = mean(&loads).value;
        let load = Measured::sampled(spread.value / over, 0.25 * (spread.high - spread.low) / over);
        Ok(Self { law, rows, rotation, heights, deviation, load })
    }

    fn is(&self, law: Law, rows: u32, rotation: f64) -> bool {
        self.law == law && self.rows == rows && (self.rotation - rotation).abs() < 0.5
    }

    fn id(&self) -> String {
        format!("{}/n-{}/{}-degrees", self.law.id(), self.rows, self.rotation)
    }

    fn lines<'a>(&self, context: &'a Context<'a>, id: &'a str) -> Lines<'a> {
        let method = format!(
            "{}; horizon 0.0942, {:.2} spacings; inertial with friction, f32, {} cracks",
            self.law.method(),
            three_shells(32) * f64::from(self.rows),
            self.heights.len()
        );
        context.lines(id, method)
    }
}

fn bootstrap() -> Bootstrap {
    Bootstrap::new(Noise::new(SEED))
}

/// Lattices by law: rows and degrees.
fn lattices(law: Law, is_full: bool) -> Vec<(u32, f64)> {
    if is_full {
        let rotations = [0.0, 15.0, 30.0, 45.0];
        return [32, 43, 64]
            .into_iter()
            .flat_map(|rows| rotations.map(|rotation| (rows, rotation)))
            .collect();
    }
    match law {
        Law::Blocks => vec![(32, 0.0), (32, 30.0), (43, 0.0), (43, 30.0)],
        Law::Bonds => vec![(32, 0.0), (43, 0.0)],
        Law::Field => vec![(32, 30.0)],
        Law::Nodes => Vec::new(),
    }
}

fn run(context: &Context<'_>) -> CaseResult {
    let is_full = context.profile == Profile::Full;
    let realisations = if is_full { 128 } else { 64 };
    let mut all = Vec::new();
    for law in Law::ALL {
        for (rows, rotation) in lattices(law, is_full) {
            context.progress(&format!("{}, {rows} rows, {rotation} degrees", law.id()));
            all.push(Scatter::new(law, (rows, rotation), realisations)?);
        }
    }
    let find = |law: Law, rows: u32, rotation: f64| {
        let found = all.iter().find(|of| of.is(law, rows, rotation));
        found.ok_or("a lattice that was not run")
    };
    let finest = if is_full { 64 } else { 43 };
    let mut claims = Vec::new();
    for rotation in [0.0, 30.0] {
        let pair = (find(Law::Blocks, finest, rotation)?, find(Law::Blocks, 32, rotation)?);
        claims.push(one_spread(context, pair, &format!("blocks/spacing/{rotation}-degrees"))?);
    }
    let turned = (find(Law::Blocks, finest, 30.0)?, find(Law::Blocks, finest, 0.0)?);
    claims.push(one_spread(context, turned, "blocks/rotation")?);
    claims.push(load_of_bonds(
        context,
        find(Law::Bonds, finest, 0.0)?,
        find(Law::Bonds, 32, 0.0)?,
        is_full,
    ));
    claims.push(guided(context, find(Law::Field, 32, 30.0)?));
    if is_full {
        claims.extend(all.iter().map(|scatter| deviation(context, scatter)));
    } else {
        context.skip("six spacings in a horizon, 15 and 45 degrees, strengths by node: by --full");
    }
    Ok(claims)
}

/// Strengths of blocks of the material: one spread on both lattices.
fn one_spread(
    context: &Context<'_>,
    (one, other): (&Scatter, &Scatter),
    id: &str,
) -> CaseResult<Claim> {
    let ratio = bootstrap().ratio_of_deviations(&one.heights, &other.heights)?;
    let lines = one.lines(context, id);
    let quantity = format!(
        "ratio of standard deviations of heights, {} rows at {} degrees over {} rows at {}",
        one.rows, one.rotation, other.rows, other.rotation
    );
    let value = Measured::sampled(ratio.value, 0.25 * (ratio.high - ratio.low));
    let reason = "strengths belong to boxes of the material: the spread is neither that of the spacing nor of the rotation; half of it is excluded";
    Ok(lines.of("ratio", &quantity).absolute(value, 1.0).monte_carlo(0.05).because(reason))
}

/// Independent bonds average out in a horizon.
fn load_of_bonds(context: &Context<'_>, fine: &Scatter, coarse: &Scatter, is_full: bool) -> Claim {
    let (a, b) = (fine.load, coarse.load);
    let relative = |of: Measured| of.standard_error.unwrap_or(f64::NAN) / of.value;
    let ratio = a.value / b.value;
    let error = ratio * relative(a).hypot(relative(b));
    let range = if is_full { (0.2, 0.5) } else { (0.4, 0.95) };
    let quantity =
        "ratio of the coefficients of variation of the failure load, fine lattice over 32 rows";
    let reason = "vanishes with the spacing: more bonds of one law in a horizon; strengths that belong to bonds are no material's";
    let subject = fine.lines(context, "bonds/load").of("ratio", quantity);
    subject.measured(Measured::sampled(ratio, error), range).because(reason)
}

/// A coarse lattice guides cracks along its rows.
fn guided(context: &Context<'_>, scatter: &Scatter) -> Claim {
    let id = scatter.id();
    scatter.lines(context, &id)
        .of("mean", "mean height of cracks, zero by the symmetry of the plate (widths of the plate)")
        .measured(mean(&scatter.heights), (0.015, 0.07))
        .because("locking: with three spacings in a horizon, a lattice that is rotated by 30 degrees turns cracks to one side")
}

fn deviation(context: &Context<'_>, scatter: &Scatter) -> Claim {
    let Interval { value, low, high, .. } = scatter.deviation;
    let id = scatter.id();
    let range = match scatter.law {
        Law::Bonds => (0.025, 0.07),
        Law::Blocks => (0.07, 0.13),
        Law::Nodes | Law::Field => (0.035, 0.09),
    };
    let quantity = "standard deviation of the height of a crack at x = 0.65 (widths of the plate)";
    let reason = "four standard errors to both sides of what was seen on twelve lattices; standard error a quarter of the 95 % bootstrap interval";
    let subject = scatter.lines(context, &id).of("deviation", quantity);
    subject.measured(Measured::sampled(value, 0.25 * (high - low)), range).because(reason)
}
