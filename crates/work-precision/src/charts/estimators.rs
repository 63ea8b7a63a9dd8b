//! Error of a statistic against CPU time: estimators on two paths and on two scenes of bodies.

mod bodies;
mod measured;
mod paths;

use result_figures::Drawing;

use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "estimators",
    title: "multilevel, control variates, quasi-Monte Carlo with and without polynomials beside plain samples: error against CPU time",
    draw,
};

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    // One thread, so CPU time is that of one core.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let mut drawings = paths::draw(context)?;
        drawings.extend(bodies::draw(context)?);
        Ok(drawings)
    })
}
