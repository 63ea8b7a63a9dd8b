//! A store behaves as a table of rows; a snapshot is restored bitwise or rejected.

#![expect(clippy::unwrap_used, reason = "a law that cannot be put to the test has failed")]

mod adapt;
mod lattice;
mod morton;
mod paraview;
mod sequences;
mod store;

use particle_store::{Attribute, Error, ParticleStore, SymmetricTensor};
use proptest::prelude::*;

/// A particle as a row: the reference for the columns.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    id: u64,
    mass: u64,
    position: [u64; 3],
    flag: i64,
    cell: [i32; 3],
    stress: [u64; 6],
    phase: u8,
    body: u32,
}

/// Any bits, including NaN with payloads, infinities, subnormals and both zeros.
fn rows(n: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<Row>> {
    let cell = any::<[i32; 3]>();
    let row =
        (any::<u64>(), any::<[u64; 3]>(), any::<i64>(), cell, any::<[u64; 6]>(), any::<u32>());
    let row = row.prop_map(|(mass, position, flag, cell, stress, body)| {
        let phase = body.to_le_bytes()[0];
        Row { id: 0, mass, position, flag, cell, stress, phase, body }
    });
    prop::collection::vec(row, n)
        .prop_map(|rows| (0..).zip(rows).map(|(id, row)| Row { id, ..row }).collect())
}

fn store_of(rows: &[Row]) -> ParticleStore<3> {
    let mut store = ParticleStore::new(rows.len());
    store.add("mass", rows.iter().map(|row| f64::from_bits(row.mass)).collect()).unwrap();
    store
        .add("position", rows.iter().map(|row| row.position.map(f64::from_bits)).collect())
        .unwrap();
    store.add("flag", rows.iter().map(|row| row.flag).collect()).unwrap();
    store.add("cell", rows.iter().map(|row| row.cell).collect()).unwrap();
    let stress = rows.iter().map(|row| SymmetricTensor(row.stress.map(f64::from_bits)));
    store.add("stress", stress.collect()).unwrap();
    store.add("phase", rows.iter().map(|row| row.phase).collect()).unwrap();
    store.add("body", rows.iter().map(|row| row.body).collect()).unwrap();
    store.set_attribute("time", Attribute::Real(f64::from_bits(0x7ff8_0000_0000_0123)));
    store.set_attribute("step", Attribute::Count(u64::MAX));
    store
}

fn rows_of(store: &ParticleStore<3>) -> Vec<Row> {
    let mass = store.get::<f64>(store.handle("mass").unwrap()).unwrap();
    let position = store.get::<[f64; 3]>(store.handle("position").unwrap()).unwrap();
    let flag = store.get::<i64>(store.handle("flag").unwrap()).unwrap();
    let cell = store.get::<[i32; 3]>(store.handle("cell").unwrap()).unwrap();
    let stress = store.get::<SymmetricTensor>(store.handle("stress").unwrap()).unwrap();
    let phase = store.get::<u8>(store.handle("phase").unwrap()).unwrap();
    let body = store.get::<u32>(store.handle("body").unwrap()).unwrap();
    (0..store.len())
        .map(|k| Row {
            id: store.ids()[k],
            mass: mass[k].to_bits(),
            position: position[k].map(f64::to_bits),
            flag: flag[k],
            cell: cell[k],
            stress: stress[k].0.map(f64::to_bits),
            phase: phase[k],
            body: body[k],
        })
        .collect()
}

fn snapshot_of(store: &ParticleStore<3>) -> Vec<u8> {
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    bytes
}

/// An order of `n` made by sorting random keys.
fn order(keys: &[u64], n: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..).take(n).collect();
    order.sort_by_key(|&k| keys[k as usize % keys.len()].rotate_left(k));
    order
}

