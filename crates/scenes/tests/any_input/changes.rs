//! Byte changes in a file.

use proptest::prelude::*;
use proptest::sample::Index;

/// Changes bytes at some positions, and sometimes also truncates or extends the file.
#[derive(Debug, Clone)]
pub(crate) struct Changes {
    bytes: Vec<(Index, u8)>,
    end: Option<(Index, Vec<u8>)>,
}

pub(crate) fn changes() -> impl Strategy<Value = Changes> {
    let byte =
        prop_oneof![any::<u8>(), prop::sample::select(vec![0_u8, 1, 2, 0x7f, 0x80, 0xf0, 0xff])];
    let end = (any::<Index>(), prop::collection::vec(any::<u8>(), 0..20));
    (
        prop::collection::vec((any::<Index>(), byte), 1..6),
        prop_oneof![6 => Just(None), 1 => end.prop_map(Some)],
    )
        .prop_map(|(bytes, end)| Changes { bytes, end })
}

impl Changes {
    pub(crate) fn of(&self, bytes: &[u8]) -> Vec<u8> {
        let mut changed = bytes.to_vec();
        for (at, byte) in &self.bytes {
            changed[at.index(bytes.len())] = *byte;
        }
        if let Some((at, more)) = &self.end {
            changed.truncate(at.index(bytes.len() + 1));
            changed.extend(more);
        }
        changed
    }
}
