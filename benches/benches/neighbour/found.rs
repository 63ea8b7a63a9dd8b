//! Results of a contender, and their comparison with those of the others.

use kiddo::PairQueryResult;
use linkcell::PairColumns;
use neighbour_search::NeighbourList;

/// Rows of a list from a rival's queries: row `i` is `indices[offsets[i]..offsets[i + 1]]`.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    offsets: Vec<usize>,
    pub(crate) indices: Vec<u32>,
}

impl Rows {
    pub(crate) fn restart(&mut self) {
        self.indices.clear();
        self.offsets.clear();
        self.offsets.push(0);
    }

    pub(crate) fn end_row(&mut self) {
        self.offsets.push(self.indices.len());
    }
}

/// Pairs in memory, in any order and format.
pub(crate) trait Pairs {
    fn for_each(&self, visit: impl FnMut(u32, u32));
}

impl Pairs for NeighbourList {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for (row, i) in self.rows().zip(0..) {
            for &j in row {
                visit(i, j);
            }
        }
    }
}

impl Pairs for Rows {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for (ends, i) in self.offsets.windows(2).zip(0..) {
            for &j in &self.indices[ends[0]..ends[1]] {
                visit(i, j);
            }
        }
    }
}

impl Pairs for Vec<[u32; 2]> {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for &[i, j] in self {
            visit(i, j);
        }
    }
}

/// kiddo's join of a cloud with itself, in which each point also finds itself.
impl Pairs for Vec<PairQueryResult<u32, u32, ()>> {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for pair in self.iter().filter(|pair| pair.left_item != pair.right_item) {
            visit(pair.left_item, pair.right_item);
        }
    }
}

impl Pairs for Vec<linkcell::Pair> {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        let id = |index: usize| u32::try_from(index).unwrap();
        for pair in self {
            visit(id(pair.i), id(pair.j));
        }
    }
}

impl Pairs for PairColumns {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for (i, j) in self.i.iter().zip(&self.j) {
            visit(i.cast_unsigned(), j.cast_unsigned());
        }
    }
}

/// Counting of pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sense {
    /// A mutual pair counts twice: (i, j) and (j, i).
    Directed,
    /// Either order is the same pair.
    Unordered,
}

/// A set of pairs: their number, and an order-independent sum of 64-bit hashes.
///
/// A set with one pair more, less, twice or different has the same sum with probability 2^-64.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fingerprint {
    sense: Sense,
    pub(crate) n_pairs: usize,
    sum: u64,
}

impl Fingerprint {
    pub(crate) fn of(pairs: &impl Pairs, sense: Sense) -> Self {
        let (mut n_pairs, mut sum) = (0, 0_u64);
        pairs.for_each(|i, j| {
            let [first, second] = match sense {
                Sense::Directed => [i, j],
                Sense::Unordered => [i.min(j), i.max(j)],
            };
            n_pairs += 1;
            sum = sum.wrapping_add(mixed(u64::from(first) << 32 | u64::from(second)));
        });
        Self { sense, n_pairs, sum }
    }
}

/// SplitMix64's output function: every bit of the input reaches every bit of the output.
fn mixed(mut bits: u64) -> u64 {
    bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ bits >> 31
}

/// Runs a search once, checks its result, and returns it ready for measurement with its buffers.
pub(crate) fn agreed<B: Pairs>(
    expected: Fingerprint,
    name: &'static str,
    mut buffer: B,
    mut search: impl FnMut(&mut B),
) -> impl FnMut() {
    search(&mut buffer);
    assert_eq!(Fingerprint::of(&buffer, expected.sense), expected, "{name}");
    move || search(&mut buffer)
}
