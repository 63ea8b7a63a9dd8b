//! Neighbour lists of clouds in random memory order; the structure is rebuilt each time, as for moving particles.
//!
//! Every contender writes every pair to memory, except where pairs are only counted, and is checked for the same pairs
//! before measurement. Outputs differ. `CellGrid` has compressed rows of four bytes per pair; the queries of the trees
//! such rows in their order. linkcell stores the pair with image and squared distance, 28 or 40 bytes. zelll, kiddo's
//! join, and kiddo for the larger radius store loose pairs. Lists keep their memory between runs if the interface
//! accepts a buffer.

#![expect(
    clippy::unwrap_used,
    reason = "a cloud that a search refuses is a mistake of the benchmark"
)]

mod clouds;
mod found;
mod rivals;

use std::alloc::System;
use std::hint::black_box;

use benches::CpuTime;
use benches::ratios::{Ratios, Work};
use cap::Cap;
use criterion::Criterion;
use linkcell::PairColumns;
use neighbour_search::{
    CellGrid, Criterion as Sight, LeafTree, NeighbourList, NeighbourSearch, Radii,
};

use crate::found::{Fingerprint, Rows, Sense, agreed};
use crate::rivals::{kiddo_join, linkcell_columns, linkcell_rows, plane, rstar, space, zelll};

/// Counts bytes for all contenders; a few nanoseconds for each allocator call.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Neighbours in the interior of a uniform cloud in space; with its faces the mean is about 43.
const IN_SPACE: f64 = 45.0;
const IN_PLANE: f64 = 20.0;

/// Our search: the list, its contents, and the closure that rebuilds it.
fn ours<const D: usize>(
    points: &[[f64; D]],
    radii: Radii<'_>,
    sense: Sense,
) -> (Fingerprint, impl FnMut()) {
    by(CellGrid::new(), points, radii, sense)
}

/// The same for a given search.
fn by<const D: usize>(
    mut search: impl NeighbourSearch<D>,
    points: &[[f64; D]],
    radii: Radii<'_>,
    sense: Sense,
) -> (Fingerprint, impl FnMut()) {
    let mut list = NeighbourList::new();
    let mut search = move |list: &mut NeighbourList| match sense {
        Sense::Directed => search.full_list(black_box(points), radii, list).unwrap(),
        Sense::Unordered => search.half_list(black_box(points), radii, list).unwrap(),
    };
    search(&mut list);
    (Fingerprint::of(&list, sense), move || search(&mut list))
}

/// A cloud in space: all pairs in both directions, or each pair once.
fn in_space(ratios: &mut Ratios, name: &str, n_points: usize, sense: Sense) {
    if !ratios.wants(name) {
        return;
    }
    let (points, radius) = clouds::uniform::<3>(n_points, IN_SPACE);
    let points = points.as_slice();
    let (pairs, cell_grid) = ours(points, Radii::Uniform(radius), sense);
    let (rows, columns) = linkcell(points, radius, pairs, sense);
    let target = if sense == Sense::Directed { 3.0 } else { 4.0 };
    let work = Work::new(name, pairs.n_pairs, "CellGrid", cell_grid)
        .rival_to_beat("linkcell, rows", target, rows)
        .rival_to_beat("linkcell, columns", target, columns);
    if sense == Sense::Directed {
        ratios.measure(work);
        return;
    }
    let written = agreed(pairs, "zelll", Vec::new(), move |written| {
        written.clear();
        zelll(points, radius, |i, j| written.push([i, j]));
    });
    let counted = move || {
        let mut n_pairs = 0;
        zelll(points, radius, |_, _| n_pairs += 1);
        assert_eq!(n_pairs, pairs.n_pairs, "zelll");
    };
    ratios.measure(
        work.rival_to_beat("zelll, written", target, written).rival("zelll, only counted", counted),
    );
}

fn linkcell(
    points: &[[f64; 3]],
    radius: f64,
    pairs: Fingerprint,
    sense: Sense,
) -> (impl FnMut(), impl FnMut()) {
    let rows = agreed(pairs, "linkcell, rows", Vec::new(), move |rows| {
        *rows = Vec::new();
        *rows = linkcell_rows(points, radius, sense);
    });
    let columns = agreed(pairs, "linkcell, columns", PairColumns::default(), move |columns| {
        linkcell_columns(points, radius, sense, columns);
    });
    (rows, columns)
}

