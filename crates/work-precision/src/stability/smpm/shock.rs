//! A plane shock in steel: Courant number against linear viscosity and against particles per cell.

use result_figures::Drawing;
use scenes::smpm::scene::{SchemeScene, ShapeScene};

use crate::problems::shock::{self, FLIP, SHAPES, scheme};
use crate::stability::axes::{linear, logarithmic, words};
use crate::stability::{Limits, Panel, Work};
use reference_problems::context::CaseError;

/// Tolerance of the pressure behind the front, and a work limit in steps of ten times that of a usual run.
const LIMITS: Limits = Limits { tolerance: 0.05, work: 10_000 };
/// Cells of half a millimetre (cm).
const CELL: f64 = 0.05;
/// Linear viscosity where it is not swept.
const VISCOSITY: f64 = 0.3;

/// Every shape function.
pub(super) fn maps(n: u32) -> Result<Vec<Drawing>, CaseError> {
    let mut drawings = Vec::new();
    for (shape, name) in SHAPES {
        drawings.push(viscosity(n, shape, name)?);
        drawings.push(particles(n, shape, name)?);
    }
    Ok(drawings)
}

/// The larger of post-shock oscillation and error of the mean.
fn error(scheme: &SchemeScene, per_cell: u32, work: &mut Work) -> Result<f64, CaseError> {
    let mut scene = shock::scene(scheme, CELL)?;
    scene.grid.particles_per_cell = per_cell;
    let behind = shock::behind(&scene, work)?;
    Ok(behind.ripple.max(behind.pressure.abs()))
}

/// Courant number at which a wave crosses a cell in a step.
const REFUSED: f64 = 1.0;

const SUBTITLE: &str = "pressure behind a shock of 0.47 Mbar in steel: the larger of post-shock oscillation and error of the mean";

const FOOT: &str = "A plate at 1 km/s on a rigid wall, cells of 0.5 mm, quadratic viscosity 1.5. \
     Boundary: a wave crosses a cell in a step; such a Courant number is rejected.";

fn viscosity(n: u32, shape: ShapeScene, name: &str) -> Result<Drawing, CaseError> {
    let run = |viscosity: f64, courant: f64, work: &mut Work| {
        let scheme =
            SchemeScene { courant_number: Some(courant), ..scheme(shape, FLIP, viscosity) };
        error(&scheme, 2, work)
    };
    Panel {
        name: format!("smpm-viscosity-{name}-musl"),
        words: words(
            format!("{name}, FLIP: linear viscosity and step"),
            SUBTITLE,
            ["coefficient of the linear viscosity", "Courant number"],
            &format!("{FOOT} 2 particles a cell."),
        ),
        across: linear(n, 0.0, 1.4),
        upwards: logarithmic(n, 0.1, 1.3),
        boundary: Some(("a wave crosses a cell", &|_| Some(REFUSED))),
        limits: LIMITS,
        run: &run,
    }
    .sweep()
}

fn particles(n: u32, shape: ShapeScene, name: &str) -> Result<Drawing, CaseError> {
    let run = |per_cell: f64, courant: f64, work: &mut Work| {
        let scheme =
            SchemeScene { courant_number: Some(courant), ..scheme(shape, FLIP, VISCOSITY) };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 6")]
        let per_cell = per_cell.round() as u32;
        error(&scheme, per_cell, work)
    };
    Panel {
        name: format!("smpm-particles-{name}"),
        words: words(
            format!("{name}, FLIP: particles per cell and step"),
            SUBTITLE,
            ["particles per cell", "Courant number"],
            &format!("{FOOT} Linear viscosity {VISCOSITY}."),
        ),
        across: linear(6, 1.0, 6.0),
        upwards: logarithmic(n, 0.1, 1.3),
        boundary: Some(("a wave crosses a cell", &|_| Some(REFUSED))),
        limits: LIMITS,
        run: &run,
    }
    .sweep()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::{Map, Outcome};

    /// Every run ends in a number or in an error that names what was out of range.
    #[test]
    fn beyond_the_courant_limit_every_run_is_refused_and_within_it_none_is_without_a_number() {
        let drawing = viscosity(2, ShapeScene::QuadraticBSpline, "quadratic").unwrap();
        let map: Map = serde_json::from_str(&drawing.data).unwrap();
        assert_eq!(map.points.len(), 8);
        for point in &map.points {
            match &point.outcome {
                Outcome::Accurate { error } => assert!(point.y < 1.0 && *error <= LIMITS.tolerance),
                Outcome::Degraded { error } => assert!(point.y < 1.0 && error.is_some()),
                Outcome::Ended { error } => {
                    assert!(point.y > 1.0 && error.contains("courant_number"), "{error}");
                }
            }
        }
        // A linear viscosity of 1.4 damps the oscillation at a small step.
        let damped = map.points.iter().find(|point| point.x > 1.0 && point.y < 0.2).unwrap();
        assert!(matches!(damped.outcome, Outcome::Accurate { .. }), "{damped:?}");
    }
}
