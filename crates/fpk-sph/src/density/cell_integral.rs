//! The density integrated over the particles' deformed lattice cells.

use std::collections::{HashMap, HashSet};

use super::cell::{Cell, Part, subdivisions, variation};
use super::probability::Probability;
use crate::cloud::lattice::index_of_place;
use crate::cloud::metric::Whitening;
use crate::error::{Error, finite};
use crate::score::LocalMap;
use crate::solver::Solver;
use crate::solver::evaluation::Evaluation;

/// The density as a function: around each particle the mass per lattice cell, over the cell as the flow has deformed it, by the
/// flow map of an estimator that follows it. The cells tile the cloud where the flow is affine over a spacing.
///
/// Cells at the rim go on outward by [`TAIL_SPACINGS`] spacings where the mass falls outward, so that the tail does not
/// end with the last particle.
#[derive(Debug)]
pub struct CellIntegral<const D: usize> {
    whitening: Whitening<D>,
    cells: Vec<Cell<D>>,
    mass_outside: f64,
}

/// An exceedance probability with its parts: [`probability`](Self::probability) names what it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Exceedance {
    estimate: f64,
    beyond_the_cloud: f64,
    unresolved: f64,
    outside: f64,
}

impl Exceedance {
    /// `P(y > T)` with what it rests on.
    pub fn probability(&self) -> Probability {
        Probability::of(self.estimate, self.unresolved, self.beyond_the_cloud, self.outside)
    }

    /// The part of it that lies beyond the outermost particles' own cells, by extrapolation of the fit.
    #[must_use]
    pub const fn beyond_the_cloud(&self) -> f64 {
        self.beyond_the_cloud
    }

    /// The part of it that rests on cells that the estimator does not resolve: turned over, or far smaller than those
    /// around them.
    #[must_use]
    pub const fn unresolved(&self) -> f64 {
        self.unresolved
    }

    /// What the lattice left outside ([`mass_outside`](crate::Simulation::mass_outside)); no part of the probability.
    #[must_use]
    pub const fn outside(&self) -> f64 {
        self.outside
    }

    /// Adds what lies above the threshold of a cell with all its parts.
    fn add<const D: usize>(&mut self, cell: &Cell<D>, parts: &[Part<D>], threshold: f64) {
        let before = self.estimate;
        for part in parts {
            let above = part.mass * part.fraction_above(threshold);
            self.estimate += above;
            if part.beyond {
                self.beyond_the_cloud += above;
            }
        }
        let of_cell = self.estimate - before;
        if !cell.map.resolved {
            self.unresolved += of_cell;
        }
    }
}

/// Spacings by which a cell at the rim goes on outward. At 6 standard deviations and a spacing of 0.3, three of them
/// hold all but 0.4 % of what lies beyond.
pub const TAIL_SPACINGS: i32 = 3;

/// Places on the lattice within [`TAIL_SPACINGS`] steps of the cloud but not in it, each as a step from the particle
/// nearest to it, the lowest where several are. The cells of the cloud and these tile the lattice without overlap.
fn beyond_the_cloud<const D: usize>(places: &[[f64; D]]) -> Vec<Vec<[i32; D]>> {
    let taken: HashSet<[i32; D]> = places.iter().map(index_of_place).collect();
    let mut nearest: HashMap<[i32; D], (i32, usize, [i32; D])> = HashMap::new();
    let steps = steps_beyond::<D>();
    for (i, place) in places.iter().enumerate() {
        let own = index_of_place(place);
        for step in &steps {
            let there = std::array::from_fn(|k| own[k] + step[k]);
            if taken.contains(&there) {
                continue;
            }
            let distance = step.iter().map(|k| k * k).sum();
            let entry = nearest.entry(there).or_insert((distance, i, *step));
            if (distance, i) < (entry.0, entry.1) {
                *entry = (distance, i, *step);
            }
        }
    }
    let mut beyond = vec![Vec::new(); places.len()];
    for (_, i, step) in nearest.into_values() {
        beyond[i].push(step);
    }
    // A hash map has no order of its own.
    for steps in &mut beyond {
        steps.sort_unstable();
    }
    beyond
}

