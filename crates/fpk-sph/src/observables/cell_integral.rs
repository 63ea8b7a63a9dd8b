//! The density integrated over the particles' deformed lattice cells.

use sde_integrators::Sde;

use crate::cloud::AxisNeighbours;
use crate::error::{Error, finite};
use crate::metric::Whitening;
use crate::score::{LocalFit, determinant, lattice_jacobian};
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
}

/// Spacings by which a cell at the rim goes on outward. At 6 standard deviations and a spacing of 0.3, three of them
/// hold all but 0.4 % of what lies beyond.
pub const TAIL_SPACINGS: usize = 3;

/// A cell's mass by the fit over its particle's mass, above which (or below its inverse) the fit is not trusted. A
/// Gaussian at 6 standard deviations and a spacing of 0.45 gives 1.34.
const MOST_MASS_RATIO: f64 = 2.0;

#[derive(Debug)]
struct Cell<const D: usize> {
    /// Centre in the metric.
    centre: [f64; D],
    /// Columns are the edges, in the metric.
    edges: [[f64; D]; D],
    /// Density at the centre times the volume of the cell.
    weight: f64,
    gradient: [f64; D],
    hessian: [[f64; D]; D],
    /// Spacings by which the cell goes on below and above along each axis.
    tail: [[usize; 2]; D],
    /// Mass with its tail.
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
    /// Those of the local fits: too few neighbours, a singular fit, a singular covariance.
    pub fn cell_integral(&self) -> Result<CellIntegral<D>, Error> {
        let (stage, fits) = self.local_fits()?;
        let cells = fits
            .iter()
            .enumerate()
            .map(|(i, fit)| {
                Cell::new(&stage.whitened, &self.field.lattice, self.masses()[i], i, fit)
            })
            .collect::<Result<_, _>>()?;
        Ok(CellIntegral { whitening: stage.whitening, cells })
    }
}

impl<const D: usize> CellIntegral<D> {
    /// The integral of the density: 1 but for what the lattice never held and for the error of the fits.
    pub fn total_mass(&self) -> f64 {
        self.cells.iter().map(|cell| cell.mass).sum()
    }

    /// How many cells hold their particle's own mass because the fit is not trusted there.
    pub fn n_distrusted(&self) -> usize {
        self.cells.iter().filter(|cell| !cell.trusted).count()
    }

    /// `P(y(x) > T)`. Cells that the limit crosses are subdivided, the limit taken as linear within a part.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the threshold.
    pub fn exceedance(
        &self,
        demand: impl Fn(&[f64; D]) -> f64,
        threshold: f64,
    ) -> Result<Exceedance, Error> {
        finite("threshold", threshold)?;
        let mut exceedance = Exceedance { probability: 0.0, beyond_the_cloud: 0.0 };
        for cell in &self.cells {
            let demand_at =
                |u: &[f64; D]| demand(&self.whitening.unwhiten(&cell.point(u))) - threshold;
            if cell.lies_below(demand_at) {
                continue;
            }
            cell.for_each_part(|u, mass| {
                let fraction = fraction_above(demand_at, u);
                exceedance.probability += mass * fraction;
                if u.iter().any(|u_k| u_k.abs() > 0.5) {
                    exceedance.beyond_the_cloud += mass * fraction;
                }
            });
        }
        Ok(exceedance)
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
                let edge = std::array::from_fn(|k| cell.edges[k][axis]);
                (self.whitening.unwhiten(&edge)[component] - origin).abs()
            })
            .sum();
        extent / subdivisions(D) as f64
    }
}

impl<const D: usize> Cell<D> {
    fn new(
        positions: &[[f64; D]],
        lattice: &[AxisNeighbours<D>],
        particle_mass: f64,
        i: usize,
        fit: &LocalFit<D>,
    ) -> Result<Self, Error> {
        let edges =
            lattice_jacobian(positions, lattice, i).ok_or(Error::NoLatticeCell { particle: i })?;
        let weight = fit.log_density.exp() * determinant(&edges).abs();
        let mut cell = Self {
            centre: positions[i],
            edges,
            weight,
            gradient: fit.gradient,
            hessian: fit.hessian,
            tail: [[0; 2]; D],
            mass: 0.0,
            trusted: true,
        };
        let own = cell.integral();
        let ratio = own / particle_mass;
        if !(1.0 / MOST_MASS_RATIO..=MOST_MASS_RATIO).contains(&ratio) {
            // The fit turns too sharply for this cell: keep its shape, but only the particle's own mass.
            cell.trusted = false;
            let scale = if ratio.is_finite() && ratio > 0.0 { 1.0 / ratio } else { 0.0 };
            cell.weight *= scale;
            if scale == 0.0 {
                (cell.weight, cell.gradient, cell.hessian) =
                    (particle_mass, [0.0; D], [[0.0; D]; D]);
            }
            cell.mass = cell.integral();
            return Ok(cell);
        }
        for axis in 0..D {
            for side in 0..2 {
                if lattice[i][axis][side].is_none() && cell.falls_outward(axis, side) {
                    cell.tail[axis][side] = TAIL_SPACINGS;
                }
            }
        }
        cell.mass = cell.integral();
        Ok(cell)
    }

