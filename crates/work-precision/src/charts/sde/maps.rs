//! Stability maps: the largest stable step, by formula and as measured on a step of the code.

use result_figures::{Drawing, Line, ReferencePoint, ReferencePoints, Scale, TimeSeries, Words};
use sde_integrators::Sriw1;

use reference_problems::context::CaseError;
use reference_problems::sde::stability::{
    Formula, boundary, formula_boundary, measured_boundary, of,
};

/// Largest stable step over the noise strength: formula as a line, quadrature over a step as points.
pub(super) fn mean_square() -> Result<Drawing, CaseError> {
    let methods = [
        ("Euler-Maruyama", Formula::Theta(0.0)),
        ("Milstein", Formula::Milstein),
        ("Heun", Formula::Heun),
        ("theta = 0.25", Formula::Theta(0.25)),
    ];
    let line = |&(name, formula): &(&str, Formula)| Line {
        name: name.into(),
        points: (0..=98)
            .map(|k| 0.01 * f64::from(k))
            .map(|ray| (ray, formula_boundary(ray, formula)))
            .collect(),
    };
    let mut points = Vec::new();
    for (_, formula) in methods {
        for k in 0..=9 {
            let ray = 0.1 * f64::from(k) + 0.05;
            if let Some(y) = measured_boundary(ray, formula)? {
                points.push(ReferencePoint { x: ray, y, error: None });
            }
        }
    }
    let words = Words {
        title: "Mean-square stability on dX = l X dt + m X dB".into(),
        subtitle: "a method is stable below its line; theta >= 1/2 everywhere, the equation itself left of 1".into(),
        x_label: "m² / (2 |l|), noise against damping".into(),
        y_label: "largest stable |l| h".into(),
        caption: vec![
            "Lines: formulas (SRIW1: none known, so quadrature). Points: E|R|² = 1 by Gauss-Hermite quadrature over a step of the code and bisection (to 1e-10: no bar).".into(),
        ],
    };
    let references =
        vec![ReferencePoints { name: "measured, one step of the code".into(), points }];
    let mut lines: Vec<Line> = methods.iter().map(line).collect();
    let of_sriw1 = (0..=49)
        .map(|k| 0.02 * f64::from(k))
        .map(|ray| Ok((ray, boundary(ray, &of(&Sriw1))?)))
        .collect::<Result<_, CaseError>>()?;
    lines.push(Line { name: "SRIW1, by quadrature".into(), points: of_sriw1 });
    let chart = TimeSeries { words, scale: Scale::Log, lines, bands: Vec::new(), references };
    Ok(Drawing::time_series("sde-stability-mean-square", &chart)?)
}

/// Largest stable step of a linear oscillator over its damping ratio.
pub(super) fn oscillator() -> Result<Drawing, CaseError> {
    use crate::problems::oscillator_limits as limits;
    let ratio = |k: i32| 0.01 + 0.0245 * f64::from(k);
    let lines = limits::METHODS
        .iter()
        .map(|&(name, method)| Line {
            name: name.into(),
            points: (0..=40).map(|k| (ratio(k), Some(limits::formula(method, ratio(k))))).collect(),
        })
        .collect();
    let mut points = Vec::new();
    for &(_, method) in limits::METHODS {
        for k in 0..=10 {
            let x = ratio(4 * k);
            points.push(ReferencePoint { x, y: limits::measured(method, x)?, error: None });
        }
    }
    let words = Words {
        title: "Stability on the oscillator q'' + 2 ξ ω q' + ω² q = s W".into(),
        subtitle: "a method is stable below its line; Strang, trapezoidal and backward Euler everywhere".into(),
        x_label: "damping ratio ξ".into(),
        y_label: "largest stable h ω".into(),
        caption: vec![
            "Lines: formulas. Points: spectral radius of a step of the code, by bisection (to 1e-9: no bar).".into(),
        ],
    };
    let references =
        vec![ReferencePoints { name: "measured, one step of the code".into(), points }];
    let chart = TimeSeries { words, scale: Scale::Log, lines, bands: Vec::new(), references };
    Ok(Drawing::time_series("sde-stability-oscillator", &chart)?)
}
