//! A list with a skin hands out the pairs of a new list, whatever the points have done since.

use neighbour_search::{
    BruteForce, Criterion, Domain, Error, NeighbourList, NeighbourSearch, Radii, SkinList, Update,
};
use proptest::prelude::*;

/// The pairs of a list with a skin, and those of brute force.
fn both<const D: usize>(
    skin: &SkinList<D>,
    points: &[[f64; D]],
    radius: f64,
) -> [Vec<[usize; 2]>; 2] {
    let (mut ours, mut expected) = (Vec::new(), Vec::new());
    skin.for_each_pair(points, |pair| ours.push([pair.i, pair.j])).unwrap();
    let mut list = NeighbourList::new();
    BruteForce::new().full_list(points, Radii::Uniform(radius), &mut list).unwrap();
    list.for_each_pair(points, |pair| expected.push([pair.i, pair.j])).unwrap();
    ours.sort_unstable();
    [ours, expected]
}

fn walks<const D: usize>(random: &[[f64; 6]], radius: f64, skin: f64, step: f64) -> [usize; 2] {
    let mut points: Vec<[f64; D]> =
        random.iter().map(|x| std::array::from_fn(|axis| x[axis])).collect();
    let mut list = SkinList::new(skin).unwrap();
    let mut updates = [0; 2];
    for turn in 0..12_usize {
        let update = list.update(&points, Radii::Uniform(radius)).unwrap();
        updates[usize::from(update == Update::Rebuilt)] += 1;
        let [ours, expected] = both(&list, &points, radius);
        assert_eq!(ours, expected, "turn {turn} in {D} dimensions");
        for (k, x) in points.iter_mut().enumerate() {
            for (axis, x) in x.iter_mut().enumerate() {
                *x += step * (random[(k + turn) % random.len()][axis] - 0.5);
            }
        }
        // Points come and go, and change places.
        match turn {
            4 => points.truncate(points.len() - 3),
            6 => points.push([0.5; D]),
            8 => points.reverse(),
            _ => (),
        }
    }
    updates
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn pairs_are_those_of_a_new_list(
        random in prop::collection::vec(prop::array::uniform6(0.0..1.0_f64), 10..80),
        radius in 0.05..0.6_f64,
        skin in 0.01..0.3_f64,
    ) {
        // A step is below 0.18 skins: the second update reuses. The first, and those after points have gone and come, rebuild.
        let updates = walks::<2>(&random, radius, skin, 0.25 * skin);
        prop_assert!(updates[0] > 0 && updates[1] >= 3, "{updates:?}");
        walks::<1>(&random, radius, skin, skin);
        walks::<3>(&random, radius, skin, 0.1 * skin);
    }
}

#[test]
fn change_of_radius_or_number_rebuilds() {
    let mut list = SkinList::new(0.5).unwrap();
    let points = [[0.0], [1.0], [2.0]];
    assert_eq!(list.update(&points, Radii::Uniform(1.0)), Ok(Update::Rebuilt));
    assert_eq!(list.update(&points, Radii::Uniform(1.0)), Ok(Update::Reused));
    assert_eq!(list.update(&points, Radii::Uniform(0.2)), Ok(Update::Reused), "it shrinks");
    assert_eq!(
        list.update(&points, Radii::Uniform(1.5)),
        Ok(Update::Reused),
        "half of the skin, and half of it again"
    );
    assert_eq!(list.update(&points, Radii::Uniform(1.6)), Ok(Update::Rebuilt));
    let own = Radii::PerPoint { radii: &[1.0; 3], criterion: Criterion::Max };
    assert_eq!(list.update(&points, own), Ok(Update::Rebuilt));
    let grown = Radii::PerPoint { radii: &[1.0, 1.4, 0.1], criterion: Criterion::Max };
    assert_eq!(list.update(&points, grown), Ok(Update::Reused));
    let other = Radii::PerPoint { radii: &[1.0; 3], criterion: Criterion::Mean };
    assert_eq!(list.update(&points, other), Ok(Update::Rebuilt));
    assert_eq!(list.update(&points[..2], Radii::Uniform(1.1)), Ok(Update::Rebuilt));
    assert_eq!(list.candidates().n_pairs(), 2);
    assert_eq!(
        list.for_each_pair(&points, |_| ()),
        Err(Error::ListLength { listed: 2, points: 3 })
    );
}

#[test]
fn what_is_no_skin_or_no_cloud_is_refused() {
    for value in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(SkinList::<2>::new(value).map(|_| ()), Err(Error::Skin { value }));
    }
    let mut list = SkinList::new(0.5).unwrap();
    list.update(&[[0.0], [1.0]], Radii::Uniform(1.0)).unwrap();
    let refused = Error::CoordinateNotFinite { particle: 1, axis: 0, value: f64::INFINITY };
    assert_eq!(list.update(&[[0.0], [f64::INFINITY]], Radii::Uniform(1.0)), Err(refused));
    assert_eq!(
        list.update(&[[0.0], [1.0]], Radii::Uniform(1.0)),
        Ok(Update::Reused),
        "the list is as it was"
    );
}

#[test]
fn point_that_leaves_a_period_on_one_side_and_enters_on_the_other_has_hardly_moved() {
    let ring = Domain::periodic([Some(10.0)]).unwrap();
    let mut list = SkinList::in_domain(ring, 0.5).unwrap();
    let radii = Radii::Uniform(1.0);
    assert_eq!(list.update(&[[0.1], [9.3]], radii), Ok(Update::Rebuilt));
    let points = [[9.9], [9.3]];
    assert_eq!(list.update(&points, radii), Ok(Update::Reused));
    let mut along = Vec::new();
    list.for_each_pair(&points, |pair| along.push(pair.x_ij[0])).unwrap();
    assert!(along.len() == 2 && (along[0] - 0.6).abs() < 1e-12, "{along:?}");
}

#[test]
fn pairs_of_radii_that_grow_and_points_that_move_are_those_of_a_new_list() {
    let mut points: Vec<[f64; 2]> = (0..60).map(|k| [f64::from(k % 8), f64::from(k / 8)]).collect();
    let mut radii: Vec<f64> = (0..60).map(|k| 0.8 + 0.05 * f64::from(k % 13)).collect();
    let mut list = SkinList::new(0.4).unwrap();
    let (mut reused, mut expected) = (0, NeighbourList::new());
    for turn in 0..40 {
        for (k, (x, h)) in points.iter_mut().zip(&mut radii).enumerate() {
            let turn = f64::from(turn) + k as f64;
            x[0] += 0.02 * turn.sin();
            *h += 0.01 * (1.3 * turn).cos();
        }
        for criterion in [Criterion::Max, Criterion::Gather] {
            let radii = Radii::PerPoint { radii: &radii, criterion };
            let update = list.update(&points, radii).unwrap();
            reused += usize::from(update == Update::Reused);
            BruteForce::new().full_list(&points, radii, &mut expected).unwrap();
            let mut ours = Vec::new();
            list.for_each_pair(&points, |pair| ours.push([pair.i, pair.j])).unwrap();
            ours.sort_unstable();
            let mut theirs = Vec::new();
            expected.for_each_pair(&points, |pair| theirs.push([pair.i, pair.j])).unwrap();
            assert_eq!(ours, theirs);
            if turn % 2 == 0 {
                break;
            }
        }
    }
    assert!(reused > 5, "{reused}");
}
