//! Step size of a damage law with memory: exact step of the crate and explicit Euler step.

use peridyn_sde::BondLaw;
use result_figures::{Curve, CurvePoint, Curves, Drawing, Scale, Threshold, Words};

use crate::context::{CaseError, Context, Profile};
use crate::draw::ChartKind;
use crate::problems::peridyn::memory::{Wear, stepped};
use crate::stability::axes::logarithmic;

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-damage",
    title: "the step of damage with memory: where Euler's rule turns negative, and the error of both",
    draw,
};

/// Exponents `n` and `m`, with the `z` beyond which some initial value turns negative.
const EXPONENTS: [((f64, f64), f64); 5] = [
    ((1.0, 1.0), 1.0),
    ((1.0, 2.0), 1.0),
    ((2.0, 1.0), 4.0),
    ((2.0, 2.0), 6.75),
    ((0.5, 1.0), 0.0),
];

/// The remaining stiffness of a bond became negative.
#[derive(Debug, thiserror::Error)]
#[error("step {step}: what is left of the bond is {alpha}")]
struct Negative {
    step: u32,
    alpha: f64,
}

/// Euler steps, as a baseline.
fn euler(
    wear: &Wear,
    stretch: impl Fn(f64) -> f64,
    until: f64,
    steps: u32,
) -> Result<f64, Negative> {
    let (dt, mut alpha) = (until / f64::from(steps), wear.start);
    for step in 0..steps {
        alpha += dt * wear.slope(stretch(dt * f64::from(step)), alpha);
        if alpha < 0.0 {
            return Err(Negative { step: step + 1, alpha });
        }
    }
    Ok(alpha)
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    Ok(vec![negative(is_quick)?, error(is_quick)?])
}

/// Fraction of initial values for which Euler's rule turns negative at constant stretch, over `z = h lambda e^(k s)`.
fn negative(is_quick: bool) -> Result<Drawing, CaseError> {
    let zs = logarithmic(if is_quick { 30 } else { 90 }, 0.05, 40.0);
    let n_starts = if is_quick { 99 } else { 499 };
    let steps = 200;
    let (mut series, mut rows) = (Vec::new(), Vec::new());
    for (look, ((n, m), boundary)) in EXPONENTS.into_iter().enumerate() {
        let (mut least_seen, mut worst) = (f64::INFINITY, f64::INFINITY);
        let mut line = Vec::new();
        for &z in &zs {
            let mut count = 0.0;
            for k in 1..=n_starts {
                let start = f64::from(k) / f64::from(n_starts + 1);
                let wear = Wear { sensitivity: 0.0, rate: z, n, m, start };
                if euler(&wear, |_| 0.0, f64::from(steps), steps).is_err() {
                    count += 1.0;
                    least_seen = least_seen.min(z);
                }
            }
            // Remainder after one step of the crate.
            for start in [1e-3, 0.5, 0.999] {
                let law = Wear { sensitivity: 0.0, rate: z, n, m, start }.law()?;
                let mut exposure = 0.0;
                law.advance(1.0, 0.0, 0.0, 1.0, &mut exposure);
                worst = worst.min(law.left(exposure));
            }
            line.push((z, 100.0 * count / f64::from(n_starts)));
        }
        rows.push(format!(
            "  n = {n}, m = {m}: negative from z = {least_seen:.3} on, boundary {boundary}; the least that the exact step leaves is {worst:.1e}"
        ));
        series.push(Curve::line(format!("Euler, n = {n}, m = {m}"), look, line));
    }
    let chart = Curves {
        words: Words {
            title: "Euler's rule leaves less than nothing of a bond beyond z = 1, 4 or 6.75".into(),
            subtitle: format!("dα/dt = -λ exp(k s) αⁿ (1 - α)ᵐ at constant stretch, {steps} steps, {n_starts} starts α(0) between 0 and 1"),
            x_label: "z = h λ exp(k s)".into(),
            y_label: "starts from which α turned negative (%)".into(),
            caption: vec!["Boundary: the least of α^(1-n) (1 - α)^(-m) over α. For n = 1/2 it is zero: there the rule fails at any step. The exact step of the crate never left less than zero.".into()],
        },
        across: Scale::Log,
        upwards: Scale::Linear,
        series,
        thresholds: [("z = 1: n = 1", 1.0), ("z = 4: n = 2, m = 1", 4.0), ("z = 6.75: n = m = 2", 6.75)]
            .map(|(name, at)| Threshold::across(name, at))
            .into(),
    };
    Ok(Drawing { table: rows.join("\n"), ..Drawing::curves("peridyn-damage-negative", &chart)? })
}