/// Steps of at most [`TAIL_SPACINGS`] along each axis, the step of nothing left out.
fn steps_beyond<const D: usize>() -> Vec<[i32; D]> {
    let reach = TAIL_SPACINGS;
    let mut steps = vec![[0; D]];
    for axis in 0..D {
        steps = steps
            .into_iter()
            .flat_map(|step: [i32; D]| {
                (-reach..=reach).map(move |k| {
                    let mut step = step;
                    step[axis] = k;
                    step
                })
            })
            .collect();
    }
    steps.retain(|step| step.iter().any(|&k| k != 0));
    steps
}

impl<const D: usize> CellIntegral<D> {
    pub(crate) fn new(solver: &Solver<D>) -> Result<Self, Error> {
        let Solver { discretisation, state, .. } = solver;
        if discretisation.estimator.criterion().is_some() {
            return Err(Error::NoFlowMap);
        }
        let mut evaluation = Evaluation::new(solver.n_particles());
        evaluation.prepare(discretisation, state, state.stage())?;
        let cloud = evaluation.cloud;
        let view = cloud.view(discretisation, state, state.time);
        let maps = discretisation.estimator.local_maps(&view).ok_or(Error::NoFlowMap)?;
        let beyond = beyond_the_cloud(&discretisation.lattice.places);
        let cell = |((i, map), beyond): ((usize, LocalMap<D>), Vec<[i32; D]>)| {
            let (centre, weight) = (cloud.positions[i], state.masses[i]);
            let mut cell = Cell { centre, map, weight, beyond: vec![], mass: 0.0 };
            cell.go_on(beyond);
            if !cell.integral().is_finite() {
                // Masses so uneven that their fit overflows: the cell holds its own, evenly.
                (cell.map.slope, cell.map.bend) = ([0.0; D], [[0.0; D]; D]);
                cell.beyond.clear();
            }
            cell.mass = cell.integral();
            cell
        };
        let cells = maps.into_iter().enumerate().zip(beyond).map(cell).collect();
        Ok(Self { whitening: cloud.whitening, cells, mass_outside: solver.mass_outside() })
    }

    /// The integral of the density: 1 but for what the lattice never held and for the error of the fits.
    pub fn total_mass(&self) -> f64 {
        self.cells.iter().map(|cell| cell.mass).sum()
    }

    /// `P(y(x) > T)`. Cells that the limit crosses are subdivided; within a part the demand and the logarithm of the density
    /// are taken as linear.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the threshold.
    pub fn exceedance(
        &self,
        demand: impl Fn(&[f64; D]) -> f64,
        threshold: f64,
    ) -> Result<Exceedance, Error> {
        let mut exceedance = [self.none()];
        self.add_exceedances(&demand, &[threshold], &mut exceedance)?;
        Ok(exceedance[0])
    }

    /// `P(y(x) > T)` for each threshold, as by [`exceedance`](Self::exceedance), in one pass over the cells: the masses of
    /// their parts, which are most of the work, are computed once.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for a threshold.
    pub fn exceedances(
        &self,
        demand: impl Fn(&[f64; D]) -> f64,
        thresholds: &[f64],
    ) -> Result<Vec<Exceedance>, Error> {
        let mut exceedances = vec![self.none(); thresholds.len()];
        self.add_exceedances(&demand, thresholds, &mut exceedances)?;
        Ok(exceedances)
    }

    const fn none(&self) -> Exceedance {
        Exceedance {
            estimate: 0.0,
            beyond_the_cloud: 0.0,
            unresolved: 0.0,
            outside: self.mass_outside,
        }
    }

    fn add_exceedances(
        &self,
        demand: &dyn Fn(&[f64; D]) -> f64,
        thresholds: &[f64],
        exceedances: &mut [Exceedance],
    ) -> Result<(), Error> {
        for &threshold in thresholds {
            finite("threshold", threshold)?;
        }
        let mut parts = Vec::new();
        for cell in &self.cells {
            let demand = |u: &[f64; D]| demand(&self.whitening.unwhiten(&cell.point(u)));
            let greatest = cell.greatest(demand);
            parts.clear();
            for (exceedance, &threshold) in exceedances.iter_mut().zip(thresholds) {
                // A demand that is no number makes the probability none.
                if greatest <= threshold {
                    continue;
                }
                if parts.is_empty() {
                    cell.parts(demand, &mut parts);
                }
                exceedance.add(cell, &parts, threshold);
            }
        }
        Ok(())
    }

