//! The log density between and beyond the particles.

use neighbour_search::{LeafTree, Near};
use particle_store::Lattice;
use smoothing_kernels::{Kernel, Lucy};

use crate::cloud::lattice::{ParticleLattice, index_of_place};
use crate::error::Error;
use crate::method::remapping::BEYOND_THE_CLOUD;
use crate::score::{LeastSquares, Monomials, lattice_jacobian, solve};

/// The departure of the log density from that of the cloud's Gaussian, `log psi + |y|^2 / 2`, at any place in whitened
/// coordinates.
///
/// * Within the cloud, on the lattice: `X` with `y(X) = place` by Newton's iteration, `y(X)` and the
///   departure by moving least squares over the particles around `X` (Lancaster & Salkauskas 1981). On the lattice the
///   particles are evenly spaced, however the flow has sheared them.
/// * Beyond it is extrapolated linearly from the nearest particles, by their own gradients.
#[derive(Debug)]
pub(super) struct Departure<'a, const D: usize> {
    lattice: &'a ParticleLattice<D>,
    y: &'a [[f64; D]],
    values: Vec<f64>,
    gradients: Vec<[f64; D]>,
    tree: LeafTree<D>,
    at: Grid<D>,
    /// Steps to all places that may lie within the reach of a point whose nearest place is the origin.
    steps: Vec<[i32; D]>,
}

/// What is known of the departure at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Found {
    /// The place lies within the cloud.
    Within(f64),
    /// It lies beyond, but not far.
    Beyond(f64),
    /// Nothing is known there.
    Nothing,
}

/// The particle at each lattice position.
#[derive(Debug)]
struct Grid<const D: usize> {
    low: [i32; D],
    size: [usize; D],
    ids: Vec<u32>,
}

/// Position at a point of the lattice with its derivatives there, per spacing, and the weights that interpolate other values.
struct Fit<const D: usize> {
    y: [f64; D],
    edges: [[f64; D]; D],
    members: Vec<usize>,
    /// Of each member in a value, then in its derivatives over the reach.
    weights: Vec<Vec<f64>>,
}

impl<const D: usize> Fit<D> {
    /// A value of the particles a step beyond the point, to first order.
    fn value_at(&self, step: &[f64; D], of: impl Fn(usize) -> f64) -> f64 {
        let reach = degree_and_reach(D).1;
        let (mut value, mut slope) = (0.0, [0.0; D]);
        for (p, &j) in self.members.iter().enumerate() {
            let of_member = of(j);
            value += self.weights[0][p] * of_member;
            for l in 0..D {
                slope[l] += self.weights[1 + l][p] / reach * of_member;
            }
        }
        value + slope.iter().zip(step).map(|(g, c)| g * c).sum::<f64>()
    }
}

const NOBODY: u32 = u32::MAX;

/// Degree of the moving least squares and their reach in spacings: about 2.5 places per unknown.
const fn degree_and_reach(dimension: usize) -> (usize, f64) {
    match dimension {
        1 => (4, 6.0),
        2 => (4, 3.6),
        3 => (4, 3.0),
        4 => (3, 2.5),
        _ => (2, 2.3),
    }
}

/// Places per unknown below which the degree is lowered.
const PLACES_PER_UNKNOWN: f64 = 2.5;
/// What is left of the way to the place, in spacings, where the departure is taken as linear.
const NEAR_ENOUGH: f64 = 1e-3;
/// Newton's iteration takes three; what takes longer lies in a fold.
const MOST_ITERATIONS: usize = 12;

impl<'a, const D: usize> Departure<'a, D> {
    /// From particles at `y` with their density and score, all in whitened coordinates.
    pub(super) fn new(
        lattice: &'a ParticleLattice<D>,
        y: &'a [[f64; D]],
        density: &[f64],
        score: &[[f64; D]],
    ) -> Result<Self, Error> {
        let mut tree = LeafTree::new();
        tree.build(y, lattice.spacing)?;
        let half_square = |y: &[f64; D]| 0.5 * y.iter().map(|c| c * c).sum::<f64>();
        let values = density.iter().zip(y).map(|(psi, y)| psi.ln() + half_square(y)).collect();
        let add = |(s, y): (&[f64; D], &[f64; D])| std::array::from_fn(|k| s[k] + y[k]);
        let gradients = score.iter().zip(y).map(add).collect();
        let at = Grid::new(&lattice.places);
        Ok(Self { lattice, y, values, gradients, tree, at, steps: steps::<D>()? })
    }

    /// The departure at a place.
    pub(super) fn at(&self, place: &[f64; D]) -> Found {
        let mut nearest = Vec::new();
        if self.tree.nearest(place, 2 * D + 2, &mut nearest).is_err() {
            return Found::Nothing;
        }
        let Some(first) = nearest.first() else { return Found::Nothing };
        match self.within(place, first.j) {
            Some((fit, step)) => Found::Within(fit.value_at(&step, |j| self.values[j])),
            None if first.r < BEYOND_THE_CLOUD * self.spacing() => {
                Found::Beyond(self.beyond(&nearest))
            }
            None => Found::Nothing,
        }
    }

    /// What particles carry, `n` numbers each, at a place: beyond the cloud that of the nearest particle.
    pub(super) fn carried(
        &self,
        place: &[f64; D],
        of_particles: &[f64],
        n: usize,
        out: &mut [f64],
    ) {
        let mut nearest = Vec::new();
        let _ = self.tree.nearest(place, 1, &mut nearest);
        let Some(first) = nearest.first() else { return };
        let within = self.within(place, first.j);
        for (k, out) in out.iter_mut().take(n).enumerate() {
            let of = |j: usize| of_particles[j * n + k];
            *out = within.as_ref().map_or(of(first.j), |(fit, step)| fit.value_at(step, of));
        }
    }

