//! Stability limits of `smpm`: shock, numerical fracture, Taylor series.
//!
//! The shock sweeps cover step, viscosity, particles per cell and shape function.

mod breakdown;
mod fracture;
mod shock;

use result_figures::Drawing;

use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "smpm",
    title: "schemes of smpm: step, viscosity, particles, gas that parts; Taylor series where they end",
    draw,
};

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    context.progress("shock");
    let mut drawings = shock::maps(if is_quick { 4 } else { 8 })?;
    context.progress("gas that parts");
    drawings.push(fracture::chart()?);
    drawings.extend(breakdown::charts(context)?);
    Ok(drawings)
}
