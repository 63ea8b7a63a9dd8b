//! How far cracks from a notch scatter, and whether that survives another lattice.

use peridyn_sde::statistics::{Bootstrap, CrackEnsemble, Interval};
use peridyn_sde::{Precision, Scheme};
use reference_problems::peridyn::notched_plate::{Cause, NOTCH, NotchedPlate, three_shells};
use reference_problems::peridyn::sample::mean;
use sde_integrators::Noise;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/notched-plate",
    title: "Cracks from an edge notch: what noise and random stiffness scatter, on lattices of 32, 64 and 128 rows",
    source: "self-convergence; white noise: sd in proportion to dx^0.9 (measured with a prototype)",
    cost: Profile::Default,
    run: Together(run),
};

/// Where heights are compared (widths of the plate); the notch ends at 0.3.
const ABSCISSA: f64 = 0.65;
/// `s0/sigma` of the white noise.
const RATIO: f64 = 10.0;
const SEED: u64 = 7;

/// What is refined, and how.
#[derive(Clone, Copy, PartialEq)]
enum Family {
    White,
    /// Random stiffness, and three spacings in the horizon.
    Local,
    /// Random stiffness, and one horizon on all lattices.
    FixedHorizon,
}

impl Family {
    const ALL: [Self; 3] = [Self::White, Self::Local, Self::FixedHorizon];

    const fn id(self) -> &'static str {
        match self {
            Self::White => "white-noise",
            Self::Local => "stiffness",
            Self::FixedHorizon => "stiffness-fixed-horizon",
        }
    }

    fn plate(self, rows: u32) -> NotchedPlate {
        let horizon = three_shells(if self == Self::FixedHorizon { 32 } else { rows });
        let cause = match self {
            Self::White => {
                Cause::WhiteNoise { ratio: RATIO, scheme: Scheme::EulerMaruyama, z: 0.9 }
            }
            Self::Local | Self::FixedHorizon => Cause::Stiffness,
        };
        NotchedPlate { rows, horizon, cause, rotation: 0.0, tip: NOTCH }
    }

    const fn method(self) -> &'static str {
        match self {
            Self::White => {
                "white noise, s0/sigma = 10, horizon 3.015 dx, overdamped, Euler-Maruyama, z = 0.9"
            }
            Self::Local => {
                "stiffness lognormal, coefficient of variation 0.5, length 0.283, horizon 3.015 dx, inertial with friction"
            }
            Self::FixedHorizon => {
                "stiffness lognormal, coefficient of variation 0.5, length 0.283, horizon 0.0942, inertial with friction"
            }
        }
    }
}

/// Cracks of a family on a lattice.
struct Scatter {
    family: Family,
    rows: u32,
    ensemble: CrackEnsemble,
    heights: Vec<f64>,
    deviation: Interval,
}

impl Scatter {
    fn new(family: Family, rows: u32, realisations: u64, seed: u64) -> CaseResult<Self> {
        let ensemble = family.plate(rows).cracks(Precision::Single, realisations, seed)?;
        let heights = ensemble.heights(ABSCISSA);
        let deviation = bootstrap().deviation(&heights)?;
        Ok(Self { family, rows, ensemble, heights, deviation })
    }

    fn place(&self) -> String {
        format!("{}, {} rows", self.family.id(), self.rows)
    }

    fn count(&self) -> usize {
        self.ensemble.records().len()
    }

    /// Over dx, with a standard error of a quarter of the 95 % bootstrap interval.
    fn spacings(&self) -> Measured {
        let rows = f64::from(self.rows);
        let error = 0.25 * rows * (self.deviation.high - self.deviation.low);
        Measured::sampled(rows * self.deviation.value, error)
    }

    /// Logarithms of failure loads.
    fn loads(&self) -> Vec<f64> {
        let loads = self.ensemble.records().iter().filter_map(|record| record.failure_load);
        loads.map(f64::ln).collect()
    }
}

