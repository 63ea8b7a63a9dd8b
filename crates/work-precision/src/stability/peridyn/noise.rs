//! Strength over noise: fraction of bonds of an unloaded plate that break.

use peridyn_sde::Scheme;
use result_figures::{Drawing, Line, ReferencePoint, ReferencePoints, Scale, TimeSeries, Words};

use crate::draw::ChartKind;
use crate::stability::axes::linear;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::peridyn::background::{
    BondNoise, LANES, MOST_DEVIATIONS, broken, noise_of_bonds, temperature,
};
use reference_problems::peridyn::first_passage::rate;
use reference_problems::peridyn::network::Network;

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-noise",
    title: "bonds of a plate in noise that break without load, over s0/sigma and time",
    draw,
};

const STRENGTH: f64 = 0.01;
/// In units of the stiffest mode; the bond failure rate of Heun's method is within 2 % there.
const Z: f64 = 0.2;

/// First-passage rate over a level, from a table of its smooth ratio to `(1 + b) e^(-b^2/2)`.
struct Rates {
    ratios: Vec<f64>,
}

impl Rates {
    const FROM: f64 = 0.5;
    const STEP: f64 = 0.125;

    fn new() -> Self {
        let n = (MOST_DEVIATIONS - Self::FROM) / Self::STEP;
        let levels = std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(|&k| k <= n);
        let ratio = |k: f64| {
            let b = Self::FROM + Self::STEP * k;
            rate(b) / Self::scale(b)
        };
        Self { ratios: levels.map(ratio).collect() }
    }

    fn scale(b: f64) -> f64 {
        (1.0 + b) * (-0.5 * b * b).exp()
    }

    fn at(&self, b: f64) -> f64 {
        let place = ((b - Self::FROM) / Self::STEP).clamp(0.0, self.ratios.len() as f64 - 1.001);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a place in the table"
        )]
        let below = place as usize;
        let part = place - below as f64;
        Self::scale(b) * ((1.0 - part) * self.ratios[below] + part * self.ratios[below + 1])
    }
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let is_quick = context.profile == Profile::Quick;
    let network = Network::square(16, 3)?;
    let n_bonds = network.bonds.len() as f64;
    let times: &[f64] = if is_quick { &[20.0, 100.0] } else { &[20.0, 200.0, 2000.0] };
    let ratios = linear(if is_quick { 4 } else { 10 }, 3.0, 12.0);
    let rates = Rates::new();
    let mut points = vec![Vec::new(); times.len()];
    let (mut rows, mut lambda) = (Vec::new(), 1.0);
    let of_bonds = noise_of_bonds(&network)?;
    let predicted = |ratio: f64, time: f64| {
        let kt = temperature(&network, STRENGTH, ratio);
        let share = |of: &BondNoise| -(-of.rate(kt, STRENGTH, |b| rates.at(b)) * time).exp_m1();
        of_bonds.iter().map(share).sum::<f64>() / n_bonds
    };
    for &ratio in &ratios {
        context.progress(&format!("s0/sigma = {ratio}"));
        let (lost, found) = broken(&network, (STRENGTH, ratio), (Z, times), Scheme::Heun)?;
        lambda = found;
        let mut row = vec![format!("  s0/sigma {ratio:4.1}")];
        for ((points, lost), time) in points.iter_mut().zip(lost).zip(times) {
            let (share, error) = mean(&lost.map(|lost| lost / n_bonds));
            let expected = predicted(ratio, time / lambda);
            points.push(ReferencePoint { x: ratio, y: share, error: Some(error) });
            row.push(format!(
                "t = {time:4}: {share:9.2e} +- {error:.0e}, predicted {expected:9.2e}"
            ));
        }
        rows.push(row.join(" | "));
    }
    let (mut lines, mut references) = (Vec::new(), Vec::new());
    for (mut points, time) in points.into_iter().zip(times) {
        let mut line = Vec::new();
        for ratio in linear(if is_quick { 10 } else { 46 }, 3.0, 12.0) {
            line.push((ratio, Some(predicted(ratio, time / lambda))));
        }
        // A fraction below one bond of all lanes is not observable.
        line.retain(|&(_, share)| share.is_some_and(|p| p * n_bonds * LANES as f64 > 1e-3));
        points.retain(|point| point.y > 0.0);
        lines.push(Line { name: format!("predicted after {time}/λ"), points: line });
        references.push(ReferencePoints { name: format!("after {time}/λ"), points });
    }
    let drawing = Drawing::time_series("peridyn-noise", &picture(lines, references, n_bonds))?;
    Ok(vec![Drawing { table: rows.join("\n"), ..drawing }])
}

/// Mean of the lanes and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, (square / (n - 1.0) / n).sqrt())
}

fn picture(lines: Vec<Line>, references: Vec<ReferencePoints>, n_bonds: f64) -> TimeSeries {
    TimeSeries {
        words: Words {
            title: "Below s₀/σ = 7 noise alone breaks the plate; from 8 on it does not show".into(),
            subtitle: "plate of 16 x 16 nodes, three shells, held along one edge, no load; Heun with the bridge, z = 0.2; time in 1/λ of the stiffest mode".into(),
            x_label: "strength over noise, s₀/σ, with σ² = kT dof / (bonds κ)".into(),
            y_label: "share of the bonds that broke".into(),
            caption: vec![format!(
                "Points: mean and standard error of {LANES} realisations of {n_bonds} bonds, none where not one bond broke. Lines: each bond a killed Ornstein-Uhlenbeck path of its own variance and diffusion, as if no other had broken."
            )],
        },
        scale: Scale::Log,
        lines,
        bands: Vec::new(),
        references,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error of linear interpolation of a ratio with unit relative change: an eighth of the squared step, 2e-3.
    #[test]
    fn the_table_of_rates_is_that_of_the_eigenvalue() {
        let rates = Rates::new();
        for b in [1.03, 2.71, 5.55, 8.9] {
            assert!((rates.at(b) / rate(b) - 1.0).abs() < 2e-3, "{b}");
        }
    }
}
