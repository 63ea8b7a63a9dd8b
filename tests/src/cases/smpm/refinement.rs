//! What of the contact explosion converges with the cell, and what does not at the cell of the paper.

use reference_problems::smpm::problems::{Problem, experiment};
use smpm::uncertainty::Experiment;

use crate::cases::prelude::*;

pub(crate) const CASE: Case = Case {
    id: "smpm/refinement",
    title: "Flow stress at H, 9 us, over the cell",
    source: "own runs; Chen et al. 2019, section 5.2, whose cells are 0.5 cm",
    cost: Profile::Default,
    run: Together(run),
};

const TIME: f64 = 9.0;
/// What the others are compared with (cm).
const REFERENCE: f64 = 0.125;

/// A cell (cm), and how far the flow stress may be off.
const ROWS: [(f64, f64); 3] = [(1.0, 0.08), (0.5, 0.03), (0.25, 1.5e-3)];
/// With `--full`.
const FINER: (f64, f64) = (0.0625, 0.05);

/// The flow stress at H (Mbar).
fn at(cell: f64) -> CaseResult<f64> {
    let mut scene = Problem::ContactExplosion.scene_with(0.0, &[TIME])?;
    scene.grid.cell = cell;
    scene.gauges.retain(|gauge| gauge.name == "H");
    scene.quantities = vec!["flow_stress".to_owned()];
    let run = experiment::<2>(&scene)?;
    let centre = scene.inputs()?.centre();
    let record = Experiment::simulation::<f64>(&run, &centre)?.record(&scene.plan()?)?;
    Ok(*record.values.first().ok_or("no value was recorded")?)
}

fn run(context: &Context<'_>) -> CaseResult {
    let rows = ROWS.into_iter().chain((context.profile == Profile::Full).then_some(FINER));
    context.progress(&format!("{REFERENCE} cm"));
    let reference = at(REFERENCE)?;
    let mut claims = Vec::new();
    for (cell, tolerance) in rows {
        context.progress(&format!("{cell} cm"));
        let method = format!(
            "quadratic B-splines, FLIP, MUSL, cells of {cell} cm against cells of {REFERENCE} cm"
        );
        let reason = "converges, to 3 % from half a centimetre on; deviator and pressure at an instant do not, and have no claim";
        let lines = context.lines(format!("cell{cell}"), method);
        let subject = lines.of("flow-stress", "sigma_y at H").unit("Mbar");
        claims.push(subject.relative(at(cell)?, reference).within(tolerance).because(reason));
    }
    Ok(claims)
}
