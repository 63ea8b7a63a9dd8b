//! Every search gives the list that brute force gives, whatever the cloud.

#![expect(clippy::unwrap_used, reason = "a law that cannot be put to the test has failed")]

use neighbour_search::{
    BruteForce, CellGrid, Criterion, Error, NeighbourList, NeighbourSearch, Radii,
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
fn searches<const D: usize>() -> Vec<(&'static str, Box<dyn NeighbourSearch<D>>)> {
    vec![("CellGrid", Box::new(CellGrid::new()))]
}

/// The half list is what comes after the point itself in the full list, or refused where that misses pairs.
fn halves_agree<const D: usize>(
    search: &mut dyn NeighbourSearch<D>,
    points: &[[f64; D]],
    radii: Radii<'_>,
    full: &NeighbourList,
) {
    let mut list = NeighbourList::new();
    for search in [search, &mut BruteForce] {
        if let Radii::PerPoint { criterion, .. } = radii
            && !criterion.is_symmetric()
        {
            let refused = search.half_list(points, radii, &mut list);
            assert_eq!(refused, Err(Error::NotSymmetric { criterion }));
            continue;
        }
        search.half_list(points, radii, &mut list).unwrap();
        assert_eq!(list.len(), full.len());
        assert_eq!(2 * list.n_pairs(), full.n_pairs());
        for (i, (half, full)) in (0..).zip(list.rows().zip(full.rows())) {
            assert!(half.iter().eq(full.iter().filter(|&&j| i < j)), "{search:?}, row {i}");
        }
    }
}

/// Number of pairs listed over all clouds and criteria, so that no agreement is about nothing.
fn agrees_with_brute_force<const D: usize>(random: &[[f64; 6]], radius: f64) -> usize {
    let (mut expected, mut list) = (NeighbourList::new(), NeighbourList::new());
    let mut n_pairs = 0;
    for (name, mut search) in searches::<D>() {
        for kind in CLOUDS {
            let points = cloud::<D>(kind, random);
            // Seventyfold between the smallest and the largest.
            let own: Vec<f64> =
                random[..points.len()].iter().map(|x| radius * 70_f64.powf(x[5] - 0.5)).collect();
            let per_point =
                Criterion::ALL.map(|criterion| Radii::PerPoint { radii: &own, criterion });
            for radii in [Radii::Uniform(radius), Radii::Uniform(0.2)].into_iter().chain(per_point)
            {
                BruteForce.full_list(&points, radii, &mut expected).unwrap();
                search.full_list(&points, radii, &mut list).unwrap();
                assert_eq!(list, expected, "{name} in {D} dimensions, {kind:?}, {radii:?}");
                assert_eq!(list.len(), points.len());
                n_pairs += list.n_pairs();
                halves_agree(search.as_mut(), &points, radii, &expected);
            }
        }
    }
    n_pairs
}

fn numbers(n: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<[f64; 6]>> {
    prop::collection::vec(prop::array::uniform6(0.0..1.0_f64), n)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_search_lists_what_brute_force_lists(random in numbers(20..150), radius in 0.02..1.0_f64) {
        prop_assert!(agrees_with_brute_force::<1>(&random, radius) > 0);
        prop_assert!(agrees_with_brute_force::<2>(&random, radius) > 0);
        prop_assert!(agrees_with_brute_force::<3>(&random, radius) > 0);
        prop_assert!(agrees_with_brute_force::<4>(&random, radius) > 0);
        prop_assert!(agrees_with_brute_force::<5>(&random, radius) > 0);
        prop_assert!(agrees_with_brute_force::<6>(&random, radius) > 0);
    }

}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn every_search_lists_what_brute_force_lists_in_a_larger_cloud(random in numbers(700..900), radius in 0.02..0.3_f64) {
        prop_assert!(agrees_with_brute_force::<2>(&random, radius) > 0);
        prop_assert!(agrees_with_brute_force::<3>(&random, radius) > 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn extreme_scales_change_nothing(random in numbers(60), exponent in -140..140_i32) {
        let scale = 10_f64.powi(exponent);
        let points: Vec<[f64; 2]> = random.iter().map(|x| [scale * x[0], scale * x[1]]).collect();
        let (mut expected, mut list) = (NeighbourList::new(), NeighbourList::new());
        for radii in [Radii::Uniform(0.3 * scale), Radii::Uniform(1e-150), Radii::Uniform(1e150)] {
            BruteForce.full_list(&points, radii, &mut expected).unwrap();
            CellGrid::new().full_list(&points, radii, &mut list).unwrap();
            prop_assert_eq!(&list, &expected);
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
        BruteForce.full_list(&points, radii, &mut list).unwrap();
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
    let brute = BruteForce.full_list(points, radii, &mut list).unwrap_err();
    let grid = CellGrid::new().full_list(points, radii, &mut list).unwrap_err();
    assert_eq!(format!("{brute:?}"), format!("{grid:?}"), "searches refuse alike");
    grid
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
fn refused_build_leaves_the_list_as_it_was() {
    let mut list = NeighbourList::new();
    let mut grid = CellGrid::new();
    grid.full_list(&[[0.0], [1.0]], Radii::Uniform(1.0), &mut list).unwrap();
    let before = list.clone();
    grid.full_list(&[[0.0], [f64::NAN]], Radii::Uniform(1.0), &mut list).unwrap_err();
    assert_eq!(list, before);
}
