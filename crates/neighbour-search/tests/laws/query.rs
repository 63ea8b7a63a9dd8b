//! Questions about a place have the answers of a loop over all points.

use std::ops::ControlFlow;

use neighbour_search::{
    CellGrid, Criterion, Domain, Error, LeafTree, NeighbourList, NeighbourSearch, Radii,
};
use proptest::prelude::*;

/// As the crate decides: axes summed in order from 0.
fn square<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b))
}

/// Every point by distance from a place, those alike by index.
fn by_distance<const D: usize>(points: &[[f64; D]], centre: &[f64; D]) -> Vec<(f64, usize)> {
    let mut all: Vec<_> = points.iter().zip(0..).map(|(x, j)| (square(centre, x), j)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    all
}

fn answers_are_those_of_a_loop<const D: usize>(
    random: &[[f64; 6]],
    scale: f64,
    edge: f64,
    radius: f64,
    k: usize,
) {
    let point = |x: &[f64; 6]| -> [f64; D] { std::array::from_fn(|axis| x[axis]) };
    // A lattice whose distances tie, with duplicates; the first of it is stretched to make outliers.
    let lattice = |x: &[f64; 6]| point(x).map(|value| (8.0 * value).floor() / 8.0);
    let clouds = [
        random.iter().map(point).collect::<Vec<_>>(),
        random.iter().map(lattice).collect(),
        random
            .iter()
            .zip(0..)
            .map(|(x, k)| if k < 3 { point(x).map(|v| v * scale) } else { point(x) })
            .collect(),
        random[..1].iter().map(point).collect(),
        Vec::new(),
    ];
    let (mut grid, mut tree, mut found) = (CellGrid::new(), LeafTree::new(), Vec::new());
    for points in clouds {
        grid.build(&points, edge).unwrap();
        tree.build(&points, edge).unwrap();
        assert_eq!([grid.n_points(), tree.n_points()], [points.len(); 2]);
        let far = point(&random[1]).map(|value| -value * scale);
        let places = [point(&random[0]), lattice(&random[1]), far];
        for centre in places {
            let all = by_distance(&points, &centre);
            grid.nearest(&centre, k, &mut found).unwrap();
            let expected: Vec<usize> = all.iter().take(k).map(|near| near.1).collect();
            assert_eq!(found.iter().map(|near| near.j).collect::<Vec<_>>(), expected);
            tree.nearest(&centre, k, &mut found).unwrap();
            assert_eq!(found.iter().map(|near| near.j).collect::<Vec<_>>(), expected);

            let mut visited = Vec::new();
            let flow = grid.for_each_within(&centre, radius, |near| {
                assert_eq!(near.x_ij[0].to_bits(), (centre[0] - points[near.j][0]).to_bits());
                assert_eq!(near.r.to_bits(), square(&centre, &points[near.j]).sqrt().to_bits());
                visited.push(near.j);
                ControlFlow::<()>::Continue(())
            });
            assert_eq!(flow, Ok(ControlFlow::Continue(())));
            let mut by_tree = Vec::new();
            let _ = tree.for_each_within(&centre, radius, |near| {
                by_tree.push(near.j);
                ControlFlow::<()>::Continue(())
            });
            by_tree.sort_unstable();
            visited.sort_unstable();
            let within = all.iter().filter(|near| near.0 <= radius * radius);
            let mut expected: Vec<usize> = within.map(|near| near.1).collect();
            expected.sort_unstable();
            assert_eq!(visited, expected);
            assert_eq!(by_tree, expected);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn places_are_answered_as_a_loop_would(
        random in prop::collection::vec(prop::array::uniform6(0.0..1.0_f64), 4..150),
        exponent in 0..200_i32,
        edge in 0.01..2.0_f64,
        radius in 0.05..1.5_f64,
        k in 0..200_usize,
    ) {
        let scale = 10_f64.powi(exponent);
        answers_are_those_of_a_loop::<1>(&random, scale, edge, radius, k);
        answers_are_those_of_a_loop::<2>(&random, scale, edge, radius, k);
        answers_are_those_of_a_loop::<3>(&random, scale, edge, radius, k);
        answers_are_those_of_a_loop::<6>(&random, scale, edge, radius, k);
    }
}

#[test]
fn visitor_that_breaks_is_not_called_again() {
    let mut grid = CellGrid::new();
    grid.build(&[[0.0], [0.5], [1.0]], 1.0).unwrap();
    let mut calls = 0;
    let flow = grid.for_each_within(&[0.0], 2.0, |near| {
        calls += 1;
        ControlFlow::Break(near.j)
    });
    assert_eq!((flow, calls), (Ok(ControlFlow::Break(0)), 1));
}

#[test]
fn grid_that_built_a_list_answers_about_its_points() {
    let (mut grid, mut list) = (CellGrid::new(), NeighbourList::new());
    let radii = Radii::PerPoint { radii: &[1.0, 2.0, 3.0], criterion: Criterion::Max };
    grid.full_list(&[[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]], radii, &mut list).unwrap();
    let mut found = Vec::new();
    grid.nearest(&[0.0, 3.0], 2, &mut found).unwrap();
    assert_eq!([found[0].j, found[1].j], [2, 0]);
    assert_eq!(found[1].x_ij[1].to_bits(), 3.0_f64.to_bits());
}

#[test]
fn places_and_edges_that_are_none_are_refused() {
    let mut grid = CellGrid::new();
    grid.build(&[[0.0, 0.0]], 1.0).unwrap();
    let mut found = Vec::new();
    let place = Error::PlaceNotFinite { axis: 1, value: f64::INFINITY };
    assert_eq!(grid.nearest(&[0.0, f64::INFINITY], 1, &mut found), Err(place));
    let go_on = |_| ControlFlow::<()>::Continue(());
    assert_eq!(grid.for_each_within(&[0.0, f64::INFINITY], 1.0, go_on), Err(place));
    for value in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(
            grid.for_each_within(&[0.0; 2], value, go_on),
            Err(Error::UniformRadius { value })
        );
        assert_eq!(grid.build(&[[0.0; 2]], value), Err(Error::UniformRadius { value }));
    }
    let point = Error::CoordinateNotFinite { particle: 0, axis: 0, value: f64::NEG_INFINITY };
    assert_eq!(grid.build(&[[f64::NEG_INFINITY, 0.0]], 1.0), Err(point));
    assert_eq!(grid.n_points(), 1, "a refused build leaves the grid as it was");
}

#[test]
fn places_in_a_periodic_space_see_images() {
    let ring = Domain::periodic([Some(10.0), None]).unwrap();
    let points: Vec<[f64; 2]> = (0..10).map(|k| [f64::from(k) + 20.0, 0.0]).collect();
    let mut grid = CellGrid::in_domain(ring);
    let mut tree = LeafTree::in_domain(ring);
    grid.build(&points, 3.0).unwrap();
    tree.build(&points, 3.0).unwrap();
    let mut found = Vec::new();
    grid.nearest(&[9.75, 0.0], 4, &mut found).unwrap();
    assert_eq!(found.iter().map(|near| near.j).collect::<Vec<_>>(), [0, 9, 1, 8]);
    assert!((found[0].x_ij[0] + 0.25).abs() == 0.0);
    tree.nearest(&[-0.25, 0.0], 10, &mut found).unwrap();
    assert_eq!(found.len(), 10);
    assert_eq!(found[9].j, 5);
    let mut n_within = 0;
    let _ = tree
        .for_each_within(&[9.75, 0.0], 5.0, |near| {
            n_within += usize::from(near.r <= 5.0);
            ControlFlow::<()>::Continue(())
        })
        .unwrap();
    assert_eq!(n_within, 10);
    let go_on = |_| ControlFlow::<()>::Continue(());
    let refused = Error::PeriodTooShort { axis: 0, period: 10.0, least: 12.0 };
    assert_eq!(grid.for_each_within(&[0.0; 2], 6.0, go_on), Err(refused));
}
