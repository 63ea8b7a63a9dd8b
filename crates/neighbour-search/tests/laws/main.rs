//! Every search gives the list that brute force gives, whatever the cloud.
//!
//! One program with the laws of queries and skins, so that each search is compiled once for each number of dimensions.

#![expect(clippy::unwrap_used, reason = "a law that cannot be put to the test has failed")]

mod custom_search;
mod many;
mod query;
mod skin;

use neighbour_search::{
    BruteForce, CellGrid, Criterion, Domain, Error, LeafTree, NeighbourList, NeighbourSearch, Radii,
};
use proptest::prelude::*;

/// Clouds that searches have been known to get wrong.
#[derive(Debug, Clone, Copy)]
enum Cloud {
    Uniform,
    /// Distances tie with the radius.
    Lattice,
    Clustered,
    /// No extent but along one axis.
    Collinear,
    Duplicated,
    /// One point far beyond the others.
    Outlier,
    /// Coordinates whose differences overflow.
    Huge,
    OnePoint,
    Empty,
}

const CLOUDS: [Cloud; 9] = [
    Cloud::Uniform,
    Cloud::Lattice,
    Cloud::Clustered,
    Cloud::Collinear,
    Cloud::Duplicated,
    Cloud::Outlier,
    Cloud::Huge,
    Cloud::OnePoint,
    Cloud::Empty,
];

/// The cloud made of random numbers in [0, 1).
fn cloud<const D: usize>(kind: Cloud, random: &[[f64; 6]]) -> Vec<[f64; D]> {
    let point = |k: usize| -> [f64; D] { std::array::from_fn(|axis| random[k][axis]) };
    let all = 0..random.len();
    match kind {
        Cloud::Uniform => all.map(point).collect(),
        Cloud::Lattice => all.map(|k| point(k).map(|value| (6.0 * value).floor() * 0.1)).collect(),
        Cloud::Clustered => {
            all.map(|k| point(k).map(|value| (k % 3) as f64 + 0.3 * value.powi(4))).collect()
        }
        Cloud::Collinear => all.map(|k| [0.7; D].map(|value| value * random[k][0])).collect(),
        Cloud::Duplicated => all.map(|k| point(k / 4 * 2)).collect(),
        Cloud::Outlier => {
            all.map(|k| if k == 7 { point(k).map(|value| 1e9 * value) } else { point(k) }).collect()
        }
        Cloud::Huge => all
            .map(|k| {
                if k % 5 == 0 {
                    point(k).map(|value| (2.0 * value - 1.0) * f64::MAX)
                } else {
                    point(k)
                }
            })
            .collect(),
        Cloud::OnePoint => vec![point(0)],
        Cloud::Empty => Vec::new(),
    }
}

/// All neighbour searches but brute force.
fn searches<const D: usize>(domain: Domain<D>) -> [(&'static str, Box<dyn NeighbourSearch<D>>); 2] {
    [
        ("CellGrid", Box::new(CellGrid::in_domain(domain))),
        ("LeafTree", Box::new(LeafTree::in_domain(domain))),
    ]
}

/// A space without end, one that is periodic along every axis, and one along every other axis: with a period of barely two
/// radii and a longer one.
fn domains<const D: usize>(largest: f64) -> [Domain<D>; 3] {
    let of = |periods| Domain::periodic(periods).unwrap();
    [
        Domain::unbounded(),
        of([Some(2.0 * largest); D]),
        of(std::array::from_fn(|axis| (axis % 2 == 0).then_some(2.7 * largest))),
    ]
}

/// Each pair of the full list once in the half list, or refused where that misses pairs.
fn halves_agree<const D: usize>(
    search: &mut dyn NeighbourSearch<D>,
    points: &[[f64; D]],
    radii: Radii<'_>,
    full: &NeighbourList,
) {
    let mut list = NeighbourList::new();
    if let Radii::PerPoint { criterion, .. } = radii
        && !criterion.is_symmetric()
    {
        let refused = search.half_list(points, radii, &mut list);
        assert_eq!(refused, Err(Error::NotSymmetric { criterion }));
        return;
    }
    search.half_list(points, radii, &mut list).unwrap();
    assert_eq!(list.len(), full.len());
    let pairs = |list: &NeighbourList| {
        let mut pairs: Vec<[u32; 2]> =
            (0..).zip(list.rows()).flat_map(|(i, row)| row.iter().map(move |&j| [i, j])).collect();
        for pair in &mut pairs {
            pair.sort_unstable();
        }
        pairs.sort_unstable();
        pairs
    };
    let mut twice = pairs(full);
    assert!(twice.chunks(2).all(|both| both[0] == both[1]));
    twice.dedup();
    assert_eq!(pairs(&list), twice, "{search:?}");
}

/// Every point is visited once, with the neighbours, differences and distances of its row in the list.
fn rows_agree<const D: usize>(
    search: &mut dyn NeighbourSearch<D>,
    points: &[[f64; D]],
    radii: Radii<'_>,
    full: &NeighbourList,
) {
    let mut visited = vec![false; points.len()];
    let visit = &mut |row: neighbour_search::Row<'_, D>| {
        assert!(!std::mem::replace(&mut visited[row.i], true));
        let mut order: Vec<usize> = (0..row.j.len()).collect();
        order.sort_unstable_by_key(|&k| row.j[k]);
        let mut k = order.iter();
        full.for_each_pair_of(row.i, points, |pair| {
            let &k = k.next().unwrap();
            assert_eq!(row.j[k] as usize, pair.j);
            let x_ij = row.x_ij.map(|column| column[k]);
            assert_eq!(x_ij.map(f64::to_bits), pair.x_ij.map(f64::to_bits));
            assert_eq!(row.squared_distances[k].sqrt().to_bits(), pair.r.to_bits());
        })
        .unwrap();
        assert!(k.next().is_none());
        assert!(row.squared_distances.len() == row.j.len());
    };
    search.for_each_row(points, radii, visit).unwrap();
    assert!(visited.iter().all(|&is_visited| is_visited));
}

