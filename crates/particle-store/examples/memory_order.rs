//! Draws a lattice in row order and in Morton order as SVG; a line joins particles adjacent in memory.
//!
//! `cargo run -p particle-store --example memory_order > docs/pictures/particle-store.svg`

use particle_store::{Lattice, ParticleStore, morton_order};
use std::error::Error;
use std::io::{self, Write};

/// Radius of the ball in the picture (px), and the margin around it.
const SIZE: f64 = 190.0;
const MARGIN: f64 = 30.0;

/// One panel: a line through all points in order, in eight parts of increasing darkness.
fn draw(out: &mut impl Write, title: &str, left: f64, points: &[[f64; 2]]) -> io::Result<()> {
    let centre = left + MARGIN + SIZE;
    let baseline = MARGIN - 8.0;
    writeln!(
        out,
        r##"<text x="{centre}" y="{baseline}" text-anchor="middle" font-family="sans-serif" font-size="15" fill="#1B2430">{title}</text>"##
    )?;
    let colours =
        ["#9ECAE1", "#6BAED6", "#4292C6", "#2171B5", "#0072B2", "#08519C", "#08306B", "#041C40"];
    let part = points.len().div_ceil(colours.len());
    for (k, colour) in colours.iter().enumerate() {
        // A part begins where the previous one ended.
        let from = (k * part).saturating_sub(1);
        let line: Vec<String> = points[from..points.len().min((k + 1) * part)]
            .iter()
            .map(|[x, y]| {
                format!("{:.1},{:.1}", centre + SIZE * x, 2.0 * MARGIN + SIZE * (1.0 - y))
            })
            .collect();
        writeln!(
            out,
            r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="1.6"/>"#,
            line.join(" ")
        )?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let lattice = Lattice::<2>::ball_lattice(1.0, 0.09)?;
    let mut store = ParticleStore::<2>::new(lattice.len());
    let position = store.add("position", lattice.points)?;

    let mut out = io::stdout().lock();
    let (width, height) = (4.0 * (SIZE + MARGIN), 2.0 * SIZE + 3.0 * MARGIN);
    writeln!(
        out,
        r#"<svg width="{width}" height="{height}" role="img" aria-label="Particles in the order of memory, by rows and by Morton order" xmlns="http://www.w3.org/2000/svg">"#
    )?;
    writeln!(out, r##"<rect width="100%" height="100%" fill="#FFFFFF"/>"##)?;
    draw(&mut out, "as the lattice was laid", 0.0, store.get(position)?)?;
    let order = morton_order(store.get(position)?)?;
    store.permute(&order)?;
    draw(&mut out, "permuted by morton_order", 0.5 * width, store.get(position)?)?;
    writeln!(out, "</svg>")?;
    Ok(())
}
