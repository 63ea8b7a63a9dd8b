//! The rivals, each used as its documentation recommends, with the structure rebuilt each time.
//!
//! All read `[f64; D]`, so no input is converted. Buffers are kept between runs if the interface accepts one.

use std::hint::black_box;

use kiddo::{ImmutableKdTree, PairQueryResult, SquaredEuclidean};
use linkcell::{Cell, PairColumns, pairs_within, pairs_within_columns};
use rstar::RTree;
use rstar::primitives::GeomWithData;
use zelll::CellGrid;

use crate::found::{Rows, Sense};

/// kiddo for one dimension: its traits do not allow a generic function.
macro_rules! trees {
    ($module:ident, $dimension:literal) => {
        pub(crate) mod $module {
            use super::*;

            const D: usize = $dimension;

            /// kiddo: a tree, then a query for each point.
            pub(crate) fn kiddo(
                points: &[[f64; D]],
                radius: impl Fn(usize) -> f64,
                rows: &mut Rows,
            ) {
                let tree = ImmutableKdTree::<f64, D>::new_from_slice(black_box(points)).unwrap();
                rows.restart();
                for (i, x) in points.iter().enumerate() {
                    let reach = radius(i);
                    tree.query(x).within::<SquaredEuclidean<f64>>(reach * reach).unsorted().visit(
                        |found| {
                            if found.item as usize != i {
                                rows.indices.push(found.item);
                            }
                        },
                    );
                    rows.end_row();
                }
            }

            /// kiddo: each pair is found by the point with the larger radius, and written in both directions.
            pub(crate) fn kiddo_max(points: &[[f64; D]], radii: &[f64], pairs: &mut Vec<[u32; 2]>) {
                let tree = ImmutableKdTree::<f64, D>::new_from_slice(black_box(points)).unwrap();
                pairs.clear();
                for (i, x) in points.iter().zip(radii).enumerate() {
                    let ((x, &reach), i) = (x, u32::try_from(i).unwrap());
                    tree.query(x).within::<SquaredEuclidean<f64>>(reach * reach).unsorted().visit(
                        |found| {
                            let (j, its_reach) = (found.item, radii[found.item as usize]);
                            if its_reach < reach || (its_reach <= reach && j < i) {
                                pairs.push([i, j]);
                                pairs.push([j, i]);
                            }
                        },
                    );
                }
            }
        }
    };
}
trees!(plane, 2);
trees!(space, 3);

/// kiddo: the join of two trees of the same points; it requires two trees. Each point also finds itself.
pub(crate) fn kiddo_join(points: &[[f64; 2]], radius: f64) -> Vec<PairQueryResult<u32, u32, ()>> {
    let [tree, twin] =
        [(); 2].map(|()| ImmutableKdTree::<f64, 2>::new_from_slice(black_box(points)).unwrap());
    tree.query_tree(&twin)
        .within::<SquaredEuclidean<f64>>(radius * radius)
        .without_distances()
        .execute()
}

/// rstar: a bulk-loaded tree, then a query for each point.
pub(crate) fn rstar(points: &[[f64; 2]], radius: f64, rows: &mut Rows) {
    let leaves = black_box(points).iter().zip(0..);
    let leaves = leaves.map(|(x, i)| GeomWithData::new(*x, i)).collect();
    let tree = RTree::<GeomWithData<[f64; 2], u32>>::bulk_load(leaves);
    rows.restart();
    for (i, x) in points.iter().enumerate() {
        for leaf in tree.locate_within_distance(*x, radius * radius) {
            if leaf.data as usize != i {
                rows.indices.push(leaf.data);
            }
        }
        rows.end_row();
    }
}

/// linkcell is always periodic: in this box, the unit box plus a radius, no image of a point is near another point.
///
/// It includes pairs below the radius, not at it; no pair of a random cloud is at it.
fn box_without_images(radius: f64) -> Cell {
    let side = 1.0 + 1.001 * radius;
    Cell::ortho(side, side, side).unwrap()
}

/// linkcell: rows of 40 bytes, in a new vector each time.
pub(crate) fn linkcell_rows(points: &[[f64; 3]], radius: f64, sense: Sense) -> Vec<linkcell::Pair> {
    let is_half = sense == Sense::Unordered;
    let cell = box_without_images(radius);
    pairs_within(black_box(points), &cell, radius, None, None, is_half).unwrap()
}

/// linkcell: columns of 28 bytes per pair, which keep their memory.
pub(crate) fn linkcell_columns(
    points: &[[f64; 3]],
    radius: f64,
    sense: Sense,
    columns: &mut PairColumns,
) {
    let is_half = sense == Sense::Unordered;
    let cell = box_without_images(radius);
    pairs_within_columns(black_box(points), &cell, radius, None, None, is_half, columns).unwrap();
}

/// zelll: each pair once, passed to a visitor.
///
/// Rebuilding a grid from points that are still in their cells skips half of the work, which moving points do not
/// allow.
pub(crate) fn zelll(points: &[[f64; 3]], radius: f64, mut visit: impl FnMut(u32, u32)) {
    let grid = CellGrid::new((0_u32..).zip(black_box(points).iter().copied()), radius);
    let limit = radius * radius;
    grid.particle_pairs().for_each(|(&(i, p), &(j, q))| {
        let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        if x * x + y * y + z * z <= limit {
            visit(i, j);
        }
    });
}