fn run(context: &Context<'_>) -> CaseResult {
    let sizes: &[(u32, u64)] = if context.profile == Profile::Full {
        &[(32, 200), (64, 200), (128, 64)]
    } else {
        &[(32, 64), (64, 32)]
    };
    let mut all: Vec<Scatter> = Vec::new();
    for family in Family::ALL {
        for &(rows, realisations) in sizes {
            context.progress(&format!("{}, {rows} rows", family.id()));
            // On the coarsest lattice both horizons are one; a spread that stays needs more realisations to exclude half of it.
            if family != Family::FixedHorizon {
                all.push(Scatter::new(family, rows, realisations, SEED)?);
            } else if rows != sizes[0].0 {
                all.push(Scatter::new(family, rows, realisations.max(64), SEED)?);
            }
        }
    }
    let mut claims: Vec<Claim> = all.iter().map(|scatter| deviation(context, scatter)).collect();
    let find = |family: Family, rows: u32| {
        let family = if rows == sizes[0].0 && family == Family::FixedHorizon {
            Family::Local
        } else {
            family
        };
        let found = all.iter().find(|of| of.family == family && of.rows == rows);
        found.ok_or("a lattice that was not run")
    };
    for family in Family::ALL {
        for pair in sizes.windows(2) {
            let (coarse, fine) = (find(family, pair[0].0)?, find(family, pair[1].0)?);
            claims.push(between(context, family, coarse, fine)?);
        }
    }
    claims.extend(outcomes(context, &all));
    claims.extend(horizon(context, find(Family::Local, 64)?, find(Family::FixedHorizon, 64)?)?);
    context.progress("another seed");
    let local = find(Family::Local, 32)?;
    let other = Scatter::new(Family::Local, 32, local.count() as u64, SEED + 1)?;
    claims.extend(loads(context, local, &other)?);
    claims.push(cold(context)?);
    claims.push(in_shards(context)?);
    Ok(claims)
}

/// An ensemble in parts whose sizes are no multiples of the lanes.
fn in_shards(context: &Context<'_>) -> CaseResult<Claim> {
    context.progress("shards");
    let (plate, count) = (Family::White.plate(24), 40);
    let whole = plate.run(Precision::Single, 0..count, SEED)?;
    let [last, middle, parts] =
        [27..count, 14..27, 0..14].map(|range| plate.run(Precision::Single, range, SEED));
    let (middle, last) = (middle?, last?);
    let mut parts = parts?;
    parts.append(middle)?;
    parts.append(last)?;
    let n_different = (whole.records.iter().zip(&parts.records).filter(|(a, b)| a != b).count())
        + whole.loads.iter().zip(&parts.loads).filter(|(a, b)| a != b).count()
        + usize::from(whole.damage != parts.damage)
        + usize::from(whole.broken != parts.broken);
    let method = "40 realisations of 24 rows in white noise, f32, in three ranges run from the last to the first and joined";
    Ok(context
        .subject("shards", "paths, load curves and maps that differ from those of one run", method)
        .same_bits(n_different, 2 * whole.records.len() + 2)
        .because(
            "noise is a function of seed, realisation and step; lanes do not know of each other",
        ))
}

fn bootstrap() -> Bootstrap {
    Bootstrap::new(Noise::new(SEED))
}

fn lines<'a>(context: &'a Context<'a>, id: &'a str, family: Family, paths: &str) -> Lines<'a> {
    context.lines(id, format!("{}; f32, {paths}", family.method()))
}