/// Number of pairs listed over all spaces, clouds and criteria, so that no agreement is about nothing.
///
/// `fixed` is a radius of all points, beside `radius`, and at least half a period.
fn agrees_with_brute_force<const D: usize>(random: &[[f64; 6]], radius: f64, fixed: f64) -> usize {
    let (mut expected, mut list) = (NeighbourList::new(), NeighbourList::new());
    let mut n_pairs = 0;
    // Seventyfold between the smallest and the largest.
    let own: Vec<f64> = random.iter().map(|x| radius * 70_f64.powf(x[5] - 0.5)).collect();
    let largest = own.iter().copied().fold(fixed.max(radius), f64::max);
    for domain in domains::<D>(largest) {
        let mut searches = searches(domain);
        for kind in CLOUDS {
            let points = cloud::<D>(kind, random);
            let own = &own[..points.len()];
            let per_point =
                Criterion::ALL.map(|criterion| Radii::PerPoint { radii: own, criterion });
            for radii in
                [Radii::Uniform(radius), Radii::Uniform(fixed)].into_iter().chain(per_point)
            {
                BruteForce::in_domain(domain).full_list(&points, radii, &mut expected).unwrap();
                for (name, search) in &mut searches {
                    search.full_list(&points, radii, &mut list).unwrap();
                    list.sort_rows();
                    assert_eq!(list, expected, "{name}, {domain:?}, {kind:?}, {radii:?}");
                    assert_eq!(list.len(), points.len());
                    n_pairs += list.n_pairs();
                    halves_agree(search.as_mut(), &points, radii, &expected);
                    rows_agree(search.as_mut(), &points, radii, &expected);
                }
            }
        }
    }
    n_pairs
}

