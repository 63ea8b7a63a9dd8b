//! ChaCha with 8 rounds, vectorised over blocks: one lane per stream, or one per block of a stream.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

/// Words of 32 bits in a block.
pub(crate) const BLOCK_WORDS: usize = 16;

/// "expand 32-byte k", the constants of the cipher.
const CONSTANTS: [u32; 4] = [0x6170_7865, 0x3320_646e, 0x7962_2d32, 0x6b20_6574];

/// Key of a seed and a purpose: both little endian, then zeros.
pub(crate) const fn key(seed: u64, purpose: u64) -> [u32; 8] {
    [low(seed), high(seed), low(purpose), high(purpose), 0, 0, 0, 0]
}

#[allow(clippy::cast_possible_truncation, reason = "the lower half is what is asked for")]
#[inline(always)]
const fn low(x: u64) -> u32 {
    x as u32
}

#[inline(always)]
const fn high(x: u64) -> u32 {
    (x >> 32) as u32
}

/// Block `counters[lane]` of stream `streams[lane]`, word by word, in a loop that compilers vectorise.
///
/// Source: Bernstein 2008, ChaCha, a variant of Salsa20.
#[inline(always)]
pub(crate) fn blocks<const L: usize>(
    key: &[u32; 8],
    streams: &[u64; L],
    counters: &[u64; L],
    words: &mut [[u32; L]; BLOCK_WORDS],
) {
    // Split into halves first: a loop that also holds 64-bit numbers would get half the lanes.
    let mut addresses = [[0; L]; 4];
    for lane in 0..L {
        let (stream, counter) = (streams[lane], counters[lane]);
        let halves = [low(counter), high(counter), low(stream), high(stream)];
        for (row, half) in addresses.iter_mut().zip(halves) {
            row[lane] = half;
        }
    }
    for lane in 0..L {
        let start = [
            CONSTANTS[0],
            CONSTANTS[1],
            CONSTANTS[2],
            CONSTANTS[3],
            key[0],
            key[1],
            key[2],
            key[3],
            key[4],
            key[5],
            key[6],
            key[7],
            addresses[0][lane],
            addresses[1][lane],
            addresses[2][lane],
            addresses[3][lane],
        ];
        let mut state = start;
        double_round(&mut state);
        double_round(&mut state);
        double_round(&mut state);
        double_round(&mut state);
        for word in 0..BLOCK_WORDS {
            words[word][lane] = state[word].wrapping_add(start[word]);
        }
    }
}

#[inline(always)]
fn double_round(x: &mut [u32; BLOCK_WORDS]) {
    quarter_round(x, 0, 4, 8, 12);
    quarter_round(x, 1, 5, 9, 13);
    quarter_round(x, 2, 6, 10, 14);
    quarter_round(x, 3, 7, 11, 15);
    quarter_round(x, 0, 5, 10, 15);
    quarter_round(x, 1, 6, 11, 12);
    quarter_round(x, 2, 7, 8, 13);
    quarter_round(x, 3, 4, 9, 14);
}

#[inline(always)]
fn quarter_round(x: &mut [u32; BLOCK_WORDS], a: usize, b: usize, c: usize, d: usize) {
    x[a] = x[a].wrapping_add(x[b]);
    x[d] = (x[d] ^ x[a]).rotate_left(16);
    x[c] = x[c].wrapping_add(x[d]);
    x[b] = (x[b] ^ x[c]).rotate_left(12);
    x[a] = x[a].wrapping_add(x[b]);
    x[d] = (x[d] ^ x[a]).rotate_left(8);
    x[c] = x[c].wrapping_add(x[d]);
    x[b] = (x[b] ^ x[c]).rotate_left(7);
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

    #[test]
    fn every_lane_gives_the_words_of_rand_chacha() {
        let (seed, purpose) = (0x0123_4567_89ab_cdef, 3);
        let streams = [0, 1, 1 << 40, u64::MAX, 7, 7, 7, 7];
        let counters = [0, 5, 9, 1 << 33, 0, 1, 2, 3];
        let mut words = [[0; 8]; BLOCK_WORDS];
        blocks(&key(seed, purpose), &streams, &counters, &mut words);
        let mut bytes = [0; 32];
        bytes[..8].copy_from_slice(&seed.to_le_bytes());
        bytes[8..16].copy_from_slice(&purpose.to_le_bytes());
        for lane in 0..8 {
            let mut generator = ChaCha8Rng::from_seed(bytes);
            generator.set_stream(streams[lane]);
            generator.set_word_pos(u128::from(counters[lane]) * 16);
            for row in &words {
                assert_eq!(row[lane], generator.next_u32());
            }
        }
    }
}
