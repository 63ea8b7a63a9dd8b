//! Bonds that a notch cuts.

use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::error::{Error, finite, positive, same_length};

/// A node this near to the surface of a notch, over the length of the bond, lies on it: places are products of a spacing, with
/// their roundoff.
const ON_SURFACE: f64 = 1e-9;

/// A flat piece with straight edges: all points `origin + sum_k a_k edge_k` with every `a_k` from 0 to 1.
struct Piece<const D: usize, const E: usize> {
    origin: [f64; D],
    /// The normal of the piece, of length one.
    normal: [f64; D],
    /// `a_k` of a point is its distance to the origin times this.
    duals: [[f64; D]; E],
}

impl<const D: usize, const E: usize> Piece<D, E> {
    fn crosses(&self, a: &[f64; D], b: &[f64; D]) -> bool {
        let along = |v: &[f64; D], x: &[f64; D]| -> f64 {
            (0..D).map(|k| v[k] * (x[k] - self.origin[k])).sum()
        };
        let length = (0..D).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt();
        let (above, below) = (along(&self.normal, a), along(&self.normal, b));
        let on = |height: f64| height.abs() < ON_SURFACE * length;
        // The part of the bond, from 0 to 1, that lies in the plane: one point, or all of it.
        let (mut from, mut to) = match (on(above), on(below)) {
            (true, true) => (0.0, 1.0),
            (true, false) => (0.0, 0.0),
            (false, true) => (1.0, 1.0),
            (false, false) if (above > 0.0) == (below > 0.0) => return false,
            (false, false) => (above / (above - below), above / (above - below)),
        };
        for dual in &self.duals {
            let (start, end) = (along(dual, a), along(dual, b));
            let slope = end - start;
            if slope.abs() < ON_SURFACE {
                if (start - 0.5).abs() > 0.5 + ON_SURFACE {
                    return false;
                }
                continue;
            }
            // Where along the bond this coordinate is 0 and 1.
            let (one, two) = (-start / slope, (1.0 - start) / slope);
            let slack = ON_SURFACE / slope.abs();
            from = f64::max(from, one.min(two) - slack);
            to = f64::min(to, one.max(two) + slack);
        }
        from <= to
    }
}

impl Bonds {
    /// The bonds that cross a notch: a segment in two dimensions, given by its ends, that no bond may cross. One that only
    /// touches it is cut.
    ///
    /// # Errors
    /// [`Error::Length`] where the nodes are not those of these bonds; [`Error::Parameter`] for an end;
    /// [`Error::Parameter`] for a notch without length; [`Error::NotchOutsideBody`] where it cuts nothing.
    pub fn across_segment(
        &self,
        nodes: &Nodes<2>,
        (from, to): ([f64; 2], [f64; 2]),
    ) -> Result<Vec<usize>, Error> {
        for value in from.into_iter().chain(to) {
            finite("an end of the notch", value)?;
        }
        let edge = [to[0] - from[0], to[1] - from[1]];
        let length = edge[0].hypot(edge[1]);
        positive("length of the notch", length)?;
        let dual = edge.map(|e| e / length / length);
        let normal = [-edge[1] / length, edge[0] / length];
        self.across(nodes, &Piece { origin: from, normal, duals: [dual] })
    }

    /// The bonds that cross a flat notch in three dimensions: the parallelogram of a corner and the two edges that start there
    /// (lengths). One that only touches it is cut.
    ///
    /// ```
    /// use peridyn_sde::{BondConfig, Bonds, Condition, Horizon, Nodes};
    ///
    /// let nodes = Nodes::lattice(1.0, ([0.0; 3], [4.0; 3]), Condition::Solid, |_| true)?;
    /// let config = BondConfig::uncorrected(Horizon::of_shells(1, 1.0)?, 1.0);
    /// let bonds = Bonds::new(&nodes, &config)?;
    /// // Half of the plane between the second and the third layer.
    /// let cut = bonds.across_plane(&nodes, [0.0, 0.0, 2.0], [[2.0, 0.0, 0.0], [0.0, 4.0, 0.0]])?;
    /// assert_eq!(cut.len(), 8);
    /// # Ok::<(), peridyn_sde::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Bonds::across_segment`], with [`Error::Parameter`] for a notch without area.
    pub fn across_plane(
        &self,
        nodes: &Nodes<3>,
        corner: [f64; 3],
        edges: [[f64; 3]; 2],
    ) -> Result<Vec<usize>, Error> {
        for value in corner.into_iter().chain(edges.into_iter().flatten()) {
            finite("a corner of the notch", value)?;
        }
        let across = cross(&edges[0], &edges[1]);
        let area = (0..3).map(|k| across[k] * across[k]).sum::<f64>().sqrt();
        positive("area of the notch", area)?;
        let normal = across.map(|c| c / area);
        let duals = [
            cross(&edges[1], &normal).map(|c| c / area),
            cross(&normal, &edges[0]).map(|c| c / area),
        ];
        self.across(nodes, &Piece { origin: corner, normal, duals })
    }