fn full_in_plane(ratios: &mut Ratios) {
    let (points, radius) = clouds::uniform::<2>(100_000, IN_PLANE);
    let (pairs, cell_grid) = ours(&points, Radii::Uniform(radius), Sense::Directed);
    let queries = agreed(pairs, "kiddo", Rows::default(), |rows| {
        plane::kiddo(&points, |_| radius, rows);
    });
    let join = agreed(pairs, "kiddo, join", Vec::new(), |joined| {
        *joined = kiddo_join(&points, radius);
    });
    ratios.measure(
        Work::new("2-D full list, 100k", pairs.n_pairs, "CellGrid", cell_grid)
            .rival_to_beat("kiddo", 12.0, queries)
            .rival_to_beat("kiddo, join", 12.0, join),
    );
}

/// A radius for each point; its own decides.
fn gather(ratios: &mut Ratios) {
    let (points, radii) = clouds::normal::<3>(100_000, IN_SPACE);
    let sight = Radii::PerPoint { radii: &radii, criterion: Sight::Gather };
    let (pairs, leaf_tree) = by(LeafTree::new(), &points, sight, Sense::Directed);
    let (same_pairs, cell_grid) = by(CellGrid::new(), &points, sight, Sense::Directed);
    assert_eq!(pairs, same_pairs);
    let queries = agreed(pairs, "kiddo", Rows::default(), |rows| {
        space::kiddo(&points, |i| radii[i], rows);
    });
    let work = "3-D normal cloud, 100k, radii 20:1, gather";
    ratios.measure(
        Work::new(work, pairs.n_pairs, "LeafTree", leaf_tree)
            .rival_to_beat("kiddo", 3.5, queries)
            .rival("our CellGrid", cell_grid),
    );
}

/// A radius for each point; the larger decides.
fn larger(criterion: &mut Criterion<CpuTime>, ratios: &mut Ratios) {
    let name = |d: usize| format!("neighbour/{d}-D normal cloud, 20k, radii 20 to 1, max");
    let (points, radii) = clouds::normal::<2>(20_000, IN_PLANE);
    let sight = Radii::PerPoint { radii: &radii, criterion: Sight::Max };
    let (pairs, leaf_tree) = by(LeafTree::new(), &points, sight, Sense::Directed);
    let queries = agreed(pairs, "kiddo", Vec::new(), |found| {
        plane::kiddo_max(&points, &radii, found);
    });
    let work = Work::new(name(2), pairs.n_pairs, "LeafTree", leaf_tree);
    ratios.measure(work.rival("kiddo", queries).in_criterion(criterion));

    let (points, radii) = clouds::normal::<3>(20_000, IN_SPACE);
    let sight = Radii::PerPoint { radii: &radii, criterion: Sight::Max };
    let (pairs, leaf_tree) = by(LeafTree::new(), &points, sight, Sense::Directed);
    let queries = agreed(pairs, "kiddo", Vec::new(), |found| {
        space::kiddo_max(&points, &radii, found);
    });
    let work = Work::new(name(3), pairs.n_pairs, "LeafTree", leaf_tree);
    ratios.measure(work.rival("kiddo", queries).in_criterion(criterion));
}

/// A cloud in space with instructions that every machine supports; linkcell is unchanged.
fn portable(ratios: &mut Ratios) {
    let (points, radius) = clouds::uniform::<3>(100_000, IN_SPACE);
    let (points, sense) = (points.as_slice(), Sense::Directed);
    let portable = CellGrid::new().with_portable_instructions();
    let (pairs, cell_grid) = by(portable, points, Radii::Uniform(radius), sense);
    let (rows, columns) = linkcell(points, radius, pairs, sense);
    let name = "3-D full list, 100k, portable";
    ratios.measure(
        Work::new(name, pairs.n_pairs, "CellGrid", cell_grid)
            .rival_to_beat("linkcell, rows", 1.0, rows)
            .rival_to_beat("linkcell, columns", 1.0, columns),
    );
}

