//! Operations of a store on its columns, and their errors.

use particle_store::{Attribute, Error, Handle, Kind, ParticleStore};

fn store() -> (ParticleStore<2>, Handle<f64>, Handle<[f64; 2]>) {
    let mut store = ParticleStore::new(3);
    let mass = store.add("mass", vec![1.0, 2.0, 3.0]).unwrap();
    let position = store.add("position", vec![[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]).unwrap();
    store.add("flag", vec![7_i64, 8, 9]).unwrap();
    store.add("cell", vec![[1_i32, 1], [2, 2], [3, 3]]).unwrap();
    (store, mass, position)
}

#[test]
fn permutation_moves_every_column_and_the_ids_together() {
    let (mut store, mass, position) = store();
    store.permute(&[2, 0, 1]).unwrap();
    assert_eq!(store.ids(), [2, 0, 1]);
    assert_eq!(store.get(mass).unwrap(), [3.0, 1.0, 2.0]);
    assert_eq!(store.get(position).unwrap(), [[4.0, 5.0], [0.0, 1.0], [2.0, 3.0]]);
    let (flag, cell) = (store.handle::<i64>("flag").unwrap(), store.handle("cell").unwrap());
    assert_eq!(store.get(flag).unwrap(), [9, 7, 8]);
    assert_eq!(store.get::<[i32; 2]>(cell).unwrap()[0], [3, 3]);
    assert_eq!(store.index_of(1), Some(2));
}

#[test]
fn generation_changes_when_the_order_does_and_only_then() {
    let (mut store, mass, _) = store();
    store.permute(&[0, 1, 2]).unwrap();
    store.retain(&[true; 3]).unwrap();
    store.get_mut(mass).unwrap()[0] = 5.0;
    assert_eq!(store.generation(), 0);
    store.permute(&[1, 0, 2]).unwrap();
    assert_eq!(store.generation(), 1);
    assert_eq!(store.retain(&[true, false, true]).unwrap(), 1);
    assert_eq!(store.generation(), 2);
    assert_eq!(store.ids(), [1, 2]);
    assert_eq!(store.get(mass).unwrap(), [2.0, 3.0]);
}

#[test]
fn what_is_no_permutation_is_refused_and_changes_nothing() {
    let (mut store, mass, _) = store();
    let twice = store.permute(&[0, 1, 1]).unwrap_err();
    assert!(matches!(twice, Error::NotAPermutation { position: 2, value: 1, .. }));
    let beyond = store.permute(&[0, 3, 1]).unwrap_err();
    assert!(matches!(beyond, Error::NotAPermutation { position: 1, value: 3, .. }));
    let short = store.permute(&[0, 1]).unwrap_err();
    assert!(matches!(short, Error::LengthMismatch { length: 2, n_particles: 3, .. }));
    assert!(matches!(store.retain(&[true]), Err(Error::LengthMismatch { length: 1, .. })));
    assert_eq!((store.generation(), store.get(mass).unwrap()), (0, &[1.0, 2.0, 3.0][..]));
}

#[test]
fn columns_are_refused_by_name_by_length_and_by_kind() {
    let (mut store, mass, position) = store();
    assert!(matches!(store.add("mass", vec![0_i64; 3]), Err(Error::DuplicateName { .. })));
    assert!(matches!(store.add("new", vec![0.0; 2]), Err(Error::LengthMismatch { .. })));
    assert!(matches!(store.handle::<f64>("new"), Err(Error::UnknownColumn { .. })));
    assert!(matches!(
        store.handle::<i64>("mass"),
        Err(Error::KindMismatch { expected: Kind::Integer, found: Kind::Scalar, .. })
    ));
    assert!(matches!(store.get_pair_mut(mass, mass), Err(Error::SameColumn { .. })));
    let (masses, positions) = store.get_pair_mut(mass, position).unwrap();
    positions[1][0] = 10.0 * masses[1];
    assert_eq!(store.get(position).unwrap(), [[0.0, 1.0], [20.0, 3.0], [4.0, 5.0]]);
    let other = ParticleStore::<2>::new(3);
    assert!(matches!(other.get(mass), Err(Error::UnknownHandle { index: 0, n_columns: 0 })));
    let mut other = other;
    assert!(matches!(other.get_pair_mut(mass, mass), Err(Error::UnknownHandle { .. })));
    other.add("flag", vec![0_i64; 3]).unwrap();
    assert!(matches!(other.get_mut(mass), Err(Error::KindMismatch { .. })));
}

#[test]
fn attributes_are_kept_by_name() {
    let mut store = ParticleStore::<1>::new(0);
    assert_eq!(store.set_attribute("time", Attribute::Real(0.5)), None);
    assert_eq!(store.set_attribute("step", Attribute::Count(7)), None);
    assert_eq!(store.set_attribute("step", Attribute::Count(8)), Some(Attribute::Count(7)));
    assert_eq!(store.attribute("time"), Some(Attribute::Real(0.5)));
    assert_eq!(store.attributes().map(|(name, _)| name).collect::<Vec<_>>(), ["step", "time"]);
}
