//! The density integrated over the particles' deformed lattice cells.

use std::collections::{HashMap, HashSet};

use sde_integrators::Sde;

use crate::cloud::AxisNeighbours;
use crate::error::{Error, finite};
use crate::lattice::index_of_place;
use crate::metric::Whitening;
use crate::score::{LocalFit, LocalMap, determinant, lattice_jacobian};
use crate::simulation::Simulation;

/// The density as a function: around each particle `psi_i exp(g.u + u.H u / 2)` over the lattice cell as the flow has
/// deformed it, with the local fit of log density. The cells tile the cloud where the flow is affine over a spacing.
///
/// Cells at the rim go on outward by [`TAIL_SPACINGS`] spacings where the fit falls outward, so that the tail does not
/// end with the last particle. In a cell where the fit makes of the particle's mass less than half or more than twice,
/// the fit is not trusted beyond the cell: the cell holds its particle's own mass, with the shape of the fit.
#[derive(Debug)]
pub struct CellIntegral<const D: usize> {
    whitening: Whitening<D>,
    cells: Vec<Cell<D>>,
}

/// A probability of exceedance, with what it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Exceedance {
    /// `P(y > T)`.
    pub probability: f64,
    /// The part of it that lies beyond the outermost particles' own cells, by extrapolation of the fit.
    pub beyond_the_cloud: f64,
    /// The part of it that rests on cells that the estimator does not resolve: turned over, or far smaller than those
    /// around them.
    pub unresolved: f64,
    /// The part of it that rests on cells in which the fit is not trusted, with their particles' own masses.
    pub distrusted: f64,
}

/// Spacings by which a cell at the rim goes on outward. At 6 standard deviations and a spacing of 0.3, three of them
/// hold all but 0.4 % of what lies beyond.
pub const TAIL_SPACINGS: i32 = 3;

/// A cell's mass by the fit over its particle's mass, above which (or below its inverse) the fit is not trusted. A
/// Gaussian at 6 standard deviations and a spacing of 0.45 gives 1.34.
const MOST_MASS_RATIO: f64 = 2.0;

/// `y(u) = centre + E u + u.K u / 2` and the mass per unit of `u`, `weight exp(slope.u + u.bend u / 2)`, in lattice
/// coordinates `u` of the cell, from -1/2 to 1/2.
#[derive(Debug)]
struct Cell<const D: usize> {
    /// Centre in the metric.
    centre: [f64; D],
    map: LocalMap<D>,
    weight: f64,
    /// Places on the lattice beyond the cloud to which this cell goes on, as steps from it.
    beyond: Vec<[i32; D]>,
    /// Mass with what lies beyond.
    mass: f64,
    /// Whether the fit makes of the particle's mass what it should, within [`MOST_MASS_RATIO`].
    trusted: bool,
}

/// Subdivisions of a cell per axis: about a hundred points where the dimension allows.
const fn subdivisions(dimension: usize) -> usize {
    match dimension {
        1 => 64,
        2 => 12,
        3 => 5,
        4 => 3,
        _ => 2,
    }
}

