//! A second build of the same size allocates nothing.

use std::alloc::System;

use cap::Cap;
use neighbour_search::{
    CellGrid, Criterion, LeafTree, NeighbourList, NeighbourSearch, Radii, SkinList,
};

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Bytes that a second call allocates, freed again or not.
fn second(mut call: impl FnMut()) -> usize {
    call();
    let before = ALLOCATOR.total_allocated();
    call();
    ALLOCATOR.total_allocated() - before
}

/// One test, so that no other allocates meanwhile; on one thread, since a pool may allocate whenever it likes.
#[test]
fn second_build_of_the_same_size_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let points: Vec<[f64; 3]> = (0..5000)
            .map(|k| [f64::from(k % 17), f64::from(k / 17 % 17), f64::from(k / 289)])
            .collect();
        let own: Vec<f64> = (0..5000).map(|k| 1.0 + 0.2 * f64::from(k % 7)).collect();
        let per_point = Criterion::ALL.map(|criterion| Radii::PerPoint { radii: &own, criterion });
        let mut list = NeighbourList::new();
        for radii in [Radii::Uniform(1.5)].into_iter().chain(per_point) {
            let (mut grid, mut tree) = (CellGrid::new(), LeafTree::new());
            assert_eq!(second(|| grid.full_list(&points, radii, &mut list).unwrap()), 0);
            assert_eq!(second(|| tree.full_list(&points, radii, &mut list).unwrap()), 0);
            let visit = &mut |_: neighbour_search::Row<'_, 3>| ();
            assert_eq!(second(|| grid.for_each_row(&points, radii, visit).unwrap()), 0);
        }
        let (mut skin, mut turn) = (SkinList::new(0.5).unwrap(), 0);
        let moved: Vec<[f64; 3]> = points.iter().map(|x| [x[2], x[0], x[1]]).collect();
        let mut update = || {
            turn += 1;
            let points = if turn % 2 == 0 { &points } else { &moved };
            skin.update(points, Radii::Uniform(1.5)).unwrap();
        };
        // Both clouds once: the second needs a little more room than the first.
        update();
        update();
        assert_eq!(second(update), 0);
        assert!(list.n_pairs() > 10_000);
    });
}
