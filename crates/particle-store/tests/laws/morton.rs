//! Morton order is a permutation, preserves locality, and is independent of position and scale of the cloud.

use particle_store::{Error, Lattice, ParticleStore, morton_order};
use proptest::prelude::*;

fn is_a_permutation(order: &[u32], n: usize) {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    assert!(sorted.into_iter().eq((0..).take(n)));
}

/// On a lattice of 2^m points along each axis every aligned run of 2^(D k) indices is one cube of side 2^k, for every
/// k.
///
/// This is the definition of the curve, and implies its locality.
fn runs_are_cubes<const D: usize>(m: u32) {
    let side = 1_usize << m;
    let lattice = Lattice::<D>::box_lattice([3.0; D], [side; D]).unwrap();
    let order = morton_order(&lattice.points).unwrap();
    is_a_permutation(&order, lattice.len());
    for k in 0..=m {
        let cube_of = |place: u32| lattice.indices[place as usize].map(|index| index >> k);
        let runs = order.chunks_exact(1 << (k as usize * D));
        assert_eq!(runs.len(), 1 << ((m - k) as usize * D));
        for run in runs {
            assert!(run.iter().all(|&place| cube_of(place) == cube_of(run[0])), "D {D}, k {k}");
        }
    }
}

#[test]
fn aligned_runs_of_a_lattice_are_cubes_in_one_to_six_dimensions() {
    runs_are_cubes::<1>(9);
    runs_are_cubes::<2>(6);
    runs_are_cubes::<3>(4);
    runs_are_cubes::<4>(3);
    runs_are_cubes::<5>(2);
    runs_are_cubes::<6>(2);
}

fn bits<const D: usize>(points: &[[f64; D]]) -> Vec<[u64; D]> {
    let mut bits: Vec<_> = points.iter().map(|x| x.map(f64::to_bits)).collect();
    bits.sort_unstable();
    bits
}

fn orders_any_cloud<const D: usize>(numbers: &[f64], shift: u32) {
    let points: Vec<[f64; D]> = numbers.as_chunks::<D>().0.to_vec();
    let order = morton_order(&points).unwrap();
    is_a_permutation(&order, points.len());
    // A power of two changes no rounding.
    let scale = f64::from(1 << shift);
    let larger: Vec<[f64; D]> = points.iter().map(|x| x.map(|value| value * scale)).collect();
    assert_eq!(morton_order(&larger).unwrap(), order);
    // An ordered cloud stays ordered, because equal cells keep their order.
    let mut store = ParticleStore::<D>::new(points.len());
    let position = store.add("position", points.clone()).unwrap();
    store.permute(&order).unwrap();
    let sorted = store.get(position).unwrap();
    assert_eq!(bits(sorted), bits(&points));
    assert!(morton_order(sorted).unwrap().into_iter().eq((0..).take(points.len())));
}

proptest! {
    #[test]
    fn any_cloud_is_ordered_whatever_its_scale(
        numbers in prop::collection::vec(-1e3..1e3_f64, 0..120), shift in 0..30_u32,
    ) {
        orders_any_cloud::<1>(&numbers, shift);
        orders_any_cloud::<2>(&numbers, shift);
        orders_any_cloud::<3>(&numbers, shift);
        orders_any_cloud::<4>(&numbers, shift);
        orders_any_cloud::<5>(&numbers, shift);
        orders_any_cloud::<6>(&numbers, shift);
    }
}

#[test]
fn clouds_without_extent_and_of_all_extents_are_ordered() {
    assert!(morton_order::<3>(&[]).unwrap().is_empty());
    assert_eq!(morton_order(&[[5.0, -1.0]; 3]).unwrap(), [0, 1, 2]);
    let extremes = [[f64::MAX, 0.0], [f64::MIN, 0.0], [0.0, f64::MAX], [0.0, 0.0]];
    is_a_permutation(&morton_order(&extremes).unwrap(), 4);
    assert_eq!(morton_order(&[[f64::MAX], [0.0], [f64::MIN]]).unwrap(), [2, 1, 0]);
}

#[test]
fn points_that_are_nowhere_are_refused() {
    for wrong in [f64::NAN, f64::NEG_INFINITY] {
        let error = morton_order(&[[0.0, 0.0], [0.0, wrong]]).unwrap_err();
        assert!(matches!(error, Error::NotFinite { what } if what == "point 1"));
    }
}