proptest! {
    #[test]
    fn store_is_a_table_of_rows_under_reordering_and_removal(
        mut table in rows(0..40),
        steps in prop::collection::vec((any::<bool>(), any::<[u64; 4]>()), 1..6),
    ) {
        let mut store = store_of(&table);
        for (reorder, keys) in steps {
            let (generation, ids) = (store.generation(), store.ids().to_vec());
            if reorder {
                let order = order(&keys, table.len());
                store.permute(&order).unwrap();
                table = order.iter().map(|&k| table[k as usize]).collect();
            } else {
                let keep: Vec<bool> = (0..table.len()).map(|k| keys[k % 4] >> (k % 64) & 3 != 0).collect();
                let removed = store.retain(&keep).unwrap();
                let kept = table.iter().zip(&keep).filter(|(_, keep)| **keep);
                table = kept.map(|(row, _)| *row).collect();
                prop_assert_eq!(removed, keep.len() - table.len());
            }
            prop_assert_eq!(&rows_of(&store), &table);
            prop_assert_eq!(store.generation() != generation, store.ids() != ids);
            for (place, row) in table.iter().enumerate() {
                prop_assert_eq!(store.index_of(row.id), Some(place));
            }
        }
    }

    #[test]
    fn snapshot_comes_back_bit_for_bit(table in rows(0..40), keys in any::<[u64; 4]>()) {
        let mut store = store_of(&table);
        store.permute(&order(&keys, table.len())).unwrap();
        let mut bytes = snapshot_of(&store);
        bytes.extend(b"what follows is not read");
        let mut rest = bytes.as_slice();
        let restored = ParticleStore::<3>::restore(&mut rest).unwrap();
        prop_assert_eq!(rest, b"what follows is not read");
        prop_assert_eq!(rows_of(&restored), rows_of(&store));
        prop_assert_eq!(restored.generation(), store.generation());
        prop_assert_eq!(restored.content_hash(), store.content_hash());
        prop_assert!(restored.columns().eq(store.columns()));
        let bits = |value| match value {
            Some(Attribute::Real(value)) => value.to_bits(),
            Some(Attribute::Count(value)) => value,
            _ => 0,
        };
        prop_assert_eq!(bits(restored.attribute("time")), 0x7ff8_0000_0000_0123);
        prop_assert_eq!(bits(restored.attribute("step")), u64::MAX);
    }

    #[test]
    fn content_hash_tells_stores_apart(table in rows(1..20), place in any::<prop::sample::Index>(), bit in 0..64_u32) {
        let store = store_of(&table);
        let mut changed = store.clone();
        let mass = changed.handle::<f64>("mass").unwrap();
        let masses = changed.get_mut(mass).unwrap();
        let place = place.index(masses.len());
        masses[place] = f64::from_bits(masses[place].to_bits() ^ (1 << bit));
        prop_assert_ne!(changed.content_hash(), store.content_hash());
    }
}

fn small_store() -> ParticleStore<3> {
    let row = |id| Row {
        id,
        mass: id,
        position: [id; 3],
        flag: -1,
        cell: [1, 2, 3],
        stress: [id; 6],
        phase: 1,
        body: 2,
    };
    store_of(&[row(0), row(1)])
}

#[test]
fn no_wrong_bit_anywhere_is_taken_for_a_snapshot() {
    let bytes = snapshot_of(&small_store());
    for place in 0..bytes.len() {
        for bit in 0..8 {
            let mut wrong = bytes.clone();
            wrong[place] ^= 1 << bit;
            assert!(ParticleStore::<3>::restore(&wrong[..]).is_err(), "byte {place}, bit {bit}");
        }
    }
}

#[test]
fn snapshot_cut_short_says_so() {
    let bytes = snapshot_of(&small_store());
    for length in 0..bytes.len() {
        let cut = ParticleStore::<3>::restore(&bytes[..length]);
        assert!(matches!(cut, Err(Error::Truncated)), "{length} bytes of {}", bytes.len());
    }
}

#[test]
fn foreign_snapshots_are_refused_by_what_is_foreign() {
    let bytes = snapshot_of(&small_store());
    let restored = |place: usize, value: u8| {
        let mut foreign = bytes.clone();
        foreign[place] = value;
        ParticleStore::<3>::restore(&foreign[..])
    };
    assert!(matches!(restored(0, b'x'), Err(Error::NotASnapshot { .. })));
    assert!(matches!(restored(8, 2), Err(Error::UnsupportedVersion { found: 2, supported: 3 })));
    let other = ParticleStore::<2>::restore(&bytes[..]);
    assert!(matches!(other, Err(Error::DimensionMismatch { found: 3, expected: 2 })));
    // The highest byte of the number of particles: too many particles are detected without allocating memory for them.
    assert!(matches!(restored(39, 0x7f), Err(Error::Truncated)));
    // The last byte of the hash itself, and one of the last column's.
    let last = bytes.len() - 1;
    assert!(matches!(restored(last, !bytes[last]), Err(Error::HashMismatch { .. })));
    assert!(matches!(restored(last - 8, !bytes[last - 8]), Err(Error::HashMismatch { .. })));
}

/// The layout is fixed: this is a complete snapshot of one particle with two columns and one attribute, by hand.
#[test]
fn layout_is_the_documented_one() {
    let mut store = ParticleStore::<1>::new(1);
    store.add("m", vec![1.0]).unwrap();
    store.add("i", vec![[-2_i32]]).unwrap();
    store.set_attribute("t", Attribute::Count(5)).unwrap_or(Attribute::Count(0));
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    let word = |value: u64| value.to_le_bytes();
    let mut expected = Vec::new();
    expected.extend(b"PARTSTOR");
    expected.extend([3, 0, 0, 0, 1, 0, 0, 0]);
    expected.extend([word(0), word(1), word(1), word(1), word(2)].concat());
    expected.push(1);
    expected.extend(word(1));
    expected.push(b't');
    expected.extend(word(5));
    expected.extend(word(0));
    expected.push(0);
    expected.extend(word(1));
    expected.push(b'm');
    expected.extend(word(1.0_f64.to_bits()));
    expected.push(3);
    expected.extend(word(1));
    expected.push(b'i');
    expected.extend([254, 255, 255, 255]);
    assert_eq!(bytes[..bytes.len() - 8], expected);
    // XXH64 of these bytes, by an independent implementation.
    assert_eq!(bytes[bytes.len() - 8..], word(0x2fa0_0966_14f0_b086));
    assert_eq!(store.content_hash(), 0x2fa0_0966_14f0_b086);
}