impl<S: Sde<D, M>, const D: usize, const M: usize> Simulation<S, D, M> {
    /// The density as a function, from local fits at the present positions.
    ///
    /// # Errors
    /// Those of the local fits: too few neighbours, a singular covariance.
    pub fn cell_integral(&self) -> Result<CellIntegral<D>, Error> {
        let beyond = beyond_the_cloud(&self.field.lattice.places);
        let masses = self.masses();
        if let Some((stage, maps)) = self.local_maps()? {
            let cell = |(i, map): (usize, LocalMap<D>)| Cell {
                centre: stage.whitened[i],
                map,
                weight: masses[i],
                beyond: vec![],
                mass: 0.0,
                trusted: true,
            };
            let cells = maps.into_iter().enumerate().map(cell).collect();
            return Ok(CellIntegral::finish(stage.whitening, cells, beyond, None));
        }
        let (stage, fits) = self.local_fits()?;
        let cells = fits
            .iter()
            .enumerate()
            .map(|(i, fit)| {
                Cell::of_fit(&stage.whitened, &self.field.lattice.axis_neighbours, i, fit)
            })
            .collect::<Result<_, _>>()?;
        Ok(CellIntegral::finish(stage.whitening, cells, beyond, Some(masses)))
    }
}

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
    /// Holds every cell against its particle's mass, where it rests on a fit of the density, and lets those that are
    /// trusted go on beyond the cloud. A flow map needs no trust: its cell holds the mass that it held at the start.
    fn finish(
        whitening: Whitening<D>,
        mut cells: Vec<Cell<D>>,
        beyond: Vec<Vec<[i32; D]>>,
        masses: Option<&[f64]>,
    ) -> Self {
        for (i, (cell, beyond)) in cells.iter_mut().zip(beyond).enumerate() {
            let Some(particle_mass) = masses.map(|masses| masses[i]) else {
                cell.go_on(beyond);
                if !cell.integral().is_finite() {
                    // Masses so uneven that their fit overflows: the cell holds its own, evenly.
                    (cell.map.slope, cell.map.bend) = ([0.0; D], [[0.0; D]; D]);
                    cell.beyond.clear();
                }
                cell.mass = cell.integral();
                continue;
            };
            let ratio = cell.integral() / particle_mass;
            if (1.0 / MOST_MASS_RATIO..=MOST_MASS_RATIO).contains(&ratio) {
                cell.go_on(beyond);
                // As much beyond as within, or no number: the fit is level rather than falling.
                let with_beyond = cell.integral();
                if with_beyond.is_nan() || with_beyond > 2.0 * ratio * particle_mass {
                    cell.beyond.clear();
                }
            } else {
                cell.hold_own_mass(particle_mass, ratio);
            }
            cell.mass = cell.integral();
        }
        Self { whitening, cells }
    }

    /// The integral of the density: 1 but for what the lattice never held and for the error of the fits.
    pub fn total_mass(&self) -> f64 {
        self.cells.iter().map(|cell| cell.mass).sum()
    }

    /// How many cells hold their particle's own mass because the fit is not trusted there.
    pub fn n_distrusted(&self) -> usize {
        self.cells.iter().filter(|cell| !cell.trusted).count()
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
        finite("threshold", threshold)?;
        let mut exceedance = Exceedance {
            probability: 0.0,
            beyond_the_cloud: 0.0,
            unresolved: 0.0,
            distrusted: 0.0,
        };
        for cell in &self.cells {
            let before = exceedance.probability;
            let demand_at =
                |u: &[f64; D]| demand(&self.whitening.unwhiten(&cell.point(u))) - threshold;
            if cell.lies_below(demand_at) {
                continue;
            }
            cell.for_each_part(|u, mass| {
                let fraction = fraction_above(demand_at, u, &cell.slope_across_part(u));
                exceedance.probability += mass * fraction;
                if u.iter().any(|u_k| u_k.abs() > 0.5) {
                    exceedance.beyond_the_cloud += mass * fraction;
                }
            });
            let of_cell = exceedance.probability - before;
            if !cell.map.resolved {
                exceedance.unresolved += of_cell;
            }
            if !cell.trusted {
                exceedance.distrusted += of_cell;
            }
        }
        Ok(exceedance)
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

impl<const D: usize> Cell<D> {
    /// The cell as the flow has deformed it, with the quadratic of log density around its particle.
    fn of_fit(
        positions: &[[f64; D]],
        lattice: &[AxisNeighbours<D>],
        i: usize,
        fit: &LocalFit<D>,
    ) -> Result<Self, Error> {
        let edges =
            lattice_jacobian(positions, lattice, i).ok_or(Error::NoLatticeCell { particle: i })?;
        let (mut slope, mut bend) = ([0.0; D], [[0.0; D]; D]);
        for a in 0..D {
            slope[a] = (0..D).map(|k| fit.gradient[k] * edges[k][a]).sum();
            for b in 0..D {
                for k in 0..D {
                    bend[a][b] +=
                        (0..D).map(|l| edges[k][a] * fit.hessian[k][l] * edges[l][b]).sum::<f64>();
                }
            }
        }
        let weight = fit.log_density.exp() * determinant(&edges).abs();
        let curvature = [[[0.0; D]; D]; D];
        let map = LocalMap { edges, curvature, slope, bend, resolved: true };
        Ok(Self { centre: positions[i], map, weight, beyond: vec![], mass: 0.0, trusted: true })
    }

    /// The fit turns too sharply for this cell: keep its shape, but only the particle's own mass.
    fn hold_own_mass(&mut self, particle_mass: f64, ratio: f64) {
        self.trusted = false;
        if ratio.is_finite() && ratio > 0.0 {
            self.weight /= ratio;
        } else {
            self.weight = particle_mass;
            (self.map.slope, self.map.bend) = ([0.0; D], [[0.0; D]; D]);
        }
    }

    /// Takes in those places beyond the cloud towards which the mass falls. A cell that goes on has its map taken as
    /// affine: a curvature by neighbours on one side is no ground to go beyond them.
    fn go_on(&mut self, beyond: Vec<[i32; D]>) {
        if beyond.is_empty() {
            return;
        }
        self.map.curvature = [[[0.0; D]; D]; D];
        self.beyond = beyond;
        let LocalMap { slope, bend, .. } = self.map;
        self.beyond.retain(|step| {
            let (mut along, mut curvature) = (0.0, 0.0);
            for k in 0..D {
                along += slope[k] * f64::from(step[k]);
                for l in 0..D {
                    curvature += f64::from(step[k]) * bend[k][l] * f64::from(step[l]);
                }
            }
            curvature <= 0.0 && along + 0.5 * curvature < 0.0
        });
    }

    /// The point with the lattice coordinates `u` of the cell.
    fn point(&self, u: &[f64; D]) -> [f64; D] {
        let mut y = self.centre;
        for k in 0..D {
            for a in 0..D {
                y[k] += self.map.edges[k][a] * u[a];
                for b in 0..D {
                    y[k] += 0.5 * u[a] * self.map.curvature[k][a][b] * u[b];
                }
            }
        }
        y
    }

    /// `exp(slope.u + u.bend u / 2)` at the lattice coordinates `u`.
    fn shape(&self, u: &[f64; D]) -> f64 {
        let mut exponent = 0.0;
        for k in 0..D {
            exponent += self.map.slope[k] * u[k];
            for l in 0..D {
                exponent += 0.5 * u[k] * self.map.bend[k][l] * u[l];
            }
        }
        exponent.exp()
    }

    /// By how much the logarithm of the mass per unit of `u` grows across a part along each axis.
    fn slope_across_part(&self, u: &[f64; D]) -> [f64; D] {
        let LocalMap { slope, bend, .. } = &self.map;
        std::array::from_fn(|k| {
            (slope[k] + (0..D).map(|l| bend[k][l] * u[l]).sum::<f64>()) / subdivisions(D) as f64
        })
    }

    /// The mean of the mass per unit of `u` over a part, over its value at the centre: of `exp(slope s + bend s^2 / 2)` for
    /// `s` from -1/2 to 1/2 along each axis.
    fn mean_over_part(&self, u: &[f64; D]) -> f64 {
        let parts = subdivisions(D) as f64;
        let slope = self.slope_across_part(u);
        let along =
            |k: usize| sinhc(0.5 * slope[k]) * (self.map.bend[k][k] / (24.0 * parts * parts)).exp();
        (0..D).map(along).product()
    }

    fn integral(&self) -> f64 {
        let mut mass = 0.0;
        self.for_each_part(|_, part| mass += part);
        mass
    }

    /// Calls with the centre (lattice coordinates) and the mass of every part of the cell and of what lies beyond.
    fn for_each_part(&self, mut visit: impl FnMut(&[f64; D], f64)) {
        let parts = subdivisions(D);
        let part_weight = self.weight / (parts as f64).powi(i32::try_from(D).unwrap_or(0));
        for place in std::iter::once(&[0; D]).chain(&self.beyond) {
            let mut index = [0; D];
            'parts: loop {
                let u: [f64; D] = std::array::from_fn(|k| {
                    f64::from(place[k]) + (index[k] as f64 + 0.5) / parts as f64 - 0.5
                });
                visit(&u, part_weight * self.shape(&u) * self.mean_over_part(&u));
                // The next index, first axis fastest.
                for axis in 0..D {
                    index[axis] += 1;
                    if index[axis] < parts {
                        continue 'parts;
                    }
                    index[axis] = 0;
                }
                break;
            }
        }
    }

    /// Whether the demand is further from the threshold, at the centre of the cell and of each of those beyond, than twice
    /// what it varies from there to any corner: no part of them comes near.
    fn is_far(&self, demand_above_threshold: impl Fn(&[f64; D]) -> f64) -> bool {
        std::iter::once(&[0; D]).chain(&self.beyond).all(|place| {
            let centre = demand_above_threshold(&place.map(f64::from));
            let to_corner =
                |bits: usize| (demand_above_threshold(&corner(place, bits)) - centre).abs();
            let variation = (0..1 << D).map(to_corner).fold(0.0, f64::max);
            centre.abs() > 2.0 * variation
        })
    }

    /// Whether the demand stays below the threshold at the centre and at all corners of the cell and of what lies beyond.
    fn lies_below(&self, demand_above_threshold: impl Fn(&[f64; D]) -> f64) -> bool {
        demand_above_threshold(&[0.0; D]) <= 0.0
            && std::iter::once(&[0; D]).chain(&self.beyond).all(|place| {
                (0..1 << D).all(|bits| demand_above_threshold(&corner(place, bits)) <= 0.0)
            })
    }
}