    fn across<const D: usize, const E: usize>(
        &self,
        nodes: &Nodes<D>,
        piece: &Piece<D, E>,
    ) -> Result<Vec<usize>, Error> {
        let positions = nodes.positions();
        same_length("nodes", positions.len(), self.n_nodes())?;
        let cut: Vec<usize> = (0..)
            .zip(self.pairs())
            .filter(|&(_, (i, j))| piece.crosses(&positions[i], &positions[j]))
            .map(|(bond, _)| bond)
            .collect();
        if cut.is_empty() { Err(Error::NotchOutsideBody) } else { Ok(cut) }
    }
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BondConfig, Condition, Horizon};

    fn body<const D: usize>(side: f64, condition: Condition) -> (Nodes<D>, Bonds) {
        let nodes = Nodes::lattice(0.1, ([0.0; D], [side; D]), condition, |_| true).unwrap();
        let config = BondConfig::uncorrected(Horizon::of_shells(2, 0.1).unwrap(), 1.0);
        let bonds = Bonds::new(&nodes, &config).unwrap();
        (nodes, bonds)
    }

    #[test]
    fn a_notch_along_a_row_of_nodes_cuts_nothing_beyond_its_tip() {
        let (nodes, bonds) = body::<2>(1.2, Condition::PlaneStress { thickness: 1.0 });
        let row = nodes.positions()[12 * 6][1];
        let cut = bonds.across_segment(&nodes, ([-0.1, row], [0.5, row])).unwrap();
        let pairs: Vec<_> = bonds.pairs().collect();
        let beyond = |node: usize| nodes.positions()[node][0] > 0.51;
        assert!(cut.iter().all(|&bond| !(beyond(pairs[bond].0) && beyond(pairs[bond].1))));
        // Of the row itself: those of length 1 and 2 between its nodes at 0.05 to 0.45, and those that leave the tip.
        let in_row = cut.iter().filter(|&&bond| pairs[bond].0 / 12 == 6 && pairs[bond].1 / 12 == 6);
        assert_eq!(in_row.count(), 4 + 3 + 1 + 2);
    }

    #[test]
    fn a_plane_through_a_block_cuts_what_a_segment_cuts_in_each_of_its_layers() {
        let (nodes, bonds) = body::<3>(0.8, Condition::Solid);
        let (from, to) = ([-0.1, 0.4, -0.1], [0.33, 0.0, 0.0]);
        let cut = bonds.across_plane(&nodes, from, [to, [0.0, 0.0, 1.0]]).unwrap();
        let (plate, flat) = body::<2>(0.8, Condition::PlaneStress { thickness: 1.0 });
        let in_plate = flat.across_segment(&plate, ([-0.1, 0.4], [0.23, 0.4])).unwrap();
        let pairs: Vec<_> = bonds.pairs().collect();
        let in_layer = |&&bond: &&usize| pairs[bond].0 / 64 == 3 && pairs[bond].1 / 64 == 3;
        assert_eq!(cut.iter().filter(in_layer).count(), in_plate.len());
        // Independent of the order and the sense of the edges.
        let far = [from[0] + to[0], from[1], from[2]];
        let turned = bonds.across_plane(&nodes, far, [[0.0, 0.0, 1.0], [-0.33, 0.0, 0.0]]);
        assert_eq!(cut, turned.unwrap());
    }

    #[test]
    fn an_oblique_plane_cuts_the_bonds_whose_ends_lie_on_both_of_its_sides() {
        let (nodes, bonds) = body::<3>(0.8, Condition::Solid);
        // x + y + z = 1.2, larger than the block, and no node on it: coordinates sum to 0.05 more than a multiple of 0.1.
        let corner = [-4.0, 2.4, 2.8];
        let edges = [[6.0, -6.0, 0.0], [6.0, 0.0, -6.0]];
        let cut = bonds.across_plane(&nodes, corner, edges).unwrap();
        let above = |node: usize| nodes.positions()[node].iter().sum::<f64>() > 1.2;
        let expected: Vec<usize> = (0..)
            .zip(bonds.pairs())
            .filter(|&(_, (i, j))| above(i) != above(j))
            .map(|(bond, _)| bond)
            .collect();
        assert_eq!(cut, expected);
    }

    #[test]
    fn notches_without_extent_and_outside_are_refused() {
        let (nodes, bonds) = body::<3>(0.4, Condition::Solid);
        let flat = bonds.across_plane(&nodes, [0.0; 3], [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        assert!(matches!(flat, Err(Error::Parameter { name: "area of the notch", .. })));
        let edges = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let outside = bonds.across_plane(&nodes, [0.0, 0.0, 5.0], edges);
        assert_eq!(outside, Err(Error::NotchOutsideBody));
        let infinite = bonds.across_plane(&nodes, [0.0, 0.0, f64::INFINITY], edges);
        assert!(matches!(infinite, Err(Error::Parameter { .. })));
        let (plate, flat) = body::<2>(0.4, Condition::PlaneStress { thickness: 1.0 });
        let point = flat.across_segment(&plate, ([0.2; 2], [0.2; 2]));
        assert!(matches!(point, Err(Error::Parameter { name: "length of the notch", .. })));
    }
}
