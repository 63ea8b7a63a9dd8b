//! Diffusion of a scalar that particles carry, over the lattice that they started from.

use crate::cloud::AxisNeighbours;
use crate::error::Error;
use crate::score::{determinant, lattice_jacobian, solve_transposed};

/// What particles exchange of a scalar `w` that noise spreads between them,
///
/// $$ \mu_i \frac{dw_i}{dt} = \sum_j K_{ij} (w_j - w_i), \qquad K_{ij} = K_{ji} \ge 0, $$
///
/// in place of `Dw/Dt = div(psi D grad w) / psi`. It conserves `sum mu_i w_i`, and no `w_i` leaves the range of the others.
///
/// A column `g` of the noise is `b = F^-1 g` on the lattice, with `F` the edges of the deformed cell. With `s = |b|`, the
/// largest component, and `r` spacings,
///
/// $$ D : \nabla\nabla w \approx \frac{s^2}{2 r^2} \left( w(X + r b / s) - 2 w(X) + w(X - r b / s) \right), $$
///
/// `w` between lattice points by linear interpolation (Camilli & Falcone 1995), which adds diffusion: along
/// an axis of the lattice at most `1 / (4 r^2)` of that along the largest. The masses enter by their exponentially fitted mean (Scharfetter & Gummel 1969).
#[derive(Debug, Clone)]
pub(crate) struct LatticeExchange<const D: usize> {
    grid: PlaceGrid<D>,
    pub(crate) pairs: Vec<Pair>,
    pub(crate) moves: Vec<Move>,
    /// Whether the cell of a particle is turned over; empty before the first look.
    pub(crate) turned_over: Vec<bool>,
}

/// Two particles that exchange; a pair may occur more than once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    pub(crate) i: u32,
    pub(crate) j: u32,
    /// Its part of `K_ij` (probability per unit of time).
    pub(crate) conductance: f64,
    /// The demand where the noise takes particle `i` by the move that this pair is part of.
    pub(crate) demand: f64,
}

/// A move of a particle by noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Move {
    pub(crate) i: u32,
    /// `K` of the whole move (probability per unit of time).
    pub(crate) conductance: f64,
    /// The demand where it leads.
    pub(crate) demand: f64,
}

/// What the exchange is made for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene<'a, const D: usize> {
    pub(crate) positions: &'a [[f64; D]],
    pub(crate) masses: &'a [f64],
    pub(crate) lattice: &'a [AxisNeighbours<D>],
    /// Steps taken and time, for errors.
    pub(crate) at: (u64, f64),
}

/// Longest move in spacings. On the damper with 6,561 particles moves of 1, 2, 3 spacings give P of first passage at
/// three thresholds 0.7 to 3.4 % high, within 1.5 %, 0.7 to 2.7 % low.
const LONGEST_MOVE: i32 = 2;
/// A longer move must have less than this part of the diffusion across that a shorter one has.
const WORTH_A_LONGER_MOVE: f64 = 0.7;

impl<const D: usize> LatticeExchange<D> {
    /// An exchange over particles at the given places on their lattice, in spacings.
    pub(crate) fn new(places: &[[f64; D]]) -> Self {
        Self {
            grid: PlaceGrid::new(places),
            pairs: Vec::new(),
            moves: Vec::new(),
            turned_over: Vec::new(),
        }
    }