/// Two threads compared with one, by wall time.
fn two_threads(ratios: &mut Ratios) {
    let (points, radius) = clouds::uniform::<3>(1_000_000, IN_SPACE);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let list_by = |threads| {
        let (pool, mut grid, mut list) = (pool(threads), CellGrid::new(), NeighbourList::new());
        let radii = Radii::Uniform(radius);
        let points = points.as_slice();
        move || pool.install(|| grid.full_list(black_box(points), radii, &mut list).unwrap())
    };
    ratios.wall(
        "3-D full list, 1M, wall time",
        ["two threads", "one"],
        1.7,
        list_by(2),
        list_by(1),
    );
}

/// The cloud of a density solver, small and dense.
fn lattice(criterion: &mut Criterion<CpuTime>, ratios: &mut Ratios) {
    let (points, radius) = (clouds::sheared_lattice(), 2.5);
    let (pairs, cell_grid) = ours(&points, Radii::Uniform(radius), Sense::Directed);
    let queries = agreed(pairs, "kiddo", Rows::default(), |rows| {
        plane::kiddo(&points, |_| radius, rows);
    });
    let join = agreed(pairs, "kiddo, join", Vec::new(), |joined| {
        *joined = kiddo_join(&points, radius);
    });
    let r_tree = agreed(pairs, "rstar", Rows::default(), |rows| rstar(&points, radius, rows));
    ratios.measure(
        Work::new("neighbour/2-D sheared lattice, 1681", pairs.n_pairs, "CellGrid", cell_grid)
            .rival("kiddo", queries)
            .rival("kiddo, join", join)
            .rival("rstar", r_tree)
            .in_criterion(criterion),
    );
}

/// Peak allocated bytes while a list of a million points is built from scratch, without the points.
fn memory(ratios: &mut Ratios) {
    let work = "3-D full list, 1M, bytes at the peak";
    if !ratios.wants(work) || !ratios.is_measured() {
        return;
    }
    let (points, radius) = clouds::uniform::<3>(1_000_000, IN_SPACE);
    let cell_grid = peak(|| {
        let (mut grid, mut list) = (CellGrid::new(), NeighbourList::new());
        grid.full_list(&points, Radii::Uniform(radius), &mut list).unwrap();
    });
    let columns = peak(|| {
        linkcell_columns(&points, radius, Sense::Directed, &mut PairColumns::default());
    });
    let rows = peak(|| drop(linkcell_rows(&points, radius, Sense::Directed)));
    ratios.bytes(work, cell_grid, "linkcell, rows", rows, 4.0);
    ratios.bytes(work, cell_grid, "linkcell, columns", columns, 4.0);
}

/// The allocator reports only the overall peak, so each peak must exceed the earlier ones.
fn peak(run: impl FnOnce()) -> usize {
    let (allocated, highest) = (ALLOCATOR.allocated(), ALLOCATOR.max_allocated());
    run();
    assert!(ALLOCATOR.max_allocated() > highest, "measure the memory of this one earlier");
    ALLOCATOR.max_allocated() - allocated
}

fn main() {
    let mut ratios = Ratios::from_args("neighbour");
    // On one thread, as the rivals.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| one_thread(&mut ratios));
    if ratios.is_measured() {
        two_threads(&mut ratios);
    }
    ratios.note(
        "TreeNSearch (C++, f32, not run here), 3-D full list on an EPYC of Zen 4: 235 M/s at 100k and 221 at 1M on points \
         already sorted, 56 and 32 in random order.",
    );
    ratios.print();
}

fn one_thread(ratios: &mut Ratios) {
    let mut criterion = benches::criterion();
    memory(ratios);
    lattice(&mut criterion, ratios);
    full_in_plane(ratios);
    in_space(ratios, "3-D full list, 100k", 100_000, Sense::Directed);
    in_space(ratios, "3-D half list, 100k", 100_000, Sense::Unordered);
    portable(ratios);
    gather(ratios);
    larger(&mut criterion, ratios);
    if ratios.is_measured() {
        in_space(ratios, "3-D full list, 1M", 1_000_000, Sense::Directed);
        in_space(ratios, "3-D half list, 1M", 1_000_000, Sense::Unordered);
    }
    criterion.final_summary();
}