/// A corner of the cell at a place on the lattice, by the bits of its number.
fn corner<const D: usize>(place: &[i32; D], bits: usize) -> [f64; D] {
    std::array::from_fn(|k| f64::from(place[k]) + if bits >> k & 1 == 0 { -0.5 } else { 0.5 })
}

/// The part of a part's mass where the demand exceeds the threshold: over the part the demand is taken as uniform with the
/// standard deviation that it has, `w/sqrt(12)`, and the logarithm of the density as linear in it, by `slope` across the
/// part along each axis.
fn fraction_above<const D: usize>(
    demand_above_threshold: impl Fn(&[f64; D]) -> f64,
    u: &[f64; D],
    slope: &[f64; D],
) -> f64 {
    let centre = demand_above_threshold(u);
    let across = across_part(demand_above_threshold, u);
    let width = across.iter().map(|a| a * a).sum::<f64>().sqrt();
    if centre.abs() >= 0.5 * width {
        return f64::from(u8::from(centre > 0.0));
    }
    // The density is exp(tilt s) for s from -1/2 to 1/2, and the demand exceeds where s > -centre/width.
    let tilt = (0..D).map(|k| slope[k] * across[k]).sum::<f64>() / width;
    let above = 0.5 + centre / width;
    exponential_share(tilt, above)
}