fn deviation(context: &Context<'_>, scatter: &Scatter) -> Claim {
    let Scatter { family, rows, .. } = *scatter;
    let id = format!("{}/n-{rows}", family.id());
    let lines = lines(context, &id, family, &format!("{} realisations", scatter.count()));
    let quantity =
        format!("standard deviation of the height of a crack at x = {ABSCISSA}, over dx");
    if family == Family::White {
        return context
            .subject(format!("{id}/deviation"), &quantity, &lines.method)
            .relative(scatter.spacings(), 1.3)
            .monte_carlo(0.1)
            .because("the mesh sets it: about 1.3 spacings at this noise, on every mesh (measured with a prototype)");
    }
    let (least, most) = match (family, rows) {
        (Family::Local, ..=64) => (2.1, 4.0),
        (Family::Local, _) => (2.5, 5.5),
        _ => (0.08 * f64::from(rows), 0.13 * f64::from(rows)),
    };
    let reason = "four standard errors to both sides of what was seen; standard error a quarter of the 95 % bootstrap interval";
    lines.of("deviation", &quantity).measured(scatter.spacings(), (least, most)).because(reason)
}

/// Of all ensembles: none broke elsewhere, and how many came to where heights are compared.
fn outcomes(context: &Context<'_>, all: &[Scatter]) -> [Claim; 3] {
    let (mut elsewhere, mut short, mut white) =
        (Worst::default(), Worst::default(), Worst::default());
    for scatter in all {
        let share = |count: usize| count as f64 / scatter.count() as f64;
        let records = scatter.ensemble.records();
        let lost = records.iter().filter(|record| !record.outcome.counts()).count();
        elsewhere.take(share(lost), &scatter.place());
        let missing = share(scatter.count() - scatter.heights.len());
        let worst = if scatter.family == Family::White { &mut white } else { &mut short };
        worst.take(missing, &scatter.place());
    }
    let lines = |worst: &Worst, what: &str| context.lines("", worst.method(what));
    [
        lines(&elsewhere, "all ensembles, 32 realisations or more")
            .of(
                "elsewhere",
                "largest share of realisations that broke at the prescribed edges, fell apart or failed",
            )
            .bounded(elsewhere.value(), 0.02)
            .because("statistics: no bond breaks near the prescribed edges, and no plate fell apart; one of 64 or more may"),
        lines(&white, "white noise, all lattices")
            .of("short/white-noise", "largest share of cracks that end before the abscissa")
            .bounded(white.value(), 0.02)
            .because("statistics: the plate is pulled until it is through; one of 64 may not be"),
        lines(&short, "random stiffness, all lattices and horizons")
            .of("short/stiffness", "largest share of cracks that end before the abscissa")
            .measured(short.value(), (0.15, 0.5))
            .because("cracks arrest where the plate is soft, or do not start where it is soft around the notch: heights are of the others, and more arrest the smaller the horizon"),
    ]
}

/// What refinement does.
fn between(
    context: &Context<'_>,
    family: Family,
    coarse: &Scatter,
    fine: &Scatter,
) -> CaseResult<Claim> {
    let id = format!("{}/n-{}-over-n-{}/ratio", family.id(), fine.rows, coarse.rows);
    let paths = format!("{} and {} realisations", fine.count(), coarse.count());
    let method = lines(context, &id, family, &paths).method;
    let ratio = bootstrap().ratio_of_deviations(&fine.heights, &coarse.heights)?;
    let (expected, bias_bound, reason) = match family {
        Family::FixedHorizon => (
            1.0,
            0.05,
            "the horizon is a length of the material: the spread stays; half of it is excluded",
        ),
        Family::White => (
            0.5_f64.powf(0.9),
            0.05,
            "vanishes with the lattice: dx^0.9, measured with a prototype; a spread that stays is excluded",
        ),
        Family::Local => (
            0.5,
            0.1,
            "vanishes with the horizon, which shrinks with the lattice: a smooth field turns a crack by what a horizon sees of it; a spread that stays is excluded",
        ),
    };
    let value = Measured::sampled(ratio.value, 0.25 * (ratio.high - ratio.low));
    let subject = context.subject(&id, "ratio of standard deviations, fine over coarse", &method);
    Ok(subject.absolute(value, expected).monte_carlo(bias_bound).because(reason))
}

