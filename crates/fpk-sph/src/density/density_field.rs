//! The density at any point.

use smoothing_kernels::{Kernel, Lucy};

use crate::cloud::metric::{Metric, Whitening};
use crate::error::Error;
use crate::score::{inverse, lattice_jacobian, solve_transposed};
use crate::solver::Solver;

/// The density as a function of the state, from density and score at the particles. What is carried from the particles to
/// a point is the departure from the cloud's Gaussian, in whitened coordinates,
///
/// $$ \varphi = \log\psi + \tfrac12 |y|^2, \qquad
/// \varphi(y) = \sum_j w_j(y) \left( \varphi_j + \tfrac12 \nabla\varphi_j \cdot (y - y_j) \right), \qquad
/// \sum_j w_j = 1, \quad \sum_j w_j (y - y_j) = 0, $$
///
/// with Lucy's kernel, over [`FIELD_REACH`] spacings of each particle's deformed lattice cell, times the linear function that
/// the two conditions set. Exact where the departure is quadratic, so a Gaussian is carried without error; else of third
/// order in the spacing. Beyond the cloud the departure goes on linearly from the particle that is nearest in spacings.
///
/// A point costs a look at every particle. The source is this project.
#[derive(Debug)]
pub struct DensityField<const D: usize> {
    whitening: Whitening<D>,
    /// `log det L`.
    log_determinant: f64,
    nodes: Vec<Node<D>>,
}

/// What the field knows of a particle.
#[derive(Debug)]
struct Node<const D: usize> {
    /// Place in the metric.
    y: [f64; D],
    departure: f64,
    gradient: [f64; D],
    /// From the metric to the coordinates of the cell, in spacings.
    to_cell: [[f64; D]; D],
    /// Square of a distance in the metric beyond which the kernel does not reach.
    far: f64,
}

/// Spacings over which a particle is heard.
pub const FIELD_REACH: f64 = 2.2;

/// `1 - m.S^-1 m / m_0`, with the kernel's moments `m_0`, `m`, `S` about a place, is 1 where particles lie evenly around it
/// and falls outward; on a line of particles it has this value half a spacing beyond the last.
const LEAST_CENTRED: f64 = 0.2;

impl<const D: usize> DensityField<D> {
    pub(crate) fn new(solver: &Solver<D>) -> Result<Self, Error> {
        let evaluation = solver.evaluated()?;
        let (cloud, estimates) = (&evaluation.cloud, &evaluation.estimates);
        let (positions, masses) = (&solver.state.positions, &solver.state.masses);
        let at = (solver.state.n_steps, solver.state.time);
        let whitening = Whitening::of(Metric::Whitened, positions, masses, at)?;
        let determinant = whitening.determinant();
        // From the method's metric to the state, and from there to whitened coordinates.
        let to_whitened = determinant / cloud.whitening.determinant();
        let y: Vec<[f64; D]> = positions.iter().map(|x| whitening.whiten(x)).collect();
        let node = |i: usize| {
            let edges = lattice_jacobian(&y, &solver.discretisation.lattice.axis_neighbours, i)
                .ok_or(Error::NoLatticeCell { particle: i })?;
            let to_cell = inverse(&edges).ok_or(Error::LeftStableRange {
                step: at.0,
                time: at.1,
                particle: i,
                quantity: "cell volume",
                value: 0.0,
            })?;
            let score = cloud.whitening.unwhiten_gradient(&estimates.score[i]);
            let score = whitening.whiten_gradient(&score);
            // |y - y_i| is at most the Frobenius norm of the edges times the length in spacings.
            let norm_squared: f64 = edges.as_flattened().iter().map(|e| e * e).sum();
            Ok(Node {
                y: y[i],
                departure: (estimates.density[i] * to_whitened).ln()
                    + 0.5 * y[i].iter().map(|c| c * c).sum::<f64>(),
                gradient: std::array::from_fn(|k| score[k] + y[i][k]),
                to_cell,
                far: FIELD_REACH * FIELD_REACH * norm_squared,
            })
        };
        let nodes = (0..y.len()).map(node).collect::<Result<_, Error>>()?;
        Ok(Self { whitening, log_determinant: determinant.ln(), nodes })
    }

    /// `psi(x)`, in the units of the state.
    pub fn density_at(&self, x: &[f64; D]) -> f64 {
        self.log_density_at(x).exp()
    }

    /// `log psi(x)`: finite where [`density_at`](Self::density_at) underflows.
    pub fn log_density_at(&self, x: &[f64; D]) -> f64 {
        let y = self.whitening.whiten(x);
        let departure = self.departure_between(&y).unwrap_or_else(|| self.departure_beyond(&y));
        departure - 0.5 * y.iter().map(|c| c * c).sum::<f64>() - self.log_determinant
    }

    /// Whether a point lies beyond the cloud, where the density is an extrapolation.
    pub fn is_beyond(&self, x: &[f64; D]) -> bool {
        let y = self.whitening.whiten(x);
        self.departure_between(&y).is_none()
    }

    /// The departure at a place that particles surround; none elsewhere.
    fn departure_between(&self, y: &[f64; D]) -> Option<f64> {
        // Moments of the kernel about the place, of its product with `value`, with d = y_j - y.
        let (mut total, mut first, mut second) = (0.0, [0.0; D], [[0.0; D]; D]);
        let (mut sum, mut along) = (0.0, [0.0; D]);
        for node in &self.nodes {
            let d: [f64; D] = std::array::from_fn(|k| node.y[k] - y[k]);
            if dot(&d, &d) >= node.far {
                continue;
            }
            let q = node.in_spacings(&d).sqrt() / FIELD_REACH;
            let weight = <Lucy as Kernel<D>>::shape(&Lucy, q * <Lucy as Kernel<D>>::support(&Lucy));
            if weight <= 0.0 {
                continue;
            }
            let value = node.departure - 0.5 * dot(&node.gradient, &d);
            total += weight;
            sum += weight * value;
            for k in 0..D {
                first[k] += weight * d[k];
                along[k] += weight * d[k] * value;
                for l in 0..D {
                    second[k][l] += weight * d[k] * d[l];
                }
            }
        }
        // w_j = W_j a (1 - s.d_j) with s = (sum W d d^T)^-1 sum W d; the matrix is symmetric.
        let s = solve_transposed(&second, &first);
        let centred = 1.0 - dot(&first, &s) / total;
        (centred > LEAST_CENTRED).then(|| (sum - dot(&s, &along)) / (total * centred))
    }

    /// The departure beyond the cloud.
    fn departure_beyond(&self, y: &[f64; D]) -> f64 {
        let mut nearest = (f64::INFINITY, 0.0);
        for node in &self.nodes {
            let d: [f64; D] = std::array::from_fn(|k| node.y[k] - y[k]);
            let distance = node.in_spacings(&d);
            if distance < nearest.0 {
                nearest = (distance, node.departure - dot(&node.gradient, &d));
            }
        }
        nearest.1
    }
}

impl<const D: usize> Node<D> {
    /// Square of a distance, in spacings of the particle's cell.
    fn in_spacings(&self, d: &[f64; D]) -> f64 {
        self.to_cell.iter().map(|row| dot(row, d).powi(2)).sum()
    }
}

fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| a[k] * b[k]).sum()
}
