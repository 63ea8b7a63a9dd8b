//! Full neighbour lists of clouds in shuffled order, the structure built anew each time, as particles that move need it.
//!
//! Everyone writes every pair to memory, in both directions, and is checked to find the same pairs before it is measured.
//! What they leave behind differs: `CellGrid` compressed rows, sorted; the rivals' queries compressed rows in the order of
//! their trees (and rows sorted afterwards, where it says so); kiddo's join, and kiddo where the larger radius decides,
//! loose pairs. Lists keep their memory from build to build; the rivals' trees cannot.

#![expect(
    clippy::unwrap_used,
    reason = "a cloud that a search refuses is a mistake of the benchmark"
)]

use std::hint::black_box;

use benches::CpuTime;
use criterion::measurement::Measurement;
use criterion::{BenchmarkGroup, Criterion, Throughput};
use kiddo::{ImmutableKdTree, PairQueryResult, SquaredEuclidean};
use neighbour_search::{CellGrid, Criterion as Sight, NeighbourList, NeighbourSearch, Radii};
use particle_store::Lattice;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rstar::RTree;
use rstar::primitives::GeomWithData;

const N_POINTS: usize = 20_000;

/// The list that a rival makes: row `i` is `indices[offsets[i]..offsets[i + 1]]`.
#[derive(Debug, Default)]
struct Rows {
    offsets: Vec<usize>,
    indices: Vec<u32>,
}

impl Rows {
    fn restart(&mut self) {
        self.indices.clear();
        self.offsets.clear();
        self.offsets.push(0);
    }

    fn end_row(&mut self) {
        self.offsets.push(self.indices.len());
    }

    fn sort(&mut self) {
        for ends in self.offsets.windows(2) {
            self.indices[ends[0]..ends[1]].sort_unstable();
        }
    }

    /// All pairs (i, j), sorted.
    fn pairs(&self) -> Vec<[u32; 2]> {
        let rows = self.offsets.windows(2).zip(0..);
        let mut pairs: Vec<_> = rows
            .flat_map(|(ends, i)| self.indices[ends[0]..ends[1]].iter().map(move |&j| [i, j]))
            .collect();
        pairs.sort_unstable();
        pairs
    }
}

/// Numbers whose seed is the benchmark's own, so that every run sees the same clouds.
fn random<T, L: Distribution<T>>(law: L) -> impl FnMut() -> T {
    let mut generator = ChaCha8Rng::seed_from_u64(20);
    move || law.sample(&mut generator)
}

fn shuffle<T>(items: &mut [T]) {
    let mut next = random::<u64, _>(StandardUniform);
    for last in (1..items.len()).rev() {
        items.swap(last, usize::try_from(next() % (last as u64 + 1)).unwrap());
    }
}

/// The cloud of a density solver: 41 x 41 particles over 6 standard deviations, sheared and turned by the flow. Spacing 1.
fn sheared_lattice() -> Vec<[f64; 2]> {
    let lattice = Lattice::<2>::box_lattice([20.0; 2], [41; 2]).unwrap();
    let (sin, cos) = 0.5_f64.sin_cos();
    let mut points: Vec<_> = lattice
        .points
        .iter()
        .map(|[x, y]| {
            let x = x + 0.2 * y;
            [cos * x - sin * y, sin * x + cos * y]
        })
        .collect();
    shuffle(&mut points);
    points
}

/// Independent points in the unit box.
fn uniform_cloud<const D: usize>() -> Vec<[f64; D]> {
    let mut next = random::<f64, _>(StandardUniform);
    (0..N_POINTS).map(|_| std::array::from_fn(|_| next())).collect()
}

/// A normal cloud, and radii that hold about `neighbours` everywhere: `h` goes with the density to the power `-1/D`, up to
/// 20 times its smallest.
fn normal_cloud<const D: usize>(neighbours: f64) -> (Vec<[f64; D]>, Vec<f64>) {
    let mut next = random::<f64, _>(StandardNormal);
    let points: Vec<[f64; D]> = (0..N_POINTS).map(|_| std::array::from_fn(|_| next())).collect();
    let densest = N_POINTS as f64 / std::f64::consts::TAU.powf(D as f64 / 2.0);
    let smallest = radius::<D>(neighbours, densest);
    let radii = points
        .iter()
        .map(|x| {
            let square: f64 = x.iter().map(|x_k| x_k * x_k).sum();
            smallest * (0.5 * square / D as f64).exp().min(20.0)
        })
        .collect();
    (points, radii)
}

