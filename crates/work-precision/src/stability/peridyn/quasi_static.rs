//! Load step against batch of bonds in a quasi-static run.

use peridyn_sde::EquilibriumConfig;
use result_figures::{Curve, CurvePoint, Curves, Drawing, Scale, Threshold, Words};

use super::point;
use crate::context::{CaseError, Context, Profile};
use crate::draw::ChartKind;
use crate::problems::peridyn::slow_plate::{Pulled, SlowPlate};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-quasi-static",
    title: "a notched plate with a hole in quasi-static load steps: peak load and path by step and batch of bonds",
    draw,
};

/// Parts of the stretch over strength of the most critical bond.
const BATCHES: [(&str, f64); 4] = [
    ("one bond at a time", 0.0),
    ("batch of 2 %", 0.02),
    ("batch of 10 %", 0.1),
    ("all over their strength", 0.999),
];

/// Against the run event by event.
struct Compared {
    /// Relative.
    peak: f64,
    /// In spacings.
    path: Result<f64, CaseError>,
}

fn compared(plate: &SlowPlate, found: &Pulled, exact: &Pulled) -> Compared {
    let path = match (&found.path, &exact.path) {
        (Some(one), Some(two)) => Ok(plate.apart(one, two).0),
        _ => Err("no crack grew from the notch".into()),
    };
    Compared { peak: (found.peak / exact.peak - 1.0).abs(), path }
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    let n = if is_quick { 32 } else { 64 };
    let plate = SlowPlate::new(n)?;
    let steps: &[u32] = if is_quick { &[4, 32] } else { &[2, 4, 8, 16, 32, 64, 128] };
    context.progress("event by event");
    let config = EquilibriumConfig::EVENT_BY_EVENT;
    let exact = plate.by_events(config)?;
    let (mut peaks, mut paths, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for (look, (name, batch)) in BATCHES.into_iter().enumerate() {
        let [mut of_peak, mut of_path] = [const { Vec::<CurvePoint>::new() }; 2];
        for &count in steps {
            context.progress(&format!("{name}, {count} steps"));
            let x = f64::from(count);
            match plate.by_steps(EquilibriumConfig { batch, ..config }, count) {
                Ok(found) => {
                    let Compared { peak, path } = compared(&plate, &found, &exact);
                    let words = match &path {
                        Ok(path) => format!("{path:.2} spacings"),
                        Err(reason) => reason.to_string(),
                    };
                    rows.push(format!(
                        "  {name:24} {count:4} steps: peak off by {:6.2} %, path by {words}; {} bonds, {} evaluations",
                        100.0 * peak,
                        found.order.len(),
                        found.evaluations
                    ));
                    of_peak.push(CurvePoint::at(x, 100.0 * peak));
                    of_path.push(point(x, path));
                }
                Err(error) => {
                    let reason = error.to_string();
                    of_peak.push(CurvePoint::ended(x, reason.clone()));
                    of_path.push(CurvePoint::ended(x, reason));
                }
            }
        }
        peaks.push(Curve::marked(name, look, of_peak));
        paths.push(Curve::marked(name, look, of_path));
    }
    let table = rows.join("\n");
    let peaks = Drawing::curves("peridyn-quasi-static-peak", &picture(n, Of::Peak, peaks))?;
    let paths = Drawing::curves("peridyn-quasi-static-path", &picture(n, Of::Path, paths))?;
    Ok(vec![Drawing { table, ..peaks }, paths])
}

/// Charts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Peak,
    Path,
}

fn picture(n: usize, of: Of, series: Vec<Curve>) -> Curves {
    let (title, y_label) = match of {
        Of::Peak => (
            "The peak load needs small load steps, the batch matters less",
            "error of the peak load (%)",
        ),
        Of::Path => (
            "Bonds over their strength must not all break at once",
            "largest distance of the cracks (spacings)",
        ),
    };
    let thresholds = match of {
        Of::Peak => Vec::new(),
        Of::Path => vec![Threshold::upwards("one spacing", 1.0)],
    };
    Curves {
        words: Words {
            title: title.into(),
            subtitle: format!(
                "{n} x {n} nodes with a notch and a hole, mean strain to 0.8 of the strength in equal load steps; against the run event by event"
            ),
            x_label: "load steps".into(),
            y_label: y_label.into(),
            caption: vec![
                "A batch of 2 %: bonds within 2 % of the most critical one break together, then equilibrium is found at the same load.".into(),
            ],
        },
        across: Scale::Log,
        upwards: Scale::Linear,
        series,
        thresholds,
    }
}
