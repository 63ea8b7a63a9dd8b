//! A plane cantilever of four-node elements whose Young's modulus is a random field.

use random_fields::{
    Correlation, CorrelationFunction, Enough, SpatialCorrelation, pivoted_cholesky,
};
use uq_estimators::{Failure, NormalModel};

use crate::cases::prelude::*;

/// Elements along and across the beam.
pub(crate) const CELLS: [usize; 2] = [50, 20];
/// Length and height (m).
pub(crate) const SIZE: [f64; 2] = [5.0, 2.0];
const POISSON: f64 = 0.3;
/// Mean and standard deviation of Young's modulus (Pa), its correlation length (m).
const MODULUS: [f64; 2] = [200e9, 30e9];
const LENGTH: f64 = 10.0;
/// The loads on the upper edge: their number and size (N).
const N_LOADS: usize = 20;
const LOAD: f64 = 500e3;

/// Plane stress with a thickness of 1 m, or plane strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Plane {
    Stress,
    Strain,
}

/// Where the loads are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Loads {
    /// At 0.25 m, 0.5 m to 5 m.
    Ends,
    /// In the middles of 20 equal parts.
    Middles,
    /// From the clamped to the free end, 5/19 m apart.
    Both,
}

/// What the paper leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Choice {
    pub(crate) plane: Plane,
    pub(crate) loads: Loads,
    /// Height of point A on the free end, in elements.
    pub(crate) point: usize,
}

/// Downward displacement of point A (m) as a function of one normal for each element.
///
/// Bilinear elements with two by two points; one modulus for each element, at its centre. Where a modulus is not positive the
/// displacement counts as infinite.
#[derive(Debug)]
pub(crate) struct Beam {
    /// Stiffness of an element with unit modulus, row by row.
    element: [f64; 64],
    loads: Vec<f64>,
    observed: usize,
    /// Columns of a factor of the correlation of the elements.
    factor: Vec<f64>,
}

const N_CELLS: usize = CELLS[0] * CELLS[1];
/// Unknowns of a column of nodes; the clamped one has none.
const PER_COLUMN: usize = 2 * (CELLS[1] + 1);
const N_UNKNOWNS: usize = CELLS[0] * PER_COLUMN;
/// Unknowns below the diagonal that an element couples.
const BAND: usize = PER_COLUMN + 3;

impl Beam {
    pub(crate) fn new(choice: Choice) -> CaseResult<Self> {
        let side = [SIZE[0] / CELLS[0] as f64, SIZE[1] / CELLS[1] as f64];
        let centre = |cell: usize| {
            let (i, j) = (cell / CELLS[1], cell % CELLS[1]);
            [(i as f64 + 0.5) * side[0], (j as f64 + 0.5) * side[1]]
        };
        let correlation: SpatialCorrelation<2> =
            Correlation { function: CorrelationFunction::Exponential, length: LENGTH }.into();
        let entry = |a: usize, b: usize| correlation.between(&centre(a), &centre(b));
        // All columns: within roundoff.
        let factor = pivoted_cholesky(N_CELLS, entry, Enough::Largest(1e-12))?.columns;
        let mut loads = vec![0.0; N_UNKNOWNS];
        for k in 0..N_LOADS {
            let n = N_LOADS as f64;
            let part = match choice.loads {
                Loads::Ends => (k as f64 + 1.0) / n,
                Loads::Middles => (k as f64 + 0.5) / n,
                Loads::Both => k as f64 / (n - 1.0),
            };
            let x = part * CELLS[0] as f64;
            // Shared by the two nodes beside it.
            let left = (0..CELLS[0]).rev().find(|left| *left as f64 <= x).unwrap_or(0);
            for (column, part) in [(left, 1.0 - (x - left as f64)), (left + 1, x - left as f64)] {
                if let Some(unknown) = unknown(column, CELLS[1], 1) {
                    loads[unknown] += part * LOAD;
                }
            }
        }
        let observed = unknown(CELLS[0], choice.point, 1).ok_or("the free end is clamped")?;
        Ok(Self { element: unit_stiffness(choice.plane, side), loads, observed, factor })
    }

