//! Probabilities of rare events of many standard normals.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use sde_integrators::{Accumulator, Estimate, Noise, Purpose, SubsetConfig};

use crate::error::{Error, require_at_least, require_finite, require_positive};
use crate::parallel::map_in_order;
use crate::rates::with_error;
use crate::tails::line_crossing::{ROOT_ERROR, crossing, several_crossings};
use crate::tails::normal_model::{ModelRuns, NormalModel, failed, value_at};
use crate::tails::tail_design_point::{TailPoint, find};

/// `P(g(z) > level)` of a response of independent standard normals, from one to thousands of them.
///
/// [`design_point`](Self::design_point), then [`line_sampling`](Self::line_sampling). Every line is parallel to the direction
/// $a$ of the design point, through a random point $z_\perp$ of the plane across it. With the place $s_k$ from which on the response
/// along line $k$ exceeds the level,
///
/// $$ \hat p = \frac1n \sum_k \Phi(-s_k), \qquad g(z_{\perp, k} + s_k a) = \text{level} . $$
///
/// Where lines cross the level more than once, $\Phi(-s_k)$ gives way to the sum of the probabilities of all intervals above it.
///
/// The weights depend on how much $s_k$ varies, not on the number of normals; those of a normal density about the design
/// point become uneven where the surface is curved in many directions.
/// Use [`subset`](Self::subset) as a check without a gradient, and where no direction is important.
///
/// Sources: Koutsourelakis, Pradlwarter and Schueller 2004, Reliability of structures in high dimensions, part I; Hohenbichler
/// and Rackwitz 1988, Improvement of second-order reliability estimates by importance sampling.
///
/// ```
/// use uq_estimators::{Failure, NormalModel, TailSampling};
///
/// /// `g = z_1 + 0.01 (z_2^2 + ... + z_n^2)`.
/// struct Parabola(usize);
/// impl NormalModel for Parabola {
///     fn n_normals(&self) -> usize {
///         self.0
///     }
///     fn value(&self, z: &[f64]) -> Result<f64, Failure> {
///         Ok(z[0] + 0.01 * z[1..].iter().map(|z| z * z).sum::<f64>())
///     }
/// }
/// let tail = TailSampling { model: &Parabola(10), level: 4.0, seed: 1 };
/// let point = tail.design_point()?;
/// assert!((point.reliability_index - 4.0).abs() < 1e-3);
/// let found = tail.line_sampling(&point, 200)?;
/// // Exact within the squares of 0.01: Phi(-4 + 0.09).
/// assert!((found.probability.value / 4.6e-5 - 1.0).abs() < 0.05);
/// # Ok::<(), uq_estimators::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct TailSampling<'a> {
    /// The response.
    pub model: &'a dyn NormalModel,
    /// The level whose exceedance is the event, in the unit of the response.
    pub level: f64,
    /// Seed of the samples.
    pub seed: u64,
}

impl std::fmt::Debug for TailSampling<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TailSampling")
            .field("n_normals", &self.model.n_normals())
            .field("level", &self.level)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}

/// Probability of a rare event.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct TailEstimate {
    /// The probability, with its standard error.
    pub probability: Estimate,
    /// Effective number of lines, $(\sum p)^2 / \sum p^2$ with the probability `p` of each; of runs for subset simulation.
    pub effective_lines: f64,
    /// Lines on which the event is not everything beyond one crossing, by all their crossings; where there is one among the lines
    /// checked all lines are searched.
    pub n_several: u64,
    /// What it cost, without the design point.
    pub runs: ModelRuns,
}

/// Every so many lines one is checked.
const CHECKED: u64 = 8;

/// Fewest lines.
const FEWEST_LINES: u64 = 64;

/// Fewest effective lines, and largest share of one line in the sum, for which the standard error is trusted.
const FEWEST_EFFECTIVE: f64 = 20.0;
const LARGEST_SHARE: f64 = 0.25;

/// How far beyond the design point lines are followed: what is farther has a probability below `e^-32` of the first-order one.
const BEYOND: f64 = 8.0;

/// Distance of the places at which a line is checked, and of those at which every line is searched, in standard deviations.
const CHECK_STEP: f64 = 1.0;
const SEARCH_STEP: f64 = 0.5;

/// Result of a line.
struct Line {
    /// Probability of the event on it.
    probability: f64,
    /// Whether the event is not everything beyond one crossing, as far as was looked.
    is_several: bool,
    values: u64,
}

