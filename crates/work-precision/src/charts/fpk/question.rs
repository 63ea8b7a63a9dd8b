//! What is asked of all methods: second moments, probabilities at three levels, and surfaces of probabilities.

use result_figures::Reference;
use scenes::fpk::density::{Demand, Requested};

use crate::problems::exceedance_surface::{ExceedanceSurface, SMALLEST};

/// Levels of the probabilities.
pub(super) const LEVELS: [(&str, f64); 3] = [("tail-3", 1e-3), ("tail-6", 1e-6), ("tail-9", 1e-9)];

/// One quantity: both moments, or the probabilities of some times and thresholds, of which the worst counts.
#[derive(Debug, Clone)]
pub(super) struct Quantity {
    pub(super) name: &'static str,
    pub(super) title: String,
    /// Relative error of its reference.
    pub(super) reference_error: f64,
    /// Indices of time and threshold with the reference; none for moments.
    pub(super) cells: Vec<((usize, usize), Reference)>,
    /// Probability below which a cell needs no guide.
    pub(super) smallest: f64,
}

/// What one run of a method may answer: moments at the only time, probabilities at times and thresholds.
pub(super) struct Question<const D: usize> {
    /// `E[q^2]` and `E[q'^2]`, or none.
    pub(super) moments: Vec<([u32; D], Reference)>,
    pub(super) times: Vec<f64>,
    pub(super) thresholds: Vec<f64>,
    /// Steps of a path from one time to the next.
    pub(super) steps_each: usize,
    pub(super) quantities: Vec<Quantity>,
}

impl<const D: usize> Question<D> {
    /// Second moments at a time, and a probability at the threshold of each of [`LEVELS`].
    pub(super) fn moments_and_tails(
        time: f64,
        n_steps: usize,
        moments: [([u32; D], Reference); 2],
        targets: &[(f64, Reference)],
    ) -> Self {
        let mut quantities = vec![Quantity {
            name: "moments",
            title: "Second moments: the worse of E[q^2] and E[q'^2]".into(),
            reference_error: moments.iter().map(|(_, r)| relative_error(r)).fold(0.0, f64::max),
            cells: Vec::new(),
            smallest: 0.0,
        }];
        for (k, ((name, _), (threshold, reference))) in LEVELS.iter().zip(targets).enumerate() {
            quantities.push(Quantity {
                name,
                title: format!("Probability P(|q| > {threshold:.3}) = {:.1e}", reference.value),
                reference_error: relative_error(reference),
                cells: vec![((0, k), *reference)],
                smallest: 0.0,
            });
        }
        Self {
            moments: moments.to_vec(),
            times: vec![time],
            thresholds: targets.iter().map(|(threshold, _)| *threshold).collect(),
            steps_each: n_steps,
            quantities,
        }
    }

    /// The whole surface `P(|q| > T)` over time and threshold: one quantity, whose error is the worst of all cells.
    pub(super) fn surface(surface: ExceedanceSurface, steps_each: usize) -> Self {
        let cells: Vec<_> = surface.cells().collect();
        let quantity = Quantity {
            name: "surface",
            title: format!(
                "Surface P(|q| > T) at {} times and {} thresholds: the worst of its {} cells above {SMALLEST:.0e}",
                surface.times.len(),
                surface.thresholds.len(),
                cells.len()
            ),
            reference_error: surface.relative_error(),
            cells,
            smallest: SMALLEST,
        };
        let ExceedanceSurface { times, thresholds, .. } = surface;
        Self { moments: Vec::new(), times, thresholds, steps_each, quantities: vec![quantity] }
    }

    pub(super) fn asked(&self, cells: bool) -> Requested<D> {
        Requested {
            times: self.times.clone(),
            powers: self.moments.iter().map(|(powers, _)| *powers).collect(),
            demand: Demand::of_state(0, "q", D),
            thresholds: self.thresholds.clone(),
            kinks: Vec::new(),
            cells,
        }
    }

    /// Last time and its number of steps.
    pub(super) fn span(&self) -> (f64, usize) {
        let last = self.times.last().copied().unwrap_or_default();
        (last, self.times.len() * self.steps_each)
    }
}

fn relative_error(reference: &Reference) -> f64 {
    reference.error.unwrap_or(0.0) / reference.value
}