    /// Young's modulus of each element (Pa).
    fn moduli(&self, normals: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; N_CELLS];
        for (column, z) in self.factor.chunks_exact(N_CELLS).zip(normals) {
            field.iter_mut().zip(column).for_each(|(field, u)| *field += u * z);
        }
        field.iter().map(|field| MODULUS[0] + MODULUS[1] * field).collect()
    }

    /// Banded Cholesky factor of the stiffness, row by row; none where it is not positive definite.
    fn stiffness_factor(&self, moduli: &[f64]) -> Option<Vec<f64>> {
        let width = BAND + 1;
        let mut rows = vec![0.0; N_UNKNOWNS * width];
        for (cell, modulus) in moduli.iter().enumerate() {
            let places = unknowns_of(cell);
            for (a, row) in places.iter().enumerate() {
                for (b, column) in places.iter().enumerate() {
                    if let (Some(row), Some(column)) = (*row, *column)
                        && column <= row
                    {
                        rows[row * width + BAND + column - row] +=
                            modulus * self.element[8 * a + b];
                    }
                }
            }
        }
        for i in 0..N_UNKNOWNS {
            let (above, rest) = rows.split_at_mut(i * width);
            let row = &mut rest[..width];
            for j in i.saturating_sub(BAND)..i {
                let of_j = &above[j * width..][..width];
                // Columns from the later start on.
                let shared = BAND + j - i;
                let product: f64 =
                    row[..shared].iter().zip(&of_j[BAND - shared..]).map(|(a, b)| a * b).sum();
                row[shared] = (row[shared] - product) / of_j[BAND];
            }
            let square: f64 = row[..BAND].iter().map(|a| a * a).sum();
            let pivot = row[BAND] - square;
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            row[BAND] = pivot.sqrt();
        }
        Some(rows)
    }

    /// Displacement at A and its derivative with respect to each modulus, if asked for.
    fn respond(&self, moduli: &[f64], slopes: Option<&mut [f64]>) -> f64 {
        if moduli.iter().any(|modulus| *modulus <= 0.0) {
            return f64::INFINITY;
        }
        let Some(factor) = self.stiffness_factor(moduli) else { return f64::INFINITY };
        let mut u = self.loads.clone();
        solve(&factor, &mut u);
        if let Some(slopes) = slopes {
            // The adjoint: K v = e, then du/dE = -v K_e u.
            let mut v = vec![0.0; N_UNKNOWNS];
            v[self.observed] = 1.0;
            solve(&factor, &mut v);
            for (cell, slope) in slopes.iter_mut().enumerate() {
                let places = unknowns_of(cell);
                let at = |x: &[f64], a: usize| places[a].map_or(0.0, |place| x[place]);
                *slope =
                    -(0..64).map(|k| at(&v, k / 8) * self.element[k] * at(&u, k % 8)).sum::<f64>();
            }
        }
        u[self.observed]
    }

    /// The displacement for the mean modulus everywhere (m).
    pub(crate) fn of_means(&self) -> f64 {
        self.respond(&vec![MODULUS[0]; N_CELLS], None)
    }
}

impl NormalModel for Beam {
    fn n_normals(&self) -> usize {
        self.factor.len() / N_CELLS
    }

    fn value(&self, normals: &[f64]) -> Result<f64, Failure> {
        Ok(self.respond(&self.moduli(normals), None))
    }

    fn value_and_gradient(
        &self,
        normals: &[f64],
        gradient: &mut [f64],
    ) -> Result<Option<f64>, Failure> {
        let mut slopes = vec![0.0; N_CELLS];
        let value = self.respond(&self.moduli(normals), Some(&mut slopes));
        for (column, out) in self.factor.chunks_exact(N_CELLS).zip(gradient) {
            *out = MODULUS[1] * column.iter().zip(&slopes).map(|(u, s)| u * s).sum::<f64>();
        }
        Ok(Some(value))
    }
}

/// Unknown of a node; none where it is clamped.
fn unknown(column: usize, row: usize, component: usize) -> Option<usize> {
    column.checked_sub(1).map(|column| column * PER_COLUMN + 2 * row + component)
}

/// Unknowns of the nodes of a cell, counterclockwise from the lower left.
fn unknowns_of(cell: usize) -> [Option<usize>; 8] {
    let (i, j) = (cell / CELLS[1], cell % CELLS[1]);
    let nodes = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
    std::array::from_fn(|k| unknown(nodes[k / 2].0, nodes[k / 2].1, k % 2))
}

/// Forward and back substitution.
fn solve(factor: &[f64], x: &mut [f64]) {
    let width = BAND + 1;
    for i in 0..x.len() {
        let row = &factor[i * width..][..width];
        let first = i.saturating_sub(BAND);
        let product: f64 =
            row[BAND + first - i..BAND].iter().zip(&x[first..i]).map(|(a, b)| a * b).sum();
        x[i] = (x[i] - product) / row[BAND];
    }
    for i in (0..x.len()).rev() {
        let row = &factor[i * width..][..width];
        let value = x[i] / row[BAND];
        x[i] = value;
        let first = i.saturating_sub(BAND);
        for (x, a) in x[first..i].iter_mut().zip(&row[BAND + first - i..BAND]) {
            *x -= a * value;
        }
    }
}

/// Stiffness of a bilinear element with unit modulus and thickness.
fn unit_stiffness(plane: Plane, side: [f64; 2]) -> [f64; 64] {
    let nu = POISSON;
    let [d_11, d_12] = match plane {
        Plane::Stress => [1.0, nu].map(|d| d / (1.0 - nu * nu)),
        Plane::Strain => [1.0 - nu, nu].map(|d| d / ((1.0 + nu) * (1.0 - 2.0 * nu))),
    };
    let shear = 0.5 / (1.0 + nu);
    let mut stiffness = [0.0; 64];
    let place = 1.0 / 3.0_f64.sqrt();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    for [x, y] in corners.map(|corner| corner.map(|c| c * place)) {
        // Derivatives of the shape functions at the point.
        let slopes = corners.map(|[a, b]| {
            [0.25 * a * (1.0 + b * y) * 2.0 / side[0], 0.25 * b * (1.0 + a * x) * 2.0 / side[1]]
        });
        let strain = |k: usize| {
            let [x, y] = slopes[k / 2];
            if k.is_multiple_of(2) { [x, 0.0, y] } else { [0.0, y, x] }
        };
        let weight = 0.25 * side[0] * side[1];
        for (k, entry) in stiffness.iter_mut().enumerate() {
            let (a, b) = (strain(k / 8), strain(k % 8));
            let normal = d_11 * (a[0] * b[0] + a[1] * b[1]) + d_12 * (a[0] * b[1] + a[1] * b[0]);
            *entry += weight * (normal + shear * a[2] * b[2]);
        }
    }
    stiffness
}