/// Error under a stretch ramp, until half of the bond remains, over the number of steps.
fn error(is_quick: bool) -> Result<Drawing, CaseError> {
    let ramp = |t: f64| 1e-3 * t;
    let fine = if is_quick { 20_000 } else { 100_000 };
    let counts: &[u32] =
        if is_quick { &[1, 10, 100] } else { &[1, 2, 5, 10, 20, 40, 80, 160, 320, 640] };
    let (mut series, mut rows, mut own) = (Vec::new(), Vec::new(), 0.0_f64);
    // Until about half remains.
    let all = [((1.0, 1.0), 0.2266), ((2.0, 2.0), 0.3839), ((0.5, 1.0), 0.22)];
    for (look, ((n, m), until)) in all.into_iter().enumerate() {
        let wear = Wear { sensitivity: 2e4, rate: 1.0, n, m, start: 0.99 };
        let exact = wear.integrated(ramp, until, fine);
        own = own.max((exact - wear.integrated(ramp, until, fine / 2)).abs());
        let law = wear.law()?;
        let (mut by_euler, mut by_law) = (Vec::new(), Vec::new());
        for &count in counts {
            let x = f64::from(count);
            by_law.push(CurvePoint::at(x, (stepped(&law, ramp, until, count) - exact).abs()));
            by_euler.push(match euler(&wear, ramp, until, count) {
                Ok(alpha) => CurvePoint::at(x, (alpha - exact).abs()),
                Err(error) => CurvePoint::ended(x, error.to_string()),
            });
        }
        let worst = by_law.iter().filter_map(CurvePoint::value).fold(0.0, f64::max);
        let of_euler: Vec<String> = by_euler
            .iter()
            .map(|point| point.value().map_or("ended".into(), |error| format!("{error:.3}")))
            .collect();
        rows.push(format!(
            "  n = {n}, m = {m}: alpha {exact:.6}; exact step within {worst:.0e}; Euler {}",
            of_euler.join(" ")
        ));
        series.push(Curve::marked(format!("Euler, n = {n}, m = {m}"), look, by_euler));
        series.push(Curve::points(format!("exact step, n = {n}, m = {m}"), look, by_law));
    }
    let chart = Curves {
        words: Words {
            title: "One exact step is right where 640 of Euler's are 0.5 to 18 % off".into(),
            subtitle: "ramp of stretch of 0.001 a unit of time, k = 20,000, α(0) = 0.99, until about half is left".into(),
            x_label: "steps".into(),
            y_label: "error of α".into(),
            caption: vec![format!("Against {fine} steps of the classical Runge-Kutta method, whose half as many differ by {own:.0e} at most. The law is separable: one exposure for each bond, exact on straight lines of stretch.")],
        },
        across: Scale::Log,
        upwards: Scale::Log,
        series,
        thresholds: Vec::new(),
    };
    Ok(Drawing { table: rows.join("\n"), ..Drawing::curves("peridyn-damage-error", &chart)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boundaries_are_the_least_of_the_slope_over_what_is_left() {
        for ((n, m), boundary) in EXPONENTS {
            let of = |k: i32| {
                let alpha = 1e-6 + f64::from(k) / 3e5;
                alpha.powf(1.0 - n) * (1.0 - alpha).powf(-m)
            };
            let least = (0..299_999).map(of).fold(f64::INFINITY, f64::min);
            assert!((least - boundary).abs() < 2e-3, "{n} {m}: {least}");
        }
    }
}
