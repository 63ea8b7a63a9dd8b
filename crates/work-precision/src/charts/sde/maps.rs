//! Stability maps: the largest stable step, by formula and as measured on a step of the code.

use result_figures::{Drawing, Line, ReferencePoint, ReferencePoints, Scale, TimeSeries, Words};
use sde_integrators::{
    EulerMaruyama, Heun, Integrator, SemiImplicitEuler, Shark, Sriw1, StateSpace,
};

use reference_problems::context::CaseError;
use reference_problems::sde::linear::probe;
use reference_problems::sde::problems::Oscillator;
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

/// The largest stable `h omega` of an oscillator with a damping ratio `xi < 1`.
type Limit = fn(f64) -> Result<f64, CaseError>;

/// Methods with a limit on an oscillator: name, limit by formula, limit of the code.
const LIMITED: [(&str, Limit, Limit); 4] = [
    ("Euler-Maruyama", |xi| Ok(2.0 * xi), |xi| of_code(xi, &EulerMaruyama)),
    (
        "semi-implicit Euler",
        |xi| Ok(2.0 * (f64::hypot(1.0, xi) - xi)),
        |xi| of_code(xi, &SemiImplicitEuler),
    ),
    ("Heun", explicit_second_order, |xi| of_code(xi, &Heun)),
    ("ShARK", explicit_second_order, |xi| of_code(xi, &Shark)),
];

/// The spectral radius of a step is 1.
fn of_code<I>(xi: f64, method: &I) -> Result<f64, CaseError>
where
    I: Integrator<StateSpace<Oscillator>, 2, 1>,
{
    largest_stable(|angle| {
        let system = Oscillator { frequency: 2.0, damping_ratio: xi, intensity: 0.7 };
        let nothing = |_: &[f64; 2], _: &I::Memory| [0.0; 0];
        let (map, _) = probe(&StateSpace(system), method, angle / system.frequency, nothing)?;
        Ok(map.spectral_radius())
    })
}

/// `|1 + z + z^2/2| = 1` at the eigenvalue `z = h omega (-xi + i sqrt(1 - xi^2))` of the oscillator.
fn explicit_second_order(xi: f64) -> Result<f64, CaseError> {
    largest_stable(|angle| {
        let (x, y) = (-xi * angle, (1.0 - xi * xi).max(0.0).sqrt() * angle);
        Ok(f64::hypot(1.0 + x + 0.5 * (x * x - y * y), y + x * y))
    })
}

/// The first angle at which a factor exceeds 1, sought in steps of 2 % and bisected.
fn largest_stable(amplification: impl Fn(f64) -> Result<f64, CaseError>) -> Result<f64, CaseError> {
    let mut above = 1e-3;
    while amplification(above)? <= 1.0 {
        above *= 1.02;
        if above > 1e3 {
            return Err("no limit of stability below h omega = 1000".into());
        }
    }
    let mut below = above / 1.02;
    for _ in 0..60 {
        let middle = 0.5 * (below + above);
        if amplification(middle)? <= 1.0 { below = middle } else { above = middle }
    }
    Ok(below)
}

/// Largest stable step of a linear oscillator over its damping ratio.
pub(super) fn oscillator() -> Result<Drawing, CaseError> {
    let ratio = |k: i32| 0.01 + 0.0245 * f64::from(k);
    let (mut lines, mut points) = (Vec::new(), Vec::new());
    for (name, formula, of_code) in LIMITED {
        let on_line = |k: i32| Ok((ratio(k), Some(formula(ratio(k))?)));
        let line = (0..=40).map(on_line).collect::<Result<_, CaseError>>()?;
        lines.push(Line { name: name.into(), points: line });
        for x in (0..=10).map(|k| ratio(4 * k)) {
            points.push(ReferencePoint { x, y: of_code(x)?, error: None });
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