    /// The pairs that exchange where the particles are now, and their moves, with the columns of the noise, particle by
    /// particle, and the demand as a function.
    ///
    /// # Errors
    /// [`Error::NoLatticeCell`]; [`Error::LeftStableRange`] where a cell has no volume; [`Error::NotFinite`] for a demand.
    pub(crate) fn find(
        &mut self,
        scene: &Scene<'_, D>,
        noise: &[[f64; D]],
        demand: impl Fn(&[f64; D]) -> f64,
    ) -> Result<(), Error> {
        self.pairs.clear();
        self.moves.clear();
        self.turned_over.clear();
        let n_columns = noise.len() / scene.positions.len().max(1);
        for i in 0..scene.positions.len() {
            let edges = lattice_jacobian(scene.positions, scene.lattice, i)
                .ok_or(Error::NoLatticeCell { particle: i })?;
            self.turned_over.push(determinant(&edges) <= 0.0);
            for column in &noise[i * n_columns..(i + 1) * n_columns] {
                let Some(along) = Along::of_column(&edges, column, i, scene)? else { continue };
                for sign in [1, -1] {
                    let length = f64::from(sign) * along.time.sqrt();
                    let x = &scene.positions[i];
                    let value = demand(&std::array::from_fn(|k| x[k] + length * column[k]));
                    if !value.is_finite() {
                        return Err(Error::NotFinite { name: "demand", value });
                    }
                    self.add(scene.masses, i, &along, sign, value);
                }
            }
        }
        Ok(())
    }

    /// The move of particle `i` along one column of its noise or against it, to where the demand has this value.
    fn add(&mut self, masses: &[f64], i: usize, along: &Along<D>, sign: i32, demand: f64) {
        let own = self.grid.id(i);
        let mut whole = 0.0;
        for (corner, weight) in along.corners() {
            let j = self.grid.neighbour(i, &corner.map(|step| sign * step));
            let mean = fitted_mean(masses[i], masses[j.map_or(i, |j| j as usize)]);
            let conductance = weight * mean / (2.0 * along.time);
            whole += conductance;
            if let Some(j) = j.filter(|&j| j != own && conductance > 0.0) {
                // The other half comes from the moves of the other end.
                self.pairs.push(Pair { i: own, j, conductance: 0.5 * conductance, demand });
            }
        }
        if whole > 0.0 {
            self.moves.push(Move { i: own, conductance: whole, demand });
        }
    }
}

/// How one column of the noise goes over the lattice.
#[derive(Debug, Clone, Copy)]
struct Along<const D: usize> {
    /// Time in which the noise spreads by the length of the move: `r^2 / s^2`.
    time: f64,
    corners: [([i32; D], f64); MOST_CORNERS],
}

/// A simplex in six dimensions has seven corners.
const MOST_CORNERS: usize = 7;

impl<const D: usize> Along<D> {
    /// A column of the noise of particle `i`, whose cell has these edges; none where it is zero.
    fn of_column(
        edges: &[[f64; D]; D],
        column: &[f64; D],
        i: usize,
        scene: &Scene<'_, D>,
    ) -> Result<Option<Self>, Error> {
        if column.iter().all(|&value| value == 0.0) {
            return Ok(None);
        }
        let transposed = std::array::from_fn(|k| std::array::from_fn(|l| edges[l][k]));
        let b: [f64; D] = solve_transposed(&transposed, column);
        let size = b.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        if !size.is_finite() || b.iter().any(|value| value.is_nan()) {
            let ((step, time), quantity) = (scene.at, "cell volume");
            return Err(Error::LeftStableRange { step, time, particle: i, quantity, value: 0.0 });
        }
        Ok((size > 0.0).then(|| Self::of(&b, size)))
    }

    /// `b` on the lattice, per square root of time, and its largest component: of the moves up to the longest, the one
    /// that adds least across.
    fn of(b: &[f64; D], size: f64) -> Self {
        let (mut best, mut least) = (None, f64::INFINITY);
        for length in (1..=LONGEST_MOVE).map(f64::from) {
            let point = b.map(|value| value / size * length);
            let corners = corners(&point);
            let across: f64 = corners[..=D]
                .iter()
                .map(|(corner, weight)| {
                    let distance = |k: usize| {
                        (f64::from(corner[k]) - point[k]) * (f64::from(corner[k]) - point[k])
                    };
                    weight * (0..D).map(distance).sum::<f64>() / (length * length)
                })
                .sum();
            if best.is_none() || across < WORTH_A_LONGER_MOVE * least {
                least = across;
                best = Some(Self { time: (length / size) * (length / size), corners });
            }
        }
        best.unwrap_or(Self { time: f64::INFINITY, corners: [([0; D], 0.0); MOST_CORNERS] })
    }

