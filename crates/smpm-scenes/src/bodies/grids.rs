//! Grids of doubling cells for multilevel Monte Carlo.

use result_figures::number::tidy;
use scene_runs::scene::Objection;

use crate::method_scene::{MethodScene, MultilevelScene};
use crate::scene::{BodyScene, GridScene, SmpmScene, SolidScene};

/// Largest part of a cell by which a size may miss a whole number of cells: roundoff.
const ROUNDOFF: f64 = 1e-6;
/// Fewest samples of a pilot.
const FEWEST_SAMPLES: u64 = 8;

/// A size that does not go with a cell.
struct Misfit {
    what: String,
    /// Its length or coordinate, in cells.
    cells: f64,
    cell: f64,
}

impl SmpmScene {
    /// The cells of the grids of a multilevel method, the coarsest first, that of the scene last.
    ///
    /// # Errors
    /// An [`Objection`] to the coarsest cell, or if there is no coarser grid than that of the scene.
    pub(crate) fn cells(&self, method: &MultilevelScene) -> Result<Vec<f64>, Objection> {
        let is_listed = |body: &BodyScene| matches!(body.shape, SolidScene::Points { .. });
        if let Some(body) = self.bodies.iter().find(|body| is_listed(body)) {
            let message =
                format!("the particles of body `{}` are listed for one grid alone", body.name);
            return Err(Objection::new("method.multilevel", message));
        }
        let mut cells = vec![self.grid.cell];
        let misfit = loop {
            let cell = 2.0 * cells[cells.len() - 1];
            let limit = method.coarsest_cell;
            if !cell.is_finite() || limit.is_some_and(|limit| cell > limit * (1.0 + ROUNDOFF)) {
                break None;
            }
            let misfit = self.misfit(cell);
            if misfit.is_some() {
                break misfit;
            }
            cells.push(cell);
        };
        let coarsest = cells[cells.len() - 1];
        if let Some(asked) = method.coarsest_cell {
            let is_it = (coarsest - asked).abs() <= ROUNDOFF * asked;
            if !is_it || cells.len() < 2 {
                return Err(self.no_such_cell(asked, misfit.as_ref()));
            }
        }
        if cells.len() < 2 {
            let message = format!(
                "there is no grid with twice the cell {} of the scene{}",
                tidy(self.grid.cell),
                misfit.map_or_else(String::new, |misfit| misfit.words())
            );
            let help =
                "take a finer `grid.cell`, sizes of an even number of cells, or `monte_carlo`";
            return Err(Objection::new("method.multilevel", message).with_help(help));
        }
        cells.reverse();
        Ok(cells)
    }

    fn no_such_cell(&self, asked: f64, misfit: Option<&Misfit>) -> Objection {
        let path = "method.multilevel.coarsest_cell";
        if let Some(misfit) = misfit {
            let message = format!("there is no grid of cell {}{}", tidy(asked), misfit.words());
            let help = "take a smaller coarsest cell, or leave the key out";
            return Objection::new(path, message).with_help(help);
        }
        let cell = self.grid.cell;
        let message = format!(
            "the coarsest cell is {asked}; it must be the cell {} of the grid times a power of two: {}, {}, ...",
            tidy(cell),
            tidy(2.0 * cell),
            tidy(4.0 * cell)
        );
        Objection::new(path, message)
    }

    /// The first box or boundary that does not go with a cell.
    fn misfit(&self, cell: f64) -> Option<Misfit> {
        let is_whole =
            |cells: f64| (cells - cells.round()).abs() <= ROUNDOFF * cells.abs().max(1.0);
        for body in &self.bodies {
            for solid in std::iter::once(&body.shape).chain(&body.except) {
                // A curved surface is cut into particles on any grid.
                let (lengths, is_box) = match solid {
                    SolidScene::Box { from, to } => {
                        (from.iter().zip(to).map(|(from, to)| to - from).collect(), true)
                    }
                    SolidScene::Ball { radius, .. } => (vec![2.0 * radius], false),
                    SolidScene::Cylinder { radius, height, .. } => {
                        (vec![2.0 * radius, *height], false)
                    }
                    // Of the box about it: an inclined edge is cut into particles on any grid.
                    SolidScene::Polygon { corners } => (extents(corners), true),
                    SolidScene::Surface { read, .. } => {
                        let length = |(low, high): ([f64; 3], [f64; 3])| {
                            low.iter().zip(high).map(|(low, high)| high - low).collect()
                        };
                        (read.as_ref().map_or_else(Vec::new, |it| length(it.bounds)), false)
                    }
                    SolidScene::Points { .. } => continue,
                };
                // Steps of a rotated surface are on any grid.
                let is_box = is_box && body.rotation.is_none();
                for (axis, length) in lengths.iter().enumerate() {
                    let cells = length / cell;
                    if (is_box && !is_whole(cells)) || cells < 1.0 - ROUNDOFF {
                        let what = format!("length {} of body `{}`", axis + 1, body.name);
                        return Some(Misfit { what, cells, cell });
                    }
                }
            }
        }
        self.boundaries.iter().find_map(|boundary| {
            let cells = boundary.position / cell;
            let what = format!("the position {} of a boundary", tidy(boundary.position));
            (!is_whole(cells)).then_some(Misfit { what, cells, cell })
        })
    }

    /// The scene on another grid.
    pub(crate) fn on_grid(&self, cell: f64) -> Self {
        let grid = GridScene { cell, ..self.grid.clone() };
        Self { grid, ..self.clone() }
    }

    /// Rejects a multilevel method without random numbers, without coarser grids, or with a number that it cannot have.
    pub(crate) fn check_multilevel(&self) -> Result<(), Objection> {
        let MethodScene::Multilevel(method) = self.method else { return Ok(()) };
        let objection = |key: &str, message: String| {
            Err(Objection::new(format!("method.multilevel.{key}"), message))
        };
        let MultilevelScene { tolerance, pilot, most_runs, .. } = method;
        if self.random.is_empty() && self.random_fields.is_empty() {
            let message = "there are no random parameters and no random fields to sample";
            return Err(Objection::new("method.multilevel", message));
        }
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return objection("tolerance", format!("{tolerance} must be greater than 0"));
        }
        if !(FEWEST_SAMPLES..=MOST_SAMPLES).contains(&pilot) {
            let message =
                format!("{pilot} samples; there must be {FEWEST_SAMPLES} to {MOST_SAMPLES}");
            return objection("pilot", message);
        }
        if most_runs == 0 {
            return objection("most_runs", "0 runs; there must be 1 at least".to_owned());
        }
        self.cells(&method).map(drop)
    }
}

/// Lengths of the box about points, along each axis of the first.
fn extents(points: &[Vec<f64>]) -> Vec<f64> {
    let n_axes = points.first().map_or(0, Vec::len);
    (0..n_axes)
        .map(|axis| {
            let along = || points.iter().filter_map(|point| point.get(axis).copied());
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        })
        .collect()
}

/// Most samples of a pilot.
const MOST_SAMPLES: u64 = 1 << 20;

impl Misfit {
    fn words(&self) -> String {
        let Self { what, cells, cell } = self;
        format!(": {what} is {} cells of {}", tidy(*cells), tidy(*cell))
    }
}
