//! Polygons in the plane: their checks, and which points they hold.

use scene_runs::scene::Objection;

use crate::coordinates::point;

/// A simple polygon by its corners, in either sense.
pub(crate) struct Polygon<const D: usize>(Vec<[f64; D]>);

impl<const D: usize> Polygon<D> {
    /// The polygon of a scene, by the path of its corners.
    ///
    /// # Errors
    /// An [`Objection`] outside of two dimensions, to fewer than three corners, to a corner that is not finite, and to edges that
    /// meet elsewhere than at a common corner.
    pub(crate) fn of(corners: &[Vec<f64>], path: &str) -> Result<Self, Objection> {
        if D != 2 {
            let message = format!("a polygon is a shape in two dimensions; the scene has {D}");
            return Err(Objection::new(path, message));
        }
        let at = format!("{path}.corners");
        if corners.len() < 3 {
            let message = format!("{} corners; a polygon needs at least 3", corners.len());
            return Err(Objection::new(at, message));
        }
        let read = |(i, corner): (usize, &Vec<f64>)| {
            let at = format!("{at}[{i}]");
            let corner = point::<D>(corner, &at)?;
            if corner.iter().all(|value| value.is_finite()) {
                return Ok(corner);
            }
            Err(Objection::new(at, format!("the corner {corner:?} is not finite")))
        };
        let corners = corners.iter().enumerate().map(read).collect::<Result<_, _>>()?;
        let polygon = Self(corners);
        if let Some([i, j]) = polygon.crossing() {
            let [edge, other] = [i, j].map(|k| polygon.edge(k));
            let message = format!(
                "the edges {} and {} meet outside of a common corner: {edge:?}, {other:?}",
                i + 1,
                j + 1
            );
            let help = "give the corners in the order of the boundary, each once";
            return Err(Objection::new(at, message).with_help(help));
        }
        Ok(polygon)
    }

    /// The edge from a corner to the next.
    fn edge(&self, k: usize) -> [[f64; D]; 2] {
        [self.0[k], self.0[(k + 1) % self.0.len()]]
    }

    /// Two edges that meet elsewhere than at a common corner, or an edge without length with the next.
    fn crossing(&self) -> Option<[usize; 2]> {
        let n = self.0.len();
        for i in 0..n {
            let [a, b] = self.edge(i);
            for j in i + 1..n {
                let [c, d] = self.edge(j);
                let meet = if j == i + 1 || (i == 0 && j == n - 1) {
                    // Of two neighbours, the far ends: folded back, or an edge without length.
                    let [from, corner, to] = if j == i + 1 { [a, b, d] } else { [c, a, b] };
                    folds(&from, &corner, &to)
                } else {
                    segments_meet([&a, &b], [&c, &d])
                };
                if meet {
                    return Some([i, j]);
                }
            }
        }
        None
    }

    pub(crate) fn bounds(&self) -> ([f64; D], [f64; D]) {
        let fold = |start: f64, of: fn(f64, f64) -> f64| {
            std::array::from_fn(|k| self.0.iter().map(|corner| corner[k]).fold(start, of))
        };
        (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max))
    }

    /// Whether a ray from the point along the first axis leaves the polygon an odd number of times. Of polygons that share an
    /// edge, one alone holds a point on it.
    pub(crate) fn holds(&self, x: &[f64; D]) -> bool {
        let crosses = |k: usize| {
            let [mut low, mut high] = self.edge(k);
            if low[1] > high[1] {
                (low, high) = (high, low);
            }
            (low[1]..high[1]).contains(&x[1]) && turn(&low, &high, x) > 0.0
        };
        (0..self.0.len()).filter(|&k| crosses(k)).count() % 2 == 1
    }
}

