//! Particles appended, split and merged: conserved quantities, ids, and errors.

use particle_store::{Child, Error, Handle, ParticleStore, Rule, Rules, SymmetricTensor};
use proptest::prelude::*;

const OTHERS: [(&str, Rule); 5] = [
    ("velocity", Rule::Mean),
    ("volume", Rule::Sum),
    ("stress", Rule::Mean),
    ("size", Rule::First),
    ("phase", Rule::First),
];

fn store(n: u32) -> (ParticleStore<2>, Rules<'static, 2>) {
    let mut store = ParticleStore::new(n as usize);
    let numbers = |offset: f64| (0..n).map(move |k| offset + f64::from(k * k % 7));
    let mass = store.add("mass", numbers(1.0).collect()).unwrap();
    let position = store.add("position", numbers(0.5).map(|x| [x, -2.0 * x]).collect()).unwrap();
    store.add("velocity", numbers(-3.0).map(|x| [x, x * x]).collect()).unwrap();
    store.add("volume", numbers(0.25).collect()).unwrap();
    store.add("stress", numbers(2.0).map(|x| SymmetricTensor([x; 6])).collect()).unwrap();
    store.add("size", numbers(9.0).collect()).unwrap();
    store.add("phase", (0..n).map(|k| k.to_le_bytes()[0]).collect()).unwrap();
    (store, Rules { mass, position, others: &OTHERS })
}

fn column<T: particle_store::Element<2>>(store: &ParticleStore<2>, name: &str) -> Vec<T> {
    store.get::<T>(store.handle(name).unwrap()).unwrap().to_vec()
}

/// Mass, first moment, momentum, volume, and stress times mass.
fn totals(store: &ParticleStore<2>) -> [f64; 7] {
    let mass = column::<f64>(store, "mass");
    let (x, v) = (column::<[f64; 2]>(store, "position"), column::<[f64; 2]>(store, "velocity"));
    let stress = column::<SymmetricTensor>(store, "stress");
    let volume = column::<f64>(store, "volume");
    let sum = |of: &dyn Fn(usize) -> f64| (0..store.len()).map(of).sum::<f64>();
    [
        sum(&|k| mass[k]),
        sum(&|k| mass[k] * x[k][0]),
        sum(&|k| mass[k] * x[k][1]),
        sum(&|k| mass[k] * v[k][0]),
        sum(&|k| mass[k] * v[k][1]),
        sum(&|k| volume[k]),
        sum(&|k| mass[k] * stress[k].0[5]),
    ]
}

fn are_the_same(a: [f64; 7], b: [f64; 7]) {
    for (k, (a, b)) in a.into_iter().zip(b).enumerate() {
        // Less than a thousand roundings of sums below 1e5.
        assert!((a - b).abs() <= 1e3 * 1e5 * f64::EPSILON, "total {k}: {a} and {b}");
    }
}

/// Shares that sum to one, and offsets that conserve the centre of mass.
fn children(weights: &[f64], spread: f64) -> Vec<Child<2>> {
    let total: f64 = weights.iter().sum();
    let shares = weights.iter().map(|weight| weight / total);
    let raw = |k: usize| [spread * k as f64, spread * (k * k) as f64];
    let centre: [f64; 2] = core::array::from_fn(|axis| {
        shares.clone().enumerate().map(|(k, share)| share * raw(k)[axis]).sum()
    });
    let offset = |k| core::array::from_fn(|axis| raw(k)[axis] - centre[axis]);
    shares.enumerate().map(|(k, share)| Child { offset: offset(k), share }).collect()
}

proptest! {
    #[test]
    fn splitting_and_merging_conserve_and_undo_each_other(
        n in 1..20_u32, place in any::<prop::sample::Index>(),
        weights in prop::collection::vec(0.1..1.0_f64, 2..8), spread in 0.0..2.0_f64,
    ) {
        let (mut store, rules) = store(n);
        let before = store.clone();
        let place = place.index(n as usize);
        let ids = store.split(place, &children(&weights, spread), &rules).unwrap();
        are_the_same(totals(&store), totals(&before));
        prop_assert_eq!(ids.clone(), u64::from(n)..u64::from(n) + weights.len() as u64);
        prop_assert_eq!(store.len(), n as usize - 1 + weights.len());
        prop_assert_eq!(store.generation(), 1);
        for other in (0..n as usize).filter(|&other| other != place) {
            prop_assert_eq!(store.ids()[other], before.ids()[other]);
        }
        let group: Vec<usize> = ids.map(|id| store.index_of(id).unwrap()).collect();
        let merged = store.merge(&[group], &rules).unwrap();
        are_the_same(totals(&store), totals(&before));
        prop_assert_eq!(store.generation(), 2);
        prop_assert_eq!(store.index_of(merged.start), Some(place));
        prop_assert_eq!(column::<f64>(&store, "size"), column::<f64>(&before, "size"));
        prop_assert_eq!(column::<u8>(&store, "phase"), column::<u8>(&before, "phase"));
        let (x, was) = (column::<[f64; 2]>(&store, "position"), column::<[f64; 2]>(&before, "position"));
        for (x, was) in x.iter().flatten().zip(was.iter().flatten()) {
            prop_assert!((x - was).abs() <= 1e-12);
        }
    }
}

