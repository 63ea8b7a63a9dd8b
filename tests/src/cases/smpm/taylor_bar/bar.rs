//! A bar that runs into a wall: its run and its shape.

use reference_problems::smpm::problems::{Problem, experiment};
use scenes::smpm::material_scene::MaterialScene;
use scenes::smpm::reading::MOST_RANDOM;
use scenes::smpm::scene::{SmpmScene, SolidScene};
use smpm::Body;
use smpm::uncertainty::Experiment;

use crate::cases::prelude::*;

/// A bar before its impact, and how it is computed.
pub(super) struct Specimen {
    /// mm.
    pub(super) length: f64,
    /// mm.
    pub(super) radius: f64,
    /// km/s.
    pub(super) speed: f64,
    /// When it is looked at (us).
    pub(super) end: f64,
    /// Cells to the radius.
    pub(super) cells: u32,
}

/// A run at its end.
pub(super) struct Bar {
    /// Length, diameter of the foot, diameter where a fifth of the first length is above the wall (mm).
    pub(super) sizes: [f64; 3],
    /// Over that of the start.
    pub(super) energy: f64,
    /// Velocity of the centre of mass along the axis, over that of impact.
    pub(super) rest: f64,
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
    /// The last coordinate is along the axis. Particles represent boxes: the surface is half a box beyond the last.
    fn of<const D: usize>(
        starts: &[[f64; D]],
        body: &Body<f64, D>,
        spacing: f64,
        bar: &Specimen,
    ) -> CaseResult<Self> {
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
                let edge = extrapolated(radius(inner), radius(outer), bar.radius);
                Ok([edge, body.position(*outer)[D - 1]])
            })
            .collect::<CaseResult<_>>()?;
        let [.., below, last] = rows.as_slice() else { return Err("a bar of one row".into()) };
        let height = |p: usize| [starts[p][D - 1], body.position(p)[D - 1]];
        Ok(Self { surface, length: extrapolated(height(below[0]), height(last[0]), bar.length) })
    }

    fn foot(&self) -> f64 {
        2.0 * self.surface.iter().map(|[radius, _]| *radius).fold(0.0, f64::max)
    }

    /// The diameter at a height.
    fn diameter_at(&self, height: f64) -> CaseResult<f64> {
        let crosses = |pair: &&[[f64; 2]]| pair[0][1] <= height && height < pair[1][1];
        let pair = self.surface.windows(2).find(crosses).ok_or("the bar is shorter than that")?;
        let [[r0, z0], [r1, z1]] = [pair[0], pair[1]];
        Ok(2.0 * (r0 + (r1 - r0) * (height - z0) / (z1 - z0)))
    }
}

/// The axisymmetric bar of the scene with the size, the speed and the material of another; without one that of the scene.
pub(super) fn axisymmetric(of: &Specimen, material: Option<MaterialScene>) -> CaseResult<Bar> {
    let mut scene = Problem::TaylorBar.scene()?;
    let bar = scene.bodies.first_mut().ok_or("a scene without a bar")?;
    bar.shape = SolidScene::Box { from: vec![0.0; 2], to: vec![of.radius, of.length] };
    bar.velocity = vec![0.0, -of.speed];
    if let Some(material) = material {
        scene.materials.insert(bar.material.clone(), material);
    }
    run::<2>(scene, of)
}

/// The quarter of the scene, which must be of the size and the speed of the specimen.
pub(super) fn quarter(of: &Specimen) -> CaseResult<Bar> {
    run::<3>(Problem::TaylorBarQuarter.scene()?, of)
}

fn run<const D: usize>(mut scene: SmpmScene, of: &Specimen) -> CaseResult<Bar> {
    scene.grid.cell = of.radius / f64::from(of.cells);
    let spacing = scene.grid.cell / f64::from(scene.grid.particles_per_cell);
    let mut run = Experiment::simulation::<f64>(&experiment::<D>(&scene)?, &[0.0; MOST_RANDOM])?;
    let starts = run.bodies()[0].positions().to_vec();
    let before = run.ledger();
    run.advance_to(of.end)?;
    let after = run.ledger();
    let meridian = Meridian::of(&starts, &run.bodies()[0], spacing, of)?;
    Ok(Bar {
        sizes: [meridian.length, meridian.foot(), meridian.diameter_at(0.2 * of.length)?],
        energy: (after.kinetic + after.internal) / (before.kinetic + before.internal),
        rest: after.momentum[D - 1] / before.momentum[D - 1].abs(),
    })
}