/// Twice the area of a triangle, positive counterclockwise.
fn turn<const D: usize>(a: &[f64; D], b: &[f64; D], c: &[f64; D]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether an edge returns into the one before it, or either has no length.
fn folds<const D: usize>(from: &[f64; D], corner: &[f64; D], to: &[f64; D]) -> bool {
    let product = |a: &[f64; D], b: &[f64; D]| -> f64 {
        (0..D).map(|k| (a[k] - corner[k]) * (b[k] - corner[k])).sum()
    };
    let has_no_length = product(from, from) == 0.0 || product(to, to) == 0.0;
    has_no_length || (turn(from, corner, to) == 0.0 && product(from, to) > 0.0)
}

/// Whether two segments have a point in common.
fn segments_meet<const D: usize>([a, b]: [&[f64; D]; 2], [c, d]: [&[f64; D]; 2]) -> bool {
    let between = |a: &[f64; D], b: &[f64; D], x: &[f64; D]| {
        (0..D).all(|k| a[k].min(b[k]) <= x[k] && x[k] <= a[k].max(b[k]))
    };
    let turns = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
    let apart = |one: f64, two: f64| (one > 0.0) != (two > 0.0) && one != 0.0 && two != 0.0;
    (apart(turns[0], turns[1]) && apart(turns[2], turns[3]))
        || (turns[0] == 0.0 && between(a, b, c))
        || (turns[1] == 0.0 && between(a, b, d))
        || (turns[2] == 0.0 && between(c, d, a))
        || (turns[3] == 0.0 && between(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 2]]) -> Result<Polygon<2>, Objection> {
        let corners: Vec<Vec<f64>> = corners.iter().map(|corner| corner.to_vec()).collect();
        Polygon::of(&corners, "shape.polygon")
    }

    const SLOPE: [[f64; 2]; 6] =
        [[0.0, -5.0], [30.0, -5.0], [30.0, 0.0], [20.0, 0.0], [10.0, 5.0], [0.0, 5.0]];

    #[test]
    fn a_slope_holds_the_points_under_its_surface_in_either_sense() {
        let mut reversed = SLOPE;
        reversed.reverse();
        for corners in [SLOPE, reversed] {
            let slope = polygon(&corners).unwrap();
            assert_eq!(slope.bounds(), ([0.0, -5.0], [30.0, 5.0]));
            for (x, inside) in [
                ([15.0, 2.4], true),
                ([15.0, 2.6], false),
                ([25.0, -0.1], true),
                ([25.0, 0.1], false),
                ([5.0, 4.9], true),
                ([5.0, -5.1], false),
                ([-0.1, 0.0], false),
            ] {
                assert_eq!(slope.holds(&x), inside, "{x:?}");
            }
        }
    }

    /// The area by points on a lattice, which none of the edges meets but by chance: that of the shoelace formula.
    #[test]
    fn polygons_that_share_an_edge_hold_each_point_once() {
        let below = polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [1.0, 1.0], [0.0, 2.0]]).unwrap();
        let above = polygon(&[[0.0, 2.0], [1.0, 1.0], [4.0, 3.0], [4.0, 4.0], [0.0, 4.0]]).unwrap();
        let mut held = [0; 2];
        for i in 0..40 {
            for j in 0..40 {
                let x = [0.1 * f64::from(i), 0.1 * f64::from(j)];
                let both = [below.holds(&x), above.holds(&x)];
                assert_ne!(both[0], both[1], "{x:?}");
                held[usize::from(both[1])] += 1;
            }
        }
        // 7.5 of 16, within the lattice's edge of 0.1 along a boundary of 5.
        assert!((f64::from(held[0]) * 0.01 - 7.5).abs() < 0.25, "{held:?}");
    }

    #[test]
    fn what_is_no_simple_polygon_is_refused() {
        for (corners, words) in [
            (&[[0.0, 0.0], [1.0, 0.0]][..], "2 corners; a polygon needs at least 3"),
            (&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], "the edges 1 and 3 meet"),
            (&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "the edges 1 and 2 meet"),
            (&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "the edges 1 and 2 meet"),
            (&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.0]], "the edges 1 and 3 meet"),
            (&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], "the edges 1 and 3 meet"),
            (&[[0.0, 0.0], [1.0, 0.0], [0.0, f64::INFINITY]], "not finite"),
        ] {
            let error = polygon(corners).map(drop).unwrap_err();
            assert!(error.message.contains(words), "{corners:?}: {}", error.message);
        }
        let corners = vec![vec![0.0; 3]; 3];
        let error = Polygon::<3>::of(&corners, "shape.polygon").map(drop).unwrap_err();
        assert!(error.message.contains("two dimensions"), "{}", error.message);
    }
}