/// Information of cracks about the horizon: two horizons on one lattice, in one field, at one energy release rate.
fn horizon(context: &Context<'_>, half: &Scatter, whole: &Scatter) -> CaseResult<[Claim; 2]> {
    let ratio = bootstrap().ratio_of_deviations(&whole.heights, &half.heights)?;
    let method = format!(
        "stiffness lognormal, coefficient of variation 0.5, length 0.283; horizons 0.0942 and 0.0471 on 64 rows, {} and {} realisations",
        whole.count(),
        half.count()
    );
    let (large, small) = (whole.loads(), half.loads());
    let (mean_large, mean_small) = (mean(&large), mean(&small));
    let spread = bootstrap().deviation(&large)?.value;
    let error = |mean: Measured| mean.standard_error.unwrap_or(f64::NAN);
    Ok([
        context
            .subject(
                "horizon/spread-exponent",
                "d ln(standard deviation of heights)/d ln(horizon)",
                &method,
            )
            .absolute(
                Measured::sampled(ratio.value.log2(), 0.25 * (ratio.high / ratio.low).log2()),
                1.0,
            )
            .monte_carlo(0.1)
            .because("the horizon can be inferred from the spread of paths, to which it is in proportion: n plates determine it to 1/sqrt(2 n); no influence, 0, is excluded"),
        context
            .subject(
                "horizon/load-shift",
                "mean logarithm of the failure load at twice the horizon less that at the horizon, over the standard deviation of one plate",
                &method,
            )
            .absolute(Measured::sampled(
        (mean_large.value - mean_small.value) / spread,
        error(mean_large).hypot(error(mean_small)) / spread,
    ), 0.0)
            .monte_carlo(0.3)
            .because("the horizon cannot be inferred from one load: with a horizon that is small beside the notch the energy release rate alone sets it; here it is a third of the notch and less"),
    ])
}

/// The failure loads of two independent ensembles of one plate.
fn loads(context: &Context<'_>, one: &Scatter, other: &Scatter) -> CaseResult<[Claim; 2]> {
    let (ours, theirs) = (one.loads(), other.loads());
    let method = format!(
        "{}, 32 rows; f32, {} and {} realisations of two seeds",
        one.family.method(),
        ours.len(),
        theirs.len()
    );
    let of_deviation = |loads: &[f64]| -> CaseResult<Measured> {
        let found = bootstrap().deviation(loads)?;
        Ok(Measured::sampled(found.value, 0.25 * (found.high - found.low)))
    };
    let claim = |name: &str, quantity: &str, found: Measured, expected: Measured| {
        context
            .subject(format!("failure-load/{name}"), quantity, &method)
            .absolute(
                found,
                Reference::uncertain(expected.value, expected.standard_error.unwrap_or(f64::NAN)),
            )
            .monte_carlo(0.0)
            .because("two samples of one distribution: fields and their order are drawn from the seed alone")
    };
    Ok([
        claim("mean", "mean logarithm of the failure load", mean(&ours), mean(&theirs)),
        claim(
            "deviation",
            "standard deviation of the logarithm of the failure load",
            of_deviation(&ours)?,
            of_deviation(&theirs)?,
        ),
    ])
}

/// With a millionth of `kT` cracks do not scatter.
fn cold(context: &Context<'_>) -> CaseResult<Claim> {
    context.progress("a millionth of kT");
    let cause = Cause::WhiteNoise { ratio: 1e3 * RATIO, scheme: Scheme::EulerMaruyama, z: 0.9 };
    let plate =
        NotchedPlate { rows: 32, horizon: three_shells(32), cause, rotation: 0.0, tip: NOTCH };
    let heights = plate.cracks(Precision::Single, 64, SEED)?.heights(ABSCISSA);
    let deviation = 32.0 * bootstrap().deviation(&heights)?.value;
    let method = "white noise, s0/sigma = 10,000, 32 rows, otherwise as above, 64 realisations";
    let lines = context.lines("white-noise/cold", method);
    let reason = "all cracks take the path without noise: what scatters them is the noise and not only the mesh";
    let subject = lines.of("deviation", "standard deviation of the height of a crack, over dx");
    Ok(subject.bounded(deviation, 5e-3).because(reason))
}
