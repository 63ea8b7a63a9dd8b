//! Stability limits of the schemes of `fpk-sph` on the damper of Canor & Denoël 2013, section 4.1: particles and step.
//!
//! The predicted step is the diffusion limit of Runge-Kutta 4 (`stability fpk`) times the ratio of the intervals of stability on
//! the negative real axis, `b` against 2.785. It falls with the square of the spacing. The trace of the diffusion on the lattice
//! comes from a run with 81 x 81 particles.

use fpk_sph::{Combination, InitialLattice, Method, Scheme, StepRule};
use result_figures::{Drawing, Scale};

use super::axes::{logarithmic, words};
use super::fpk::{Damper, FINE, MOST_STEPS, TIME, TOLERANCE, drawn, odd};
use super::{Panel, Work};
use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "fpk-schemes",
    title: "schemes in time of fpk-sph on the damper: particles, step",
    draw,
};

/// A scheme of the flow-map fit.
struct Swept {
    /// Name in files.
    id: &'static str,
    title: &'static str,
    scheme: Scheme,
    /// The part of the second moments whose cells the limit leaves out.
    negligible: f64,
}

const fn swept(id: &'static str, title: &'static str, scheme: Scheme, negligible: f64) -> Swept {
    Swept { id, title, scheme, negligible }
}

const SCHEMES: [Swept; 3] = [
    swept("runge-kutta-4", "Runge-Kutta 4", Scheme::RungeKutta4, 0.0),
    swept(
        "lawson-adams-bashforth-2",
        "Lawson-Adams-Bashforth 2",
        Scheme::LawsonAdamsBashforth2,
        0.0,
    ),
    swept(
        "lawson-adams-bashforth-2-negligible",
        "Lawson-Adams-Bashforth 2, 1 % negligible",
        Scheme::LawsonAdamsBashforth2,
        0.01,
    ),
];

/// Caption of every map.
const CAPTION: &str = "Boundary: the diffusion limit 0.25 (b / 2.785) l² / max tr(F⁻¹ D F⁻ᵀ), cells F in spacings, with the \
     interval of stability b on the negative real axis: 2.785 and 1; the largest trace \
     without the cells that hold the negligible part of the second moments.";

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let n = if context.profile == Profile::Quick { 4 } else { 9 };
    let damper = Damper::new()?;
    let fine = |negligible| -> Result<f64, CaseError> {
        let combination = Combination { negligible, ..Method::FlowMapFit.combination() };
        Ok(damper.fine_run(damper.system.clone(), Method::Custom(combination))?.least_limit)
    };
    let of_all = fine(0.0)?;
    let maps = SCHEMES.iter().map(|swept| {
        let least = if swept.negligible > 0.0 { fine(swept.negligible)? } else { of_all };
        map(&damper, n, least, swept)
    });
    maps.collect()
}

/// The map of one scheme; `fine` is the limit of Runge-Kutta 4 with [`FINE`] particles per side.
fn map(damper: &Damper, n: u32, fine: f64, swept: &Swept) -> Result<Drawing, CaseError> {
    let &Swept { id, title, scheme, negligible } = swept;
    let combination = Combination { negligible, ..Method::FlowMapFit.combination() };
    let run = |count: f64, dt: f64, work: &mut Work| {
        let combination = Combination { scheme, step: StepRule::Fixed { dt }, ..combination };
        damper.error(combination, InitialLattice::box_of(odd(count)), TIME, work)
    };
    let ratio = scheme.real_interval() / Scheme::RungeKutta4.real_interval();
    let limit = |count: f64| {
        let spacings = (FINE - 1) as f64 / (odd(count) - 1) as f64;
        Some(fine * ratio * spacings.powi(2))
    };
    drawn(&Panel {
        name: format!("fpk-scheme-{id}"),
        words: words(
            format!("{title}: particles and step"),
            "E[q²] of the damper at t = 4, flow-map fit at a fixed step",
            ["particles along an axis", "step (s)"],
            CAPTION,
        ),
        scale: Scale::Log,
        across: logarithmic(n, 15.0, 81.0),
        upwards: logarithmic(n, 0.01, 0.3),
        boundary: Some(("diffusion limit", &limit)),
        tolerance: TOLERANCE,
        work_limit: MOST_STEPS,
        run: &run,
    })
}