    /// Corners that have a weight.
    fn corners(&self) -> impl Iterator<Item = &([i32; D], f64)> {
        self.corners[..=D].iter().filter(|(_, weight)| *weight > 0.0)
    }
}

/// The corners of the simplex (Kuhn 1960) of the lattice cell around a point, with weights by which the point is their
/// mean; the first `D + 1` count.
fn corners<const D: usize>(point: &[f64; D]) -> [([i32; D], f64); MOST_CORNERS] {
    #[allow(clippy::cast_possible_truncation, reason = "at most the longest move")]
    let mut corner = point.map(|value| value.floor() as i32);
    let part: [f64; D] = std::array::from_fn(|k| point[k] - f64::from(corner[k]));
    let mut order: [usize; D] = std::array::from_fn(|k| k);
    order.sort_by(|&a, &b| part[b].total_cmp(&part[a]));
    let mut corners = [([0; D], 0.0); MOST_CORNERS];
    corners[0] = (corner, 1.0 - part[order[0]]);
    for (at, &axis) in order.iter().enumerate() {
        corner[axis] += 1;
        let next = order.get(at + 1).map_or(0.0, |&next| part[next]);
        corners[at + 1] = (corner, part[axis] - next);
    }
    corners
}

/// The mean of two masses by which a constant flux between them is exact where the logarithm of the mass is linear
/// (Scharfetter & Gummel 1969): with `d = ln(b/a)/2`, `sqrt(a b) d / sinh d`. Zero where one of them is.
fn fitted_mean(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 {
        return 0.0;
    }
    let half = 0.5 * (b / a).ln();
    // d / sinh d = 1 - d^2/6 + O(d^4): 1e-8 here.
    let ratio = if half.abs() < 1e-2 { 1.0 - half * half / 6.0 } else { half / half.sinh() };
    (a * b).sqrt() * ratio
}

/// Particle at each lattice position, over the bounding box.
#[derive(Debug, Clone)]
struct PlaceGrid<const D: usize> {
    lowest: [i32; D],
    extent: [i32; D],
    /// The particle, or [`NOBODY`].
    at: Vec<u32>,
    places: Vec<[i32; D]>,
}

/// No particle has this id: a lattice of so many is refused.
const NOBODY: u32 = u32::MAX;

impl<const D: usize> PlaceGrid<D> {
    fn new(places: &[[f64; D]]) -> Self {
        #[allow(clippy::cast_possible_truncation, reason = "whole numbers well within the range")]
        let places: Vec<[i32; D]> =
            places.iter().map(|place| place.map(|value| value.round() as i32)).collect();
        let (mut lowest, mut highest) = ([i32::MAX; D], [i32::MIN; D]);
        for place in &places {
            for k in 0..D {
                lowest[k] = lowest[k].min(place[k]);
                highest[k] = highest[k].max(place[k]);
            }
        }
        let extent = std::array::from_fn(|k| highest[k] - lowest[k] + 1);
        let size = extent.iter().map(|&n: &i32| n.unsigned_abs() as usize).product();
        let mut grid = Self { lowest, extent, at: vec![NOBODY; size], places };
        for i in 0..grid.places.len() {
            if let Some(cell) = grid.cell(&grid.places[i]) {
                grid.at[cell] = grid.id(i);
            }
        }
        grid
    }

    /// A particle's id in the short form.
    #[allow(clippy::cast_possible_truncation, reason = "particles are counted by 32 bits")]
    fn id(&self, i: usize) -> u32 {
        debug_assert!(i < self.places.len());
        i as u32
    }

    fn cell(&self, place: &[i32; D]) -> Option<usize> {
        let mut cell = 0;
        for k in 0..D {
            let step = place[k] - self.lowest[k];
            if step < 0 || step >= self.extent[k] {
                return None;
            }
            cell = cell * self.extent[k].unsigned_abs() as usize + step.unsigned_abs() as usize;
        }
        Some(cell)
    }

