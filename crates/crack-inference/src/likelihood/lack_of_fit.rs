//! How well quadratics follow what ensembles at the points of a design found.

use crate::likelihood::polynomial::{dot, terms};
use crate::likelihood::regressions::{Layout, Regressions};

/// Which number of the law of the summaries; summaries are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// The mean of a summary.
    Mean(usize),
    /// The slope of the first summary on the second, which comes before it, others before it being equal.
    Slope(usize, usize),
    /// The logarithm of the variance of a summary, given those before it.
    LogVariance(usize),
}

/// How well a quadratic polynomial does for one number of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComponentFit {
    /// Which number.
    pub component: Component,
    /// The sum of the squared residuals, each over the variance that its finite ensemble gives it. Near `degrees_of_freedom`, with
    /// a deviation of `sqrt(2 degrees_of_freedom)`, where the polynomial does; more with few realisations, whose own estimate of
    /// that variance scatters. Infinite where an ensemble has the variance zero.
    pub chi_square: f64,
    /// Points of the design less terms of the polynomial.
    pub degrees_of_freedom: usize,
    /// The root mean square of the residuals beyond what finite ensembles explain: of a mean, over the deviation of its summary; of
    /// a slope, as the change of the later summary, over its deviation given those before it, for a change of the earlier one by
    /// its own; of a logarithm of a variance, itself. A misfit `a` of a mean counts with `P` plates where `a sqrt(P)` is not small.
    pub misfit: f64,
}

/// For every number of the law, in their order: ensembles at the points of a design against polynomials with these coefficients.
pub(crate) fn lack_of_fit(
    layout: Layout,
    design: &[Vec<f64>],
    ensembles: &[Regressions],
    coefficients: &[Vec<f64>],
) -> Vec<ComponentFit> {
    let k = layout.n_summaries;
    let means = (0..k).map(Component::Mean);
    let slopes = (0..k).flat_map(|i| (0..i).map(move |j| Component::Slope(i, j)));
    let all = means.chain(slopes).chain((0..k).map(Component::LogVariance));
    let fit = |(number, component): (usize, Component)| {
        let polynomial = &coefficients[number];
        let residual = |(units, ensemble): (&Vec<f64>, &Regressions)| Residual {
            value: ensemble.numbers[number] - dot(polynomial, &terms(units)),
            variance: ensemble.covariance[number * (layout.len() + 1)],
            unit: unit(layout, &ensemble.numbers, component),
        };
        let residuals: Vec<_> = design.iter().zip(ensembles).map(residual).collect();
        component_fit(component, &residuals, polynomial.len())
    };
    all.enumerate().map(fit).collect()
}

/// What a point of the design is off by, the variance that its finite ensemble gives it, and what it is measured in.
struct Residual {
    value: f64,
    variance: f64,
    unit: f64,
}

fn unit(layout: Layout, numbers: &[f64], component: Component) -> f64 {
    let covariance = layout.covariance(numbers, &layout.mixing(numbers));
    let deviation = |i: usize| covariance[i * (layout.n_summaries + 1)].sqrt();
    let rest = |i: usize| simd_lanes::exp(0.5 * numbers[layout.log_variance(i)]);
    match component {
        Component::Mean(i) => deviation(i),
        Component::Slope(i, j) => rest(i) / deviation(j),
        Component::LogVariance(_) => 1.0,
    }
}

fn component_fit(component: Component, residuals: &[Residual], n_terms: usize) -> ComponentFit {
    let (mut chi_square, mut beyond) = (0.0, 0.0);
    let (n, degrees_of_freedom) = (residuals.len() as f64, residuals.len() - n_terms);
    let share = degrees_of_freedom as f64 / n;
    for &Residual { value, variance, unit } in residuals {
        // An ensemble of two values may say that it has no error at all.
        chi_square += if variance > 0.0 { value * value / variance } else { f64::INFINITY };
        beyond += (value * value - share * variance) / (unit * unit) / n;
    }
    let misfit = beyond.max(0.0).sqrt();
    ComponentFit { component, chi_square, degrees_of_freedom, misfit }
}
