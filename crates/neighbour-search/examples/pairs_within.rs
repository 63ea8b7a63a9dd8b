//! Draws points, all pairs within a radius, and the neighbours of one point as SVG.
//!
//! `cargo run -p neighbour-search --example pairs_within > docs/pictures/neighbour-search.svg`

use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};
use std::error::Error;
use std::io::{self, Write};

const N_POINTS: u32 = 400;
const RADIUS: f64 = 0.09;
/// The point whose neighbours are shown.
const CHOSEN: usize = 5;
/// Length of the unit square in the picture (px), and the margin around it.
const SIZE: f64 = 480.0;
const MARGIN: f64 = 40.0;

/// Points that fill the unit square evenly: fractional parts of multiples of powers of the plastic number.
fn points() -> Vec<[f64; 2]> {
    let plastic: f64 = 1.324_717_957_244_746;
    let place = |k: u32, power: i32| (f64::from(k) * plastic.powi(-power)).fract();
    (1..=N_POINTS).map(|k| [place(k, 1), place(k, 2)]).collect()
}

/// Position of a point of the unit square in the picture.
fn px([x, y]: [f64; 2]) -> (f64, f64) {
    (MARGIN + SIZE * x, MARGIN + SIZE * (1.0 - y))
}

fn dot(out: &mut impl Write, x: [f64; 2], radius: f64, colour: &str) -> io::Result<()> {
    let (x, y) = px(x);
    writeln!(out, r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius}" fill="{colour}"/>"#)
}

fn main() -> Result<(), Box<dyn Error>> {
    let points = points();
    let (mut grid, mut list) = (CellGrid::new(), NeighbourList::new());
    grid.half_list(&points, Radii::Uniform(RADIUS), &mut list)?;
    let mut pairs = Vec::new();
    list.for_each_pair(&points, |pair| pairs.push((pair.i, pair.j)))?;
    grid.full_list(&points, Radii::Uniform(RADIUS), &mut list)?;
    let neighbours = list.of(CHOSEN);

    let mut out = io::stdout().lock();
    let side = SIZE + 2.0 * MARGIN;
    let height = side + 30.0;
    let label = format!("{N_POINTS} points, {} pairs within a radius", pairs.len());
    writeln!(
        out,
        r#"<svg width="{side}" height="{height}" role="img" aria-label="{label}" xmlns="http://www.w3.org/2000/svg">"#
    )?;
    writeln!(out, r##"<rect width="100%" height="100%" fill="#FFFFFF"/>"##)?;
    let line = |&(i, j): &(usize, usize)| {
        let ((x1, y1), (x2, y2)) = (px(points[i]), px(points[j]));
        format!("M{x1:.0} {y1:.0}L{x2:.0} {y2:.0}")
    };
    let lines = pairs.iter().map(line).collect::<Vec<_>>().concat();
    writeln!(out, r##"<path stroke="#C9D2DC" stroke-width="0.8" d="{lines}"/>"##)?;
    for point in &points {
        dot(&mut out, *point, 2.2, "#5B6775")?;
    }
    let (x, y) = px(points[CHOSEN]);
    let reach = SIZE * RADIUS;
    writeln!(
        out,
        r##"<circle cx="{x:.1}" cy="{y:.1}" r="{reach}" fill="none" stroke="#0072B2" stroke-width="2"/>"##
    )?;
    for &j in neighbours {
        dot(&mut out, points[j as usize], 4.0, "#D55E00")?;
    }
    dot(&mut out, points[CHOSEN], 5.0, "#0072B2")?;
    let baseline = side + 8.0;
    writeln!(
        out,
        r##"<text x="{MARGIN}" y="{baseline}" font-family="sans-serif" font-size="15" fill="#1B2430">{label}; {} neighbours of one</text>"##,
        neighbours.len()
    )?;
    writeln!(out, "</svg>")?;
    Ok(())
}
