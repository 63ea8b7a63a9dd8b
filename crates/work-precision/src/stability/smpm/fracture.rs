//! Numerical fracture: a gas whose particles separate until they no longer interact.

use result_figures::{Drawing, Line, Scale, TimeSeries, Words};
use smpm::material::{Fluid, Solid, StiffenedGas, StiffenedGasParameters};
use smpm::{Body, Config, Fill, Shape, Simulation, Transfer};

use reference_problems::context::CaseError;

const SHAPES: [(Shape, &str); 2] =
    [(Shape::QuadraticBSpline, "quadratic"), (Shape::CubicBSpline, "cubic")];
const TRANSFERS: [(Transfer, &str); 2] = [(Transfer::Flip, "FLIP"), (Transfer::Apic, "APIC")];
/// Relative volume error that indicates separation.
const PARTED: f64 = 0.05;
/// Largest stretch of the gas.
const MOST_STRETCH: f64 = 12.0;

/// Stretches and the volume ratio of the central particles until the run ends, with the reason.
struct Stretched {
    ratios: Vec<(f64, f64)>,
    end: Option<String>,
}

impl Stretched {
    /// Stretch at which the volume error reaches [`PARTED`].
    fn parts_at(&self) -> Option<f64> {
        self.ratios.iter().find(|(_, ratio)| (ratio - 1.0).abs() > PARTED).map(|&(at, _)| at)
    }

    fn in_words(&self) -> String {
        match (self.parts_at(), &self.end) {
            (Some(at), _) => format!("{at:.1}"),
            (None, Some(_)) => {
                let last = self.ratios.last().map_or(1.0, |&(at, _)| at);
                format!("ended after {last:.1}")
            }
            (None, None) => format!("> {MOST_STRETCH}"),
        }
    }
}

/// A gas with negligible pressure whose particles move at `v = x/(1 s)`: the exact stretch is `1 + t`.
fn stretch(shape: Shape, transfer: Transfer, per_cell: f64) -> Result<Stretched, CaseError> {
    let equation = StiffenedGas::new(StiffenedGasParameters {
        density: 1.0,
        exponent: 1.4,
        stiffness: 0.0,
        pressure: 1e-6,
    })?;
    let fill = Fill::of([1.0 / per_cell], ([-20.0], [20.0]), |_| true)?;
    let mut gas = Body::new(Solid { equation, strength: Fluid }, &fill, [0.0])?;
    gas.set_velocities(|x| *x)?;
    let config = Config::<1> { shape, transfer, ..Config::with_cell(1.0) };
    let mut run = Simulation::new(config, vec![gas])?;
    let mut stretched = Stretched { ratios: vec![(1.0, 1.0)], end: None };
    for k in 1..=110 {
        let exact = 1.0 + 0.1 * f64::from(k);
        if let Err(error) = run.advance_to(exact - 1.0) {
            stretched.end = Some(error.to_string());
            break;
        }
        let gas = &run.bodies()[0];
        let n = gas.n_particles();
        let middle = n / 4..3 * n / 4;
        let count = middle.len() as f64;
        let mean = middle.map(|p| gas.volume_ratio(p)).sum::<f64>() / count;
        stretched.ratios.push((exact, mean / exact));
    }
    Ok(stretched)
}

pub(super) fn chart() -> Result<Drawing, CaseError> {
    let (mut lines, mut rows) = (Vec::new(), Vec::new());
    for (shape, shape_name) in SHAPES {
        for (transfer, transfer_name) in TRANSFERS {
            let mut entries = Vec::new();
            for per_cell in [1_u8, 2, 4] {
                let stretched = stretch(shape, transfer, f64::from(per_cell))?;
                entries.push(format!("{per_cell} a cell: {}", stretched.in_words()));
                if per_cell == 2 {
                    let points = stretched.ratios.iter().map(|&(at, ratio)| (at, Some(ratio)));
                    let name = format!("{shape_name}, {transfer_name}");
                    lines.push(Line { name, points: points.collect() });
                }
            }
            let name = format!("{shape_name}, {transfer_name}");
            rows.push(format!("  {name:16} {}", entries.join("   ")));
        }
    }
    let chart = TimeSeries {
        words: Words {
            title: "Numerical fracture: a gas that is stretched until its particles part".into(),
            subtitle: "uniaxial, v = x / (1 s), 2 particles a cell at the start; volume that particles have, over the true one".into(),
            x_label: "true stretch along the axis".into(),
            y_label: "volume of the particles over the true one".into(),
            caption: vec![
                "Below 1 particles no longer see their neighbours and no longer expand. With APIC each extrapolates its own motion and expands too much. In D dimensions the volume ratio is the D-th power of the stretch.".into(),
            ],
        },
        scale: Scale::Linear,
        lines,
        bands: Vec::new(),
        references: Vec::new(),
    };
    rows.insert(0, format!("  stretch at which the volume is off by {PARTED}:"));
    Ok(Drawing { table: rows.join("\n"), ..Drawing::time_series("smpm-fracture", &chart)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quadratic splines span three cells, cubic ones four.
    #[test]
    fn a_stretched_gas_parts_later_the_farther_its_shape_function_reaches() {
        let flip = TRANSFERS[0].0;
        let parts = |shape| stretch(shape, flip, 2.0).unwrap().parts_at().unwrap();
        let [quadratic, cubic] = [Shape::QuadraticBSpline, Shape::CubicBSpline].map(parts);
        assert!(1.5 < quadratic && quadratic < cubic, "{quadratic} {cubic}");
    }
}
