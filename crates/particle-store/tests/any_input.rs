//! Any bytes are read as a bitwise identical snapshot or rejected with a typed error.
//!
//! There is no panic, no hang, and no memory beyond [`MOST_BYTES`]. `PROPTEST_CASES` sets the number of cases.

#![allow(clippy::unwrap_used, reason = "a setup that fails should fail the test")]

use std::alloc::System;

use cap::Cap;
use particle_store::{Attribute, ParticleStore, SymmetricTensor};
use proptest::prelude::*;
use proptest::sample::Index;
use twox_hash::XxHash64;

/// An allocation beyond it aborts the program.
const MOST_BYTES: usize = 1 << 30;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MOST_BYTES);

/// Contents of a snapshot with columns and attributes of every kind, before its hash.
pub(crate) fn snapshot() -> Vec<u8> {
    let mut store = ParticleStore::<2>::new(3);
    store.add("scalar", vec![0.5_f64; 3]).unwrap();
    store.add("point", vec![[0.5, -1.0]; 3]).unwrap();
    store.add("integer", vec![-1_i64; 3]).unwrap();
    store.add("index", vec![[1_i32, -2]; 3]).unwrap();
    store.add("tensor", vec![SymmetricTensor([1.0; 6]); 3]).unwrap();
    store.add("flag", vec![1_u8; 3]).unwrap();
    store.add("label", vec![7_u32; 3]).unwrap();
    store.set_attribute("real", Attribute::Real(0.25));
    store.set_attribute("count", Attribute::Count(4));
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    bytes.truncate(bytes.len() - 8);
    bytes
}

/// Reads these bytes, also with a correct hash.
pub(crate) fn is_read_or_refused(bytes: &[u8]) -> Result<(), TestCaseError> {
    prop_assert!(ParticleStore::<2>::restore(bytes).is_err());
    let hashed = [bytes, &XxHash64::oneshot(0, bytes).to_le_bytes()].concat();
    if let Ok(store) = ParticleStore::<2>::restore(hashed.as_slice()) {
        let mut once = Vec::new();
        store.snapshot(&mut once).unwrap();
        let mut again = Vec::new();
        ParticleStore::<2>::restore(once.as_slice()).unwrap().snapshot(&mut again).unwrap();
        prop_assert_eq!(once, again);
    }
    Ok(())
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        is_read_or_refused(&bytes)?;
    }

    #[test]
    fn a_forged_snapshot_is_read_or_refused(
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6),
        end in prop::option::of(any::<Index>()),
    ) {
        let mut bytes = snapshot();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        bytes.truncate(end.map_or(bytes.len(), |end| end.index(bytes.len())));
        is_read_or_refused(&bytes)?;
    }
}