#[test]
fn several_groups_are_merged_at_once_each_by_its_own_masses() {
    let (mut store, rules) = store(6);
    let before = store.clone();
    // Masses 1 2 5 3 3 5.
    let ids = store.merge(&[vec![4, 1], vec![0, 5, 2]], &rules).unwrap();
    assert_eq!((ids, store.ids()), (6..8, &[7, 3, 6][..]));
    assert_eq!(store.get(rules.mass).unwrap(), [11.0, 3.0, 5.0]);
    assert_eq!(column::<u8>(&store, "phase"), [0, 3, 4]);
    are_the_same(totals(&store), totals(&before));
    assert_eq!(store.merge::<[usize; 2]>(&[], &rules).unwrap(), 8..8);
    assert_eq!(store.generation(), 1);
}

#[test]
fn appended_particles_come_last_with_new_ids_whatever_the_order_of_columns() {
    let mut store = ParticleStore::<1>::new(2);
    let mass = store.add("mass", vec![1.0, 2.0]).unwrap();
    let phase = store.add("phase", vec![1_u8, 2]).unwrap();
    let mut more = ParticleStore::<1>::new(1);
    more.add("phase", vec![3_u8]).unwrap();
    more.add("mass", vec![3.0]).unwrap();
    assert_eq!(store.append(&more).unwrap(), 2..3);
    assert_eq!((store.ids(), store.generation()), (&[0, 1, 2][..], 1));
    assert_eq!(
        (store.get(mass).unwrap(), store.get(phase).unwrap()),
        (&[1.0, 2.0, 3.0][..], &[1, 2, 3][..])
    );
    more.retain(&[false]).unwrap();
    assert_eq!(store.append(&more).unwrap(), 3..3);
    assert_eq!(store.generation(), 1);

    let mut wrong = ParticleStore::<1>::new(1);
    wrong.add("mass", vec![0.0]).unwrap();
    assert!(matches!(store.append(&wrong), Err(Error::UnknownColumn { name }) if name == "phase"));
    wrong.add("phase", vec![0_u32]).unwrap();
    assert!(matches!(store.append(&wrong), Err(Error::KindMismatch { .. })));
    let mut wrong = more.clone();
    wrong.add("more", vec![0.0; 0]).unwrap();
    assert!(matches!(store.append(&wrong), Err(Error::UnknownColumn { name }) if name == "more"));
    assert_eq!((store.len(), store.get(mass).unwrap().len()), (3, 3));
}

#[test]
fn ids_of_removed_particles_are_never_given_again_not_even_after_a_restart() {
    let (mut store, _) = store(3);
    let more = store.clone();
    store.retain(&[true, false, false]).unwrap();
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    let mut restored = ParticleStore::<2>::restore(&bytes[..]).unwrap();
    assert_eq!(restored.append(&more).unwrap(), 3..6);
    assert_eq!(restored.ids(), [0, 3, 4, 5]);
}

#[test]
fn what_cannot_be_split_or_merged_is_refused_and_changes_nothing() {
    let (mut store, rules) = store(4);
    let hash = store.content_hash();
    let half = Child { offset: [0.0; 2], share: 0.5 };
    let nowhere = Child { offset: [0.0, f64::NAN], share: 0.5 };
    assert!(matches!(store.split(4, &[half; 2], &rules), Err(Error::NoSuchPlace { place: 4, .. })));
    assert!(matches!(store.split(0, &[half; 3], &rules), Err(Error::InvalidShares { .. })));
    assert!(matches!(store.split(0, &[], &rules), Err(Error::InvalidShares { .. })));
    assert!(matches!(store.split(0, &[half, nowhere], &rules), Err(Error::NotFinite { .. })));
    assert!(matches!(store.merge(&[[0, 4]], &rules), Err(Error::NoSuchPlace { place: 4, .. })));
    assert!(matches!(store.merge(&[[0, 1], [2, 1]], &rules), Err(Error::NamedTwice { place: 1 })));
    assert!(matches!(store.merge(&[[1]], &rules), Err(Error::GroupTooSmall { length: 1, .. })));
    let with = |others| Rules { others, ..rules };
    let missing = store.split(0, &[half; 2], &with(&OTHERS[1..]));
    assert!(matches!(missing, Err(Error::NoRule { name }) if name == "velocity"));
    let unknown = store.split(0, &[half; 2], &with(&[("heat", Rule::Sum)]));
    assert!(matches!(unknown, Err(Error::UnknownColumn { name }) if name == "heat"));
    let mut others = OTHERS;
    others[4].1 = Rule::Mean;
    let mismatch = store.merge(&[[0, 1]], &Rules { others: &others, ..rules });
    assert!(
        matches!(mismatch, Err(Error::RuleMismatch { name, rule: Rule::Mean }) if name == "phase")
    );
    others[4] = ("mass", Rule::Sum);
    let fixed = store.merge(&[[0, 1]], &Rules { others: &others, ..rules });
    assert!(matches!(fixed, Err(Error::RuleMismatch { name, .. }) if name == "mass"));
    assert_eq!(store.content_hash(), hash);
    let mass: Handle<f64> = rules.mass;
    store.get_mut(mass).unwrap()[0] = f64::NAN;
    assert!(matches!(store.merge(&[[1, 0]], &rules), Err(Error::InvalidMass { group: 0, .. })));
}
