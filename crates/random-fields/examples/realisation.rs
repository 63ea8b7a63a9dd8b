//! Draws one realisation of a field three times: as it is, about inclined axes, and given measurements.
//!
//! `cargo run -p random-fields --example realisation > docs/pictures/random-fields.svg`

use std::error::Error;
use std::io::{self, Write};

use random_fields::{
    ConditionedField, Correlation, CorrelationFunction, Marginal, Measurement, RandomField,
    SpatialCorrelation, Truncation,
};
use sde_integrators::Noise;

/// The box (m), the cells of the picture, and their side (px).
const SIZE: [f64; 2] = [30.0, 10.0];
const CELLS: [usize; 2] = [120, 40];
const CELL: f64 = 5.0;
/// Left, upper and lower margin of a picture (px).
const MARGIN: [f64; 3] = [24.0, 34.0, 12.0];
/// Range of the colours (kPa).
const RANGE: [f64; 2] = [10.0, 46.0];
const COLOURS: [&str; 9] = [
    "#440154", "#472D7B", "#3B528B", "#2C728E", "#21918C", "#28AE80", "#5EC962", "#ADDC30",
    "#FDE725",
];
const STRENGTH: Marginal = Marginal::Lognormal { mean: 23.0, coefficient_of_variation: 0.3 };

/// Centre of a cell (m).
fn centre(column: usize, row: usize) -> [f64; 2] {
    [
        (column as f64 + 0.5) * SIZE[0] / CELLS[0] as f64,
        (row as f64 + 0.5) * SIZE[1] / CELLS[1] as f64,
    ]
}

/// Index of the colour of a strength (kPa).
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 8")]
fn colour(strength: f64) -> usize {
    let part = (strength - RANGE[0]) / (RANGE[1] - RANGE[0]);
    (part * COLOURS.len() as f64).clamp(0.0, COLOURS.len() as f64 - 1.0) as usize
}

/// One picture; adjacent cells of one colour in a row are one rectangle.
fn draw(
    out: &mut impl Write,
    field: &RandomField<2>,
    coefficients: &[f64],
    (top, title): (f64, &str),
) -> Result<(), Box<dyn Error>> {
    let [left, above, _] = MARGIN;
    writeln!(out, r##"<text x="{left}" y="{:.0}" fill="#1B2430">{title}</text>"##, top + 22.0)?;
    for row in 0..CELLS[1] {
        let points: Vec<[f64; 2]> = (0..CELLS[0]).map(|column| centre(column, row)).collect();
        let mut values = vec![0.0; CELLS[0]];
        field.values(coefficients, &points, &mut values)?;
        let colours: Vec<usize> = values.iter().map(|&z| colour(STRENGTH.at(z))).collect();
        let y = top + above + (CELLS[1] - 1 - row) as f64 * CELL;
        let mut column = 0;
        for run in colours.chunk_by(|a, b| a == b) {
            let (x, width) = (left + column as f64 * CELL, run.len() as f64 * CELL);
            let fill = COLOURS[run[0]];
            writeln!(out, r#"<path fill="{fill}" d="M{x} {y}h{width}v{CELL}h-{width}z"/>"#)?;
            column += run.len();
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let along = |length| Correlation { function: CorrelationFunction::Exponential, length };
    let soil = SpatialCorrelation::separable([along(20.0), along(2.0)]);
    let (sine, cosine) = 20.0_f64.to_radians().sin_cos();
    let inclined = soil.with_axes([[cosine, -sine], [sine, cosine]]);
    let (corners, truncation) = ([[0.0, 0.0], SIZE], Truncation::Share(0.9));
    let field = RandomField::on_box(corners, soil, truncation)?.with_unit_variance();
    let layers = RandomField::on_box(corners, inclined, truncation)?.with_unit_variance();
    let exact = |x: f64, y: f64, strength: f64| -> Result<_, random_fields::Error> {
        let value = STRENGTH.normal_score(strength)?;
        Ok(Measurement { position: [x, y], value, standard_deviation: 0.0 })
    };
    let measured = [exact(4.0, 8.0, 12.0)?, exact(15.0, 5.0, 42.0)?, exact(26.0, 2.0, 12.0)?];
    let given = ConditionedField::new(field.clone(), &measured)?;

    let noise = Noise::new(11);
    let draws = |field: &RandomField<2>| -> Result<Vec<f64>, random_fields::Error> {
        let mut coefficients = vec![0.0; field.n_terms()];
        field.coefficients(&noise, 0, 0, &mut coefficients)?;
        Ok(coefficients)
    };
    let (plain, turned) = (draws(&field)?, draws(&layers)?);
    let mut conditioned = plain.clone();
    given.condition(&mut conditioned)?;

    let [left, above, below] = MARGIN;
    let step = above + CELLS[1] as f64 * CELL + below;
    let (width, height) = (2.0 * left + CELLS[0] as f64 * CELL, 3.0 * step + 8.0);
    let mut out = io::stdout().lock();
    writeln!(
        out,
        r#"<svg width="{width}" height="{height}" role="img" aria-label="Strength of a slope" font-family="sans-serif" font-size="15" xmlns="http://www.w3.org/2000/svg">"#
    )?;
    writeln!(out, r##"<rect width="100%" height="100%" fill="#FFFFFF"/>"##)?;
    let title =
        "Strength from 10 (dark) to 46 kPa (light) on 30 m by 10 m: lengths of 20 m and 2 m";
    draw(&mut out, &field, &plain, (0.0, title))?;
    draw(&mut out, &layers, &turned, (step, "The same normals, layers inclined by 20 degrees"))?;
    let title = "The first, given 12, 42 and 12 kPa at the circles";
    draw(&mut out, &field, &conditioned, (2.0 * step, title))?;
    for one in &measured {
        let [x, y] = one.position.map(|x| x * CELLS[0] as f64 * CELL / SIZE[0]);
        let (cx, cy) = (left + x, 2.0 * step + above + CELLS[1] as f64 * CELL - y);
        let style = r##"fill="none" stroke="#FFFFFF" stroke-width="2""##;
        writeln!(out, r#"<circle cx="{cx:.1}" cy="{cy:.1}" r="7" {style}/>"#)?;
    }
    writeln!(out, "</svg>")?;
    Ok(())
}
