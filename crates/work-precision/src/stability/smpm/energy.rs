//! Energy of an explosion over the Courant number.

use rayon::prelude::*;
use result_figures::{Drawing, Method, Reading, Run, RunOutcome, Words, WorkPrecision};
use scenes::causes::with_causes;
use scenes::smpm::scene::{OrderScene, SchemeScene, ShapeScene, TransferScene};

use crate::context::CaseError;
use crate::problems::smpm::schemes::{Explosion, FLIP, ORDERS, SHAPES, scheme};
use crate::stability::Work;
use crate::stability::axes::logarithmic;

/// End time (us).
const TIME: f64 = 40.0;
/// Edge of a cell (cm).
const CELL: f64 = 0.5;
const MOST_STEPS: u64 = 20_000;

/// Linear and quadratic functions in all update orders; the others, and APIC, in the default order.
fn schemes() -> Vec<(String, SchemeScene)> {
    let of = |(shape, shape_name): (ShapeScene, &str),
              (order, order_name): (OrderScene, &str),
              transfer| {
        let transfer_name = if transfer == FLIP { "FLIP" } else { "APIC" };
        let name = format!("{shape_name}, {order_name}, {transfer_name}");
        (name, SchemeScene { update_order: Some(order), ..scheme(shape, transfer, 0.06) })
    };
    let [hat, gimp, quadratic, cubic] = SHAPES;
    let usual = ORDERS[2];
    let mut all = Vec::new();
    for shape in [hat, quadratic] {
        all.extend(ORDERS.map(|order| of(shape, order, FLIP)));
    }
    all.extend([gimp, cubic].map(|shape| of(shape, usual, FLIP)));
    all.push(of(quadratic, usual, TransferScene::Apic));
    all
}

/// A run: its Courant number, and the energy change or why it is missing.
type Point = (f64, Result<f64, String>);

pub(super) fn chart(n: u32) -> Result<Drawing, CaseError> {
    let mut numbers = logarithmic(n, 0.1, 0.95);
    // Rejected: a wave would cross a cell.
    numbers.push(1.1);
    let follow = |scheme: &SchemeScene, courant: f64| -> Point {
        let scheme = SchemeScene { courant_number: Some(courant), ..scheme.clone() };
        let change = Explosion::new(&scheme, CELL, 2)
            .and_then(|run| run.energy_change(TIME, &mut Work::new(MOST_STEPS)));
        (courant, change.map_err(|error| with_causes(error.as_ref())))
    };
    let schemes = schemes();
    let rows: Vec<(&str, Vec<Point>)> = schemes
        .par_iter()
        .map(|(name, scheme)| {
            (name.as_str(), numbers.iter().map(|&courant| follow(scheme, courant)).collect())
        })
        .collect();
    let run = |(courant, change): &Point| Run {
        cost: *courant,
        cost_error: None,
        outcome: match change {
            Ok(change) if change.abs() > 0.0 && change.is_finite() => {
                RunOutcome::Error { value: change.abs(), standard_error: None }
            }
            Ok(change) => RunOutcome::Failed { reason: format!("energy changed by {change}") },
            Err(reason) => RunOutcome::Failed { reason: reason.clone() },
        },
        label: matches!(change, Ok(change) if *change > 0.0).then(|| "+".to_owned()),
    };
    let series = rows.iter().map(|(name, points)| Method {
        name: (*name).to_owned(),
        runs: points.iter().map(run).collect(),
    });
    let chart = WorkPrecision {
        words: Words {
            title: "Energy of an explosion against the Courant number".into(),
            subtitle: format!(
                "TNT in water on a plate of steel, {TIME} us, cells of 5 mm, 2 x 2 particles; linear viscosity 0.06"
            ),
            x_label: "Courant number".into(),
            y_label: "change of the energy, over that of the start".into(),
            caption: vec![
                "A plus marks a gain, a cross above a typed error: beyond 1 a wave crosses a cell and the number is rejected; within it the energy grew by 20 %, or a particle became faster in the step than it was allowed for.".into(),
            ],
        },
        reading: Reading::Parameter,
        series: series.collect(),
    };
    let table: Vec<String> = rows.iter().map(|(name, points)| line(name, points)).collect();
    Ok(Drawing::work_precision("smpm-energy-courant", &chart)?.with_rows(&table.join("\n")))
}

fn line(name: &str, points: &[Point]) -> String {
    let entry = |(courant, change): &Point| match change {
        Ok(change) => format!("{courant:.2}: {:+.1} %", 100.0 * change),
        Err(_) => format!("{courant:.2}: ended"),
    };
    let entries: Vec<String> = points.iter().map(entry).collect();
    format!("  {name:24} {}", entries.join("  "))
}
