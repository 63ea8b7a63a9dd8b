//! What of the contact explosion converges with the cell, and what does not at the cell of the paper.

use figures::{ErrorKind, Reference};
use smpm::uncertainty::Experiment;
use work_precision::problems::smpm::problems::{Problem, experiment};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "smpm/refinement",
    title: "Flow stress, deviator and pressure at H, 9 us, over the cell",
    source: "own runs; Chen et al. 2019, section 5.2, whose cells are 0.5 cm",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
};

const TIME: f64 = 9.0;
/// What the others are compared with (cm).
const REFERENCE: f64 = 0.125;

/// A cell (cm), and where the relative errors of flow stress, deviator and pressure were seen.
type Row = (f64, [(f64, f64); 3]);

const ROWS: [Row; 3] = [
    (1.0, [(-0.08, -0.05), (-2.3, -1.7), (-0.7, -0.4)]),
    (0.5, [(-0.03, 0.03), (-2.3, -1.7), (-0.25, 0.05)]),
    (0.25, [(-0.03, 0.03), (-1.9, -1.2), (0.3, 0.8)]),
];
/// With `--full`.
const FINER: Row = (0.0625, [(-0.03, 0.03), (-0.15, 0.2), (-0.15, 0.15)]);

const QUANTITIES: [(&str, &str, &str); 3] = [
    ("flow-stress", "sigma_y at H", "converges, to 3 % from half a centimetre on"),
    (
        "deviator-11",
        "S_11 at H",
        "at half a centimetre and a quarter of it loading still goes on where in truth it has turned about: the sign is wrong",
    ),
    (
        "pressure",
        "p at H",
        "the front is some cells wide and the plate eight to four: a peak that has come or gone at one time. Near at half a centimetre by chance, half as high again at a quarter",
    ),
];

/// Flow stress, deviator and pressure at H (Mbar).
fn at(cell: f64) -> Result<[f64; 3], CaseError> {
    let mut scene = Problem::ContactExplosion.scene_with(0.0, &[TIME])?;
    scene.grid.cell = cell;
    scene.gauges.retain(|gauge| gauge.name == "H");
    scene.quantities = ["flow_stress", "deviator_11", "pressure"].map(str::to_owned).to_vec();
    let run = experiment::<2>(&scene)?;
    let centre = scene.inputs::<5>()?.centre();
    let record = Experiment::<2, 5>::simulation::<f64>(&run, &centre)?.record(&scene.plan()?)?;
    let values = record.values.try_into();
    values.map_err(|values| format!("three values were asked for, not {values:?}").into())
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let rows = ROWS.into_iter().chain((context.profile == Profile::Full).then_some(FINER));
    context.progress(&format!("{REFERENCE} cm"));
    let reference = at(REFERENCE)?;
    let mut claims = Vec::new();
    for (cell, bands) in rows {
        context.progress(&format!("{cell} cm"));
        let values = at(cell)?;
        let id = format!("cell{cell}");
        let method = format!(
            "quadratic B-splines, FLIP, MUSL, cells of {cell} cm against cells of {REFERENCE} cm"
        );
        let lines = Lines { context, id: &id, method };
        for (k, (name, quantity, reason)) in QUANTITIES.into_iter().enumerate() {
            let (from, to) = bands[k];
            claims.push(lines.judge(
                (name, quantity, "Mbar"),
                ErrorKind::Relative,
                values[k],
                Reference::exact(reference[k]),
                Criterion::AsMeasured { from, to, reason },
            ));
        }
    }
    Ok(claims)
}