impl TailSampling<'_> {
    /// The design point: the point of the event nearest to the origin, searched from there.
    ///
    /// Steps go in the direction of Hasofer, Lind, Rackwitz and Fiessler, halved until the merit function
    /// $\tfrac12 \lvert u \rvert^2 + c \lvert g(u) - \text{level} \rvert$ falls enough. The search ends at a distance of at most
    /// 1e-4 standard deviations to the linearised surface, with at most 0.01 of the point across the gradient. Each step takes a
    /// gradient and a value or more.
    ///
    /// It finds one local minimum. For others use [`design_point_from`](Self::design_point_from).
    ///
    /// Source: Zhang and Der Kiureghian 1995, Two improved algorithms for reliability analysis, section 3.
    ///
    /// # Errors
    /// [`Error::TooFew`] for a model without normals; [`Error::NotFinite`] for the level; [`Error::NotRare`] for a level below the
    /// response at the origin; [`Error::NoDesignPoint`] with what was reached; [`Error::SampleFailed`],
    /// [`Error::NonFiniteSample`], where the sample is the number of the step.
    pub fn design_point(&self) -> Result<TailPoint, Error> {
        self.design_point_from(&vec![0.0; self.model.n_normals()])
    }

    /// The same from another start, where the gradient vanishes at the origin or there are several design points.
    ///
    /// # Errors
    /// As [`design_point`](Self::design_point); [`Error::Length`].
    pub fn design_point_from(&self, start: &[f64]) -> Result<TailPoint, Error> {
        require_at_least("normals", self.model.n_normals() as u64, 1)?;
        require_length(start.len(), self.model.n_normals())?;
        find((self.model, self.level), start)
    }

    /// The probability by so many lines, at least 64.
    ///
    /// A line costs about four values, one for a linear response. Every eighth line is checked at places one standard deviation
    /// apart, from a random one on, on both sides of the origin. Where one of these shows another crossing all lines are searched for
    /// crossings at half that distance, some fifty values a line. An event on the line narrower than that, away from the first
    /// crossing, may not be seen, nor one that hardly any line meets: compare with [`subset`](Self::subset) where another design point
    /// may exist in another direction.
    ///
    /// The standard error is that of the lines, with 1e-4 of the probability for the roots. Its square is
    /// enlarged by the factor one plus 20 over the effective number of lines, since probabilities of lines are skewed and
    /// few of them underestimate their scatter; the 20 was measured on paraboloids. With the feature `rayon` lines run in
    /// parallel on the current pool; the result is bitwise identical for any number of threads.
    ///
    /// # Errors
    /// [`Error::TooFew`] for the lines, [`Error::NotFinite`] for the level or the point, [`Error::NotPositive`] for its index or
    /// slope, [`Error::Length`] for a point of another model; [`Error::UnevenWeights`]; [`Error::SampleFailed`],
    /// [`Error::NonFiniteSample`] for the lowest such line.
    pub fn line_sampling(&self, point: &TailPoint, n_lines: u64) -> Result<TailEstimate, Error> {
        require_finite("level", 0, self.level)?;
        require_at_least("lines", n_lines, FEWEST_LINES)?;
        require_at_least("normals", self.model.n_normals() as u64, 1)?;
        require_length(point.normals.len(), self.model.n_normals())?;
        for (index, &u) in point.normals.iter().enumerate() {
            require_finite("normal of the design point", index, u)?;
        }
        require_positive("reliability index", 0, point.reliability_index)?;
        require_positive("slope at the design point", 0, point.slope)?;
        let direction = point.direction();
        // NaN for the origin, which has no direction.
        require_finite("direction", 0, direction[0])?;
        let numbers: Vec<u64> = (0..n_lines).collect();
        let check = |number: u64| number.is_multiple_of(CHECKED).then_some(CHECK_STEP);
        let lines =
            map_in_order(&numbers, |&number| self.line(point, &direction, number, check(number)));
        let mut lines: Vec<Line> = lines.into_iter().collect::<Result<_, _>>()?;
        let mut runs = ModelRuns { values: lines.iter().map(|it| it.values).sum(), gradients: 0 };
        if lines.iter().any(|line| line.is_several) {
            let search = |&number: &u64| self.line(point, &direction, number, Some(SEARCH_STEP));
            lines = map_in_order(&numbers, search).into_iter().collect::<Result<_, _>>()?;
            runs.values += lines.iter().map(|it| it.values).sum::<u64>();
        }
        let n_several = lines.iter().filter(|line| line.is_several).count() as u64;
        let (mut all, mut squares, mut largest) = (Accumulator::default(), 0.0, 0.0_f64);
        for Line { probability: p, .. } in lines {
            all.push(p);
            squares += p * p;
            largest = largest.max(p);
        }
        let (n, sum) = (n_lines as f64, all.mean() * n_lines as f64);
        let (effective, share) =
            if sum > 0.0 { (sum * sum / squares, largest / sum) } else { (0.0, 0.0) };
        if effective < FEWEST_EFFECTIVE || share > LARGEST_SHARE {
            let (fewest, most) = (FEWEST_EFFECTIVE, LARGEST_SHARE);
            return Err(Error::UnevenWeights { n_lines, effective, fewest, share, most });
        }
        let (value, variance) = (all.mean(), all.variance().unwrap_or(f64::INFINITY) / n);
        let skewed = 1.0 + FEWEST_EFFECTIVE / effective;
        let standard_error = (variance * skewed + (ROOT_ERROR * value).powi(2)).sqrt();
        let probability = with_error(value, standard_error);
        Ok(TailEstimate { probability, effective_lines: effective, n_several, runs })
    }

    /// A line, searched for further crossings at this distance of places, if any.
    fn line(
        &self,
        point: &TailPoint,
        direction: &[f64],
        number: u64,
        step: Option<f64>,
    ) -> Result<Line, Error> {
        let mut stream = Noise::new(self.seed).stream(Purpose::Field, number);
        let mut base = vec![0.0; direction.len()];
        stream.fill_normal(&mut base);
        let along: f64 = base.iter().zip(direction).map(|(z, a)| z * a).sum();
        base.iter_mut().zip(direction).for_each(|(z, a)| *z -= along * a);
        let (mut place, mut values) = (vec![0.0; base.len()], 0);
        let mut excess = |s: f64| -> Result<f64, Error> {
            for ((x, z), a) in place.iter_mut().zip(&base).zip(direction) {
                *x = z + s * a;
            }
            values += 1;
            Ok(value_at(self.model, ("line sampling", number), &place)? - self.level)
        };
        let far = point.reliability_index + BEYOND;
        let found = crossing((point.reliability_index, point.slope, far), &mut excess)?;
        let (mut probability, mut is_several) = (found.probability(), false);
        if let Some(step) = step {
            let from = (step * stream.next_uniform() - far, step);
            let several = several_crossings(found, from, far, &mut excess)?;
            is_several = several.is_some();
            probability = several.unwrap_or(probability);
        }
        Ok(Line { probability, is_several, values })
    }

    /// The probability by subset simulation, [`sde_integrators::subset_simulation`], which needs no gradient and no design
    /// point. The standard error is from the scatter of the runs; `effective_lines` is their number.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the level; [`Error::SampleFailed`], [`Error::NonFiniteSample`] for a run;
    /// [`Error::Subset`] for the configuration, or a level that is not reached.
    pub fn subset(&self, config: &SubsetConfig) -> Result<TailEstimate, Error> {
        require_finite("level", 0, self.level)?;
        let (values, failure) = (AtomicU64::new(0), Mutex::new(None));
        let response = |normals: &[f64]| {
            let number = values.fetch_add(1, Ordering::Relaxed);
            let value = self.model.value(normals).unwrap_or_else(|error| {
                let mut first = failure.lock().unwrap_or_else(PoisonError::into_inner);
                let _ = first.get_or_insert_with(|| failed("subset simulation", number, &error));
                f64::NAN
            });
            // NaN ends the run.
            Ok(value)
        };
        let n_normals = self.model.n_normals();
        let found = sde_integrators::subset_simulation(
            &response,
            n_normals,
            self.level,
            &Noise::new(self.seed),
            config,
        );
        if let Some(error) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        Ok(TailEstimate {
            probability: found.map_err(Error::Subset)?,
            effective_lines: config.n_runs as f64,
            n_several: 0,
            runs: ModelRuns { values: values.into_inner(), gradients: 0 },
        })
    }
}

fn require_length(value: usize, expected: usize) -> Result<(), Error> {
    if value == expected {
        Ok(())
    } else {
        Err(Error::Length { quantity: "normals of the point", value, expected })
    }
}