    /// The particle at the offset `step` from particle `i`.
    fn neighbour(&self, i: usize, step: &[i32; D]) -> Option<u32> {
        let place = std::array::from_fn(|k| self.places[i][k] + step[k]);
        self.cell(&place).map(|cell| self.at[cell]).filter(|&j| j != NOBODY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_the_mean_of_the_corners_of_its_simplex() {
        for point in [[0.3, -1.7, 2.0], [1.0, 1.0, 1.0], [-0.2, 0.9, 0.9]] {
            let corners = corners(&point);
            let total: f64 = corners.iter().map(|(_, weight)| weight).sum();
            assert!((total - 1.0).abs() < 1e-15);
            for k in 0..3 {
                let mean: f64 = corners.iter().map(|(c, weight)| weight * f64::from(c[k])).sum();
                assert!((mean - point[k]).abs() < 1e-15, "{point:?}");
            }
            assert!(corners.iter().all(|(_, weight)| *weight >= 0.0));
        }
    }

    #[test]
    fn the_fitted_mean_carries_a_constant_flux() {
        // A flux J through a mass exp(s u) from u = 0 to 1 needs a difference of J int exp(-s u) du.
        for s in [1e-3_f64, 0.019, 0.021, 1.4, -3.0] {
            let needed = -(-s).exp_m1() / s;
            assert!((fitted_mean(1.0, s.exp()) * needed - 1.0).abs() < 1e-8, "{s}");
        }
        assert!(fitted_mean(0.0, 1.0) == 0.0);
    }

    /// Unit masses on a square lattice under the map `x = F X`, noise `g`: `L w` of `w = x^T H x / 2` is `g^T H g / 2`.
    #[test]
    fn the_exchange_is_the_operator_on_a_sheared_lattice() {
        let n = 15;
        let places: Vec<[f64; 2]> =
            (0..n * n).map(|p| [f64::from(p % n), f64::from(p / n)]).collect();
        let index = |x: i32, y: i32| {
            ((0..n).contains(&x) && (0..n).contains(&y)).then(|| (y * n + x).unsigned_abs())
        };
        let lattice: Vec<AxisNeighbours<2>> = (0..n * n)
            .map(|p| {
                let (x, y) = (p % n, p / n);
                [[index(x - 1, y), index(x + 1, y)], [index(x, y - 1), index(x, y + 1)]]
            })
            .collect();
        let positions: Vec<[f64; 2]> =
            places.iter().map(|[a, b]| [0.5 * a + 0.1 * b, -0.3 * a + 0.2 * b]).collect();
        let masses = vec![1.0; positions.len()];
        let scene =
            Scene { positions: &positions, masses: &masses, lattice: &lattice, at: (0, 0.0) };
        let g = [0.0, 0.4];
        let mut exchange = LatticeExchange::new(&places);
        exchange.find(&scene, &vec![g; positions.len()], |x| x[0]).unwrap();
        let middle = 112;
        // b = F^-1 g = (-4, 20)/13: two spacings along it lead to (-0.4, 2), by 0.4 to (-1, 2) and by 0.6 to (0, 2), which
        // are (-0.3, 0.7) and (0.2, 0.4) in the state, within 1.69 units of time. The operator itself gives 0.08 and 0.
        let (along, across) = (0.4 * 0.49 + 0.6 * 0.16, 0.4 * 0.09 + 0.6 * 0.04);
        for (h, expected) in [([0.0, 1.0], 0.5 * along / 1.69), ([1.0, 0.0], 0.5 * across / 1.69)] {
            let w = |i: u32| {
                let [q, v] = positions[i as usize];
                0.5 * (h[0] * q * q + h[1] * v * v)
            };
            let rate: f64 = exchange
                .pairs
                .iter()
                .filter(|pair| pair.i == middle || pair.j == middle)
                .map(|pair| {
                    let other = if pair.i == middle { pair.j } else { pair.i };
                    pair.conductance * (w(other) - w(middle))
                })
                .sum();
            assert!((rate - expected).abs() < 1e-13, "{rate} against {expected}");
        }
    }
}
