//! XXH64, the hash of snapshots.

const PRIME_1: u64 = 0x9e37_79b1_85eb_ca87;
const PRIME_2: u64 = 0xc2b2_ae3d_27d4_eb4f;
const PRIME_3: u64 = 0x1656_67b1_9e37_79f9;
const PRIME_4: u64 = 0x85eb_ca77_c2b2_ae63;
const PRIME_5: u64 = 0x27d4_eb2f_1656_67c5;

/// Bytes taken at a time, eight for each of four lanes.
const STRIPE: usize = 32;

/// XXH64 with seed 0, fed piece by piece: Collet, xxHash fast digest algorithm, version 0.1.1, section "XXH64".
///
/// Four lanes of whole words, because a byte at a time leaves the processor waiting for each multiplication.
#[derive(Debug, Clone)]
pub(crate) struct Xxh64 {
    lanes: [u64; 4],
    /// What was fed and is not a whole stripe yet.
    rest: [u8; STRIPE],
    n_rest: usize,
    n_bytes: u64,
}

impl Xxh64 {
    pub(crate) const fn new() -> Self {
        let first = PRIME_1.wrapping_add(PRIME_2);
        let lanes = [first, PRIME_2, 0, 0_u64.wrapping_sub(PRIME_1)];
        Self { lanes, rest: [0; STRIPE], n_rest: 0, n_bytes: 0 }
    }

    pub(crate) fn update(&mut self, mut bytes: &[u8]) {
        self.n_bytes = self.n_bytes.wrapping_add(bytes.len() as u64);
        if self.n_rest > 0 {
            let (now, later) = bytes.split_at(bytes.len().min(STRIPE - self.n_rest));
            self.rest[self.n_rest..self.n_rest + now.len()].copy_from_slice(now);
            self.n_rest += now.len();
            bytes = later;
            if self.n_rest < STRIPE {
                return;
            }
            let stripe = self.rest;
            self.take_stripes(&[stripe]);
        }
        let (stripes, rest) = bytes.as_chunks::<STRIPE>();
        self.take_stripes(stripes);
        self.rest[..rest.len()].copy_from_slice(rest);
        self.n_rest = rest.len();
    }

    fn take_stripes(&mut self, stripes: &[[u8; STRIPE]]) {
        let mut lanes = self.lanes;
        for stripe in stripes {
            for (lane, word) in lanes.iter_mut().zip(stripe.as_chunks::<8>().0) {
                *lane = round(*lane, u64::from_le_bytes(*word));
            }
        }
        self.lanes = lanes;
    }

    pub(crate) fn digest(&self) -> u64 {
        let mut hash = PRIME_5;
        if self.n_bytes >= STRIPE as u64 {
            let [a, b, c, d] = self.lanes;
            hash = a.rotate_left(1).wrapping_add(b.rotate_left(7));
            hash = hash.wrapping_add(c.rotate_left(12)).wrapping_add(d.rotate_left(18));
            for lane in self.lanes {
                hash = (hash ^ round(0, lane)).wrapping_mul(PRIME_1).wrapping_add(PRIME_4);
            }
        }
        hash = hash.wrapping_add(self.n_bytes);
        let (words, rest) = self.rest[..self.n_rest].as_chunks::<8>();
        for word in words {
            hash ^= round(0, u64::from_le_bytes(*word));
            hash = hash.rotate_left(27).wrapping_mul(PRIME_1).wrapping_add(PRIME_4);
        }
        let (halves, rest) = rest.as_chunks::<4>();
        for half in halves {
            hash ^= u64::from(u32::from_le_bytes(*half)).wrapping_mul(PRIME_1);
            hash = hash.rotate_left(23).wrapping_mul(PRIME_2).wrapping_add(PRIME_3);
        }
        for &byte in rest {
            hash ^= u64::from(byte).wrapping_mul(PRIME_5);
            hash = hash.rotate_left(11).wrapping_mul(PRIME_1);
        }
        hash = (hash ^ hash >> 33).wrapping_mul(PRIME_2);
        hash = (hash ^ hash >> 29).wrapping_mul(PRIME_3);
        hash ^ hash >> 32
    }
}

fn round(lane: u64, word: u64) -> u64 {
    lane.wrapping_add(word.wrapping_mul(PRIME_2)).rotate_left(31).wrapping_mul(PRIME_1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hash(bytes: &[u8]) -> u64 {
        let mut hash = Xxh64::new();
        hash.update(bytes);
        hash.digest()
    }

    #[test]
    fn hash_is_the_published_one() {
        // Vectors of the documentation of several implementations; the last fills a stripe and each kind of rest.
        for (text, expected) in [
            ("", 0xef46_db37_51d8_e999),
            ("a", 0xd24e_c4f1_a98c_6e5b),
            ("abc", 0x44bc_2cf5_ad77_0999),
            ("Nobody inspects the spammish repetition", 0xfbce_a83c_8a37_8bf1),
        ] {
            assert_eq!(hash(text.as_bytes()), expected, "{text}");
        }
    }

    #[test]
    fn hash_is_that_of_the_reference_library_at_every_kind_of_length() {
        // The bytes 0, 1, 2, ..; digests by libxxhash through the Python package xxhash.
        let bytes: Vec<u8> = (0..255).collect();
        for (length, expected) in [
            (3, 0xe5c7_bb45_33bc_65dd),
            (4, 0xffce_d860_4453_cc1e),
            (8, 0x884a_1736_14b8_1b8d),
            (13, 0x13d1_7c4c_7797_23a8),
            (31, 0xc346_d2b5_9b4d_8ee1),
            (32, 0xcbf5_9c51_16ff_32b4),
            (33, 0x0c53_5d1a_cafb_8ead),
            (63, 0xe26a_a9e2_a95f_8e4f),
            (64, 0xf7c6_7301_db67_13f0),
            (100, 0x6ac1_e580_3216_6597),
            (255, 0x0f7d_9750_7caa_d693),
        ] {
            assert_eq!(hash(&bytes[..length]), expected, "{length} bytes");
        }
    }

    #[test]
    fn hash_does_not_depend_on_the_pieces() {
        let bytes: Vec<u8> = (0..200).collect();
        let whole = hash(&bytes);
        for first in 0..bytes.len() {
            for second in [0, 1, 7, 31, 32, 33] {
                let (head, tail) = bytes.split_at(first);
                let (middle, tail) = tail.split_at(second.min(tail.len()));
                let mut pieces = Xxh64::new();
                pieces.update(head);
                pieces.update(middle);
                pieces.update(tail);
                assert_eq!(pieces.digest(), whole, "{first} and {second} bytes");
            }
        }
    }
}