    /// The mean rate at which the demand crosses the threshold from below (per unit of time; Rice 1944),
    ///
    /// $$ \nu^+(T) = \int_{y(x) = T} \max(\dot y, 0) \frac{\psi}{|\nabla y|} dS = E\left[ \max(\dot y, 0) \delta(y - T) \right], $$
    ///
    /// with `rate(x)` the time derivative of the demand along a path. The demand must have one: for an oscillator whose
    /// noise acts on the velocity, the displacement has, the velocity has not. For the barrier `|q| > T` the demand is
    /// `|q|` and its rate `sign(q) v`.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the threshold.
    pub fn crossing_rate(
        &self,
        demand: impl Fn(&[f64; D]) -> f64,
        rate: impl Fn(&[f64; D]) -> f64,
        threshold: f64,
    ) -> Result<f64, Error> {
        finite("threshold", threshold)?;
        let mut crossing = 0.0;
        for cell in &self.cells {
            let at = |u: &[f64; D]| self.whitening.unwhiten(&cell.point(u));
            let demand_at = |u: &[f64; D]| demand(&at(u)) - threshold;
            if cell.is_far(demand_at) {
                continue;
            }
            cell.for_each_part(|u, mass| {
                // A hat over two parts: parts on either side of a limit that runs along their edge share it.
                let width = variation(demand_at, u);
                let distance = demand_at(u).abs();
                if distance < width {
                    // The hat has a width of its own: the density is that of the part's centre.
                    let mass = mass / cell.mean_over_part(u);
                    crossing += mass * rate(&at(u)).max(0.0) * (1.0 - distance / width) / width;
                }
            });
        }
        Ok(crossing)
    }

    /// The marginal density of one component, averaged over bins with the given edges: one value fewer than edges.
    ///
    /// # Errors
    /// [`Error::NoSuchComponent`], [`Error::BinEdges`].
    pub fn marginal(&self, component: usize, edges: &[f64]) -> Result<Vec<f64>, Error> {
        if component >= D {
            return Err(Error::NoSuchComponent { value: component, limit: D });
        }
        let (count, increasing) =
            (edges.len(), |w: &[f64]| w[1] > w[0] && w[1].is_finite() && w[0].is_finite());
        if let Some(position) = edges.windows(2).position(|w| !increasing(w)) {
            return Err(Error::BinEdges { count, position: position + 1 });
        }
        if count < 2 {
            return Err(Error::BinEdges { count, position: 0 });
        }
        let mut masses = vec![0.0; count - 1];
        for cell in &self.cells {
            let half_width = 0.5 * self.part_width(cell, component);
            cell.for_each_part(|u, mass| {
                let x = self.whitening.unwhiten(&cell.point(u))[component];
                spread(mass, x - half_width, x + half_width, edges, &mut masses);
            });
        }
        Ok(masses.iter().zip(edges.windows(2)).map(|(mass, w)| mass / (w[1] - w[0])).collect())
    }

    /// Extent of a part of the cell along a component of the state.
    fn part_width(&self, cell: &Cell<D>, component: usize) -> f64 {
        let origin = self.whitening.unwhiten(&[0.0; D])[component];
        let extent: f64 = (0..D)
            .map(|axis| {
                let edge = std::array::from_fn(|k| cell.map.edges[k][axis]);
                (self.whitening.unwhiten(&edge)[component] - origin).abs()
            })
            .sum();
        extent / subdivisions(D) as f64
    }
}

/// Adds a mass that is uniform from `from` to `to` to the bins it meets.
fn spread(mass: f64, from: f64, to: f64, edges: &[f64], masses: &mut [f64]) {
    let first = edges.partition_point(|&edge| edge <= from).saturating_sub(1);
    for bin in first..masses.len() {
        let (low, high) = (edges[bin], edges[bin + 1]);
        if low >= to {
            break;
        }
        let overlap = (to.min(high) - from.max(low)).max(0.0);
        masses[bin] += mass * overlap / (to - from);
    }
}