fn numbers(n: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<[f64; 6]>> {
    prop::collection::vec(prop::array::uniform6(0.0..1.0_f64), n)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn every_search_lists_what_brute_force_lists(random in numbers(20..150), radius in 0.02..1.0_f64) {
        prop_assert!(agrees_with_brute_force::<1>(&random, radius, 0.2) > 0);
        prop_assert!(agrees_with_brute_force::<2>(&random, radius, 0.2) > 0);
        prop_assert!(agrees_with_brute_force::<3>(&random, radius, 0.2) > 0);
        prop_assert!(agrees_with_brute_force::<4>(&random, radius, 0.2) > 0);
        prop_assert!(agrees_with_brute_force::<5>(&random, radius, 0.2) > 0);
        prop_assert!(agrees_with_brute_force::<6>(&random, radius, 0.2) > 0);
    }

}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1))]

    #[test]
    fn every_search_lists_what_brute_force_lists_in_a_larger_cloud(random in numbers(1100..1200), radius in 0.005..0.04_f64) {
        prop_assert!(agrees_with_brute_force::<3>(&random, radius, 0.06) > 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn extreme_scales_change_nothing(random in numbers(60), exponent in -140..140_i32) {
        let scale = 10_f64.powi(exponent);
        let points: Vec<[f64; 2]> = random.iter().map(|x| [scale * x[0], scale * x[1]]).collect();
        let (mut expected, mut list) = (NeighbourList::new(), NeighbourList::new());
        let own: Vec<f64> = random.iter().map(|x| scale * 10_f64.powf(-8.0 * x[3])).collect();
        let own = Radii::PerPoint { radii: &own, criterion: Criterion::Max };
        let uniform = [0.3 * scale, 1e-150, 1e150].map(Radii::Uniform);
        for radii in uniform.into_iter().chain([own]) {
            BruteForce::new().full_list(&points, radii, &mut expected).unwrap();
            for (name, mut search) in searches(Domain::unbounded()) {
                search.full_list(&points, radii, &mut list).unwrap();
                list.sort_rows();
                prop_assert_eq!(&list, &expected, "{}", name);
            }
        }
    }

    /// Clouds far from where single precision could distinguish points.
    #[test]
    fn distance_from_the_origin_changes_nothing(random in numbers(80), exponent in 0..15_i32, apart in 0..12_i32) {
        let (far, apart) = (10_f64.powi(exponent), 10_f64.powi(apart));
        let mut points: Vec<[f64; 3]> = random.iter().map(|x| [far + x[0], x[1] - far, x[2]]).collect();
        // Two clouds that lie far apart.
        points.iter_mut().step_by(2).for_each(|x| x[0] += apart);
        let (mut expected, mut list) = (NeighbourList::new(), NeighbourList::new());
        let radii = Radii::Uniform(0.4);
        BruteForce::new().full_list(&points, radii, &mut expected).unwrap();
        for (name, mut search) in searches(Domain::unbounded()) {
            search.full_list(&points, radii, &mut list).unwrap();
            list.sort_rows();
            prop_assert_eq!(&list, &expected, "{}", name);
        }
    }

    #[test]
    fn pairs_carry_their_difference_and_distance(random in numbers(50), radius in 0.1..0.5_f64) {
        let points = cloud::<3>(Cloud::Uniform, &random);
        let mut list = NeighbourList::new();
        CellGrid::new().full_list(&points, Radii::Uniform(radius), &mut list).unwrap();
        let (mut all, mut by_point) = (Vec::new(), Vec::new());
        list.for_each_pair(&points, |pair| all.push(pair)).unwrap();
        for i in 0..points.len() {
            list.for_each_pair_of(i, &points, |pair| by_point.push(pair)).unwrap();
        }
        prop_assert_eq!(&all, &by_point);
        prop_assert_eq!(all.len(), list.n_pairs());
        for pair in all {
            let squared: f64 = (0..3).map(|axis| (points[pair.i][axis] - points[pair.j][axis]).powi(2)).sum();
            // A square root and the same sum: one rounding.
            prop_assert!((pair.r - squared.sqrt()).abs() <= f64::EPSILON * pair.r);
            prop_assert_eq!(pair.x_ij[2].to_bits(), (points[pair.i][2] - points[pair.j][2]).to_bits());
            prop_assert!(pair.r <= radius && pair.i != pair.j);
        }
    }
}

/// Points at 0, 1 and 3 with radii 1, 2 and 0.5, by hand.
#[test]
fn criteria_are_what_their_names_say() {
    let points = [[0.0], [1.0], [3.0]];
    let radii = [1.0, 2.0, 0.5];
    let listed = |criterion| {
        let mut list = NeighbourList::new();
        let radii = Radii::PerPoint { radii: &radii, criterion };
        BruteForce::new().full_list(&points, radii, &mut list).unwrap();
        list.rows().map(<[u32]>::to_vec).collect::<Vec<_>>()
    };
    assert_eq!(listed(Criterion::Gather), [vec![1], vec![0, 2], vec![]]);
    assert_eq!(listed(Criterion::Scatter), [vec![1], vec![0], vec![1]]);
    assert_eq!(listed(Criterion::Max), [vec![1], vec![0, 2], vec![1]]);
    // Means: 1.5 over distance 1; 1.25 over distance 2; 0.75 over distance 3.
    assert_eq!(listed(Criterion::Mean), [vec![1], vec![0], vec![]]);
}

/// A square lattice of unit spacing: 4 at distance 1, 4 at √2, 4 at 2, and 8 at √5.
#[test]
fn radius_is_inclusive_and_the_point_itself_is_left_out() {
    let points: Vec<[f64; 2]> = (0..81).map(|k| [f64::from(k % 9), f64::from(k / 9)]).collect();
    let mut list = NeighbourList::new();
    for (radius, expected) in [(1.0, 4), (1.9, 8), (2.0, 12), (2.3, 20)] {
        CellGrid::new().full_list(&points, Radii::Uniform(radius), &mut list).unwrap();
        assert_eq!(list.of(40).len(), expected, "radius {radius}");
        assert!(!list.of(40).contains(&40));
        assert_eq!(list.max_count(), expected);
    }
    assert_eq!(list.min_count(), 7, "a corner sees 2 + 1 + 2 + 2");
}

fn error_of(points: &[[f64; 2]], radii: Radii<'_>) -> Error {
    let mut list = NeighbourList::new();
    let brute = BruteForce::new().full_list(points, radii, &mut list).unwrap_err();
    for (name, mut search) in searches(Domain::unbounded()) {
        let refused = search.full_list(points, radii, &mut list).unwrap_err();
        assert_eq!(format!("{brute:?}"), format!("{refused:?}"), "{name}: searches refuse alike");
    }
    brute
}

#[test]
fn input_that_is_no_cloud_is_refused_with_its_place() {
    let points = [[0.0, 0.0], [1.0, f64::NEG_INFINITY], [0.0, 1.0]];
    let not_finite = Error::CoordinateNotFinite { particle: 1, axis: 1, value: f64::NEG_INFINITY };
    assert_eq!(error_of(&points, Radii::Uniform(1.0)), not_finite);
    let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    for value in [0.0, -1.0, f64::INFINITY, 1e-160, 1e160] {
        assert_eq!(error_of(&points, Radii::Uniform(value)), Error::UniformRadius { value });
        let radii = Radii::PerPoint { radii: &[1.0, 1.0, value], criterion: Criterion::Max };
        assert_eq!(error_of(&points, radii), Error::Radius { particle: 2, value });
    }
    assert!(matches!(
        error_of(&points, Radii::Uniform(f64::NAN)),
        Error::UniformRadius { value } if value.is_nan()
    ));
    assert!(matches!(
        error_of(&[[f64::NAN, 0.0]], Radii::Uniform(1.0)),
        Error::CoordinateNotFinite { particle: 0, axis: 0, .. }
    ));
    let radii = Radii::PerPoint { radii: &[1.0], criterion: Criterion::Gather };
    assert_eq!(error_of(&points, radii), Error::RadiiLength { points: 3, radii: 1 });
}

#[test]
fn period_shorter_than_two_radii_is_refused() {
    let ring = Domain::periodic([None, Some(1.0)]).unwrap();
    let refused = Error::PeriodTooShort { axis: 1, period: 1.0, least: 1.5 };
    let (points, mut list) = ([[0.0; 2]; 2], NeighbourList::new());
    let own = Radii::PerPoint { radii: &[0.1, 0.75], criterion: Criterion::Gather };
    for radii in [Radii::Uniform(0.75), own] {
        for (_, mut search) in searches(ring) {
            assert_eq!(search.full_list(&points, radii, &mut list), Err(refused));
        }
        assert_eq!(BruteForce::in_domain(ring).full_list(&points, radii, &mut list), Err(refused));
    }
}

/// A ring of eight points at unit spacing has eight contacts, a row of them seven.
#[test]
fn ring_closes() {
    let points: Vec<[f64; 1]> = (0..8).map(|k| [f64::from(k) + 100.0]).collect();
    let ring = Domain::periodic([Some(8.0)]).unwrap();
    let mut list = NeighbourList::new();
    for (_, mut search) in searches(ring) {
        search.half_list(&points, Radii::Uniform(1.0), &mut list).unwrap();
        assert_eq!(list.n_pairs(), 8);
        let mut round = 0.0;
        list.for_each_pair(&points, |pair| round += pair.x_ij[0].abs()).unwrap();
        assert!((round - 8.0).abs() == 0.0);
    }
}

#[test]
fn refused_build_leaves_the_list_as_it_was() {
    let mut list = NeighbourList::new();
    let mut grid = CellGrid::new();
    grid.full_list(&[[0.0], [1.0]], Radii::Uniform(1.0), &mut list).unwrap();
    let before = list.clone();
    grid.full_list(&[[0.0], [f64::NAN]], Radii::Uniform(1.0), &mut list).unwrap_err();
    assert_eq!(list, before);
}

#[test]
fn a_list_of_coinciding_points_is_refused_before_memory_ends() {
    let points = vec![[0.3, 0.7]; 200_000];
    let mut list = NeighbourList::new();
    let refused = CellGrid::new().full_list(&points, Radii::Uniform(0.1), &mut list);
    let limit = Error::TooManyNeighbours { points: 200_000, entries: 1 << 27, neighbours: 4096 };
    assert_eq!(refused, Err(limit));
    assert!(list.is_empty());
    let refused = LeafTree::new().half_list(&points, Radii::Uniform(0.1), &mut list);
    assert_eq!(refused, Err(limit));
    // Sixteen million pairs are a list.
    CellGrid::new().full_list(&points[..4000], Radii::Uniform(0.1), &mut list).unwrap();
    assert_eq!(list.n_pairs(), 4000 * 3999);
}
