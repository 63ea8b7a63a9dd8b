//! The deformed lattice cell of each particle.

use crate::cloud::AxisNeighbours;

/// The edges of a particle's lattice cell as the flow has deformed it: column `k` is `dx/dX_k` times the spacing, where
/// `X` are the coordinates on the initial lattice.
///
/// Central differences inside, one-sided differences of second order (of first order where the lattice is too narrow)
/// at its rim; at a tip, which has no neighbour along some axis, the edge of a neighbour along another. It is exact
/// for an affine flow. `None` where that neighbour has none either.
pub(crate) fn lattice_jacobian<const D: usize>(
    positions: &[[f64; D]],
    lattice: &[AxisNeighbours<D>],
    i: usize,
) -> Option<[[f64; D]; D]> {
    let mut edges = [[0.0; D]; D];
    let neighbours = lattice.get(i)?;
    for axis in 0..D {
        let at_neighbour = || {
            neighbours
                .iter()
                .flatten()
                .flatten()
                .find_map(|&j| edge(positions, lattice, j as usize, axis))
        };
        let column = edge(positions, lattice, i, axis).or_else(at_neighbour)?;
        for k in 0..D {
            edges[k][axis] = column[k];
        }
    }
    Some(edges)
}

/// The edge along one axis, by differences over the lattice neighbours there.
fn edge<const D: usize>(
    positions: &[[f64; D]],
    lattice: &[AxisNeighbours<D>],
    i: usize,
    axis: usize,
) -> Option<[f64; D]> {
    match lattice[i][axis] {
        [Some(below), Some(above)] => {
            let (a, b) = (&positions[below as usize], &positions[above as usize]);
            Some(std::array::from_fn(|k| 0.5 * (b[k] - a[k])))
        }
        [None, Some(above)] => Some(one_sided(positions, lattice, i, above, axis, 1)),
        [Some(below), None] => {
            Some(one_sided(positions, lattice, i, below, axis, 0).map(|edge| -edge))
        }
        [None, None] => None,
    }
}

/// `-3/2 x_0 + 2 x_1 - 1/2 x_2` towards one side, or `x_1 - x_0` where there is no second neighbour.
fn one_sided<const D: usize>(
    positions: &[[f64; D]],
    lattice: &[AxisNeighbours<D>],
    i: usize,
    first: u32,
    axis: usize,
    side: usize,
) -> [f64; D] {
    let (x_0, x_1) = (&positions[i], &positions[first as usize]);
    match lattice[first as usize][axis][side] {
        Some(second) => {
            let x_2 = &positions[second as usize];
            std::array::from_fn(|k| -1.5 * x_0[k] + 2.0 * x_1[k] - 0.5 * x_2[k])
        }
        None => std::array::from_fn(|k| x_1[k] - x_0[k]),
    }
}

/// Determinant of a small matrix by elimination with partial pivoting.
pub(crate) fn determinant<const D: usize>(matrix: &[[f64; D]; D]) -> f64 {
    let mut m = *matrix;
    let mut product = 1.0;
    for k in 0..D {
        let pivot = (k..D).max_by(|&a, &b| m[a][k].abs().total_cmp(&m[b][k].abs())).unwrap_or(k);
        if m[pivot][k] == 0.0 {
            return 0.0;
        }
        if pivot != k {
            m.swap(pivot, k);
            product = -product;
        }
        product *= m[k][k];
        for i in k + 1..D {
            let factor = m[i][k] / m[k][k];
            for j in k..D {
                m[i][j] -= factor * m[k][j];
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use particle_store::Lattice;

    #[test]
    fn a_determinant_by_hand() {
        // 2 (3*1 - 2*0) - 0 + 1 (1*0 - 3*4) = 6 - 12 = -6.
        let m = [[2.0, 0.0, 1.0], [1.0, 3.0, 2.0], [4.0, 0.0, 1.0]];
        assert!((determinant(&m) + 6.0).abs() < 1e-14);
    }

    #[test]
    fn an_affine_flow_deforms_every_cell_alike_the_rim_included() {
        every_cell_is_deformed_alike(&Lattice::box_lattice([1.0, 2.0], [5, 5]).unwrap());
        // The tips of the ball have no neighbour across.
        every_cell_is_deformed_alike(&Lattice::ball_lattice(2.0, 0.4).unwrap());
    }

    fn every_cell_is_deformed_alike(lattice: &Lattice<2>) {
        let axis_neighbours = lattice.axis_neighbours();
        let a = [[1.5, -0.4], [0.3, 0.8]];
        let moved: Vec<[f64; 2]> = lattice
            .points
            .iter()
            .map(|x| std::array::from_fn(|k| a[k][0] * x[0] + a[k][1] * x[1] + 0.7))
            .collect();
        let expected = (1.5 * 0.8 + 0.4 * 0.3) * lattice.cell_volume();
        for i in 0..moved.len() {
            let edges = lattice_jacobian(&moved, &axis_neighbours, i).unwrap();
            assert!((determinant(&edges) - expected).abs() < 1e-14, "particle {i}");
        }
    }
}