/// The share of the mass of `exp(tilt s)`, `s` from 0 to 1, that lies in the last part of length `above`.
fn exponential_share(tilt: f64, above: f64) -> f64 {
    if tilt.abs() < 1e-6 {
        above
    } else if tilt > 0.0 {
        (-tilt * above).exp_m1() / (-tilt).exp_m1()
    } else {
        // The same with a power that does not overflow.
        (tilt * (1.0 - above)).exp() * (tilt * above).exp_m1() / tilt.exp_m1()
    }
}

/// How much the demand varies across a part, were it linear there.
fn variation<const D: usize>(demand: impl Fn(&[f64; D]) -> f64, u: &[f64; D]) -> f64 {
    across_part(demand, u).iter().map(|a| a.abs()).sum()
}

/// By how much the demand grows across a part along each axis.
fn across_part<const D: usize>(demand: impl Fn(&[f64; D]) -> f64, u: &[f64; D]) -> [f64; D] {
    let half = 0.5 / subdivisions(D) as f64;
    std::array::from_fn(|axis| {
        let (mut below, mut above) = (*u, *u);
        below[axis] -= half;
        above[axis] += half;
        demand(&above) - demand(&below)
    })
}

/// `sinh(x)/x`.
fn sinhc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 + x * x / 6.0 } else { x.sinh() / x }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_of_an_exponential_is_right_on_both_sides_and_does_not_overflow() {
        for above in [0.1, 0.5, 0.9] {
            for tilt in [1e-7, 0.3, 4.0, 30.0] {
                let share = exponential_share(tilt, above);
                let rest = exponential_share(-tilt, 1.0 - above);
                // What lies above with one tilt lies below with the other.
                assert!((share + rest - 1.0).abs() < 1e-12, "{tilt} {above}: {share} {rest}");
            }
            assert!((exponential_share(1e4, above) - 1.0).abs() < 1e-12);
            let far = exponential_share(-1e4, above);
            assert!((0.0..1e-12).contains(&far), "{far}");
        }
    }
}
