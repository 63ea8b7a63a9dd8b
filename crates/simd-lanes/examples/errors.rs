//! Prints the errors of `exp`, `ln`, `sin` and `cos` as the picture on the page of the crate.
//!
//! `cargo run -p lanes --example errors > docs/pictures/lanes-errors.svg`

#![allow(clippy::print_stdout, reason = "an example prints")]

#[path = "../tests/shared/reference.rs"]
mod reference;

use std::f64::consts::FRAC_PI_4;

use reference::{Double, reference_exp, reference_ln, reference_sin_cos};
use simd_lanes::{exp, ln, sin_cos};

/// Intervals of the argument's range, and points in each.
const PARTS: u32 = 150;
const POINTS: u32 = 64;

/// Width and height of a panel (px), and the height of one unit in the last place.
const PANEL: (f64, f64) = (330.0, 150.0);
const UNIT: f64 = 100.0;

/// A function, its range and its error in units of the last place.
type Panel = (&'static str, [f64; 2], fn(f64) -> f64);

fn main() {
    let panels: [Panel; 4] = [
        ("exp x", [-20.0, 20.0], |x| reference_exp(Double(x, 0.0)).ulps(exp(x))),
        ("ln x", [0.1, 4.0], |x| reference_ln(x).ulps(ln(x))),
        ("sin x", [-FRAC_PI_4, FRAC_PI_4], |x| reference_sin_cos(x).0.ulps(sin_cos([x]).0[0])),
        ("cos x", [-FRAC_PI_4, FRAC_PI_4], |x| reference_sin_cos(x).1.ulps(sin_cos([x]).1[0])),
    ];
    println!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 720 400" font-family="sans-serif" font-size="13">"#
    );
    println!(r#"<rect width="720" height="400" fill="white"/>"#);
    println!(
        r#"<text x="20" y="22">Largest error in 150 parts of a range, units of the last place</text>"#
    );
    for (k, (name, [low, high], error)) in panels.into_iter().enumerate() {
        let (left, top) = (20.0 + (k % 2) as f64 * 350.0, 45.0 + (k / 2) as f64 * 180.0);
        let floor = top + PANEL.1 - 20.0;
        println!(
            r##"<path d="M{left} {:.0}h{}" stroke="#c33" stroke-dasharray="4"/>"##,
            floor - UNIT,
            PANEL.0
        );
        println!(
            r##"<path d="M{left} {:.0}h{}" stroke="#999" stroke-dasharray="2"/>"##,
            floor - 0.5 * UNIT,
            PANEL.0
        );
        println!(
            r#"<text x="{}" y="{:.0}" text-anchor="end">1</text>"#,
            left + PANEL.0,
            floor - UNIT - 3.0
        );
        println!(r#"<text x="{left}" y="{:.0}">{low:.4}</text>"#, floor + 15.0);
        println!(
            r#"<text x="{:.0}" y="{:.0}" text-anchor="middle">{name}</text>"#,
            left + 0.5 * PANEL.0,
            floor + 15.0
        );
        println!(
            r#"<text x="{}" y="{:.0}" text-anchor="end">{high:.4}</text>"#,
            left + PANEL.0,
            floor + 15.0
        );
        print!(r#"<path fill="none" stroke="black" d="M{left} {floor:.0}"#);
        for part in 0..PARTS {
            let at = |point| {
                let fraction = f64::from(part * POINTS + point) / f64::from(PARTS * POINTS);
                error(low + (high - low) * fraction)
            };
            // At zero the error of the sine is zero and the unit in the last place is undefined.
            let largest = (1..POINTS).map(at).fold(0.0, f64::max);
            let x = left + PANEL.0 * (f64::from(part) + 0.5) / f64::from(PARTS);
            print!("L{x:.1} {:.1}", floor - UNIT * largest);
        }
        println!(r#""/>"#);
    }
    println!("</svg>");
}