/// Radius of the disc or ball that holds so many points at a density.
fn radius<const D: usize>(neighbours: f64, density: f64) -> f64 {
    let unit_ball = if D == 2 { std::f64::consts::PI } else { std::f64::consts::PI * 4.0 / 3.0 };
    (neighbours / (density * unit_ball)).powf(1.0 / D as f64)
}

/// The rivals, for one dimension: kiddo's traits do not let a function be generic over it.
macro_rules! rivals {
    ($module:ident, $dimension:literal) => {
        mod $module {
            use super::*;

            const D: usize = $dimension;

            /// kiddo: a tree, then a query for each point.
            pub(super) fn kiddo(
                points: &[[f64; D]],
                radius: impl Fn(usize) -> f64,
                rows: &mut Rows,
            ) {
                let tree = ImmutableKdTree::<f64, D>::new_from_slice(points).unwrap();
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

            /// kiddo: each pair found by the point that sees farther, and written both ways.
            pub(super) fn kiddo_max(points: &[[f64; D]], radii: &[f64], pairs: &mut Vec<[u32; 2]>) {
                let tree = ImmutableKdTree::<f64, D>::new_from_slice(points).unwrap();
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

            /// kiddo: the join of two trees of the same points, which it wants to be two. Each point finds itself as well.
            pub(super) fn kiddo_join(
                points: &[[f64; D]],
                radius: f64,
            ) -> Vec<PairQueryResult<u32, u32, ()>> {
                let [tree, twin] =
                    [(); 2].map(|()| ImmutableKdTree::<f64, D>::new_from_slice(points).unwrap());
                tree.query_tree(&twin)
                    .within::<SquaredEuclidean<f64>>(radius * radius)
                    .without_distances()
                    .execute()
            }

            /// rstar: a tree loaded in bulk, then a query for each point.
            pub(super) fn rstar(
                points: &[[f64; D]],
                radius: impl Fn(usize) -> f64,
                rows: &mut Rows,
            ) {
                let leaves = points.iter().zip(0..).map(|(x, i)| GeomWithData::new(*x, i));
                let tree = RTree::<GeomWithData<[f64; D], u32>>::bulk_load(leaves.collect());
                rows.restart();
                for (i, x) in points.iter().enumerate() {
                    let reach = radius(i);
                    for leaf in tree.locate_within_distance(*x, reach * reach) {
                        if leaf.data as usize != i {
                            rows.indices.push(leaf.data);
                        }
                    }
                    rows.end_row();
                }
            }

            /// One radius for all.
            pub(super) fn uniform(
                criterion: &mut Criterion<CpuTime>,
                name: &str,
                points: &[[f64; D]],
                radius: f64,
            ) {
                let mut rows = Rows::default();
                let mut group = criterion.benchmark_group(name);
                let pairs = cell_grid(&mut group, points, Radii::Uniform(radius));

                kiddo(points, |_| radius, &mut rows);
                assert_eq!(rows.pairs(), pairs, "kiddo");
                group.bench_function("kiddo", |b| {
                    b.iter(|| kiddo(black_box(points), |_| radius, &mut rows));
                });
                group.bench_function("kiddo, rows sorted", |b| {
                    b.iter(|| {
                        kiddo(black_box(points), |_| radius, &mut rows);
                        rows.sort();
                    });
                });
                let joined = kiddo_join(points, radius);
                let others = joined.iter().filter(|pair| pair.left_item != pair.right_item);
                let others = others.map(|pair| [pair.left_item, pair.right_item]).collect();
                assert_eq!(sorted(others), pairs, "kiddo, join");
                group.bench_function("kiddo, join", |b| {
                    b.iter(|| kiddo_join(black_box(points), radius));
                });
                rstar(points, |_| radius, &mut rows);
                assert_eq!(rows.pairs(), pairs, "rstar");
                group.bench_function("rstar", |b| {
                    b.iter(|| rstar(black_box(points), |_| radius, &mut rows));
                });
                group.finish();
            }

            /// A radius for each point, of which its own decides.
            pub(super) fn gather(
                criterion: &mut Criterion<CpuTime>,
                name: &str,
                (points, radii): &(Vec<[f64; D]>, Vec<f64>),
            ) {
                let mut rows = Rows::default();
                let mut group = criterion.benchmark_group(name);
                let sight = Radii::PerPoint { radii, criterion: Sight::Gather };
                let pairs = cell_grid(&mut group, points, sight);

                kiddo(points, |i| radii[i], &mut rows);
                assert_eq!(rows.pairs(), pairs, "kiddo");
                group.bench_function("kiddo", |b| {
                    b.iter(|| kiddo(black_box(points), |i| radii[i], &mut rows));
                });
                rstar(points, |i| radii[i], &mut rows);
                assert_eq!(rows.pairs(), pairs, "rstar");
                group.bench_function("rstar", |b| {
                    b.iter(|| rstar(black_box(points), |i| radii[i], &mut rows));
                });
                group.finish();
            }

            /// A radius for each point, of which the larger decides.
            pub(super) fn larger(
                criterion: &mut Criterion<CpuTime>,
                name: &str,
                (points, radii): &(Vec<[f64; D]>, Vec<f64>),
            ) {
                let mut found = Vec::new();
                let mut group = criterion.benchmark_group(name);
                let sight = Radii::PerPoint { radii, criterion: Sight::Max };
                let pairs = cell_grid(&mut group, points, sight);

                kiddo_max(points, radii, &mut found);
                assert_eq!(sorted(found.clone()), pairs, "kiddo");
                group.bench_function("kiddo", |b| {
                    b.iter(|| kiddo_max(black_box(points), radii, &mut found));
                });
                group.finish();
            }
        }
    };
}
rivals!(plane, 2);
rivals!(space, 3);

fn sorted(mut pairs: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    pairs.sort_unstable();
    pairs
}

/// Measures `CellGrid` and returns its pairs, which set the throughput of the group.
fn cell_grid<const D: usize>(
    group: &mut BenchmarkGroup<'_, impl Measurement>,
    points: &[[f64; D]],
    radii: Radii<'_>,
) -> Vec<[u32; 2]> {
    let (mut grid, mut list) = (CellGrid::new(), NeighbourList::new());
    grid.full_list(points, radii, &mut list).unwrap();
    let pairs =
        list.rows().zip(0..).flat_map(|(row, i)| row.iter().map(move |&j| [i, j])).collect();
    group.throughput(Throughput::Elements(list.n_pairs() as u64));
    group.bench_function("CellGrid", |b| {
        b.iter(|| grid.full_list(black_box(points), radii, &mut list));
    });
    pairs
}

fn main() {
    let mut criterion = benches::criterion();
    plane::uniform(&mut criterion, "neighbour/2d lattice 1681", &sheared_lattice(), 2.5);
    let random_name = |d: usize| format!("neighbour/{d}d random 20000");
    let dense = N_POINTS as f64;
    plane::uniform(&mut criterion, &random_name(2), &uniform_cloud(), radius::<2>(20.0, dense));
    space::uniform(&mut criterion, &random_name(3), &uniform_cloud(), radius::<3>(43.0, dense));

    let (flat, deep) = (normal_cloud::<2>(20.0), normal_cloud::<3>(43.0));
    plane::gather(&mut criterion, "neighbour/2d radii 20 to 1, gather", &flat);
    plane::larger(&mut criterion, "neighbour/2d radii 20 to 1, max", &flat);
    space::gather(&mut criterion, "neighbour/3d radii 20 to 1, gather", &deep);
    space::larger(&mut criterion, "neighbour/3d radii 20 to 1, max", &deep);
    criterion.final_summary();
}
