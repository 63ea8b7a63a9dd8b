//! The design point of a rare event.

use sde_integrators::normal_probability;

use crate::error::{Error, require_finite};
use crate::tails::normal_model::{ModelRuns, NormalModel, gradient_at, value_at};

/// The point of the event that is nearest to the origin, in standard normals.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct TailPoint {
    /// The point $u^\ast$.
    pub normals: Vec<f64>,
    /// Reliability index $\beta = \lvert u^\ast \rvert$.
    pub reliability_index: f64,
    /// Derivative of the response along the direction of the point, in its unit for each standard deviation.
    pub slope: f64,
    /// Number of steps of the optimiser.
    pub steps: usize,
    /// What it cost.
    pub runs: ModelRuns,
}

impl TailPoint {
    /// $\Phi(-\beta)$: the probability for a response linear in the normals, an estimate without error for others.
    #[must_use]
    pub fn first_order_probability(&self) -> f64 {
        normal_probability(-self.reliability_index)
    }

    /// Unit vector from the origin to the point.
    pub(crate) fn direction(&self) -> Vec<f64> {
        let length = dot(&self.normals, &self.normals).sqrt();
        self.normals.iter().map(|u| u / length).collect()
    }
}

/// Largest distance to the surface by the linearised response, and largest part of the point across the gradient over its
/// length: the relative error of the reliability index is then of the order of 1e-4 and of its square.
const DISTANCE: f64 = 1e-4;
const MISALIGNMENT: f64 = 1e-2;

const MOST_STEPS: usize = 100;
const MOST_HALVINGS: i32 = 30;

/// Part of the predicted decrease of the merit function that a step must reach.
const SUFFICIENT: f64 = 0.1;

/// A point of the optimiser, with `G(u) = level - g(u)`.
struct Iterate {
    u: Vec<f64>,
    surface: f64,
    gradient: Vec<f64>,
    gradient_square: f64,
}

impl Iterate {
    fn new(
        (model, level): (&dyn NormalModel, f64),
        step: usize,
        u: Vec<f64>,
        runs: &mut ModelRuns,
    ) -> Result<Self, Error> {
        let mut gradient = vec![0.0; u.len()];
        let (value, cost) = gradient_at(model, (TASK, step as u64), &u, &mut gradient)?;
        *runs += cost;
        for slope in &mut gradient {
            *slope = -*slope;
        }
        let gradient_square = dot(&gradient, &gradient);
        Ok(Self { u, surface: level - value, gradient, gradient_square })
    }

    /// Distance to the surface by the linearised response.
    fn distance(&self) -> f64 {
        self.surface.abs() / self.gradient_square.sqrt()
    }

    /// Distance from the origin to the linearised surface; negative where it has the origin beyond it.
    fn index(&self) -> f64 {
        (self.surface - dot(&self.gradient, &self.u)) / self.gradient_square.sqrt()
    }

    /// Length of the part of the point across the gradient, over that of the point, at least one.
    fn misalignment(&self) -> f64 {
        let along = dot(&self.u, &self.gradient) / self.gradient_square;
        let across: f64 =
            self.u.iter().zip(&self.gradient).map(|(u, g)| (u - along * g).powi(2)).sum();
        across.sqrt() / dot(&self.u, &self.u).sqrt().max(1.0)
    }
}

const TASK: &str = "the search for the design point";

pub(crate) fn find(
    (model, level): (&dyn NormalModel, f64),
    start: &[f64],
) -> Result<TailPoint, Error> {
    require_finite("level", 0, level)?;
    for (index, &u) in start.iter().enumerate() {
        require_finite("normal of the start", index, u)?;
    }
    let mut runs = ModelRuns { values: 1, gradients: 0 };
    let origin = value_at(model, (TASK, 0), &vec![0.0; start.len()])?;
    if origin > level {
        return Err(Error::NotRare { value: origin, level });
    }
    let mut at = Iterate::new((model, level), 0, start.to_vec(), &mut runs)?;
    let mut penalty = 0.0;
    for steps in 0..=MOST_STEPS {
        let not_found = |at: &Iterate| Error::NoDesignPoint {
            steps,
            reliability_index: dot(&at.u, &at.u).sqrt(),
            distance: at.distance(),
            misalignment: at.misalignment(),
        };
        if !(at.gradient_square.is_finite() && at.gradient_square > 0.0) {
            return Err(not_found(&at));
        }
        // A point on the far side of the surface, as where the level is that of the origin, has no direction.
        if at.distance() <= DISTANCE && at.misalignment() <= MISALIGNMENT && at.index() > 0.0 {
            return Ok(finished(&at, steps, runs));
        }
        if steps == MOST_STEPS {
            return Err(not_found(&at));
        }
        let target = step((model, level), &at, &mut penalty, (steps, &mut runs))?;
        match target {
            Some(u) => at = Iterate::new((model, level), steps + 1, u, &mut runs)?,
            None => return Err(not_found(&at)),
        }
    }
    unreachable!("the last step of the loop returns")
}

/// One step: the first halving along the direction of Hasofer, Lind, Rackwitz and Fiessler that lowers the merit function
/// enough; none if no halving does.
fn step(
    (model, level): (&dyn NormalModel, f64),
    at: &Iterate,
    penalty: &mut f64,
    (number, runs): (usize, &mut ModelRuns),
) -> Result<Option<Vec<f64>>, Error> {
    let factor = (dot(&at.gradient, &at.u) - at.surface) / at.gradient_square;
    let goal: Vec<f64> = at.gradient.iter().map(|g| factor * g).collect();
    let (square, goal_square) = (dot(&at.u, &at.u), dot(&goal, &goal));
    // Above |u| / |grad G| the direction descends; far from the surface the second keeps the full step acceptable.
    let mut least = (square / at.gradient_square).sqrt();
    if at.distance() > DISTANCE {
        least = least.max(0.5 * goal_square / at.surface.abs());
    }
    *penalty = penalty.max(2.0 * least);
    let merit = |square: f64, surface: f64| 0.5 * square + *penalty * surface.abs();
    let before = merit(square, at.surface);
    // Along the direction G falls at the rate of its value.
    let slope = dot(&at.u, &goal) - square - *penalty * at.surface.abs();
    for halvings in 0..=MOST_HALVINGS {
        let length = 0.5_f64.powi(halvings);
        let u: Vec<f64> = at.u.iter().zip(&goal).map(|(u, v)| u + length * (v - u)).collect();
        let surface = level - value_at(model, (TASK, number as u64), &u)?;
        runs.values += 1;
        if merit(dot(&u, &u), surface) - before <= SUFFICIENT * length * slope {
            return Ok(Some(u));
        }
    }
    Ok(None)
}

/// The point on the axis of the gradient, where the linearised response meets the level.
fn finished(at: &Iterate, steps: usize, runs: ModelRuns) -> TailPoint {
    let (length, reliability_index) = (at.gradient_square.sqrt(), at.index());
    let normals = at.gradient.iter().map(|g| -reliability_index * g / length).collect();
    TailPoint { normals, reliability_index, slope: length, steps, runs }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