    /// The spacing of the lattice.
    pub(super) fn spacing(&self) -> f64 {
        self.lattice.spacing
    }

    /// The places of a lattice of that spacing nearest to the particles.
    pub(super) fn indices(&self) -> impl Iterator<Item = [i32; D]> {
        self.y.iter().map(|y| index_of_place(&y.map(|c| c / self.lattice.spacing)))
    }

    /// The lattice around the place, and the step that is left to it; none where the place lies beyond the lattice or cannot be
    /// found on it.
    fn within(&self, place: &[f64; D], nearest: usize) -> Option<(Fit<D>, [f64; D])> {
        let edges = lattice_jacobian(self.y, &self.lattice.axis_neighbours, nearest)?;
        let mut x = self.lattice.places[nearest];
        let mut step = solve(&edges, &difference(place, &self.y[nearest]));
        for _ in 0..MOST_ITERATIONS {
            let length = step.iter().map(|c| c * c).sum::<f64>().sqrt();
            if !length.is_finite() {
                return None;
            }
            // A step of more than two cells leaves what the edges know.
            let part = if length > 2.0 { 2.0 / length } else { 1.0 };
            for k in 0..D {
                x[k] += part * step[k];
            }
            let fit = self.fit(&x)?;
            step = solve(&fit.edges, &difference(place, &fit.y));
            if step.iter().all(|c| c.abs() < NEAR_ENOUGH) {
                return Some((fit, step));
            }
        }
        None
    }

    /// Moving least squares at a point of the lattice.
    fn fit(&self, x: &[f64; D]) -> Option<Fit<D>> {
        let centre = index_of_place(x);
        self.at.of(&centre)?;
        let (degree, reach) = degree_and_reach(D);
        let (mut members, mut points) =
            (Vec::with_capacity(self.steps.len()), Vec::with_capacity(self.steps.len()));
        for step in &self.steps {
            let index: [i32; D] = std::array::from_fn(|k| centre[k] + step[k]);
            let u: [f64; D] = std::array::from_fn(|k| (f64::from(index[k]) - x[k]) / reach);
            let square: f64 = u.iter().map(|c| c * c).sum();
            if square >= 1.0 {
                continue;
            }
            if let Some(j) = self.at.of(&index) {
                let support = <Lucy as Kernel<D>>::support(&Lucy);
                members.push(j);
                points.push((u, <Lucy as Kernel<D>>::shape(&Lucy, square.sqrt() * support)));
            }
        }
        let tables = Monomials::carried_by::<D>(members.len(), degree, PLACES_PER_UNKNOWN)?;
        let weights = LeastSquares::new(tables, &points).0.weights(&points, 1 + D);
        let (mut y, mut edges) = ([0.0; D], [[0.0; D]; D]);
        for (p, &j) in members.iter().enumerate() {
            let of_member = &self.y[j];
            let weight = weights[0][p];
            for k in 0..D {
                y[k] += weight * of_member[k];
            }
            for l in 0..D {
                let weight = weights[1 + l][p] / reach;
                for k in 0..D {
                    edges[k][l] += weight * of_member[k];
                }
            }
        }
        Some(Fit { y, edges, members, weights })
    }

    /// The mean of what the nearest particles make of the place, each linearly.
    fn beyond(&self, nearest: &[Near<D>]) -> f64 {
        // A particle at the place itself has no infinite weight.
        let floor = 0.01 * self.spacing().powi(2);
        let (mut value, mut total) = (0.0, 0.0);
        for near in nearest {
            let weight = 1.0 / (near.r.powi(2) + floor).powi(2);
            let along: f64 =
                near.x_ij.iter().zip(&self.gradients[near.j]).map(|(x, g)| x * g).sum();
            value += weight * (self.values[near.j] + along);
            total += weight;
        }
        value / total
    }
}

/// `a - b`.
fn difference<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| a[k] - b[k])
}

impl<const D: usize> Grid<D> {
    fn new(places: &[[f64; D]]) -> Self {
        let (mut low, mut high) = ([i32::MAX; D], [i32::MIN; D]);
        let indices: Vec<[i32; D]> = places.iter().map(index_of_place).collect();
        for index in &indices {
            for k in 0..D {
                low[k] = low[k].min(index[k]);
                high[k] = high[k].max(index[k]);
            }
        }
        let size = std::array::from_fn(|k| (high[k] - low[k]).unsigned_abs() as usize + 1);
        let mut grid = Self { low, size, ids: vec![NOBODY; size.iter().product()] };
        for (id, index) in (0..).zip(&indices) {
            if let Some(at) = grid.offset(index) {
                grid.ids[at] = id;
            }
        }
        grid
    }

    fn offset(&self, index: &[i32; D]) -> Option<usize> {
        let (mut offset, mut stride) = (0, 1);
        for k in 0..D {
            let along = usize::try_from(index[k] - self.low[k]).ok()?;
            if along >= self.size[k] {
                return None;
            }
            offset += stride * along;
            stride *= self.size[k];
        }
        Some(offset)
    }

    fn of(&self, index: &[i32; D]) -> Option<usize> {
        let id = self.ids[self.offset(index)?];
        (id != NOBODY).then_some(id as usize)
    }
}

/// Steps to all places that may lie within the reach of a point whose nearest place is the origin.
fn steps<const D: usize>() -> Result<Vec<[i32; D]>, Error> {
    let most = degree_and_reach(D).1 + 0.5 * (D as f64).sqrt();
    Ok(Lattice::<D>::ball_lattice(most, 1.0)?.indices)
}