    /// Whether log density falls from the face outward and goes on falling.
    fn falls_outward(&self, axis: usize, side: usize) -> bool {
        let sign = if side == 0 { -1.0 } else { 1.0 };
        let outward: [f64; D] = std::array::from_fn(|k| sign * self.edges[k][axis]);
        let (mut slope, mut curvature) = (0.0, 0.0);
        for k in 0..D {
            slope += self.gradient[k] * outward[k];
            for l in 0..D {
                curvature += outward[k] * self.hessian[k][l] * outward[l];
            }
        }
        curvature <= 0.0 && slope + 0.5 * curvature < 0.0
    }

    /// The point with the lattice coordinates `u` of the cell, which runs from -1/2 to 1/2 along each axis.
    fn point(&self, u: &[f64; D]) -> [f64; D] {
        let mut y = self.centre;
        for k in 0..D {
            for axis in 0..D {
                y[k] += self.edges[k][axis] * u[axis];
            }
        }
        y
    }

    /// `exp(g.d + d.H d / 2)` at the lattice coordinates `u`.
    fn shape(&self, u: &[f64; D]) -> f64 {
        let y = self.point(u);
        let mut exponent = 0.0;
        for k in 0..D {
            let d_k = y[k] - self.centre[k];
            exponent += self.gradient[k] * d_k;
            for l in 0..D {
                exponent += 0.5 * d_k * self.hessian[k][l] * (y[l] - self.centre[l]);
            }
        }
        exponent.exp()
    }

    fn integral(&self) -> f64 {
        let mut mass = 0.0;
        self.for_each_part(|_, part| mass += part);
        mass
    }

    /// Calls with the centre (lattice coordinates) and the mass of every part of the cell and its tail.
    fn for_each_part(&self, mut visit: impl FnMut(&[f64; D], f64)) {
        let parts = subdivisions(D);
        let counts: [usize; D] = self.tail.map(|[below, above]| parts * (1 + below + above));
        let part_weight = self.weight / (parts as f64).powi(i32::try_from(D).unwrap_or(0));
        let mut index = [0; D];
        loop {
            let u: [f64; D] = std::array::from_fn(|k| {
                (index[k] as f64 + 0.5) / parts as f64 - 0.5 - self.tail[k][0] as f64
            });
            visit(&u, part_weight * self.shape(&u));
            // The next index, first axis fastest.
            let mut axis = 0;
            loop {
                if axis == D {
                    return;
                }
                index[axis] += 1;
                if index[axis] < counts[axis] {
                    break;
                }
                index[axis] = 0;
                axis += 1;
            }
        }
    }

    /// Whether the demand stays below the threshold at the centre and at all corners of the cell with its tail.
    fn lies_below(&self, demand_above_threshold: impl Fn(&[f64; D]) -> f64) -> bool {
        let corner = |bits: usize| -> [f64; D] {
            std::array::from_fn(|k| {
                let [below, above] = self.tail[k];
                if bits >> k & 1 == 0 { -0.5 - below as f64 } else { 0.5 + above as f64 }
            })
        };
        demand_above_threshold(&[0.0; D]) <= 0.0
            && (0..1 << D).all(|bits| demand_above_threshold(&corner(bits)) <= 0.0)
    }
}

/// The part of a part's volume where the demand exceeds the threshold, were it linear there.
fn fraction_above<const D: usize>(
    demand_above_threshold: impl Fn(&[f64; D]) -> f64,
    u: &[f64; D],
) -> f64 {
    let half = 0.5 / subdivisions(D) as f64;
    let centre = demand_above_threshold(u);
    let mut variation = 0.0;
    for axis in 0..D {
        let (mut below, mut above) = (*u, *u);
        below[axis] -= half;
        above[axis] += half;
        variation += (demand_above_threshold(&above) - demand_above_threshold(&below)).abs();
    }
    if centre.abs() >= 0.5 * variation {
        f64::from(u8::from(centre > 0.0))
    } else {
        0.5 + centre / variation
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
