//! A list with a skin hands out the pairs of a new list, whatever the points have done since.

#![expect(clippy::unwrap_used, reason = "a law that cannot be put to the test has failed")]

use neighbour_search::{
    BruteForce, Error, NeighbourList, NeighbourSearch, Radii, SkinList, Update,
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
    BruteForce.full_list(points, Radii::Uniform(radius), &mut list).unwrap();
    list.for_each_pair(points, |pair| expected.push([pair.i, pair.j])).unwrap();
    [ours, expected]
}

fn walks<const D: usize>(random: &[[f64; 6]], radius: f64, skin: f64, step: f64) -> [usize; 2] {
    let mut points: Vec<[f64; D]> =
        random.iter().map(|x| std::array::from_fn(|axis| x[axis])).collect();
    let mut list = SkinList::new(skin).unwrap();
    let mut updates = [0; 2];
    for turn in 0..12_usize {
        let update = list.update(&points, radius).unwrap();
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
    assert_eq!(list.update(&points, 1.0), Ok(Update::Rebuilt));
    assert_eq!(list.update(&points, 1.0), Ok(Update::Reused));
    assert_eq!(list.update(&points, 1.1), Ok(Update::Rebuilt));
    assert_eq!(list.update(&points[..2], 1.1), Ok(Update::Rebuilt));
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
    list.update(&[[0.0], [1.0]], 1.0).unwrap();
    let refused = Error::CoordinateNotFinite { particle: 1, axis: 0, value: f64::INFINITY };
    assert_eq!(list.update(&[[0.0], [f64::INFINITY]], 1.0), Err(refused));
    assert_eq!(list.update(&[[0.0], [1.0]], 1.0), Ok(Update::Reused), "the list is as it was");
}
